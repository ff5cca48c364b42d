"""Solve a scene: which zones slip (complementarity), then where exactly they end (Newton)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from time import perf_counter

import numpy as np
from scipy.optimize import brentq

from semianalytic.collocation import GridSlip, slip_on_grid
from semianalytic.errors import SceneError, TensionError
from semianalytic.panels import Rule, Zone, rule_for
from semianalytic.rayleigh import Array, CutPoints, RayleighFactors, rayleigh_factors
from semianalytic.scene import Scene
from semianalytic.profile import Profile
from semianalytic.solution import SlipZone, Solution, Statistics
from semianalytic.stuck import stuck_traction
from semianalytic.zones import Load, ZoneFields

_GRIDS = (48, 96, 192, 384)
_MOST_ZONE_SETS = 12
_MOST_STEPS = 40
_MOST_REFINEMENTS = 5
_FARTHEST = 300.0  # unknowns beyond put an edge on a wave front or at the contact edge
_NARROWEST_GAP = 1e-14  # a stick gap around c_R narrower than x/t can resolve is left out


@dataclass(frozen=True)
class Edges:
    """Zone edges as unbounded unknowns: where each lies between two wave fronts.

    Attributes
    ----------
    factors : RayleighFactors
    senses : tuple of int, one per zone, from the longitudinal front inward
    open_ends : (bool, bool), whether the first zone starts ahead of all waves and whether the
        last one reaches the contact edge
    segments : tuple of int, per edge: 0 for (a, b), 1 for (b, c), 2 for (c, inf)
    """

    factors: RayleighFactors
    senses: tuple[int, ...]
    open_ends: tuple[bool, bool]
    segments: tuple[int, ...]

    def points(self, unknowns: Array) -> list[CutPoints]:
        """Edges in slowness; the unknown is a logit in a bounded segment, a logarithm beyond c."""
        a, c = self.factors.a, self.factors.c
        result = []
        for z, segment in zip(unknowns, self.segments, strict=True):
            if segment == 2:
                result.append(self.factors.near_c(np.exp(z)))
                continue
            low, high = ((a, 1.0), (1.0, c))[segment]
            up, down = (high - low) / (1 + np.exp(-z)), (high - low) / (1 + np.exp(z))
            if segment == 0:
                result.append(CutPoints(a + up, up, -down, a - c + up))
            else:
                result.append(CutPoints(1 + up, 1 - a + up, up, -down))
        return result

    def zones(self, unknowns: Array) -> tuple[Zone, ...]:
        """The zones of given unknowns."""
        points: list[CutPoints | None] = list(self.points(unknowns))
        if self.open_ends[0]:
            points.insert(0, None)
        if self.open_ends[1]:
            points.append(None)
        return tuple(
            Zone(points[2 * i], points[2 * i + 1], sense) for i, sense in enumerate(self.senses)
        )

    def admits(self, unknowns: Array) -> bool:
        """Whether edges keep their order and stay off the ends of the cut."""
        if not np.abs(unknowns).max() < _FARTHEST:
            return False
        points = self.points(unknowns)
        return all(float(q.minus(p)) > 0 for p, q in pairwise(points))


def _place(
    factors: RayleighFactors,
    senses: tuple[int, ...],
    open_ends: tuple[bool, bool],
    points: list[CutPoints],
) -> tuple[Edges, Array]:
    """Edges and unknowns from points on the cut."""
    segments, unknowns = [], []
    for p in points:
        if p.from_c > 0:
            segments.append(2)
            unknowns.append(np.log(p.from_c))
        elif p.from_b > 0:
            segments.append(1)
            unknowns.append(np.log(p.from_b) - np.log(-p.from_c))
        else:
            segments.append(0)
            unknowns.append(np.log(p.from_a) - np.log(-p.from_b))
    return Edges(factors, senses, open_ends, tuple(segments)), np.array(unknowns, dtype=float)


def zones_on_grid(factors: RayleighFactors, grid: GridSlip) -> tuple[Edges, Array]:
    """Zones seen by the first stage, edges placed by the square-root shape of V there."""
    xi, rate = grid.xi[::-1], grid.slip_rate[::-1]  # from the longitudinal front inward
    sense = np.sign(rate).astype(int)
    bounds = [*np.flatnonzero(np.diff(sense, prepend=0)), len(sense)]
    senses, points = [], []
    for start, stop in pairwise(bounds):
        if sense[start] == 0:
            continue
        senses.append(int(sense[start]))
        for node, outside, inward in ((start, start - 1, 1), (stop - 1, stop, -1)):
            if not 0 <= outside < len(xi):
                continue
            share, most = 0.5, 0.9
            if sense[outside]:
                share, most = 0.25, 0.4
            inner = node + inward
            if start <= inner < stop and abs(rate[inner]) > abs(rate[node]):
                square = np.square(rate[[node, inner]])
                reach = abs(xi[inner] - xi[node]) * square[0] / (square[1] - square[0])
                share = float(np.clip(reach / abs(xi[outside] - xi[node]), 0.1, most))
            points.append(factors.cut(1 / (xi[node] + share * (xi[outside] - xi[node]))))
    open_ends = (bool(sense[0]), bool(sense[-1]))
    return _place(factors, tuple(senses), open_ends, points)


@dataclass(frozen=True)
class _Newton:
    """Unknowns after Newton, whether they converged, inverse Jacobian and steps taken."""

    unknowns: Array
    converged: bool
    inverse: Array
    steps: int


def _broyden(inverse: Array, move: Array, change: Array) -> Array:
    """Inverse Jacobian after a step, by Broyden's good update."""
    image = inverse @ change
    denominator = move @ image
    if denominator == 0:
        return inverse
    return inverse + np.outer(move - image, move @ inverse) / denominator


def _newton(edges: Edges, load: Load, rule: Rule, start: Array, tolerance: float) -> _Newton:
    """Solve for the edges by Newton's method with Broyden updates and natural monotonicity."""

    def mismatch(unknowns: Array) -> Array:
        return ZoneFields(edges.factors, load, edges.zones(unknowns), rule, False).mismatch()

    unknowns, size = start, len(start)
    value = mismatch(unknowns)
    inverse, fresh = np.zeros((size, size)), False
    for step in range(1, _MOST_STEPS + 1):
        if not fresh and step in (1, 8, 16, 24):
            jacobian = np.empty((size, size))
            for i in range(size):
                moved = unknowns.copy()
                moved[i] += 1e-6
                jacobian[:, i] = (mismatch(moved) - value) / 1e-6
            try:
                inverse = np.linalg.inv(jacobian)
            except np.linalg.LinAlgError:
                return _Newton(unknowns, False, inverse, step)
        move = -inverse @ value
        largest = np.abs(move).max()
        if largest > 1.5:
            move *= 1.5 / largest
        for _ in range(8):
            trial = unknowns + move
            if edges.admits(trial):
                new = mismatch(trial)
                if np.abs(inverse @ new).max() <= max(largest, 1e-12):
                    break
            move /= 2
        else:
            return _Newton(unknowns, False, inverse, step)
        change = new - value
        unknowns, value = trial, new
        if not np.all(np.isfinite(value)):
            return _Newton(unknowns, False, inverse, step)
        if largest < tolerance:
            return _Newton(unknowns, True, inverse, step)
        inverse = _broyden(inverse, move, change)
    return _Newton(unknowns, False, inverse, _MOST_STEPS)


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


def _violations(profile: Profile, tolerance: float) -> list[Violation]:
    """Where the slip rate has the wrong sign or the traction exceeds friction."""
    panels, load = profile.panels, profile.fields.load
    rates = {int(i): profile.slip_rate_at_nodes(int(i)) for i in np.flatnonzero(panels.sense)}
    largest = max((float(np.abs(rate).max()) for rate in rates.values()), default=0.0)
    found = []
    for region in panels.regions:
        sense = int(panels.sense[region[0]])
        unbounded = panels.right[region[-1]] is None
        at = panels.nodes(region)
        if sense:
            wrong = sense * np.concatenate([rates[i] for i in region]) < -tolerance * largest
            signs = np.full(at.v.shape, sense)
        else:
            strength = load.friction * (load.base_pressure + profile.pressure_change(at.v))
            traction = np.concatenate([profile.traction_at_nodes(i) for i in region])
            scale = 1 + (strength if unbounded else strength.max())
            wrong = np.abs(traction) > strength + tolerance * scale
            signs = np.sign(traction).astype(int)
        wrong[1:-1] |= wrong[:-2] & wrong[2:]
        bounds = np.flatnonzero(np.diff(wrong.astype(int), prepend=0, append=0))
        last = len(at.v) - 1
        zone = int(panels.zone[region[0]]) if sense else -1
        for start, stop in zip(bounds[::2], bounds[1::2], strict=True):
            to_edge = bool(stop > last) and unbounded
            left = at.pick(max(start - 1, 0))
            right = None if to_edge else at.pick(min(stop, last))
            touches = (bool(start == 0), bool(stop > last) and not unbounded)
            found.append(Violation(zone, int(signs[start]), left, right, *touches))
        for i in region:
            if sense and not wrong.any() and sense * profile.residue(i) > 0:
                width = _gap_at_rayleigh_front(profile, i, rates[i])
                if width > _NARROWEST_GAP:
                    left, right = (profile.fields.factors.near_c(d) for d in (-width, width))
                    found.append(Violation(zone, sense, left, right, False, False))
    return found


def _gap_at_rayleigh_front(profile: Profile, panel: int, rate: Array) -> float:
    """Half-width in slowness of the strip around c where the logarithm in V reverses it."""
    from_c = profile.panels.at.from_c[panel]
    nearest = np.argsort(np.abs(from_c))[:2]
    residue = profile.residue(panel)
    level = float(np.mean(rate[nearest] - residue * np.log(np.abs(from_c[nearest]))))
    return float(np.exp(np.maximum(-level / residue, -690.0)))


def _corrected(edges: Edges, unknowns: Array, violations: list[Violation]) -> tuple[Edges, Array]:
    """Zones without the intervals that slip the wrong way, and with those that must slip.

    New zones are made only when the present ones are sound.
    """
    zones = list(edges.zones(unknowns))
    wrong_slip = sorted((bad for bad in violations if bad.zone >= 0), key=lambda bad: bad.left.v)
    for bad in reversed(wrong_slip):
        zone = zones[bad.zone]
        if bad.touches_left:
            zones[bad.zone] = replace(zone, left=bad.right)
        elif bad.touches_right and zone.right is not None:
            zones[bad.zone] = replace(zone, right=bad.left)
        else:
            inner = [] if bad.right is None else [replace(zone, left=bad.right)]
            zones[bad.zone : bad.zone + 1] = [replace(zone, right=bad.left), *inner]
    for bad in (bad for bad in violations if bad.zone < 0):
        after = sum(zone.left is None or bool(zone.left.v < bad.left.v) for zone in zones)
        if bad.touches_right and after < len(zones) and zones[after].sense == bad.sense:
            zones[after] = replace(zones[after], left=bad.left)
        elif bad.touches_left and after > 0 and zones[after - 1].sense == bad.sense:
            zones[after - 1] = replace(zones[after - 1], right=bad.right)
        elif not wrong_slip:
            zones.insert(after, Zone(bad.left, bad.right, bad.sense))
    points = [p for zone in zones for p in (zone.left, zone.right) if p is not None]
    open_ends = (bool(zones) and zones[0].left is None, bool(zones) and zones[-1].right is None)
    return _place(edges.factors, tuple(zone.sense for zone in zones), open_ends, points)


def _check_pressure(scene: Scene) -> None:
    """Raise TensionError where the contact pressure would turn tensile."""
    base, step = scene.base.pressure, scene.step.pressure
    factors = rayleigh_factors(scene.material.poisson_ratio)
    mode_one = stuck_traction(scene.material.poisson_ratio, "I")
    if step < 0:
        raise TensionError(
            "scene: a negative pressure step opens the contact at its edge x = 0; "
            "make step pressure positive, or simulate the scene with finite elements."
        )
    least = base + step * float(mode_one(factors.c))
    if least < 0:
        raise TensionError(
            f"scene: the contact pressure would fall to {least:.4g} at the Rayleigh front "
            f"x/t = {scene.material.rayleigh_speed:.6g}; raise base pressure to at least "
            f"{base - least:.4g}."
        )


def _frictionless(scene: Scene) -> bool:
    return scene.friction == 0 or scene.base.pressure == scene.step.pressure == 0


def _scaled_load(scene: Scene) -> tuple[Load, float]:
    """Load in units of its largest traction, and that unit."""
    f, base, step = scene.friction, scene.base, scene.step
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
    """Zones, whether they fulfil Coulomb's law on a rule, and what finding them took."""

    edges: Edges
    unknowns: Array
    inverse: Array
    sound: bool
    steps: int = 0
    sets: int = 1


def _settled(edges: Edges, unknowns: Array, load: Load, rule: Rule, tolerance: float) -> _Found:
    """Zones corrected from a start until Coulomb's law holds at all nodes."""
    steps, inverse = 0, np.zeros((0, 0))
    for sets in range(1, _MOST_ZONE_SETS + 1):
        if len(unknowns):
            refined = _newton(edges, load, rule, unknowns, 1e-2 * tolerance)
            steps += refined.steps
            unknowns, inverse = refined.unknowns, refined.inverse
            if not refined.converged:
                crossed = _across_shear_front(edges, unknowns)
                if crossed is None:
                    break
                edges, unknowns = crossed
                continue
        fields = ZoneFields(edges.factors, load, edges.zones(unknowns), rule)
        violations = _violations(Profile(fields), tolerance)
        if not violations:
            return _Found(edges, unknowns, inverse, True, steps, sets)
        edges, unknowns = _corrected(edges, unknowns, violations)
    return _Found(edges, unknowns, inverse, False, steps, sets)


def _across_shear_front(edges: Edges, unknowns: Array) -> tuple[Edges, Array] | None:
    """The same zones with edges that ran into the shear front started on its other side."""
    factors, points = edges.factors, edges.points(unknowns)
    stuck_at_front = [
        segment < 2 and abs(float(p.from_b)) < 1e-4
        for p, segment in zip(points, edges.segments, strict=True)
    ]
    if not any(stuck_at_front):
        return None
    behind, ahead = 1 + 0.1 * (factors.c - 1), 1 - 0.02 * (1 - factors.a)
    moved = [
        factors.cut(ahead if p.from_b > 0 else behind) if at_front else p
        for p, at_front in zip(points, stuck_at_front, strict=True)
    ]
    return _place(factors, edges.senses, edges.open_ends, moved)


def _find_zones(
    factors: RayleighFactors, load: Load, rule: Rule, tolerance: float
) -> tuple[_Found, int]:
    """Zones from complementarity on finer and finer grids, and the pivots it took."""
    pivots = steps = sets = 0
    for size in _GRIDS:
        grid = slip_on_grid(
            factors.poisson_ratio,
            load.friction,
            (load.base_pressure, load.base_shear),
            (load.step_pressure, load.step_shear),
            load.far_slip_rate,
            size,
        )
        found = _settled(*zones_on_grid(factors, grid), load, rule, tolerance)
        pivots, steps, sets = pivots + grid.pivots, steps + found.steps, sets + found.sets
        if found.sound:
            break
    return replace(found, steps=steps, sets=sets), pivots


def _polished(found: _Found, unknowns: Array, load: Load, rule: Rule) -> tuple[Array, int]:
    """Unknowns on a finer rule, by Broyden steps from the Jacobian already known."""
    edges, inverse = found.edges, found.inverse
    if not len(unknowns):
        return unknowns, 0

    def mismatch(unknowns: Array) -> Array:
        return ZoneFields(edges.factors, load, edges.zones(unknowns), rule, False).mismatch()

    value = mismatch(unknowns)
    move = -inverse @ value
    step = 1
    while step < 8 and edges.admits(unknowns + move):
        unknowns = unknowns + move
        if np.abs(move).max() < 1e-12:
            break
        step += 1
        change = -value
        value = mismatch(unknowns)
        change += value
        inverse = _broyden(inverse, move, change)
        following = -inverse @ value
        if not np.abs(following).max() < np.abs(move).max():
            break
        move = following
    return unknowns, step


def _difference(fine: Profile, coarse: Profile) -> float:
    """Largest difference of edges and of slip rates, relative to c_t and to the largest rate."""
    edges = [
        abs(1 / p.v - 1 / q.v)
        for x, y in zip(fine.fields.zones, coarse.fields.zones, strict=True)
        for p, q in ((x.left, y.left), (x.right, y.right))
        if p is not None and q is not None
    ]
    u = 1 / np.linspace(0.01, 1 / fine.fields.factors.a, 60)
    rate, other = fine.slip_rate(u), coarse.slip_rate(u)
    rate = np.append(rate, fine.edge_slip_rate)
    other = np.append(other, coarse.edge_slip_rate)
    largest = float(np.abs(rate).max()) or 1.0
    return float(max([*edges, np.abs(rate - other).max() / largest]))


@dataclass(frozen=True)
class _Refined:
    """Profile on the finest rule used, error estimate from the rule before, steps taken."""

    unknowns: Array
    profile: Profile
    estimate: float
    steps: int


def _refined(found: _Found, load: Load, rtol: float) -> _Refined:
    """Polish the edges on finer and finer rules until two agree to rtol."""
    unknowns, steps, wanted = found.unknowns, 0, rtol / 4
    coarse: Profile | None = None
    for _ in range(_MOST_REFINEMENTS):
        rule = rule_for(wanted)
        unknowns, taken = _polished(found, unknowns, load, rule)
        steps += taken
        zones = found.edges.zones(unknowns)
        profile = Profile(ZoneFields(found.edges.factors, load, zones, rule))
        estimate = np.inf if coarse is None else _difference(profile, coarse) + 1e-14
        if estimate <= rtol:
            break
        wanted *= 0.12 if coarse is None else max(0.1 * rtol / estimate, 1e-3)
        coarse = profile
    return _Refined(unknowns, profile, estimate, steps)


def solve(scene: Scene, *, rtol: float = 1e-8) -> Solution:
    """Solve a scene for slip and stick on its interface.

    Parameters
    ----------
    scene : Scene
    rtol : float
        Wanted accuracy of zone edges (relative to c_t) and slip rate (relative to its largest
        value), between 1e-12 and 1e-2.

    Returns
    -------
    Solution
        Its `status` is "converged" if the error estimate is below rtol and Coulomb's law holds
        at every node.

    Raises
    ------
    SceneError
        If rtol is out of range.
    TensionError
        If the contact pressure would turn tensile; the message says where.
    """
    if not 1e-12 <= rtol <= 1e-2:
        raise SceneError(f"rtol must lie between 1e-12 and 1e-2, got {rtol!r}.")
    _check_pressure(scene)
    factors = rayleigh_factors(scene.material.poisson_ratio)
    load, stress = _scaled_load(scene)
    clock = [perf_counter()]
    loose = max(rtol, 1e-4)
    pivots = 0
    if _frictionless(scene):
        edges = Edges(factors, (1,), (True, True), ())
        found = _Found(edges, np.zeros(0), np.zeros((0, 0)), True)
    else:
        found, pivots = _find_zones(factors, load, rule_for(loose), 30 * loose)
    clock.append(perf_counter())
    refined = _refined(found, load, rtol)
    clock.append(perf_counter())
    violations = [] if _frictionless(scene) else _violations(refined.profile, 100 * rtol)
    if found.sound and violations:
        start = _corrected(found.edges, refined.unknowns, violations)
        again = _settled(*start, load, rule_for(rtol), 100 * rtol)
        found = replace(again, steps=found.steps + again.steps, sets=found.sets + again.sets)
        refined = _refined(found, load, rtol)
    status = "converged"
    if not found.sound:
        status = "no set of slip zones was found that fulfils Coulomb's law everywhere"
    elif refined.estimate > rtol:
        status = f"the error estimate {refined.estimate:.1e} exceeds rtol {rtol:.1e}"
    clock.append(perf_counter())
    stages = dict(zip(("zones", "edges", "check"), np.diff(clock).tolist(), strict=True))
    statistics = Statistics(
        pivots=pivots,
        newton_steps=found.steps + refined.steps,
        zone_sets=found.sets,
        unknowns=len(refined.unknowns),
        nodes=int(refined.profile.panels.jacobian.size),
        seconds=stages,
    )
    profile, estimate = refined.profile, refined.estimate
    zones = _slip_zones(scene, profile)
    return Solution(scene, zones, status, estimate, statistics, profile, stress)


def _slip_zones(scene: Scene, profile: Profile) -> tuple[SlipZone, ...]:
    """Zones in velocity, from the contact edge outward; without friction cut by sense of slip."""
    speed = scene.material.shear_speed
    zones = []
    for zone in reversed(profile.fields.zones):
        inner = 0.0 if zone.right is None else float(speed / zone.right.v)
        outer = np.inf if zone.left is None else float(speed / zone.left.v)
        zones.append(SlipZone(inner, outer, zone.sense))
    if _frictionless(scene):
        return _zones_by_sense(profile, speed)
    return tuple(zones)


def _zones_by_sense(profile: Profile, speed: float) -> tuple[SlipZone, ...]:
    """Zones of a frictionless interface: it slips behind the longitudinal front, either way."""
    factors, far = profile.fields.factors, profile.fields.load.far_slip_rate
    close = factors.c * np.logspace(-14, -1, 53)
    v = np.concatenate([profile.panels.at.v.ravel(), factors.c - close, factors.c + close])
    v = np.unique(v[(v > factors.a * (1 + 1e-6)) & (v < 1e6)])
    sense = np.sign(profile.slip_rate(v))
    cuts = [
        brentq(lambda u: float(profile.slip_rate(np.array([u]))[0]), v[i], v[i + 1], xtol=1e-15)
        for i in np.flatnonzero(np.diff(sense))
    ]
    outermost = np.inf if far else speed / factors.a
    edges = [outermost, *(speed / cut for cut in cuts), 0.0]
    bounds = np.concatenate([[0], np.flatnonzero(np.diff(sense)) + 1])
    zones = [
        SlipZone(float(inner), float(outer), int(sense[i]))
        for outer, inner, i in zip(edges[:-1], edges[1:], bounds, strict=True)
    ]
    return tuple(reversed(zones))
