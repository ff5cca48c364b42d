"""One zone of slip from a contact edge under a load and a strength that grow as t^n.

Units: slowness b, impedance mu b, stress and time such that Q_0 = 1.  The n-th time derivatives of
all fields, over n!, depend on x/t alone:

    T(k) = M_+(k) (u_s + k)^(-n - 1/2) Pi_n(k),  W = -T / M,  T(0) = Q_0,

with Pi_n the jump J = s_0 + Q_0 of traction at the contact edge times the polynomial part of
(u_s + k)^(n + 1/2) / M_+(k).  Densities over slowness grow like |v - u_s|^(-n - 1/2) at the edge of
slip: integrals over them are finite parts.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property, lru_cache
from math import factorial, prod
from typing import Any

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike

from semianalytic.halfplane.rayleigh import CutPoints, RayleighFactors
from semianalytic.halfplane.running import RunningIntegral, panels_to
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import SceneError

_POINTS = 12
"""Points on a panel: with 8 slip rates are off by 1e-9; with 24 weights lose four digits (n =
2)."""
_SHORT = 4.0
"""Distance of a panel from a singular point over its length: half leaves 1e-10, twice 0."""
_FARTHEST = 1e16
"""Slowness over that of the edge beyond which the slip rate no longer changes."""


@lru_cache(maxsize=32)
def finite_part(power: int, lag: int) -> tuple[Array, Array]:
    """Return nodes y and weights of the finite part of int_0^1 y^(-power - 1/2) (1 - y)^lag f dy.

    They integrate the polynomial through f at Chebyshev nodes: its Taylor polynomial in y times the
    beta function continued to B(m + 1/2 - power, lag + 1), and the rest by Gauss-Jacobi quadrature.
    """
    from scipy.special import roots_jacobi

    nodes, rule = roots_jacobi(2 * _POINTS, lag, -0.5)
    # From x on [-1, 1] with the weight (1 - x)^lag (1 + x)^(-1/2) to y = (1 + x) / 2.
    nodes, rule = (1 + nodes) / 2, rule / 2 ** (lag + 0.5)
    moments = np.zeros(_POINTS)
    for j in range(_POINTS):
        series = np.eye(_POINTS)[j]
        rest, finite = chebyshev.chebval(2 * nodes - 1, series), 0.0
        # The Taylor terms at y = 0, where T_j(-1) = (-1)^j and d/dy = 2 d/dx, are integrated in
        # closed form. The remainder of T_j vanishes like y^power and may be divided by it.
        for m in range(power):
            slope = chebyshev.chebval(-1.0, chebyshev.chebder(series, m)) if m else (-1.0) ** j
            value = float(slope) * 2.0**m / factorial(m)
            rest = rest - value * nodes**m
            finite += value * factorial(lag) / np.prod(m + 0.5 - power + np.arange(lag + 1))
        moments[j] = finite + float(rule @ (rest / nodes**power))
    # Values at Chebyshev nodes give the coefficients of T_j by a discrete cosine transform.
    angle = np.pi * (np.arange(_POINTS) + 0.5) / _POINTS
    transform = 2 * np.cos(np.arange(_POINTS)[:, None] * angle) / _POINTS
    transform[0] /= 2
    both = (1 + np.cos(angle)) / 2, moments @ transform
    for table in both:
        # The cache hands out the same arrays to all callers.
        table.setflags(write=False)
    return both


def binomial(n: float, i: int) -> float:
    """Return the binomial coefficient of any n over a whole number i."""
    return prod(n - j for j in range(i)) / factorial(i)


def _row(n: int) -> Array:
    """Return the binomial coefficients of a whole number, (n + 1, 1)."""
    return np.array([[binomial(n, i)] for i in range(n + 1)])


@dataclass(frozen=True, eq=False)
class GrowingZone:
    """Slip at 0 < x < xi_s t under a load Q_0 t^n on the slot and a strength s_0 t^n."""

    factors: RayleighFactors  # impedance in the mode of shear
    power: int  # n >= 0; 0 is the step of a `Scene`
    ratio: float  # chi = s_0 / Q_0
    edge: float  # slowness u_s of the edge of slip

    def __getstate__(self) -> dict[str, Any]:
        return {part.name: getattr(self, part.name) for part in fields(self)}  # no closures

    @cached_property
    def polynomial(self) -> Array:
        """Coefficients of Pi_n over J, of the highest power first."""
        first, second = self.factors.log_m_plus_far
        inverse = [1.0, -first, first * first / 2 - second]
        n = self.power
        powers = [binomial(n + 0.5, i) * self.edge**i for i in range(n + 1)]
        return np.array(
            [sum(powers[i] * inverse[j - i] for i in range(j + 1)) for j in range(n + 1)]
        )

    @property
    def load(self) -> float:
        """T(0), which is Q_0 = 1 if the edge is right."""
        at_zero = self.factors.m_plus_at_zero[self.factors.mode]
        share = float(self.polynomial[-1]) / self.edge ** (self.power + 0.5)
        return (1 + self.ratio) * at_zero * share

    def _density(self, v: Array) -> Array:
        """Return dV/dv (v - u_s)^(n + 1/2) (-1)^n, smooth."""
        scale = (1 + self.ratio) / (np.pi * self.factors.kappa)
        return np.asarray(scale * np.polyval(self.polynomial, -v) / (v * self.factors.m_plus(v)))

    @property
    def _short(self) -> float:
        """Length behind the edge over which finite parts are taken; the density has a pole at 0."""
        return self.edge / _SHORT

    @cached_property
    def _slip_moments(self) -> tuple[Array, RunningIntegral]:
        """Finite parts of int v^j dV up to `_short` behind the edge, and integrals further on."""
        n, edge, short = self.power, self.edge, self._short
        j = np.arange(n + 2)[:, None]

        def slope(at: CutPoints, to_stop: Array) -> Array:
            lag = at.v - edge
            return np.asarray(self._sign * self._density(at.v) * at.v**j / lag ** (n + 0.5))

        y, weight = finite_part(n, 0)
        v = edge + short * y
        # With v = u_s + short y, dv (v - u_s)^(-n - 1/2) is short^(1/2 - n) y^(-n - 1/2) dy.
        near = self._sign * short ** (0.5 - n) * (v**j * self._density(v)) @ weight
        count = int(np.ceil(np.log2(_FARTHEST)))
        # Panels that double in length follow the density, whose scale is the distance from the
        # edge.
        ends = edge + short * np.exp2(np.arange(count, dtype=float))
        return near, RunningIntegral(self.factors, slope, ends)

    @property
    def _sign(self) -> float:
        return (-1.0) ** self.power

    def _lagged(self, u: Array, order: int) -> Array:
        """Return the finite part of int (1 - v/u)^order dV from the edge to slownesses u (m,)."""
        n, edge, result = self.power, self.edge, np.zeros(u.shape)
        behind = u > edge
        near, far = behind & (u - edge <= self._short), u - edge > self._short
        if near.any():
            y, weight = finite_part(n, order)
            length = (u[near] - edge)[:, None]
            # (1 - v/u)^order = (length / u)^order (1 - y)^order, whose second factor is in the
            # weights.
            values = self._density(edge + length * y) * (length / u[near, None]) ** order
            result[near] = self._sign * (values * length ** (0.5 - n)) @ weight
        if far.any():
            before, running = self._slip_moments
            moments = before[:, None] + running.at(u[far])
            powers = np.arange(order + 1)[:, None]
            # Far behind the edge the binomial sum over moments of v^j loses no digits, and one
            # running integral serves all slownesses.
            terms = _row(order) * (-1 / u[far]) ** powers * moments[: order + 1]
            result[far] = terms.sum(axis=0)
        return result

    def slip_rate(self, xi: ArrayLike) -> Array:
        """Return the slip rate of one side over t^n at velocities xi >= 0."""
        return self._at(xi, self.power)

    def slip(self, xi: ArrayLike) -> Array:
        """Return the slip of one side over t^(n + 1) at velocities xi >= 0."""
        # int_0^t (s - x v)^n ds = (t - x v)^(n + 1) / (n + 1).
        return self._at(xi, self.power + 1) / (self.power + 1)

    def _at(self, xi: ArrayLike, order: int) -> Array:
        xi = np.asarray(xi, dtype=float)
        slowest = self.edge * _FARTHEST
        u = 1 / np.maximum(xi.ravel(), 1 / slowest)
        return self._lagged(u, order).reshape(xi.shape)

    @property
    def edge_amplitude(self) -> float:
        """A of the slip rate A sqrt(1 - xi / xi_s) over t^n next to the edge.

        There int (1 - v/u)^n dV is the density times B(1/2 - n, n + 1) (u - u_s)^(1/2) / u_s^n.
        """
        n = self.power
        whole = factorial(n) / np.prod(np.arange(n + 1) + 0.5 - n)
        density = self._sign * float(self._density(np.array([self.edge]))[0])
        return float(density * whole * self.edge ** (0.5 - n))

    @property
    def _close(self) -> float:
        """Length ahead of the edge, beyond the last singular front b, of finite parts."""
        return (self.edge - 1.0) / (2 * _SHORT)

    @cached_property
    def _traction_moments(self) -> RunningIntegral:
        """Integrals of v^j dtau ahead of the edge, up to `_close` before it."""
        n, close = self.power, self._close
        j = np.arange(n + 1)[:, None]

        def slope(at: CutPoints, to_stop: Array) -> Array:
            return self._traction_density(at) * at.v**j / (to_stop + close) ** (n + 0.5)

        ends = panels_to(self.factors, self.edge - close, close)
        return RunningIntegral(self.factors, slope, ends)

    def _traction_density(self, at: CutPoints) -> Array:
        """Return dtau/dv (u_s - v)^(n + 1/2)."""
        imaginary = self.factors.impedance_on_cut(at).imag
        scale = (1 + self.ratio) / (np.pi * self.factors.kappa)
        share = np.polyval(self.polynomial, -at.v) / (at.v * self.factors.m_plus(at.v))
        return np.asarray(scale * share * imaginary)

    def _before_edge(self, length: Array, order: Array) -> Array:
        """Return finite parts of int v^j dtau over lengths (m,) up to the edge, (order, m)."""
        y, weight = finite_part(self.power, 0)
        v = self.edge - length[:, None] * y
        density = self._traction_density(self.factors.cut(v.ravel())).reshape(v.shape)
        values = density * v ** order[:, None, None] * length[:, None] ** (0.5 - self.power)
        return np.asarray(values @ weight)

    @cached_property
    def conditions(self) -> Array:
        """Finite parts of int v^j dtau ahead of the edge less s_0, 0, ...: 0 if the zone is right.

        They say that the traction over t^n, a polynomial in x/t behind the edge, is the strength.
        """
        order = np.arange(self.power + 1, dtype=float)
        close = self._before_edge(np.array([self._close]), order)[:, 0]
        found = self._traction_moments.total + close
        return np.asarray(found - np.where(order == 0, self.ratio, 0.0))

    def traction(self, xi: ArrayLike) -> Array:
        """Return the traction over t^n at velocities xi >= 1 / u_s, ahead of the edge."""
        xi = np.asarray(xi, dtype=float)
        with np.errstate(divide="ignore"):
            u = 1 / xi.ravel()
        n, result = self.power, np.empty(u.shape)
        near = self.edge - u < self._close
        if near.any():
            y, weight = finite_part(n, n)
            # Tractions are evaluated no nearer to the edge.
            length = np.maximum(self.edge - u[near], 1e-15 * self.edge)[:, None]
            at = self.factors.cut((self.edge - length * y).ravel())
            values = self._traction_density(at).reshape(length.shape[0], -1)
            # (1 - v/u)^n = (-length / u)^n (1 - y)^n, and length^n times length^(1/2 - n) is a
            # root. The traction is counted from the strength, which it reaches at the edge.
            short = (-1 / u[near]) ** n * np.sqrt(length[:, 0])
            result[near] = self.ratio - short * (values @ weight)
        powers = np.arange(n + 1)[:, None]
        moments = self._traction_moments.at(u[~near])
        with np.errstate(divide="ignore", invalid="ignore"):
            terms = _row(n) * (-1 / u[~near]) ** powers * moments
        result[~near] = np.where(u[~near] > 0, terms.sum(axis=0), 0.0)
        return result.reshape(xi.shape)


def growing_zone(factors: RayleighFactors, power: int, ratio: float) -> GrowingZone:
    """Find the edge of slip under a load and a strength that grow as t^n.

    Raises SceneError if no edge is slower than the Rayleigh wave (the shear wave in mode III).
    """
    from scipy.optimize import brentq  # here, for `import semianalytic` is to be quick

    def zone(x: float) -> GrowingZone:
        return GrowingZone(factors, power, ratio, factors.c * (1 + float(np.exp(x))))

    ends = float(np.log(1e-12)), float(np.log(1e12))
    # T(0) falls as the edge becomes slower: the load 1 lies between the two ends, or nowhere.
    if zone(ends[0]).load < 1:
        wave = "Rayleigh" if factors.has_rayleigh_wave else "shear"
        raise SceneError(
            f"growing load: the edge of slip would be faster than the {wave} wave, where this "
            "solver has no answer; raise pressure or friction, or lower the shear."
        )
    if zone(ends[1]).load > 1:
        raise SceneError(
            "growing load: slip does not leave the contact edge within rounding; lower pressure or "
            "friction, or raise the shear."
        )
    return zone(brentq(lambda x: zone(x).load - 1, *ends, xtol=1e-15, rtol=1e-15))
