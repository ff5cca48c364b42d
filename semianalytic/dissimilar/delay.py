"""Bound on the growth of waves along a sliding interface when friction lags behind pressure.

With friction f / (1 + lambda t*) (Prakash and Clifton, simplified) the growth of waves is largest
near q c t* = 1 and falls for shorter ones, so that

    max over q of Re lambda = G / t*,

with a number G that depends on friction and the bodies.  The problem is then well posed but not
stable: waves of length about 2 pi c t* dominate after much longer than t* / G.  A delay also turns
the phase of friction, so that waves may grow that decay without it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from semianalytic.dissimilar.compliance import Compliance
from semianalytic.dissimilar.growth import GrowingWave, growing_waves, symbol

_RATIO = 1.7
"""Ratio of each trial q c_t t* to the one before; 1.35 found no other maximum for 30 pairs."""


@dataclass(frozen=True)
class DelayedGrowth:
    """The fastest growth rate times a delay t*, its q c_t t*, and its velocity over upper c_t."""

    rate: float
    wave_number: float
    velocity: float


def fastest_delayed_growth(compliance: Compliance, friction: float) -> DelayedGrowth | None:
    """Return the fastest growth over all wave numbers under a delay; None if no wave grows.

    All growing waves are sought at every q c_t t* of a scale.  Following those without delay would
    miss the fastest one of aluminium on steel at f = 0.5, and all of gouge on rock.

    `friction` is s f, the friction coefficient with the sense of slip.
    """
    from scipy.optimize import minimize_scalar  # here, for `import semianalytic` is to be quick

    # In 30 pairs the largest growth was at 0.4 to 1 times the slowness of its own wave, none
    # elsewhere from 0.05 to 10.
    low, high = np.log(0.2 * compliance.first), np.log(6.0 * compliance.last)
    scale = np.linspace(low, high, int(np.ceil((high - low) / np.log(_RATIO))) + 1).tolist()
    found = [
        # Re lambda t* = (growth / q c_t) (q c_t t*): what is compared at different wave numbers.
        (float(wave.growth * np.exp(log)), log, wave)
        for log in scale
        for wave in growing_waves(compliance, friction, float(np.exp(log)))
    ]
    if not found:
        return None
    _, best, wave = max(found, key=lambda rate: rate[0])

    def followed(log: float) -> GrowingWave:
        k = _followed(compliance, friction, float(np.exp(log)), wave.slowness)
        return wave if k is None else GrowingWave(k)

    def fall(log: float) -> float:
        return float(-followed(log).growth * np.exp(log))

    bounds = best - np.log(_RATIO), best + np.log(_RATIO)
    log = float(minimize_scalar(fall, bounds=bounds, method="bounded").x)
    fastest, delay = followed(log), float(np.exp(log))
    return DelayedGrowth(float(fastest.growth * delay), delay, fastest.velocity)


def _followed(
    compliance: Compliance, friction: float, delay: float, start: complex
) -> complex | None:
    """Follow a zero of Phi with a delay by Newton's method; None if it does not converge."""
    k = start
    for _ in range(40):
        near = min(abs(k + side * front) for front in compliance.fronts for side in (1, -1))
        step = 1e-4 * near
        entries = compliance.at(np.array([k, k - step, k + step]))
        value, before, after = symbol(entries, friction, delay)
        move = complex(-2 * step * value / (after - before))
        # A step that passes a front or the axis continues on another sheet.
        longest = min(near, abs(k.imag)) / 2
        k += move * min(1.0, longest / abs(move)) if move else 0.0
        if abs(move) < 1e-12 * abs(k):
            return k
    return None
