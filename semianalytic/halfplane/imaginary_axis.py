"""The impedance of a half-plane at imaginary slowness k = i eta, where it is real and smooth.

A load that is even about a point moves the interface evenly as well, and what it
needs is integrals of M over the imaginary axis, not its Wiener-Hopf factors.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from semianalytic.halfplane.rayleigh import RayleighFactors
from semianalytic.scene.arrays import Array


def impedance_on_axis(factors: RayleighFactors, eta: Array) -> Array:
    """Return M(i eta) of the mode of the factors at eta > 0 [mu b], free of cancellation.

    R = (b^2 + 2 eta^2)^2 - 4 eta^2 alpha beta is written 1 + 4 eta^2 beta (1 - a^2)/(alpha + beta).
    """
    alpha, beta = _roots(factors, eta)
    if factors.mode == "III":
        return beta
    rayleigh = 1 + 4 * eta**2 * beta * (1 - factors.a**2) / (alpha + beta)
    return np.asarray(rayleigh / (beta if factors.mode == "II" else alpha))


def static_remainder(factors: RayleighFactors, eta: Array, edge: float) -> Array:
    """Return the static kappa less M(i eta) / sqrt(edge^2 + eta^2), free of cancellation."""
    alpha, beta = _roots(factors, eta)
    root = np.sqrt(edge**2 + eta**2)
    if factors.mode == "III":
        return np.asarray((edge**2 - 1) / ((root + beta) * root))
    half = (alpha + beta) / 2
    # sqrt(eta^2 + q^2) = eta + q^2 / (eta + sqrt(eta^2 + q^2)), for q = a, b and the edge
    above = (factors.a**2 / (eta + alpha) + 1 / (eta + beta)) / 2
    lead = (edge**2 / (eta + root) * half + eta * above) / half  # root - eta^2 / half
    own = 1 / beta
    if factors.mode == "I":  # over alpha, not beta, which leaves one more difference of the roots
        own = 1 / alpha + factors.kappa * eta**2 * (1 - factors.a**2) / (half * alpha * 2 * half)
    return np.asarray((factors.kappa * lead - own) / root)


# Analytic to +- i pi/2, integrands leave exp(-pi^2 / 0.2) = 4e-22; twice it leaves 2e-11.
def over_axis(function: Callable[[Array], Array], spacing: float = 0.2) -> float:
    """Return the integral of a function of eta from 0 to infinity by the trapezoidal rule in ln."""
    eta = np.exp(np.arange(-44.0, 44.0 + spacing / 2, spacing))
    return float(spacing * (eta @ function(eta)))


def _roots(factors: RayleighFactors, eta: Array) -> tuple[Array, Array]:
    return np.sqrt(factors.a**2 + eta**2), np.sqrt(1 + eta**2)
