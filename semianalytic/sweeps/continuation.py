"""The continuation of zones in friction: found at a few values, followed through the others.

Edges are smooth functions of friction as long as the zones stay the same.  Next to frictions
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

from semianalytic.cut.load import common_load, scaled_load
from semianalytic.cut.profile import Profile
from semianalytic.cut.zones import ZoneFields
from semianalytic.halfplane.rayleigh import Array
from semianalytic.halfplane.rules import rule_for
from semianalytic.scene.scene import Scene
from semianalytic.selfsimilar.solution import Solution
from semianalytic.selfsimilar.solver import solve
from semianalytic.selfsimilar.statistics import Statistics
from semianalytic.selfsimilar.zones.edges import Edges, edges_of, moves
from semianalytic.selfsimilar.zones.estimate import loose_tolerance
from semianalytic.selfsimilar.zones.tuning import FARTHEST, NUDGE
from semianalytic.sweeps import tuning
from semianalytic.sweeps.batches import Prediction, ZoneSets, batches, continued, linearised
from semianalytic.sweeps.interpolation import confirmed, fits, interpolated, lagrange

FROM_SCRATCH, COMPUTED, INTERPOLATED = "from scratch", "computed", "interpolated"
"""Origins of a solution: without help from neighbours, corrected from a prediction, interpolated
and checked on the loose rule alone."""


@dataclass(frozen=True)
class KnownZones:
    """Zones known at one friction; `inverse` is on the loose rule, None if not yet formed."""

    edges: Edges
    unknowns: Array
    inverse: Array | None
    tolerance: float
    estimate: float
    slope: Array | None = None  # of the unknowns over friction, where solved from scratch


class Continuation:
    """The solutions so far of scenes with ascending friction, and the zones known at them."""

    def __init__(self, scenes: Sequence[Scene], rtol: float, unit: float | None = None) -> None:
        self.scenes, self.rtol = scenes, rtol
        self.friction = np.array([scene.coefficient for scene in scenes])
        # One unit of stress for all scenes, so that their loads can stand in one array.
        self.unit = unit or min((scaled_load(scene)[1] for scene in scenes), default=1.0)
        self.solutions: dict[int, Solution] = {}
        self.origin: dict[int, str] = {}
        self.zones: dict[int, KnownZones] = {}
        self.tried: set[tuple[Edges | None, int, tuple[int, ...]]] = set()
        self.pending: dict[int, KnownZones] = {}  # interpolated, not yet confirmed
        self.refused: set[int] = set()  # interpolated, but not confirmed
        self.stencils: set[tuple[int, ...]] = set()  # that were interpolated through

    def run(self) -> None:
        """Solve all scenes."""
        count = len(self.scenes)
        if not count:
            return
        # Evenly spaced in the order of frictions, not in their values: a sweep that is dense
        # somewhere is meant to be dense there.
        # Half as many take 5 % more work, twice as many 5 % less.
        first = np.linspace(0, count - 1, 2 if self.zones else min(count, 7)).round()
        for i in set(first.astype(int).tolist()) - self.solutions.keys():
            self._solve(i)
        # Each round fills what interpolates well, then tries zones known at both ends of each gap;
        # where everything has been tried, `_proposed` solves the middle, so that the loop ends.
        while len(self.solutions) < count:
            self._interpolate()
            proposed = self._proposed()
            for edges, targets in proposed.items():
                self._continue(edges, targets)
            # Confirmed last and together: until then a gap may still close by computed neighbours.
            if len(self.solutions) + len(self.pending) == count:
                self._confirm()

    def extended(self, scenes: Sequence[Scene]) -> Continuation:
        """Return a continuation through these scenes too, which those that are known help."""
        every = {scene.coefficient: scene for scene in (*scenes, *self.scenes)}
        places = {friction: i for i, friction in enumerate(sorted(every))}
        longer = Continuation([every[place] for place in places], self.rtol, self.unit)
        for name in ("solutions", "origin", "zones"):
            for i, known in getattr(self, name).items():
                getattr(longer, name)[places[self.scenes[i].coefficient]] = known
        return longer

    def _nodes(self) -> list[int]:
        """Return the frictions, in order, that were solved and not interpolated."""
        return sorted(i for i, origin in self.origin.items() if origin != INTERPOLATED)

    def _gaps(self) -> list[tuple[int, int, list[int]]]:
        """Return neighbours among `_nodes`, and the frictions between them that are still open."""
        gaps, done = [], self.solutions.keys() | self.pending.keys()
        for i, j in pairwise(self._nodes()):
            inside = [k for k in range(i + 1, j) if k not in done]
            if inside:
                gaps.append((i, j, inside))
        return gaps

    def _edges(self, i: int) -> Edges | None:
        return self.zones[i].edges if i in self.zones else None

    def _proposed(self) -> dict[Edges, list[int]]:
        """Return the scenes to try next, by edges that have not failed; else solve the middle."""
        proposed: dict[Edges, list[int]] = {}
        between: dict[Edges, list[int]] = {}
        for left, right, inside in self._gaps():
            edges = self._edges(left)
            # Points between equal zones probably have the same ones, and may fill up a batch
            # below.
            if edges is not None and edges == self._edges(right):
                between.setdefault(edges, []).extend(inside)
            fresh = [trial for trial in self._tries(left, right, inside) if trial not in self.tried]
            self.tried |= set(fresh)
            for edges, _, targets in fresh:
                if edges is not None:
                    fitting = [i for i in targets if fits(edges, self.scenes[i])]
                    proposed.setdefault(edges, []).extend(fitting)
            if not fresh:
                self._solve(inside[len(inside) // 2])
        for edges, some in proposed.items():  # a batch costs little more for being full
            every = {*some, *between.get(edges, [])}
            if len(every) <= tuning.BATCH:
                some[:] = [i for i in every if fits(edges, self.scenes[i])]
        return proposed

    def _tries(
        self, left: int, right: int, inside: list[int]
    ) -> list[tuple[Edges | None, int, tuple[int, ...]]]:
        """Return edges to try in a gap, the end at which they are known, and the frictions.

        A few are tried between equal sets of zones, a few from either side between different ones.
        """
        at_left, at_right, count = self._edges(left), self._edges(right), len(inside)
        if at_left == at_right:
            parts = 1
            if count > tuning.HALVED_GAP:
                parts = min(7, -(-count // tuning.HALVED_GAP))
            # The points tried divide the gap evenly and leave out its ends, which are known.
            step = count // (parts + 1)
            return [(at_left, left, tuple(inside[step :: step + 1][:parts]))]
        if count < 3:  # closer to a change neither set is tried; twice: 19 % less work
            return []
        # Somewhere in the gap zones change: each set is tried over the half near its own end,
        # from there inward.
        step, most = -(-count // 8), 4  # four from either side; with two work is 16 % less
        offsets = [k * step - 1 for k in range(1, most + 1) if k * step <= count]
        from_left = tuple(inside[k] for k in offsets)
        from_right = tuple(inside[-1 - k] for k in offsets)
        return [(at_left, left, from_left), (at_right, right, from_right)]

    def _solve(self, i: int) -> None:
        """Solve a scene from scratch."""
        solution = solve(self.scenes[i], rtol=self.rtol)
        self.origin[i] = FROM_SCRATCH
        self.solutions[i] = solution
        fields = solution.profile.fields
        load = fields.load
        # Without friction edges do not move with it, and near an opening they depend on its ends,
        # which the batches do not follow; such scenes are solved one by one.
        if solution.status == "converged" and not (load.frictionless or load.opened):
            edges, unknowns = edges_of(fields.factors, fields.zones)
            tolerance, estimate = fields.rule.tolerance, solution.error_estimate
            self.zones[i] = KnownZones(edges, unknowns, None, tolerance, estimate)

    def _with_jacobians(self, edges: Edges) -> list[int]:
        """Return the frictions, in order, known to have some edges; one at least has a Jacobian."""
        nodes = sorted(i for i, known in self.zones.items() if known.edges == edges)
        if any(self.zones[i].inverse is not None for i in nodes):
            return nodes
        rule = rule_for(loose_tolerance(self.rtol))
        for batch in batches(edges, [self.zones[i].unknowns for i in nodes]):
            chosen = [nodes[j] for j in batch]
            start = np.array([self.zones[i].unknowns for i in chosen]).T.reshape(-1, len(chosen))
            inverse, slope = np.zeros((len(chosen), 0, 0)), start
            if edges.segments:
                # The slope of the unknowns over friction, -J^-1 dF/df, makes a first prediction of
                # first order where only one friction is known.
                step = NUDGE * self.friction[chosen]
                scenes = [self.scenes[i] for i in chosen]
                beside = [
                    replace(scene, friction=scene.law.with_coefficient(scene.coefficient + h))
                    for scene, h in zip(scenes, step, strict=True)
                ]
                sets = ZoneSets(edges, common_load(scenes, self.unit))
                inverse, values = linearised(sets, start, rule)
                change = edges.mismatch(start, common_load(beside, self.unit), rule) - values
                slope = -moves(inverse, change) / step
            for i, matrix, gain in zip(chosen, inverse, slope.T, strict=True):
                self.zones[i] = replace(self.zones[i], inverse=matrix, slope=gain)
        return nodes

    def _inverse_near(self, nodes: list[int], i: int) -> Array:
        """Return the inverse Jacobian at a friction from the nearest of `nodes` that have one."""
        with_one = [j for j in nodes if self.zones[j].inverse is not None]
        place = bisect(with_one, i)
        # The neighbours to the left and to the right; at the ends of the range there is one alone.
        pair = with_one[max(0, place - 1) : place + 1]
        if len(pair) == 1 or pair[0] == i:
            pair = pair[:1]
        weights = lagrange(self.friction[pair], self.friction[i])
        parts = zip(weights, pair, strict=True)
        return np.asarray(sum(w * self.zones[j].inverse for w, j in parts))

    def _prediction(self, nodes: list[int], i: int) -> Prediction:
        """Predict the zones at a friction from the nearest known ones, by Lagrange's formula."""
        place = bisect(nodes, i)
        # Three to either side; half, twice: 2 % and 7 % more work.
        near = nodes[max(0, place - 3) : place + 3]
        stencil = sorted(near, key=lambda j: abs(self.friction[j] - self.friction[i]))
        known, count = [self.zones[j] for j in stencil], len(stencil)
        unknowns = np.array([zone.unknowns for zone in known])
        value = lagrange(self.friction[stencil], self.friction[i]) @ unknowns
        doubt, first = np.inf, known[0]
        if count == 1 and first.slope is not None:
            value = value + first.slope * (self.friction[i] - self.friction[stencil[0]])
        # The doubt is the change by the last two nodes: polynomials one degree apart can agree by
        # symmetry.
        elif count > 2:
            fewer = lagrange(self.friction[stencil[: count - 2]], self.friction[i])
            doubt = float(np.abs(value - fewer @ unknowns[: count - 2]).max(initial=0.0))
        # Beyond, an edge is at its front to rounding; an extrapolation may go anywhere.
        value = np.clip(value, -FARTHEST, FARTHEST)
        return Prediction(value, self._inverse_near(nodes, i), doubt, first.tolerance)

    def _continue(self, edges: Edges, targets: list[int]) -> None:
        """Try one set of zones at some frictions; keep those that satisfy Coulomb's law."""
        nodes = self._with_jacobians(edges)
        targets = sorted(i for i in set(targets) if i not in self.solutions)
        predictions = [self._prediction(nodes, i) for i in targets]
        trusted = [prediction.doubt < tuning.TRUSTED_DOUBT for prediction in predictions]
        for batch in batches(edges, [prediction.unknowns for prediction in predictions], trusted):
            start = perf_counter()
            chosen = [targets[j] for j in batch]
            load = common_load([self.scenes[i] for i in chosen], self.unit)
            # Edges that cross a cut of the panels on their way give no numbers, and are dropped.
            with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
                chosen_predictions = [predictions[j] for j in batch]
                corrected = continued(ZoneSets(edges, load), chosen_predictions, self.rtol)
            seconds = (perf_counter() - start) / len(batch)
            for j in np.flatnonzero(corrected.sound):
                i, estimate = chosen[j], float(corrected.estimate[j])
                unknowns, tolerance = corrected.unknowns[:, j], float(corrected.tolerances[j])
                known = KnownZones(edges, unknowns, corrected.inverse[j], tolerance, estimate)
                self.zones[i], self.origin[i] = known, COMPUTED
                self._add(i, known, corrected.steps, corrected.nodes, seconds)

    def _add(self, i: int, known: KnownZones, steps: int, nodes: int, seconds: float) -> None:
        scene, edges = self.scenes[i], known.edges
        load, stress = scaled_load(scene)
        # The fields are formed anew for the single friction: those of the batch hold all columns,
        # and would keep the whole batch in memory.
        zones = edges.zones(known.unknowns)
        profile = Profile(ZoneFields(edges.factors, load, zones, rule_for(known.tolerance)))
        stages = {"zones": 0.0, "edges": seconds, "check": 0.0}
        statistics = Statistics(0, steps, 1, len(known.unknowns), nodes, stages)
        found = "converged", known.estimate, statistics
        self.solutions[i] = Solution(scene, *found, profile, stress)

    def _interpolate(self) -> None:
        """Interpolate between known frictions with the same zones, where it is accurate enough."""
        for left, right, inside in self._gaps():
            edges = self._edges(left)
            inside = [i for i in inside if i not in self.refused]
            if edges is None or edges != self._edges(right) or not inside:
                continue
            stencil = self._stencil(left, right)
            # The same nodes would give the same refusal again.
            if stencil and (left, *stencil) not in self.stencils:
                self.stencils.add((left, *stencil))
                self.pending.update(self._between(stencil, left, right, inside))

    def _stencil(self, left: int, right: int) -> list[int]:
        """Return known frictions of the same zones around a gap, nearest first; none if too few."""
        nodes = self._nodes()
        edges, place = self._edges(left), nodes.index(left)
        below, above = place, place + 1
        last, most = len(nodes) - 1, tuning.MOST_INTERPOLATED
        while below > 0 and place - below < most and self._edges(nodes[below - 1]) == edges:
            below -= 1
        while above < last and above - place < most and self._edges(nodes[above + 1]) == edges:
            above += 1
        # A gap that borders on other zones hides a threshold, where edges go like a root of
        # friction: no polynomial may reach across or up to it.
        if (below == place and left > 0) or (above == place + 1 and right < len(self.scenes) - 1):
            return []
        middle = (self.friction[left] + self.friction[right]) / 2
        around = nodes[below : above + 1]
        stencil = sorted(around, key=lambda j: abs(float(self.friction[j]) - middle))[:most]
        few = edges is not None and bool(edges.segments) and len(stencil) < 5
        return [] if few else stencil

    def _between(
        self, stencil: list[int], left: int, right: int, inside: list[int]
    ) -> dict[int, KnownZones]:
        """Return the interpolated zones whose error estimate is below rtol."""
        known = [self.zones[j] for j in stencil]
        edges, tolerance = known[0].edges, min(self.zones[i].tolerance for i in (left, right))
        unknowns, at = np.array([zone.unknowns for zone in known]), self.friction[stencil]
        known_to = max(zone.estimate for zone in known), self.rtol
        values, estimate = interpolated(edges, at, unknowns, self.friction[inside], *known_to)
        good = estimate <= self.rtol
        if edges.segments:
            good &= edges.admits(values.T)
        return {
            inside[k]: KnownZones(edges, values[k], None, tolerance, float(estimate[k]))
            for k in np.flatnonzero(good)
        }

    def _confirm(self) -> None:
        """Keep interpolated zones that pass Coulomb's law and edge conditions on the loose rule."""
        by_edges: dict[Edges, list[int]] = {}
        for i in sorted(self.pending):
            by_edges.setdefault(self.pending[i].edges, []).append(i)
        loose = loose_tolerance(self.rtol)
        for edges, targets in by_edges.items():
            nodes = self._with_jacobians(edges)
            for batch in batches(edges, [self.pending[i].unknowns for i in targets]):
                start, chosen = perf_counter(), [targets[j] for j in batch]
                load = common_load([self.scenes[i] for i in chosen], self.unit)
                columns = [self.pending[i].unknowns for i in chosen]
                inverse = np.array([self._inverse_near(nodes, i) for i in chosen])
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
