"""Edges and gap rates of a contact that opens under a step of pressure, by quadrature.

Like `closed_forms` they use neither the panels nor Newton's method for zone edges.  P, the
transform of the change of pressure, is M_+ over square roots at the edges, times what its behaviour
at infinity leaves open.  Gap rates are relative, upper minus lower side, opening positive;
velocities are x/t.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import quad
from scipy.optimize import brentq

from semianalytic.halfplane.rayleigh import RayleighFactors, rayleigh_factors
from semianalytic.reference.closed_forms import (
    over_shear_speed,
    rate_from_contact_edge,
    relative_rate,
)
from semianalytic.scene.arrays import Array
from semianalytic.scene.checks import checked_number
from semianalytic.scene.errors import SceneError
from semianalytic.scene.scene import Material

_NODES = 400


def edge_speed_of_opening(material: Material, pressure_ratio: float) -> float:
    """Return the speed of the opening [0, speed t] under an extra pressure on the slot faces.

    It is c_t sqrt((1 - 2 nu) / (2 (1 - nu))) / ((1 - nu) (1 + chi_o)^2) [length / time].

    Parameters
    ----------
    material : Material
    pressure_ratio : float
        chi_o, base pressure P_b over the extra pressure |P_0|.
    """
    owner = "edge_speed_of_opening: pressure_ratio"
    checked_number(owner, pressure_ratio, "be 0 or more", lambda given: given >= 0)
    nu = material.poisson_ratio
    ratio = float(np.sqrt((1 - 2 * nu) / (2 * (1 - nu))))  # of c_t to c_l
    return material.shear_speed * ratio / ((1 - nu) * (1 + pressure_ratio) ** 2)


def gap_rate_of_opening(
    material: Material, load_pressure: float, pressure_ratio: float, velocity: ArrayLike
) -> Array:
    """Return the relative gap rate of the opening from the contact edge [length / time].

    It is 2 v_y, v_y = (|P_0| sqrt(u_o) / (pi kappa M_+(0))) int sqrt(a + v) / (v sqrt(v - u_o)
    (c + v) S_+) dv from u_o to 1/xi, with M_+ of mode I.

    Parameters
    ----------
    material : Material
    load_pressure : float
        P_0 < 0, the extra pressure on the slot faces being |P_0| [stress].
    pressure_ratio : float
        chi_o, base pressure P_b over |P_0|.
    velocity : array of any shape [length / time]
        0 is the contact edge.

    Returns
    -------
    array of the shape of velocity; 0 ahead of the opening.

    Raises
    ------
    SceneError
        If a velocity is negative, or the pressure step is not.
    """
    if not load_pressure < 0:
        raise SceneError("load_pressure: the edge opens under a negative pressure step only.")
    edge = edge_speed_of_opening(material, pressure_ratio) / material.shear_speed
    rate = rate_from_contact_edge(rayleigh_factors(material.poisson_ratio), "I", edge)
    xi = over_shear_speed(material, velocity, edge=True)
    return relative_rate(material, -load_pressure, xi, rate)


@dataclass(frozen=True)
class DetachedOpening:
    """The opening around the Rayleigh front that a sudden pressure on a small base makes.

    Attributes
    ----------
    inner, outer : float
        Velocities of the edges at which it closes and opens [length / time].
    pressure_ratio : float
        Base pressure over the step of pressure, P_b / P_0.
    """

    inner: float
    outer: float
    pressure_ratio: float


def detached_opening(material: Material, outer: float) -> DetachedOpening:
    """Return the opening that begins at the speed `outer`, from c_R to c_t, and its load.

    P = M_+ sqrt((k + u_o)(k + u_i)) / (c + k) (R + r / (k + u_i)) has two constants left after
    P(0) = P_0 is known, and u_i: the rate of the gap and the gap are 0 where it closes, and the
    pressure is 0 where it opens, which gives P_b.

    Parameters
    ----------
    material : Material
    outer : float
        Where the contact opens [length / time], above c_R and not above c_t.

    Raises
    ------
    SceneError
        If `outer` is not between c_R and c_t.
    """
    speed = material.shear_speed
    if not material.rayleigh_speed < outer <= speed:
        raise SceneError("outer: the opening begins between the Rayleigh and the shear speed.")
    factors, start = rayleigh_factors(material.poisson_ratio), speed / outer

    def gap_left(log: float) -> float:
        end = factors.c + np.exp(log)
        return _closed(factors, start, end, _constants(factors, start, end), 1)

    # The unknown is the distance of the closing edge behind c, from a tenth of that of the opening
    # edge ahead of it on.
    nearest, farthest = np.log((factors.c - start) / 10), np.log(100.0)
    end = factors.c + np.exp(brentq(gap_left, nearest, farthest, xtol=1e-14, rtol=1e-14))
    ratio = -_pressure_gained(factors, start, end, _constants(factors, start, end))
    return DetachedOpening(speed / end, outer, ratio)


def _constants(factors: RayleighFactors, start: float, end: float) -> tuple[float, float]:
    """Return R and r for P_0 = 1 for which the gap closes at zero rate."""
    smooth, sharp = (_closed(factors, start, end, powers, 0) for powers in ((1.0, 0.0), (0.0, 1.0)))
    # P(0) = M_+(0) sqrt(u_o u_i) (R + r / u_i) / c = 1, with M_+(0) = c S_+(0) / sqrt(a).
    unit = np.sqrt(factors.a / (start * end)) / float(factors.s_plus(0.0))
    r = unit / (1 / end - sharp / smooth)
    return -r * sharp / smooth, r


def _closed(
    factors: RayleighFactors, start: float, end: float, constants: tuple[float, float], moment: int
) -> float:
    """Return the principal value of int v^moment dv_y/dv dv over the opening.

    The Gauss-Jacobi rule for sqrt((v - start) / (end - v)) is used, for which the principal value
    of 1 / (v - c) is pi.
    """
    big, small = constants
    half = np.pi * (np.arange(_NODES) + 0.5) / (2 * _NODES + 1)
    v = end - (end - start) * np.square(np.sin(half))
    weight = 2 * np.pi * (end - start) * np.square(np.cos(half)) / (2 * _NODES + 1)

    def numerator(v: Array) -> Array:
        unit = -np.pi * factors.kappa * v * (v + factors.c) * factors.s_plus(v)
        return np.sqrt(v + factors.a) / unit * (big * (end - v) + small) * v**moment

    # The pole at c is subtracted at the nodes and added as its principal value.
    at_c = float(numerator(np.array(factors.c)))
    return float(weight @ ((numerator(v) - at_c) / (v - factors.c)) + np.pi * at_c)


def _pressure_gained(
    factors: RayleighFactors, start: float, end: float, constants: tuple[float, float]
) -> float:
    """Return the change of pressure from the longitudinal front to the opening edge, P_0 = 1."""
    big, small = constants

    def slope(v: float) -> float:  # times sqrt(v - a)
        # Ahead of the shear wave only this term of R is on the cut; behind it all of R is.
        impedance = -np.square(1 - 2 * v * v)
        if v > 1:
            impedance = float(factors.reduced_rayleigh(v)) * (v + factors.c) * (v - factors.c)
        m_plus = float(factors.m_plus(v, "I")) * np.sqrt(v + factors.a)
        roots = np.sqrt((start - v) * (end - v)) / (factors.c - v)
        scale = np.pi * factors.kappa * v * m_plus
        return float(impedance * roots * (big + small / (end - v)) / scale)

    def over(left: float, right: float) -> float:  # v = left + (right - left) sin(s)^2
        def density(s: float) -> float:
            v = left + (right - left) * np.sin(s) ** 2
            # dv / sqrt(v - a) = 2 sqrt(right - a) cos(s) ds: the root of the front is gone.
            if left == factors.a:
                return 2 * np.sqrt(right - left) * np.cos(s) * slope(v)
            return (right - left) * np.sin(2 * s) * slope(v) / np.sqrt(v - factors.a)

        return float(quad(density, 0, np.pi / 2, epsabs=1e-14, epsrel=1e-13, limit=200)[0])

    return over(factors.a, 1.0) + (over(1.0, start) if start > 1 else 0.0)
