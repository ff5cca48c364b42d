"""A scene over many friction coefficients: zones found at a few, followed through the rest.

Edges are smooth functions of friction as long as the zones stay the same.  Beside frictions
solved from scratch they are predicted and corrected by Newton's method on many frictions at
once; every one is checked for Coulomb's law.  Where the check or Newton's method fails, zones
have changed, and that friction is solved from scratch.  Where interpolations between them agree
to the wanted accuracy, the frictions between are filled in.
"""

from __future__ import annotations

from bisect import bisect
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from time import perf_counter

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.halfplane.rayleigh import Array
from semianalytic.halfplane.rules import rule_for
from semianalytic.scene.checks import checked_number
from semianalytic.scene.errors import SceneError
from semianalytic.scene.scene import Scene
from semianalytic.selfsimilar.edges import Edges, edges_of, moves
from semianalytic.selfsimilar.estimate import loose_tolerance
from semianalytic.selfsimilar.load import common_load, scaled_load
from semianalytic.selfsimilar.profile import Profile
from semianalytic.selfsimilar.solution import Solution, Statistics
from semianalytic.selfsimilar.solver import slip_zones, solve
from semianalytic.selfsimilar.tuning import FARTHEST, NUDGE
from semianalytic.selfsimilar.zones import ZoneFields
from semianalytic.sweeps.batches import (
    AT_ONCE,
    TRUSTED,
    Predicted,
    batches,
    followed,
    linearised,
)
from semianalytic.sweeps.interpolation import confirmed, fits, interpolated, lagrange

FROM_SCRATCH, COMPUTED, INTERPOLATED = "from scratch", "computed", "interpolated"

_FIRST = 7  # frictions solved from scratch to begin with
_STENCIL = 3  # known frictions to either side used to predict
_BETWEEN = 7  # frictions tried at once between two with the same set of zones
_FINEST = 3  # gaps up to this are halved
_FEWEST = 3  # frictions between two sets of zones for which neither is tried
_BESIDE = 4  # frictions tried at once from either side of a change
_WIDEST, _NARROWEST = 8, 5  # known frictions to interpolate through


@dataclass(frozen=True, eq=False)
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
        `solve`.  Those "interpolated" lie between two such with the same zones; their Coulomb
        inequalities and their edges were checked on the loose rule only (to 1e-3 and, in edge
        unknowns, 1e-2); finer than that they rest on the difference of interpolations through
        fewer and more neighbours.

    Raises
    ------
    SceneError
        If friction is not one-dimensional or not of numbers, a value of it does not make a scene,
        or rtol is out of range.
    TensionError
        If the contact pressure would turn tensile.
    """
    given = np.asarray(friction, dtype=object)
    if given.ndim != 1:
        raise SceneError(f"friction must be one-dimensional, got the shape {given.shape}.")
    values = np.array([checked_number("sweep: friction", value) for value in given], dtype=float)
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
        self.known: dict[int, _Known] = {}
        self.tried: set[tuple[Edges | None, int, tuple[int, ...]]] = set()
        self.pending: dict[int, _Known] = {}  # interpolated, not yet confirmed
        self.refused: set[int] = set()  # interpolated, but not confirmed
        self.stencils: set[tuple[int, ...]] = set()  # that were interpolated through

    def run(self) -> None:
        """Solve all scenes."""
        count = len(self.scenes)
        if not count:
            return
        for i in np.unique(np.linspace(0, count - 1, min(count, _FIRST)).round().astype(int)):
            self._solve(int(i))
        while len(self.solutions) < count:
            self._interpolate()
            proposed = self._proposed()
            for edges, targets in proposed.items():
                self._follow(edges, targets)
            if len(self.solutions) + len(self.pending) == count:
                self._confirm()

    def _nodes(self) -> list[int]:
        """Frictions in order that were solved, not interpolated."""
        return sorted(i for i, origin in self.origin.items() if origin != INTERPOLATED)

    def _gaps(self) -> list[tuple[int, int, list[int]]]:
        """Neighbours among `_nodes`, and the frictions between that are still open."""
        gaps, done = [], self.solutions.keys() | self.pending.keys()
        for i, j in pairwise(self._nodes()):
            inside = [k for k in range(i + 1, j) if k not in done]
            if inside:
                gaps.append((i, j, inside))
        return gaps

    def _edges(self, i: int) -> Edges | None:
        return self.known[i].edges if i in self.known else None

    def _proposed(self) -> dict[Edges, list[int]]:
        """Scenes to try next, by the edges they may have.

        Between equal sets of zones a few, between different ones a few from either side.
        What has been tried in vain is not tried again: the middle is then solved from scratch.
        """
        proposed: dict[Edges, list[int]] = {}
        between: dict[Edges, list[int]] = {}
        for left, right, inside in self._gaps():
            at_left, at_right = self._edges(left), self._edges(right)
            count = len(inside)
            if at_left == at_right:
                if at_left is not None:
                    between.setdefault(at_left, []).extend(inside)
                parts = min(_BETWEEN, -(-count // _FINEST)) if count > _FINEST else 1
                step = count // (parts + 1)
                tries = [(at_left, left, inside[step :: step + 1][:parts])]
            elif count < _FEWEST:
                tries = []
            else:
                step = -(-count // (2 * _BESIDE))
                offsets = [k * step - 1 for k in range(1, _BESIDE + 1) if k * step <= count]
                from_left = [inside[k] for k in offsets]
                from_right = [inside[-1 - k] for k in offsets]
                tries = [(at_left, left, from_left), (at_right, right, from_right)]
            keyed = [(edges, end, tuple(targets)) for edges, end, targets in tries]
            fresh = [one for one in keyed if one not in self.tried]
            self.tried |= set(fresh)
            for edges, _, targets in fresh:
                if edges is not None:
                    fitting = [i for i in targets if fits(edges, self.scenes[i])]
                    proposed.setdefault(edges, []).extend(fitting)
            if not fresh:
                self._solve(inside[count // 2])
        for edges, some in proposed.items():  # a batch costs little more for being full
            every = {*some, *between.get(edges, [])}
            if len(every) <= AT_ONCE:
                some[:] = [i for i in every if fits(edges, self.scenes[i])]
        return proposed

    def _solve(self, i: int) -> None:
        """Solve a scene from scratch."""
        solution = solve(self.scenes[i], rtol=self.rtol)
        self.origin[i] = FROM_SCRATCH
        self.solutions[i] = solution
        fields = solution.profile.fields
        if solution.status == "converged" and not fields.load.frictionless:
            edges, unknowns = edges_of(fields.factors, fields.zones)
            wanted, estimate = fields.rule.tolerance, solution.error_estimate
            self.known[i] = _Known(edges, unknowns, None, wanted, estimate)

    def _lenders(self, edges: Edges) -> list[int]:
        """Frictions in order that are known to have some edges; one at least has a Jacobian."""
        nodes = sorted(i for i, known in self.known.items() if known.edges == edges)
        if any(self.known[i].inverse is not None for i in nodes):
            return nodes
        rule = rule_for(loose_tolerance(self.rtol))
        for batch in batches(edges, [self.known[i].unknowns for i in nodes]):
            chosen = [nodes[j] for j in batch]
            start = np.array([self.known[i].unknowns for i in chosen]).T.reshape(-1, len(chosen))
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
                self.known[i] = replace(self.known[i], inverse=one, slope=gain)
        return nodes

    def _lent(self, nodes: list[int], i: int) -> Array:
        """Inverse Jacobian at a friction from the nearest of `nodes` that have it."""
        with_one = [j for j in nodes if self.known[j].inverse is not None]
        place = bisect(with_one, i)
        pair = with_one[max(0, place - 1) : place + 1]
        if len(pair) == 1 or pair[0] == i:
            pair = pair[:1]
        weights = lagrange(self.friction[pair], self.friction[i])
        return np.asarray(
            sum(w * self.known[j].inverse for w, j in zip(weights, pair, strict=True))
        )

    def _predicted(self, nodes: list[int], i: int) -> Predicted:
        """Zones at a friction from the known ones nearest to it, by Lagrange's formula."""
        place = bisect(nodes, i)
        near = nodes[max(0, place - _STENCIL) : place + _STENCIL]
        stencil = sorted(near, key=lambda j: abs(self.friction[j] - self.friction[i]))
        known, count = [self.known[j] for j in stencil], len(stencil)
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

    def _follow(self, edges: Edges, targets: list[int]) -> None:
        """Try one set of zones at some frictions; keep what fulfils Coulomb's law."""
        nodes = self._lenders(edges)
        targets = sorted(i for i in set(targets) if i not in self.solutions)
        predicted = [self._predicted(nodes, i) for i in targets]
        trusted = [one.doubt < TRUSTED for one in predicted]
        for batch in batches(edges, [one.unknowns for one in predicted], trusted):
            start = perf_counter()
            chosen = [targets[j] for j in batch]
            load = common_load([self.scenes[i] for i in chosen], self.unit)
            # Edges that cross a cut of the panels on their way give no numbers, and are dropped.
            with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
                found = followed(edges, [predicted[j] for j in batch], load, self.rtol)
            seconds = (perf_counter() - start) / len(batch)
            for j in np.flatnonzero(found.sound):
                i, estimate = chosen[j], float(found.estimate[j])
                known = _Known(
                    edges, found.unknowns[:, j], found.inverse[j], float(found.wanted[j]), estimate
                )
                self.known[i], self.origin[i] = known, COMPUTED
                self._add(i, known, found.steps, found.nodes, seconds)

    def _add(self, i: int, known: _Known, steps: int, nodes: int, seconds: float) -> None:
        scene, edges = self.scenes[i], known.edges
        load, stress = scaled_load(scene)
        zones = edges.zones(known.unknowns)
        profile = Profile(ZoneFields(edges.factors, load, zones, rule_for(known.wanted)))
        stages = {"zones": 0.0, "edges": seconds, "check": 0.0}
        statistics = Statistics(0, steps, 1, len(known.unknowns), nodes, stages)
        zones_in_velocity = slip_zones(scene, profile)
        self.solutions[i] = Solution(
            scene, zones_in_velocity, "converged", known.estimate, statistics, profile, stress
        )

    def _interpolate(self) -> None:
        """Fill in frictions between known ones with the same zones, where that is good enough."""
        for left, right, inside in self._gaps():
            edges = self._edges(left)
            inside = [i for i in inside if i not in self.refused]
            if edges is None or edges != self._edges(right) or not inside:
                continue
            stencil = self._stencil(left, right)
            if stencil and (left, *stencil) not in self.stencils:
                self.stencils.add((left, *stencil))
                self.pending.update(self._between(stencil, left, right, inside))

    def _stencil(self, left: int, right: int) -> list[int]:
        """Known frictions around a gap with the same zones all through, nearest to it first;
        none if they are too few or the gap borders on other zones."""
        nodes = self._nodes()
        edges, place = self._edges(left), nodes.index(left)
        below, above = place, place + 1
        while below > 0 and place - below < _WIDEST and self._edges(nodes[below - 1]) == edges:
            below -= 1
        last = len(nodes) - 1
        while above < last and above - place < _WIDEST and self._edges(nodes[above + 1]) == edges:
            above += 1
        if (below == place and left > 0) or (above == place + 1 and right < len(self.scenes) - 1):
            return []
        middle = (self.friction[left] + self.friction[right]) / 2
        stencil = sorted(
            nodes[below : above + 1], key=lambda j: abs(float(self.friction[j]) - middle)
        )[:_WIDEST]
        few = edges is not None and bool(edges.segments) and len(stencil) < _NARROWEST
        return [] if few else stencil

    def _between(
        self, stencil: list[int], left: int, right: int, inside: list[int]
    ) -> dict[int, _Known]:
        """Interpolated zones whose error estimate is below rtol."""
        known = [self.known[j] for j in stencil]
        edges, wanted = known[0].edges, min(self.known[left].wanted, self.known[right].wanted)
        unknowns = np.array([one.unknowns for one in known])
        noise = max(one.estimate for one in known)
        values, estimate = interpolated(
            edges, self.friction[stencil], unknowns, self.friction[inside], noise, self.rtol
        )
        good = estimate <= self.rtol
        if edges.segments:
            good &= edges.admits(values.T)
        return {
            inside[k]: _Known(edges, values[k], None, wanted, float(estimate[k]))
            for k in np.flatnonzero(good)
        }

    def _confirm(self) -> None:
        """Keep interpolated zones that fulfil Coulomb's law, and whose edges hold, on the loose
        rule."""
        by_edges: dict[Edges, list[int]] = {}
        for i in sorted(self.pending):
            by_edges.setdefault(self.pending[i].edges, []).append(i)
        loose = loose_tolerance(self.rtol)
        for edges, targets in by_edges.items():
            nodes = self._lenders(edges)
            for batch in batches(edges, [self.pending[i].unknowns for i in targets]):
                start, chosen = perf_counter(), [targets[j] for j in batch]
                load = common_load([self.scenes[i] for i in chosen], self.unit)
                columns = [self.pending[i].unknowns for i in chosen]
                inverse = np.array([self._lent(nodes, i) for i in chosen])
                unknowns = np.array(columns).T.reshape(-1, len(chosen))
                sound, size = confirmed(edges, unknowns, inverse, load, loose)
                seconds = (perf_counter() - start) / len(batch)
                for i, kept in zip(chosen, sound, strict=True):
                    if kept:
                        self.origin[i] = INTERPOLATED
                        self._add(i, self.pending[i], 0, size, seconds)
                    else:
                        self.refused.add(i)
        self.pending.clear()
