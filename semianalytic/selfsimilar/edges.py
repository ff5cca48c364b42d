"""Zone edges as unknowns, and Newton's method for them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from semianalytic.halfplane.rayleigh import Array, CutPoints, RayleighFactors
from semianalytic.halfplane.rules import Rule
from semianalytic.selfsimilar.collocation import GridSlip
from semianalytic.selfsimilar.layout import Zone
from semianalytic.selfsimilar.zones import Load, ZoneFields

_MOST_STEPS = 40
_LONGEST_MOVE = 1.5
FARTHEST = 300.0  # unknowns beyond put an edge on a wave front or at the contact edge
NUDGE = 1e-6
_ROUNDING, _LONGEST_NUDGE = 1e-13, 0.3
_LEAST_WIDTH = 1e-10  # over the distance from a front; of a narrower zone rounding leaves little


@dataclass(frozen=True)
class Edges:
    """Which unknown is which zone edge.

    Attributes
    ----------
    factors : RayleighFactors
    senses : tuple of int, one per zone, from the longitudinal front inward
    open_ends : (bool, bool), whether the first zone starts ahead of all waves and whether the
        last one reaches the contact edge
    segments : tuple of int, per edge: 0 for (a, b), 1 for (b, c), 2 for (c, inf)
    """

    factors: RayleighFactors
    senses: tuple[int, ...]
    open_ends: tuple[bool, bool]
    segments: tuple[int, ...]

    @cached_property
    def _bounded(self) -> np.ndarray:
        """Edges in bounded segments."""
        return np.flatnonzero(np.array(self.segments) < 2)

    @cached_property
    def _segments(self) -> tuple[Array, Array, Array]:
        """Per edge: the front its segment starts from less every front (4, e), the width of the
        segment (1 beyond c), and 1 where it is bounded (0 beyond c)."""
        fronts = np.array([0.0, self.factors.a, 1.0, self.factors.c])
        segments, bounded = np.array(self.segments, dtype=int), self._bounded
        width, bend = np.ones(len(segments)), np.zeros(len(segments))
        width[bounded], bend[bounded] = np.diff(fronts)[1 + segments[bounded]], 1.0
        return fronts[1 + segments] - fronts[:, None], width, bend

    def parts(self, unknowns: Array) -> Array:
        """Slowness of the edges and their distances from a, b and c, as in `CutPoints`.

        The unknown is a logit in a bounded segment, a logarithm beyond c; that of an edge which
        closes a stick gap within a segment counts from the edge that opens the gap, so that gaps
        may be as narrow as they like.  (4, e) or (4, e, k) for `unknowns` (e,) or (e, k).
        """
        axes = (...,) + (None,) * (unknowns.ndim - 1)
        shift, width, bend = (part[axes] for part in self._segments)
        size = np.exp(unknowns)
        parts = np.asarray(shift + width * size / (1 + bend * size))
        for edge, (segment, behind_gap) in enumerate(zip(self.segments, self._gaps, strict=True)):
            rest = width[edge]
            if behind_gap:
                rest = np.abs(parts[_far_front(segment), edge - 1])
                gap = rest * size[edge] / (1 + bend[edge] * size[edge])
                parts[:, edge] = parts[:, edge - 1] + gap
            if segment < 2:
                parts[2 + segment, edge] = -rest / (1 + size[edge])
        return parts

    @cached_property
    def _gaps(self) -> tuple[bool, ...]:
        """Per edge, whether it closes a stick gap that lies within its segment."""
        return _closing_gaps(self.segments, self.open_ends[0])

    def points(self, unknowns: Array) -> list[CutPoints]:
        """Edges in slowness; `unknowns` (e,) give points of shape (1,), (e, k) give (k, 1)."""
        parts = self.parts(unknowns)[..., None]
        return [CutPoints(parts[:, edge]) for edge in range(len(self.segments))]

    def zones(self, unknowns: Array) -> tuple[Zone, ...]:
        """The zones of given unknowns."""
        points: list[CutPoints | None] = list(self.points(unknowns))
        if self.open_ends[0]:
            points.insert(0, None)
        if self.open_ends[1]:
            points.append(None)
        return tuple(
            Zone(points[2 * i], points[2 * i + 1], sense) for i, sense in enumerate(self.senses)
        )

    def admits(self, unknowns: Array) -> np.ndarray:
        """Whether edges keep their order, zones a width, and all stay off the ends of the cut.

        () or (k,).
        """
        near = np.abs(unknowns).max(axis=0) < FARTHEST
        opens = self.open_ends[0]
        for index, (p, q) in enumerate(pairwise(self.points(np.where(near, unknowns, 0.0)))):
            inside = (index % 2 == 0) != opens  # between the edges of one zone
            least = _LEAST_WIDTH * np.abs(p.parts[p.nearest]) if inside else np.zeros(1)
            near &= (q.minus(p) > least)[..., 0]
        return near

    def nudges(self, unknowns: Array) -> Array:
        """Changes of the unknowns, (e,) or (e, k), that show how the mismatch depends on them.

        A narrow stick gap is the difference of two distances from a front: a nudge has to change
        it by more than their rounding.
        """
        result = np.full(unknowns.shape, NUDGE)
        points = self.points(unknowns)
        for edge in np.flatnonzero(self._gaps):
            outward = points[edge - 1]
            gap = points[edge].minus(outward)[..., 0]
            rounding = _ROUNDING * np.abs(outward.parts[outward.nearest])[..., 0]
            result[edge] = np.clip(rounding / gap, NUDGE, _LONGEST_NUDGE)
        return result

    def mismatch(self, unknowns: Array, load: Load, rule: Rule) -> Array:
        """What the edges leave unfulfilled, (e,) or (e, k) as `unknowns`."""
        return ZoneFields(self.factors, load, self.zones(unknowns), rule, False).mismatch()


def place_edges(
    factors: RayleighFactors,
    senses: tuple[int, ...],
    open_ends: tuple[bool, bool],
    points: list[CutPoints],
) -> tuple[Edges, Array]:
    """Edges and unknowns from points (1,) on the cut."""
    segments = tuple(int(p.parts[3, 0] > 0) + int(p.parts[2, 0] > 0) for p in points)
    unknowns = np.empty(len(points))
    for edge, behind_gap in enumerate(_closing_gaps(segments, open_ends[0])):
        p, segment = points[edge], segments[edge]
        start, end = p.parts[1 + segment], p.parts[_far_front(segment)]
        if behind_gap:
            start = p.minus(points[edge - 1])
        size = start / -end if segment < 2 else start
        if behind_gap and segment == 2:
            size = start / points[edge - 1].from_c
        unknowns[edge] = np.log(size[0])
    return Edges(factors, senses, open_ends, segments), unknowns


def _far_front(segment: int) -> int:
    """The front, as a part of `CutPoints`, that bounds a segment inward, or c beyond it."""
    return min(2 + segment, 3)


def _closing_gaps(segments: Sequence[int], opens: bool) -> tuple[bool, ...]:
    """Per edge, whether it closes a stick gap that lies within its segment.

    `opens`: the first zone starts ahead of all waves, so that the first edge ends it.
    """
    return tuple(
        edge > 0 and (edge % 2 == 0) != opens and segments[edge] == segments[edge - 1]
        for edge in range(len(segments))
    )


def edges_of(factors: RayleighFactors, zones: Sequence[Zone]) -> tuple[Edges, Array]:
    """Edges and unknowns of given zones, from the longitudinal front inward."""
    points = [p for zone in zones for p in (zone.left, zone.right) if p is not None]
    open_ends = (bool(zones) and zones[0].left is None, bool(zones) and zones[-1].right is None)
    return place_edges(factors, tuple(zone.sense for zone in zones), open_ends, points)


def edges_on_grid(factors: RayleighFactors, grid: GridSlip, critical: bool) -> tuple[Edges, Array]:
    """Zones seen by the first stage, edges placed by the two outermost values of V there.

    With a critical base, shear traction equal to friction ahead of all waves, slip starts at the
    longitudinal front itself if it starts there at all.
    """
    xi, rate = grid.xi[::-1], grid.slip_rate[::-1]  # from the longitudinal front inward
    sense = np.sign(rate).astype(int)
    if critical and sense[0] == 0:
        sense[0] = sense[1]
    bounds = [0, *(np.flatnonzero(sense[1:] != sense[:-1]) + 1).tolist(), len(sense)]
    at_front = (xi == 0) | (xi == 1 / factors.c) | (xi == 1) | (xi == xi[0])
    senses, points = [], []
    for start, stop in pairwise(bounds):
        if sense[start] == 0:
            continue
        senses.append(int(sense[start]))
        for node, outside, inward in ((start, start - 1, 1), (stop - 1, stop, -1)):
            if not 0 <= outside < len(xi):
                continue
            inner, most = node + inward, 1.25
            if sense[outside]:
                most = 0.4
            elif at_front[outside] or sense[outside - inward]:
                most = 0.95
            ratio = abs(rate[node] / rate[inner]) if start <= inner < stop and rate[inner] else 0.5
            share = float(min(0.25 + 0.75 * ratio, most))
            place = xi[node] + share * (xi[outside] - xi[node])
            if xi[outside] == 1:  # a zone that comes this near to the shear front crosses it
                place = 1 + share * (1 - xi[node])
            points.append(factors.cut([1 / place]))
    open_ends = (bool(sense[0]), bool(sense[-1]))
    return place_edges(factors, tuple(senses), open_ends, points)


def moves(inverse: Array, values: Array) -> Array:
    """Products of (e, e) or (k, e, e) matrices and (e,) or (e, k) vectors."""
    return (inverse @ values.T[..., None])[..., 0].T


def broyden(inverse: Array, move: Array, change: Array) -> Array:
    """Inverse Jacobians (e, e) or (k, e, e) after moves (e,) or (e, k) that changed the mismatch by
    as much as `change`."""
    image = moves(inverse, change)
    denominator = (move * image).sum(axis=0)
    rows = moves(np.swapaxes(inverse, -1, -2), move) / np.where(denominator, denominator, np.inf)
    return np.asarray(inverse + (move - image).T[..., :, None] * rows.T[..., None, :])


@np.errstate(over="ignore", divide="ignore", invalid="ignore")  # edges moved onto a front
def edge_shift(edges: Edges, unknowns: Array, moved: Array) -> Array:
    """Largest shift of edges over the lesser of themselves and c_t, () or (k,).

    Of those slower than c_t at least a tenth of what the logarithms of their distances from c
    change: the slip rate beside a narrow stick gap follows that of its width.

    Parameters
    ----------
    unknowns, moved : (e,) or (e, k) arrays
    """
    before, after = edges.parts(unknowns), edges.parts(moved)
    shifts = np.abs(before[0] / after[0] - 1) * np.maximum(1.0, 1 / before[0])
    scales = np.abs(np.log(after[3] / before[3]))
    scales[np.flatnonzero(np.array(edges.segments) == 0)] = 0.0
    return np.asarray(np.maximum(shifts, 0.1 * scales).max(axis=0, initial=0.0))


@dataclass(frozen=True)
class Located:
    """Unknowns after Newton, whether they converged, inverse Jacobian and steps taken."""

    unknowns: Array
    converged: bool
    inverse: Array
    steps: int


def locate_edges(edges: Edges, load: Load, rule: Rule, start: Array, tolerance: float) -> Located:
    """Newton's method for the edges, damped by natural monotonicity, until the next move would
    shift them by less than a tolerance.

    The Jacobian is formed from neighbouring sets of zones in one sweep with the first set.
    """
    unknowns, size = start, len(start)
    inverse: Array = np.zeros((size, size))
    for step in range(1, _MOST_STEPS + 1):
        nudges = edges.nudges(unknowns)
        beside = np.concatenate([np.zeros((size, 1)), np.diag(nudges)], axis=1)
        values = edges.mismatch(unknowns[:, None] + beside, load, rule)
        try:
            inverse = np.asarray(np.linalg.inv((values[:, 1:] - values[:, :1]) / nudges))
        except np.linalg.LinAlgError:
            return Located(unknowns, False, inverse, step)
        move = -inverse @ values[:, 0]
        largest = float(np.abs(move).max())
        if not largest < np.inf:
            return Located(unknowns, False, inverse, step)
        # the next move is smaller by a factor of this one
        if largest < 1 and largest * edge_shift(edges, unknowns, unknowns + move) < 2 * tolerance:
            accepted = bool(edges.admits(unknowns + move))
            return Located(unknowns + move if accepted else unknowns, accepted, inverse, step)
        cautious = largest > 1.0
        move *= min(1.0, _LONGEST_MOVE / largest)
        for _ in range(8):
            trial = unknowns + move
            if edges.admits(trial) and not (
                cautious and np.abs(inverse @ edges.mismatch(trial, load, rule)).max() > largest
            ):
                break
            move /= 2
        else:
            return Located(unknowns, False, inverse, step)
        unknowns = trial
    return Located(unknowns, False, inverse, _MOST_STEPS)
