"""Stretches of the cut between wave fronts and zone edges, and points on them.

Points are given by x with v = left + (right - left) / (1 + exp(-x)), or v = left (1 + exp(x)) on
the stretch that has no right end.  Powers and logarithms of the distances from both ends become
exponentials in x, and distances from the ends are exact however small.  A complex x with
-pi < Im x < 0 is a point k = -v of the upper half-plane: the strip covers all of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from semianalytic.scene.arrays import Array

Values = NDArray[Any]
"""Values that are real, or complex off the cut."""


@dataclass(frozen=True)
class Points:
    """Slownesses v at x of a stretch, v - left, and right - v, inf where there is no right end."""

    x: Values
    v: Values
    from_left: Values
    to_right: Values


@dataclass(frozen=True)
class Stretch:
    """The slownesses left < v < right; without end if right is None."""

    left: float
    right: float | None

    def at(self, x: Values) -> Points:
        """Return the points of coordinates x (n,)."""
        if self.right is None:
            from_left = self.left * np.exp(x)
            return Points(x, self.left + from_left, from_left, np.full(x.shape, np.inf))
        width = self.right - self.left
        near_left = x.real < 0
        small = np.exp(np.where(near_left, x, -x))  # at most 1 in modulus
        near, far = width * small / (1 + small), width / (1 + small)
        # The shorter distance is computed and the other one follows: neither is a difference.
        from_left = np.where(near_left, near, far)
        to_right = np.where(near_left, far, near)
        v = np.where(near_left, self.left + from_left, self.right - to_right)
        return Points(x, v, from_left, to_right)

    @property
    def lead(self) -> float:
        """Distance in x, about, from v = 2 left to the middle where the right end is far; 0
        elsewhere.
        """
        return 0.0 if self.right is None else max(0.0, float(np.log(self.right / self.left - 1)))

    def slope(self, points: Points) -> Values:
        """Return dv/dx at points, (n,)."""
        if self.right is None:
            return points.from_left
        return np.asarray(points.from_left * points.to_right / (self.right - self.left))

    def minus(self, points: Points, ends: Array) -> Values:
        """Return the points less each of `ends`, (e, n); no end is inside the stretch."""
        column = np.asarray(ends, dtype=float)[:, None]
        if self.right is None:
            return np.asarray((self.left - column) + points.from_left)
        near_left = points.x.real < 0
        near_right = (self.right - column) - points.to_right
        # Counted from the end near which the point is; its own left end is exact in any case.
        counted = near_left | (column == self.left)
        return np.where(counted, (self.left - column) + points.from_left, near_right)

    def coordinates(self, v: Array) -> Array:
        """Return the x of slownesses (n,) from left on; it is -inf at left."""
        beyond = self.left if self.right is None else self.right - v
        with np.errstate(divide="ignore"):
            return np.asarray(np.log((v - self.left) / beyond))

    def coordinate(self, v: float) -> float:
        """Return the x of a slowness inside the stretch."""
        return float(self.coordinates(np.asarray(v)))


def stretches(ends: Sequence[float]) -> list[Stretch]:
    """Return the stretches between slownesses in increasing order; the last one has no end."""
    return [Stretch(left, right) for left, right in zip(ends, [*ends[1:], None], strict=True)]
