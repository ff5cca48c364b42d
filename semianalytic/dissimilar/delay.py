"""How a delay of friction behind pressure bounds the growth of waves along a sliding interface.

With friction f / (1 + lambda t*) (Prakash and Clifton, simplified) the growth of waves is largest
near q c t* = 1 and falls for shorter ones, so that

    max over q of Re lambda = G / t*,

with a number G that friction and the bodies determine.  The problem is well posed then; it is not
stable: whatever is to last much longer than t* / G is taken over by waves of some 2 pi c t*.  A
delay turns the phase of friction: it also lets waves grow that decay without one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from semianalytic.dissimilar.compliance import Compliance
from semianalytic.dissimilar.growth import GrowingWave, growing_waves, symbol

_FROM, _TO = 0.2, 6.0
"""Times the slowness of the fastest and of the slowest body wave, between which q c_t t* is looked
for.  Of 30 random pairs with growing waves the largest growth was at 0.4 to 1 times the slowness of
its own wave, but for growth below 1e-5; from 0.05 to 10 no other maximum was found."""
_RATIO = 1.7
"""Of one q c_t t* to the next: 1.35 found no other maximum for those pairs."""
_MOST_NEWTON, _SETTLED = 40, 1e-12
_DIFFERENCE = 1e-4
"""Of a slowness over its distance from the nearest wave front."""


@dataclass(frozen=True)
class DelayedGrowth:
    """The fastest growth that a delay t* leaves.

    Attributes
    ----------
    rate : float
        G: growth rate times t*.
    wave_number : float
        q c_t t* of that wave, c_t of the upper body.
    velocity : float
        Of its crests, over c_t of the upper body.
    """

    rate: float
    wave_number: float
    velocity: float


def fastest_delayed_growth(compliance: Compliance, friction: float) -> DelayedGrowth | None:
    """The fastest growth over all wave numbers under a delay; None where no wave grows.

    All waves that grow are looked for at every q c_t t* of a scale, for following those of no delay
    misses the fastest one of aluminium on steel at f = 0.5, and all of gouge on rock.

    Parameters
    ----------
    friction : float
        s f, the friction coefficient with the sense of slip.
    """
    from scipy.optimize import minimize_scalar  # here, for `import semianalytic` is to be quick

    low, high = np.log(_FROM * compliance.first), np.log(_TO * compliance.last)
    scale = np.linspace(low, high, int(np.ceil((high - low) / np.log(_RATIO))) + 1).tolist()
    found = [
        (float(wave.growth * np.exp(log)), log, wave)
        for log in scale
        for wave in growing_waves(compliance, friction, float(np.exp(log)))
    ]
    if not found:
        return None
    _, best, wave = max(found, key=lambda one: one[0])

    def followed(log: float) -> GrowingWave:
        k = _followed(compliance, friction, float(np.exp(log)), wave.slowness)
        return wave if k is None else GrowingWave(k)

    bounds = best - np.log(_RATIO), best + np.log(_RATIO)
    top = minimize_scalar(
        lambda log: -followed(log).growth * np.exp(log), bounds=bounds, method="bounded"
    )
    log = float(top.x)
    fastest = followed(log)
    delay = float(np.exp(log))
    return DelayedGrowth(float(fastest.growth * delay), delay, fastest.velocity)


def _followed(
    compliance: Compliance, friction: float, delay: float, start: complex
) -> complex | None:
    """The zero of Phi with a delay that Newton's method leads to; None where none grows."""
    k = start
    for _ in range(_MOST_NEWTON):
        near = min(abs(k + side * front) for front in compliance.fronts for side in (1, -1))
        step = _DIFFERENCE * near
        value, before, after = symbol(
            compliance.at(np.array([k, k - step, k + step])), friction, delay
        )
        move = complex(-2 * step * value / (after - before))
        longest = min(near, abs(k.imag)) / 2
        k += move * min(1.0, longest / abs(move)) if move else 0.0
        if abs(move) < _SETTLED * abs(k):
            return k
    return None
