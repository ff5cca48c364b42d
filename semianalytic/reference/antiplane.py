"""Antiplane shear in closed form: one slip zone [0, xi_s t] under a step of shear.

In mode III the impedance is M = mu sqrt(b^2 - k^2) and its factor M_+ = sqrt(b + k), so that every
integral is elementary under constant strength; `viscous_zone` has that which grows with slip rate.
Slip and slip rate are relative, upper minus lower side; velocities are x/t.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.reference.closed_forms import over_shear_speed
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import SceneError
from semianalytic.scene.scene import Material


def antiplane_edge_speed(material: Material, strength_ratio: float) -> float:
    """Return the speed of the edge of the slip zone, c_t / (1 + chi_b)^2 [length / time].

    Parameters
    ----------
    material : Material
        The solid.
    strength_ratio : float
        chi_b >= 0, strength less base shear, f P_b - Q_b, over the step Q_0 of shear.

    Raises
    ------
    SceneError
        If the ratio is negative: everything slips then.
    """
    if not strength_ratio >= 0:
        raise SceneError(f"strength_ratio: chi_b must not be negative, got {strength_ratio}.")
    return material.shear_speed / (1 + strength_ratio) ** 2


def antiplane_slip_rate(
    material: Material, load_shear: float, strength_ratio: float, velocity: ArrayLike
) -> Array:
    """Return the relative slip rate of the antiplane zone [length / time].

    It is (4 Q_0/(pi rho c_t)) arctan sqrt((xi_s - xi)/(c_t + xi)).

    Parameters
    ----------
    material : Material
    load_shear : float
        Q_0 [stress].
    strength_ratio : float
        As in `antiplane_edge_speed`; 0 without friction, when it is proportional to arccos(xi/c_t).
    velocity : array of any shape [length / time]
        x/t >= 0; 0 is the contact edge.

    Returns
    -------
    array of the shape of velocity; 0 ahead of the zone.
    """
    xi = over_shear_speed(material, velocity, edge=True)
    edge = _edge(material, strength_ratio)
    root = np.sqrt(np.maximum(edge - xi, 0.0) / (1 + xi))
    return np.asarray(4 * load_shear / (np.pi * material.shear_impedance) * np.arctan(root))


def antiplane_slip(
    material: Material, load_shear: float, strength_ratio: float, x: ArrayLike, t: ArrayLike
) -> Array:
    """Return the relative slip of the antiplane zone at x > 0 and t > 0, which broadcast [length].

    It is t V - (4 Q_0 x / (pi mu sqrt(xi_s / c_t))) arsinh sqrt((t/x - u_s) / (b + u_s)), with
    u_s = 1/xi_s.
    """
    x, t = np.asarray(x, dtype=float), np.asarray(t, dtype=float)
    if not all(np.all((part > 0) & (part < np.inf)) for part in (x, t)):
        raise SceneError("antiplane_slip: x and t must be positive and finite.")
    xi = over_shear_speed(material, x / t, edge=True)
    edge = _edge(material, strength_ratio)
    # (t/x - u_s) / (b + u_s) in velocities over c_t, without the difference of two slownesses.
    lag = np.maximum(edge - xi, 0.0) / (xi * (1 + edge))
    scale = 4 * load_shear / (np.pi * material.shear_modulus * np.sqrt(edge))
    rate = antiplane_slip_rate(material, load_shear, strength_ratio, x / t)
    return np.asarray(t * rate - scale * x * np.arcsinh(np.sqrt(lag)))


def antiplane_traction(
    material: Material, load_shear: float, strength_ratio: float, velocity: ArrayLike
) -> Array:
    """Return the shear traction that the step adds to the base at x/t = velocity [stress].

    Ahead of the zone it is (2 Q_0 / pi) [(1 + chi_b) arctan r - arctan((1 + chi_b) r)], r^2 =
    xi_s (c_t - xi) / (c_t (xi - xi_s)); in the zone chi_b Q_0, and 0 ahead of the shear wave.
    """
    xi = over_shear_speed(material, velocity, edge=True)
    edge = _edge(material, strength_ratio)
    ahead = xi > edge
    # Inside the zone the strength stands for the formula, whose root would be imaginary.
    distance = np.where(ahead, xi - edge, 1.0)
    r = np.sqrt(edge * np.maximum(1 - xi, 0.0) / distance)
    grown = (1 + strength_ratio) * np.arctan(r) - np.arctan((1 + strength_ratio) * r)
    return np.asarray(load_shear * np.where(ahead, 2 / np.pi * grown, strength_ratio))


def antiplane_edge_intensity(material: Material, load_shear: float, strength_ratio: float) -> float:
    """Return A of the slip rate A sqrt(1 - xi/xi_s) near the edge of the zone [length / time].

    It is A = (4 Q_0 / (pi rho c_t)) sqrt(xi_s / (c_t + xi_s)).
    """
    edge = _edge(material, strength_ratio)
    unit = 4 * load_shear / (np.pi * material.shear_impedance)
    return float(unit * np.sqrt(edge / (1 + edge)))


def _edge(material: Material, strength_ratio: float) -> float:
    """Return the edge of the zone without viscosity, over c_t."""
    return antiplane_edge_speed(material, strength_ratio) / material.shear_speed
