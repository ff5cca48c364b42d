"""Estimate the error of a solution: two rules compared, remaining shifts, and missed slip."""

from __future__ import annotations

import numpy as np

from semianalytic.cut.load import per_set
from semianalytic.cut.profile import Profile
from semianalytic.cut.totals import contact_integral
from semianalytic.cut.zones import ZoneFields
from semianalytic.halfplane.rules import rule_for
from semianalytic.scene.arrays import Array
from semianalytic.selfsimilar.zones import tuning
from semianalytic.selfsimilar.zones.coulomb import largest_excess
from semianalytic.selfsimilar.zones.edges import Edges, edge_shift, moves
from semianalytic.selfsimilar.zones.placement import Placement


def loose_tolerance(rtol: float) -> float:
    """Return the tolerance of the rule on which zones are searched for."""
    # Half, twice: work 11 % and 3 % less in 48 random scenes, of which 20 and 13 change.
    return max(rtol / tuning.RULE_SHARE, 1e-4)


def narrowness(edges: Edges, unknowns: Array) -> float:
    """Return the factor by which the remaining shift of edges must be smaller than for most zones.

    Where slip ahead of an opening is narrow, its edge must be accurate relative to that width.
    """
    ahead = _ahead(edges, unknowns)
    # The remainder then takes a fifth of rtol.
    return 1.0 if ahead is None else min(1.0, 3.0 * float(ahead[1]))


def _ahead(edges: Edges, unknowns: Array) -> tuple[int, Array] | None:
    """Return the last edge ahead of an opening, and how far from it, () or (k,); None without."""
    if edges.opening is None or edges.opening.left is None or -1 not in edges.sides:
        return None
    edge = len(edges.sides) - 1 - edges.sides[::-1].index(-1)
    return edge, np.asarray(edges.opening.left.minus(edges.points(unknowns)[edge])[..., 0])


def numerical_error(
    placement: Placement, fields: ZoneFields, tolerance: float, left: float
) -> float:
    """Return the error estimate of placed edges and their fields, without slip that is missed.

    The coarser companion has the fields of the same zones on a coarser rule, and edges moved to
    where that rule wants them.

    The fields are those of the placement on the rule of the tolerance; `left` is the shift that
    another step would cause.
    """
    rule = rule_for(tuning.COARSER_COMPANION * tolerance)
    coarse = ZoneFields(fields.factors, fields.load, fields.zones, rule)
    unknowns = moved = placement.unknowns
    if len(unknowns):
        # The edges that the coarse rule requires, to first order.
        moved = unknowns - moves(placement.inverse, placement.edges.left_by(coarse, unknowns))
    error = float(difference(placement.edges, unknowns, moved, fields, coarse))
    gain = intensity_gain(fields)
    error = max(error, gain * float(edge_shift(placement.edges, unknowns, moved)))
    # Without this part two random films were 5.9 times their estimates off, with it 0.15.
    error = max(error, 2.0 * _share_of_film(fields, coarse))
    error = max(error, _share_of_power(fields, coarse))
    return error + max(tuning.LEFT_SAFETY * tuning.SAFETY, gain) * left


def _share_of_film(fine: ZoneFields, coarse: ZoneFields) -> float:
    """Return the largest difference of traction between two rules under a film that opens.

    It is over traction plus load; strong films are resolved worse between nodes than at them.
    """
    resistance, load, layout = fine.load.resistance, fine.load, fine.layout
    if resistance is None or load.opened is None or np.ndim(resistance) != 0:
        return 0.0
    applied = max(abs(load.load_shear), abs(load.load_pressure)) / float(resistance)
    both, worst = [solution.rate_integral() for solution in (fine, coarse)], 0.0
    far = float(load.far_slip_rate)
    for panel in layout.slip:
        if layout.open[panel]:
            continue
        at = fine.panels.inside(panel, np.linspace(-7.0, 7.0, 40))
        rates = [far + rate.totals[:panel].sum() + rate(panel, at) for rate in both]
        change = np.abs(rates[0] - rates[1]) / (np.abs(rates[0]) + applied)
        worst = max(worst, float(change.max()))
    return worst


def _share_of_power(fine: ZoneFields, coarse: ZoneFields) -> float:
    """Return the relative difference of power between two rules where slip covers c."""
    if fine.layout.pole < 0 or fine.load.resists_rate or fine.load.frictionless:
        return 0.0
    profiles = [Profile(zones) for zones in (fine, coarse)]
    own, other = (contact_integral(profile, profile.strength_at_nodes) for profile in profiles)
    return abs(own - other) / own if own > 0 else 0.0


def slip_gain(profile: Profile) -> float:
    """Return the largest slip rate of each zone, over its time of slip, over the largest slip.

    An error of the slip rate, relative to its largest value in the zone, leaves at most this many
    times as much of slip, relative to the largest slip.
    """
    panels, load, layout = profile.panels, profile.fields.load, profile.panels.layout
    at, first = panels.at.v, float(panels.left[0].v[0])
    passed = panels.jacobian * panels.rule.spacing
    rate = np.abs(profile.slip_rate_at_nodes)
    # Sums over nodes are right to some per cent.
    gained = np.cumsum((profile.slip_rate_at_nodes * passed).ravel())
    slip = (float(load.far_slip_rate) * first + gained) / at.ravel()
    largest = float(np.abs(slip).max(initial=0.0))
    if not largest:
        return 0.0
    # A zone of 6e-8 c_t at the edge slips 1e-7 times as fast as the one around the shear front:
    # the largest rate of all, over its time of slip, would be 3,000 times the largest slip.
    bound = np.zeros(len(rate))
    zone = np.array(layout.zone)
    for index in set(zone[layout.slip]):
        of_zone = layout.slipping & (zone == index)
        # Rates at nodes near a film's edge are not bounded; the largest one of the profile is.
        bound[of_zone] = min(rate[of_zone].max(), float(profile.largest_rate))
    most = float((np.cumsum((bound[:, None] * passed).ravel()) / at.ravel()).max())
    return most / first / largest


def intensity_gain(fields: ZoneFields) -> float:
    """Return by how much a shift of edges changes the stress intensity at a stuck contact edge.

    The intensity is the difference of what the step brings and what friction holds there.  Both
    follow the edges, and it may be much less than either.
    """
    if fields.layout.sense[-1]:
        return 0.0
    held = abs(float(fields.held_at_edge))
    known = abs(float(fields.stick_transform_at_edge)) + tuning.LEAST_INTENSITY * held
    return held / known if known else 0.0


def missed_slip(profile: Profile) -> Array:
    """Return about how much slip is missed or has the wrong sense, over the largest slip rate.

    The result is () or (k,). Slip that is missed appears as traction that exceeds friction within
    the tolerance. The mismatch of the edges appears as traction near them too; it is counted with
    their shift.
    """
    largest = profile.largest_rate
    mismatch = np.abs(profile.fields.mismatch()).max(axis=0, initial=0.0)
    # Excess that rounding or the edges explain is not slip that is missed.
    excess = largest_excess(profile, 5e-15, mismatch)
    missed = tuning.SLIP_PER_EXCESS * excess / np.where(largest > 0, largest, np.inf)
    wrong = profile.wrong_at_nodes[profile.panels.layout.slip].max(axis=(0, -1), initial=0.0)
    # free slip may have either sense
    return np.asarray(missed + np.where(profile.fields.load.frictionless, 0.0, wrong))


def difference(
    edges: Edges, unknowns: Array, moved: Array, fine: ZoneFields, coarse: ZoneFields
) -> Array:
    """Return the error estimate from the difference of two rules, () or (k,).

    It compares edges, relative to the lesser of themselves and c_t; slip rates in the middle and at
    the end of every panel, residues, and widths of zones, relative to the largest slip rate; and
    stress intensity. Under a resistance, slip rates away from the
    contact edge are also compared with the largest of these alone.

    `unknowns` and `moved`, (e,) or (e, k), are the edges that are right on the fine and on the
    coarse rule, on which `fine` and `coarse` are fields of the same zones.
    """
    compared, scale, peaks, inner = [], np.ones(()), np.zeros(()), np.ones(())
    for fields in (coarse, fine):
        rate = fields.rate_integral()
        halves = rate.halves
        # V at the right end of each panel, and below in its middle.
        ends = np.cumsum(rate.totals, axis=0) + per_set(fields.load.far_slip_rate)
        middles = np.abs(ends - rate.totals + halves)
        peaks = np.maximum(np.abs(ends), middles)
        scale = peaks.max(axis=0)
        inner = np.maximum(peaks[:-1].max(axis=0, initial=0.0), middles[-1])
        halves[rate.residues != 0] = 0.0  # the middle of such a panel depends on the rule
        compared.append(np.concatenate([halves, rate.residues, rate.totals]))
    scale = np.where(scale > 0, scale, 1.0)
    change = np.abs(compared[0] - compared[1])
    rates = change.max(axis=0) / scale
    if fine.load.resistance is not None:  # under strong films V towers at the contact edge alone
        rates = np.maximum(rates, change[:-1].max(axis=0) / np.where(inner > 0, inner, scale))
    covers_c = fine.layout.pole >= 0
    # At most 0.1 was measured elsewhere, and 5.7 where slip covers c in 300 scenes that open.
    share = 7.0 if covers_c else 0.3
    # The third part of the estimate: points between nodes.
    least = share * fine.rule.tolerance
    if len(unknowns):
        by_width = _share_of_width(edges, unknowns, moved, fine, peaks) / scale
        rates = np.maximum(np.maximum(rates, by_width), edge_shift(edges, unknowns, moved))
        rates = np.maximum(rates, _share_beside_opening(edges, unknowns, moved))
    of_edge = _share_of_intensity(fine, coarse)
    return 1e-14 + least + np.maximum(tuning.SAFETY * rates, of_edge)  # 1e-14 is rounding


def _share_of_intensity(fine: ZoneFields, coarse: ZoneFields) -> Array:
    """Return the difference of intensity at a stuck edge over it plus some friction, () or (k,)."""
    if fine.layout.sense[-1]:
        return np.zeros(())
    known, other = fine.stick_transform_at_edge, coarse.stick_transform_at_edge
    scale = np.abs(known) + tuning.LEAST_INTENSITY * np.abs(fine.held_at_edge)
    return np.abs(known - other) / np.where(scale > 0, scale, np.inf)


def _share_beside_opening(edges: Edges, unknowns: Array, moved: Array) -> Array:
    """Return the relative change of work ahead of an opening with the edge there, () or (k,)."""
    ahead = _ahead(edges, unknowns)
    if ahead is None:
        return np.zeros(unknowns.shape[1:])
    edge, width = ahead
    change = np.abs(edges.parts(moved)[0, edge] - edges.parts(unknowns)[0, edge])
    # Friction takes about the third power of the width ahead of an opening.
    return np.asarray(3.0 * change / width)


def shift_error(edges: Edges, unknowns: Array, moved: Array, fields: ZoneFields) -> Array:
    """Return the change of edges and slip rates by a shift of edges alone, () or (k,).

    Edges count relative to the lesser of themselves and c_t, slip rates relative to the largest;
    `fields` are those before or after the shift.
    """
    rate = fields.rate_integral()
    ends = np.cumsum(rate.totals, axis=0) + per_set(fields.load.far_slip_rate)
    peaks = np.maximum(np.abs(ends), np.abs(ends - rate.totals + rate.halves))
    scale = peaks.max(axis=0)
    by_width = _share_of_width(edges, unknowns, moved, fields, peaks)
    return np.maximum(
        by_width / np.where(scale > 0, scale, 1.0), edge_shift(edges, unknowns, moved)
    )


def _share_of_width(
    edges: Edges, unknowns: Array, moved: Array, fields: ZoneFields, peaks: Array
) -> Array:
    """Return changes of slip rates, at most `peaks` (p, ...), with widths of zones, () or (k,)."""
    v = edges.parts(unknowns)[0]
    change, slipping = np.abs(edges.parts(moved)[0] - v), fields.layout.slipping
    worst, edge = np.zeros(unknowns.shape[1:]), 0
    for index, zone in enumerate(fields.zones):
        ends = (zone.left is not None) + (zone.right is not None)
        if ends == 2:
            here = slipping & (np.array(fields.layout.zone) == index)
            # Twice the relative change of the width.
            share = 2 * (change[edge] + change[edge + 1]) / (v[edge + 1] - v[edge])
            worst = np.maximum(worst, peaks[here].max(axis=0) * share)
        edge += ends
    return worst
