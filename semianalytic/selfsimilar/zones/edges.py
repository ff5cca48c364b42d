"""Zone edges as unknowns, and the mismatch of the conditions at them.

The traction reaches s f p at an edge where slip begins; slip rate vanishes where it ends.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from semianalytic.cut.load import Load, per_set
from semianalytic.cut.quadrature.layout import Zone
from semianalytic.cut.zones import ZoneFields
from semianalytic.halfplane.lazily import cached_property
from semianalytic.halfplane.rayleigh import CutPoints, RayleighFactors
from semianalytic.halfplane.rules import Rule
from semianalytic.scene.arrays import Array
from semianalytic.selfsimilar.zones import tuning


@dataclass(frozen=True)
class Edges:
    """Assignment of unknowns to zone edges."""

    factors: RayleighFactors
    kinds: tuple[Zone, ...]  # zones from the longitudinal front inward, without their edges
    # whether the first zone starts ahead of all waves, and whether the last one reaches the contact
    # edge
    open_ends: tuple[bool, bool]
    segments: tuple[int, ...]  # per edge: 0 for a slowness in (a, b), 1 for (b, c), 2 for (c, inf)
    opening: Zone | None = None  # open part of the contact; edges stay on their side of it
    # per edge: -1 ahead of the opening, 1 behind it, 0 held at an end of it
    sides: tuple[int, ...] = ()
    held_at: tuple[float, ...] = ()  # unknowns of the edges that are held

    @cached_property
    def _segments(self) -> tuple[Array, Array, Array]:
        """Front less every front (4, e), width, and 1 if bounded, of each edge's segment."""
        a, c = per_set(self.factors.a), per_set(self.factors.c)
        fronts = np.zeros((4, *np.shape(a)))
        fronts[1], fronts[2], fronts[3] = a, 1.0, c
        segments = np.array(self.segments, dtype=int)
        bounded = np.flatnonzero(segments < 2)
        shift = fronts[1 + segments] - fronts[:, None]
        width, bend = np.ones_like(shift[0]), np.zeros_like(shift[0])
        width[bounded], bend[bounded] = np.diff(fronts, axis=0)[1 + segments[bounded]], 1.0
        return shift, width, bend

    def parts(self, unknowns: Array) -> Array:
        """Return the slowness of the edges and their distances from a, b and c, as in `CutPoints`.

        The unknown is a logit in a bounded segment and a logarithm beyond c. For an edge that
        closes a stick gap within a segment it counts from the edge that opens the gap, so that gaps
        may be arbitrarily narrow. The result is (4, e) or (4, e, k) for `unknowns` (e,) or (e, k).
        """
        shift, width, bend = self._segments
        axes = (..., *[None] * (unknowns.ndim - width.ndim))
        shift, width, bend = shift[axes], width[axes], bend[axes]
        # With s = e^unknown the distance from the front is width s / (1 + s), or s beyond c.
        size = np.exp(unknowns)
        parts = np.asarray(shift + width * size / (1 + bend * size))
        for edge, (segment, behind_gap) in enumerate(zip(self.segments, self._gaps, strict=True)):
            rest = width[edge]
            if behind_gap:
                rest = np.abs(parts[_far_front(segment), edge - 1])
                gap = rest * size[edge] / (1 + bend[edge] * size[edge])
                parts[:, edge] = parts[:, edge - 1] + gap
            # The distance from the far front is computed by itself: a difference would lose its
            # digits.
            if segment < 2:
                parts[2 + segment, edge] = -rest / (1 + size[edge])
        return parts

    @cached_property
    def _gaps(self) -> tuple[bool, ...]:
        """Whether each edge closes a stick gap that lies within its segment."""
        return _closing_gaps(self.segments, self.open_ends[0])

    def points(self, unknowns: Array) -> list[CutPoints]:
        """Return the edges in slowness, (1,) or (k, 1) for `unknowns` (e,) or (e, k)."""
        parts = self.parts(unknowns)[..., None]
        points = [CutPoints(parts[:, edge]) for edge in range(len(self.segments))]
        for edge, side in enumerate(self.sides):
            if side or self.opening is None:
                continue
            # Held at an end of the opening.  Edges alternate between beginnings and ends of zones,
            # from a beginning unless the first zone has no left edge.
            begins = (edge % 2 == 0) != self.open_ends[0]
            end = self.opening.left if begins else self.opening.right
            points[edge] = points[edge] if end is None else end
        return points

    def zones(self, unknowns: Array) -> tuple[Zone, ...]:
        """Return the zones for given unknowns."""
        points: list[CutPoints | None] = list(self.points(unknowns))
        if self.open_ends[0]:
            points.insert(0, None)
        if self.open_ends[1]:
            points.append(None)
        return tuple(
            Zone(left, right, kind.sense, kind.inward, kind.held)
            for kind, left, right in zip(self.kinds, points[::2], points[1::2], strict=True)
        )

    def admits(self, unknowns: Array) -> np.ndarray:
        """Return whether edges are in order, zones wide, none at an end of the cut, () or (k,)."""
        near = np.abs(unknowns).max(axis=0) < tuning.FARTHEST
        opens = self.open_ends[0]
        for index, (p, q) in enumerate(pairwise(self.points(np.where(near, unknowns, 0.0)))):
            # Segments between the edges of one zone alternate with those between zones.
            inside = (index % 2 == 0) != opens
            # Narrower zones are lost in rounding.
            least = 1e-10 * np.abs(p.parts[1:]).min(axis=0) if inside else np.zeros(1)
            near &= (q.minus(p) > least)[..., 0]
        return near & self._keeps_off_opening(np.where(near, unknowns, 0.0))

    def ordered(self, unknowns: Array) -> bool:
        """Return whether edges (e,) are in order, and on their side of the opening."""
        inward = all(p.first_below(q) for p, q in pairwise(self.points(unknowns)))
        return inward and bool(self._keeps_off_opening(unknowns))

    def _keeps_off_opening(self, unknowns: Array) -> Array | bool:
        """Return whether edges stay on their side of the opening, () or (k,)."""
        if self.opening is None:
            return True
        keeps = np.ones(unknowns.shape[1:], dtype=bool)
        for side, point in zip(self.sides, self.points(unknowns), strict=True):
            bound = self.opening.left if side < 0 else self.opening.right
            if side and bound is not None:
                # No panel fits between an edge and an end of the opening that differ by rounding, 1
                # ulp once.
                least = 16 * np.finfo(float).eps * bound.v
                keeps &= (side * point.minus(bound) > least)[..., 0]
        return keeps

    def nudges(self, unknowns: Array) -> Array:
        """Return changes of unknowns, (e,) or (e, k), for differences beyond rounding of gaps."""
        result = np.full(unknowns.shape, tuning.NUDGE)
        points = self.points(unknowns)
        for edge in np.flatnonzero(self._gaps):
            outward = points[edge - 1]
            gap = points[edge].minus(outward)[..., 0]
            # A nudge of a narrow gap exceeds the rounding of its distance from a front.
            rounding = 1e-13 * np.abs(outward.parts[1:]).min(axis=0)[..., 0]
            result[edge] = np.clip(rounding / gap, tuning.NUDGE, tuning.LONGEST_NUDGE)
        return result

    def chosen(self, which: np.ndarray) -> Edges:
        """Return the edges for some of many sets of zones."""
        factors = self.factors.chosen(which)
        return self if factors is self.factors else replace(self, factors=factors)

    def mismatch(self, unknowns: Array, load: Load, rule: Rule) -> Array:
        """Return the mismatch of the conditions at the edges, (e,) or (e, k) like `unknowns`."""
        # Without the tail behind the last edge, which does not enter the conditions.
        fields = ZoneFields(self.factors, load, self.zones(unknowns), rule, False)
        return self.left_by(fields, unknowns)

    def left_by(self, fields: ZoneFields, unknowns: Array) -> Array:
        """Return the mismatch of fields with these edges; of a held one, its distance."""
        result = fields.mismatch()
        # Without a free edge the mismatch is the same for all columns of unknowns.
        if result.ndim < unknowns.ndim:
            result = np.repeat(result[:, None], unknowns.shape[1], axis=1)
        for edge, side in enumerate(self.sides):
            if not side:
                result[edge] = unknowns[edge] - self.held_at[edge]
        return result


def edges_of(
    factors: RayleighFactors, zones: Sequence[Zone], opening: Zone | None = None
) -> tuple[Edges, Array]:
    """Return the edges and unknowns of given zones, from the longitudinal front inward."""
    points = [p for zone in zones for p in (zone.left, zone.right) if p is not None]
    open_ends = (bool(zones) and zones[0].left is None, bool(zones) and zones[-1].right is None)
    segments = tuple(int(p.parts[3, 0] > 0) + int(p.parts[2, 0] > 0) for p in points)
    unknowns = np.empty(len(points))
    for edge, behind_gap in enumerate(_closing_gaps(segments, open_ends[0])):
        p, segment = points[edge], segments[edge]
        start, end = p.parts[1 + segment], p.parts[_far_front(segment)]
        if behind_gap:
            start = p.minus(points[edge - 1])
        # The inverse of the map in `Edges.parts`.
        size = start / -end if segment < 2 else start
        if behind_gap and segment == 2:
            size = start / points[edge - 1].from_c
        unknowns[edge] = np.log(size[0])
    kinds = tuple(Zone(None, None, zone.sense, zone.inward, zone.held) for zone in zones)
    if opening is None:
        return Edges(factors, kinds, open_ends, segments), unknowns
    sides = tuple(_side(point, opening) for point in points)
    held_at = tuple(unknowns.tolist())
    return Edges(factors, kinds, open_ends, segments, opening, sides, held_at), unknowns


def _side(point: CutPoints, opening: Zone) -> int:
    """Return -1 ahead of the opening, 1 behind it, and 0 at one of its ends."""
    assert opening.left is not None
    if point is opening.left or point is opening.right:
        return 0
    return -1 if point.first_below(opening.left) else 1


def _far_front(segment: int) -> int:
    """Return the front, as a part of `CutPoints`, that bounds a segment inward, or c beyond it."""
    return min(2 + segment, 3)


def _closing_gaps(segments: Sequence[int], opens: bool) -> tuple[bool, ...]:
    """Return whether each edge closes a gap in its segment; `opens`: the first ends a zone."""
    return tuple(
        edge > 0 and (edge % 2 == 0) != opens and segments[edge] == segments[edge - 1]
        for edge in range(len(segments))
    )


def moves(inverse: Array, values: Array) -> Array:
    """Return products of (e, e) or (k, e, e) matrices and (e,) or (e, k) vectors."""
    return (inverse @ values.T[..., None])[..., 0].T


def broyden(inverse: Array, move: Array, change: Array) -> Array:
    """Update inverse Jacobians (e, e) or (k, e, e) by Broyden's formula.

    The moves (e,) or (e, k) have changed the mismatch by `change`.
    """
    image = moves(inverse, change)
    denominator = (move * image).sum(axis=0)
    # Sherman-Morrison form; a move of zero leaves the matrix as it is.
    rows = moves(np.swapaxes(inverse, -1, -2), move) / np.where(denominator, denominator, np.inf)
    return np.asarray(inverse + (move - image).T[..., :, None] * rows.T[..., None, :])


# An edge that is moved onto a front has an infinite logit, and an infinite shift.
@np.errstate(over="ignore", divide="ignore", invalid="ignore")
def edge_shift(edges: Edges, unknowns: Array, moved: Array) -> Array:
    """Return the largest shift of edges over the lesser of themselves and c_t, () or (k,).

    For edges slower than c_t it counts at least a tenth of the change of the logarithm of their
    distance from c: the slip rate near a narrow stick gap follows that of the width of the gap.
    For faster edges it counts at least the change of the square root of their distance from the
    longitudinal front: the pressure falls like that root behind the front, and so does the stress
    that a stuck strip holds there.

    Unknowns are (e,) or (e, k).
    """
    before, after = edges.parts(unknowns), edges.parts(moved)
    # The first factor is the relative change of the velocity 1/v; times max(1, 1/v) it is the
    # change over the lesser of the velocity and c_t = 1.
    shifts = np.abs(before[0] / after[0] - 1) * np.maximum(1.0, 1 / before[0])
    scales = np.abs(np.log(after[3] / before[3]))
    faster = np.flatnonzero(np.array(edges.segments) == 0)
    scales[faster] = 0.0
    # The slip rate at a narrow stick gap follows the logarithm of its width.
    counted = np.maximum(shifts, 0.1 * scales)
    roots = np.abs(np.sqrt(after[1, faster]) - np.sqrt(before[1, faster]))
    counted[faster] = np.maximum(counted[faster], roots)
    return np.asarray(counted.max(axis=0, initial=0.0))
