"""Speeds of waves along an interface without friction or slip, and friction at which waves grow.

Speeds are in units of c_t of the upper body.
"""

from __future__ import annotations

import numpy as np

from semianalytic.dissimilar.compliance import Complex, Compliance, Entries
from semianalytic.dissimilar.growth import count_growing
from semianalytic.dissimilar.phase import bonded_phase, contact_phase
from semianalytic.dissimilar.stretch import Stretch, stretches
from semianalytic.halfplane.rayleigh import Array

LEAST_FRICTION = 1e-6
"""Threshold below which it counts as 0, since no interface is that smooth."""


def generalised_rayleigh_speed(compliance: Compliance) -> float | None:
    """Return the speed of the wave along a closed interface without friction, A(k) = 0, or None.

    It is slower than all body waves.  Where it exists, every friction coefficient lets waves grow
    (Ranjith and Rice 2001).
    """
    return _slow_zero(compliance, contact_phase(compliance, 0.0).zeros)


def stoneley_speed(compliance: Compliance) -> float | None:
    """Return the speed of the wave along a bonded interface, A B + k^2 D^2 = 0, or None."""
    return _slow_zero(compliance, bonded_phase(compliance).zeros)


def _slow_zero(compliance: Compliance, zeros: tuple[float, ...]) -> float | None:
    # Zeros ahead of a body wave radiate into that body, and are no waves of the interface.
    slow = [1 / v for v in zeros if v > compliance.last]
    return slow[0] if slow else None


def growth_threshold(compliance: Compliance, direction: int) -> float:
    """Return the friction coefficient above which waves grow that run in a direction.

    Parameters
    ----------
    direction : +1 or -1
        The direction in which the upper body slides, f_+, or the other one, f_-.

    Returns
    -------
    float
        0 where every coefficient lets waves grow, inf where none does.
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
    found: list[float] = []
    for stretch in stretches(compliance.distinct_fronts):
        found += _crossings_on(compliance, stretch)
    return np.sort(found)


def _crossings_on(compliance: Compliance, stretch: Stretch) -> list[float]:
    """Return the s f of all crossings on one stretch of the cut.

    They are -Re(A / (k D)) at the zeros of Im(A / (k D)).
    """
    from scipy.optimize import brentq  # here, for `import semianalytic` is to be quick

    def ratio(x: Array) -> Complex:
        points = stretch.at(x)
        entries = compliance.on_cut(points.v, stretch.minus(points, compliance.fronts))
        return _without_poles(entries)

    def turned(x: float) -> float:
        return float(ratio(np.array([x]))[0].imag)

    # Of 200 random pairs none has other thresholds at half the step, one at five times.
    x = np.arange(-38.0, 38.01, 0.02)
    sign = np.sign(ratio(x).imag)
    found = []
    for i in np.flatnonzero(sign[1:] * sign[:-1] < 0):
        root = np.array([brentq(turned, x[i], x[i + 1], xtol=1e-14)])
        entries = compliance.on_cut(
            stretch.at(root).v, stretch.minus(stretch.at(root), compliance.fronts)
        )
        # Next to zeros of k D a crossing is rounding.
        if abs(entries.coupling[0]) > 1e-12 * abs(entries.normal[0]):
            found.append(float((-entries.normal / entries.coupling).real[0]))
    return found


def _without_poles(entries: Entries) -> Complex:
    """Return A / (k D) times |k D|^2 / (|A|^2 + |k D|^2), which has no pole at zeros of k D."""
    scale = np.abs(entries.normal) ** 2 + np.abs(entries.coupling) ** 2
    return np.asarray(entries.normal * entries.coupling.conj() / scale)
