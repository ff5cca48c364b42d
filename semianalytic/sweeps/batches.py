"""Correction of the zones of many frictions at once, the batched part of `sweep`."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from semianalytic.cut.load import Load
from semianalytic.cut.profile import Profile
from semianalytic.cut.zones import ZoneFields
from semianalytic.halfplane.rules import Rule, rule_for
from semianalytic.scene.arrays import Array
from semianalytic.selfsimilar.zones.coulomb import admissible
from semianalytic.selfsimilar.zones.edges import Edges, moves
from semianalytic.selfsimilar.zones.estimate import difference, loose_tolerance, missed_slip
from semianalytic.selfsimilar.zones.tuning import (
    COARSER_COMPANION,
    HOPED_ERROR,
    LEAST_LEFT_SHIFT,
    LEFT_SHIFT,
    SAFETY,
)
from semianalytic.sweeps import tuning


@dataclass(frozen=True)
class ContinuedZones:
    """Sets of zones of neighbouring frictions, k columns of unknowns, and how they were found.

    inverse (k, e, e) is that of the Jacobian, tolerances (k,) are those of their rules, nodes the
    number per set on the last.
    """

    unknowns: Array
    estimate: Array
    sound: np.ndarray
    inverse: Array
    tolerances: Array
    steps: int
    nodes: int


@dataclass(frozen=True)
class ZoneSets:
    """A group of k sets of zones with the same kinds of edges, and their loads."""

    edges: Edges
    load: Load

    def chosen(self, which: np.ndarray) -> ZoneSets:
        """Return some of the sets; all of them are the same object, with its cached values."""
        if len(which) == np.size(self.load.friction) and np.all(np.diff(which) == 1):
            return self
        friction, far = np.asarray(self.load.friction), np.asarray(self.load.far_slip_rate)
        load = replace(self.load, friction=friction[which], far_slip_rate=far[which])
        return ZoneSets(self.edges.chosen(which), load)

    def fields(self, unknowns: Array, rule: Rule) -> ZoneFields:
        """Return the fields of the sets at unknowns (e, k) on a rule."""
        return ZoneFields(self.edges.factors, self.load, self.edges.zones(unknowns), rule)

    def mismatch(self, unknowns: Array, rule: Rule) -> Array:
        """Return the residuals of the edge conditions, (e, k)."""
        return self.edges.mismatch(unknowns, self.load, rule)


def linearised(sets: ZoneSets, unknowns: Array, rule: Rule) -> tuple[Array, Array]:
    """Return inverse Jacobians (k, e, e) and mismatches (e, k) at unknowns; NaN if singular."""
    size, count = unknowns.shape
    # All differences of all sets are evaluated in one sweep: each set stands next to its e
    # neighbours, of which neighbour j has the unknown j nudged.
    nudges = sets.edges.nudges(unknowns)
    neighbours = np.repeat(unknowns[:, :, None], size + 1, axis=2)
    neighbours[np.arange(size), :, np.arange(1, size + 1)] += nudges
    repeated = sets.chosen(np.repeat(np.arange(count), size + 1))
    values = repeated.mismatch(neighbours.reshape(size, -1), rule).reshape(neighbours.shape)
    jacobian = np.moveaxis(values[..., 1:] - values[..., :1], 0, 1) / nudges.T[:, None, :]
    try:
        inverse = np.asarray(np.linalg.inv(jacobian))
    except np.linalg.LinAlgError:
        # One singular matrix stops numpy for the whole batch; its sets are then solved one by one
        # from scratch.
        inverse = np.full_like(jacobian, np.nan)
    return inverse, values[..., 0]


def newton(sets: ZoneSets, start: Array, rule: Rule) -> tuple[Array, Array, Array, int]:
    """Return unknowns (e, k) on a rule, inverse Jacobians, last moves (inf if they fail), and
    steps.
    """
    size, count = start.shape
    unknowns, inverse = start.copy(), np.zeros((count, size, size))
    waiting = np.flatnonzero(sets.edges.admits(unknowns))
    last, previous = np.full(count, np.inf), np.full(count, np.inf)
    step = 0
    while len(waiting) and step < tuning.MOST_STEPS:
        step += 1
        part = linearised(sets.chosen(waiting), unknowns[:, waiting], rule)
        inverse[waiting] = part[0]
        move = -moves(*part)
        largest = np.abs(move).max(axis=0)
        finite = largest < np.inf
        waiting, move, largest = waiting[finite], move[:, finite], largest[finite]
        if not len(waiting):
            break
        # A long move is shortened, not refused: unknowns are logarithms of distances from fronts,
        # and a linear model holds over about one e-fold of them.
        share = np.minimum(1.0, 1.5 / np.maximum(largest, 1e-300))
        unknowns[:, waiting] += move * share
        admitted = sets.edges.chosen(waiting).admits(unknowns[:, waiting])
        # Quadratic convergence at least halves each move; what does not is no root of these zones,
        # or too far from it to be worth more steps.
        admitted &= largest < tuning.SLOW * previous[waiting]
        previous[waiting] = largest
        # Newton's error after a move of this size is about its square, hence the caller's
        # contraction of twice the move.
        last[waiting] = np.where(admitted & (largest < tuning.NEAR), largest, np.inf)
        waiting = waiting[admitted & (largest >= tuning.NEAR)]
    return unknowns, inverse, last, step


@dataclass(frozen=True)
class _PolishedZones:
    """Sets of zones on a rule: indices, unknowns (e, k), bounds of their errors, their fields."""

    kept: np.ndarray
    settled: np.ndarray
    unknowns: Array
    left: Array
    beside: Array
    fields: ZoneFields
    steps: int


def _polished(
    sets: ZoneSets, start: Array, inverse: Array, contraction: Array, rtol: float, tolerance: float
) -> _PolishedZones:
    """Take chord steps on the rule of a tolerance until the mismatch is negligible.

    A step leaves `contraction` (k,) of itself, or what is observed; fields are those before the
    last.
    """
    kept, unknowns, rule = np.arange(start.shape[1]), start, rule_for(tolerance)
    previous, sound = np.full(len(kept), np.inf), np.zeros(len(kept), dtype=bool)
    for step in range(tuning.MOST_STEPS):
        beside, left = unknowns, np.zeros(len(kept))
        going = sets.chosen(kept)
        fields = going.fields(beside, rule)
        # Zones without edges (slip everywhere, or none) have no unknowns to improve: the fields
        # alone are wanted.
        if not len(start):
            sound[:] = True
            break
        move = -moves(inverse[kept], fields.mismatch())
        unknowns, size = beside + move, np.abs(move).max(axis=0)
        # The observed contraction counts where it is worse than the predicted one, never where it
        # is better: two steps may agree by chance.
        contraction[kept] = np.maximum(contraction[kept], size / previous)
        left = size * contraction[kept]
        near = left <= max(LEFT_SHIFT * rtol, LEAST_LEFT_SHIFT)
        # The fields are those before the last step, so that this step itself has to be small, not
        # only what it leaves.
        settled = near & (size <= 10 * rtol)  # longest last move of an edge unknown
        converging = going.edges.admits(unknowns) & (size < tuning.SLOW * previous)
        if np.all(settled | ~converging) or step == tuning.MOST_STEPS - 1:
            sound[kept] = settled
            # Sets that did not settle keep the unknowns that belong to `fields`; they are refused
            # by the caller.
            unknowns = np.where(settled, unknowns, beside)
            break
        kept, unknowns, previous = kept[converging], unknowns[:, converging], size[converging]
    return _PolishedZones(kept, sound[kept], unknowns, left, beside, fields, step + 1)


def _estimates(
    edges: Edges, zones: _PolishedZones, profile: Profile, inverse: Array, tolerance: float
) -> Array:
    """Return error estimates (k,) of sets on the rule of a tolerance: companion, shifts, missed
    slip.
    """
    fields = profile.fields
    rule = rule_for(COARSER_COMPANION * tolerance)
    coarse = replace(fields, rule=rule)
    moved = zones.beside
    if edges.segments:
        # A coarser rule shifts the edges by one chord step; the clip keeps a set on a nearly
        # singular Jacobian from overflowing, and its estimate is too large for any rtol anyway.
        moved = moved - np.clip(moves(inverse, coarse.mismatch()), -1.0, 1.0)
    others = SAFETY * zones.left + missed_slip(profile)
    return difference(edges, zones.unknowns, moved, fields, coarse) + others


def continued(
    sets: ZoneSets, start: Array, inverse: Array, doubt: Array, tolerances: Array, rtol: float
) -> ContinuedZones:
    """Compute edges from predictions, with error estimates and checks.

    Edges whose error estimate exceeds rtol are computed on finer rules.

    Parameters
    ----------
    start : (e, k) array
        Predicted unknowns.
    inverse : (k, e, e) array
        Inverse Jacobians from neighbours.
    doubt, tolerances : (k,) arrays
        Bounds of the errors of the unknowns, and tolerances of the rules that are probably needed.
    """
    unknowns, tolerances = start.copy(), tolerances.copy()
    size, count = unknowns.shape
    estimate, sound = np.full(count, np.inf), np.zeros(count, dtype=bool)
    kept, steps, nodes = np.arange(count), 0, 0
    # Share of itself that a chord step leaves, by the doubt of its prediction.
    contraction = np.maximum(20.0 * doubt, tuning.LEAST_CONTRACTION)
    # Trusted predictions are about as near to the edges as the loose rule would bring them, and go
    # straight to finer ones.
    far = np.flatnonzero(doubt >= tuning.TRUSTED_DOUBT)
    if size and len(far):
        loose, inverse = loose_tolerance(rtol), inverse.copy()
        coarse = rule_for(max(loose, tuning.COARSEST))
        found = newton(sets.chosen(far), unknowns[:, far], coarse)
        unknowns[:, far], inverse[far], last, steps = found
        contraction[far] = np.maximum(2 * last, tuning.LEAST_CONTRACTION)
        kept = np.flatnonzero(contraction < np.inf)
        # Rules so far apart need a chord step on one between them.
        if len(kept) and tolerances[kept].min() < 1e-2 * loose:
            # The geometric mean: one step there is cheaper than a second step on the finest rule.
            between = rule_for(float(np.sqrt(loose * tolerances[kept].min())))
            going = sets.chosen(kept)
            unknowns[:, kept] -= moves(inverse[kept], going.mismatch(unknowns[:, kept], between))
            kept = kept[going.edges.admits(unknowns[:, kept])]
            steps += 1
    for _ in range(3):
        if not len(kept):
            break
        # The loosest rule that any set still asks for: sets that need a finer one come again in the
        # next round, with the tolerance that their estimate suggests.
        finest = float(tolerances[kept].max())
        going, parts = sets.chosen(kept), (unknowns[:, kept], inverse[kept], contraction[kept])
        zones = _polished(going, *parts, rtol, finest)
        going = going.chosen(zones.kept)
        kept, steps = kept[zones.kept], steps + zones.steps
        unknowns[:, kept], tolerances[kept] = zones.unknowns, finest
        profile, nodes = Profile(zones.fields), zones.fields.panels.jacobian[:, 0].size
        lawful = zones.settled & admissible(profile, min(rtol, tuning.LOOSEST_LAW))
        estimate[kept] = _estimates(going.edges, zones, profile, inverse[kept], finest)
        sound[kept] = lawful & (estimate[kept] <= rtol)
        kept = kept[lawful & ~sound[kept]]
        # Errors fall about as the tolerance, so that the ratio of the wanted to the found error is
        # the next change of the rule.
        finer = HOPED_ERROR * rtol / estimate[kept]
        tolerances[kept] *= np.maximum(finer, 1e-3)
    return ContinuedZones(unknowns, estimate, sound, inverse, tolerances, steps, nodes)
