"""Zones of many frictions corrected at once: the batched side of `sweep`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from semianalytic.coulomb import admissible
from semianalytic.edges import NUDGE, Edges, moves
from semianalytic.panels import Rule, rule_for
from semianalytic.profile import Profile
from semianalytic.rayleigh import Array
from semianalytic.scene import Scene
from semianalytic.solver import (
    SAFETY,
    difference,
    loose_tolerance,
)
from semianalytic.zones import Load, ZoneFields

AT_ONCE = 24  # sets of zones in one batch: more leave the processor's cache
LOOSELY = 100  # the same on the loose rule
_MOST_STEPS = 4
_LONGEST_MOVE = 1.5
_NEAR = 2e-3  # move of an edge unknown after which its Jacobian is kept
_SLOW = 0.5  # Newton moves that shrink less are given up
_CONTRACTION, _LENT_CONTRACTION = 20.0, 0.1  # of chord steps, by the doubt of a prediction
_LEAST_CONTRACTION = 1e-3  # the same, once it has been seen
_TRUSTED = 1e-3  # doubt of a prediction that needs no Newton's method
_MOST_TURNS = 10  # of common steps on the loose rule
_MOST_ROUNDS = 6  # of evaluations on fine rules
_SETTLED = 0.04  # what may be left of Newton's method, in rtol
_ROUNDING = 1e-11  # moves that tell nothing of the Jacobian
_LEFT = 0.02  # the same on the loose rule
_LOOSE_CHECK, _LOOSE_MOVE = 10, 100  # there, in its tolerance
_STRICTNESS = 10  # of the check of Coulomb's law; `solve`, which is asked next, uses 100
_LOOSEST = 1e-4  # tolerance of that check: neighbours lend zones where a new one just begins
_CLOSE = 1e-3  # to a front, in slowness: differences are then formed there
_SECANT = 0.1  # of one edge, what the next step leaves of itself over the last
_WITHOUT_JACOBIAN = 1e-5  # rtol from which those steps suffice
_CHORDS = 5  # steps with lent Jacobians before they are formed anew


@dataclass(frozen=True)
class Predicted:
    """Unknowns at one friction and the inverse Jacobian from those near it, how far they may be
    off, the tolerance of the rule that is likely needed, and what a step with this Jacobian
    leaves of itself, where that has been seen."""

    unknowns: Array
    inverse: Array
    doubt: float
    wanted: float
    contraction: float = 0.0


@dataclass(frozen=True)
class Followed:
    """Sets of zones of neighbouring frictions, k columns of unknowns, and how they were found.

    inverse (k, e, e) is that of the Jacobian, a step with which leaves `contraction` (k,) of
    itself; wanted are the tolerances of their rules, which the batch made finer and longer, nodes
    the number per set on the last.
    """

    unknowns: Array
    estimate: Array
    sound: np.ndarray
    inverse: Array
    contraction: Array
    wanted: Array
    rules: list[Rule]
    steps: int
    nodes: int


def batches(edges: Edges, starts: Sequence[Array], at_once: int = AT_ONCE) -> Iterator[list[int]]:
    """Sets of zones that may share panels: every edge on one side of every cut, close to one
    front or to none.
    """
    groups: dict[tuple, list[int]] = {}
    keys: list[Array] = [np.zeros(len(starts))]
    if edges.segments and starts:
        for p in edges.points(np.array(starts).T):
            from_fronts = np.abs(p.parts[1:, :, 0])
            close = from_fronts.min(axis=0) < _CLOSE
            keys.append(np.where(close, from_fronts.argmin(axis=0), -1))
            for cut in edges.factors.cuts:
                keys.append(p.parts[cut.nearest, :, 0] < cut.parts[cut.nearest, 0])
    for j, key in enumerate(np.array(keys).T.tolist()):
        groups.setdefault(tuple(key), []).append(j)
    for group in groups.values():
        parts = -(-len(group) // at_once)
        yield from (part.tolist() for part in np.array_split(group, parts))


def common_load(scenes: Sequence[Scene], unit: float) -> Load:
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


def linearised(edges: Edges, unknowns: Array, load: Load, rule: Rule) -> tuple[Array, Array]:
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
        found = linearised(edges, unknowns[:, waiting], _chosen(load, waiting), rule)
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
    edges: Edges,
    start: Array,
    lent: Array,
    contraction: Array,
    load: Load,
    rule: Rule,
    goal: float,
) -> tuple[Array, Array, Array, int]:
    """Broyden steps on a rule from lent inverse Jacobians (k, e, e) until less than goal is left.

    Unknowns (e, k), or the start where that did not succeed; inverse Jacobians; what a step
    leaves of itself (k,), `contraction` until it is seen, infinite where steps did not succeed;
    the steps taken.
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
        waiting, largest = waiting[kept], largest[kept]
        move, before = move[:, kept], values[:, kept]
        unknowns[:, waiting] += move
        previous[waiting] = largest
        seen = share[kept] if step > 1 else contraction[waiting]
        arrived = largest * seen < goal
        if step > 1:  # a Jacobian made by these steps is good along them alone
            seen = _SECANT * seen if len(start) == 1 else np.maximum(seen, _LENT_CONTRACTION)
        left[waiting[arrived]] = np.maximum(seen[arrived], _LEAST_CONTRACTION)
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


def _contraction(doubt: Array) -> Array:
    """What a step with a lent Jacobian may leave of itself, by the doubt of the prediction."""
    return np.clip(_CONTRACTION * doubt, _LENT_CONTRACTION, 1.0)


def _located(
    edges: Edges, start: Array, lent: Array, doubt: Array, load: Load, rtol: float
) -> tuple[Array, Array, Array, int]:
    """Unknowns (e, k) near their places on the loose rule, inverse Jacobians (k, e, e), what a
    chord step with them leaves of itself (k,), infinite for sets that did not get there, and the
    steps taken.

    Broyden steps leave the Jacobian of several edges too rough for fine rules.
    """
    loose, rough = loose_tolerance(rtol), rtol < _WITHOUT_JACOBIAN and len(start) > 1
    goal = _NEAR if rough else loose
    contraction = _contraction(doubt)
    found = _approached(edges, start, lent, contraction, load, rule_for(loose), goal)
    unknowns, inverse, contraction, steps = found
    rest = np.flatnonzero(rough | ~(contraction < np.inf))
    if len(rest):
        again = _newton(edges, unknowns[:, rest], _chosen(load, rest), rule_for(loose))
        unknowns[:, rest], inverse[rest], steps = again[0], again[1], steps + again[3]
        contraction[rest] = np.maximum(2 * again[2], _LEAST_CONTRACTION)
    return unknowns, inverse, contraction, steps


def located(edges: Edges, predicted: list[Predicted], load: Load, rtol: float) -> Followed:
    """Edges at several frictions from predictions, exact on the loose rule and checked there.

    estimate is what is left of Newton's method.
    """
    count, size = len(predicted), len(edges.segments)
    unknowns = np.array([one.unknowns for one in predicted]).T.reshape(size, count)
    inverse = np.array([one.inverse for one in predicted])
    doubt = np.array([one.doubt for one in predicted])
    loose, goal, steps, nodes = loose_tolerance(rtol), max(_LEFT * rtol, 1e-13), 0, 0
    contraction = _contraction(doubt)
    if size and not np.all(doubt < _TRUSTED):
        unknowns, inverse, contraction, steps = _located(
            edges, unknowns, inverse, doubt, load, rtol
        )
    left, previous = np.zeros(count), np.full(count, np.inf)
    kept = np.flatnonzero(contraction < np.inf)
    # All together to the end: the panels, and so what is exact on them, depend on all.
    for turn in range(_MOST_TURNS):
        if not len(kept):
            break
        beside, loads = unknowns[:, kept], _chosen(load, kept)
        fields = ZoneFields(edges.factors, loads, edges.zones(beside), rule_for(loose))
        nodes, steps = fields.panels.jacobian[:, 0].size, steps + 1
        going = np.ones(len(kept), dtype=bool)
        if size:
            move = -moves(inverse[kept], fields.mismatch())
            largest = np.abs(move).max(axis=0)
            share = largest / previous[kept]
            visible = (share > 0) & (largest > _ROUNDING)
            contraction[kept] = np.where(visible, share, contraction[kept])
            left[kept], previous[kept] = largest * contraction[kept], largest
            going = edges.admits(beside + move) & (largest < _LOOSE_MOVE * loose)
            going &= (share < _SLOW) | (left[kept] <= goal)
            unknowns[:, kept] += move
        if turn == 0:
            going = going & admissible(Profile(fields), _LOOSE_CHECK * loose)
        kept = kept[going]
        if np.all(left[kept] <= goal):
            break
    sound = np.isin(np.arange(count), kept) & (left <= goal)
    wanted = np.full(count, loose)
    rules = [rule_for(loose)] * count
    return Followed(unknowns, left, sound, inverse, contraction, wanted, rules, steps, nodes)


def followed(edges: Edges, predicted: list[Predicted], load: Load, rtol: float) -> Followed:
    """Edges at several frictions from those on the loose rule, polished, estimated and checked.

    Those whose error estimate exceeds rtol are taken to finer rules.
    """
    count, size = len(predicted), len(edges.segments)
    unknowns = np.array([one.unknowns for one in predicted]).T.reshape(size, count)
    inverse = np.array([one.inverse for one in predicted])
    wanted = np.array([one.wanted for one in predicted])
    contraction = np.array([max(one.contraction, _LEAST_CONTRACTION) for one in predicted])
    waiting, steps = np.arange(count), 0
    loose = loose_tolerance(rtol)
    if size and len(waiting) and wanted[waiting].min() < 1e-2 * loose:
        between = float(np.sqrt(loose * wanted[waiting].min()))
        found = _approached(
            edges,
            unknowns[:, waiting],
            inverse[waiting],
            contraction[waiting],
            _chosen(load, waiting),
            rule_for(between),
            between,
        )
        unknowns[:, waiting], inverse[waiting], contraction[waiting] = found[:3]
        waiting, steps = waiting[found[2] < np.inf], steps + found[3]
    estimate, sound, nodes = np.full(count, np.inf), np.zeros(count, dtype=bool), 0
    previous, rules = np.full(count, np.inf), [rule_for(loose)] * count
    for _ in range(_MOST_ROUNDS):
        if not len(waiting):
            break
        tried = waiting[wanted[waiting] > 0.1 * wanted[waiting].max()]
        finest = float(wanted[tried].min())
        beside, loads = unknowns[:, tried], _chosen(load, tried)
        fields = ZoneFields(edges.factors, loads, edges.zones(beside), rule_for(finest))
        nodes, steps = fields.panels.jacobian[:, 0].size, steps + 1
        for j in tried:
            rules[j] = fields.panels.rule
        left, moved, going = np.zeros(len(tried)), beside, np.ones(len(tried), dtype=bool)
        settled = going
        if size:
            # The fields are those before this step, which is far below what is checked.
            moved = beside - moves(inverse[tried], fields.mismatch())
            largest = np.abs(moved - beside).max(axis=0)
            share = largest / previous[tried]
            contraction[tried] = np.where(share > 0, share, contraction[tried])
            left, previous[tried] = largest * contraction[tried], largest
            going = edges.admits(moved) & (share < _SLOW)
            settled = going & (left <= max(_SETTLED * rtol, 1e-13)) & (largest <= 10 * rtol)
            unknowns[:, tried[going]] = moved[:, going]
        coarse = ZoneFields(edges.factors, loads, fields.zones, rule_for(5 * finest))
        other = beside
        if size:
            other = beside - np.clip(moves(inverse[tried], coarse.mismatch()), -1.0, 1.0)
        error = difference(edges, moved, other, fields, coarse)
        going &= ~settled | admissible(Profile(fields), min(_STRICTNESS * rtol, _LOOSEST))
        good = going & settled & (error + SAFETY * left <= rtol)
        estimate[tried], sound[tried], wanted[tried] = error + SAFETY * left, good, finest
        finer = tried[going & ~good & (error > 0.5 * rtol)]
        wanted[finer] *= np.clip(0.1 * rtol / estimate[finer], 1e-3, 0.3)
        previous[finer] = np.inf
        waiting = np.setdiff1d(waiting, tried[~going | good])
    return Followed(unknowns, estimate, sound, inverse, contraction, wanted, rules, steps, nodes)
