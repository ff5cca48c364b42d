"""Functions of slowness as Chebyshev series on intervals of the coordinate x of stretches."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.polynomial import chebyshev

from semianalytic.dissimilar.stretch import Points, Stretch
from semianalytic.scene.arrays import Array

POINTS = 16
"""Chebyshev points per interval: a singularity pi / 2 away leaves 3e-9, in fields 1e-10."""


@lru_cache(maxsize=1)
def _rules() -> tuple[Array, Array, Array]:
    """Return Chebyshev points in [-1, 1], matrices from values to series and its integral."""
    t = -np.cos(np.pi * (np.arange(POINTS) + 0.5) / POINTS)
    coefficients = np.linalg.inv(chebyshev.chebvander(t, POINTS - 1))
    integral = np.array([chebyshev.chebint(row, lbnd=-1) for row in np.eye(POINTS)]).T
    return t, np.asarray(coefficients, dtype=float), np.asarray(integral @ coefficients)


@dataclass(frozen=True, eq=False)
class Intervals:
    """Intervals start + i length ... start + (i + 1) length in x on a stretch."""

    stretch: Stretch
    start: float
    length: float
    count: int

    @property
    def x(self) -> Array:
        """Chebyshev points of all intervals, (count, POINTS)."""
        centres = self.start + self.length * (np.arange(self.count) + 0.5)
        return np.asarray(centres[:, None] + self.length / 2 * _rules()[0])

    @property
    def points(self) -> Points:
        """Points on the stretch of all Chebyshev points, in a row."""
        return self.stretch.at(self.x.ravel())


@dataclass(frozen=True, eq=False)
class Series:
    """Chebyshev coefficients (f, count, m) of functions on intervals, constant beyond them."""

    intervals: Intervals
    coefficients: Array

    def at(self, x: Array) -> Array:
        """Return the functions at coordinates x (n,), (f, n)."""
        where = self.intervals
        inside = np.clip(x, where.start, where.start + where.count * where.length)
        share = (inside - where.start) / where.length
        index = np.clip(share.astype(int), 0, where.count - 1)
        terms = chebyshev.chebvander(2 * (share - index) - 1, self.coefficients.shape[2] - 1)
        return np.einsum("fnm,nm->fn", self.coefficients[:, index], terms)

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
