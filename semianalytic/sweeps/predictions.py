"""Zones at many points of friction and Poisson ratio, predicted from neighbours and corrected.

A prediction is corrected on a loose rule.  The error of edges on that rule is known at neighbours;
it is far less than the tolerance of the rule, and is part of the error estimate.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from semianalytic.cut.profile import Profile
from semianalytic.cut.quadrature.layout import Zone
from semianalytic.cut.zones import ZoneFields
from semianalytic.halfplane.rules import rule_for
from semianalytic.scene.arrays import Array
from semianalytic.selfsimilar.zones.coulomb import admissible
from semianalytic.selfsimilar.zones.edges import moves
from semianalytic.selfsimilar.zones.estimate import loose_tolerance, missed_slip, shift_error
from semianalytic.selfsimilar.zones.tuning import FARTHEST, SAFETY
from semianalytic.sweeps import tuning
from semianalytic.sweeps.batches import ZoneSets, newton
from semianalytic.sweeps.neighbours import Neighbourhood, Stencils

Pattern = tuple[tuple[Zone, ...], tuple[bool, bool], tuple[int, ...]]
"""Kinds, open ends and segments of `Edges`, whatever the Poisson ratio."""


@dataclass(frozen=True)
class Followed:
    """Zones at one point.

    Where Newton's method found them there is an inverse Jacobian (e, e), and on the fine rule, once
    it is measured, `lack`, the error of edges that are right on the loose rule.
    """

    pattern: Pattern
    unknowns: Array
    tolerance: float
    estimate: float
    inverse: Array | None = None
    lack: float | None = None


@dataclass(frozen=True)
class Predictions:
    """Zones of one pattern predicted at t points.

    Attributes
    ----------
    points : (t,) indices of the points
    unknowns : (t, e) array
    doubt : (t,) array, how far these may be off
    inverse, others : (t, e, e) inverse Jacobians, from two polynomials
    tolerance : (t,), of the fine rule
    loose : (t,), of the loosest rule on which edges lack little
    estimate : (t,) largest error estimate of neighbours, and what edges lack on that rule
    """

    points: np.ndarray
    unknowns: Array
    doubt: Array
    inverse: Array
    others: Array
    tolerance: Array
    loose: Array
    estimate: Array

    def __len__(self) -> int:
        return len(self.points)

    def __getitem__(self, which: np.ndarray) -> Predictions:
        """Return some of the predictions."""
        return Predictions(*(getattr(self, field.name)[which] for field in fields(self)))


def predicted(
    known: Sequence[Followed], at: Array, points: np.ndarray, places: Array, rtol: float
) -> Predictions:
    """Predict zones at places (t, 2) of points (t,) from those of one pattern known at others."""
    values = np.array([zone.unknowns for zone in known])
    unknowns, doubt, shared = _between(Neighbourhood(at).stencils(places), values)
    # Points corrected by chord steps have no Jacobian of their own: they predict edges alone.
    led = np.array([zone.inverse is not None for zone in known])
    # Inverse Jacobians need fewer digits than edges, and so half as many neighbours.
    stencils = Neighbourhood(at[led]).stencils(places, 16)
    # Where shares are interpolated, so are the rows of the inverse Jacobian with respect to shares,
    # by the chain rule; `back` returns to unknowns.
    slopes = np.where(shared, _share_slope(values), 1.0)
    scaled = np.array([zone.inverse for zone in known if zone.inverse is not None])
    scaled *= slopes[led, :, None]
    back = np.where(shared, _share_slope(unknowns), 1.0)[..., None]
    inverse, others = (table / back for table in stencils.blended(scaled, values[led]))
    # Those from the fine rule alone say what others lack.
    footed = [zone for zone in known if zone.lack is not None]
    firm = Neighbourhood(at[[zone.lack is not None for zone in known]])
    near = firm.nearest(places, tuning.CERTAIN_NEIGHBOURS)
    # The median: a single neighbour on a very fine rule, near a threshold, does not make all
    # points around it expensive.
    tolerance = np.median(np.array([zone.tolerance for zone in footed])[near], axis=1)
    nearest = near[:, :4]  # the largest error estimate of the nearest four
    # The largest error of the nearest neighbours is taken over: a point between them is not known
    # better than they are.
    estimate = np.array([zone.estimate for zone in footed])[nearest].max(axis=1)
    lacks = np.array([zone.lack for zone in footed])[near]
    # What differs by much among neighbours may go on to rise beyond them, towards a threshold.
    rising = lacks.max(axis=1) / np.maximum(np.median(lacks, axis=1), tuning.LEAST_LACK)
    shift = lacks.max(axis=1) * np.sqrt(np.clip(rising, 1.0, tuning.MOST_RISING))
    # The share of the estimate for the error of a looser rule, never 0, so that
    # the logarithm below exists.
    room = np.maximum(rtol - estimate, 0.05 * rtol)
    loose = np.maximum(_loose_enough(shift, room, rtol), tolerance)
    share = (loose / loose_tolerance(rtol)) ** tuning.LACK_ORDER
    # On the fine rule itself nothing is lacking that the neighbours' estimates do not hold.
    lacking = np.where(loose > tolerance, SAFETY * shift * share, 0.0)
    return Predictions(
        points, unknowns, doubt, inverse, others, tolerance, loose, estimate + lacking
    )


@np.errstate(invalid="ignore", divide="ignore")  # of polynomials that leave 0 to 1: no number
def _between(stencils: Stencils, values: Array) -> tuple[Array, Array, np.ndarray]:
    """Interpolate unknowns (t, e), with bounds of their errors (t,), between known ones (n, e).

    For some edges (e,) shares 1 / (1 + exp(-u)) are: one of the two is smooth near a segment's end.
    """
    share = 1 / (1 + np.exp(-values))
    by_share = tuple(np.log(x / (1 - x)) for x in stencils.of_each(share))
    plain = stencils.of_each(values)
    apart, off = (np.nan_to_num(np.abs(a - b), nan=np.inf) for a, b in (plain, by_share))
    # One choice for each edge, by the median over the points, so that rows of Jacobians from
    # different points can be blended.
    shared = np.median(off, axis=0) < np.median(apart, axis=0)
    result = np.clip(np.nan_to_num(np.where(shared, by_share[0], plain[0])), -FARTHEST, FARTHEST)
    return result, np.where(shared, off, apart).max(axis=1, initial=0.0), shared


def _share_slope(unknowns: Array) -> Array:
    """Return the derivative of 1 / (1 + exp(-u))."""
    return np.asarray(1 / (2 + np.exp(unknowns) + np.exp(-unknowns)))


def _loose_enough(shift: Array, room: Array, rtol: float) -> Array:
    """Return tolerances, in steps, of loose rules whose errors (t,) take a share of the room."""
    most = 0.5 * room / SAFETY  # half of what rtol leaves
    decades = np.log10(np.maximum(shift / most, 1.0)) / tuning.LACK_ORDER
    steps = np.ceil(decades / tuning.RULE_STEP)
    return np.asarray(loose_tolerance(rtol) * 10 ** (-tuning.RULE_STEP * steps))


def joined(parts: Sequence[Predictions]) -> Predictions:
    """Join the predictions of several batches."""
    every = ([getattr(part, field.name) for part in parts] for field in fields(parts[0]))
    return Predictions(*map(np.concatenate, every))


@dataclass(frozen=True)
class CorrectedZones:
    """Corrected unknowns (e, k), error estimates (k,), which are sound, of which Coulomb's law says
    on the fine rule that there are other zones, and nodes per set; and the predictions, those that
    were far off moved near their places by Newton's method, with `LOCATED` for doubt."""

    unknowns: Array
    estimate: Array
    sound: np.ndarray
    refuted: np.ndarray
    nodes: int
    approached: Predictions


def corrected(
    sets: ZoneSets, predictions: Predictions, certain: np.ndarray, rtol: float
) -> CorrectedZones:
    """Correct predictions on the loosest rule that is accurate enough, and check Coulomb's law.

    The check is as strict as that rule allows, or, where the zones are not certain (k,), as strict
    as on the fine rule.
    """
    loosest = loose_tolerance(rtol)
    unknowns, inverse = predictions.unknowns.T.copy(), predictions.inverse.copy()
    # Near predictions need no steps on the loosest rule: their first step is the chord step below.
    sound = np.ones(len(predictions), dtype=bool)
    far = np.flatnonzero(predictions.doubt >= tuning.NEAR)
    doubt = np.full(len(predictions), tuning.LEADING_DOUBT)  # of what fails below
    # Amid far neighbours both inverse Jacobians were 17 % off, and agreed to 0.2 %.
    others, share = predictions.others.copy(), np.full(len(predictions), 0.2)
    if len(unknowns) and len(far):
        coarse = rule_for(max(loosest, tuning.COARSEST))
        found, better, last, _ = newton(sets.chosen(far), unknowns[:, far], coarse)
        sound[far] = near = last < np.inf
        far = far[near]
        unknowns[:, far], inverse[far], others[far] = found[:, near], better[near], better[near]
        # A chord step with Newton's own inverse leaves what `continued` expects of one.
        share[far] = np.maximum(2 * last[near], tuning.LEAST_CONTRACTION)
        doubt[far] = tuning.LOCATED
    moved = {"unknowns": unknowns.T.copy(), "inverse": inverse, "others": others, "doubt": doubt}
    nearer = replace(predictions, **moved)
    # The least tolerance of the batch serves all of its points, which share panels.
    fields = sets.fields(unknowns, rule_for(float(predictions.loose.min())))
    estimate = predictions.estimate.copy()
    if len(unknowns):
        unknowns, left = _stepped(sets, nearer, fields, share, rtol - estimate)
        sound &= sets.edges.admits(unknowns)
        # `left` is what the chord steps leave; the estimate held neighbours' errors and the lack of
        # the rule.
        estimate += SAFETY * left
        kept = np.flatnonzero(sound & (estimate <= rtol))
        lacking = _found_lacking(sets, unknowns, nearer, kept)
        estimate = np.maximum(estimate, SAFETY * lacking)
    sound &= estimate <= rtol
    lawful = ~certain
    if certain.any():
        lawful |= admissible(Profile(fields), tuning.LOOSE_CHECK * loosest)
    asked = np.flatnonzero(sound & ~certain)
    if len(asked):  # of edges in their places, on the fine rule
        rule = rule_for(float(predictions.tolerance[asked].min()))
        profile = Profile(sets.chosen(asked).fields(unknowns[:, asked], rule))
        lawful[asked] = admissible(profile, min(rtol, tuning.LOOSEST_LAW))
        # Next to other zones a small one may lie between the nodes; where neighbours all agree,
        # their own estimates hold it.
        estimate[asked] += missed_slip(profile)
        sound &= estimate <= rtol
    refuted = sound & ~lawful & ~certain
    nodes = fields.panels.jacobian[:, 0].size
    return CorrectedZones(unknowns, estimate, sound & lawful, refuted, nodes, nearer)


def _found_lacking(
    sets: ZoneSets, unknowns: Array, predictions: Predictions, kept: np.ndarray
) -> float:
    """Return the error on its fine rule of the kept set with the narrowest gap; 0 without one.

    On panels that sets with narrow gaps share, edges may lack a hundred times what they do alone.
    """
    gap = np.abs(sets.edges.parts(unknowns)[3]).min(axis=0)
    if len(gap) < 2 or gap[kept].min(initial=1.0) > tuning.NARROW_GAP:
        return 0.0
    at = kept[[np.argmin(gap[kept])]]
    one, now = sets.chosen(at), unknowns[:, at]
    fields = one.fields(now, rule_for(float(predictions.tolerance[at[0]])))
    moved = now - moves(predictions.inverse[at], fields.mismatch())
    return float(shift_error(one.edges, now, moved, fields)[0])


def _stepped(
    sets: ZoneSets, start: Predictions, fields: ZoneFields, share: Array, room: Array
) -> tuple[Array, Array]:
    """Return unknowns (e, k) after chord steps from `start`, and the error that is left (k,).

    It is what two inverse Jacobians disagree upon, at least a share (k,) of the first step, or what
    the last step leaves.
    """
    values = fields.mismatch()
    move = -moves(start.inverse, values)
    size, apart = np.abs(move).max(axis=0), np.abs(move + moves(start.others, values))
    # Two inverse Jacobians from two polynomials: their disagreement is the linear error of the
    # step; the square of the step stands for curvature, and for what the Jacobian of a coarser rule
    # lacks, since a first step behind Newton's method is about as long as what its edges lack.
    rest = np.maximum(apart, share * size) + tuning.BENT * np.square(size)
    unknowns = start.unknowns.T + move
    left = shift_error(sets.edges, unknowns, unknowns + rest, fields)
    # Nearly singular inverse Jacobians take short steps far from the edges: two of 3,107 points of
    # a fine grid were 3 and 18 times their estimate off, at disagreements of 0.4 and 44.
    agreed = apart.max(axis=0, initial=0.0) <= 0.3 * size
    left[~((size < 1e-2) & agreed)] = np.inf  # longer chord steps say little about what is left
    for _ in range(3):  # chord steps after the first
        again = np.flatnonzero(left < np.inf)
        again = again[SAFETY * left[again] > room[again]]
        if not len(again):
            break
        some = sets.chosen(again)
        fields = some.fields(unknowns[:, again], fields.rule)
        move = -moves(start.inverse[again], fields.mismatch())
        unknowns[:, again] += move
        # The steps form a geometric series: what is left is the last move times its ratio.
        ratio = np.abs(move).max(axis=0) / size[again]
        rest, size[again] = move * np.minimum(1.0, ratio), size[again] * ratio
        left[again] = shift_error(some.edges, unknowns[:, again], unknowns[:, again] + rest, fields)
    return unknowns, left
