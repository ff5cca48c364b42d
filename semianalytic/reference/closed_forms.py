"""Exact solutions in closed form for tests of the solvers, independent of them.

Each is a quadrature of elementary functions and S_+ (3.12), (4.20); none uses the panels, the
collocation grid or Newton's method.  Slip rates are relative, upper minus lower side, and positive
towards +x; velocities are x/t.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy.integrate import quad

from semianalytic.halfplane.rayleigh import RayleighFactors, rayleigh_factors
from semianalytic.halfplane.stuck_histories import intensity_history
from semianalytic.scene.arrays import Array
from semianalytic.scene.checks import checked_number
from semianalytic.scene.errors import SceneError
from semianalytic.scene.scene import Material, Scene


def over_shear_speed(material: Material, velocity: ArrayLike, *, edge: bool = False) -> Array:
    """Return velocities over c_t; raise SceneError unless positive, or 0 where that is allowed."""
    xi = np.asarray(velocity, dtype=float) / material.shear_speed
    if not np.all(xi >= 0 if edge else xi > 0):
        least = "not negative" if edge else "positive"
        raise SceneError(f"velocity: x/t must be {least}; the contact is x > 0.")
    return xi


def relative_rate(
    material: Material, load: float, xi: Array, one_sided: Callable[[float], float]
) -> Array:
    """Return a relative rate from that of one side, over load / (mu b) [length / time]."""
    rates = [one_sided(float(speed)) for speed in xi.ravel()]
    return np.asarray(2 * load / material.shear_impedance * np.array(rates).reshape(xi.shape))


def rate_from_contact_edge(
    factors: RayleighFactors, mode: Literal["I", "II"], edge: float
) -> Callable[[float], float]:
    """Return the rate of one side of a zone [0, edge c_t], over load / (mu b), over x/(c_t t).

    It is (sqrt(u_e) / (pi kappa M_+(0))) int sqrt(r + v) / (v sqrt(v - u_e) (c + v) S_+) dv from
    u_e to 1/xi, with r = a in mode I and b in mode II.
    """
    front = {"I": factors.a, "II": 1.0}[mode]
    start = 1 / edge
    scale = np.sqrt(start) / (np.pi * factors.kappa * factors.m_plus_at_zero[mode])

    def slope(s: float) -> float:  # v = u_e + s^2 / (1 - s)^2 covers u_e to infinity
        r = s / (1 - s)
        v = start + r * r
        # dv / sqrt(v - u_e) = 2 dr: the root at the edge of the zone is gone.
        density = np.sqrt(front + v) / (v * (factors.c + v) * factors.s_plus(v))
        return float(2 * density / (1 - s) ** 2)

    def rate(xi: float) -> float:
        if xi >= edge:
            return 0.0
        r = np.inf if xi == 0 else float(np.sqrt(1 / xi - start))
        stop = 1.0 if r == np.inf else r / (1 + r)
        return float(scale * quad(slope, 0, stop, epsabs=1e-14, epsrel=1e-13, limit=200)[0])

    return rate


def edge_speed_under_shear_step(material: Material, strength_ratio: float) -> float:
    """Return the speed of the only slip zone [0, speed t] under a shear step [length / time].

    It is c_t / ((1 - nu) (1 + chi_b)^2), as long as that is below c_R and no second zone has
    nucleated.

    Parameters
    ----------
    material : Material
    strength_ratio : float
        chi_b, friction f P_b over the step Q_0 of shear.
    """
    owner = "edge_speed_under_shear_step: strength_ratio"
    checked_number(owner, strength_ratio, "be 0 or more", lambda given: given >= 0)
    return material.shear_speed / ((1 - material.poisson_ratio) * (1 + strength_ratio) ** 2)


def slip_rate_under_shear_step(
    material: Material, load_shear: float, strength_ratio: float, velocity: ArrayLike
) -> Array:
    """Return the relative slip rate of the only zone under a shear step [length / time].

    It is 2 V, V = (Q_0 sqrt(u_s) / (pi kappa M_+(0))) int sqrt(b + v) / (v sqrt(v - u_s) (c + v)
    S_+) dv from u_s to 1/xi.

    Parameters
    ----------
    material : Material
    load_shear : float
        Q_0 [stress].
    strength_ratio : float
        chi_b, friction f P_b over Q_0.
    velocity : array of any shape [length / time]
        0 is the contact edge.

    Returns
    -------
    array of the shape of velocity; 0 ahead of the zone.

    Raises
    ------
    SceneError
        If a velocity is negative.
    """
    edge = edge_speed_under_shear_step(material, strength_ratio) / material.shear_speed
    rate = rate_from_contact_edge(rayleigh_factors(material.poisson_ratio), "II", edge)
    return relative_rate(
        material, load_shear, over_shear_speed(material, velocity, edge=True), rate
    )


def slip_rate_under_remote_shock(
    material: Material, pressure: float, shear: float, friction: float, velocity: ArrayLike
) -> Array:
    """Return the relative slip rate of an interface that slips everywhere at once [length / time].

    Under a sudden remote load with chi = f P_0 / Q_0 <= 1 (base = load), at x/t = velocity > 0,
    V = [(Q_0 - f P_0) + f P_0 Lambda(1/xi)] / (mu b), constant behind the shear front.

    Parameters
    ----------
    material : Material
    pressure, shear : float
        P_0, Q_0 [stress].
    friction : float
        Coefficient f.
    velocity : array of any shape [length / time]

    Returns
    -------
    array of the shape of velocity.

    Raises
    ------
    SceneError
        If a velocity is not positive.
    """
    factors = rayleigh_factors(material.poisson_ratio)
    a, c = factors.a, factors.c
    # M_+(0) of mode I.
    n_zero = c * float(factors.s_plus(0.0)) / np.sqrt(a)
    scale = 1 / (2 * np.pi * (1 - a * a) * n_zero)

    def slope(theta: float) -> float:  # w = a + (b - a) sin^2 theta
        w = a + (1 - a) * np.sin(theta) ** 2
        root = np.sqrt((1 + w) * (1 - w))
        return float(2 * np.sqrt(1 - a) * np.cos(theta) * root / (w * (c + w) * factors.s_plus(w)))

    def excess(xi: float) -> float:
        u = min(1 / xi, 1.0)
        share = 0.0
        if u > a:
            stop = float(np.arcsin(np.sqrt((u - a) / (1 - a))))
            share = scale * quad(slope, 0, stop, epsabs=1e-14, epsrel=1e-13)[0]
        return shear - friction * pressure + friction * pressure * share

    return relative_rate(material, 1.0, over_shear_speed(material, velocity), excess)


def slip_rate_without_friction(material: Material, load_shear: float, velocity: ArrayLike) -> Array:
    """Return the relative slip rate on a frictionless interface under a shear step [length / time].

    It is Lamb's surface velocity, 2 V, V = (Q_0 b^2 / (pi mu)) PV int_a^u U_1(w) / w dw, u = 1/xi,
    with U_1 of (3.1); logarithmically singular at c_R, negative next to it.

    Parameters
    ----------
    material : Material
    load_shear : float
        Q_0 [stress].
    velocity : array of any shape [length / time]

    Returns
    -------
    array of the shape of velocity.

    Raises
    ------
    SceneError
        If a velocity is not positive.
    """
    factors = rayleigh_factors(material.poisson_ratio)
    a, c = factors.a, factors.c

    # Between the two fronts R is complex, and Im 1/M has |R|^2 below it: no pole.
    def before(w: float) -> float:
        z, p = w * w, (w * w - a * a) * (1 - w * w)
        return 4 * z * (1 - z) * np.sqrt(z - a * a) / ((1 - 2 * z) ** 4 + 16 * z * z * p) / w

    def regular(w: float) -> float:  # U_1 / w times (w - c)
        return float(-np.sqrt(w * w - 1) / (factors.reduced_rayleigh(w) * -(w + c))) / w

    def behind(s: float) -> float:  # w = b + s^2, times dw/ds, less the pole
        w = 1 + s * s
        return 2 * s * (regular(w) - regular(c)) / (w - c)

    def rate(xi: float) -> float:
        u = 1 / xi
        if u <= a:
            return 0.0
        value = quad(
            lambda t: before(a + (1 - a) * np.sin(t) ** 2) * (1 - a) * np.sin(2 * t),
            0,
            np.arcsin(np.sqrt((min(u, 1.0) - a) / (1 - a))),
            epsabs=1e-14,
            epsrel=1e-12,
        )[0]
        if u > 1:
            # Without its pole the integrand is smooth, but the quotient is 0 / 0 at c: a break for
            # `quad`.
            stop, pole = float(np.sqrt(u - 1)), float(np.sqrt(c - 1))
            points = [pole] if stop > pole else None
            value += quad(behind, 0, stop, epsabs=1e-14, epsrel=1e-12, limit=400, points=points)[0]
            # The principal value of the pole that `behind` leaves out.
            value += regular(c) * np.log(abs((u - c) / (1 - c)))
        return float(value / np.pi)

    return relative_rate(material, load_shear, over_shear_speed(material, velocity), rate)


@dataclass(frozen=True)
class StaticZone:
    """The static slip zone near the contact edge under a constant strength.

    The stress intensity of the zone's own traction at its far end cancels that of the load,
    2 strength sqrt(2 length / pi) = K_II or K_III (Dugdale; Barenblatt).

    Attributes
    ----------
    strength : float
        Friction bound less shear traction of the slot [stress].
    length : float
        Length of the zone [length].
    modulus : float
        mu / (1 - nu), in antiplane shear mu [stress].
    """

    strength: float
    length: float
    modulus: float

    def slip(self, x: Array) -> Array:
        """Return the relative slip at x > 0, (n,) [length]."""
        # The logarithm is infinite at x = 0, where its factor vanishes faster.
        share = np.clip(x / self.length, 1e-300, 1.0)
        root = np.sqrt(1 - share)
        shape = root - share / 2 * np.log((1 + root) / (1 - root + 1e-300))
        return 4 / (np.pi * self.modulus) * self.strength * self.length * shape


def static_zone(scene: Scene, t: float) -> StaticZone:
    """Return the static zone of a scene with slow shear under constant pressure, at a time."""
    held, load = scene.superposition
    gone = load.shear * float(scene.shear_history.value(t))
    # In excess of the shear that the slot faces still carry: the base less what the load took off.
    strength = scene.coefficient * held.pressure - held.shear + gone
    _, intensity = intensity_history(scene.shear_history, load, scene.material, t, scene.shear_mode)
    # K = 2 strength sqrt(2 length / pi), solved for the length.
    length = np.pi / 8 * (float(intensity) / strength) ** 2
    return StaticZone(strength, float(length), scene.static_modulus)
