"""Put the edges of zones where the conditions at them hold, by Newton's and Broyden's methods."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from semianalytic.cut.load import Load
from semianalytic.cut.quadrature.layout import Zone
from semianalytic.cut.zones import ZoneFields
from semianalytic.halfplane.rayleigh import RayleighFactors
from semianalytic.halfplane.rules import Rule
from semianalytic.scene.arrays import Array
from semianalytic.selfsimilar.zones import tuning
from semianalytic.selfsimilar.zones.edges import Edges, broyden, edge_shift, edges_of


@dataclass(frozen=True)
class Placement:
    """Positions (e,) of edges by Newton's method, the inverse Jacobian (e, e), steps taken."""

    edges: Edges
    unknowns: Array
    inverse: Array
    converged: bool = True
    steps: int = 0

    @property
    def zones(self) -> tuple[Zone, ...]:
        """Zones between these edges, from the longitudinal front inward."""
        return self.edges.zones(self.unknowns)


def placement_of(factors: RayleighFactors, zones: Sequence[Zone], load: Load) -> Placement:
    """Return the placement of zones before any step."""
    edges, unknowns = edges_of(factors, zones, load.opened.zone if load.opened else None)
    return Placement(edges, unknowns, np.zeros((len(unknowns), len(unknowns))))


def locate_edges(
    factors: RayleighFactors,
    zones: Sequence[Zone],
    load: Load,
    rule: Rule,
    tolerance: float,
    most_steps: int = 40,  # one or two are usual, 8 were the most in 30 hard scenes
) -> Placement:
    """Locate the edges of zones by Newton's method, damped by natural monotonicity.

    The Jacobian is formed from neighbouring sets of zones in one sweep with the zones themselves, a
    guess from the longitudinal front inward.  The steps end once the next one would shift the edges
    by less than the tolerance [c_t]; `converged` is False if zones overlap, the Jacobian is
    singular or steps fail.
    """
    start = placement_of(factors, zones, load)
    edges, unknowns, inverse = start.edges, start.unknowns, start.inverse
    if not len(unknowns):
        return start
    # Zones that overlap, or begin on a front, are no start for Newton's method.
    if not (np.isfinite(unknowns).all() and edges.ordered(unknowns)):
        return replace(start, converged=False)
    for step in range(1, most_steps + 1):
        values, jacobian = linearised(edges, unknowns, load, rule)
        try:
            inverse = np.asarray(np.linalg.inv(jacobian))
        except np.linalg.LinAlgError:
            break
        move, rooted = -inverse @ values, _rooted(edges, unknowns, load)
        largest = float(np.abs(move).max())
        if not largest < np.inf:
            break
        last = _moved(unknowns, move, rooted)
        # Newton's method converges quadratically, so that the error after this move is about its
        # square.
        if largest < 1 and largest * edge_shift(edges, unknowns, last) < 2 * tolerance:
            if not edges.admits(last):
                return Placement(edges, unknowns, inverse, False, step)
            scale = _scale_of_roots(unknowns, last, rooted)
            return Placement(edges, last, scale[:, None] * inverse, True, step)
        damped = _damped(edges, unknowns, move, inverse, load, rule)
        if damped is None:
            break
        unknowns = damped
    return Placement(edges, unknowns, inverse, False, step)


def linearised(edges: Edges, unknowns: Array, load: Load, rule: Rule) -> tuple[Array, Array]:
    """Return the mismatch (e,) and its Jacobian (e, e) at unknowns (e,).

    Nudges whose effect is below rounding are enlarged until it shows. This happens for an edge next
    to a front, where the mismatch follows the square root of their distance or its cube.
    """
    nudges = edges.nudges(unknowns)
    while True:
        beside = np.concatenate([np.zeros((len(unknowns), 1)), np.diag(nudges)], axis=1)
        values = edges.mismatch(unknowns[:, None] + beside, load, rule)
        changes = values[:, 1:] - values[:, :1]
        # Below it rounding counts: Jacobians at 1e-18 from the longitudinal front were 30 times off
        unseen = np.abs(changes).max(axis=0) < 1e-13
        unseen &= nudges < tuning.LONGEST_NUDGE
        if not unseen.any():
            return values[:, 0], changes / nudges
        nudges[unseen] = np.minimum(1e3 * nudges[unseen], tuning.LONGEST_NUDGE)


def _rooted(edges: Edges, unknowns: Array, load: Load) -> np.ndarray:
    """Return which edges (e,) are so close to the longitudinal front that a root counts."""
    if not load.load_pressure:
        return np.zeros(len(unknowns), dtype=bool)
    # A strip of 1e-18 is found in three steps by the root of its width, in twenty by its logarithm.
    near = edges.parts(unknowns)[1] < 1e-3
    return near & (np.array(edges.segments, dtype=int) == 0)


def _moved(unknowns: Array, move: Array, rooted: np.ndarray) -> Array:
    """Return unknowns after a move by a linear model, `rooted` ones by that of a root."""
    moved = unknowns + move
    # The root must remain positive, so that its relative decrease is bounded.
    bend = np.maximum(move[rooted] / 2, 1e-3 - 1)
    moved[rooted] = unknowns[rooted] + 2 * np.log1p(bend)
    return moved


def _scale_of_roots(unknowns: Array, moved: Array, rooted: np.ndarray) -> Array:
    """Return (e,) how much faster an unknown changes with the mismatch at its new place."""
    # d(unknown) = 2 d(root) / root, and the root changes by exp((moved - unknowns) / 2).
    return np.where(rooted, np.exp((unknowns - moved) / 2), 1.0)


def _damped(
    edges: Edges, unknowns: Array, move: Array, inverse: Array, load: Load, rule: Rule
) -> Array | None:
    """Return unknowns after an admitted share of a move; a long one must shorten the next."""
    largest, rooted = float(np.abs(move).max()), _rooted(edges, unknowns, load)
    cautious = largest > 1.0  # longer moves are checked for natural monotonicity
    longest = float(np.abs(move[~rooted]).max(initial=0.0))
    # No unknown, a logit or logarithm, moves further in one step.
    move = move * min(1.0, 1.5 / longest if longest else 1.0)
    for _ in range(8):  # halvings of a step that does not reduce the mismatch
        trial = _moved(unknowns, move, rooted)
        # Natural monotonicity: the next move, with the present inverse, must not be longer.
        if edges.admits(trial) and not (
            cautious and np.abs(inverse @ edges.mismatch(trial, load, rule)).max() > largest
        ):
            return np.asarray(trial)
        move = move / 2
    return None


def polish_edges(
    placement: Placement, fields: ZoneFields, rule: Rule, target: float
) -> tuple[Placement, ZoneFields, float]:
    """Improve edges by Broyden steps on a rule until the next shift is below `target` [c_t]."""
    edges, unknowns, inverse = placement.edges, placement.unknowns, placement.inverse
    factors, load, new_rule = edges.factors, fields.load, fields.rule is not rule
    if not len(unknowns):
        fields = ZoneFields(factors, load, placement.zones, rule) if new_rule else fields
        return replace(placement, steps=0), fields, 0.0
    steps, before, move, shift = 0, None, np.zeros(len(unknowns)), np.inf
    while True:
        value = edges.left_by(fields, unknowns)
        if before is not None:
            inverse = broyden(inverse, move, value - before)
        move, rooted = -inverse @ value, _rooted(edges, unknowns, load)
        moved = _moved(unknowns, move, rooted)
        # The first mismatch may come from another rule; its step only brings the fields to this
        # one, and Broyden's update needs two values of the same rule.
        if fields.rule is rule:
            before, shift = value, float(edge_shift(edges, unknowns, moved))
        settled = shift <= target or steps == tuning.MOST_BROYDEN_STEPS
        if settled or not edges.admits(moved):
            return Placement(edges, unknowns, inverse, True, steps), fields, shift
        scale = _scale_of_roots(unknowns, moved, rooted)
        inverse, move = scale[:, None] * inverse, scale * move
        steps, unknowns = steps + 1, moved
        fields = ZoneFields(factors, load, edges.zones(unknowns), rule)
