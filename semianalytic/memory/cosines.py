"""Amplitudes of the cosines of a line that is even about both of its ends, and values of them."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from importlib import import_module

import numpy as np

from semianalytic.scene.arrays import Array


def cosines(values: Array, out: Array, kind: int = 2) -> None:
    """Write the amplitudes of the cosines of values at the nodes (size,) to another array.

    The line is even about both of its ends, which lie half a spacing from the outermost nodes
    (kind 2) or on them (kind 1).
    """
    _transform()(values, kind, (0,), 0, out)


def from_cosines(amplitudes: Array, out: Array, kind: int = 2) -> None:
    """Write the values at the nodes (size,) that have these amplitudes to another array."""
    # the inverse of type 2 is type 3, and that of type 1 is itself
    _transform()(amplitudes, 3 if kind == 2 else 1, (0,), 2, out)


@cache
def _transform() -> Callable[[Array, int, tuple[int], int, Array], object]:
    """Return the cosine transform (values, type, axes, 2 to divide by 2 n or 0, out)."""
    from scipy.fft import dct, idct  # here, for `import semianalytic` is to be quick

    # scipy.fft spends 12 microseconds around each call of the function below, twice what 500 nodes
    # take.  That function is not public: where a version of scipy has it elsewhere or with other
    # arguments, scipy.fft serves.
    given, found = np.arange(4.0), np.empty((4, 4))
    try:
        direct = import_module("scipy.fft._pocketfft.pypocketfft").dct
        for row, (kind, scaling) in zip(found, ((2, 0), (3, 2), (1, 0), (1, 2)), strict=True):
            direct(given, kind, (0,), scaling, row)
    except (ImportError, AttributeError, TypeError, ValueError, RuntimeError):
        found[:] = np.nan
    known = [dct(given), idct(given), dct(given, type=1), idct(given, type=1)]
    if np.allclose(found, known, rtol=1e-12):
        return direct

    def public(values: Array, kind: int, axes: tuple[int], scaling: int, out: Array) -> None:
        if scaling:  # scipy names an inverse by the type that it inverts
            out[:] = idct(values, type=1 if kind == 1 else 2)
        else:
            out[:] = dct(values, type=1 if kind == 1 else 2)

    return public
