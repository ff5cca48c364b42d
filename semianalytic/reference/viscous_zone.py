"""One slip zone with viscous friction under constant pressure, by quadrature: both kinds of shear.

On slip Im [(1 + eta/M) T] = 0, on stick Im (T / M_+) = 0.  With one zone v > u_s, slower than c_R,

    T = R M_+(k) (u_s + k)^(-1/2) exp [-(1/pi) int arctan(eta / m(w)) / (w + k) dw],   w > u_s,

where M(-w + i0) = i m(w), and T(0) = Q_0 gives R.  eta is one-sided, twice the viscosity, over
mu b; slownesses are in units of b, tractions of Q_0, slip rates of Q_0 / (mu b).  Integrals are
plain sums over even nodes in y, w - u_s = u_s exp(y) beyond the edge and logits before it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq

from semianalytic.halfplane.rayleigh import (
    Array,
    CutPoints,
    RayleighFactors,
    gauss,
    rayleigh_factors,
)
from semianalytic.scene.scene import Material

_STEP, _REACH = 0.1, 76.0
_NODES = _STEP * (np.arange(-round(_REACH / _STEP), round(_REACH / _STEP)) + 0.5)
_GAUSS = gauss(16)


@dataclass(frozen=True)
class ViscousZone:
    """The zone beyond slowness `edge`, whatever the strength it would take.

    Attributes
    ----------
    factors : RayleighFactors
    antiplane : bool
    viscosity : eta
    edge : u_s
    """

    factors: RayleighFactors
    antiplane: bool
    viscosity: float
    edge: float

    def _m_plus(self, k: Array) -> Array:
        return np.sqrt(1 + k) if self.antiplane else self.factors.m_plus(k)

    def _impedance(self, at: CutPoints) -> Array:
        """Im M on the cut."""
        if self.antiplane:
            return np.sqrt(at.from_b * (at.v + 1))
        return self.factors.impedance_on_cut(at).imag

    def _angle(self, beyond: Array) -> Array:
        """arctan(eta / m) at a distance beyond the edge."""
        at = CutPoints(np.add.outer(self.factors.cut(self.edge).parts, beyond))
        return np.arctan(self.viscosity / self._impedance(at))

    @cached_property
    def _at_nodes(self) -> tuple[Array, Array]:
        """Distances beyond the edge and arctan(eta / m) there."""
        beyond = self.edge * np.exp(_NODES)
        return beyond, self._angle(beyond)

    def _retarded(self, before: Array) -> Array:
        """T / (R M_+) at distances k + u_s > 0, (m,)."""
        beyond, angle = self._at_nodes
        log = _STEP * (angle * beyond / (beyond + before[:, None])).sum(axis=-1)
        log += angle[0] * np.log1p(beyond[0] * np.exp(-_STEP / 2) / before)
        return np.asarray(np.exp(-log / np.pi) / np.sqrt(before))

    @cached_property
    def constant(self) -> float:
        """R."""
        at_zero = self._retarded(np.array([self.edge]))[0]
        return float(1 / (self._m_plus(np.zeros(1))[0] * at_zero))

    @cached_property
    def strength(self) -> float:
        """Traction at the edge, which is the strength where slip begins."""
        share, other = 1 / (1 + np.exp(-_NODES)), 1 / (1 + np.exp(_NODES))
        kappa = 1.0 if self.antiplane else self.factors.kappa
        total = 0.0
        fronts = [self.factors.front_b, self.factors.cut([self.edge])]
        starts = fronts[:1] if self.antiplane else [self.factors.front_a, fronts[0]]
        for left, right in zip(starts, fronts[-len(starts) :], strict=True):
            width = right.minus(left)
            near_left, near_right = left.parts + width * share, right.parts - width * other
            at = CutPoints(np.where(_NODES < 0, near_left, near_right))
            to_edge = width * other if right is fronts[-1] else self.edge - at.v
            slope = self._impedance(at) * self._retarded(to_edge) / (kappa * self._m_plus(at.v))
            total += float((slope / at.v * width * share * other).sum())
        return self.constant * _STEP * total / np.pi

    def slip_rate(self, velocity: float) -> float:
        """One-sided V at a velocity >= 0 in units of c_t."""
        if velocity * self.edge >= 1:
            return 0.0
        last = _REACH if velocity == 0 else np.log(1 / (velocity * self.edge) - 1)
        ends = np.linspace(-_REACH, last, int(last + _REACH) + 2)
        x, weight = _GAUSS
        y = (ends[:-1, None] + np.diff(ends)[:, None] * x).ravel()
        weights = (np.diff(ends)[:, None] * weight).ravel()
        slopes = np.concatenate([self._slope(part) for part in np.array_split(y, 20)])
        return float(slopes @ weights)

    def _slope(self, y: Array) -> Array:
        """dV/dy; principal values over nodes that straddle each y."""
        beyond = self.edge * np.exp(y)
        offset = _NODES
        log = _STEP * (self._angle(beyond[:, None] * np.exp(offset)) / -np.expm1(-offset)).sum(
            axis=-1
        )
        angle, v = self._angle(beyond), self.edge + beyond
        modulus = np.exp(-log / np.pi) / np.sqrt(beyond)  # |T| = R m / (kappa M_+) times this
        kappa = 1.0 if self.antiplane else self.factors.kappa
        traction = self.constant * modulus * np.cos(angle) / (kappa * self._m_plus(v))
        return np.asarray(traction * beyond / (np.pi * v))


def viscous_zone(
    material: Material, strength_ratio: float, viscosity: float, *, antiplane: bool = False
) -> ViscousZone:
    """The only slip zone under a shear step on constant pressure with viscous friction.

    Holds while it is slower than c_R (in plane) and no second zone has nucleated.

    Parameters
    ----------
    material : Material
    strength_ratio : float
        chi_b, friction f P_b over the step Q_0 of shear.
    viscosity : float
        Traction per relative slip rate [stress time / length].
    antiplane : bool
        Shear along the edge.
    """
    factors = rayleigh_factors(material.poisson_ratio)
    eta = 2 * viscosity / material.shear_impedance
    least = (1.0 if antiplane else factors.c) * (1 + 1e-9)

    def excess(edge: float) -> float:
        return ViscousZone(factors, antiplane, eta, edge).strength - strength_ratio

    most = 4 * (1 + strength_ratio) ** 2 * (1 + eta) ** 2
    edge = brentq(excess, least, most, xtol=1e-15, rtol=1e-14)
    return ViscousZone(factors, antiplane, eta, float(edge))
