"""Coulomb's inequalities on solved zones: where they fail, and which zones to try next."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from semianalytic.halfplane.rayleigh import Array, CutPoints
from semianalytic.selfsimilar.between import doubtful, hidden
from semianalytic.selfsimilar.edges import Edges, edges_of, place_edges
from semianalytic.selfsimilar.layout import Zone
from semianalytic.selfsimilar.profile import Profile
from semianalytic.selfsimilar.zones import Load, ZoneFields, per_set

_APART = (False, False)
NARROWEST_GAP = 1e-14  # a stick gap around c_R narrower than x/t can resolve is left out

ELSEWHERE = 0.3  # slip rate over the traction that exceeds friction, 0.1 was seen
_LEAST_IMPEDANCE = 1e-3  # times that, over rho c_t; at the longitudinal front for nu near 0
_NARROW = 0.1  # gap over slowness between zones that may have met


@dataclass(frozen=True)
class Violation:
    """An interval of slowness where Coulomb's law fails, in a slip zone or (zone -1) in stick.

    right None: up to the contact edge.
    """

    zone: int
    sense: int
    left: CutPoints
    right: CutPoints | None
    touches_left: bool
    touches_right: bool


def largest_excess(profile: Profile) -> Array:
    """Largest traction over friction on stick, as `violations` see it, 0 or more; () or (k,).

    Ahead of the shear front as much more as there slips more than elsewhere: by the impedance.
    """
    panels, layout = profile.panels, profile.panels.layout
    excess = profile.wrong_at_nodes[layout.stick]
    ahead = layout.stick_ahead
    real, imag = profile.fields.factors.impedance_ahead(panels.at[ahead])
    excess[: len(ahead)] /= np.clip(ELSEWHERE * np.hypot(real, imag), _LEAST_IMPEDANCE, 1.0)
    return np.asarray(excess.max(axis=(0, -1), initial=0.0))


def _misses(profile: Profile, tolerance: float) -> Array:
    """(p, ..., n): at the nodes, the sense in which Coulomb's law is missed: of V in a zone, of the
    traction where it sticks; 0 where it is kept."""
    rate, stick, wrong = (
        profile.slip_rate_at_nodes,
        profile.panels.layout.stick,
        profile.wrong_at_nodes,
    )
    misses = np.sign(rate) * (wrong > tolerance)
    misses[stick] = np.sign(profile.traction_at_nodes[stick]) * (wrong[stick] > tolerance)
    return misses


def admissible(profile: Profile, tolerance: float) -> np.ndarray:
    """Whether Coulomb's law holds for sets of zones, (k,): whether there are no `violations`.

    Nor may a stick gap around c_R be narrower than those that are left out.
    """
    panels = profile.panels
    sound = np.asarray(~_misses(profile, tolerance).any(axis=(0, -1)))
    for inward, outward in zip(profile.fields.zones[1:], profile.fields.zones[:-1], strict=True):
        if inward.left is not None and outward.right is not None:
            width = inward.left.minus(outward.right)[..., 0]
            sound &= (width > 4 * NARROWEST_GAP) | (inward.left.from_c.flat[0] < 0)
    if not profile.edge_slips:
        sound &= _excess_intensity(profile) <= _intensity_tolerance(profile, tolerance)
    if (pole := panels.layout.pole) >= 0:
        reverses = panels.sense[pole] * profile.residues(pole) > 0
        if reverses.any():
            sound &= ~reverses | (reversal_at_rayleigh_front(profile, pole) <= NARROWEST_GAP)
    for j in np.flatnonzero(sound & doubtful(profile).any(axis=(0, -1))):
        sound[j] = not hidden(_one_of(profile, int(j)), tolerance)
    return sound


def _one_of(profile: Profile, j: int) -> Profile:
    """The profile of one of k sets of zones."""
    fields, load = profile.fields, profile.fields.load

    def edge(points: CutPoints | None) -> CutPoints | None:
        return points[j] if points is not None and points.v.ndim == 2 else points

    zones = tuple(Zone(edge(one.left), edge(one.right), one.sense) for one in fields.zones)
    friction, far = (float(np.ravel(x)[j]) for x in (load.friction, load.far_slip_rate))
    load = replace(load, friction=friction, far_slip_rate=far)
    return Profile(ZoneFields(fields.factors, load, zones, fields.rule))


@np.errstate(over="ignore", invalid="ignore", divide="ignore")  # told by None
def violations(profile: Profile, tolerance: float) -> list[Violation] | None:
    """Where the slip rate of one set of zones has the wrong sign or the traction exceeds friction.

    None where the fields are not numbers, as in zones that have shrunk to nothing.

    tolerance is relative to the largest slip rate, and for tractions to strength plus the load,
    in a narrow stick gap plus its share of the load.
    """
    panels, every = profile.panels, _misses(profile, tolerance)
    if np.isnan(every).any():
        return None
    found = []
    for region in panels.layout.regions:
        sense, misses = panels.sense[region[0]], every[region].ravel()
        unbounded, pole = panels.right[region[-1]] is None, panels.layout.pole
        zone = panels.layout.zone[region[0]] if sense else -1
        wrong = misses != 0
        if wrong.any():
            at, last = CutPoints(panels.at.parts[:, region].reshape(4, -1)), len(wrong) - 1
            wrong[1:-1] |= wrong[:-2] & wrong[2:]
            bounds = np.flatnonzero(np.diff(wrong.astype(int), prepend=0, append=0))
            for start, stop in zip(bounds[::2], bounds[1::2], strict=True):
                to_edge = bool(stop > last) and unbounded
                left = at[[max(start - 1, 0)]]
                right = None if to_edge else at[[min(stop, last)]]
                touches = (bool(start == 0), bool(stop > last) and not unbounded)
                found.append(Violation(zone, sense or int(misses[start]), left, right, *touches))
        excess = float(_excess_intensity(profile)) if unbounded and not sense else 0.0
        if not wrong[-1] and excess > _intensity_tolerance(profile, tolerance):
            begin = profile.fields.factors.cut([1 / (4 * min(excess, 0.02))])
            found.append(Violation(-1, int(np.sign(profile.edge_intensity)), begin, None, *_APART))
        if pole in region and not wrong.any() and sense * profile.residue(pole) > 0:
            width = float(reversal_at_rayleigh_front(profile, pole))
            if width > NARROWEST_GAP:
                ends = profile.fields.factors.beside("c", [-width, width])
                found.append(Violation(zone, sense, ends[[0]], ends[[1]], *_APART))
    return found or _hidden_violations(profile, tolerance)


def _hidden_violations(profile: Profile, tolerance: float) -> list[Violation]:
    """Violations between nodes, where there are none at them."""
    found, panels = [], profile.panels
    for one in hidden(profile, tolerance):
        sense, zone = panels.sense[one.panel], panels.layout.zone[one.panel]
        if not sense:
            nearest = np.argmin(np.abs(panels.at.v[one.panel] - one.left.v))
            sense, zone = int(np.sign(profile.traction_at_nodes[one.panel, nearest])), -1
        found.append(Violation(zone, sense, one.left, one.right, *_APART))
    return found


def _intensity_tolerance(profile: Profile, tolerance: float) -> float:
    return tolerance if profile.fields.zones else 1e-12


def _excess_intensity(profile: Profile) -> Array:
    """K_II / (f K_I) - 1 at a stuck contact edge, () or (k,); where positive, it must slip."""
    load = profile.fields.load
    strength = np.asarray(per_set(load.friction) * load.load_pressure)
    traction = np.abs(profile.edge_intensity) / np.sqrt(profile.fields.factors.a)
    # Without strength nothing bounds the traction: seen at the nodes.
    return np.where(strength > 0, traction / np.where(strength > 0, strength, 1.0) - 1, 0.0)


def reversal_at_rayleigh_front(profile: Profile, panel: int) -> Array:
    """Half-width in slowness of the strip around c where the logarithm in V reverses it.

    () or (k,); meant where V falls towards c in the sense of its zone.
    """
    rate, from_c = profile.slip_rate_at_nodes[panel], profile.panels.at.from_c[panel]
    nearest = np.argsort(np.abs(from_c), axis=-1)[..., :2]
    residue = profile.residues(panel)
    log = np.log(np.abs(np.take_along_axis(from_c, nearest, -1)))
    rates = np.take_along_axis(rate, nearest, -1)
    level = np.mean(rates - residue[..., None] * log, axis=-1)
    return np.exp(np.clip(-level / residue, -690.0, 690.0))


def corrected(
    edges: Edges, unknowns: Array, found: list[Violation], load: Load
) -> tuple[Edges, Array]:
    """Zones without the intervals that slip the wrong way, and with those that must slip.

    New zones are made only when the present ones are sound.  With a critical base the first one
    starts at the longitudinal front if it slips as the base would.
    """
    zones = list(edges.zones(unknowns))
    wrong_slip = sorted((bad for bad in found if bad.zone >= 0), key=lambda bad: bad.left.v[0])
    for bad in reversed(wrong_slip):
        zone = zones[bad.zone]
        if bad.touches_left:
            zones[bad.zone] = replace(zone, left=bad.right)
        elif bad.touches_right and zone.right is not None:
            zones[bad.zone] = replace(zone, right=bad.left)
        else:
            inner = [] if bad.right is None else [replace(zone, left=bad.right)]
            zones[bad.zone : bad.zone + 1] = [replace(zone, right=bad.left), *inner]
    for bad in (bad for bad in found if bad.zone < 0):
        after = sum(zone.left is None or bool(zone.left.v < bad.left.v) for zone in zones)
        if bad.touches_right and after < len(zones) and zones[after].sense == bad.sense:
            zones[after] = replace(zones[after], left=bad.left)
        elif bad.touches_left and after > 0 and zones[after - 1].sense == bad.sense:
            zones[after - 1] = replace(zones[after - 1], right=bad.right)
        elif not wrong_slip:
            at_front = after == 0 and load.critical and bad.sense * load.base_shear > 0
            zones.insert(after, Zone(None if at_front else bad.left, bad.right, bad.sense))
    return edges_of(edges.factors, zones)


def across_shear_front(edges: Edges, unknowns: Array) -> tuple[Edges, Array] | None:
    """The same zones with edges that ran into the shear front started on its other side."""
    factors, points = edges.factors, edges.points(unknowns)
    at_front = [
        segment < 2 and abs(p.from_b[0]) < 1e-4
        for p, segment in zip(points, edges.segments, strict=True)
    ]
    if not any(at_front):
        return None
    behind, ahead = 1 + 0.1 * (factors.c - 1), 1 - 0.02 * (1 - factors.a)
    moved = [
        factors.cut([ahead if p.from_b[0] > 0 else behind]) if stopped else p
        for p, stopped in zip(points, at_front, strict=True)
    ]
    return place_edges(factors, edges.senses, edges.open_ends, moved)


def joined(edges: Edges, unknowns: Array) -> tuple[Edges, Array] | None:
    """The zones with those two made one that slip alike on both sides of the narrowest stick gap;
    None if no gap off c is narrow.

    Newton's method closes a gap where the zones have just met.
    """
    zones, gaps = edges.zones(unknowns), {}
    for i, (outer, inner) in enumerate(pairwise(zones)):
        if outer.sense == inner.sense and outer.right is not None and inner.left is not None:
            off_c = bool(outer.right.from_c[0] * inner.left.from_c[0] > 0)
            width = float(inner.left.minus(outer.right)[0] / outer.right.v[0])
            if off_c and width < _NARROW:
                gaps[i] = width
    if not gaps:
        return None
    i = min(gaps, key=lambda i: gaps[i])
    one = replace(zones[i], right=zones[i + 1].right)
    return edges_of(edges.factors, [*zones[:i], one, *zones[i + 2 :]])


def without_vanished(edges: Edges, unknowns: Array) -> tuple[Edges, Array] | None:
    """The zones without those that Newton's method has all but closed; None if there are none."""
    zones = edges.zones(unknowns)
    kept = [
        zone
        for zone in zones
        if zone.left is None
        or zone.right is None
        or zone.right.minus(zone.left)[0] > 1e-4 * float(zone.left.v[0])
    ]
    if len(kept) == len(zones):
        return None
    return edges_of(edges.factors, kept)
