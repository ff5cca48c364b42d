"""First guesses of the slip zones: those of weak friction, and those seen on a grid.

If friction is small compared with the load, the interface slips behind the longitudinal front at
nearly the rate V of a frictionless interface, and a stick gap opens where V changes sense. Across
the gap the traction goes from one bound of friction to the other. Behind the shear front the
impedance is i m, and around a gap between slownesses l and r

    T = pi v m V' ((v - l) / (v - r))^(1/2),    r - l = 4 f p / (pi m |V'|),

because the integral of Im T / (pi v) over the gap is 2 f p.  No grid resolves gaps of the order of
friction; as a start for Newton's method this is accurate to the order of their width
(docs/solver.md, "Weak friction and thresholds").

Just behind the longitudinal front zones may be narrower than any grid resolves. Behind c_l the
pressure falls like (v - a)^(1/2), and the shear traction rises like (v - a)^(3/2). If the base is
at friction and the step of shear opposes it, the interface therefore slips from the front itself as
soon as the pressure falls at all, until the step of shear prevails.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from semianalytic.cut.load import Load, Opened
from semianalytic.cut.profile import Profile
from semianalytic.cut.quadrature.layout import Zone
from semianalytic.cut.zones import ZoneFields
from semianalytic.halfplane.rayleigh import Array, CutPoints, RayleighFactors
from semianalytic.halfplane.rules import Rule, rule_for
from semianalytic.scene.errors import ComputationError
from semianalytic.selfsimilar.zones import tuning
from semianalytic.selfsimilar.zones.collocation import GridSlip, is_open, slip_on_grid


@dataclass(frozen=True)
class Guess:
    """Zones to begin with, from the longitudinal front inward.

    Attributes
    ----------
    zones : sequence of Zone
    pivots : int
        Pivots of the complementarity problem that were needed.
    doubtful : bool
        Whether guesses on a coarser grid have failed before.
    """

    zones: Sequence[Zone]
    pivots: int = 0
    doubtful: bool = False


def guesses(factors: RayleighFactors, load: Load) -> Iterator[Guess]:
    """Yield the zones of weak friction where it is weak, then those seen on finer and finer
    grids."""
    if load.frictionless:
        # Without friction the whole interface slips; its sense is free, +1 by convention.
        yield Guess((Zone(None, None, 1),))
    elif load.rests:
        yield Guess(())
    else:
        for guess in _behind_all_fronts(factors, load):
            yield replace(guess, zones=with_slip_at_front(factors, guess.zones, load))


def _behind_all_fronts(factors: RayleighFactors, load: Load) -> Iterator[Guess]:
    """Yield guesses that do not include narrow zones at the longitudinal front."""
    if factors.mode == "III" and load.opened is None:
        zones = antiplane_zones(factors, load)
        if zones is not None:
            yield Guess(zones)
    with_wave = factors.has_rayleigh_wave and load.opened is None
    weak = weak_friction_zones(factors, load) if with_wave else None
    if weak is not None:
        yield Guess(weak)
    if load.opened is not None:
        narrow = _zone_around_narrow_opening(factors, load, load.opened)
        if narrow is not None:
            yield Guess([narrow])
            # Where base and step nearly balance at the opening, the stuck traction does not tell.
            yield Guess([replace(narrow, sense=-narrow.sense)])
    for size in tuning.GRIDS:
        try:
            grid = slip_on_grid(factors.poisson_ratio, load, size, factors.mode)
        except ComputationError:
            # By rounding, pivoting may end on a ray; the next grid has other pivots.
            continue
        zones = zones_on_grid(factors, grid, load)
        if load.opened is not None:
            zones = zones_beside_opening(factors, grid, load)
        yield Guess(zones, grid.pivots, size > tuning.GRIDS[0])


def antiplane_zones(factors: RayleighFactors, load: Load) -> list[Zone] | None:
    """Return the zone of antiplane shear under constant strength, u_s = b (1 + chi_b)^2, or None.

    For a load whose front has the slowness p it is u_s = p + (b - p) (1 + chi_b)^2.

    If the base is at friction, the zone begins at the shear front, or everywhere. If the pressure
    changes, the strength at the shear front is used, provided that friction is weak; otherwise the
    result is None.
    """
    sense, pressure = int(np.sign(load.far_slip_rate or load.load_shear)), load.base_pressure
    if load.load_pressure:
        pressure += load.load_pressure * float(load.stuck(factors, "I")(1.0))
    strength = float(load.friction) * pressure - sense * load.base_shear
    if load.load_pressure:
        if load.far_slip_rate or not 0 < strength < tuning.WEAK_FRICTION * abs(load.load_shear):
            return None
    elif load.far_slip_rate or strength <= 0:
        return [Zone(None, None, sense)]
    # u_s - b = (b - p) ((1 + chi)^2 - 1) = (b - p) chi (2 + chi), exact also for tiny chi.
    ratio = strength / abs(load.load_shear)
    behind = (1 - load.slowness) * ratio * (2 + ratio)
    return [Zone(factors.beside("b", [behind]), None, sense)]


def zones_on_grid(factors: RayleighFactors, grid: GridSlip, load: Load) -> list[Zone]:
    """Return the zones of the first stage, with edges from the two outermost values of V in each.

    If the base is critical, that is, its shear traction equals friction ahead of all waves, slip
    in its sense that starts at the first node starts at the longitudinal front itself.
    """
    # Zones are listed from the longitudinal front inward, and xi increases outward.
    xi, rate = grid.xi[::-1], grid.slip_rate[::-1]
    sense = np.sign(rate).astype(int)
    if load.critical and sense[0] == 0 and sense[1] * load.base_shear >= 0:
        sense[0] = sense[1]
    bounds = [0, *(np.flatnonzero(sense[1:] != sense[:-1]) + 1).tolist(), len(sense)]
    fronts = (xi == 0) | (xi == 1 / factors.c) | (xi == 1) | (xi == xi[0])
    zones = []
    for start, stop in pairwise(bounds):
        if sense[start] == 0:
            continue
        edges: list[CutPoints | None] = []
        for node, outside, inward in ((start, start - 1, 1), (stop - 1, stop, -1)):
            if not 0 <= outside < len(xi):
                edges.append(None)
                continue
            inner, most = node + inward, tuning.FARTHEST_SHARE
            if sense[outside]:
                most = tuning.SHARE_TO_OTHER_SENSE
            elif fronts[outside] or sense[outside - inward]:
                most = tuning.SHARE_BEFORE_NODE
            seen = start <= inner < stop and rate[inner]
            ratio = abs(rate[node] / rate[inner]) if seen else tuning.EDGE_SHARE_UNKNOWN
            # An edge between two nodes leaves the same pattern wherever it lies: from the ratio of
            # the outermost slip rate to the next one follows its place (docs/solver.md, "Which
            # zones").
            share = float(min(tuning.EDGE_SHARE + tuning.EDGE_SHARE_SLOPE * ratio, most))
            place = xi[node] + share * (xi[outside] - xi[node])
            if xi[outside] == 1:  # a zone that comes this near to the shear front crosses it
                place = 1 + share * (1 - xi[node])
            edges.append(factors.cut([1 / place]))
        zones.append(Zone(edges[0], edges[1], int(sense[start])))
    return zones


def zones_beside_opening(factors: RayleighFactors, grid: GridSlip, load: Load) -> list[Zone]:
    """Return the zones of the first stage where the contact is open; one of them holds the opening.

    This zone begins ahead of the opening, where the strength falls to zero and the traction does
    not. It ends behind the opening where slip is seen, or else where the opening closes, or at the
    contact edge (docs/separation.md, "Shear beside an opening").
    """
    assert load.opened is not None
    opening = load.opened.zone
    free = is_open(opening, grid.xi)
    # xi increases outward and zones are listed inward: the opening ends at the first free node.
    last, first = np.flatnonzero(free)[[0, -1]]
    ahead, beside = float(np.sign(grid.slip_rate[first + 1])), float(np.sign(grid.slip_rate[first]))
    inward = int(np.sign(grid.slip_rate[last - 1])) if last else 0
    rate = grid.slip_rate.copy()
    rate[free] = np.abs(rate[free]) * (ahead or beside or 1.0)
    zones = zones_on_grid(factors, replace(grid, slip_rate=rate), load)
    index = next(
        i
        for i, zone in enumerate(zones)
        if zone.right is None or zone.right.v[0] * grid.xi[first] > 1
    )
    held = zones[index]
    if opening.right is None:
        held = replace(held, right=None)
    elif not inward:
        held = replace(held, right=opening.right, held=True)
    # Behind the opening the step acts, ahead of it the base is released: the closed parts may slip
    # in opposite senses.
    elif inward == -held.sense:
        behind = zones.pop(index + 1)
        held = replace(held, right=behind.right, inward=inward)
    # In antiplane shear without base shear, no traction arrives ahead of the shear front.
    undriven = not factors.has_rayleigh_wave and not (load.base_shear or load.far_slip_rate)
    if undriven and opening.left is not None and opening.left.from_b[0] < 0:
        zones[index] = replace(held, left=opening.left)
    else:
        zones[index] = _around(factors, held, opening, grid.xi, (int(last), int(first)))
    return zones


def _zone_around_narrow_opening(
    factors: RayleighFactors, load: Load, opened: Opened
) -> Zone | None:
    """Return the zone of slip around an opening at the contact edge that no grid resolves, or None.

    Under a base much larger than the step, the opening and the slip around it end close to the
    edge, where traction rises like the inverse root of the distance.  Slip begins about where the
    traction of a stuck interface exceeds the strength that the opening leaves.  Its sense is that
    of the traction at the opening, which may be opposite to that of the base.  A grid shows only
    the sense of the base, which is released in the opening.
    """
    opening, widest = opened.zone, 1 / tuning.NARROW_AT_EDGE
    if opening.right is not None or opening.left is None or not opening.left.v[0] > 2 * widest:
        return None
    # Rounding would let the last point pass the opening.
    at = factors.cut(np.geomspace(widest, opening.left.v[0] * (1 - tuning.OFF_ENDS), 400))
    traction = load.base_shear + load.load_shear * load.stuck(factors, factors.mode).at(at)
    sense = int(np.sign(traction[-1]))
    stuck = np.flatnonzero(sense * traction <= load.friction * opened.near_pressure(at.v))
    # Where all of it slips, the zone is wide enough for a grid.
    if not sense or not len(stuck) or stuck[-1] + 1 == len(at.v):
        return None
    return Zone(at[[stuck[-1] + 1]], None, sense)


def _around(
    factors: RayleighFactors, zone: Zone, opening: Zone, xi: Array, nodes: tuple[int, int]
) -> Zone:
    """Return a zone whose edges stay on their sides of the opening that it holds.

    `nodes` are the last and the first node of the grid that are open.
    """
    share, (last, first) = tuning.BESIDE_OPENING, nodes
    assert opening.left is not None
    if zone.left is not None and not zone.left.first_below(opening.left):
        start = 1 / opening.left.v[0]
        zone = replace(zone, left=factors.cut([1 / (start + share * (xi[first + 1] - start))]))
    closing = opening.right
    if closing is None or zone.right is None or zone.held or closing.first_below(zone.right):
        return zone
    end = 1 / closing.v[0]
    return replace(zone, right=factors.cut([1 / (end + share * (xi[last - 1] - end))]))


def frictionless_profile(factors: RayleighFactors, load: Load, rule: Rule) -> Profile:
    """Return the profile of slip everywhere without friction."""
    return Profile(ZoneFields(factors, load, (Zone(None, None, 1),), rule))


def slip_senses(profile: Profile) -> tuple[list[int], list[CutPoints]]:
    """Return the senses of slip without friction, from the longitudinal front inward.

    The second list holds the points at which they change; both are empty if nothing slips.
    """
    from scipy.optimize import brentq  # here, for `import semianalytic` is to be quick

    factors = profile.fields.factors
    least = tuning.FRICTIONLESS_NOISE * profile.fields.rule.tolerance * float(profile.largest_rate)
    low, ahead = np.log(tuning.NEAREST_TO_C), factors.c - factors.a * (1 + 1e-6)
    senses: list[int] = []
    changes: list[CutPoints] = []
    for side, high in ((-1, np.log(ahead)), (1, np.log(tuning.FARTHEST_FROM_C))):

        def rate(log: float, side: int = side) -> float:
            at = factors.beside("c", [side * np.exp(log)])
            return float(profile.slip_rate_at(at)[0])

        # Points even in the logarithm of the distance from c resolve the strip of reverse slip,
        # however narrow it is.
        logs = np.linspace(high, low, int(tuning.POINTS_PER_E * (high - low)))[::-side]
        rates = profile.slip_rate_at(factors.beside("c", side * np.exp(logs)))
        before = None
        for log, sense in zip(logs, np.sign(rates) * (np.abs(rates) > least), strict=True):
            if not sense:
                continue
            if not senses or sense != senses[-1]:
                if senses and before is not None:
                    root = brentq(rate, before, log, xtol=1e-14)
                    changes.append(factors.beside("c", [side * np.exp(root)]))
                # The sense changes between the last point ahead of c and the first one behind it.
                elif senses:
                    changes.append(factors.front_c)
                senses.append(int(sense))
            before = log
    return senses, changes


def weak_friction_zones(factors: RayleighFactors, load: Load) -> list[Zone] | None:
    """Return the zones for friction that is weak compared with the step of shear traction.

    The result is None if friction is not weak, or if gaps would be wide or ahead of the shear
    front.
    """
    friction, far = float(load.friction), float(load.far_slip_rate)
    strongest = friction * max(load.base_pressure, load.load_pressure)
    if not strongest < tuning.WEAK_FRICTION * abs(load.load_shear):
        return None
    without = replace(load, friction=0.0)
    profile = frictionless_profile(factors, without, rule_for(tuning.FRICTIONLESS_RULE))
    senses, changes = slip_senses(profile)
    first = int(np.sign(far or load.load_shear))
    # Ahead of the shear front M is complex and the formula for the gaps does not hold.
    if senses[:1] != [first] or any(change.from_b[0] <= 0 for change in changes):
        return None
    left = None
    if not far and not (load.critical and first * load.base_shear > 0):
        left = _opening_behind_front(factors, load, first)
        if left is None:
            return None
    zones = []
    for start, end, sense in _gaps(profile, load, senses, changes):
        zones.append(Zone(left, start, sense))
        left = end
    return [*zones, Zone(left, None, senses[-1])]


def _gaps(
    profile: Profile, load: Load, senses: list[int], changes: list[CutPoints]
) -> list[tuple[CutPoints, CutPoints, int]]:
    """Return stick gaps where V changes sense, each with the sense of the zone ahead of it.

    If they are too wide for the strip around c that slips backward, they join to a single gap,
    which is twice as wide as the strip would be (docs/solver.md, "Weak friction and thresholds").
    """
    widths = [_gap_width(profile, load, change) for change in changes]
    if len(changes) == 2 and widths[0] > tuning.WIDEST_GAP * abs(changes[0].from_c[0]):
        strip = [2 * change.from_c[0] for change in changes]
        if -strip[0] < 2 * tuning.NARROWEST_GAP:
            return []
        around = profile.fields.factors.beside("c", strip)
        return [(around[[0]], around[[1]], senses[0])]
    return [
        (CutPoints(change.parts - width / 2), CutPoints(change.parts + width / 2), sense)
        for sense, change, width in zip(senses, changes, widths, strict=False)
        if abs(change.from_c[0]) > tuning.NARROWEST_GAP
    ]


def _gap_width(profile: Profile, load: Load, change: CutPoints) -> float:
    """Return the width in slowness of the stick gap that friction opens where V changes sense."""
    fields, from_c = profile.fields, change.from_c
    step = tuning.GAP_SLOPE_STEP * from_c
    beside = fields.factors.beside("c", np.concatenate([from_c - step, from_c + step]))
    before, after = profile.slip_rate_at(beside)
    slope = abs((after - before) / (2 * step[0]))
    strength = replace(fields, load=load).strength(change)[0]
    impedance = abs(fields.factors.impedance_behind(change)[0])
    # r - l = 4 f p / (pi m |V'|), with M = i m behind the shear front.
    return float(4 * strength / (np.pi * impedance * slope))


def _behind_front(factors: RayleighFactors) -> CutPoints:
    """Return points from the longitudinal to the shear front, even in the logarithm of their
    distance."""
    nearest, farthest = np.log(tuning.NEAREST_TO_FRONT), np.log(1 - factors.a)
    return factors.beside("a", np.exp(np.arange(nearest, farthest, tuning.FRONT_STEP)))


def _opening_behind_front(factors: RayleighFactors, load: Load, sense: int) -> CutPoints | None:
    """Return where a zone opens that slips behind the longitudinal front nearly without friction.

    There T = Q_0, turned by the phase of the impedance, has raised the traction to friction. The
    result is None if that happens nowhere ahead of the shear front.
    """
    at = _behind_front(factors)
    # A front of slowness p makes T = Q_0 k / (k + p) of the load: v - p takes the place of v.
    over = np.pi * (at.v - load.slowness)
    slope = load.load_shear * np.sin(factors.phase(at)) / over * at.from_a
    # Trapezoidal sum of dtau/dv = Im T / (pi v) in the logarithm of v - a.
    gained = np.cumsum((slope[1:] + slope[:-1]) / 2 * tuning.FRONT_STEP)
    mode_one = load.stuck(factors, "I")
    strength = load.friction * (load.base_pressure + load.load_pressure * mode_one.at(at[1:]))
    above = np.flatnonzero(sense * (load.base_shear + gained) >= strength)
    return at[[above[0] + 1]] if len(above) else None


def with_slip_at_front(
    factors: RayleighFactors, zones: Sequence[Zone], load: Load
) -> Sequence[Zone]:
    """Return the zones with one ahead of them if a base at friction is released at the first front.

    This zone ends approximately where the stuck interface would satisfy Coulomb's law again.
    """
    sense = int(np.sign(load.base_shear))
    held = not (load.critical and sense and load.load_pressure) or bool(load.far_slip_rate)
    if held or (zones and zones[0].left is None):
        return zones
    first = zones[0] if zones else None
    if factors.mode == "III" and first and first.left is not None and first.left.from_b[0] < 0:
        # In antiplane shear no shear arrives ahead of the shear front, which would hold the strip.
        return [replace(first, left=None), *zones[1:]]
    at = _behind_front(factors)
    at = at[at.from_a > tuning.NARROWEST_FRONT_ZONE]
    if load.opened is None:
        pressure = load.friction * load.load_pressure * load.stuck(factors, "I").at(at)
    else:
        pressure = load.friction * (load.pressure(factors, at) - load.base_pressure)
    # Stuck traction less strength, both less their value ahead, where the base is exactly at
    # friction.
    excess = sense * load.load_shear * load.stuck(factors, factors.mode).at(at) - pressure
    kept = np.flatnonzero(excess <= 0)
    # At nu = 0 the pressure falls too late behind the front, and no strip is found.
    if not len(kept) or not kept[0]:
        return zones
    right = at[[kept[0]]]
    if zones and zones[0].left is not None and not right.first_below(zones[0].left):
        return zones
    return [Zone(None, right, sense), *zones]
