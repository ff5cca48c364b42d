"""Find where solved zones violate Coulomb's inequalities, at the nodes of a rule and between them.

A narrow violation may lie between nodes. One number measures it there: traction over friction where
the interface sticks, slip rate against the sense of its zone where it slips. If a parabola through
three nodes comes close to the limit, the number is evaluated at ever closer points around its peak.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from semianalytic.cut.load import per_set
from semianalytic.cut.profile import Profile
from semianalytic.cut.zones import ZoneFields
from semianalytic.halfplane.rayleigh import CutPoints
from semianalytic.scene.arrays import Array
from semianalytic.selfsimilar.zones import tuning

_APART = (False, False)
_OF_NODES = ("widths", "from_left", "from_right", "jacobian", "skew")
_OF_FIELDS = (
    "slip_rate_slope",
    "traction_slope",
    "residue",
    "transform_at_edge",
    "stick_transform_at_edge",
    "stick_transform_excess",
)
"""Arrays of panels and fields that `wrong` needs, each with an axis of sets."""


@dataclass(frozen=True)
class Violation:
    """Interval of slowness in which Coulomb's law fails, in a slip zone or, with zone -1, in stick.

    `right` is None if the interval extends to the contact edge. The last two attributes say whether
    it touches the ends of its zone or stretch of stick.
    """

    zone: int
    sense: int
    left: CutPoints
    right: CutPoints | None
    touches_left: bool
    touches_right: bool


def largest_excess(profile: Profile, rounding: float, mismatch: Array) -> Array:
    """Return the largest traction over friction on stick that nothing explains; () or (k,).

    It is measured as in `violations`; ahead of the shear front it is divided by the impedance,
    because slip responds more strongly there than elsewhere.

    `rounding` is the excess that rounding explains, on all panels; `mismatch`, () or (k,), the
    excess that the mismatch of the edges explains, on panels near a zone.  Farther from them it
    explains none: where the base is just below friction and the step a millionth of it, what is
    left at an edge is more than all the traction by which another zone slips.
    """
    panels, layout = profile.panels, profile.panels.layout
    excess = profile.wrong_at_nodes[layout.stick]
    ahead = layout.stick_ahead
    real, imag = profile.fields.factors.impedance_ahead(panels.at[ahead])
    # The bound from below keeps an impedance near zero from making any rounding count.
    impedance = tuning.SLIP_PER_EXCESS * np.hypot(real, imag)
    # The impedance falls to 0 at the longitudinal front for nu near 0.
    excess[: len(ahead)] /= np.clip(impedance, 1e-3, 1.0)
    slipping = np.pad(layout.slipping, 1)
    beside = (slipping[:-2] | slipping[2:])[layout.stick]
    # without unknowns the mismatch is one number for all scenes of a batch
    known = rounding + np.multiply.outer(beside, np.broadcast_to(mismatch, excess.shape[1:-1]))
    return np.asarray((excess - known[..., None]).max(axis=(0, -1), initial=0.0))


def _misses(profile: Profile, tolerance: float) -> Array:
    """Return the sense of V or traction where the law fails at nodes, (p, ..., n), else 0."""
    stick, wrong = profile.panels.layout.stick, profile.wrong_at_nodes
    misses = np.sign(profile.slip_rate_at_nodes) * (wrong > tolerance)
    misses[stick] = np.sign(profile.traction_at_nodes[stick]) * (wrong[stick] > tolerance)
    return misses


def admissible(profile: Profile, tolerance: float) -> np.ndarray:
    """Return whether Coulomb's law holds for each of k sets of zones, (k,), without `violations`.

    A stick gap around c_R must also be wider than the gaps that are left out.
    """
    panels = profile.panels
    sound = np.asarray(~_misses(profile, tolerance).any(axis=(0, -1)))
    for inward, outward in zip(profile.fields.zones[1:], profile.fields.zones[:-1], strict=True):
        if inward.left is not None and outward.right is not None:
            width = inward.left.minus(outward.right)[..., 0]
            # The minimum width does not apply to gaps that end ahead of c_R.
            sound &= (width > 4 * tuning.NARROWEST_GAP) | (inward.left.from_c.flat[0] < 0)
    if not profile.edge_slips:
        sound &= excess_intensity(profile) <= _intensity_tolerance(profile, tolerance)
    if (pole := panels.layout.pole) >= 0:
        # V = A + r ln|v - c| reverses next to c if r has the sign of the zone.
        reverses = panels.sense[pole] * profile.residues(pole) > 0
        if reverses.any() and not panels.layout.open[pole]:
            sound &= ~reverses | (reversal_at_rayleigh_front(profile, pole) <= tuning.NARROWEST_GAP)
    # Only doubtful sets need the closer look between nodes, which works on one set at a time.
    for j in np.flatnonzero(sound & doubtful(profile).any(axis=(0, -1))):
        sound[j] = not _hidden(_one_of(profile, int(j)), tolerance)
    return sound


def _one_of(profile: Profile, j: int) -> Profile:
    """Return the profile of one of k sets of zones, with what is known of all of them."""
    fields, load, panels = profile.fields, profile.fields.load, profile.panels

    def see(points: CutPoints) -> CutPoints:
        return CutPoints(points.parts[..., j, :]) if points.v.ndim > 1 else points

    friction, far = (float(np.ravel(x)[j]) for x in (load.friction, load.far_slip_rate))
    load = replace(load, friction=friction, far_slip_rate=far)
    zones = tuple(zone.seen_by(see) for zone in fields.zones)
    one = ZoneFields(fields.factors.single(j), load, zones, fields.rule)
    nodes = {name: getattr(panels, name)[:, j] for name in _OF_NODES}
    known = {name: vars(fields)[name] for name in _OF_FIELDS if name in vars(fields)}
    own = {name: part[:, j] if part.ndim == 3 else part[j] for name, part in known.items()}
    # In place of what the cached properties would compute.
    vars(one).update(own, panels=replace(panels.seen_by(see), **nodes))
    return Profile(one)


# Overflow leaves nan in the misses, which is answered by None.
@np.errstate(over="ignore", invalid="ignore", divide="ignore")
def violations(profile: Profile, tolerance: float) -> list[Violation] | None:
    """Return where Coulomb's law fails for one set of zones; None if the fields are not numbers.

    Either the slip rate has the wrong sign or the traction exceeds friction. Fields are not numbers
    in zones that have shrunk to nothing.

    The tolerance is relative to the largest slip rate; for tractions, to strength plus load, and in
    a narrow stick gap to strength plus its share of the load.  The list is empty where the law
    holds.
    """
    if profile.fields.load.frictionless:
        # Without friction slip may have either sense, and no traction is bounded.
        return []
    misses = _misses(profile, tolerance)
    if np.isnan(misses).any():
        return None
    broken: list[Violation] = []
    for region in profile.panels.layout.closed_regions:
        broken += _at_nodes(profile, region, misses[region].ravel(), tolerance)
        broken += _at_contact_edge(profile, region, misses, tolerance)
        broken += _at_rayleigh_front(profile, region, misses)
    # Between nodes only where the nodes show nothing: corrected zones are checked again anyway.
    return broken or _hidden(profile, tolerance)


def _at_nodes(
    profile: Profile, region: list[int], misses: Array, tolerance: float
) -> list[Violation]:
    """Return the violations at the nodes of a zone or a stretch of stick, from senses (m,).

    Two that are two nodes apart are one; slip that hardly is any before one belongs to it.
    """
    wrong = misses != 0
    if not wrong.any():
        return []
    panels, result, last = profile.panels, [], len(wrong) - 1
    sense, unbounded = panels.sense[region[0]], panels.right[region[-1]] is None
    if sense:
        first = int(np.argmax(wrong))
        wrong[:first] = np.all(profile.wrong_at_nodes[region].ravel()[:first] > -tolerance)
    zone = panels.layout.zone[region[0]] if sense else -1
    at = CutPoints(panels.at.parts[:, region].reshape(4, -1))
    # Close a single sound node between two wrong ones.
    wrong[1:-1] |= wrong[:-2] & wrong[2:]
    # Differences of 0 and 1 are nonzero where a run starts and just behind where it stops.
    bounds = np.flatnonzero(np.diff(wrong.astype(int), prepend=0, append=0))
    for start, stop in zip(bounds[::2], bounds[1::2], strict=True):
        to_edge = bool(stop > last) and unbounded
        # The interval extends to the neighbouring nodes, which are sound.
        left = at[[max(start - 1, 0)]]
        right = None if to_edge else at[[min(stop, last)]]
        touches = (bool(start == 0), bool(stop > last) and not unbounded)
        result.append(Violation(zone, sense or int(misses[start]), left, right, *touches))
    return result


def _at_contact_edge(
    profile: Profile, region: list[int], misses: Array, tolerance: float
) -> list[Violation]:
    """Return a stuck contact edge that must slip, though no node shows excess traction yet."""
    if profile.panels.sense[region[0]] or profile.panels.right[region[-1]] is not None:
        return []
    # K_II > f K_I: sufficiently close to the edge the traction exceeds friction.
    excess = float(excess_intensity(profile))
    if misses[region[-1], ..., -1] or not excess > _intensity_tolerance(profile, tolerance):
        return []
    begin = _first_edge_zone(profile, excess)
    if begin is None:
        return []
    return [Violation(-1, int(np.sign(profile.edge_intensity)), begin, None, *_APART)]


def _first_edge_zone(profile: Profile, excess: float) -> CutPoints | None:
    """Return where slip at a stuck edge may begin, beyond all nodes; None if out of reach."""
    factors, start = profile.fields.factors, float(profile.panels.left[-1].v[0])
    widest = 4 * min(excess, 0.02)  # under a base 1e6 times the step such a zone ends at 1e12 / c_t
    at = factors.cut(np.geomspace(max(2 * start, 1 / widest), 1e60, 400))
    slips = np.abs(profile.traction_at(at)) > profile.strength(at.v)
    return at[[int(np.argmax(slips))]] if slips.any() else None


def _at_rayleigh_front(profile: Profile, region: list[int], misses: Array) -> list[Violation]:
    """Return the strip around c in which the logarithm in V reverses slip, if no node shows it."""
    panels, pole = profile.panels, profile.panels.layout.pole
    sense = panels.sense[region[0]]
    if pole not in region or misses[region].any() or not sense * profile.residue(pole) > 0:
        return []
    width = float(reversal_at_rayleigh_front(profile, pole))
    # A strip narrower than the narrowest gap is left out.
    if not width > tuning.NARROWEST_GAP:
        return []
    ends = profile.fields.factors.beside("c", [-width, width])
    return [Violation(panels.layout.zone[pole], sense, ends[[0]], ends[[1]], *_APART)]


def _intensity_tolerance(profile: Profile, tolerance: float) -> float:
    # Without any zone the traction is exact, so that the tolerance may be that of rounding.
    return tolerance if profile.fields.zones else tuning.UNDRIVEN_EXCESS


def excess_intensity(profile: Profile) -> Array:
    """Return K_II / (f K_I) - 1 (or with K_III) at a stuck contact edge, () or (k,).

    The edge must slip where this is positive.
    """
    load, factors = profile.fields.load, profile.fields.factors
    # Stress intensities of unit steps are proportional to 1 / M_+(0), (3.13) and (3.16).
    at_zero = factors.m_plus_at_zero
    strength = np.asarray(per_set(load.friction) * load.load_pressure)
    if load.slowness and load.load_pressure:
        strength = strength * (at_zero["I"] / factors.m_plus_at_load(load.slowness, "I"))
    if profile.normal is not None:
        strength = -per_set(load.friction) * profile.normal.edge_intensity
    units = per_set(at_zero["I"]) / per_set(at_zero[factors.mode])
    traction = np.abs(profile.edge_intensity) * units
    driven = traction > tuning.UNDRIVEN_EXCESS * abs(load.load_shear)
    # Where f K_I is 0, no strength bounds the traction.
    unbounded = np.where(driven, np.inf, 0.0)
    return np.where(strength > 0, traction / np.where(strength > 0, strength, 1.0) - 1, unbounded)


def reversal_at_rayleigh_front(profile: Profile, panel: int) -> Array:
    """Return the half-width in slowness, () or (k,), where the log at c reverses V."""
    residue = profile.residues(panel)
    level = profile.rate_starts[panel] + profile.rate_integral.level_at_c(panel)
    # V = level + residue ln|v - c| vanishes there; the bounds keep the exponential within double
    # precision.
    return np.exp(np.clip(-level / residue, -690.0, 690.0))


def doubtful(profile: Profile) -> np.ndarray:
    """Return inner nodes (p, ..., n - 2) near which the law may fail though it holds at nodes."""
    value, y = profile.wrong_at_nodes, profile.panels.rule.y
    before, middle, after = value[..., :-2], value[..., 1:-1], value[..., 2:]
    # The parabola through three nodes has its maximum at `top`.
    bend = 2 * middle - before - after
    top = middle + np.square(after - before) / (8 * np.where(bend > 0, bend, np.inf))
    # A parabola through three nodes is off by less.
    result = (middle >= before) & (middle > after) & (top > -3e-3)
    # Farther out nodes are closer together than what could hide between them.
    result &= np.abs(y[1:-1]) < 8.0
    if profile.panels.layout.pole >= 0:
        # V is unbounded at c, where a parabola says nothing.
        result[profile.panels.layout.pole] = False
    return np.asarray(result)


def _hidden(profile: Profile, tolerance: float) -> list[Violation]:
    """Return where the law of one set of zones fails between nodes by more than a tolerance."""
    panels, result = profile.panels, []
    steps = np.linspace(-1, 1, 17)
    for panel, node in np.argwhere(doubtful(profile)):
        centre, step = panels.rule.y[node + 1], panels.rule.spacing
        # Two rounds of closer points, each around the highest point of the one before.
        for _ in range(2):
            y = centre + step * steps
            value = profile.wrong(panel, panels.inside(panel, y))
            best = int(np.clip(np.argmax(value), 1, len(y) - 2))
            centre, step = y[best], step / 8
        before, top, after = value[best - 1 : best + 2]
        bend = 2 * top - before - after
        if bend > 0 and (top := top + (after - before) ** 2 / (8 * bend)) > tolerance:
            # The parabola falls to zero this far on either side of its peak.
            half = step * np.sqrt(2 * top / bend)
            ends = panels.inside(panel, centre + np.array([-half, half]))
            sense, zone = panels.sense[panel], panels.layout.zone[panel]
            if not sense:
                nearest = np.argmin(np.abs(panels.at.v[panel] - ends.v[0]))
                sense, zone = int(np.sign(profile.traction_at_nodes[panel, nearest])), -1
            result.append(Violation(zone, sense, ends[[0]], ends[[1]], *_APART))
    return result
