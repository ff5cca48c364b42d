"""Histories beyond a critical angle: the Hilbert transform of a load history.

A wave that decays away from the line runs along it ahead of the front of its history, so that
H f(t) = (1/pi) PV int f(s) / (t - s) ds is not 0 before the history begins.
"""

from __future__ import annotations

from math import factorial
from typing import Any

import numpy as np

from semianalytic.scene.arrays import Array
from semianalytic.scene.loads import LoadHistory

_REST = 1e-12
"""Value or slope at the end, over the largest jump or slope, up to which it is rounding."""


def comes_back(history: LoadHistory) -> bool:
    """Return whether a history of jumps and kinks ends at 0, so that its transform is finite.

    Examples
    --------
    >>> from semianalytic import Pulse, Step
    >>> comes_back(Pulse(0.5, "triangle")), comes_back(Step())
    (True, False)
    """
    jumps, kinks, waves = history.pieces
    slope, value = sum(k for _, k in kinks), sum(a for _, a in jumps)
    value -= sum(k * at for at, k in kinks)
    sizes = [abs(a) for _, a in jumps] + [abs(k * at) for at, k in kinks]
    steep = max((abs(k) for _, k in kinks), default=0.0)
    return not waves and abs(slope) <= _REST * steep and abs(value) <= _REST * max(sizes, default=0)


def transformed(history: LoadHistory, start: Array, end: Array) -> Array:
    """Return the mean of H f over intervals start < t < end, (n,).

    Where start is end, it is H f itself, which is infinite at a jump.  The history is one that
    `comes_back`; times are [time], (n,).
    """
    alone = start == end
    later, earlier = (analytic(history, t + 0j, 1).imag for t in (end, start))
    mean = (later - earlier) / np.where(alone, 1.0, end - start)
    return np.asarray(np.where(alone, analytic(history, end + 0j, 0).imag, mean))


def analytic(history: LoadHistory, t: Any, order: int) -> Any:
    """Return f + i H f at complex times on or above the real axis, integrated so often, t's shape.

    It is the history of waves that decay: exp(-i w t) for w < 0, which falls off with Im t.
    """
    pieces, total = history.pieces, np.zeros(t.shape, dtype=complex)
    with np.errstate(divide="ignore", invalid="ignore"):  # at a jump
        for count, steps in ((order, pieces.jumps), (order + 1, pieces.kinks)):
            for at, size in steps:
                since, late = t - at, 1j / np.pi * _integral(count, t - at)
                total += size * (since**count / factorial(count) + late)
    return total


def _integral(order: int, t: Any) -> Any:
    """Return ln t, integrated so often from 0."""
    log = np.log(t)
    if order == 0:
        return log
    size, harmonic = t**order / factorial(order), sum(1 / k for k in range(1, order + 1))
    return size * np.where(t == 0, 0.0, log) - harmonic * size
