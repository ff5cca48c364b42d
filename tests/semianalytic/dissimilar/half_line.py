"""Slip rate ahead of an over-stressed half-line between two bodies, by quadrature on the cut."""

from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from docs.studies.dissimilar.half_line import half_line_speed, phase_rule
from semianalytic.dissimilar.compliance import Compliance
from semianalytic.dissimilar.phase import slip_phase
from semianalytic.dissimilar.stretch import Stretch
from semianalytic.scene.arrays import Array

REACH, SPACING = 36.0, 0.25
"""Largest |x| on a stretch, and spacing of x."""


def half_line_slip_rate(
    compliance: Compliance, friction: float, ratio: float, velocity: ArrayLike
) -> Array:
    """Return the relative slip rate ahead of an over-stressed half-line at x/t = velocity > 0.

    It is in units of the excess on x < 0 plus the stress below friction on x > 0, over the
    impedance mu / c_t of the upper body, and follows from dV/dv = -X(-v) Im(1/K) / (pi v).
    """
    speed = half_line_speed(compliance, friction, ratio)
    _, weight, distance = phase_rule(slip_phase(compliance, friction), 1 / speed)
    velocity = np.asarray(velocity, dtype=float)
    rates = [
        _slip_rate_behind(compliance, friction, (weight, distance), 1 / speed, 1 / rate)
        if rate < speed
        else 0.0
        for rate in velocity.ravel()
    ]
    return np.array(rates).reshape(velocity.shape)


def _slip_rate_behind(
    compliance: Compliance, friction: float, known: tuple[Array, Array], start: float, stop: float
) -> float:
    """Return the integral of dV/dv from the edge to a slowness behind it."""
    (weight, distance), total = known, 0.0
    ends = [start, *(v for v in compliance.distinct_fronts if start < v < stop), stop]
    x = np.arange(-2 * REACH, REACH, SPACING)  # both ends of a stretch are algebraic
    for left, right in pairwise(ends):
        stretch = Stretch(left, right)
        at = stretch.at(x)
        from_edge = np.asarray(stretch.minus(at, np.array([start]))[0])
        # X(-v): w - v = -((u - w) + (v - u)), of which both distances from the edge u are exact.
        canonical = np.exp(-(weight / -(distance + from_edge[:, None])).sum(axis=1) / np.pi)
        entries = compliance.on_cut(at.v, stretch.minus(at, compliance.fronts))
        mobility = (entries.determinant / entries.frictional(friction)).imag
        slope = -canonical * mobility / (np.pi * at.v) * np.asarray(stretch.slope(at))
        total += SPACING * float(slope.sum())
    return total
