"""Lamb's problem: the motion of the surface of a half-plane under tractions on it, (3.1)-(3.6).

The body is y > 0.  A line force (F_x, F_y) delta(x) delta(t) acts on its surface, F_y pressing
into the body, so that a surface shear traction sigma_xy is a force -sigma_xy per length and a
pressure is a force +p.  With the transforms of (4.12) the particle velocity of the surface is

    v_x = F_x / M_II - F_y k N / (mu R),    v_y = F_y / M_I + F_x k N / (mu R),
    N = b^2 - 2 k^2 - 2 alpha beta,         M_II = mu R / (b^2 beta),  M_I = mu R / (b^2 alpha).

The direct terms have a cut from a onwards with a pole on it (a principal value); N / R has a
cut between a and b only, and its pole at c is the Rayleigh pulse.  In time

    G_11 = U_1(t/|x|) / |x|,   G_22 = V_2(t/|x|) / |x|,
    G_12 = sign(x) [U_2(t/|x|) / |x| + K delta(t - c |x|)] = -G_21.

Against the print: (3.1)-(3.3) give the coupled terms without 1/|x|, U_2 not at all, V_2 without
sqrt(u^2 - b^2), and pair G_11 with p in (3.4); G_12 = -G_21 is reciprocity.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from docs.studies.article.kernels import square_root_panels
from semianalytic.halfplane.polynomials import gauss
from semianalytic.halfplane.rayleigh import Mode, RayleighFactors, rayleigh_factors
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import SceneError
from semianalytic.scene.scene import Material

Field = Callable[[Array, Array], Array]


def principal_panels(factors: RayleighFactors, order: int) -> tuple[Array, Array]:
    """Return nodes and weights on 0 < xi < c_l for densities with a simple pole at c_R.

    The panel around c_R is symmetric and of even order, which makes it a principal value; the
    panels beside it grow in proportion to their distance from the pole.

    Parameters
    ----------
    factors : RayleighFactors
    order : Gauss nodes per panel, even.
    """
    rayleigh, longitudinal = 1 / factors.c, 1 / factors.a
    reach = (1 - rayleigh) / 2
    widths = reach * 3.0 ** np.arange(40)
    left = [0.0, *(rayleigh - widths[widths < 0.8 * rayleigh])[::-1]]
    right = [rayleigh + reach, 1.0, longitudinal]
    nodes_left, weights_left = square_root_panels(left, order)
    nodes_right, weights_right = square_root_panels(right, order)
    t, weight = gauss(order)
    # Gauss nodes of even order are symmetric about the pole and miss it: its two sides cancel.
    middle = rayleigh + reach * (2 * t - 1)
    return (
        np.concatenate([nodes_left, middle, nodes_right]),
        np.concatenate([weights_left, 2 * reach * weight, weights_right]),
    )


def _direct(factors: RayleighFactors, v: Array, mode: Mode) -> Array:
    """Return -(1/pi) Im 1/M(-v + i0) for v > a, b = mu = 1."""
    # On a front the response is a pole or the end of a cut: the value just behind it stands for it.
    on_front = (v == 1) | (v == factors.c)
    at = factors.cut(np.where(on_front, np.nextafter(v, np.inf), v))
    impedance = factors.impedance_on_cut(at, mode)
    return impedance.imag / (np.pi * np.square(np.abs(impedance)))


def _coupled(factors: RayleighFactors, v: Array) -> Array:
    """Return (1/pi) Im of k N / R at k = -v + i0, b = mu = 1; 0 outside a < v < b."""
    inside = (v > factors.a) & (v < 1)
    # Outside of a < v < b the quotient k N / R is real; any slowness inside keeps the root real
    # meanwhile.
    w = np.where(inside, v, (1 + factors.a) / 2)
    polynomial = 1 - 2 * w * w
    root = np.sqrt((w - factors.a) * (w + factors.a) * (1 - w) * (1 + w))
    rayleigh = polynomial**4 + np.square(4 * w * w * root)
    return np.where(inside, 2 / np.pi * w * root * polynomial / rayleigh, 0.0)


def _pulse(factors: RayleighFactors) -> float:
    """Return K mu, the residue of -k N / R at k = -c."""
    c = factors.c
    numerator = 1 - 2 * c * c + 2 * np.sqrt((c * c - factors.a**2) * (c * c - 1))
    return float(numerator / (2 * factors.reduced_rayleigh(c)))


def _over_slowness(
    material: Material, u: ArrayLike, response: Callable[[RayleighFactors, Array], Array]
) -> Array:
    """Return a response in units of 1/(mu b) over slowness u [time / length], 0 ahead of c_l."""
    factors = rayleigh_factors(material.poisson_ratio)
    v = np.asarray(u, dtype=float) * material.shear_speed
    inside = v > factors.a
    scale = material.shear_speed / material.shear_modulus
    return scale * np.where(inside, response(factors, np.where(inside, v, 2.0)), 0.0)


def lamb_u1(material: Material, u: ArrayLike) -> Array:
    """Return U_1 = |x| G_11 over slowness u = t/|x|, with the constant b^2/(pi mu) of (3.1).

    Its unit is [length / (stress time)]; it is unbounded at u = c and 0 for u < a.
    """
    return _over_slowness(material, u, lambda factors, v: _direct(factors, v, "II"))


def lamb_v2(material: Material, u: ArrayLike) -> Array:
    """Return V_2 = |x| G_22 over slowness, like `lamb_u1`."""
    return _over_slowness(material, u, lambda factors, v: _direct(factors, v, "I"))


def lamb_u2(material: Material, u: ArrayLike) -> Array:
    """Return U_2, the regular part of x G_12 over slowness u = t/|x|; 0 outside a < u < b."""
    return _over_slowness(material, u, _coupled)


def lamb_v1(material: Material, u: ArrayLike) -> Array:
    """Return V_1 = -U_2, the regular part of x G_21 over slowness."""
    return -lamb_u2(material, u)


def rayleigh_pulse(material: Material) -> float:
    """Return K [1 / stress]: G_12 contains sign(x) K delta(t - c |x|), G_21 its negative."""
    return _pulse(rayleigh_factors(material.poisson_ratio)) / material.shear_modulus


@dataclass(frozen=True, eq=False)
class LambFunction:
    """One function G_ij at positions and times [1 / (stress time)].

    Attributes
    ----------
    regular : array
        The function itself, without the Rayleigh pulse.
    pulse : array
        Factor of delta(t - |x|/c_R) [1 / stress], of the shape of the positions.
    """

    regular: Array
    pulse: Array


def lamb_functions(material: Material, x: ArrayLike, t: ArrayLike) -> dict[str, LambFunction]:
    """Return all four G_ij(x, t) of (3.3): displacement i under a unit line impulse j.

    Parameters
    ----------
    x, t : positions, not zero [length], and times [time]; they broadcast.

    Returns
    -------
    dict
        Under "11", "12", "21" and "22"; 1 is x, 2 is y, into the body.

    Raises
    ------
    SceneError
        If a position is zero or not finite.
    """
    x = np.asarray(x, dtype=float)
    if not np.all(np.isfinite(x)) or np.any(x == 0):
        raise SceneError("Lamb's functions need finite positions other than the loaded point 0.")
    distance = np.abs(x)
    u = np.asarray(t, dtype=float) / distance
    pulse = np.sign(x) * rayleigh_pulse(material)
    across = LambFunction(lamb_u2(material, u) / x, pulse)
    none = np.zeros_like(pulse)
    return {
        "11": LambFunction(lamb_u1(material, u) / distance, none),
        "12": across,
        "21": LambFunction(-across.regular, -pulse),
        "22": LambFunction(lamb_v2(material, u) / distance, none),
    }


@dataclass(frozen=True, eq=False)
class SurfaceDisplacement:
    """Displacement of the surface of y > 0 [length] and an estimate of its largest error."""

    x: Array
    y: Array
    error: float


@dataclass(frozen=True)
class _Rays:
    """Velocities [c_t] with the densities of direct and coupled response, b = mu = 1."""

    velocity: Array
    direct_x: Array
    direct_y: Array
    coupled: Array


def _rays(factors: RayleighFactors, order: int) -> _Rays:
    xi, weight = principal_panels(factors, order)
    v = 1 / xi
    density = weight / xi
    coupled = _coupled(factors, v) * density
    # the pulse is one more ray, at c_R
    none = np.zeros(1)
    return _Rays(
        np.append(xi, 1 / factors.c),
        np.append(_direct(factors, v, "II") * density, none),
        np.append(_direct(factors, v, "I") * density, none),
        np.append(coupled, _pulse(factors) / factors.c),
    )


def surface_displacement(
    material: Material,
    pressure: Field,
    shear: Field,
    x: ArrayLike,
    t: ArrayLike,
    *,
    rtol: float = 1e-7,
) -> SurfaceDisplacement:
    """Return the displacement of the surface under a history of tractions on it, (3.4) and (3.5).

    With rays of velocity xi the double integral over x' and t' becomes

        u_i = int d xi gamma_ij(xi) int_0^t d tau
              [f_j(x - xi tau, t - tau) +- f_j(x + xi tau, t - tau)],

    gamma_ij = |x| G_ij / xi, + for i = j and - otherwise, the pulse being a ray at c_R.

    Parameters
    ----------
    material : Material
    pressure, shear : callables (x, t) -> array
        Smooth tractions p and sigma_xy [stress] on the surface of y > 0, for t >= 0; at rest
        before.  They broadcast.
    x, t : positions [length] and times [time]; they broadcast.
    rtol : float
        Wanted error relative to the largest displacement.

    Raises
    ------
    SceneError
        If the error estimate stays above rtol: the tractions are not smooth enough.
    """
    factors = rayleigh_factors(material.poisson_ratio)
    x, t = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(t, dtype=float))
    places, times = x.ravel(), np.maximum(t.ravel(), 0.0)
    # time integrals of tractions over rays are stresses times time; 1/(rho c_t) makes a length
    scale = 1 / material.shear_impedance

    def evaluate(order: int, panels: int) -> Array:
        rays = _rays(factors, order)
        node, node_weight = gauss(16)
        fraction = ((np.arange(panels)[:, None] + node) / panels).ravel()
        weight = np.tile(node_weight / panels, panels)
        result = np.empty((2, len(places)))
        for i, (place, time) in enumerate(zip(places, times, strict=True)):
            moment = time * (1 - fraction)[None, :]
            # A ray leaves x' = x -+ xi tau at t - tau and arrives now.
            reach = material.shear_speed * rays.velocity[:, None] * (time * fraction)[None, :]
            forward = [field(place - reach, moment) for field in (shear, pressure)]
            backward = [field(place + reach, moment) for field in (shear, pressure)]
            even = [(f + g) @ weight * time for f, g in zip(forward, backward, strict=True)]
            odd = [(f - g) @ weight * time for f, g in zip(forward, backward, strict=True)]
            # The outward normal of y > 0 is -y: the force on its surface is (-sigma_xy, p). Direct
            # responses are even in x - x', coupled ones odd.
            result[0, i] = -rays.direct_x @ even[0] + rays.coupled @ odd[1]
            result[1, i] = rays.direct_y @ even[1] + rays.coupled @ odd[0]
        return scale * result

    order, panels = 16, 2
    coarse = evaluate(order, panels)
    while panels < 256:
        # Both rules grow together: either may be the one that limits the digits.
        order, panels = order + 8, 2 * panels
        fine = evaluate(order, panels)
        error = float(np.abs(fine - coarse).max(initial=0.0))
        if error <= rtol * float(np.abs(fine).max(initial=0.0)):
            return SurfaceDisplacement(fine[0].reshape(x.shape), fine[1].reshape(x.shape), error)
        coarse = fine
    raise SceneError(
        f"the surface displacement is known to {error:.1e} only; give smoother tractions "
        "or a larger rtol."
    )
