"""Antiplane shear in closed form: one slip zone [0, xi_s t] under a step of shear.

In mode III the impedance is M = mu sqrt(b^2 - k^2) and its factor M_+ = sqrt(b + k), so that every
integral is elementary.  Strength is constant, or grows with slip rate as f p +
viscosity |V|, when the phase arctan(eta / sqrt(v^2 - b^2)), eta = 2 viscosity, multiplies the
transform by one more canonical product.  Slip and slip rate are relative, upper minus lower side;
velocities are x/t.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import brentq

from semianalytic.reference.closed_forms import over_shear_speed, relative_rate
from semianalytic.scene.errors import SceneError
from semianalytic.scene.scene import Material

Array = NDArray[np.float64]

_GAUSS = 80
_SPACING, _REACH = 0.08, 90.0
"""Nodes of y in x = l + w / (1 + exp(-y)), which turns powers and logarithms at both ends of an
interval into exponentials."""


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


def viscous_antiplane_edge_speed(
    material: Material, strength_ratio: float, viscosity: float
) -> float:
    """Return the speed of the edge of the zone if strength grows by viscosity |V| [length / time].

    Parameters
    ----------
    material : Material
    strength_ratio : float
        As in `antiplane_edge_speed`, at rest; above 0.
    viscosity : float
        Strength per relative slip rate [stress time / length], not negative.
    """
    return _viscous_zone(material, strength_ratio, viscosity).edge * material.shear_speed


def viscous_antiplane_slip_rate(
    material: Material,
    load_shear: float,
    strength_ratio: float,
    viscosity: float,
    velocity: ArrayLike,
) -> Array:
    """Return the relative slip rate of the viscous antiplane zone at x/t = velocity >= 0."""
    zone = _viscous_zone(material, strength_ratio, viscosity)
    xi = over_shear_speed(material, velocity, edge=True)
    return relative_rate(material, load_shear, xi, zone.slip_rate)


@dataclass(frozen=True)
class _AntiplaneFilm:
    """The fields of a viscous zone [0, edge], b = mu = Q_0 = 1, one-sided.

    T(k) = A sqrt((b + k) / (u_s + k)) exp(-(1/pi) int theta dv / (v + k)), theta = arctan(eta/m),
    m^2 = v^2 - b^2 from u_s on; A from T(0) = Q_0.
    """

    edge: float
    eta: float

    @cached_property
    def _nodes(self) -> tuple[Array, Array, Array]:
        """Values of sin(angle), theta / sin(angle) and weights d sin(angle) on the zone."""
        node, weight = np.polynomial.legendre.leggauss(_GAUSS)
        # The root sqrt(1 - xi^2) of the angle theta is smooth in arcsin xi, for edges up to the
        # wave.
        last = np.arcsin(self.edge)
        angle = last * (node + 1) / 2
        return np.sin(angle), self._density(np.sin(angle)), last / 2 * weight * np.cos(angle)

    def _density(self, xi: Array) -> Array:
        """Return theta / xi."""
        return np.asarray(np.arctan2(self.eta * xi, np.sqrt(1 - xi * xi)) / xi)

    def _factor(self, xi: Array, from_edge: Array) -> Array:
        """Return |T| over sqrt(|b - v| / |u_s - v|), at exact distances |xi - edge|."""
        at, density, weight = self._nodes
        own = self._density(xi)
        # The pole at xi is taken out of the integral and added in closed form, as a logarithm.
        quotient = (density - own[:, None]) / (at - xi[:, None])
        exponent = quotient @ weight + own * np.log(from_edge / xi)
        at_zero = -(density @ weight)
        return np.asarray(np.exp((xi * exponent - at_zero) / np.pi) / np.sqrt(self.edge))

    def traction_at_edge(self) -> float:
        """Traction at the edge of the zone, grown from 0 at the shear wave, over Q_0."""
        from_edge, from_wave, weight = _stretch(1 - self.edge)
        xi = self.edge + from_edge
        # The traction is 0 at the shear wave and grows from there to the edge.
        density = np.sqrt(self.edge * from_wave / from_edge) * self._factor(xi, from_edge) / xi
        return float(density @ weight / np.pi)

    def slip_rate(self, xi: float) -> float:
        """Return V at a velocity, over Q_0 / (mu b)."""
        if xi >= self.edge:
            return 0.0
        from_xi, from_edge, weight = _stretch(self.edge - xi)
        at = xi + from_xi
        root = np.sqrt(self.edge * (1 - at) / from_edge)
        impedance = np.hypot(np.sqrt(1 - at * at), self.eta * at) / at  # |M + eta|
        density = root * self._factor(at, from_edge) / (impedance * at)
        return float(density @ weight / np.pi)


def _viscous_zone(material: Material, strength_ratio: float, viscosity: float) -> _AntiplaneFilm:
    if not (strength_ratio > 0 and viscosity >= 0):
        raise SceneError("strength_ratio must be positive, and viscosity not negative.")
    # The viscosity refers to relative slip rate, the impedance mu b to that of one side.
    eta = 2 * viscosity / material.shear_impedance
    last = _edge(material, strength_ratio)

    def excess(edge: float) -> float:
        return _AntiplaneFilm(edge, eta).traction_at_edge() - strength_ratio

    # Viscosity slows the edge; without any the root lies on the end of the bracket.
    above = last + 1e-9 * (1 - last)
    return _AntiplaneFilm(float(brentq(excess, 1e-6 * last, above, xtol=1e-15, rtol=1e-14)), eta)


def _stretch(width: float) -> tuple[Array, Array, Array]:
    """Return distances from both ends of an interval of a width, and weights."""
    y = np.arange(-_REACH, _REACH + _SPACING, _SPACING)
    # A logistic map: both distances keep their digits, and roots at the ends decay in y.
    left, right = 1 / (1 + np.exp(-y)), 1 / (1 + np.exp(y))
    return width * left, width * right, width * _SPACING * left * right


def _edge(material: Material, strength_ratio: float) -> float:
    """Return the edge of the zone without viscosity, over c_t."""
    return antiplane_edge_speed(material, strength_ratio) / material.shear_speed
