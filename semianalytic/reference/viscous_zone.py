"""One slip zone under constant pressure where strength grows with slip rate.

Strength f p + viscosity |V| and a step of shear; on slip Im [(1 + eta/M) T] = 0, on stick
Im (T / M_+) = 0, eta = 2 viscosity.  With one zone v > u_s, slower than c_R,

    T = R M_+(k) (u_s + k)^(-1/2) exp [-(1/pi) int arctan(eta / m(w)) / (w + k) dw],   w > u_s,

where M(-w + i0) = i m(w), and T(0) = Q_0 gives R.  Inside b = mu = Q_0 = 1, slip rates are
one-sided, and integrals plain sums over even nodes in y, w - u_s = u_s exp(y) beyond the edge and
logits before it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq

from semianalytic.halfplane.polynomials import gauss
from semianalytic.halfplane.rayleigh import CutPoints, Mode, RayleighFactors, rayleigh_factors
from semianalytic.reference.antiplane import antiplane_edge_speed
from semianalytic.reference.closed_forms import (
    edge_speed_under_shear_step,
    over_shear_speed,
    relative_rate,
)
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import SceneError
from semianalytic.scene.scene import Material

_STEP, _REACH = 0.4, 76.0
_NODES = _STEP * (np.arange(-round(_REACH / _STEP), round(_REACH / _STEP)) + 0.5)


def viscous_edge_speed(
    material: Material, strength_ratio: float, viscosity: float, mode: Mode = "II"
) -> float:
    """Return the speed of the edge of the only slip zone [length / time].

    In mode II it holds as long as that is below c_R and no second zone has nucleated.

    Parameters
    ----------
    material : Material
    strength_ratio : float
        chi_b, friction f P_b over the step Q_0 of shear.
    viscosity : float
        Strength per relative slip rate [stress time / length], not negative.
    mode : "II" or "III"
        In-plane or antiplane shear.
    """
    return material.shear_speed / _viscous_zone(material, strength_ratio, viscosity, mode).edge


def viscous_slip_rate(
    material: Material,
    load_shear: float,
    strength_ratio: float,
    viscosity: float,
    velocity: ArrayLike,
    mode: Mode = "II",
) -> Array:
    """Return the relative slip rate of the only zone at x/t = velocity >= 0 [length / time]."""
    zone = _viscous_zone(material, strength_ratio, viscosity, mode)
    xi = over_shear_speed(material, velocity, edge=True)
    return relative_rate(material, load_shear, xi, zone.slip_rate)


@dataclass(frozen=True)
class _ViscousZone:
    """The zone beyond slowness `edge`, with the strength that such a zone needs.

    Attributes
    ----------
    factors : RayleighFactors
    eta : one-sided resistance [mu b]
    edge : u_s
    """

    factors: RayleighFactors
    eta: float
    edge: float

    def _impedance(self, at: CutPoints) -> Array:
        """Return Im M on the cut."""
        return np.asarray(self.factors.impedance_on_cut(at).imag)

    def _angle(self, beyond: Array) -> Array:
        """Return arctan(eta / m) at a distance beyond the edge."""
        at = CutPoints(np.add.outer(self.factors.cut(self.edge).parts, beyond))
        return np.arctan(self.eta / self._impedance(at))

    @cached_property
    def _at_nodes(self) -> tuple[Array, Array]:
        """Distances of nodes beyond the edge, and arctan(eta / m) there."""
        beyond = self.edge * np.exp(_NODES)
        return beyond, self._angle(beyond)

    def _retarded(self, before: Array) -> Array:
        """Return T / (R M_+) at distances k + u_s > 0, (m,)."""
        beyond, angle = self._at_nodes
        log = _STEP * (angle * beyond / (beyond + before[:, None])).sum(axis=-1)
        # Nearer to the edge than the first node the angle is constant, and its integral a
        # logarithm.
        log += angle[0] * np.log1p(beyond[0] * np.exp(-_STEP / 2) / before)
        return np.asarray(np.exp(-log / np.pi) / np.sqrt(before))

    @cached_property
    def constant(self) -> float:
        """The constant R, from T(0) = Q_0."""
        at_zero = self._retarded(np.array([self.edge]))[0]
        return float(1 / (self.factors.m_plus_at_zero[self.factors.mode] * at_zero))

    @cached_property
    def strength(self) -> float:
        """Traction at the edge, which is the strength at the onset of slip."""
        share, other = 1 / (1 + np.exp(-_NODES)), 1 / (1 + np.exp(_NODES))
        ends = [self.factors.front_a, self.factors.front_b, self.factors.cut([self.edge])]
        total = 0.0
        for left, right in pairwise(ends):
            width = right.minus(left)
            # Each half of a panel counts from its own end, so that distances from the front there
            # keep their digits.
            near_left, near_right = left.parts + width * share, right.parts - width * other
            at = CutPoints(np.where(_NODES < 0, near_left, near_right))
            to_edge = width * other if right is ends[-1] else self.edge - at.v
            slope = self._impedance(at) * self._retarded(to_edge) / self.factors.m_plus(at.v)
            total += float((slope / at.v * width * share * other).sum())
        return self.constant * _STEP * total / (np.pi * self.factors.kappa)

    def slip_rate(self, velocity: float) -> float:
        """Return the one-sided V at a velocity >= 0 in units of c_t."""
        if velocity * self.edge >= 1:
            return 0.0
        # y = ln(u / u_s - 1) at u = 1 / velocity; the contact edge is at infinity.
        last = _REACH if velocity == 0 else np.log(1 / (velocity * self.edge) - 1)
        ends = np.linspace(-_REACH, last, int(last + _REACH) + 2)
        x, weight = gauss(16)
        y = (ends[:-1, None] + np.diff(ends)[:, None] * x).ravel()
        weights = (np.diff(ends)[:, None] * weight).ravel()
        slopes = np.concatenate([self._slope(part) for part in np.array_split(y, 20)])
        return float(slopes @ weights)

    def _slope(self, y: Array) -> Array:
        """Return dV/dy; principal values use nodes that straddle each y."""
        beyond = self.edge * np.exp(y)
        angles = self._angle(beyond[:, None] * np.exp(_NODES))
        # 1 / (v - w) over the nodes around y, none of which is y itself: their sum is the principal
        # value.
        log = _STEP * (angles / -np.expm1(-_NODES)).sum(axis=-1)
        angle, v = self._angle(beyond), self.edge + beyond
        modulus = np.exp(-log / np.pi) / np.sqrt(beyond)  # |T| = R m / (kappa M_+) times this
        share = self.constant * modulus * np.cos(angle) / self.factors.m_plus(v)
        return np.asarray(share * beyond / (np.pi * self.factors.kappa * v))


def _viscous_zone(
    material: Material, strength_ratio: float, viscosity: float, mode: Mode = "II"
) -> _ViscousZone:
    if not (strength_ratio > 0 and viscosity >= 0):
        raise SceneError("strength_ratio must be positive, and viscosity not negative.")
    factors = rayleigh_factors(material.poisson_ratio, mode)
    eta = 2 * viscosity / material.shear_impedance

    def excess(edge: float) -> float:
        return _ViscousZone(factors, eta, edge).strength - strength_ratio

    of_mode = antiplane_edge_speed if mode == "III" else edge_speed_under_shear_step
    dry = material.shear_speed / of_mode(material, strength_ratio)
    # Viscosity makes the edge slower than without it, and no zone of this form passes c_R (c_t).
    least = max(dry * (1 - 1e-9), factors.c * (1 + 1e-9))
    most = 2 * dry * (1 + eta) ** 2
    if most > 1e45 or excess(least) > 0:  # above, squares leave floating point
        raise SceneError("strength_ratio must put the edge below c_R and above 1e-45 c_t.")
    edge = brentq(excess, least, most, xtol=1e-15, rtol=1e-14)
    return _ViscousZone(factors, eta, float(edge))
