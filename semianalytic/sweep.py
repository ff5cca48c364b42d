"""A scene over many friction coefficients: zones found at a few, followed through the rest.

Edges are smooth functions of friction as long as the zones stay the same.  Between frictions
solved from scratch they are interpolated, beside them extrapolated, and corrected by Newton's
method on many frictions at once; every one is checked for Coulomb's law.  Where the check or
Newton's method fails, zones have changed, and that friction is solved from scratch.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from time import perf_counter

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.coulomb import admissible
from semianalytic.edges import FARTHEST, NUDGE, Edges, edges_of, moves
from semianalytic.errors import SceneError
from semianalytic.panels import rule_for
from semianalytic.profile import Profile
from semianalytic.rayleigh import Array
from semianalytic.scene import Scene
from semianalytic.solution import Solution, Statistics
from semianalytic.solver import (
    SAFETY,
    difference,
    frictionless,
    loose_tolerance,
    scaled_load,
    slip_zones,
    solve,
)
from semianalytic.zones import Load, ZoneFields

_FIRST = 5  # frictions solved from scratch to begin with
_AT_ONCE = 12  # sets of zones in one batch: more leave the processor's cache
_STENCIL = 3  # known frictions to either side used to interpolate
_MOST_STEPS = 4
_LONGEST_MOVE = 1.5
_NEAR = 2e-3  # move of an edge unknown after which its Jacobian is kept
_SLOW = 0.5  # Newton moves that shrink less are given up
_CONTRACTION, _LEAST_CONTRACTION = 20.0, 1e-3  # of chord steps, by the doubt of a prediction
_TRUSTED = 1e-3  # doubt of a prediction that needs no Newton's method
_BETWEEN = 5  # frictions first tried between two with the same set of zones
_FEWEST = 3  # frictions between two sets of zones for which neither is tried
_BESIDE = 8  # frictions tried at once beyond the last that has a set of zones
_MOST_REFINEMENTS = 3
_LOOSEST = 1e-4  # tolerance of that check: neighbours lend zones where a new one just begins
_STRICTNESS = 10  # of the check of Coulomb's law; `solve`, which is asked next, uses 100


@dataclass(frozen=True)
class Sweep:
    """Solutions of one scene with different friction coefficients.

    Attributes
    ----------
    scene : Scene
        The scene; its own friction plays no part.
    friction : (n,) array
    solutions : tuple of Solution, one per friction
    from_scratch : (n,) array of bool
        Which of them were solved without help from their neighbours.
    """

    scene: Scene
    friction: Array
    solutions: tuple[Solution, ...]
    from_scratch: np.ndarray

    @property
    def status(self) -> tuple[str, ...]:
        """Status of each solution; "converged", or a sentence saying what to distrust."""
        return tuple(solution.status for solution in self.solutions)

    @property
    def error_estimate(self) -> Array:
        """(n,) error estimates, see `Solution`."""
        return np.array([solution.error_estimate for solution in self.solutions])

    @property
    def edges(self) -> Array:
        """(n, m, 2) velocities of the inner and outer edge of the m-th zone from the contact
        edge outward [length / time]; NaN where there are fewer zones."""
        most = max((len(solution.zones) for solution in self.solutions), default=0)
        result = np.full((len(self.solutions), most, 2), np.nan)
        for row, solution in zip(result, self.solutions, strict=True):
            for pair, zone in zip(row, solution.zones, strict=False):
                pair[:] = zone.inner, zone.outer
        return result


@dataclass(frozen=True)
class _Predicted:
    """Unknowns at one friction, the inverse Jacobian if they are to be trusted, how far they may
    be off, and the tolerance of the rule that is likely needed."""

    unknowns: Array
    inverse: Array
    doubt: float
    wanted: float


@dataclass(frozen=True)
class _Followed:
    """Sets of zones of neighbouring frictions, k columns of unknowns, and how they were found.

    inverse (k, e, e) is that of the Jacobian, wanted are the tolerances of their rules, nodes
    the number per set on the last.
    """

    unknowns: Array
    estimate: Array
    sound: np.ndarray
    inverse: Array
    wanted: Array
    steps: int
    nodes: int


def sweep(scene: Scene, friction: ArrayLike, rtol: float = 1e-8) -> Sweep:
    """Solve a scene for many friction coefficients, two to four times as fast as one by one.

    Parameters
    ----------
    scene : Scene
    friction : (n,) array
        Coulomb friction coefficients, in any order.
    rtol : float
        Wanted accuracy, as for `solve`.

    Returns
    -------
    Sweep
        Each solution has passed the same checks as that of `solve`.

    Raises
    ------
    SceneError
        If friction is not one-dimensional, a value of it does not make a scene, or rtol is out
        of range.
    TensionError
        If the contact pressure would turn tensile.
    """
    values = np.array(friction, dtype=float)
    if values.ndim != 1:
        raise SceneError(f"friction must be one-dimensional, got the shape {values.shape}.")
    different, place = np.unique(values, return_inverse=True)
    followed = _Sweeping([replace(scene, friction=float(f)) for f in different], rtol)
    followed.run()
    solutions = tuple(followed.solutions[i] for i in place)
    scratch = np.array([i in followed.scratch for i in place], dtype=bool)
    return Sweep(scene, values, solutions, scratch)


class _Sweeping:
    """Solutions so far of scenes with ascending friction, and the zones they may lend."""

    def __init__(self, scenes: Sequence[Scene], rtol: float) -> None:
        self.scenes, self.rtol = scenes, rtol
        self.friction = np.array([scene.friction for scene in scenes])
        self.solutions: dict[int, Solution] = {}
        self.unknowns: dict[Edges, dict[int, Array]] = {}
        self.inverse: dict[int, Array] = {}  # of the Jacobian, where followed
        self.edges: dict[int, Edges] = {}
        self.wanted: dict[int, float] = {}  # tolerance of the rule that gave the wanted accuracy
        self.scratch: set[int] = set()
        self.tried: set[tuple[Edges | None, int, range]] = set()

    def run(self) -> None:
        """Solve all scenes."""
        count = len(self.scenes)
        if not count:
            return
        for i in np.unique(np.linspace(0, count - 1, min(count, _FIRST)).round().astype(int)):
            self._solve(int(i))
        while len(self.solutions) < count:
            for edges, targets in self._proposed().items():
                self._follow(edges, targets)

    def _gaps(self) -> list[tuple[int, int]]:
        """Neighbouring solutions with scenes between them."""
        return [(i, j) for i, j in pairwise(sorted(self.solutions)) if j > i + 1]

    def _proposed(self) -> dict[Edges, list[int]]:
        """Scenes to try next, by the edges they may have.

        Between equal sets of zones a few, then the rest; beside a set that changes the nearest.
        What has been tried in vain is not tried again: the middle is then solved from scratch.
        """
        proposed: dict[Edges, list[int]] = {}
        for left, right in self._gaps():
            at_left, at_right = self.edges.get(left), self.edges.get(right)
            inside = range(left + 1, right)
            if at_left == at_right:
                step = -(-len(inside) // _BETWEEN) if len(inside) > 2 * _BETWEEN else 1
                tries = [(at_left, left, inside[step // 2 :: step])]
            elif len(inside) < _FEWEST:
                tries = []
            else:
                most = min(_BESIDE, -(-len(inside) // 2))
                tries = [(at_left, left, inside[:most]), (at_right, right, inside[-most:])]
            fresh = [one for one in tries if one not in self.tried]
            self.tried |= set(fresh)
            for edges, _, targets in fresh:
                if edges is not None:
                    fitting = [i for i in targets if _fits(edges, self.scenes[i])]
                    proposed.setdefault(edges, []).extend(fitting)
            if not fresh:
                self._solve((left + right) // 2)
        return proposed

    def _solve(self, i: int) -> None:
        """Solve a scene from scratch."""
        solution = solve(self.scenes[i], rtol=self.rtol)
        self.scratch.add(i)
        self.solutions[i] = solution
        if solution.status == "converged" and not frictionless(self.scenes[i]):
            fields = solution.profile.fields
            self._keep(i, *edges_of(fields.factors, fields.zones), fields.rule.tolerance)

    def _keep(self, i: int, edges: Edges, unknowns: Array, wanted: float) -> None:
        self.edges[i], self.wanted[i] = edges, wanted
        self.unknowns.setdefault(edges, {})[i] = unknowns

    def _predicted(self, edges: Edges, i: int) -> _Predicted:
        """Zones at a friction from the known ones nearest to it, by Lagrange's formula."""
        known = self.unknowns[edges]
        below = sorted((j for j in known if j < i), reverse=True)[:_STENCIL]
        above = sorted(j for j in known if j > i)[:_STENCIL]
        stencil = sorted([*below, *above], key=lambda j: abs(self.friction[j] - self.friction[i]))
        wanted, count = self.wanted[stencil[0]], len(stencil)
        unknowns = np.array([known[j] for j in stencil])
        weights = _lagrange(self.friction[stencil], self.friction[i])
        value = weights @ unknowns
        doubt = np.inf
        if count > 2 and all(j in self.inverse for j in stencil):
            fewer = _lagrange(self.friction[stencil[: count - 2]], self.friction[i])
            lesser = fewer @ unknowns[: count - 2]
            doubt = float(np.abs(value - lesser).max(initial=0.0))
        inverse = np.zeros((len(value), len(value)))
        if doubt < _TRUSTED:
            near = [self.inverse[j] for j in stencil]
            inverse = np.tensordot(weights, np.array(near), 1)
        return _Predicted(np.clip(value, -FARTHEST, FARTHEST), inverse, doubt, wanted)

    def _follow(self, edges: Edges, targets: list[int]) -> None:
        """Try one set of zones at some frictions; keep what fulfils Coulomb's law."""
        targets = [i for i in targets if i not in self.solutions]
        predicted = [self._predicted(edges, i) for i in targets]
        for batch in _batches(edges, predicted):
            start = perf_counter()
            chosen = [targets[j] for j in batch]
            load = _common_load([self.scenes[i] for i in chosen])
            # Edges that cross a cut of the panels on their way give no numbers, and are dropped.
            with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
                found = _followed(edges, [predicted[j] for j in batch], load, self.rtol)
            seconds = (perf_counter() - start) / len(batch)
            for j in np.flatnonzero(found.sound):
                self._add(chosen[j], edges, found, int(j), seconds)

    def _add(self, i: int, edges: Edges, found: _Followed, column: int, seconds: float) -> None:
        scene, unknowns = self.scenes[i], found.unknowns[:, column]
        load, stress = scaled_load(scene)
        zones = edges.zones(unknowns)
        profile = Profile(ZoneFields(edges.factors, load, zones, rule_for(found.wanted[column])))
        stages = {"zones": 0.0, "edges": seconds, "check": 0.0}
        statistics = Statistics(0, found.steps, 1, len(unknowns), found.nodes, stages)
        estimate = float(found.estimate[column])
        self.solutions[i] = Solution(
            scene, slip_zones(scene, profile), "converged", estimate, statistics, profile, stress
        )
        self._keep(i, edges, unknowns, found.wanted[column])
        self.inverse[i] = found.inverse[column]


def _fits(edges: Edges, scene: Scene) -> bool:
    """Whether zones are open ahead of all waves only where friction is reached there."""
    critical = scaled_load(scene)[0].critical
    return critical if edges.open_ends[0] else not scene.far_slip_rate


def _lagrange(at: Array, f: float) -> Array:
    """Weights of values at different places `at` (m,) in the polynomial through them at f."""
    apart = at[:, None] - at + np.eye(len(at))
    others = np.where(np.eye(len(at), dtype=bool), 1.0, f - at)
    return np.asarray(np.prod(others / apart, axis=1))


def _batches(edges: Edges, predicted: list[_Predicted]) -> Iterator[list[int]]:
    """Sets of zones that may share panels: every edge on one side of every cut, near one front."""
    groups: dict[tuple, list[int]] = {}
    for j, prediction in enumerate(predicted):
        points = edges.points(prediction.unknowns)
        sides = [[p.first_below(cut) for cut in edges.factors.cuts] for p in points]
        key = (prediction.doubt < _TRUSTED, *(p.nearest for p in points), *np.ravel(sides).tolist())
        groups.setdefault(key, []).append(j)
    for group in groups.values():
        parts = -(-len(group) // _AT_ONCE)
        yield from (part.tolist() for part in np.array_split(group, parts))


def _common_load(scenes: Sequence[Scene]) -> Load:
    """Loads of scenes that differ in friction, in the least of their units of stress."""
    loads = [scaled_load(scene) for scene in scenes]
    load, least = min(loads, key=lambda pair: pair[1])
    far = [float(one.far_slip_rate) * stress / least for one, stress in loads]
    friction = np.array([scene.friction for scene in scenes])
    return replace(load, friction=friction[:, None], far_slip_rate=np.array(far)[:, None])


def _chosen(load: Load, which: np.ndarray) -> Load:
    """The loads of some sets of zones."""
    friction, far = np.asarray(load.friction), np.asarray(load.far_slip_rate)
    return replace(load, friction=friction[which], far_slip_rate=far[which])


def _newton(edges: Edges, start: Array, load: Load, rtol: float) -> tuple[Array, Array, Array, int]:
    """Unknowns (e, k) near their places on the loose rule, inverse Jacobians (k, e, e), the last
    moves (k,), infinite for sets that did not get there, and the steps taken."""
    rule = rule_for(loose_tolerance(rtol))
    size, count = start.shape
    unknowns, inverse = start.copy(), np.zeros((count, size, size))
    alive = np.arange(count)
    waiting = alive[edges.admits(unknowns)]
    last, previous = np.full(count, np.inf), np.full(count, np.inf)
    nudges = np.concatenate([np.zeros((size, 1)), NUDGE * np.eye(size)], axis=1)
    step = 0
    while len(waiting) and step < _MOST_STEPS:
        step += 1
        neighbours = unknowns[:, waiting, None] + nudges[:, None, :]
        repeated = _chosen(load, np.repeat(waiting, size + 1))
        values = edges.mismatch(neighbours.reshape(size, -1), repeated, rule)
        values = values.reshape(neighbours.shape)
        jacobian = np.moveaxis(values[..., 1:] - values[..., :1], 0, 1) / NUDGE
        try:
            inverse[waiting] = np.linalg.inv(jacobian)
        except np.linalg.LinAlgError:
            break
        move = -moves(inverse[waiting], values[..., 0])
        largest = np.abs(move).max(axis=0)
        finite = largest < np.inf
        waiting, move, largest = waiting[finite], move[:, finite], largest[finite]
        unknowns[:, waiting] += move * np.minimum(1.0, _LONGEST_MOVE / np.maximum(largest, 1e-300))
        admitted = edges.admits(unknowns[:, waiting]) & (largest < _SLOW * previous[waiting])
        previous[waiting] = largest
        last[waiting] = np.where(admitted & (largest < _NEAR), largest, np.inf)
        waiting = waiting[admitted & (largest >= _NEAR)]
    return unknowns, inverse, last, step


@dataclass(frozen=True)
class _Polished:
    """Sets of zones on a rule: which, whether settled, their unknowns (e, k), how far these may
    be off, and the fields beside them."""

    kept: np.ndarray
    settled: np.ndarray
    unknowns: Array
    left: Array
    beside: Array
    fields: ZoneFields
    steps: int


def _polished(
    edges: Edges,
    start: Array,
    inverse: Array,
    contraction: Array,
    load: Load,
    rtol: float,
    wanted: float,
) -> _Polished:
    """Chord steps on the rule of a tolerance until what is left of the mismatch is negligible.

    A step leaves `contraction` (k,) of itself, at least what has been seen.  The fields are those
    before the last step, which is far below what Coulomb's law is checked to.
    """
    kept, unknowns, rule = np.arange(start.shape[1]), start, rule_for(wanted)
    previous, sound = np.full(len(kept), np.inf), np.zeros(len(kept), dtype=bool)
    for step in range(_MOST_STEPS):
        beside, left = unknowns, np.zeros(len(kept))
        zones = edges.zones(beside)
        fields = ZoneFields(edges.factors, _chosen(load, kept), zones, rule)
        if not len(start):
            sound[:] = True
            break
        move = -moves(inverse[kept], fields.mismatch())
        unknowns, size = beside + move, np.abs(move).max(axis=0)
        contraction[kept] = np.maximum(contraction[kept], size / previous)
        left = size * contraction[kept]
        settled = (left <= max(0.02 * rtol, 1e-13)) & (size <= 10 * rtol)
        going = edges.admits(unknowns) & (size < _SLOW * previous)
        if np.all(settled | ~going) or step == _MOST_STEPS - 1:
            sound[kept] = settled
            unknowns = np.where(settled, unknowns, beside)
            break
        kept, unknowns, previous = kept[going], unknowns[:, going], size[going]
    return _Polished(kept, sound[kept], unknowns, left, beside, fields, step + 1)


def _followed(edges: Edges, predicted: list[_Predicted], load: Load, rtol: float) -> _Followed:
    """Edges at several frictions from predictions, polished, estimated and checked.

    Those whose error estimate exceeds rtol are taken to finer rules.
    """
    count, size = len(predicted), len(edges.segments)
    unknowns = np.array([one.unknowns for one in predicted]).T.reshape(size, count)
    inverse = np.array([one.inverse for one in predicted])
    wanted = np.array([one.wanted for one in predicted])
    doubt = np.array([one.doubt for one in predicted])
    estimate, sound = np.full(count, np.inf), np.zeros(count, dtype=bool)
    kept, steps, nodes = np.arange(count), 0, 0
    contraction = np.maximum(_CONTRACTION * doubt, _LEAST_CONTRACTION)
    if size and not np.all(doubt < _TRUSTED):
        unknowns, inverse, last, steps = _newton(edges, unknowns, load, rtol)
        contraction = np.maximum(2 * last, _LEAST_CONTRACTION)
        kept = np.flatnonzero(last < np.inf)
        loose = loose_tolerance(rtol)
        if len(kept) and wanted[kept].min() < 1e-2 * loose:
            between = rule_for(float(np.sqrt(loose * wanted[kept].min())))
            values = edges.mismatch(unknowns[:, kept], _chosen(load, kept), between)
            unknowns[:, kept] -= moves(inverse[kept], values)
            kept = kept[edges.admits(unknowns[:, kept])]
            steps += 1
    for _ in range(_MOST_REFINEMENTS):
        if not len(kept):
            break
        finest = float(wanted[kept].max())
        start, loads = unknowns[:, kept], _chosen(load, kept)
        polished = _polished(edges, start, inverse[kept], contraction[kept], loads, rtol, finest)
        steps += polished.steps
        kept = kept[polished.kept]
        unknowns[:, kept], wanted[kept] = polished.unknowns, finest
        fields = polished.fields
        nodes = fields.panels.jacobian[:, 0].size
        lawful = polished.settled & admissible(Profile(fields), min(_STRICTNESS * rtol, _LOOSEST))
        coarse = ZoneFields(edges.factors, fields.load, fields.zones, rule_for(5 * finest))
        moved = polished.beside
        if size:
            moved = moved - np.clip(moves(inverse[kept], coarse.mismatch()), -1.0, 1.0)
        estimate[kept] = difference(edges, polished.unknowns, moved, fields, coarse)
        estimate[kept] += SAFETY * polished.left
        sound[kept] = lawful & (estimate[kept] <= rtol)
        kept = kept[lawful & ~sound[kept]]
        wanted[kept] *= np.maximum(0.1 * rtol / estimate[kept], 1e-3)
    return _Followed(unknowns, estimate, sound, inverse, wanted, steps, nodes)
