"""Zones over friction and Poisson ratio: found at a few points, followed to the rest.

Points are taken lattice by lattice, each twice as fine as the one before.  At every point the
edges are predicted by polynomials through those of the nearest points that have the same zones.
Where neighbours agree on the zones and polynomials on the edges, a prediction is corrected on the
loose rule: what that rule lacks is known at neighbours, and as smooth as the edges.  Elsewhere it
is corrected on the fine rule like those of `continuation`, and becomes a neighbour others rest on;
where it fails, the point is solved from scratch.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from time import perf_counter

import numpy as np

from semianalytic.cut.load import check_pressure, common_load, scaled_load
from semianalytic.cut.profile import Profile
from semianalytic.cut.zones import ZoneFields
from semianalytic.halfplane.families import rayleigh_family
from semianalytic.halfplane.rayleigh import Array, rayleigh_factors
from semianalytic.halfplane.rules import rule_for
from semianalytic.halfplane.stuck import traction_of
from semianalytic.scene.scene import Scene
from semianalytic.selfsimilar.coulomb import admissible
from semianalytic.selfsimilar.edges import Edges, edges_of, moves
from semianalytic.selfsimilar.estimate import loose_tolerance, missed_slip
from semianalytic.selfsimilar.solution import Solution, Statistics
from semianalytic.selfsimilar.solver import slip_zones, solve
from semianalytic.selfsimilar.tuning import FARTHEST, SAFETY
from semianalytic.sweeps import tuning
from semianalytic.sweeps.batches import Prediction, ZoneSets, continued, linearised
from semianalytic.sweeps.continuation import COMPUTED, FROM_SCRATCH, INTERPOLATED
from semianalytic.sweeps.interpolation import fits
from semianalytic.sweeps.neighbours import Neighbourhood

Pattern = tuple[tuple[int, ...], tuple[bool, bool], tuple[int, ...]]
"""Senses, open ends and segments of `Edges`, whatever the Poisson ratio."""


@dataclass(frozen=True)
class Followed:
    """Zones at one point: their pattern and unknowns (e,), the tolerance of their rule and the
    error estimate.

    Where others may rest on them also the inverse Jacobian (e, e) and the shift (e,) of the unknowns
    from the fine rule to the loose one.
    """

    pattern: Pattern
    unknowns: Array
    tolerance: float
    estimate: float
    inverse: Array | None = None
    shift: Array | None = None


class Plane:
    """Solutions so far of scenes that differ in friction and Poisson ratio."""

    def __init__(self, scenes: Sequence[Scene], rtol: float) -> None:
        self.scenes, self.rtol = scenes, rtol
        self.loose = rule_for(loose_tolerance(rtol))
        ratio = np.array([scene.material.poisson_ratio for scene in scenes])
        friction = np.array([scene.friction for scene in scenes])
        both = np.stack([friction, ratio], axis=1)
        span = np.ptp(both, axis=0)
        self.places = (both - both.min(axis=0)) / np.where(span > 0, span, 1.0)
        self.family = rayleigh_family(ratio)
        self.factors = {one: rayleigh_factors(one) for one in np.unique(ratio).tolist()}
        self.unit = min(scaled_load(scene)[1] for scene in scenes)
        self.solutions: dict[int, Solution] = {}
        self.origin: dict[int, str] = {}
        self.zones: dict[int, Followed] = {}

    def run(self) -> None:
        """Solve all scenes."""
        self._check_pressure()
        for targets in self._lattices():
            self._advance(targets)

    def _check_pressure(self) -> None:
        """Refuse the first scene in which the contact pressure turns tensile."""
        one = self.scenes[0]
        change = traction_of(self.family, "I")(self.family.c)[:, 0]
        least = one.base.pressure + one.load.pressure * change
        check_pressure(self.scenes[int(np.argmin(least))])

    def _lattices(self) -> Iterator[np.ndarray]:
        """Points nearest to those of finer and finer lattices, and at last all that are left."""
        left, spaces = np.ones(len(self.scenes), dtype=bool), tuning.FIRST_LATTICE - 1
        everywhere = Neighbourhood(self.places)
        while 2 * (spaces + 1) ** 2 < len(self.scenes):
            side = np.linspace(0, 1, spaces + 1)
            lattice = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
            nearest = np.unique(everywhere.nearest(lattice, 1))
            yield nearest[left[nearest]]
            left[nearest] = False
            spaces *= 2
        yield np.flatnonzero(left)

    def _advance(self, targets: np.ndarray) -> None:
        """Solve some points with the help of those that are known."""
        if self.zones:
            for rank in range(tuning.PATTERNS_TRIED):
                waiting = [int(i) for i in targets if i not in self.origin]
                for (pattern, certain), some in self._patterns(waiting, rank).items():
                    self._follow(pattern, certain, np.array(some))
        self._from_scratch([int(i) for i in targets if i not in self.origin])

    def _patterns(self, targets: list[int], rank: int) -> dict[tuple[Pattern, bool], list[int]]:
        """Points by the pattern of zones they may have, and whether all known points around have it:
        rank 0 the most likely one."""
        if not targets:
            return {}
        known = np.array(list(self.zones))
        around = Neighbourhood(self.places[known])
        near = known[around.nearest(self.places[targets], tuning.CERTAIN_NEIGHBOURS)]
        result: dict[tuple[Pattern, bool], list[int]] = {}
        for i, indices in zip(targets, near.tolist(), strict=True):
            patterns = list(dict.fromkeys(self.zones[j].pattern for j in indices))
            if rank < len(patterns) and fits(self._edges(patterns[rank], [i]), self.scenes[i]):
                result.setdefault((patterns[rank], len(patterns) == 1), []).append(i)
        return result

    def _edges(self, pattern: Pattern, which: Sequence[int] | np.ndarray) -> Edges:
        """The edges of some points."""
        return Edges(self.family.chosen(np.asarray(which)), *pattern)

    def _sets(self, pattern: Pattern, which: np.ndarray) -> ZoneSets:
        """What is asked of the zones of some points."""
        load = common_load([self.scenes[i] for i in which], self.unit)
        return ZoneSets(self._edges(pattern, which), load)

    def _batches(
        self, pattern: Pattern, which: np.ndarray, unknowns: Array, apart: np.ndarray
    ) -> Iterator[np.ndarray]:
        """Points, as places in `which`, whose zones may share panels: edges on one side of every
        cut, close to one front or to none; and of one kind in `apart`.

        Those with narrow gaps, which need long panels, come together.
        """
        edges = self._edges(pattern, which)
        parts, hides = edges.parts(unknowns.T), self.family.hiding[which]
        beyond = (hides == 2) & (parts[0] > self.family.hidden_root.real[which, 0])
        distances = np.abs(parts[1:])
        close = np.where(
            distances.min(axis=0) < tuning.CLOSE_TO_FRONT, distances.argmin(axis=0), -1
        )
        keys = np.concatenate([[hides, apart], beyond, close])
        _, group = np.unique(keys, axis=1, return_inverse=True)
        from_c = distances[2].min(axis=0, initial=1.0)
        for one in range(group.max() + 1):
            some = np.flatnonzero(group == one)
            some = some[np.argsort(from_c[some])]
            yield from np.array_split(some, -(-len(some) // tuning.PLANE_BATCH))

    @np.errstate(over="ignore", invalid="ignore", divide="ignore")  # of edges that cross a cut
    def _follow(self, pattern: Pattern, certain: bool, targets: np.ndarray) -> None:
        """Try a pattern of zones at some points; keep what fulfils Coulomb's law."""
        known = np.array([i for i, one in self.zones.items() if one.pattern == pattern])
        every = [self.zones[i] for i in known]
        stencils = Neighbourhood(self.places[known]).stencils(self.places[targets])
        blends = stencils.best(values := np.array([one.unknowns for one in every]))
        unknowns, other = blends(values)
        unknowns = np.clip(unknowns, -FARTHEST, FARTHEST)
        doubt = np.abs(unknowns - other).max(axis=1, initial=0.0)
        doubt[np.isnan(doubt)] = np.inf
        resting = [one for one in every if one.inverse is not None]
        places = self.places[[i for i in known if self.zones[i].inverse is not None]]
        base = _Base.of(resting, places, self.places[targets], self.rtol)
        easy = doubt < tuning.PREDICTED_DOUBT
        kind = np.where(easy, -np.log10(base.loosest if certain else base.tolerance), 0.0)
        for batch in self._batches(pattern, targets, unknowns, kind):
            if easy[batch[0]]:
                sound = self._corrected(pattern, certain, targets, unknowns, base, batch)
                batch = batch[~sound]
            if len(batch):
                off = np.maximum(doubt[batch], tuning.LEADING_DOUBT)
                self._computed(pattern, targets[batch], unknowns[batch], base, batch, off)

    def _corrected(
        self,
        pattern: Pattern,
        certain: bool,
        targets: np.ndarray,
        unknowns: Array,
        base: _Base,
        batch: np.ndarray,
    ) -> np.ndarray:
        """Correct predictions on a loose rule, where the zones are not certain on the fine one;
        which of the batch are sound."""
        start = perf_counter()
        rule = rule_for(float((base.loosest if certain else base.tolerance)[batch].min()))
        law = tuning.LOOSE_CHECK * self.loose.tolerance
        inverse, others = base.inverse[0][batch], base.inverse[1][batch]
        sets, now = self._sets(pattern, targets[batch]), unknowns[batch].T
        fields = sets.fields(now, rule)
        profile, estimate = Profile(fields), base.estimate[batch]
        if not certain:
            law = min(self.rtol, tuning.LOOSEST_LAW)
            estimate = estimate + missed_slip(profile)
        sound = admissible(profile, law)
        if pattern[2]:
            values = fields.mismatch()
            move = -moves(inverse, values)
            size = np.abs(move).max(axis=0)
            left = np.abs(move + moves(others, values)).max(axis=0) + np.square(size)
            now = now + move
            sound &= (size < tuning.PREDICTED_DOUBT) & sets.edges.admits(now)
            again = np.flatnonzero(sound & ~(estimate + SAFETY * left <= self.rtol))
            if len(again):
                move = -moves(inverse[again], sets.chosen(again).mismatch(now[:, again], rule))
                now[:, again] += move
                second = np.abs(move).max(axis=0)
                left[again] = second * np.minimum(1.0, second / size[again])
                sound &= sets.edges.admits(now)
            estimate = estimate + SAFETY * left
        sound &= estimate <= self.rtol
        seconds = (perf_counter() - start) / len(batch)
        for j in np.flatnonzero(sound):
            i = int(targets[batch[j]])
            followed = Followed(pattern, now[:, j], base.tolerance[batch[j]], float(estimate[j]))
            self._add(i, followed, INTERPOLATED, 1, fields.panels.jacobian[:, 0].size, seconds)
        return sound

    def _computed(
        self,
        pattern: Pattern,
        targets: np.ndarray,
        unknowns: Array,
        base: _Base,
        batch: np.ndarray,
        doubt: Array,
    ) -> None:
        """Correct predictions on the fine rule."""
        start, sets = perf_counter(), self._sets(pattern, targets)
        predictions = [
            Prediction(one, inverse, float(off), tolerance)
            for one, inverse, off, tolerance in zip(
                unknowns, base.inverse[0][batch], doubt, base.tolerance[batch], strict=True
            )
        ]
        done = continued(sets, predictions, self.rtol)
        sound = np.flatnonzero(done.sound)
        if not len(sound):
            return
        now, inverse = done.unknowns[:, sound], done.inverse[sound]
        shift = -moves(inverse, sets.chosen(sound).mismatch(now, self.loose)) if len(now) else now
        seconds = (perf_counter() - start) / len(targets)
        for j, k in enumerate(sound):
            parts = now[:, j], float(done.tolerances[k]), float(done.estimate[k])
            followed = Followed(pattern, *parts, inverse[j], shift[:, j])
            self._add(int(targets[k]), followed, COMPUTED, done.steps, done.nodes, seconds)

    def _from_scratch(self, targets: list[int]) -> None:
        """Solve points without help; those with converged edges help others."""
        by_pattern: dict[Pattern, list[tuple[int, Array, float, float]]] = {}
        for i in targets:
            solution = solve(self.scenes[i], rtol=self.rtol)
            self.solutions[i], self.origin[i] = solution, FROM_SCRATCH
            fields = solution.profile.fields
            if solution.status == "converged" and not fields.load.frictionless:
                edges, unknowns = edges_of(fields.factors, fields.zones)
                pattern = (edges.senses, edges.open_ends, edges.segments)
                one = (i, unknowns, fields.rule.tolerance, solution.error_estimate)
                by_pattern.setdefault(pattern, []).append(one)
        for pattern, some in by_pattern.items():
            which, columns, tolerance, estimate = zip(*some, strict=True)
            which, unknowns = np.array(which), np.array(columns)
            for batch in self._batches(pattern, which, unknowns, np.zeros(len(which), dtype=bool)):
                sets, now = self._sets(pattern, which[batch]), unknowns[batch].T
                inverse, shift = np.zeros((len(batch), 0, 0)), now
                if len(now):
                    inverse, values = linearised(sets, now, self.loose)
                    shift = -moves(inverse, values)
                for j, k in enumerate(batch):
                    parts = now[:, j], tolerance[k], estimate[k], inverse[j], shift[:, j]
                    self.zones[int(which[k])] = Followed(pattern, *parts)

    def _add(
        self, i: int, followed: Followed, origin: str, steps: int, nodes: int, seconds: float
    ) -> None:
        scene = self.scenes[i]
        self.zones[i], self.origin[i] = followed, origin
        load, stress = scaled_load(scene)
        factors = self.factors[scene.material.poisson_ratio]
        edges = Edges(factors, *followed.pattern)
        zones = edges.zones(followed.unknowns)
        profile = Profile(ZoneFields(factors, load, zones, rule_for(followed.tolerance)))
        stages = {"zones": 0.0, "edges": seconds, "check": 0.0}
        statistics = Statistics(0, steps, 1, len(followed.unknowns), nodes, stages)
        self.solutions[i] = Solution(
            scene,
            slip_zones(scene, profile),
            "converged",
            followed.estimate,
            statistics,
            profile,
            stress,
        )


@dataclass(frozen=True)
class _Base:
    """What t points take from neighbours on the fine rule.

    Attributes
    ----------
    inverse : (t, e, e) inverse Jacobians, from two polynomials
    tolerance : (t,), of the fine rule
    loosest : (t,), of the rule that is fine enough to correct edges on
    estimate : (t,), error estimate there, and what that rule may lack
    """

    inverse: tuple[Array, Array]
    tolerance: Array
    loosest: Array
    estimate: Array

    @classmethod
    def of(cls, known: list[Followed], places: Array, to: Array, rtol: float) -> _Base:
        stencils = Neighbourhood(places).stencils(to)
        blends = stencils.best(np.array([one.unknowns for one in known]))
        inverse = blends(np.array([one.inverse for one in known]))
        near = stencils.near[:, : tuning.CERTAIN_NEIGHBOURS]
        tolerance = np.array([one.tolerance for one in known])[near].min(axis=1)
        estimate = np.array([one.estimate for one in known])[near].max(axis=1)
        shift = np.array([np.abs(one.shift).max(initial=0.0) for one in known])[near].max(axis=1)
        loose = loose_tolerance(rtol)
        share = tuning.LOOSE_SHARE * rtol / np.maximum(SAFETY * shift, tuning.LOOSE_SHARE * rtol)
        steps = np.ceil(-np.log10(share) / tuning.RULE_STEP)
        loosest = np.maximum(loose * 10 ** (-tuning.RULE_STEP * steps), tolerance)
        lacking = np.where(loosest > tolerance, SAFETY * shift * loosest / loose, 0.0)
        return cls(inverse, tolerance, loosest, estimate + lacking)
