"""A scene over many friction coefficients: zones found at a few, followed through the rest.

Edges are smooth functions of friction as long as the zones stay the same.  Beside frictions
solved from scratch they are predicted and corrected by Newton's method on many frictions at
once; every one is checked for Coulomb's law.  Where the check or Newton's method fails, zones
have changed, and that friction is solved from scratch.  Where interpolations between them agree
to the wanted accuracy, the frictions between are filled in.
"""

from __future__ import annotations

from bisect import bisect
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from time import perf_counter

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.coulomb import admissible
from semianalytic.edges import FARTHEST, NUDGE, Edges, edges_of, moves
from semianalytic.errors import SceneError
from semianalytic.panels import Rule, rule_for
from semianalytic.profile import Profile
from semianalytic.rayleigh import Array
from semianalytic.scene import Scene
from semianalytic.solution import Solution, Statistics
from semianalytic.solver import (
    SAFETY,
    difference,
    edge_shift,
    frictionless,
    loose_tolerance,
    scaled_load,
    slip_zones,
    solve,
)
from semianalytic.zones import Load, ZoneFields

FROM_SCRATCH, COMPUTED, INTERPOLATED = "from scratch", "computed", "interpolated"

_FIRST = 7  # frictions solved from scratch to begin with
_AT_ONCE = 24  # sets of zones in one batch: more leave the processor's cache
_STENCIL = 3  # known frictions to either side used to predict
_MOST_STEPS = 4
_LONGEST_MOVE = 1.5
_NEAR = 2e-3  # move of an edge unknown after which its Jacobian is kept
_SLOW = 0.5  # Newton moves that shrink less are given up
_CONTRACTION, _LEAST_CONTRACTION = 20.0, 1e-3  # of chord steps, by the doubt of a prediction
_TRUSTED = 1e-3  # doubt of a prediction that needs no Newton's method
_BETWEEN = 7  # frictions tried at once between two with the same set of zones
_FINEST = 3  # gaps up to this are halved
_FEWEST = 3  # frictions between two sets of zones for which neither is tried
_BESIDE = 4  # frictions tried at once from either side of a change
_MOST_REFINEMENTS = 3
_LOOSEST = 1e-4  # tolerance of that check: neighbours lend zones where a new one just begins
_STRICTNESS = 10  # of the check of Coulomb's law; `solve`, which is asked next, uses 100
_WIDEST, _NARROWEST = 8, 5  # known frictions to interpolate through
_LOOSE_CHECK, _LOOSE_MOVE = 10, 100  # of interpolated zones, in tolerances of the loose rule
_CONVERGING = 0.5  # differences that shrink less are no estimate
_CLOSE = 1e-3  # to a front, in slowness: differences are then formed there
_PREDICTED = 0.2  # doubt of a prediction that needs no full Newton's method
_CHORDS = 4  # steps with lent Jacobians before they are formed anew
_WITHOUT_JACOBIAN = 1e-5  # rtol from which those steps suffice


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


@dataclass(frozen=True)
class _Predicted:
    """Unknowns at one friction and the inverse Jacobian from those near it, how far they may be
    off, and the tolerance of the rule that is likely needed."""

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
                    fitting = [i for i in targets if _fits(edges, self.scenes[i])]
                    proposed.setdefault(edges, []).extend(fitting)
            if not fresh:
                self._solve(inside[count // 2])
        for edges, some in proposed.items():  # a batch costs little more for being full
            every = {*some, *between.get(edges, [])}
            if len(every) <= _AT_ONCE:
                some[:] = [i for i in every if _fits(edges, self.scenes[i])]
        return proposed

    def _solve(self, i: int) -> None:
        """Solve a scene from scratch."""
        solution = solve(self.scenes[i], rtol=self.rtol)
        self.origin[i] = FROM_SCRATCH
        self.solutions[i] = solution
        if solution.status == "converged" and not frictionless(self.scenes[i]):
            fields = solution.profile.fields
            edges, unknowns = edges_of(fields.factors, fields.zones)
            wanted, estimate = fields.rule.tolerance, solution.error_estimate
            self.known[i] = _Known(edges, unknowns, None, wanted, estimate)

    def _lenders(self, edges: Edges) -> list[int]:
        """Frictions in order that are known to have some edges; one at least has a Jacobian."""
        nodes = sorted(i for i, known in self.known.items() if known.edges == edges)
        if any(self.known[i].inverse is not None for i in nodes):
            return nodes
        rule = rule_for(loose_tolerance(self.rtol))
        for batch in _batches(edges, [self.known[i].unknowns for i in nodes]):
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
                inverse, values = _linearised(edges, start, _common_load(scenes, self.unit), rule)
                change = edges.mismatch(start, _common_load(beside, self.unit), rule) - values
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
        weights = _lagrange(self.friction[pair], self.friction[i])
        return np.asarray(
            sum(w * self.known[j].inverse for w, j in zip(weights, pair, strict=True))
        )

    def _predicted(self, nodes: list[int], i: int) -> _Predicted:
        """Zones at a friction from the known ones nearest to it, by Lagrange's formula."""
        place = bisect(nodes, i)
        near = nodes[max(0, place - _STENCIL) : place + _STENCIL]
        stencil = sorted(near, key=lambda j: abs(self.friction[j] - self.friction[i]))
        known, count = [self.known[j] for j in stencil], len(stencil)
        unknowns = np.array([one.unknowns for one in known])
        value = _lagrange(self.friction[stencil], self.friction[i]) @ unknowns
        doubt, first = np.inf, known[0]
        if count == 1 and first.slope is not None:
            value = value + first.slope * (self.friction[i] - self.friction[stencil[0]])
        elif count > 2:
            fewer = _lagrange(self.friction[stencil[: count - 2]], self.friction[i])
            doubt = float(np.abs(value - fewer @ unknowns[: count - 2]).max(initial=0.0))
        value = np.clip(value, -FARTHEST, FARTHEST)
        return _Predicted(value, self._lent(nodes, i), doubt, first.wanted)

    def _follow(self, edges: Edges, targets: list[int]) -> None:
        """Try one set of zones at some frictions; keep what fulfils Coulomb's law."""
        nodes = self._lenders(edges)
        targets = sorted(i for i in set(targets) if i not in self.solutions)
        predicted = [self._predicted(nodes, i) for i in targets]
        trusted = [one.doubt < _TRUSTED for one in predicted]
        for batch in _batches(edges, [one.unknowns for one in predicted], trusted):
            start = perf_counter()
            chosen = [targets[j] for j in batch]
            load = _common_load([self.scenes[i] for i in chosen], self.unit)
            # Edges that cross a cut of the panels on their way give no numbers, and are dropped.
            with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
                found = _followed(edges, [predicted[j] for j in batch], load, self.rtol)
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
        values, estimate = _interpolated(
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
            for batch in _batches(edges, [self.pending[i].unknowns for i in targets]):
                start, chosen = perf_counter(), [targets[j] for j in batch]
                load = _common_load([self.scenes[i] for i in chosen], self.unit)
                columns = [self.pending[i].unknowns for i in chosen]
                inverse = np.array([self._lent(nodes, i) for i in chosen])
                unknowns = np.array(columns).T.reshape(-1, len(chosen))
                sound, size = _confirmed(edges, unknowns, inverse, load, loose)
                seconds = (perf_counter() - start) / len(batch)
                for i, kept in zip(chosen, sound, strict=True):
                    if kept:
                        self.origin[i] = INTERPOLATED
                        self._add(i, self.pending[i], 0, size, seconds)
                    else:
                        self.refused.add(i)
        self.pending.clear()


def _confirmed(
    edges: Edges, unknowns: Array, inverse: Array, load: Load, loose: float
) -> tuple[np.ndarray, int]:
    """Whether zones of unknowns (e, k) pass as right on the loose rule, (k,), and its nodes."""
    with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
        fields = ZoneFields(edges.factors, load, edges.zones(unknowns), rule_for(loose))
        sound = admissible(Profile(fields), _LOOSE_CHECK * loose)
        if edges.segments:
            move = np.abs(moves(inverse, fields.mismatch())).max(axis=0)
            sound = sound & (move < _LOOSE_MOVE * loose)
    return sound, fields.panels.jacobian[:, 0].size


def _fits(edges: Edges, scene: Scene) -> bool:
    """Whether zones are open ahead of all waves only where friction is reached there."""
    critical = scaled_load(scene)[0].critical
    return critical if edges.open_ends[0] else not scene.far_slip_rate


def _lagrange(at: Array, to: ArrayLike) -> Array:
    """Weights (..., m) of values at different places `at` (m,) in the polynomial through them,
    at places `to` (...)."""
    own = np.eye(len(at), dtype=bool)
    others = np.where(own, 1.0, np.asarray(to, dtype=float)[..., None, None] - at)
    return np.asarray(np.prod(others / (at[:, None] - at + own), axis=-1))


def _in_friction(at: Array, unknowns: Array, to: Array) -> Array:
    """The polynomial in friction through unknowns (m, e) at frictions `at`, (t, e)."""
    return _lagrange(at, to) @ unknowns


def _in_edge(at: Array, unknowns: Array, to: Array) -> Array:
    """The same with polynomials in the unknown that moves most, friction being one of them.

    Smoother near thresholds, where edges move fast; NaN where that unknown is not monotone.
    """
    order = np.argsort(at)
    which = int(np.argmax(np.ptp(unknowns, axis=0)))
    s = unknowns[:, which]
    steps = np.diff(s[order])
    if not (np.all(steps > 0) or np.all(steps < 0)):
        return np.full((len(to), unknowns.shape[1]), np.nan)
    place = np.interp(to, at[order], s[order])
    nudge = 1e-4 * float(np.ptp(s))
    for _ in range(4):
        beside = np.stack([place, place + nudge, place - nudge])
        now, up, down = _lagrange(s, beside) @ (at - at[0])
        slope = (up - down) / (2 * nudge)
        place = place - (now - (to - at[0])) / np.where(slope == 0, np.nan, slope)
    return _lagrange(s, place) @ unknowns


def _interpolated(
    edges: Edges, at: Array, unknowns: Array, to: Array, noise: float, rtol: float
) -> tuple[Array, Array]:
    """Unknowns (t, e) at frictions `to` through those (m, e) at `at`, the most central first, and
    their error estimates (t,).

    Estimated from the polynomials without the last and the last but one: from the first
    difference if it is well below the second, else from the larger.  The largest estimate `noise`
    of the known adds to it, amplified by the interpolation less the safety it contains.  Of
    polynomials in friction and in an edge the better is taken; the second are tried where the
    first do not reach rtol.
    """
    if not edges.segments:
        return np.zeros((len(to), 0)), np.full(len(to), noise)
    best, least = np.zeros((len(to), len(edges.segments))), np.full(len(to), np.inf)
    amplified = np.maximum(1.0, np.abs(_lagrange(at, to)).sum(axis=1) / SAFETY) * noise
    for through in (_in_friction, _in_edge):
        full, fewer, fewest = (
            np.clip(through(at[:m], unknowns[:m], to), -FARTHEST, FARTHEST)
            for m in (len(at), len(at) - 1, len(at) - 2)
        )
        both = _apart(edges, np.concatenate([full, fewer]), np.concatenate([fewer, fewest]))
        first, second = np.split(both, 2)
        doubt = np.where(first < _CONVERGING * second, first, np.maximum(first, second))
        better = doubt < least
        best[better], least[better] = full[better], doubt[better]
        if np.all(least + amplified <= rtol):
            break
    return best, least + amplified


def _apart(edges: Edges, one: Array, other: Array) -> Array:
    """(t,): how far two interpolations (t, e) are apart, for an error estimate."""
    shift = SAFETY * edge_shift(edges, one.T, other.T)
    return np.maximum(shift, np.abs(one - other).max(axis=1))


def _batches(
    edges: Edges, starts: Sequence[Array], trusted: Sequence[bool] | None = None
) -> Iterator[list[int]]:
    """Sets of zones that may share panels: every edge on one side of every cut, close to one
    front or to none.

    Those whose prediction is trusted come last.
    """
    groups: dict[tuple, list[int]] = {}
    for j, unknowns in enumerate(starts):
        points = edges.points(unknowns)
        sides = [[p.first_below(cut) for cut in edges.factors.cuts] for p in points]
        close = [p.nearest if np.abs(p.parts[p.nearest]).min() < _CLOSE else 0 for p in points]
        key = (*close, *np.ravel(sides).tolist())
        groups.setdefault(key, []).append(j)
    for group in groups.values():
        if trusted is not None:
            group.sort(key=lambda j: trusted[j])
        parts = -(-len(group) // _AT_ONCE)
        yield from (part.tolist() for part in np.array_split(group, parts))


def _common_load(scenes: Sequence[Scene], unit: float) -> Load:
    """Loads of scenes that differ in friction alone, in one unit of stress."""
    scene = scenes[0]
    base, step = scene.base, scene.step
    friction = np.array([[scene.friction] for scene in scenes])
    far = np.array([[scene.far_slip_rate] for scene in scenes])
    return Load(
        friction,
        base.pressure / unit,
        base.shear / unit,
        step.pressure / unit,
        step.shear / unit,
        far * scene.material.shear_impedance / (2 * unit),
    )


def _chosen(load: Load, which: np.ndarray) -> Load:
    """The loads of some sets of zones."""
    friction, far = np.asarray(load.friction), np.asarray(load.far_slip_rate)
    return replace(load, friction=friction[which], far_slip_rate=far[which])


def _linearised(edges: Edges, unknowns: Array, load: Load, rule: Rule) -> tuple[Array, Array]:
    """Inverse Jacobians (k, e, e) and mismatches (e, k) at unknowns (e, k); NaN if singular."""
    size, count = unknowns.shape
    nudges = np.concatenate([np.zeros((size, 1)), NUDGE * np.eye(size)], axis=1)
    neighbours = unknowns[:, :, None] + nudges[:, None, :]
    repeated = _chosen(load, np.repeat(np.arange(count), size + 1))
    values = edges.mismatch(neighbours.reshape(size, -1), repeated, rule)
    values = values.reshape(neighbours.shape)
    jacobian = np.moveaxis(values[..., 1:] - values[..., :1], 0, 1) / NUDGE
    try:
        inverse = np.asarray(np.linalg.inv(jacobian))
    except np.linalg.LinAlgError:
        inverse = np.full_like(jacobian, np.nan)
    return inverse, values[..., 0]


def _newton(edges: Edges, start: Array, load: Load, rule: Rule) -> tuple[Array, Array, Array, int]:
    """Unknowns (e, k) near their places on a rule, inverse Jacobians (k, e, e), the last
    moves (k,), infinite for sets that did not get there, and the steps taken."""
    size, count = start.shape
    unknowns, inverse = start.copy(), np.zeros((count, size, size))
    waiting = np.flatnonzero(edges.admits(unknowns))
    last, previous = np.full(count, np.inf), np.full(count, np.inf)
    step = 0
    while len(waiting) and step < _MOST_STEPS:
        step += 1
        found = _linearised(edges, unknowns[:, waiting], _chosen(load, waiting), rule)
        inverse[waiting] = found[0]
        move = -moves(*found)
        largest = np.abs(move).max(axis=0)
        finite = largest < np.inf
        waiting, move, largest = waiting[finite], move[:, finite], largest[finite]
        if not len(waiting):
            break
        unknowns[:, waiting] += move * np.minimum(1.0, _LONGEST_MOVE / np.maximum(largest, 1e-300))
        admitted = edges.admits(unknowns[:, waiting]) & (largest < _SLOW * previous[waiting])
        previous[waiting] = largest
        last[waiting] = np.where(admitted & (largest < _NEAR), largest, np.inf)
        waiting = waiting[admitted & (largest >= _NEAR)]
    return unknowns, inverse, last, step


def _approached(
    edges: Edges, start: Array, lent: Array, load: Load, rule: Rule
) -> tuple[Array, Array, Array, int]:
    """Broyden steps on a rule from lent inverse Jacobians (k, e, e).

    Unknowns (e, k), or the start where that did not succeed; inverse Jacobians; what a step
    leaves of itself (k,), infinite where it did not succeed; the steps taken.
    """
    count = start.shape[1]
    unknowns, inverse = start.copy(), lent.copy()
    waiting = np.flatnonzero(edges.admits(unknowns) & np.isfinite(lent).all(axis=(1, 2)))
    left, previous = np.full(count, np.inf), np.full(count, 1 / _SLOW)
    move = before = np.zeros((len(start), 0))
    step = 0
    while len(waiting) and step < _CHORDS:
        values = edges.mismatch(unknowns[:, waiting], _chosen(load, waiting), rule)
        if step:
            inverse[waiting] = _updated(inverse[waiting], move, values - before)
        step += 1
        move = -moves(inverse[waiting], values)
        largest = np.abs(move).max(axis=0)
        share = largest / previous[waiting]
        kept = (share < _SLOW) & edges.admits(unknowns[:, waiting] + np.where(share < 1, move, 0))
        waiting, move, before, share = waiting[kept], move[:, kept], values[:, kept], share[kept]
        unknowns[:, waiting] += move
        previous[waiting] = largest[kept]
        arrived = largest[kept] * share < _NEAR if step > 1 else largest[kept] < _NEAR
        left[waiting[arrived]] = share[arrived]
        waiting, move, before = waiting[~arrived], move[:, ~arrived], before[:, ~arrived]
    failed = ~(left < np.inf)
    unknowns[:, failed] = start[:, failed]
    return unknowns, inverse, left, step


def _updated(inverse: Array, move: Array, change: Array) -> Array:
    """Inverse Jacobians (k, e, e) after moves (e, k) that changed the mismatch by (e, k)."""
    image = moves(inverse, change)
    denominator = np.einsum("ek,ek->k", move, image)
    rows = (
        np.einsum("ek,kef->kf", move, inverse) / np.where(denominator, denominator, np.inf)[:, None]
    )
    return np.asarray(inverse + (move - image).T[:, :, None] * rows[:, None, :])


def _located(
    edges: Edges, start: Array, lent: Array, doubt: Array, load: Load, rtol: float
) -> tuple[Array, Array, Array, int]:
    """Unknowns (e, k) near their places on the loose rule, inverse Jacobians (k, e, e), what a
    chord step with them leaves of itself (k,), infinite for sets that did not get there, and the
    steps taken.

    Where predictions (e, k) with little doubt (k,) lead nowhere there are other zones.
    """
    rule = rule_for(loose_tolerance(rtol))
    unknowns, inverse, contraction, steps = _approached(edges, start, lent, load, rule)
    arrived = contraction < np.inf
    rest = np.flatnonzero(np.where(arrived, rtol < _WITHOUT_JACOBIAN, ~(doubt < _PREDICTED)))
    if len(rest):
        found = _newton(edges, unknowns[:, rest], _chosen(load, rest), rule)
        unknowns[:, rest], inverse[rest] = found[0], found[1]
        contraction[rest] = 2 * found[2]
        steps += found[3]
    return unknowns, inverse, contraction, steps


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
        unknowns, inverse, left, steps = _located(edges, unknowns, inverse, doubt, load, rtol)
        contraction = np.maximum(left, _LEAST_CONTRACTION)
        kept = np.flatnonzero(left < np.inf)
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
