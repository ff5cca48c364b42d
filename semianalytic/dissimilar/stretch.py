"""Stretches of the cut between wave fronts and zone edges, and points on them.

Points are given by x with v = left + (right - left) / (1 + exp(-x)), or v = left (1 + exp(x)) on
the stretch that has no right end.  Powers and logarithms of the distances from both ends become
exponentials in x, and distances from the ends are exact however small.  A complex x with
-pi < Im x < 0 is a point k = -v of the upper half-plane: the strip covers all of it.

Functions of slowness are Chebyshev series on intervals of x.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike, NDArray

from semianalytic.scene.arrays import Array

Values = NDArray[Any]
"""Values that are real, or complex off the cut."""
POINTS = 16
"""Chebyshev points per interval: a singularity pi / 2 away leaves 3e-9, in fields 1e-10."""


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


@lru_cache(maxsize=1)
def _rules() -> tuple[Array, Array, Array]:
    """Return Chebyshev points in [-1, 1], matrices from values to series and its integral."""
    t = -np.cos(np.pi * (np.arange(POINTS) + 0.5) / POINTS)
    coefficients = np.linalg.inv(chebyshev.chebvander(t, POINTS - 1))
    integral = np.array([chebyshev.chebint(row, lbnd=-1) for row in np.eye(POINTS)]).T
    return t, np.asarray(coefficients, dtype=float), np.asarray(integral @ coefficients)


@dataclass(frozen=True)
class Bend:
    """The map x = size sinh(s / size), by which equal steps in s grow with |x| beyond the size."""

    size: float

    def x(self, s: Array) -> Array:
        """Return the x of coordinates s."""
        return np.asarray(self.size * np.sinh(s / self.size))

    def s(self, x: ArrayLike) -> Array:
        """Return the s of coordinates x."""
        return np.asarray(self.size * np.arcsinh(np.asarray(x) / self.size))

    def slope(self, x: Array) -> Array:
        """Return dx/ds at coordinates x."""
        return np.asarray(np.hypot(1.0, x / self.size))


@dataclass(frozen=True, eq=False)
class Intervals:
    """Intervals start + i length ... start + (i + 1) length in s on a stretch; s = x without a
    bend."""

    stretch: Stretch
    start: float
    length: float
    count: int
    bend: Bend | None = None

    @cached_property
    def x(self) -> Array:
        """Chebyshev points of all intervals, (count, POINTS)."""
        centres = self.start + self.length * (np.arange(self.count) + 0.5)
        s = np.asarray(centres[:, None] + self.length / 2 * _rules()[0])
        return self.bend.x(s) if self.bend else s

    @cached_property
    def points(self) -> Points:
        """Points on the stretch of all Chebyshev points, in a row."""
        return self.stretch.at(self.x.ravel())

    def shares(self, x: Array) -> Array:
        """Return coordinates x (n,) as numbers of intervals from the start, within them all."""
        s = self.bend.s(x) if self.bend else x
        return np.clip((s - self.start) / self.length, 0.0, self.count)


@dataclass(frozen=True, eq=False)
class Series:
    """Chebyshev coefficients (f, count, m) of functions on intervals, constant beyond them."""

    intervals: Intervals
    coefficients: Array

    def at(self, x: Array) -> Array:
        """Return the functions at coordinates x (n,), (f, n)."""
        share = self.intervals.shares(x)
        index = np.minimum(share.astype(int), self.intervals.count - 1)
        terms = chebyshev.chebvander(2 * (share - index) - 1, self.coefficients.shape[2] - 1)
        return np.einsum("fnm,nm->fn", self.coefficients[:, index], terms)

    @cached_property
    def values(self) -> Array:
        """The functions at the points of the intervals, (f, count POINTS)."""
        terms = chebyshev.chebvander(_rules()[0], self.coefficients.shape[2] - 1)
        return np.asarray(self.coefficients @ terms.T).reshape(len(self.coefficients), -1)

    @property
    def ends(self) -> tuple[Array, Array]:
        """The functions at the first and the last end, (f,) each."""
        # T_m(-1) = (-1)^m and T_m(1) = 1.
        signs = (-1.0) ** np.arange(self.coefficients.shape[2])
        return self.coefficients[:, 0] @ signs, self.coefficients[:, -1].sum(axis=-1)


def interval_weights() -> Array:
    """Return the weights of the values in the integral over [-1, 1], (POINTS,)."""
    return np.asarray(_rules()[2].sum(axis=0))


def from_values(values: Array) -> Array:
    """Return the coefficients (count, m) of a function from its values (count, POINTS)."""
    return np.asarray(values @ _rules()[1].T)


def integrated(slopes: Array, length: float, start: float) -> Array:
    """Return coefficients (count, m) of the integral over x of slopes, from `start` on."""
    parts = slopes @ _rules()[2].T * (length / 2)
    totals = parts.sum(axis=-1)
    # Each interval is integrated from its own left end; its constant is what came before.
    parts[:, 0] += start + np.concatenate([[0.0], np.cumsum(totals)[:-1]])
    return np.asarray(parts)


def padded(parts: Sequence[Array]) -> Array:
    """Stack coefficients of functions of different degree, (f, count, m)."""
    most = max(part.shape[1] for part in parts)
    return np.stack([np.hstack([p, np.zeros((len(p), most - p.shape[1]))]) for p in parts])
