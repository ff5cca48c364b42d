"""Speeds of waves without friction or slip, and friction at which waves grow, over upper c_t."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from semianalytic.dissimilar.compliance import Compliance, Entries
from semianalytic.dissimilar.growth import count_growing
from semianalytic.dissimilar.phase import bonded_phase, contact_phase
from semianalytic.dissimilar.stretch import Stretch, stretches
from semianalytic.scene.arrays import Array

LEAST_FRICTION = 1e-6
"""Threshold below which it counts as 0, since no interface is that smooth."""


def generalised_rayleigh_speed(compliance: Compliance) -> float | None:
    """Return the speed of the wave along a closed interface without friction, A(k) = 0, or None.

    It is slower than all body waves.  Where it exists, every friction coefficient lets waves grow
    (Ranjith and Rice 2001).
    """
    return _slow_zero(compliance, contact_phase(compliance, 0.0).zeros)


@lru_cache(maxsize=64)
def stoneley_speed(compliance: Compliance) -> float | None:
    """Return the speed of the wave along a bonded interface, A B + k^2 D^2 = 0, or None."""
    return _slow_zero(compliance, bonded_phase(compliance).zeros)


def _slow_zero(compliance: Compliance, zeros: tuple[float, ...]) -> float | None:
    # Zeros ahead of a body wave radiate into that body, and are no waves of the interface.
    slow = [1 / v for v in zeros if v > compliance.last]
    return slow[0] if slow else None


def growth_threshold(compliance: Compliance, direction: int) -> float:
    """Return the friction coefficient above which waves grow that run in a direction.

    The direction is +1 for that in which the upper body slides, f_+, or -1 for the other one, f_-.
    It is 0 where every coefficient lets waves grow, inf where none does.
    """
    if compliance.is_alike:
        return np.inf
    # Waves towards +x while the upper body slides towards +x are those towards -x of a mirrored
    # interface; slip of the other sense changes the sign of friction.
    crossings = [f * direction for f in friction_crossings(compliance) if f * direction > 0]
    low = 0.0
    # Between two crossings the number of growing waves is constant: one count serves each.
    for f in [*sorted(crossings), np.inf]:
        # Between two crossings nearer than that none is resolved.
        middle = (1 + low) * 2 if f == np.inf else np.sqrt(max(low, f * 1e-4) * f)
        if count_growing(compliance, direction * middle):
            return low
        low = f
    return np.inf


def friction_crossings(compliance: Compliance) -> Array:
    """Return all s f at which A + s f k D vanishes on the cut k = -v + i0, in increasing order.

    There a wave that runs towards +x turns from decaying to growing or back.
    """
    if compliance.is_alike:
        return np.zeros(0)
    parts = stretches(compliance.distinct_fronts)
    return np.sort([f for stretch in parts for f in _crossings_on(compliance, stretch)])


def _crossings_on(compliance: Compliance, stretch: Stretch) -> list[float]:
    """Return s f = -Re(A / (k D)) at the zeros of Im(A / (k D)) on one stretch of the cut."""
    from scipy.optimize import brentq  # here, for `import semianalytic` is to be quick

    def at(x: Array) -> Entries:
        points = stretch.at(x)
        return compliance.on_cut(points.v, stretch.minus(points, compliance.fronts))

    def turn(x: Array) -> Array:  # of A / (k D) times what takes its poles
        entries = at(x)
        scale = np.abs(entries.normal) ** 2 + np.abs(entries.coupling) ** 2
        return np.asarray((entries.normal * entries.coupling.conj() / scale).imag)

    def turned(x: float) -> float:
        return float(turn(np.array([x]))[0])

    # None of 200 random pairs has other thresholds at half the step, one at five times.
    x = np.arange(-38.0, 38.01, 0.02)
    sign = np.sign(turn(x))
    found = []
    for i in np.flatnonzero(sign[1:] * sign[:-1] < 0):
        entries = at(np.array([brentq(turned, x[i], x[i + 1], xtol=1e-14)]))
        # Next to zeros of k D a crossing is rounding.
        if abs(entries.coupling[0]) > 1e-12 * abs(entries.normal[0]):
            found.append(float((-entries.normal / entries.coupling).real[0]))
    return found
