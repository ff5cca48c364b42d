"""Tractions on y = 0 under prescribed slip on the contact, with the slot held or free (section 4).

Prescribed is the velocity V of the upper face, tangential (modes II, III) or normal (mode I).  Over
the whole line, transformed as in (4.12), the traction is -M V; in space and time

    s(x, t) = -M(0) V - int int sign(X) Im M(-T/|X|) / (pi T) dV/dx' dx' dt',
    X = x - x', T = t - t',

the kernel of (4.39), (4.40).  Over x > 0 alone this is (4.31), (4.37) of the article: an interface
whose slot faces are *held*.  Freeing them (Wiener-Hopf, M = kappa M_+ M_-) adds a wave diffracted
by the edge, from x' with slowness w and on to x with slowness v,

    s_d(x, t) = (kappa/pi^2) int_a^inf int_a^inf n(v) n(w) / (v + w)
                d/dt int_0^inf V(x', t - w x' - v x) dx' dw dv,     n(v) = Im M_+(-v + i0).

The article loses it in (4.30): across the cut the root changes sign and the direction reverses, so
that the two integrals add instead of cancelling.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.halfplane.polynomials import gauss
from semianalytic.halfplane.rayleigh import Mode, RayleighFactors, rayleigh_factors
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import SceneError
from semianalytic.scene.scene import Material

Field = Callable[[Array, Array], Array]
_ORDER = 12


@dataclass(frozen=True, eq=False)
class SlipHistory:
    """The velocity V(x, t) of the upper face on x > 0, 0 at t = 0, with smooth dV/dx and dV/dt."""

    slip_rate: Field
    gradient: Field
    acceleration: Field


def local_impedance(material: Material, mode: Mode) -> float:
    """Return M(0), the traction per face velocity of a plane wave, rho c_t or in mode I rho c_l."""
    speed = material.longitudinal_speed if mode == "I" else material.shear_speed
    return material.density * speed


def square_root_panels(ends: Iterable[float], order: int) -> tuple[Array, Array]:
    """Return nodes and weights (n,) on panels whose integrand may have square-root ends.

    The ends increase, and empty panels are left out.  With `order` Gauss nodes per panel in theta,
    xi = left + (right - left) sin^2 theta.
    """
    t, weight = gauss(order)
    share, jacobian = np.sin(t * np.pi / 2) ** 2, np.sin(t * np.pi) * np.pi / 2 * weight
    nodes, weights = [np.zeros(0)], [np.zeros(0)]
    for left, right in pairwise(ends):
        if right > left:
            nodes.append(left + (right - left) * share)
            weights.append((right - left) * jacobian)
    return np.concatenate(nodes), np.concatenate(weights)


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
    slot: Literal["free", "held"] = "free",
    rtol: float = 1e-6,
) -> Array:
    """Return the change of traction on y = 0 under prescribed motion of the contact faces [stress].

    It is sigma_xy in mode II, sigma_yz in mode III, in mode I the pressure, positive if the faces
    are driven apart, at positions other than 0 and times that broadcast, to `rtol` of the largest.
    A "free" slot carries nothing; one that is "held" the article's tractions (4.31), (4.37).
    """
    factors = rayleigh_factors(material.poisson_ratio, "III" if mode == "III" else "II")
    x, t = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(t, dtype=float))
    speed = material.shear_speed
    # b = 1: lengths over c_t are times, so that gradients grow by c_t
    scaled = SlipHistory(
        lambda place, time: slip.slip_rate(place * speed, time),
        lambda place, time: slip.gradient(place * speed, time) * speed,
        lambda place, time: slip.acceleration(place * speed, time),
    )
    local = local_impedance(material, mode) / material.shear_impedance
    points = list(zip((x / speed).ravel(), t.ravel(), strict=True))
    # shear resists the motion of the upper face; pressure is positive if that goes into the body
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

    coarse = evaluate(1)
    # The difference of two rules is the error of the coarser one, a bound for that of the finer.
    for panels in (2, 4, 8, 16):
        fine = evaluate(panels)
        error = float(np.abs(fine - coarse).max(initial=0.0))
        if error <= rtol * float(np.abs(fine).max(initial=0.0)):
            return fine.reshape(x.shape)
        coarse = fine
    raise SceneError(f"the traction is known to {error:.1e} only; give smoother slip.")
