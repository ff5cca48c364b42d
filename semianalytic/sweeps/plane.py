"""Zones over friction and Poisson ratio: found at a few points, followed to the others.

Points are taken lattice by lattice, each twice as fine as the one before.  At every point the
edges are predicted by polynomials through those of the nearest points that have the same zones.
Where neighbours agree on the zones and polynomials on the edges, a prediction is corrected on the
loose rule: what that rule lacks is known at neighbours, and as smooth as the edges.  Elsewhere it
is corrected on the fine rule like those of `continuation`, and becomes a neighbour others rest on;
where it fails, the point is solved from scratch.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property
from operator import itemgetter
from time import perf_counter

import numpy as np

from semianalytic.cut.load import common_load, scaled_load
from semianalytic.cut.profile import Profile
from semianalytic.cut.zones import ZoneFields
from semianalytic.halfplane.families import rayleigh_family
from semianalytic.halfplane.rayleigh import Array, rayleigh_factors
from semianalytic.halfplane.rules import Rule, rule_for
from semianalytic.halfplane.stuck import traction_of
from semianalytic.scene.scene import Scene
from semianalytic.selfsimilar.solution import Solution
from semianalytic.selfsimilar.solver import solve
from semianalytic.selfsimilar.statistics import Statistics
from semianalytic.selfsimilar.zones.edges import Edges, edges_of, moves
from semianalytic.selfsimilar.zones.estimate import loose_tolerance, shift_error
from semianalytic.selfsimilar.zones.motion import slip_zones
from semianalytic.sweeps import tuning
from semianalytic.sweeps.batches import ZoneSets, continued, linearised
from semianalytic.sweeps.continuation import COMPUTED, FROM_SCRATCH, INTERPOLATED
from semianalytic.sweeps.interpolation import fits
from semianalytic.sweeps.neighbours import Neighbourhood
from semianalytic.sweeps.predictions import (
    Followed,
    Footing,
    Pattern,
    Predictions,
    corrected,
    joined,
    predicted,
)


class Plane:
    """The solutions so far of scenes that differ in friction and Poisson ratio."""

    def __init__(self, scenes: Sequence[Scene], rtol: float) -> None:
        self.scenes, self.rtol = scenes, rtol
        self.loose = rule_for(loose_tolerance(rtol))
        ratio = np.array([scene.material.poisson_ratio for scene in scenes])
        friction = np.array([scene.coefficient for scene in scenes])
        both = np.stack([friction, ratio], axis=1)
        span = np.ptp(both, axis=0)
        # Distances between points are taken in the unit square, whatever the ranges of friction and
        # Poisson ratio.
        self.places = (both - both.min(axis=0)) / np.where(span > 0, span, 1.0)
        self.family = rayleigh_family(ratio)
        self.factors = {one: rayleigh_factors(one) for one in np.unique(ratio).tolist()}
        self.unit = min(scaled_load(scene)[1] for scene in scenes)
        self.solutions: dict[int, Solution] = {}
        self.origin: dict[int, str] = {}
        self.zones: dict[int, Followed] = {}

    def run(self) -> None:
        """Solve all scenes."""
        for targets in self._lattices():
            self._advance(targets)

    @cached_property
    def _closed(self) -> np.ndarray:
        """Whether the contact stays closed at the Rayleigh front and at its edge, (n,)."""
        # Scenes that open are left to `solve`: under a negative step the pressure is minus infinity
        # at the contact edge, under a positive one it is least at c_R.
        base, step = (part.pressure for part in self.scenes[0].superposition)
        change = traction_of(self.family, "I")(self.family.c)[:, 0]
        return np.asarray((step >= 0) & (base + step * change >= 0))

    def _lattices(self) -> Iterator[np.ndarray]:
        """Yield the points nearest to those of finer and finer lattices, and at last all others."""
        # Points are nowhere asked to lie on a grid: the nearest ones to a lattice stand for it.
        # The first has six points to a side, each further one twice as many spaces.
        left, spaces = np.ones(len(self.scenes), dtype=bool), 5
        everywhere = Neighbourhood(self.places)
        while (spaces + 1) ** 2 < len(self.scenes):
            side = np.linspace(0, 1, spaces + 1)
            lattice = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
            nearest = np.unique(everywhere.nearest(lattice, 1))
            yield nearest[left[nearest]]
            left[nearest] = False
            # Each lattice contains the one before, so that most points are predicted from
            # neighbours all around them and at half their distance.
            spaces *= 2
        yield np.flatnonzero(left)

    def _advance(self, targets: np.ndarray) -> None:
        """Solve some points with the help of those that are known."""
        if self.zones:
            for rank in range(2):  # of the nearest known points
                waiting = [int(i) for i in targets if self._closed[i] and i not in self.origin]
                for (pattern, certain), some in self._patterns(waiting, rank).items():
                    self._follow(pattern, certain, np.array(some))
        self._from_scratch([int(i) for i in targets if i not in self.origin])

    def _patterns(self, targets: list[int], rank: int) -> dict[tuple[Pattern, bool], list[int]]:
        """Group points by the pattern of a rank around, and by whether all around have it."""
        if not targets:
            return {}
        known = np.array(list(self.zones))
        around = Neighbourhood(self.places[known])
        near = known[around.nearest(self.places[targets], tuning.CERTAIN_NEIGHBOURS)]
        result: dict[tuple[Pattern, bool], list[int]] = {}
        for i, indices in zip(targets, near.tolist(), strict=True):
            # In the order of distance, each pattern once.
            patterns = list(dict.fromkeys(self.zones[j].pattern for j in indices))
            if rank < len(patterns) and fits(self._edges(patterns[rank], [i]), self.scenes[i]):
                result.setdefault((patterns[rank], len(patterns) == 1), []).append(i)
        return result

    def _edges(self, pattern: Pattern, which: Sequence[int] | np.ndarray) -> Edges:
        """Return the edges of some points."""
        return Edges(self.family.chosen(np.asarray(which)), *pattern)

    def _sets(self, pattern: Pattern, which: np.ndarray) -> ZoneSets:
        """Return the sets of zones of some points, with their loads."""
        load = common_load([self.scenes[i] for i in which], self.unit)
        return ZoneSets(self._edges(pattern, which), load)

    def _batches(
        self, pattern: Pattern, which: np.ndarray, unknowns: Array, rule: Array | float
    ) -> Iterator[np.ndarray]:
        """Yield groups of indices into `which` whose zones may share panels, sides and fronts
        alike.

        Points of many nodes, on fine rules `rule` (t,) or with narrow gaps, come in smaller groups.
        """
        if not len(which):
            return
        edges = self._edges(pattern, which)
        parts, hiding = edges.parts(unknowns.T), self.family.hiding[which]
        beyond = (hiding == 2) & (parts[0] > self.family.hidden_root.real[which, 0])
        distances = np.abs(parts[1:])
        close = distances.min(axis=0) < tuning.CLOSE_TO_FRONT
        nearest = np.where(close, distances.argmin(axis=0), 3)
        keys = np.concatenate([[hiding], beyond, nearest])
        _, group = np.unique(keys, axis=1, return_inverse=True)
        # Nodes of a panel are proportional to the digits of the rule times its length in y, which
        # is that of the digits at both ends plus ln(1/gap).
        digits = 2 - np.log(rule)
        nodes = digits * (2 * digits - np.log(distances[2].min(axis=0, initial=1.0)))
        for one in range(group.max() + 1):
            some = np.flatnonzero(group == one)
            some = some[np.argsort(nodes[some])]
            size = np.cumsum((len(parts[0]) + 2) * nodes[some]) / tuning.PLANE_BATCH
            yield from np.split(some, np.flatnonzero(np.diff(size.astype(int))) + 1)

    @np.errstate(over="ignore", invalid="ignore", divide="ignore")  # of edges that cross a cut
    def _follow(self, pattern: Pattern, certain: bool, targets: np.ndarray) -> None:
        """Try a pattern of zones at some points; keep those that satisfy Coulomb's law."""
        known = [i for i, one in self.zones.items() if one.pattern == pattern]
        parts = [self.zones[i] for i in known], self.places[known]
        every = predicted(*parts, targets, self.places[targets], self.rtol)
        # Where neighbours disagree on the zones, Coulomb's law is asked on the fine rule, which
        # therefore decides which points may share a batch.
        rule = every.loose if certain else every.tolerance
        # A prediction in greater doubt goes to the fine rule at once, where full Newton steps may
        # still find the edges.
        led = np.flatnonzero(every.doubt < tuning.LEADING_DOUBT)
        left = [every[every.doubt >= tuning.LEADING_DOUBT]]
        for batch in self._batches(pattern, targets[led], every.unknowns[led], rule[led]):
            left.append(self._correct(pattern, certain, every[led[batch]]))
        rest = joined(left)
        for batch in self._batches(pattern, rest.points, rest.unknowns, rest.tolerance):
            self._compute(pattern, rest[batch])

    def _correct(self, pattern: Pattern, certain: bool, some: Predictions) -> Predictions:
        """Keep predictions that a loose rule can correct; return others that may be right."""
        start = perf_counter()
        done = corrected(self._sets(pattern, some.points), some, certain, self.rtol)
        seconds = (perf_counter() - start) / len(some)
        sound = np.flatnonzero(done.sound)
        now, rules = done.unknowns.T[sound], some.tolerance[sound]
        parts = zip(now, rules.tolist(), done.estimate[sound].tolist(), strict=True)
        found = [Followed(pattern, *each) for each in parts]
        self._keep(some.points[sound], found, INTERPOLATED, 1, done.nodes, seconds)
        # A point that violates Coulomb's law has other zones and is not tried again with these.
        return done.approached[~(done.sound | done.refuted)]

    def _compute(self, pattern: Pattern, some: Predictions) -> None:
        """Keep predictions that can be corrected on the fine rule."""
        start, sets = perf_counter(), self._sets(pattern, some.points)
        done = continued(sets, some.each(), self.rtol)
        sound = np.flatnonzero(done.sound)
        if not len(sound):
            return
        now, inverse = done.unknowns[:, sound], done.inverse[sound]
        footings = _footings(sets.chosen(sound), now, inverse, self.loose)
        seconds = (perf_counter() - start) / len(some)
        rules, estimates = done.tolerances[sound].tolist(), done.estimate[sound].tolist()
        parts = zip(now.T, rules, estimates, footings, strict=True)
        found = [Followed(pattern, *each) for each in parts]
        self._keep(some.points[sound], found, COMPUTED, done.steps, done.nodes, seconds)

    def _from_scratch(self, targets: list[int]) -> None:
        """Solve points without help; those with converged edges help others."""
        by_pattern: dict[Pattern, list[tuple[int, Array, float, float]]] = {}
        for i in targets:
            solution = solve(self.scenes[i], rtol=self.rtol)
            self.solutions[i], self.origin[i] = solution, FROM_SCRATCH
            fields = solution.profile.fields
            load = fields.load
            if solution.status == "converged" and not (load.frictionless or load.opened):
                edges, unknowns = edges_of(fields.factors, fields.zones)
                pattern = (edges.kinds, edges.open_ends, edges.segments)
                one = (i, unknowns, fields.rule.tolerance, solution.error_estimate)
                by_pattern.setdefault(pattern, []).append(one)
        for pattern, some in by_pattern.items():
            which, unknowns = (np.array([one[part] for one in some]) for part in (0, 1))
            for batch in self._batches(pattern, which, unknowns, self.loose.tolerance):
                sets, now = self._sets(pattern, which[batch]), unknowns[batch].T
                # Zones without edges have no Jacobian, but are a footing all the same.
                inverse = np.zeros((len(batch), 0, 0))
                if len(now):
                    inverse, _ = linearised(sets, now, self.loose)
                footings = _footings(sets, now, inverse, self.loose)
                for k, footing in zip(batch, footings, strict=True):
                    i, one, tolerance, estimate = some[k]
                    self.zones[i] = Followed(pattern, one, tolerance, estimate, footing)

    def _keep(
        self,
        points: np.ndarray,
        found: list[Followed],
        origin: str,
        steps: int,
        nodes: int,
        seconds: float,
    ) -> None:
        """Make solutions at points from zones of one pattern that were found there."""
        if not found:
            return
        count, size = len(found), len(found[0].unknowns)
        unknowns = np.array([one.unknowns for one in found]).reshape(count, size).T
        every = self._edges(found[0].pattern, points).zones(unknowns)
        stages = {"zones": 0.0, "edges": seconds, "check": 0.0}
        statistics = Statistics(0, steps, 1, size, nodes, stages)
        for j, (i, followed) in enumerate(zip(points.tolist(), found, strict=True)):
            scene = self.scenes[i]
            self.zones[i], self.origin[i] = followed, origin
            (load, stress), rule = scaled_load(scene), rule_for(followed.tolerance)
            zones = tuple(zone.seen_by(itemgetter(j)) for zone in every)
            factors = self.factors[scene.material.poisson_ratio]
            profile = Profile(ZoneFields(factors, load, zones, rule))
            moving = slip_zones(profile, scene.material), "converged", followed.estimate
            self.solutions[i] = Solution(scene, *moving, statistics, profile, stress)


def _footings(sets: ZoneSets, unknowns: Array, inverse: Array, loose: Rule) -> list[Footing]:
    """Return footings from unknowns (e, k) right on the fine rule and inverse Jacobians."""
    if not len(unknowns):
        return [Footing(one, 0.0) for one in inverse]
    fields = sets.fields(unknowns, loose)
    moved = unknowns - moves(inverse, fields.mismatch())
    shift = shift_error(sets.edges, unknowns, moved, fields)
    return [Footing(one, float(size)) for one, size in zip(inverse, shift, strict=True)]
