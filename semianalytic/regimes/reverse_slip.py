"""Reverse slip under a step of shear on a preloaded interface: threshold and width.

Loading, units and unknowns are those of `semianalytic.regimes.thresholds`.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import brentq

from semianalytic.cut.profile import Profile
from semianalytic.cut.quadrature.layout import Zone
from semianalytic.cut.zones import ZoneFields
from semianalytic.halfplane.rayleigh import rayleigh_factors
from semianalytic.regimes.thresholds import (
    NEGLIGIBLE,
    RULE,
    SLOW_FRONTS,
    OneZone,
    before_rayleigh,
    front_zone_unknowns,
    load_of,
    nucleation_alone,
    one_zone,
    past_rayleigh,
    rayleigh_logarithm,
    rooted,
    scene_of,
)
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import SceneError
from semianalytic.selfsimilar.solver import solve

_FASTEST = -60.0  # `past_rayleigh` of a front indistinguishable from the longitudinal one


def log_frictionless_half_width(poisson_ratio: float) -> float:
    """Return ln of the half-width [c_R] of the strip that reverses on a frictionless interface.

    It is half the distance between the two velocities at which V vanishes under a step of shear
    alone; where x/t does not resolve the strip, it is exp(-A / r), as V = A + r ln|v - c| there.
    """
    zone = one_zone("preload", poisson_ratio, past_rayleigh(poisson_ratio, _FASTEST))
    narrow = rayleigh_logarithm(zone).log_half_width
    if narrow < math.log(1e-7):
        return narrow - math.log(rayleigh_factors(poisson_ratio).c)
    solution = solve(scene_of("preload", poisson_ratio, 0.0), rtol=1e-10)
    reverse = next(zone for zone in solution.zones if zone.sense < 0)
    speed = solution.scene.material.rayleigh_speed
    return math.log((reverse.outer - reverse.inner) / (2 * speed))


def _log_narrow_candidate(poisson_ratio: float, unknown: float) -> tuple[float, float]:
    """Return ln of (Im M)'(c) r w and of chi for a zone that ends at a front past c_R."""
    factors = rayleigh_factors(poisson_ratio)
    c = factors.c
    stiffness = 2 * c * float(factors.reduced_rayleigh(c)) / math.sqrt(c * c - 1)
    zone = one_zone("preload", poisson_ratio, past_rayleigh(poisson_ratio, unknown))
    logarithm = rayleigh_logarithm(zone)
    return math.log(stiffness * logarithm.residue) + logarithm.log_half_width, math.log(zone.chi)


def log_narrow_reverse_threshold(poisson_ratio: float) -> float:
    """Return ln of the friction below which a narrow strip at c_R reverses under a shear step.

    In a gap |v - c| < d the traction dips below +f p by (Im M)'(c) r sqrt(d^2 - (v - c)^2), r the
    residue of dV/dv, and d is twice the half-width w of the strip that the logarithm reverses.
    The dip spans 2 f p at chi = (Im M)'(c) r w.  Exact for w -> 0.  SceneError if there is none.
    """

    def excess(unknown: float) -> float:
        reversing, present = _log_narrow_candidate(poisson_ratio, unknown)
        return reversing - present

    if excess(0.0) > 0:
        raise SceneError("No narrow strip reverses; give a poisson_ratio above -0.42.")
    unknown = float(brentq(excess, _FASTEST, 0.0, xtol=1e-10))
    return _log_narrow_candidate(poisson_ratio, unknown)[0]


def _least_traction(profile: Profile, gap: float) -> float:
    """Return tau / (f p) + 1 at c_R, its least between zones, 1e-4 of the gap [b] near it."""
    load = profile.fields.load
    u = np.array([profile.fields.factors.c + 1e-4 * gap])
    bound = load.friction * (load.base_pressure + profile.pressure_change(u))
    return float(((load.base_shear + profile.shear_change(u)) / bound)[0]) + 1


def reverse_threshold(poisson_ratio: float) -> float:
    """Return the friction below which part of the interface slips backward under a shear step.

    It is traced on one zone where reversal comes before slip at the shear front, on two zones
    otherwise, and by the closed form where the reversed strip is very narrow.

    Raises
    ------
    ComputationError
        If Newton's method fails.
    """
    log_width = log_frictionless_half_width(poisson_ratio)
    if log_width < math.log(1e-7):
        return math.exp(log_narrow_reverse_threshold(poisson_ratio))
    nucleating = nucleation_alone("preload", poisson_ratio)
    front = float(nucleating.profile.panels.left[-1].from_c[0])
    least = _least_traction(nucleating.profile, front)
    if least < NEGLIGIBLE:
        return _threshold_on_one_zone(poisson_ratio, front)
    if log_width < math.log(0.03):  # up to 0.03 the closed form of a narrow strip is good to 5 %
        chi = 1.1 * math.exp(log_narrow_reverse_threshold(poisson_ratio))
    else:
        chi = (1 - 0.85 * least) * nucleating.chi  # the threshold is near 1 - 0.92 least
    return _threshold_on_two_zones(poisson_ratio, chi)


def _threshold_on_one_zone(poisson_ratio: float, front: float) -> float:
    """Return the friction at which a zone from the edge brings c_R to -f p, from a start v - c."""
    factors = rayleigh_factors(poisson_ratio)

    def zone(log_distance: float) -> OneZone:
        return one_zone("preload", poisson_ratio, factors.beside("c", [math.exp(log_distance)]))

    def least(log_distance: float) -> float:
        return _least_traction(zone(log_distance).profile, math.exp(log_distance))

    return zone(brentq(least, math.log(0.9 * front), SLOW_FRONTS[1], xtol=1e-12)).chi


def _threshold_on_two_zones(poisson_ratio: float, chi: float) -> float:
    """Return the friction at which the gap between two zones is brought to -f p, from above."""
    factors = rayleigh_factors(poisson_ratio)

    def residual(unknowns: Array) -> Array:
        slow, healed, fast, log_chi = unknowns
        inner = Zone(factors.beside("c", [math.exp(slow)]), None, 1)
        opening = before_rayleigh(factors, healed)
        outer = Zone(past_rayleigh(poisson_ratio, fast), opening, 1)
        fields = ZoneFields(factors, load_of("preload", math.exp(log_chi)), (outer, inner), RULE)
        gap = min(math.exp(slow), -float(opening.from_c[0]))
        return np.append(fields.mismatch(), _least_traction(Profile(fields), gap))

    zones = solve(scene_of("preload", poisson_ratio, chi), rtol=1e-6).zones
    outer, slow = zones[-1], math.log(1 / zones[0].outer - factors.c)
    start = [slow, *front_zone_unknowns(poisson_ratio, outer.inner, outer.outer), math.log(chi)]
    return math.exp(rooted(residual, start)[-1])
