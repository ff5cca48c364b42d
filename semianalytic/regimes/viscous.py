"""Slip regimes under viscous friction: where the stick gap at c_R closes on a preloaded interface.

With a resistance eta the slope of slip rate at c_R is given by the pressure, which is least there:
V' = 0, and V is least at c_R in a zone that covers it.  The gap closes where that least V is 0.
Viscosity is in units of rho c_t / 2, the traction of a plane shear wave per relative slip rate.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

from semianalytic.halfplane.rayleigh import rayleigh_factors
from semianalytic.halfplane.stuck import stuck_traction
from semianalytic.regimes.thresholds import nucleation_alone, one_zone, past_rayleigh

_FRONTS = (-25.0, 25.0)  # `past_rayleigh` from c_l to c_t


def viscous_nucleation(poisson_ratio: float, viscosity: float) -> float:
    """Return the friction f P_b / Q_0 below which a preloaded shear front slips."""
    return nucleation_alone("preload", poisson_ratio, viscosity).chi


def viscous_closing(poisson_ratio: float, viscosity: float) -> float | None:
    """Return the friction f P_b / Q_0 below which one zone covers c_R under a step of shear.

    There is no such friction without viscosity, where a small viscosity leaves a gap however low
    friction is, or, for any viscosity, where the stuck traction at c_R opposes the load.  As
    viscosity grows the friction tends to that traction, q*(c).

    Returns
    -------
    float or None
        None if the gap never closes.
    """
    front_c = rayleigh_factors(poisson_ratio).front_c

    def least_rate(unknown: float) -> float:
        zone = one_zone("preload", poisson_ratio, past_rayleigh(poisson_ratio, unknown), viscosity)
        return float(zone.profile.slip_rate_at(front_c)[0])

    if not viscosity or least_rate(_FRONTS[0]) <= 0:
        return None
    unknown = brentq(least_rate, *_FRONTS, xtol=1e-12)
    front = past_rayleigh(poisson_ratio, float(unknown))
    return one_zone("preload", poisson_ratio, front, viscosity).chi


def closing_limit(poisson_ratio: float) -> float:
    """Return q*(c), the stuck traction at c_R over the step, to which `viscous_closing` tends."""
    factors = rayleigh_factors(poisson_ratio)
    return float(stuck_traction(poisson_ratio, "II")(np.array(factors.c)))


def closing_poisson_ratio() -> float:
    """Return the Poisson ratio below which no viscosity closes the gap, q*(c) = 0."""
    return float(brentq(closing_limit, -0.5, 0.0, xtol=1e-12))
