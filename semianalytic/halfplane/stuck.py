"""Tractions on a fully stuck interface: the diffraction of unit step loads by the slot.

q*(u) and p*(u) of the article's (3.10)-(3.16) without the constant, as functions of the
slowness u = t/x.  Each is tabulated once per Poisson ratio as Chebyshev series of what is
left after its square-root behaviour at the wave fronts is divided out.

A load whose front moves over the slot with slowness p has v - p in place of v and M_+(-p) in place
of M_+(0).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache, singledispatch
from typing import Literal

import numpy as np
from numpy.polynomial import chebyshev, polynomial
from numpy.typing import ArrayLike

from semianalytic.halfplane.polynomials import chebyshev_series, gauss
from semianalytic.halfplane.rayleigh import CutPoints, Mode, RayleighFactors, rayleigh_factors
from semianalytic.scene.arrays import Array
from semianalytic.scene.scene import Material, Tractions

NEAR_FRONT = 0.04
ARCTAN_SERIES = np.array([(-1) ** k / (2 * k + 3) for k in range(12)])
"""Coefficients of (r - arctan r) / r^3 in powers of r^2, which keep all digits for small r."""


def series_behind_front(
    slope: Callable[[Array], Array], start: float, power: int, slowness: float = 0.0
) -> Array:
    """Return the Chebyshev series in (s - 1)/(s + 1) of [start + int_0^s slope] / (s + 1)^power."""
    t, weight = gauss(24)

    def series(z: Array) -> Array:
        s = (1 + z) / (1 - z)  # falls from node to node
        ends = np.concatenate(([0.0], s[::-1]))
        width = np.diff(ends)
        gain = width * (slope(ends[:-1, None] + width[:, None] * t) @ weight)
        return (start + np.cumsum(gain))[::-1] / (s + 1) ** power

    return _resolved(series, slowness)


def _resolved(series: Callable[[Array], Array], slowness: float) -> Array:
    """Return a Chebyshev series; for a moving front, of as high a degree as it needs."""
    # The pole of a moving front at p lies at an end of a table: 0.99 a takes 564, -1e4 takes 800,
    # and p = -1e5 loses two of twelve digits with half of the last.
    for degree in (128, 512, 2048) if slowness else (128,):
        found = chebyshev_series(series, degree)
        if len(found) < 0.8 * degree:
            break
    return found


@dataclass(frozen=True)
class StuckTraction:
    """The traction p* (mode I) or q* (mode II) per unit step, b = 1.

    Use `stuck_traction(poisson_ratio, mode, slowness)`, which keeps the tables.
    """

    factors: RayleighFactors
    mode: Mode
    # p, that of the front of the load over the slot, below the first front [b]
    slowness: float = 0.0

    @cached_property
    def m_plus_at_load(self) -> float:
        """M_+(-p), M_+(0) for a load that comes at once: K and T of a unit step are over it."""
        return float(self.factors.m_plus_at_load(self.slowness, self.mode))

    @cached_property
    def _scale(self) -> float:
        """The constant 1 / (pi kappa M_+(-p)) of (3.11), (3.15)."""
        return float(1 / (np.pi * self.factors.kappa * self.m_plus_at_load))

    def _from_load(self, v: Array) -> Array:
        """Return v - p, v itself for a load that comes at once."""
        return v - self.slowness if self.slowness else v

    def derivative(self, u: ArrayLike) -> Array:
        """Return d/du, Im M(-u + i0) / (pi kappa M_+(-p) (u - p) M_+(u)); 0 for u < a."""
        u = np.asarray(u, dtype=float)
        inside = np.where(u > self.factors.a, u, 2.0)
        return np.where(u > self.factors.a, self.slope(self.factors.cut(inside)), 0.0)

    def slope(self, at: CutPoints) -> Array:
        """Return d/du of the traction at points on the cut."""
        imag = self.factors.impedance_on_cut(at, self.mode).imag
        return self._scale * imag / (self._from_load(at.v) * self.factors.m_plus(at.v, self.mode))

    @cached_property
    def _before_shear_front(self) -> Array:
        """Series on a < u < b of q* / (u - a)^(3/2) or p* / (u - a)^(1/2)."""
        a = self.factors.a
        t, weight = gauss(48)

        def series(z: Array) -> Array:
            # With v = a + (u - a) t^2 the root at the front is part of dv; Im M is 4 v^2 alpha in
            # mode II and -(1 - 2 v^2)^2 / alpha in mode I.
            v = a + (1 - a) * (z[:, None] + 1) / 2 * t**2
            m = self._scale / (self._from_load(v) * self.factors.m_plus(v, self.mode))
            if self.mode == "II":
                return (8 * v**2 * np.sqrt(v + a) * m * t**2) @ weight
            return -(2 * np.square(1 - 2 * v**2) / np.sqrt(v + a) * m) @ weight

        return _resolved(series, self.slowness)

    @cached_property
    def _behind_shear_front(self) -> Array:
        """Series in (s - 1)/(s + 1), s = sqrt(u - b), of traction / (s + 1) for u > b."""

        def slope(s: Array) -> Array:
            v = 1 + s**2
            root = np.sqrt(v + 1)
            if self.mode == "I":
                root = np.sqrt(v * v - self.factors.a**2) / s
            rayleigh = self.factors.reduced_rayleigh(v) * (v * v - self.factors.c**2)
            across = root * self._from_load(v)
            return 2 * self._scale * rayleigh / (across * self.factors.m_plus(v, self.mode))

        # Both series meet at the shear front: the second is counted from the end of the first.
        start = float(self._near(np.array(1 - self.factors.a)))
        return series_behind_front(slope, start, 1, self.slowness)

    @cached_property
    def at_rayleigh_front(self) -> float:
        """The traction at u = c; p* is least there."""
        return float(self(self.factors.c))

    def _near(self, from_a: Array) -> Array:
        """The traction up to the shear front, at distances from the longitudinal one."""
        power = 1.5 if self.mode == "II" else 0.5
        place = 2 * from_a / (1 - self.factors.a) - 1
        return from_a**power * chebyshev.chebval(place, self._before_shear_front)

    def __call__(self, u: ArrayLike) -> Array:
        """Return the traction at slowness u = t/x [1/b], any shape; 0 ahead of all waves."""
        return self.at(self.factors.cut(u))

    def at(self, points: CutPoints) -> Array:
        """Return the traction at points on the cut, from their exact distances to the fronts."""
        result, behind = np.empty(points.v.shape), points.from_b > 0
        s = np.sqrt(points.from_b[behind])
        # The traction is smooth in sqrt(u - b) behind the front and grows like it far behind.
        result[behind] = (s + 1) * chebyshev.chebval((s - 1) / (s + 1), self._behind_shear_front)
        result[~behind] = self._near(np.clip(points.from_a[~behind], 0, 1 - self.factors.a))
        return result


class AntiplaneTraction(StuckTraction):
    """The traction q* in mode III, (2/pi) (r - arctan r) with r^2 = (u/b - 1) / (1 - p/b)."""

    def at(self, points: CutPoints) -> Array:
        """Return the traction at points on the cut; 0 ahead of the shear front."""
        z = np.maximum(points.from_b, 0.0) / (1 - self.slowness)
        root = np.sqrt(z)
        series = z * root * polynomial.polyval(np.minimum(z, NEAR_FRONT), ARCTAN_SERIES)
        # r - arctan r cancels to r^3 / 3 at the front; the series has all digits there.
        whole = np.where(z < NEAR_FRONT, series, root - np.arctan(root))
        return np.asarray(2 / np.pi * whole)


@lru_cache(maxsize=512)
def stuck_traction(poisson_ratio: float, mode: Mode, slowness: float = 0.0) -> StuckTraction:
    """Return p* or q* for a Poisson ratio, and a front of slowness p [b], with cached tables."""
    if mode == "III":
        return AntiplaneTraction(rayleigh_factors(poisson_ratio, mode), mode, slowness)
    return StuckTraction(rayleigh_factors(poisson_ratio), mode, slowness)


@singledispatch
def traction_of(factors: RayleighFactors, mode: Mode, slowness: float = 0.0) -> StuckTraction:
    """Return p* (mode I) or q* (mode II) of the half-plane of some factors."""
    return stuck_traction(factors.poisson_ratio, mode, slowness)


def stress_intensity(
    material: Material, load: Tractions, t: ArrayLike, shear_mode: Literal["II", "III"] = "II"
) -> tuple[Array, Array]:
    """Return the stress intensity factors (K_I, K_II) of a stuck interface at times t.

    The equations are (3.13), (3.16).

    Near the edge pressure ~ K_I / sqrt(2 pi x) and shear ~ K_II / sqrt(2 pi x)
    [stress sqrt(length)]; K_I > 0 is compression.  Times before 0 give 0.  In mode III the second
    is K_III = 2 Q_0 sqrt(2 c_t t / pi), that of mode II at nu = 0.
    """
    root = np.sqrt(np.maximum(np.asarray(t, dtype=float), 0.0) / np.pi)
    nu = material.poisson_ratio
    mode_one = 2 * load.pressure * np.sqrt((1 - 2 * nu) * material.longitudinal_speed) / (1 - nu)
    yielding = 1 - nu if shear_mode == "II" else 1.0
    sheared = 2 * load.shear * np.sqrt(2 * material.shear_speed / yielding)
    return mode_one * root, sheared * root


def front_share(material: Material, slowness: float, mode: Mode) -> float:
    """Return K under a front of slowness p [time / length] over K at once, M_+(0) / M_+(-p)."""
    if not slowness:
        return 1.0
    factors = rayleigh_factors(material.poisson_ratio, "III" if mode == "III" else "II")
    moving = factors.m_plus_at_load(slowness * material.shear_speed, mode)
    return float(factors.m_plus_at_zero[mode] / moving)
