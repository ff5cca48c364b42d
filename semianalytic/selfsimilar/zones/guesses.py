"""First guesses of the slip zones: those of weak friction, and those seen on a grid."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from semianalytic.cut.load import Load, Opened
from semianalytic.cut.quadrature.layout import Zone
from semianalytic.halfplane.rayleigh import CutPoints, RayleighFactors
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import ComputationError
from semianalytic.selfsimilar.zones import tuning
from semianalytic.selfsimilar.zones.collocation import GridSlip, is_open, slip_on_grid
from semianalytic.selfsimilar.zones.weak_friction import weak_friction_zones, with_slip_at_front


@dataclass(frozen=True)
class Guess:
    """Zones to begin with, pivots they took, and whether a coarser grid has failed."""

    zones: Sequence[Zone]
    pivots: int = 0
    doubtful: bool = False


def guesses(factors: RayleighFactors, load: Load) -> Iterator[Guess]:
    """Yield the zones of weak friction, if it is, then those on finer and finer grids."""
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
            # Where base and step nearly balance at the opening, the stuck traction does not decide.
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
            # Largest share: towards stick, slip of the other sense, and a front or narrow gap.
            inner, most = node + inward, 1.25
            if sense[outside]:
                most = 0.4
            elif fronts[outside] or sense[outside - inward]:
                most = 0.95
            seen = start <= inner < stop and rate[inner]
            ratio = abs(rate[node] / rate[inner]) if seen else 0.5
            # An edge between two nodes leaves the same pattern wherever it lies: from the ratio of
            # the outermost slip rate to the next one follows its place, to
            # 0.02 of the unknowns in the median of a hundred random scenes.
            share = float(min(0.25 + 0.75 * ratio, most))
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
    contact edge.
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
    ends = [None if zone.right is None else zone.right.v[0] for zone in zones]
    index = next(i for i, end in enumerate(ends) if end is None or end * grid.xi[first] > 1)
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
    """Return the zone around an opening at the edge that no grid resolves, or None.

    Slip begins about where the traction of a stuck interface exceeds the strength that is left, in
    the sense of the traction at the opening, which may be opposite to that of the base.
    """
    # Within 0.02 c_t of the contact edge slip is sought without a grid: with grids alone 4 of 60
    # random openings fail, and work is 2.7 times as much.
    opening, widest = opened.zone, 1 / 0.02
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
    """Return a zone with edges on their sides of its opening, open from node to node of a grid."""
    # Place of an edge that a grid puts within an opening, from there to the next node.
    share, (last, first) = 0.3, nodes
    assert opening.left is not None
    if zone.left is not None and not zone.left.first_below(opening.left):
        start = 1 / opening.left.v[0]
        zone = replace(zone, left=factors.cut([1 / (start + share * (xi[first + 1] - start))]))
    closing = opening.right
    if closing is None or zone.right is None or zone.held or closing.first_below(zone.right):
        return zone
    end = 1 / closing.v[0]
    return replace(zone, right=factors.cut([1 / (end + share * (xi[last - 1] - end))]))
