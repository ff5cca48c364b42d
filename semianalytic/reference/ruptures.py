"""Closed results on ruptures: critical wavelengths of rate-and-state, and supershear strength."""

from __future__ import annotations

import math

import numpy as np

from semianalytic.halfplane.rayleigh import rayleigh_factors
from semianalytic.memory.impedance import Antiplane, Impedance, InPlane
from semianalytic.reference.prescribed_crack import PrescribedCrack
from semianalytic.scene.arguments import checking
from semianalytic.scene.checks import checked_number, checked_size
from semianalytic.scene.errors import SceneError
from semianalytic.scene.material import Material


def critical_wavenumber(ratio: float, inertia: float, impedance: Impedance) -> float:
    """Return mu q L / (2 a sigma) of the wave that neither grows nor decays in steady sliding.

    Waves exp(lambda t + i q x) of steady sliding at V0 obey, with Lambda = lambda L / V0,

        1 - r / (1 + Lambda) + (kappa / Lambda) F(Lambda zeta / kappa) = 0,  F(s) = s G(s),

    where r = b/a, zeta = mu V0 / (2 c_t a sigma), kappa = mu q L / (2 a sigma) (Rice, Lapusta &
    Ranjith 2001).  The neutral one has Lambda = i sqrt(r - 1); longer ones grow.

    Parameters
    ----------
    ratio : float
        r = b/a, above 1.
    inertia : float
        zeta, 0 or more; 0 is quasi-static.
    impedance : Antiplane or InPlane
        G of the mode.
    """
    turn = math.sqrt(ratio - 1)
    if inertia == 0:
        return (ratio - 1) / impedance.static

    def excess(kappa: float) -> float:
        s = complex(1e-300, turn * inertia / kappa)
        return kappa * (s * _value(impedance, s)).real - (ratio - 1)

    # F falls from the static stiffness to 0 at the slowest surface wave, so the root lies above
    # the quasi-static one; kappa F rises from there
    low, high = (ratio - 1) / impedance.static, 2 * (ratio - 1 + turn * inertia) / impedance.static
    low = max(low, turn * inertia * (1 + 1e-12))
    for _ in range(200):
        middle = (low + high) / 2
        if not low < middle < high:
            break
        low, high = (middle, high) if excess(middle) < 0 else (low, middle)
    return (low + high) / 2


def growth(ratio: float, inertia: float, wavenumber: float, impedance: Impedance) -> complex:
    """Return Lambda = lambda L / V0 of the wave of a wavenumber kappa; see `critical_wavenumber`.

    It is continued from the neutral wave by Newton's method.

    Raises
    ------
    SceneError
        If the continuation fails.
    """
    start = critical_wavenumber(ratio, inertia, impedance)
    found = complex(0, math.sqrt(ratio - 1))

    def residual(value: complex, kappa: float) -> complex:
        s = value * inertia / kappa
        # F in the left half-plane is continued through the right one only where it is smooth
        stiff = impedance.static if inertia == 0 else s * _value(impedance, s)
        return 1 - ratio / (1 + value) + kappa / value * stiff

    # 210 growth rates are met to 1e-11.
    for kappa in np.geomspace(start, wavenumber, 41)[1:]:
        for _ in range(50):
            step = 1e-7 * abs(found)
            slope = (residual(found + step, kappa) - residual(found - step, kappa)) / (2 * step)
            change = residual(found, kappa) / slope
            found -= change
            if abs(change) < 1e-13 * abs(found):
                break
        else:
            raise SceneError(f"growth: there is no wave to follow at kappa = {kappa:.4g}.")
    return found


def _value(impedance: Impedance, s: complex) -> complex:
    return complex(impedance(np.array([s]))[0])


@checking
def critical_wavelength(
    material: Material,
    a: float,
    b: float,
    pressure: float,
    distance: float,
    rate: float = 0.0,
    mode: str = "in-plane",
) -> float:
    """Return the wavelength above which steady rate-and-state sliding is unstable [length].

    Parameters
    ----------
    material : Material
        The solid on both sides.
    a, b : float
        Direct effect and evolution of friction, b above a.
    pressure : float
        Contact pressure [stress].
    distance : float
        Slip L over which the state changes [length].
    rate : float
        Slip rate of the steady sliding [length / time]; 0 is quasi-static.
    mode : str
        "in-plane" or "antiplane".

    Raises
    ------
    SceneError
        If b is not above a, or a number is out of range.

    Examples
    --------
    >>> from semianalytic import Material
    >>> from semianalytic.reference.ruptures import critical_wavelength
    >>> rock = Material(30e9, 2700.0, 0.25)
    >>> round(critical_wavelength(rock, 0.010, 0.014, 50e6, 1e-5), 4)
    6.2832
    """
    for name, value in (("a", a), ("pressure", pressure), ("distance", distance)):
        checked_size(f"critical_wavelength: {name}", value)
    checked_number("critical_wavelength: rate", rate, "be 0 or more", lambda value: value >= 0)
    if not b > a:
        raise SceneError("critical_wavelength: b must be above a, or all waves decay.")
    scale = 2 * a * pressure
    zeta = material.shear_modulus * rate / (material.shear_speed * scale)
    if mode == "antiplane":
        impedance: Impedance = Antiplane()
    else:
        impedance = InPlane(material.shear_speed / material.longitudinal_speed)
    kappa = critical_wavenumber(b / a, zeta, impedance)
    return 2 * math.pi * material.shear_modulus * distance / (scale * kappa)


@checking
def supershear_strength(poisson_ratio: float, speed: float = 1.0) -> float:
    """Return the traction that a self-similar in-plane crack sends ahead with its shear wave.

    It is the excess over the traction before, in units of the stress drop, at the shear front of a
    crack that grows at a share `speed` of the Rayleigh speed.  At the Rayleigh speed it is the
    largest S = (tau_p - tau_0) / (tau_0 - tau_d) at which a rupture turns supershear (Burridge
    1973; Andrews 1976).

    Parameters
    ----------
    poisson_ratio : float
        Poisson ratio, 0 to 0.5.
    speed : float
        Speed of the crack over the Rayleigh speed, 0 to 1.

    Examples
    --------
    >>> from semianalytic.reference.ruptures import supershear_strength
    >>> round(supershear_strength(0.25), 6)
    1.774648
    """
    material = Material(1.0, 1.0, poisson_ratio)
    share = checked_number(
        "supershear_strength: speed", speed, "lie between 0 and 1", lambda value: 0 < value <= 1
    )
    # `prescribed_crack` leaves out the Rayleigh speed, at which tips take no energy.
    own, factors = share * material.rayleigh_speed, rayleigh_factors(poisson_ratio)
    crack = PrescribedCrack(material, own, 1.0, "II", factors)
    return float(crack.traction(material.shear_speed, 1.0))
