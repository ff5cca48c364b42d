"""Solve a scene: which zones slip (complementarity), then where exactly they end (Newton)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from time import perf_counter

import numpy as np

from semianalytic.halfplane.rayleigh import Array, RayleighFactors, rayleigh_factors
from semianalytic.halfplane.rules import Rule, rule_for
from semianalytic.halfplane.stuck import stuck_traction
from semianalytic.scene.checks import checked_number
from semianalytic.scene.errors import ComputationError, TensionError
from semianalytic.scene.scene import Scene
from semianalytic.selfsimilar.collocation import GridSlip, slip_on_grid
from semianalytic.selfsimilar.coulomb import (
    ELSEWHERE,
    across_shear_front,
    corrected,
    joined,
    largest_excess,
    violations,
    without_vanished,
)
from semianalytic.selfsimilar.edges import (
    Edges,
    broyden,
    edge_shift,
    edges_of,
    edges_on_grid,
    locate_edges,
    moves,
)
from semianalytic.selfsimilar.front import with_slip_at_front
from semianalytic.selfsimilar.profile import Profile
from semianalytic.selfsimilar.running import RunningIntegral
from semianalytic.selfsimilar.solution import SlipZone, Solution, Statistics
from semianalytic.selfsimilar.weak import frictionless_profile, slip_senses, weak_friction_zones
from semianalytic.selfsimilar.zones import Load, ZoneFields, per_set

_GRIDS = (48, 96, 192, 384)
_MOST_ZONE_SETS = 12
_MOST_REFINEMENTS = 8
_MOST_POLISHINGS = 8
_STRICT = 1e-9  # tolerance of the rule on which zones are looked for again
_STRICTER, _STRICTEST = 1e-3, 1e-12  # tolerances of the answer then, over rtol and at all
_COARSE = 3.0  # rules are much better than their tolerance as far as edges go
_SHIFT, _LEAST_SHIFT = 0.1, 1e-7  # of edges when zones are looked for, over rtol and at least
_LEFT = 0.02  # shift of edges left in the end, over rtol
_SMALL = 0.1  # of rtol, the error that is hoped for on the next rule
_STRICTNESS = 10  # of the check of Coulomb's law, over the tolerance of a rule: noise is below 1
_NEGLIGIBLE = 1e-15  # friction over the step of shear
_ROUNDING = 5e-15  # of tractions at nodes, relative to strength plus load
_BETWEEN, _BESIDE_POLE = 0.3, 6.0  # error between nodes, over the tolerance of a rule
SAFETY = 5.0  # slip rates near edges and fronts change more than the quantities compared


def check_pressure(scene: Scene) -> None:
    """Raise TensionError where the contact pressure of a scene would turn tensile."""
    base, step = scene.base.pressure, scene.load.pressure
    mode_one = stuck_traction(scene.material.poisson_ratio, "I")
    if step < 0:
        raise TensionError(
            "scene: a negative pressure step opens the contact at its edge x = 0; "
            "make load pressure positive, or simulate the scene with finite elements "
            "(docs/limits.md)."
        )
    least = base + step * mode_one.at_rayleigh_front
    if least < 0:
        raise TensionError(
            f"scene: the contact pressure would fall to {least:.4g} at the Rayleigh front "
            f"x/t = {scene.material.rayleigh_speed:.6g}; raise base pressure to at least "
            f"{base - least:.4g}, or simulate the scene with finite elements (docs/limits.md)."
        )


def frictionless(scene: Scene) -> bool:
    """Whether nothing resists slip, or only what rounding takes from the step of shear."""
    strength = scene.friction * max(scene.base.pressure, scene.load.pressure)
    return strength == 0 or strength < _NEGLIGIBLE * abs(scene.load.shear)


def scaled_load(scene: Scene) -> tuple[Load, float]:
    """Load in units of its largest traction, and that unit."""
    f, base, step = scene.friction, scene.base, scene.load
    parts = (step.shear, f * step.pressure, base.shear, f * base.pressure)
    stress = max(abs(part) for part in parts) or 1.0
    load = Load(
        f,
        base.pressure / stress,
        base.shear / stress,
        step.pressure / stress,
        step.shear / stress,
        scene.far_slip_rate * scene.material.shear_impedance / (2 * stress),
    )
    return load, stress


@dataclass(frozen=True)
class _Found:
    """Zones and their profile on a rule, whether they fulfil Coulomb's law there, and the cost."""

    edges: Edges
    unknowns: Array
    inverse: Array
    profile: Profile
    sound: bool
    steps: int = 0
    sets: int = 1


@dataclass(frozen=True)
class _Search:
    """On which rule edges are located and to what shift, on which Coulomb's law is checked."""

    locating: Rule
    shift: float
    checking: Rule


@np.errstate(over="ignore", invalid="ignore", divide="ignore")  # ends in a status
def _settled(edges: Edges, unknowns: Array, load: Load, search: _Search) -> _Found:
    """Zones corrected from a start until Coulomb's law holds."""
    steps, inverse = 0, np.zeros((0, 0))
    for sets in range(1, _MOST_ZONE_SETS + 1):
        if len(unknowns):
            located = locate_edges(edges, load, search.locating, unknowns, search.shift)
            steps += located.steps
            unknowns, inverse = located.unknowns, located.inverse
            if not located.converged:
                other = (
                    across_shear_front(edges, unknowns)
                    or without_vanished(edges, unknowns)
                    or joined(edges, unknowns)
                )
                if other is None:
                    break
                edges, unknowns = other
                continue
        profile = _profile(edges, unknowns, load, search.checking)
        wrong = violations(profile, _STRICTNESS * search.checking.tolerance)
        if wrong is None:
            break
        if not wrong:
            return _Found(edges, unknowns, inverse, profile, True, steps, sets)
        edges, unknowns = corrected(edges, unknowns, wrong, load)
    profile = _profile(edges, unknowns, load, search.checking)
    return _Found(edges, unknowns, inverse, profile, False, steps, sets)


def _profile(edges: Edges, unknowns: Array, load: Load, rule: Rule) -> Profile:
    return Profile(ZoneFields(edges.factors, load, edges.zones(unknowns), rule))


def first_stage(factors: RayleighFactors, load: Load, size: int = _GRIDS[0]) -> GridSlip:
    """Slip rate on a grid of about `size` nodes: which zones there are, and about where."""
    return slip_on_grid(
        factors.poisson_ratio,
        float(load.friction),
        (load.base_pressure, load.base_shear),
        (load.load_pressure, load.load_shear),
        float(load.far_slip_rate),
        size,
    )


def _find_zones(
    factors: RayleighFactors, load: Load, rtol: float, loose: float
) -> tuple[_Found, int]:
    """Zones from complementarity on finer and finer grids, located on a rule of a loose tolerance,
    and the pivots it took."""
    pivots = steps = sets = 0
    checking, shift = rule_for(loose), max(_SHIFT * rtol, _LEAST_SHIFT)
    none = edges_of(factors, ())
    found = _Found(*none, np.zeros((0, 0)), _profile(*none, load, checking), False)
    for size in (0, *_GRIDS):
        if not (load.load_shear or load.load_pressure or load.far_slip_rate):
            start = none  # nothing happens, though the base may be at friction
        elif size:
            try:
                grid = first_stage(factors, load, size)
            except ComputationError:  # pivoting ended on a ray, by rounding
                continue
            pivots += grid.pivots
            start = edges_on_grid(factors, grid, load.critical)
        elif (weak := weak_friction_zones(factors, load)) is not None:
            start = weak
        else:
            continue
        locating = checking if size > _GRIDS[0] else rule_for(_COARSE * loose)
        start = with_slip_at_front(*start, load)
        found = _settled(*start, load, _Search(locating, shift, checking))
        steps, sets = steps + found.steps, sets + found.sets
        if found.sound:
            break
    return replace(found, steps=steps, sets=sets), pivots


@np.errstate(over="ignore", invalid="ignore", divide="ignore")  # ends in a status
def _refined(found: _Found, load: Load, rtol: float) -> tuple[_Found, float]:
    """Polish the edges on finer and finer rules until a coarser companion agrees to rtol.

    With the steps this took, and the error estimate.
    """
    if not found.sound:
        return replace(found, steps=0), np.inf
    wanted, steps = rtol / 10, 0
    for _ in range(_MOST_REFINEMENTS):
        found, left = _polished(found, load, rule_for(wanted), max(_LEFT * rtol, 1e-13))
        steps += found.steps
        unknowns, fields = found.unknowns, found.profile.fields
        coarse = ZoneFields(fields.factors, load, fields.zones, rule_for(5 * wanted))
        moved = unknowns
        if len(unknowns):
            moved = unknowns - moves(found.inverse, coarse.mismatch())
        numerical = float(difference(found.edges, unknowns, moved, fields, coarse))
        numerical += 4 * SAFETY * left  # slip rates change fastest beside edges
        missed = float(missed_slip(found.profile))
        if not numerical + missed < np.inf:
            return replace(found, steps=steps), np.inf  # zones that shrink to nothing
        if numerical + missed <= rtol or numerical <= _SMALL * rtol:
            break  # a finer rule finds no zone that is missed: the check does
        wanted *= max(min(_SMALL * rtol / numerical, 0.1), 1e-2)
    return replace(found, steps=steps), numerical + missed


def _lawful(
    found: _Found, refined: _Found, estimate: float, load: Load, rtol: float
) -> tuple[_Found, float]:
    """Refined zones, or the zones that Coulomb's law demands instead where to rtol they break it.

    With all the steps and sets it took, and the error estimate.
    """
    refined = replace(refined, steps=found.steps + refined.steps)
    if refined.profile.fields.rule is found.profile.fields.rule:
        return refined, estimate  # the law was checked on that rule
    strictness = min(max(float(refined.profile.largest_rate), 1 / _STRICTNESS), 1.0)
    wrong = violations(refined.profile, strictness * rtol)
    if wrong is None:
        return replace(refined, sound=False), np.inf
    if not wrong or not found.sound:
        return refined, estimate
    rule = rule_for(rtol / 10)
    search = _Search(rule, max(_SHIFT * rtol, _LEAST_SHIFT), rule)
    again = _settled(*corrected(found.edges, refined.unknowns, wrong, load), load, search)
    last, estimate = _refined(again, load, rtol)
    steps = refined.steps + again.steps + last.steps
    return replace(last, steps=steps, sets=found.sets + again.sets), estimate


def missed_slip(profile: Profile) -> Array:
    """About how much slip is missed, over the largest slip rate, where traction exceeds friction by
    no more than is tolerated; () or (k,).

    What edges leave unfulfilled shows as traction beside them; it is counted with their shift.
    """
    largest = profile.largest_rate
    known = _ROUNDING + np.abs(profile.fields.mismatch()).max(axis=0, initial=0.0)
    excess = np.maximum(largest_excess(profile) - known, 0.0)
    return ELSEWHERE * excess / np.where(largest > 0, largest, np.inf)


def _polished(found: _Found, load: Load, rule: Rule, target: float) -> tuple[_Found, float]:
    """Zones on a rule by Broyden steps, until the next would shift edges by less than a target;
    and that shift."""
    edges, unknowns, profile = found.edges, found.unknowns, found.profile
    other_rule, steps = profile.fields.rule is not rule, 0
    if not len(unknowns):
        if other_rule:
            profile = _profile(edges, unknowns, load, rule)
        return replace(found, profile=profile, steps=0), 0.0
    inverse, value = found.inverse, profile.fields.mismatch()
    move = -inverse @ value
    shift = np.inf if other_rule else float(edge_shift(edges, unknowns, unknowns + move))
    while shift > target and steps < _MOST_POLISHINGS and edges.admits(unknowns + move):
        steps, unknowns, before = steps + 1, unknowns + move, value
        profile = _profile(edges, unknowns, load, rule)
        value = profile.fields.mismatch()
        if steps > 1 or not other_rule:  # else the value before is of that rule
            inverse = broyden(inverse, move, value - before)
        move = -inverse @ value
        shift = float(edge_shift(edges, unknowns, unknowns + move))
    return replace(found, unknowns=unknowns, profile=profile, inverse=inverse, steps=steps), shift


def difference(
    edges: Edges, unknowns: Array, moved: Array, fine: ZoneFields, coarse: ZoneFields
) -> Array:
    """Error estimate from the difference of two rules, () or (k,).

    Of edges over the lesser of themselves and c_t, and of slip rates over the largest, which move
    with them: compared in the middle and at the end of every panel, by their residues, and by the
    widths of zones.

    Parameters
    ----------
    unknowns, moved : (e,) or (e, k) arrays, edges that are right on the fine and the coarse rule
    fine, coarse : ZoneFields of the same zones on two rules
    """
    compared, scale, peaks = [], np.ones(()), np.zeros(())
    for fields in (coarse, fine):
        panels = fields.panels
        rate = RunningIntegral(panels, fields.slip_rate_slope, fields.factors.c)
        halves = panels.rule.halved(rate.density * panels.jacobian)
        ends = np.cumsum(rate.totals, axis=0) + per_set(fields.load.far_slip_rate)
        peaks = np.maximum(np.abs(ends), np.abs(ends - rate.totals + halves))
        scale = peaks.max(axis=0)
        halves[rate.residues != 0] = 0.0  # the middle of such a panel depends on the rule
        compared.append(np.concatenate([rate.totals, halves, rate.residues]))
    scale = np.where(scale > 0, scale, 1.0)
    rates = np.abs(compared[0] - compared[1]).max(axis=0) / scale
    least = (_BESIDE_POLE if fine.layout.pole >= 0 else _BETWEEN) * fine.rule.tolerance
    if len(unknowns):
        by_width = _share_of_width(edges, unknowns, moved, fine, peaks) / scale
        rates = np.maximum(np.maximum(rates, by_width), edge_shift(edges, unknowns, moved))
    return 1e-14 + least + SAFETY * rates


def _share_of_width(
    edges: Edges, unknowns: Array, moved: Array, fields: ZoneFields, peaks: Array
) -> Array:
    """How much slip rates change with the width of zones that end on both sides, () or (k,).

    `peaks` (p, ...) are the largest slip rates in panels.
    """
    v = edges.parts(unknowns)[0]
    change, slipping = np.abs(edges.parts(moved)[0] - v), fields.layout.slipping
    worst, edge = np.zeros(unknowns.shape[1:]), 0
    for index, zone in enumerate(fields.zones):
        ends = (zone.left is not None) + (zone.right is not None)
        if ends == 2:
            here = slipping & (np.array(fields.layout.zone) == index)
            share = 2 * (change[edge] + change[edge + 1]) / (v[edge + 1] - v[edge])
            worst = np.maximum(worst, peaks[here].max(axis=0) * share)
        edge += ends
    return worst


def solve(scene: Scene, *, rtol: float = 1e-8) -> Solution:
    """Solve a scene for slip and stick on its interface.

    Parameters
    ----------
    scene : Scene
    rtol : float
        Wanted accuracy, between 1e-12 and 1e-2, of zone edges (relative to c_t), of the slip rate
        in L1 and at points away from edges and c_R, and of integrals: of all that
        `Solution.error_estimate` is said to bound.

    Returns
    -------
    Solution
        Its `status` is "converged" if the error estimate is below rtol and Coulomb's law holds
        to rtol at the nodes and between them.

    Raises
    ------
    SceneError
        If rtol is out of range, or the scene is not self-similar.
    TensionError
        If the contact pressure would turn tensile; the message says where.
    """
    scene.check_self_similar()
    rtol = checked_number(
        "rtol", rtol, "lie between 1e-12 and 1e-2", lambda given: 1e-12 <= given <= 1e-2
    )
    check_pressure(scene)
    factors = rayleigh_factors(scene.material.poisson_ratio)
    load, stress = scaled_load(scene)
    clock = [perf_counter()]
    loose = loose_tolerance(rtol)
    pivots = 0
    if frictionless(scene):
        profile = frictionless_profile(factors, load, rule_for(loose))
        edges = Edges(factors, (1,), (True, True), ())
        found = _Found(edges, np.zeros(0), np.zeros((0, 0)), profile, True)
    else:
        found, pivots = _find_zones(factors, load, rtol, loose)
    clock.append(perf_counter())
    refined, estimate = _refined(found, load, rtol)
    clock.append(perf_counter())
    if not frictionless(scene):
        refined, estimate = _lawful(found, refined, estimate, load, rtol)
        if not estimate <= rtol:
            # what hardly slips is driven by less than a loose rule can tell
            strict = max(_STRICTER * rtol, min(rtol, _STRICTEST))
            found, more = _find_zones(factors, load, strict, min(loose, _STRICT))
            pivots += more
            again, lower = _lawful(found, *_refined(found, load, strict), load, strict)
            if lower <= estimate:
                refined, estimate = again, lower
    clock.append(perf_counter())
    status = "converged"
    if not refined.sound:
        status = "no set of slip zones was found that fulfils Coulomb's law everywhere"
    elif estimate > rtol:
        status = f"the error estimate {estimate:.1e} exceeds rtol {rtol:.1e}"
    stages = dict(zip(("zones", "edges", "check"), np.diff(clock).tolist(), strict=True))
    statistics = Statistics(
        pivots=pivots,
        newton_steps=refined.steps,
        zone_sets=refined.sets,
        unknowns=len(refined.unknowns),
        nodes=int(refined.profile.panels.jacobian.size),
        seconds=stages,
    )
    zones = slip_zones(scene, refined.profile)
    return Solution(scene, zones, status, estimate, statistics, refined.profile, stress)


def loose_tolerance(rtol: float) -> float:
    """Tolerance of the rule on which zones are looked for."""
    return max(rtol / 10, 1e-4)


def slip_zones(scene: Scene, profile: Profile) -> tuple[SlipZone, ...]:
    """Zones in velocity, from the contact edge outward; without friction cut by sense of slip."""
    speed = scene.material.shear_speed
    if frictionless(scene):
        return _zones_by_sense(profile, speed)
    ahead = np.inf if scene.far_slip_rate else scene.material.longitudinal_speed
    return tuple(
        SlipZone(
            0.0 if zone.right is None else float(speed / zone.right.v[0]),
            ahead if zone.left is None else float(speed / zone.left.v[0]),
            zone.sense,
        )
        for zone in reversed(profile.fields.zones)
    )


def _zones_by_sense(profile: Profile, speed: float) -> tuple[SlipZone, ...]:
    """Zones of a frictionless interface: it slips behind the longitudinal front, either way."""
    senses, changes = slip_senses(profile)
    fields = profile.fields
    front = np.inf if fields.load.far_slip_rate else speed / fields.factors.a
    edges = [front, *(float(speed / change.v[0]) for change in changes), 0.0]
    zones = [
        SlipZone(inner, outer, sense)
        for (outer, inner), sense in zip(pairwise(edges), senses, strict=False)
    ]
    return tuple(reversed(zones))
