"""The slip speed of a node at which its friction and the inertia of its bodies balance."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from semianalytic.scene.laws.law import Law

Array = NDArray[np.float64]

SLOWEST = 1e-300
"""Slip rate at which the search for the speed of a law without a threshold begins."""
ACCURACY = 1e-12
"""Relative accuracy of the speeds; half or twice as much changes no answer."""
MOST = 200
"""Most steps of the search, which takes 2 for Coulomb friction and 20 to 30 for other laws."""


def slip_speed(
    friction: Law,
    stopping: Array,
    pressure: Array,
    impedance: Array,
    state: Array,
    pressed: NDArray[np.bool_],
) -> Array:
    """Return the speed V >= 0 at which strength + impedance V = stopping, 0 where nodes stick.

    Parameters
    ----------
    friction : Law
    stopping : (n,) array
        |traction| that would stop the pair of nodes at this step [stress].
    pressure : (n,) array
        Pressure that friction follows [stress].
    impedance : (n,) array
        Traction that reduces the slip rate by 1 [stress time / length].
    state : (n,) array
        State of the law.
    pressed : (n,) array of bool
        Whether the faces touch; nothing rubs elsewhere.
    """
    free = stopping / impedance

    def excess(speed: Array) -> Array:
        return np.asarray(friction.strength(pressure, speed, state) + impedance * speed - stopping)

    if friction.has_threshold:
        slips = pressed & (excess(np.zeros(len(free))) < 0)
        speed = bracketed(excess, np.zeros(len(free)), free, slips)
    else:
        # strength rises with the logarithm of the speed
        low = np.full(len(free), np.log(SLOWEST))
        slips = pressed & (excess(np.exp(low)) < 0)
        high = np.log(np.where(free > 0, free, SLOWEST))
        speed = np.exp(bracketed(lambda y: excess(np.exp(y)), low, high, slips))
    return np.where(pressed, np.where(slips, speed, 0.0), free)


def bracketed(
    excess: Callable[[Array], Array], low: Array, high: Array, wanted: NDArray[np.bool_]
) -> Array:
    """Return where a rising function is 0 between low and high, by the Illinois rule.

    Every third step halves the bracket, so that it always closes.  Elements that are not wanted may
    hold anything.
    """
    a, b = low.copy(), high.copy()
    fa, fb = excess(a), excess(b)
    at = b
    scale = np.maximum(np.abs(fa), np.abs(fb))
    for count in range(MOST):
        with np.errstate(divide="ignore", invalid="ignore"):
            secant = b - fb * (b - a) / (fb - fa)
        middle = (a + b) / 2
        inside = (secant >= a) & (secant <= b)
        at = np.where(inside & (count % 3 < 2), secant, middle)
        f = excess(at)
        found = (np.abs(f) <= 1e-15 * scale) | (b - a <= ACCURACY * np.abs(b))
        if (found | ~wanted).all():
            break
        below = f < 0
        # the value at an end that stays is halved, or the secant would stay on one side
        fa, fb = np.where(below, f, fa / 2), np.where(below, fb / 2, f)
        a, b = np.where(below, at, a), np.where(below, b, at)
    return at
