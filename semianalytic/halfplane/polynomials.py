"""Gauss-Legendre rules, Chebyshev series and central differences of smooth functions."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np

from semianalytic.scene.arrays import Array

FOURTH_ORDER = np.array([-2.0, -1.0, 1.0, 2.0]), np.array([1.0, -8.0, 8.0, -1.0]) / 12
"""Points, in steps, and weights of the central difference of fourth order."""


@cache
def gauss(n: int) -> tuple[Array, Array]:
    """Return Gauss-Legendre nodes and weights on [0, 1], as read-only arrays."""
    nodes, weights = np.polynomial.legendre.leggauss(n)
    both = (nodes + 1) / 2, weights / 2
    for table in both:
        table.setflags(write=False)
    return both


def chebyshev_series(function: Callable[[Array], Array], degree: int) -> Array:
    """Return the Chebyshev coefficients of a smooth function on [-1, 1] down to rounding."""
    # Most functions need few coefficients: more are computed only where those above rounding reach
    # the end of the series.
    for count in (degree // 8 + 1, degree // 2 + 1, degree + 1):
        series = _interpolant(function, count)
        above = np.flatnonzero(np.abs(series) > 4e-16 * np.abs(series).max())
        if above[-1] < 0.8 * count:  # else the series is not complete
            break
    return series[: above[-1] + 1]


def _interpolant(function: Callable[[Array], Array], count: int) -> Array:
    """Return Chebyshev coefficients (count,) of the polynomial through a function on [-1, 1]."""
    values = function(np.cos(np.pi * (np.arange(count) + 0.5) / count))
    # cosine transform of the values by a Fourier transform of every other one, there and back
    folded = np.fft.fft(np.concatenate([values[::2], values[1::2][::-1]]))
    turned = folded * np.exp(-0.5j * np.pi * np.arange(count) / count)
    series: Array = 2 / count * turned.real
    series[0] /= 2
    return series
