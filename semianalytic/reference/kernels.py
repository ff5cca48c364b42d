"""Tractions on y = 0 under prescribed slip on the contact, with the slot held or free (section 4).

Prescribed is the velocity V of the upper face, tangential (mode II) or normal (mode I, the lower
face moving oppositely).  Over the whole line, transformed as in (4.12), the traction is -M V.
In space and time

    s(x, t) = -M(0) V - int int sign(X) Im M(-T/|X|) / (pi T) dV/dx' dx' dt',
    X = x - x', T = t - t',

the kernel of (4.39), (4.40).  Taken over x > 0 only, V being 0 on x < 0, this is the
result (4.31), (4.37) of the article: an interface whose slot faces are *held*.  It needs tractions
on the slot.  Removing them (Wiener-Hopf, M = kappa M_+ M_-) adds a wave diffracted by the edge,

    s_d(x, t) = (kappa/pi^2) int_a^inf int_a^inf n(v) n(w) / (v + w)
                d/dt int_0^inf V(x', t - w x' - v x) dx' dw dv,     n(v) = Im M_+(-v + i0):

slip at x' runs to the edge with slowness w and from there to x with slowness v.  The article
loses it in (4.30): across the cut the root changes sign and the direction reverses, so the two
integrals add instead of cancelling.

Of the two terms of Im M one is positive, the other negative; the print gives both one sign.  In
antiplane shear (mode III) there is one, sqrt(u^2 - b^2), and V is along z.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.halfplane.polynomials import gauss
from semianalytic.halfplane.rayleigh import Array, Mode, RayleighFactors, rayleigh_factors
from semianalytic.halfplane.velocities import square_root_panels
from semianalytic.scene.errors import SceneError
from semianalytic.scene.scene import Material

Field = Callable[[Array, Array], Array]
Slot = Literal["free", "held"]

_ORDER = 12


@dataclass(frozen=True, eq=False)
class KernelTerms:
    """The two terms of a kernel, the one with (b^2 - 2 u^2)^2 and the one with 4 u^2.

    Their difference `four - square` is right; the article prints a sum.
    """

    square: Array
    four: Array

    @property
    def right(self) -> Array:
        """The kernel with opposite signs."""
        return self.four - self.square

    @property
    def as_printed(self) -> Array:
        """-(square + four), both terms of one sign as in (4.39), (4.40), (4.42), (4.43)."""
        return -(self.square + self.four)


def impedance_terms(poisson_ratio: float, u: ArrayLike, mode: Mode) -> KernelTerms:
    """Return the terms of Im M(-u + i0) over slowness u, b = mu = 1.

    In mode II they are -u K_b, -u K_a of (4.42).

    `square` = (1 - 2u^2)^2 / sqrt(u^2 - b^2), `four` = 4 u^2 sqrt(u^2 - a^2); in mode I a and b
    change places; in mode III `four` is sqrt(u^2 - b^2), `square` 0.  Each is 0 ahead of its front.
    """
    if mode == "III":
        ahead = np.sqrt(np.maximum(np.square(np.asarray(u, dtype=float)) - 1, 0.0))
        return KernelTerms(np.zeros_like(ahead), ahead)
    first, second = _fronts(poisson_ratio, mode)
    u = np.asarray(u, dtype=float)
    # Ahead of its front a term is 0; any slowness behind it keeps the roots real meanwhile.
    behind, ahead = np.where(u > first, u, first + 1), np.where(u > second, u, second + 1)
    square = np.square(1 - 2 * behind**2) / np.sqrt(behind**2 - first**2)
    four = 4 * ahead**2 * np.sqrt(ahead**2 - second**2)
    return KernelTerms(np.where(u > first, square, 0.0), np.where(u > second, four, 0.0))


def _fronts(poisson_ratio: float, mode: Mode) -> tuple[float, float]:
    """Return the slownesses of the fronts of the square term and of the four term."""
    a = rayleigh_factors(poisson_ratio).a
    return (1.0, a) if mode == "II" else (a, 1.0)


def _curvature_terms(poisson_ratio: float, u: Array, mode: Mode) -> KernelTerms:
    """Return the second derivatives of `impedance_terms` in u: the numerators of (4.35), (4.38)."""
    if mode == "III":
        behind = np.where(u > 1, u, 2.0)
        bend = np.where(u > 1, -((np.square(behind) - 1) ** -1.5), 0.0)
        return KernelTerms(np.zeros_like(bend), bend)
    first, second = _fronts(poisson_ratio, mode)
    e, g = first**2, second**2
    behind, ahead = np.where(u > first, u, first + 1), np.where(u > second, u, second + 1)
    z, y = behind**2, ahead**2
    polynomial = e - 8 * e**2 + (2 - 4 * e + 48 * e**2) * z - 60 * e * z**2 + 24 * z**3
    # Differentiated twice by hand: differences of the terms would cancel far behind the fronts.
    square = polynomial / (z - e) ** 2.5
    four = 4 * (2 * g**2 - 9 * g * y + 6 * y**2) / (y - g) ** 1.5
    return KernelTerms(np.where(u > first, square, 0.0), np.where(u > second, four, 0.0))


def point_kernel(
    material: Material, mode: Mode, x: ArrayLike, t: ArrayLike, *, as_printed: bool = False
) -> Array:
    """Return the traction under a point displacement delta(x) delta(t), off its fronts.

    The equations are (4.35), (4.38).

    A full-plane kernel, hypersingular at |x| = c_l t and c_t t; sigma_xy in mode II, sigma_yz in
    mode III, sigma_yy in mode I [stress / (length^2 time)].

    Parameters
    ----------
    x, t : positions other than 0 [length], times [time]; they broadcast.
    as_printed : the two terms added, as in the article; grows like t^2 / x^5 where it should decay.
    """
    distance = np.abs(np.asarray(x, dtype=float))
    speed = material.shear_speed
    u = np.asarray(t, dtype=float) * speed / distance
    terms = _curvature_terms(material.poisson_ratio, u, mode)
    shape = terms.square + terms.four if as_printed else terms.right
    return material.shear_impedance * speed**2 * shape / (np.pi * distance**3)


def regularised_kernel(
    material: Material, mode: Mode, x: ArrayLike, t: ArrayLike, *, as_printed: bool = False
) -> Array:
    """Return the kernel that multiplies the slip-rate gradient dV/dx in (4.39), (4.40), off t = 0.

    Its part concentrated at t = 0 is -M(0) H(x) delta(t), `local_impedance`.  Static limit for
    t >> b|x|: -(2 mu (b^2 - a^2)/(pi b^2)) / x, in mode III -(mu/pi) / x.

    Parameters
    ----------
    x, t : positions other than 0 [length], times above 0 [time]; they broadcast.
    as_printed : both terms negative, as in the article.

    Returns
    -------
    array [stress time / (length time)]
    """
    x, t = np.asarray(x, dtype=float), np.asarray(t, dtype=float)
    u = t * material.shear_speed / np.abs(x)
    terms = impedance_terms(material.poisson_ratio, u, mode)
    shape = terms.as_printed if as_printed else -terms.right
    return np.sign(x) * material.shear_impedance * shape / (np.pi * t)


def local_impedance(material: Material, mode: Mode) -> float:
    """Return M(0), the traction per face velocity of a plane wave, rho c_t or in mode I rho c_l."""
    speed = material.longitudinal_speed if mode == "I" else material.shear_speed
    return material.density * speed


@dataclass(frozen=True)
class SlipHistory:
    """The velocity of the upper face on x > 0, one-sided, at rest until t = 0.

    Attributes
    ----------
    slip_rate : V(x, t) for x >= 0, t >= 0 [length / time]; V(x, 0) = 0.
    gradient : dV/dx [1 / time].
    acceleration : dV/dt [length / time^2].
        All three broadcast over arrays and are smooth; V need not vanish at x = 0.
    """

    slip_rate: Field
    gradient: Field
    acceleration: Field


@dataclass(frozen=True, eq=False)
class InterfaceTraction:
    """Traction at positions and times [stress] and an estimate of its largest error."""

    value: Array
    error: float


def _panels(count: int) -> tuple[Array, Array]:
    node, weight = gauss(_ORDER)
    return ((np.arange(count)[:, None] + node) / count).ravel(), np.tile(weight / count, count)


def _held(
    factors: RayleighFactors, slip: SlipHistory, mode: Mode, x: float, t: float, panels: int
) -> float:
    """Return the part of the traction at x (any sign) from -Im M, slot held; c_t = mu b = 1."""
    # what arrives from the edge, V(0+, t - |x|/xi), varies in proportion to xi
    arrival, last = abs(x) / t, 1 / factors.a
    doubling = arrival * 2.0 ** np.arange(max(1, int(np.ceil(np.log2(last / arrival)))))
    ends = sorted({0.0, 1.0, last, *doubling[doubling < last].tolist()})
    xi, weight = square_root_panels(ends, _ORDER + 2 * panels)
    imag = factors.impedance_on_cut(factors.cut(1 / xi), mode).imag
    node, node_weight = _panels(panels)
    # rays from further out, x' = x + xi y > 0
    start = np.minimum(np.maximum(-x / xi, 0.0), t)[:, None]
    y = start + (t - start) * node
    outer = (t - start[:, 0]) * (slip.gradient(x + xi[:, None] * y, t - y) @ node_weight)
    rays = -outer
    if x > 0:  # rays from nearer to the edge, x' = x - xi y > 0
        # A ray of velocity xi comes from the contact only, x' > 0, and only since t = 0.
        stop = np.minimum(x / xi, t)[:, None]
        y = stop * node
        rays = rays + stop[:, 0] * (slip.gradient(x - xi[:, None] * y, t - y) @ node_weight)
    # the face velocity jumps at the edge of the contact, from 0 to V(0+)
    delay = abs(x) / xi
    edge = slip.slip_rate(np.zeros_like(xi), np.maximum(t - delay, 0.0)) / xi
    rays = rays + np.sign(x) * np.where(delay < t, edge, 0.0)
    return -float((weight * imag) @ rays) / np.pi


def _diffracted(
    factors: RayleighFactors, slip: SlipHistory, mode: Mode, x: float, t: float, panels: int
) -> float:
    """Return the diffracted wave that frees the slot, at x > 0; c_t = mu b = 1."""
    last = t / x
    # Nothing that the edge sends out is faster than the longitudinal wave.
    if last <= factors.a:
        return 0.0
    # 1 / (v + 1/zeta) varies in proportion to both, down to the edge
    growing = 4.0 ** np.arange(1, max(1, int(np.ceil(np.log2(last) / 2))) + 1)
    ends = [factors.a, *(end for end in (1.0, *growing) if end < last), last]
    order = _ORDER + panels
    v, v_weight = square_root_panels(ends, order)
    inner = [1 / end for end in growing[::-1] if end < last]
    zeta, zeta_weight = square_root_panels([0.0, *inner, 1.0, 1 / factors.a], order)

    def imaginary_factor(at: Array) -> Array:
        imag = factors.impedance_on_cut(factors.cut(at), mode).imag
        # n(v) = Im M / (kappa M_-) at -v, and M_-(-v) = M_+(v).
        return imag / (factors.kappa * factors.m_plus(at, mode))

    node, node_weight = _panels(panels)
    shares = zeta_weight * imaginary_factor(1 / zeta) / (1 + v[:, None] * zeta)
    per_ray = np.empty(len(v))
    for i, time in enumerate(np.maximum(t - v * x, 0.0)):
        y = time * node
        arrived = slip.acceleration(zeta[:, None] * y, time - y) @ node_weight
        per_ray[i] = time * float(shares[i] @ arrived)
    return float((v_weight * imaginary_factor(v)) @ per_ray) * factors.kappa / np.pi**2


def interface_traction(
    slip: SlipHistory,
    mode: Mode,
    material: Material,
    x: ArrayLike,
    t: ArrayLike,
    *,
    slot: Slot = "free",
    rtol: float = 1e-6,
) -> InterfaceTraction:
    """Return the change of traction on y = 0 under prescribed motion of the contact faces.

    Parameters
    ----------
    slip : SlipHistory
        Of the upper face: tangential velocity in modes II and III, normal velocity in mode I.
    mode : "II" for the shear traction sigma_xy, "III" for sigma_yz, "I" for the pressure (positive
        if the faces are driven apart).
    x, t : positions other than 0 [length] and times [time]; they broadcast.
    slot : "free" for slot faces without traction, so that the value at x < 0 is 0; "held" for
        slot faces kept from moving along, the article's (4.31), (4.37), which takes tractions
        at x < 0.
    rtol : wanted error relative to the largest traction.

    Raises
    ------
    SceneError
        If an option is not known, a position is 0, or the error estimate stays above rtol.
    """
    if slot not in ("free", "held") or mode not in ("I", "II", "III"):
        raise SceneError(
            "interface_traction: slot must be 'free' or 'held', mode 'I', 'II' or 'III'."
        )
    factors = _factors(material.poisson_ratio, mode)
    x, t = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(t, dtype=float))
    if np.any(x == 0):
        raise SceneError("the traction at the edge x = 0 itself is not defined; move off it.")
    speed = material.shear_speed
    # b = 1: lengths over c_t are times, so that gradients grow by c_t
    scaled = SlipHistory(
        lambda place, time: slip.slip_rate(place * speed, time),
        lambda place, time: slip.gradient(place * speed, time) * speed,
        lambda place, time: slip.acceleration(place * speed, time),
    )
    local = local_impedance(material, mode) / material.shear_impedance
    points = list(zip((x / speed).ravel(), t.ravel(), strict=True))
    # Shear resists the motion of the upper face; pressure is positive if it is driven into its
    # body.
    sign = (1 if mode == "I" else -1) * material.shear_impedance

    def evaluate(panels: int) -> Array:
        values = np.zeros(len(points))
        for i, (place, time) in enumerate(points):
            # A free slot carries nothing, whatever arrives there.
            if time <= 0 or (slot == "free" and place < 0):
                continue
            value = -_held(factors, scaled, mode, place, time, panels)
            if place > 0:
                value += local * float(scaled.slip_rate(np.array(place), np.array(time)))
                if slot == "free":
                    value -= _diffracted(factors, scaled, mode, place, time, panels)
            values[i] = value
        return sign * values

    panels, coarse = 1, evaluate(1)
    # The difference of two rules is the error of the coarser one, a bound for that of the finer.
    while panels < 16:
        panels *= 2
        fine = evaluate(panels)
        error = float(np.abs(fine - coarse).max(initial=0.0))
        if error <= rtol * float(np.abs(fine).max(initial=0.0)):
            return InterfaceTraction(fine.reshape(x.shape), error)
        coarse = fine
    raise SceneError(
        f"the traction is known to {error:.1e} only; give smoother slip or a larger rtol."
    )


def _factors(poisson_ratio: float, mode: Mode) -> RayleighFactors:
    """Return the factors whose kappa is that of the mode."""
    return rayleigh_factors(poisson_ratio, "III" if mode == "III" else "II")


def self_similar_transform(
    poisson_ratio: float,
    velocity: ArrayLike,
    rise: ArrayLike,
    k: ArrayLike,
    *,
    far: float = 0.0,
    mode: Mode = "II",
) -> Array:
    """Return the exact transform T_+(k) = int d tau / (1 + k xi) under slip V(x/t), slot free.

    T_+ = kappa M_+(k) [k sum m(u_0) V' d xi_0 / (u_0 + k) - M_-(0) V(inf)], b = mu = 1.

    Parameters
    ----------
    velocity, rise : (n,) arrays
        Similarity velocities xi_0 [c_t] and the rises V'(xi_0) d xi_0 of the slip rate there:
        nodes of a quadrature, or the places and heights of jumps.
    k : k >= 0, any shape [1 / c_t].
    far : V(inf), slip rate ahead of all waves.
    """
    factors = _factors(poisson_ratio, mode)
    k = np.asarray(k, dtype=float)
    u = 1 / np.asarray(velocity, dtype=float)
    # m(u_0) = M_-(-u_0), which is M_+(u_0) because M is even.
    density = factors.m_plus(u, mode) * np.asarray(rise, dtype=float)
    cauchy = (density / (u + k[..., None])).sum(axis=-1)
    at_rest = factors.m_plus_at_zero[mode]
    return factors.kappa * factors.m_plus(k, mode) * (k * cauchy - at_rest * far)
