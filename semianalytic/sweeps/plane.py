"""Zones over friction, or friction and Poisson ratio: found at few points, followed to others.

Points are taken lattice by lattice, each twice as fine as the one before.  At every point the
edges are predicted by polynomials through those of the nearest points that have the same zones.
Where neighbours agree on the zones and polynomials on the edges, a prediction is corrected on the
loose rule: what that rule lacks is known at neighbours, and as smooth as the edges.  Elsewhere it
is corrected on the fine rule (`batches`), and becomes a neighbour others rest on; where it fails,
the point is solved from scratch.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from operator import itemgetter
from time import perf_counter

import numpy as np

from semianalytic.cut.load import common_load, contact_opens, scaled_load
from semianalytic.cut.profile import Profile
from semianalytic.cut.zones import ZoneFields
from semianalytic.halfplane.families import rayleigh_family
from semianalytic.halfplane.rayleigh import rayleigh_factors
from semianalytic.halfplane.rules import rule_for
from semianalytic.scene.arrays import Array
from semianalytic.scene.scene import Scene
from semianalytic.selfsimilar.search import loose_search
from semianalytic.selfsimilar.solution import Solution
from semianalytic.selfsimilar.solver import is_rated, solve
from semianalytic.selfsimilar.statistics import Statistics
from semianalytic.selfsimilar.zones.edges import Edges, moves
from semianalytic.selfsimilar.zones.estimate import loose_tolerance, shift_error
from semianalytic.sweeps import tuning
from semianalytic.sweeps.batches import ZoneSets, continued
from semianalytic.sweeps.neighbours import Neighbourhood
from semianalytic.sweeps.predictions import (
    Followed,
    Pattern,
    Predictions,
    corrected,
    joined,
    predicted,
)

FROM_SCRATCH, COMPUTED, INTERPOLATED = "from scratch", "computed", "interpolated"
"""Origins of a solution: without help from neighbours, corrected from a prediction on the fine
rule, or on the loose rule alone."""


class Plane:
    """The solutions so far of scenes that differ in friction and Poisson ratio, or in friction."""

    def __init__(self, scenes: Sequence[Scene], rtol: float, unit: float | None = None) -> None:
        self.scenes, self.rtol = list(scenes), rtol
        self.loose = rule_for(loose_tolerance(rtol))
        ratio = np.array([scene.material.poisson_ratio for scene in scenes])
        friction = np.array([scene.coefficient for scene in scenes])
        self.values = np.stack([friction, ratio], axis=1)  # (n, 2)
        ratios, first = np.unique(ratio, return_index=True)
        # Tables of many solids at once are those of loads in the plane that come at once.
        several = len(ratios) > 1
        alone = rayleigh_factors(float(ratios[0]), scenes[0].shear_mode)
        self.family = rayleigh_family(ratio) if several else alone
        # The hidden root nearest to the cut makes the rule of a batch, on which others then lack
        # less than on their own.  Steps are half powers of two.
        self.hidden = np.resize(self.family.hidden_root, len(scenes))
        self.hiding = np.resize(self.family.hiding, len(scenes))
        a = np.resize(self.family.a, len(scenes))
        away = np.abs(np.angle((self.hidden - a) / (1 - self.hidden)))
        angle = np.where(self.hidden.imag > 0, away, np.pi)
        self.strip = np.round(2 * np.log2(np.maximum(angle, 1e-3)))
        # Where they open, or depend on slip rate in any way, the batches do not follow zones: such
        # scenes are left to `solve`.
        opens = {nu: contact_opens(scenes[i]) for nu, i in zip(ratios.tolist(), first, strict=True)}
        self.followed = ~np.array([is_rated(scenes[0]) or opens[nu] for nu in ratio.tolist()])
        self.factors = dict(zip(ratios.tolist(), map(self.family.single, first), strict=True))
        # Loads do not depend on the Poisson ratio.
        _, first, own = np.unique(friction, return_index=True, return_inverse=True)
        each = [scaled_load(scenes[i]) for i in first]
        self.loads = [each[number] for number in own]
        self.unit = unit or min(unit for _, unit in each)
        load = common_load([scenes[i] for i in first], self.unit)
        far_slip_rate = np.asarray(load.far_slip_rate)[own]
        self.load = replace(load, friction=friction[:, None], far_slip_rate=far_slip_rate)
        # Zones slip ahead of all waves only where friction is reached there.
        self.still = np.array([not load.far_slip_rate for load, _ in each])[own]
        self.critical = np.array([load.critical for load, _ in each])[own]
        self.solutions: dict[int, Solution] = {}
        self.origin: dict[int, str] = {}
        self.zones: dict[int, Followed] = {}

    def run(self) -> None:
        """Solve all scenes."""
        # Distances between points are taken in the unit square, whatever the ranges of friction and
        # Poisson ratio, or, with one ratio, on a line.
        span, low = np.ptp(self.values, axis=0), self.values.min(axis=0)
        varied = [0, 1] if span[1] else [0]
        self.places = ((self.values - low) / np.where(span > 0, span, 1.0))[:, varied]
        for targets in self._lattices():
            self._advance(targets)

    def add(self, scenes: Sequence[Scene]) -> None:
        """Solve scenes of other frictions and the same Poisson ratio too, with help of all."""
        others = Plane(scenes, self.rtol, self.unit)
        for name in ("values", "hidden", "hiding", "strip", "followed", "still", "critical"):
            setattr(self, name, np.concatenate([getattr(plane, name) for plane in (self, others)]))
        self.scenes += others.scenes
        self.loads += others.loads
        friction, far_slip_rate = (
            np.concatenate([getattr(plane.load, name) for plane in (self, others)])
            for name in ("friction", "far_slip_rate")
        )
        self.load = replace(self.load, friction=friction, far_slip_rate=far_slip_rate)
        self.run()

    def _lattices(self) -> Iterator[np.ndarray]:
        """Yield the points nearest to those of finer and finer lattices, and at last all others."""
        # Points are nowhere asked to lie on a grid: the nearest ones to a lattice stand for it.
        # The first has three points to a side, each further one twice as many spaces.
        # Where others are known already, what is left may be few.
        left, spaces = self._unsolved(np.arange(len(self.scenes))), 2
        everywhere, sides, count = Neighbourhood(self.places), self.places.shape[1], left.sum()
        while (spaces + 1) ** sides < count:
            side = np.linspace(0, 1, spaces + 1)
            lattice = np.stack(np.meshgrid(*[side] * sides), axis=-1).reshape(-1, sides)
            nearest = np.unique(everywhere.nearest(lattice, 1))
            yield nearest[left[nearest]]
            left[nearest] = False
            # Each lattice contains the one before, so that most points are predicted from
            # neighbours all around them and at half their distance.
            spaces *= 4 // sides
        yield np.flatnonzero(left)

    def _advance(self, targets: np.ndarray) -> None:
        """Solve some points with the help of those that are known."""
        # The whole level twice: what is found the first time helps what is left.
        for _ in range(2):
            targets = targets[self._unsolved(targets)]
            if not (self.zones and len(targets)):
                break
            left: dict[Pattern, list[Predictions]] = {}
            for rank in range(2):  # of the nearest known points
                for pattern, (some, certain) in self._patterns(targets, rank).items():
                    left.setdefault(pattern, []).append(self._follow(pattern, certain, some))
            for pattern, parts in left.items():
                rest = joined(parts)
                self._compute(pattern, rest[self._unsolved(rest.points)])
        self._from_scratch([int(i) for i in targets if i not in self.origin])

    def _unsolved(self, points: np.ndarray) -> np.ndarray:
        """Return which points have no solution yet."""
        return np.array([i not in self.origin for i in points.tolist()], dtype=bool)

    def _patterns(
        self, targets: np.ndarray, rank: int
    ) -> dict[Pattern, tuple[np.ndarray, np.ndarray]]:
        """Group points by the pattern of a rank around, with whether all around have it."""
        targets = targets[self.followed[targets] & self._unsolved(targets)]
        if not len(targets):
            return {}
        known = np.array(list(self.zones))
        around = Neighbourhood(self.places[known])
        near = known[around.nearest(self.places[targets], tuning.CERTAIN_NEIGHBOURS)]
        numbers: dict[Pattern, int] = {}
        every = [numbers.setdefault(self.zones[i].pattern, len(numbers)) for i in known.tolist()]
        own = np.zeros(len(self.scenes), dtype=int)
        own[known] = every
        differs = own[near] != own[near[:, :1]]
        # Zones that cannot be followed, which are not known here, differ as well.
        solved = np.array(list(self.origin))
        among = Neighbourhood(self.places[solved])
        close = solved[among.nearest(self.places[targets], tuning.CERTAIN_NEIGHBOURS)]
        certain = ~differs.any(axis=1) & np.isin(close, known).all(axis=1)
        # In the order of distance, each pattern once.
        chosen = own[near[np.arange(len(near)), differs.argmax(axis=1) if rank else 0]]
        found = {}
        for pattern, number in numbers.items():
            fitting = (self.critical if pattern[1][0] else self.still)[targets]
            some = (chosen == number) & fitting & ~(certain & bool(rank))
            if some.any():
                found[pattern] = targets[some], certain[some]
        return found

    def _sets(self, pattern: Pattern, which: np.ndarray) -> ZoneSets:
        """Return the sets of zones of some points, with their loads."""
        return ZoneSets(Edges(self.family, *pattern), self.load).chosen(which)

    def _batches(
        self, pattern: Pattern, which: np.ndarray, unknowns: Array, rule: Array, measured: bool
    ) -> Iterator[np.ndarray]:
        """Yield groups of indices into `which` whose zones may share panels.

        Points of many nodes, on fine rules `rule` (t,) or with narrow gaps, come in smaller groups.
        Where it is `measured` what edges lack on a loose rule, groups hold alike solids and gaps
        alone: on the panels of others edges lack less than on their own.
        """
        if len(which) < 2:
            yield from np.arange(len(which))[:, None]
            return
        parts, hiding = self._sets(pattern, which).edges.parts(unknowns.T), self.hiding[which]
        beyond = (hiding == 2) & (parts[0] > self.hidden.real[which])
        distances = np.abs(parts[1:])
        # Nodes of a panel are proportional to the digits of the rule times its length in y, which
        # is that of the digits at both ends plus ln(1/gap).
        digits, narrow = 2 - np.log(rule), -np.log(distances[2].min(axis=0, initial=1.0))
        nodes = digits * (2 * digits + narrow)
        alike = np.array([self.strip[which], np.round(narrow / 2)]) * measured
        keys = np.concatenate([[hiding == 2], alike, beyond])
        _, group = np.unique(keys, axis=1, return_inverse=True)
        for label in range(group.max() + 1):
            some = np.flatnonzero(group == label)
            some = some[np.argsort(nodes[some])]
            size = np.cumsum((len(parts[0]) + 2) * nodes[some]) / tuning.PLANE_BATCH
            yield from np.split(some, np.flatnonzero(np.diff(size.astype(int))) + 1)

    def _follow(self, pattern: Pattern, certain: np.ndarray, targets: np.ndarray) -> Predictions:
        """Try a pattern of zones at some points; return predictions that may still be right."""
        known = [i for i, zone in self.zones.items() if zone.pattern == pattern]
        self._measure(pattern, known)
        parts = [self.zones[i] for i in known], self.places[known]
        every = predicted(*parts, targets, self.places[targets], self.rtol)
        # A prediction in greater doubt goes to the fine rule at once, where full Newton steps may
        # still find the edges.
        led = np.flatnonzero(every.doubt < tuning.LEADING_DOUBT)
        left = [every[every.doubt >= tuning.LEADING_DOUBT]]
        some = targets[led], every.unknowns[led], every.loose[led]
        for batch in self._batches(pattern, *some, False):
            left.append(self._correct(pattern, certain[led[batch]], every[led[batch]]))
        return joined(left)

    def _measure(self, pattern: Pattern, known: Sequence[int]) -> None:
        """Measure what edges from the fine rule lack on the loose one, where it is not known."""
        firm = [(i, self.zones[i]) for i in known if self.origin[i] != INTERPOLATED]
        new = [(i, zone.unknowns, zone.inverse) for i, zone in firm if zone.lack is None]
        if not new:
            return
        points, unknowns, inverse = (np.array(part) for part in zip(*new, strict=True))
        rules = np.full(len(points), self.loose.tolerance)
        for batch in self._batches(pattern, points, unknowns, rules, True):
            sets, now = self._sets(pattern, points[batch]), unknowns[batch].T
            lack = np.zeros(len(batch))
            if len(now):
                fields = sets.fields(now, self.loose)
                moved = now - moves(inverse[batch], fields.mismatch())
                lack = shift_error(sets.edges, now, moved, fields)
            for i, size in zip(points[batch].tolist(), lack.tolist(), strict=True):
                self.zones[i] = replace(self.zones[i], lack=size)

    @np.errstate(over="ignore", invalid="ignore", divide="ignore")  # of edges that cross a cut
    def _correct(self, pattern: Pattern, certain: np.ndarray, some: Predictions) -> Predictions:
        """Keep predictions that a loose rule can correct; return others that may be right."""
        start = perf_counter()
        done = corrected(self._sets(pattern, some.points), some, certain, self.rtol)
        seconds = (perf_counter() - start) / len(some)
        sound = np.flatnonzero(done.sound)
        now, rules = done.unknowns.T[sound], some.tolerance[sound]
        nearer = done.approached[sound]
        own = zip(nearer.inverse, nearer.doubt == tuning.LOCATED, strict=True)
        inverse = [each if located else None for each, located in own]
        parts = zip(now, rules.tolist(), done.estimate[sound].tolist(), inverse, strict=True)
        found = [Followed(pattern, *each) for each in parts]
        self._keep(some.points[sound], found, INTERPOLATED, 1, done.nodes, seconds)
        # A point that violates Coulomb's law has other zones and is not tried again with these.
        return done.approached[~(done.sound | done.refuted)]

    @np.errstate(over="ignore", invalid="ignore", divide="ignore")  # of edges that cross a cut
    def _compute(self, pattern: Pattern, every: Predictions, origin: str = COMPUTED) -> None:
        """Keep predictions that can be corrected on the fine rule."""
        for batch in self._batches(pattern, every.points, every.unknowns, every.tolerance, False):
            some = every[batch]
            start, sets = perf_counter(), self._sets(pattern, some.points)
            start_from = some.unknowns.T, some.inverse, some.doubt
            done = continued(sets, *start_from, some.tolerance, self.rtol)
            sound = np.flatnonzero(done.sound)
            if not len(sound):
                continue
            now, inverse = done.unknowns[:, sound], done.inverse[sound]
            seconds = (perf_counter() - start) / len(some)
            rules, estimates = done.tolerances[sound].tolist(), done.estimate[sound].tolist()
            parts = zip(now.T, rules, estimates, inverse, strict=True)
            found = [Followed(pattern, *each) for each in parts]
            self._keep(some.points[sound], found, origin, done.steps, done.nodes, seconds)

    def _from_scratch(self, targets: list[int]) -> None:
        """Solve points without help; those whose zones are found on the loose rule help others."""
        self._search([i for i in targets if self.followed[i]])
        for i in targets:
            if i not in self.origin:
                self.solutions[i] = solve(self.scenes[i], rtol=self.rtol)
                self.origin[i] = FROM_SCRATCH

    def _search(self, targets: list[int]) -> None:
        """Search the zones of points one by one on the loose rule, and refine them together."""
        found: dict[Pattern, list[tuple[int, Array, Array]]] = {}
        for i in targets:
            load, unit = self.loads[i]
            if load.frictionless:
                continue
            factors = self.factors[self.scenes[i].material.poisson_ratio]
            trial, _ = loose_search(factors, load, self.rtol)
            edges, inverse = trial.placement.edges, trial.placement.inverse * (self.unit / unit)
            if trial.lawful:
                pattern = (edges.kinds, edges.open_ends, edges.segments)
                found.setdefault(pattern, []).append((i, trial.placement.unknowns, inverse))
        for pattern, some in found.items():
            points, unknowns, inverse = (np.array(part) for part in zip(*some, strict=True))
            doubt, rule = (np.full(len(some), size) for size in (tuning.LOCATED, self.rtol / 20.0))
            every = Predictions(points, unknowns, doubt, inverse, inverse, rule, rule, rule)
            self._compute(pattern, every, FROM_SCRATCH)

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
        unknowns = np.array([zone.unknowns for zone in found]).reshape(count, size).T
        every = self._sets(found[0].pattern, points).edges.zones(unknowns)
        stages = {"zones": 0.0, "edges": seconds, "check": 0.0}
        statistics = Statistics(steps, 1, size, nodes, stages)
        for j, (i, followed) in enumerate(zip(points.tolist(), found, strict=True)):
            scene = self.scenes[i]
            self.zones[i], self.origin[i] = followed, origin
            (load, stress), rule = self.loads[i], rule_for(followed.tolerance)
            zones = tuple(zone.seen_by(itemgetter(j)) for zone in every)
            factors = self.factors[scene.material.poisson_ratio]
            profile = Profile(ZoneFields(factors, load, zones, rule))
            known = "converged", followed.estimate, statistics
            self.solutions[i] = Solution(scene, *known, profile, stress)
