"""A scene over many friction coefficients: zones found at a few, followed through the rest.

Edges are smooth functions of friction as long as the zones stay the same.  Solutions from scratch
at a few frictions bound the stretches of equal zones.  Between them edges are predicted, and
corrected by Newton's method on the loose rule for many frictions at once; every one is checked for
Coulomb's law.  What finer rules change is small and smooth: it is computed at a few frictions,
which are checked once more, and interpolated between them.  Where a check or Newton's method
fails, zones have changed, and that friction is solved from scratch.
"""

from __future__ import annotations

from bisect import bisect
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from time import perf_counter

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.batches import (
    LOOSELY,
    Predicted,
    batches,
    common_load,
    followed,
    linearised,
    located,
)
from semianalytic.edges import FARTHEST, NUDGE, Edges, edges_of, moves
from semianalytic.errors import SceneError
from semianalytic.interpolation import fits, interpolated, lagrange
from semianalytic.panels import Rule, rule_for
from semianalytic.profile import Profile
from semianalytic.rayleigh import Array
from semianalytic.scene import Scene
from semianalytic.solution import Solution, Statistics
from semianalytic.solver import (
    SAFETY,
    frictionless,
    loose_tolerance,
    scaled_load,
    slip_zones,
    solve,
)
from semianalytic.zones import ZoneFields

FROM_SCRATCH, COMPUTED, INTERPOLATED = "from scratch", "computed", "interpolated"

_FIRST = 4  # frictions solved from scratch to begin with,
_EXPLORED = 1e-3  # to this accuracy where more is wanted
_STENCIL = 3  # known frictions to either side used to predict
_FEWEST = 7  # frictions between two sets of zones that are tried with both
_BETWEEN = 7  # frictions tried at once between two with the same set of zones
_FINEST = 3  # gaps up to this are halved
_ROUGH = 0.1  # doubt of predictions from which another friction is located first
_SPARSE, _WAVES = 40, 2  # or beside that many others; this is done at most that often
_BENT = 0.2  # doubt of predictions by slopes, over how far they bend
_NODES = 8  # frictions of one set of zones that are computed before the rest is interpolated
_WIDEST, _NARROWEST = 8, 4  # computed frictions to interpolate through


@dataclass(frozen=True)
class Sweep:
    """Solutions of one scene with different friction coefficients.

    Attributes
    ----------
    scene : Scene
        The scene; its own friction plays no part.
    friction : (n,) array
    solutions : tuple of Solution, one per friction
    origin : tuple of str, one per friction
        "from scratch": solved without help from neighbours; "computed": edges corrected from a
        prediction, and checked like those from scratch; "interpolated" between such with the
        same zones, edges and Coulomb's law checked on the loose rule alone.
    """

    scene: Scene
    friction: Array
    solutions: tuple[Solution, ...]
    origin: tuple[str, ...]

    @property
    def from_scratch(self) -> np.ndarray:
        """(n,) which solutions were solved without help from their neighbours."""
        return np.array([origin == FROM_SCRATCH for origin in self.origin], dtype=bool)

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
class _Known:
    """Zones found at one friction: the unknowns, the inverse Jacobian on the loose rule (None
    where not yet formed), the tolerance of their rule and the error estimate."""

    edges: Edges
    unknowns: Array
    inverse: Array | None
    wanted: float
    estimate: float
    slope: Array | None = None  # of the unknowns over friction, where solved from scratch
    batch: tuple[int, ...] = ()  # with which it was located
    rule: Rule | None = None  # on which they were found, where not that of the tolerance
    contraction: float = 0.0  # what a step with the inverse Jacobian leaves of itself


def sweep(scene: Scene, friction: ArrayLike, rtol: float = 1e-8) -> Sweep:
    """Solve a scene for many friction coefficients, faster than one by one: the more, the faster.

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
        Solutions that are "from scratch" or "computed" have passed the same checks as that of
        `solve`.  Those "interpolated" lie between two such with the same zones; their edges are
        exact on the loose rule, where their Coulomb inequalities were checked to 1e-3, and what
        finer rules change is interpolated, with an error estimate from the difference of
        interpolations through fewer and more neighbours.

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
    return Sweep(scene, values, solutions, tuple(followed.origin[i] for i in place))


class _Sweeping:
    """Solutions so far of scenes with ascending friction, and the zones they may lend."""

    def __init__(self, scenes: Sequence[Scene], rtol: float) -> None:
        self.scenes, self.rtol = scenes, rtol
        self.friction = np.array([scene.friction for scene in scenes])
        self.unit = min((scaled_load(scene)[1] for scene in scenes), default=1.0)
        self.solutions: dict[int, Solution] = {}
        self.origin: dict[int, str] = {}
        self.guess: dict[int, _Known] = {}  # zones that may be lent
        self.loose: dict[int, _Known] = {}  # with edges that are exact on the loose rule
        self.known: dict[int, _Known] = {}  # as solved or computed
        self.tried: set[tuple[Edges, int]] = set()
        self.stencils: set[tuple[int, ...]] = set()  # that were interpolated through

    def run(self) -> None:
        """Solve all scenes."""
        count = len(self.scenes)
        if not count:
            return
        self._solve(count - 1)
        first = np.linspace(0, count - 1, min(count, _FIRST)).round().astype(int)
        for i in first[:-1].tolist():
            self._explore(i)
        self._bound()
        for _ in range(_WAVES):
            for edges, targets in self._rough().items():
                self._locate(edges, targets, max(self.rtol, _EXPLORED), self.guess)
        for choose in (self._nearest, self._other):
            for edges, targets in choose().items():
                self._locate(edges, targets, self.rtol, self.loose)
        for edges, targets in self._chosen().items():
            self._compute(edges, targets)
        for i in range(count):
            if i not in self.loose and i not in self.solutions:
                self._solve(i)
        while len(self.solutions) < count:
            self._interpolate()
            for edges, targets in self._left_over().items():
                self._compute(edges, targets)

    def _gaps(self, nodes: Iterable[int]) -> list[tuple[int, int, list[int]]]:
        """Neighbours among `nodes`, and the frictions between that are still open."""
        gaps = []
        for i, j in pairwise(sorted(nodes)):
            inside = [k for k in range(i + 1, j) if k not in self.solutions]
            if inside:
                gaps.append((i, j, inside))
        return gaps

    def _guessed(self, i: int) -> Edges | None:
        return self.guess[i].edges if i in self.guess else None

    def _bound(self) -> None:
        """Halve the frictions between different sets of zones by solutions from scratch."""
        middles = [-1]
        while middles:
            middles = [
                inside[len(inside) // 2]
                for left, right, inside in self._gaps(self.guess.keys() | self.solutions.keys())
                if self._guessed(left) != self._guessed(right) and len(inside) > _FEWEST
            ]
            for i in middles:
                self._explore(i)

    def _rough(self) -> dict[Edges, list[int]]:
        """A few frictions between equal sets of zones where predictions are rough."""
        chosen: dict[Edges, list[int]] = {}
        for left, right, inside in self._gaps(self.guess):
            edges = self.guess[left].edges
            if edges == self.guess[right].edges and edges.segments:
                middle = self._predicted(self._lenders(edges), inside[len(inside) // 2])
                if len(inside) > _SPARSE or not middle.doubt < _ROUGH:
                    chosen.setdefault(edges, []).extend(_spread(inside))
        return chosen

    def _nearest(self) -> dict[Edges, list[int]]:
        """All frictions, by the edges of the nearest ones."""
        chosen: dict[Edges, list[int]] = {}
        for left, right, inside in self._gaps(self.guess.keys() | self.solutions.keys()):
            half = (len(inside) + 1) // 2
            for end, targets in ((left, inside[:half]), (right, inside[half:])):
                if end in self.guess:
                    chosen.setdefault(self.guess[end].edges, []).extend(targets)
        for i, guess in self.guess.items():
            chosen.setdefault(guess.edges, []).append(i)
        return chosen

    def _other(self) -> dict[Edges, list[int]]:
        """Frictions for which the edges of the nearest ones do not do, by those beyond."""
        chosen: dict[Edges, list[int]] = {}
        for left, right, inside in self._gaps(self.loose.keys() | self.solutions.keys()):
            for end in (left, right):
                edges = self._guessed(end)
                if edges is not None:
                    fresh = [i for i in inside if (edges, i) not in self.tried]
                    chosen.setdefault(edges, []).extend(fresh)
        return chosen

    def _locate(
        self, edges: Edges, targets: list[int], rtol: float, found_at: dict[int, _Known]
    ) -> None:
        """Try one set of zones at some frictions on the loose rule."""
        targets = sorted(i for i in set(targets) if i not in self.loose)
        targets = [i for i in targets if fits(edges, self.scenes[i])]
        if not targets:
            return
        self.tried |= {(edges, i) for i in targets if found_at is self.loose}
        nodes = self._lenders(edges)
        predicted = [self._predicted(nodes, i) for i in targets]
        for batch in batches(edges, [one.unknowns for one in predicted], LOOSELY):
            chosen = [targets[j] for j in batch]
            load = common_load([self.scenes[i] for i in chosen], self.unit)
            # Edges that cross a cut of the panels on their way give no numbers, and are dropped.
            with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
                found = located(edges, [predicted[j] for j in batch], load, rtol)
            group = tuple(chosen[j] for j in np.flatnonzero(found.sound))
            for j in np.flatnonzero(found.sound):
                i, wanted, left = chosen[j], predicted[batch[j]].wanted, float(found.estimate[j])
                known = _Known(
                    edges,
                    found.unknowns[:, j],
                    found.inverse[j],
                    wanted,
                    left,
                    batch=group,
                    contraction=float(found.contraction[j]),
                )
                found_at[i] = self.guess[i] = known

    def _chosen(self) -> dict[Edges, list[int]]:
        """Frictions to compute first, by their edges: the outermost two and some between."""
        chosen: dict[Edges, list[int]] = {}
        for some in dict.fromkeys(self.loose[i].batch for i in sorted(self.loose)):
            share = (1 - np.cos(np.linspace(0, np.pi, _NODES))) / 2
            places = {0, 1, len(some) - 2, len(some) - 1}
            places |= set((share * (len(some) - 1)).round().astype(int).tolist())
            nodes = [some[k] for k in sorted(places) if 0 <= k < len(some)]
            open_ones = [i for i in nodes if i not in self.solutions]
            chosen.setdefault(self.loose[some[0]].edges, []).extend(open_ones)
        return chosen

    def _left_over(self) -> dict[Edges, list[int]]:
        """Frictions to compute next, by their edges."""
        chosen: dict[Edges, list[int]] = {}
        for _, _, inside in self._gaps(self._nodes()):
            for i in _spread(inside):
                chosen.setdefault(self.loose[i].edges, []).append(i)
        return chosen

    def _nodes(self) -> list[int]:
        """Frictions in order that were solved, not interpolated."""
        return sorted(i for i, origin in self.origin.items() if origin != INTERPOLATED)

    def _explore(self, i: int) -> None:
        """Find the zones of a scene from scratch, no finer than needed to lend them."""
        solution = solve(self.scenes[i], rtol=max(self.rtol, _EXPLORED))
        if solution.status != "converged" or frictionless(self.scenes[i]):
            self._solve(i)
        else:
            self._lend(i, solution)

    def _solve(self, i: int) -> None:
        """Solve a scene from scratch."""
        solution = solve(self.scenes[i], rtol=self.rtol)
        self.origin[i], self.solutions[i] = FROM_SCRATCH, solution
        if solution.status == "converged" and not frictionless(self.scenes[i]):
            self._lend(i, solution)
            self.known[i] = self.guess[i]

    def _lend(self, i: int, solution: Solution) -> None:
        fields, estimate = solution.profile.fields, solution.error_estimate
        edges, unknowns = edges_of(fields.factors, fields.zones)
        tolerance = fields.rule.tolerance
        wanted = min(1.0, tolerance / estimate) * self.rtol / 10
        self.guess[i] = _Known(edges, unknowns, None, wanted, estimate)

    def _lenders(self, edges: Edges) -> list[int]:
        """Frictions in order that are known to have some edges, and their Jacobians."""
        nodes = sorted(i for i, known in self.guess.items() if known.edges == edges)
        new = [i for i in nodes if self.guess[i].inverse is None]
        rule = rule_for(loose_tolerance(self.rtol))
        for batch in batches(edges, [self.guess[i].unknowns for i in new]):
            chosen = [new[j] for j in batch]
            start = np.array([self.guess[i].unknowns for i in chosen]).T.reshape(-1, len(chosen))
            inverse, slope = np.zeros((len(chosen), 0, 0)), start
            if edges.segments:
                step = NUDGE * self.friction[chosen]
                scenes = [self.scenes[i] for i in chosen]
                beside = [
                    replace(scene, friction=float(scene.friction + h))
                    for scene, h in zip(scenes, step, strict=True)
                ]
                inverse, values = linearised(edges, start, common_load(scenes, self.unit), rule)
                change = edges.mismatch(start, common_load(beside, self.unit), rule) - values
                slope = -moves(inverse, change) / step
            for i, one, gain in zip(chosen, inverse, slope.T, strict=True):
                self.guess[i] = replace(self.guess[i], inverse=one, slope=gain)
        return nodes

    def _lent(self, nodes: list[int], i: int) -> Array:
        """Inverse Jacobian at a friction from the nearest of `nodes`."""
        place = bisect(nodes, i)
        pair = nodes[max(0, place - 1) : place + 1]
        if len(pair) == 1 or pair[0] == i:
            pair = pair[:1]
        weights = lagrange(self.friction[pair], self.friction[i])
        return np.asarray(
            sum(w * self.guess[j].inverse for w, j in zip(weights, pair, strict=True))
        )

    def _predicted(self, nodes: list[int], i: int) -> Predicted:
        """Zones at a friction from the known ones nearest to it, by Lagrange's formula."""
        place = bisect(nodes, i)
        pair = [self.guess[j] for j in nodes[max(0, place - 1) : place + 1]]
        if len(pair) == 2 and all(one.slope is not None for one in pair):
            return self._between(nodes, i)
        near = nodes[max(0, place - _STENCIL) : place + _STENCIL]
        stencil = sorted(near, key=lambda j: abs(self.friction[j] - self.friction[i]))
        known, count = [self.guess[j] for j in stencil], len(stencil)
        unknowns = np.array([one.unknowns for one in known])
        value = lagrange(self.friction[stencil], self.friction[i]) @ unknowns
        doubt, first = np.inf, known[0]
        if count == 1 and first.slope is not None:
            value = value + first.slope * (self.friction[i] - self.friction[stencil[0]])
        elif count > 2:
            fewer = lagrange(self.friction[stencil[: count - 2]], self.friction[i])
            doubt = float(np.abs(value - fewer @ unknowns[: count - 2]).max(initial=0.0))
        value = np.clip(value, -FARTHEST, FARTHEST)
        return Predicted(value, self._lent(nodes, i), doubt, first.wanted)

    def _between(self, nodes: list[int], i: int) -> Predicted:
        """Zones between two frictions at which their slopes are known, by Hermite's formula."""
        place = bisect(nodes, i)
        ends = nodes[place - 1 : place + 1]
        one, other = (self.guess[j] for j in ends)
        start, stop = self.friction[ends]
        width, s = stop - start, (self.friction[i] - start) / (stop - start)
        chord = other.unknowns - one.unknowns
        bend = (
            s
            * (1 - s)
            * ((1 - s) * (one.slope * width - chord) - s * (other.slope * width - chord))
        )
        value = one.unknowns + s * chord + bend
        doubt = _BENT * float(np.abs(bend).max(initial=0.0))
        return Predicted(value, self._lent(nodes, i), doubt, one.wanted)

    def _compute(self, edges: Edges, targets: list[int]) -> None:
        """Take edges that are exact on the loose rule to finer ones; solve those that fail."""
        for batch in batches(edges, [self.loose[i].unknowns for i in targets]):
            start = perf_counter()
            chosen = [targets[j] for j in batch]
            predicted = [self._located(i) for i in chosen]
            load = common_load([self.scenes[i] for i in chosen], self.unit)
            with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
                found = followed(edges, predicted, load, self.rtol)
            seconds = (perf_counter() - start) / len(batch)
            for j, i in enumerate(chosen):
                if found.sound[j]:
                    estimate, wanted = float(found.estimate[j]), float(found.wanted[j])
                    self.known[i] = _Known(
                        edges,
                        found.unknowns[:, j],
                        found.inverse[j],
                        wanted,
                        estimate,
                        rule=found.rules[j],
                    )
                    self.origin[i] = COMPUTED
                    self._add(i, self.known[i], found.steps, found.nodes, seconds)
                else:
                    self._solve(i)

    def _located(self, i: int) -> Predicted:
        """Edges on the loose rule as a prediction, and the rule that the nearest computed need."""
        one = self.loose[i]
        assert one.inverse is not None
        computed = [j for j in one.batch if j in self.known]
        nearest = min(computed, key=lambda j: abs(j - i), default=None)
        wanted = one.wanted if nearest is None else self.known[nearest].wanted
        doubt = loose_tolerance(self.rtol)
        return Predicted(one.unknowns, one.inverse, doubt, wanted, one.contraction)

    def _add(self, i: int, known: _Known, steps: int, nodes: int, seconds: float) -> None:
        scene, edges = self.scenes[i], known.edges
        load, stress = scaled_load(scene)
        zones = edges.zones(known.unknowns)
        # The error was estimated on the rule of a batch, which is longer than one set needs.
        rule = known.rule or rule_for(known.wanted)
        profile = Profile(ZoneFields(edges.factors, load, zones, rule))
        stages = {"zones": 0.0, "edges": seconds, "check": 0.0}
        statistics = Statistics(0, steps, 1, len(known.unknowns), nodes, stages)
        zones_in_velocity = slip_zones(scene, profile)
        self.solutions[i] = Solution(
            scene, zones_in_velocity, "converged", known.estimate, statistics, profile, stress
        )

    def _edges(self, i: int) -> Edges | None:
        return self.known[i].edges if i in self.known else None

    def _interpolate(self) -> None:
        """Fill in frictions between computed ones with the same zones, where that is good."""
        for left, right, inside in self._gaps(self._nodes()):
            edges = self._edges(left)
            if edges is None or edges != self._edges(right):
                continue
            some = self.loose[inside[0]].batch
            middle = (self.friction[left] + self.friction[right]) / 2
            nodes = sorted(
                (i for i in some if self._edges(i) == edges),
                key=lambda i: abs(float(self.friction[i]) - middle),
            )[:_WIDEST]
            inside = [i for i in inside if i in some]
            enough = len(nodes) >= (_NARROWEST if edges.segments else 1)
            if enough and (left, *nodes) not in self.stencils:
                self.stencils.add((left, *nodes))
                self._fill(edges, nodes, inside)

    def _fill(self, edges: Edges, stencil: list[int], inside: list[int]) -> None:
        """Edges on the loose rule with interpolated corrections, if their error is below rtol."""
        start = perf_counter()
        known = [self.known[j] for j in stencil]
        base = [self.loose[j].unknowns for j in stencil]
        at = (self.friction[stencil], np.array(base))
        to = (self.friction[inside], np.array([self.loose[i].unknowns for i in inside]))
        unknowns = np.array([one.unknowns for one in known])
        worth = np.array([one.estimate for one in known])
        values, estimate = interpolated(edges, *at, unknowns - at[1], *to, worth)
        estimate = estimate + SAFETY * max(self.loose[i].estimate for i in [*stencil, *inside])
        good = estimate <= self.rtol
        if edges.segments:
            good &= edges.admits(values.T)
        wanted = min(one.wanted for one in known)
        rules = [one.rule or rule_for(one.wanted) for one in known]
        rule = Rule(min(one.spacing for one in rules), max(one.reach for one in rules))
        seconds = (perf_counter() - start) / len(inside)
        for k in np.flatnonzero(good):
            i = inside[k]
            self.origin[i] = INTERPOLATED
            found = _Known(edges, values[k], None, wanted, float(estimate[k]), rule=rule)
            self._add(i, found, 0, 0, seconds)


def _spread(inside: list[int]) -> list[int]:
    """A few of some frictions."""
    count = len(inside)
    parts = min(_BETWEEN, -(-count // _FINEST)) if count > _FINEST else 1
    step = count // (parts + 1)
    return inside[step :: step + 1][:parts]
