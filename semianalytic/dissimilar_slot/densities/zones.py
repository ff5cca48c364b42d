"""Zones of slip and of opening, and their edges as unknowns of Newton's method."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from semianalytic.dissimilar.stretch import Stretch
from semianalytic.scene.arrays import Array


@dataclass(frozen=True)
class MovingZone:
    """Part that slips or is open, left < v < right in slowness; right None reaches the edge.

    The sense is +1 where the upper body slips towards +x, of openings that of the slip ahead.
    """

    left: float
    right: float | None
    sense: int
    open: bool = False


def joined(zone: MovingZone, other: MovingZone) -> bool:
    """Tell whether a zone begins where the one before it ends."""
    return zone.right is not None and zone.right == other.left


def neighbours(
    zones: Sequence[MovingZone],
) -> Iterator[tuple[MovingZone | None, MovingZone, MovingZone | None]]:
    """Yield every zone between the zones it is joined to; None stands for stick."""
    for before, zone, after in zip([None, *zones], zones, [*zones[1:], None], strict=False):
        yield (
            before if before is not None and joined(before, zone) else None,
            zone,
            after if after is not None and joined(zone, after) else None,
        )


def edges_of(zones: Sequence[MovingZone]) -> list[float]:
    """Return the slownesses of all edges in increasing order, those of joined zones once."""
    ends = [end for zone in zones for end in (zone.left, zone.right) if end is not None]
    return sorted(set(ends))


def moved(zones: Sequence[MovingZone], edges: Sequence[float]) -> tuple[MovingZone, ...]:
    """Return the zones with other edges, in the order of `edges_of`."""
    # By value, so that an edge that two zones share stays shared.
    to = dict(zip(edges_of(zones), edges, strict=True))
    return tuple(
        replace(zone, left=to[zone.left], right=None if zone.right is None else to[zone.right])
        for zone in zones
    )


@dataclass(frozen=True)
class Coordinates:
    """Coordinates of edges that serve as unknowns, each with the wave fronts on both its sides.

    They are on the stretch from the edge or front before to the front behind, and keep the order.
    """

    segments: tuple[tuple[float, float | None], ...]

    def edges(self, unknowns: Array) -> list[float]:
        """Return the slownesses of the edges, (e,)."""
        edges: list[float] = []
        for (left, right), x in zip(self.segments, unknowns, strict=True):
            # Counted from the edge before it, if that lies between the same fronts: they cannot
            # cross.
            start = max([left, *edges[-1:]])
            edges.append(float(Stretch(start, right).at(np.array([x])).v[0]))
        return edges

    def unknowns(self, edges: Sequence[float]) -> Array:
        """Return the unknowns from the slownesses of the edges, (e,)."""
        starts = [0.0, *edges][: len(edges)]
        return np.array(
            [
                Stretch(max(left, start), right).coordinate(edge)
                for (left, right), start, edge in zip(self.segments, starts, edges, strict=True)
            ]
        )


def coordinates_of(fronts: Sequence[float], edges: Sequence[float]) -> Coordinates:
    """Return coordinates by which edges stay between the wave fronts they lie between now."""
    ends: list[float | None] = [0.0, *fronts, None]
    segments = []
    for edge in edges:
        left, right = next(
            (end, other)
            for end, other in pairwise(ends)
            if end is not None and end < edge and (other is None or edge < other)
        )
        segments.append((left, right))
    return Coordinates(tuple(segments))
