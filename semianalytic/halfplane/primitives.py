"""Primitives in slowness of the stuck tractions p* and q*, which ramp loads need, (3.20)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Literal

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike

from semianalytic.halfplane.polynomials import chebyshev_series, gauss
from semianalytic.halfplane.rayleigh import Mode, RayleighFactors, rayleigh_factors
from semianalytic.halfplane.stuck import StuckTraction, series_behind_front, stuck_traction
from semianalytic.scene.arrays import Array


@dataclass(frozen=True)
class StuckPrimitive:
    """The primitive int_a^u p* dv (mode I) or int_a^u q* dv (mode II) over slowness, b = 1."""

    factors: RayleighFactors
    mode: Mode

    @cached_property
    def _traction(self) -> StuckTraction:
        return stuck_traction(self.factors.poisson_ratio, self.mode)

    @property
    def _power(self) -> float:
        return 2.5 if self.mode == "II" else 1.5

    @cached_property
    def _before_shear_front(self) -> Array:
        """Series on a < u < b of the primitive over (u - a)^(5/2) or (u - a)^(3/2)."""
        a = self.factors.a
        t, weight = gauss(48)

        def series(z: Array) -> Array:
            # substituting v = a + (u - a) t^2 leaves the traction over (v - a)^power smooth
            width = (1 - a) * (z + 1) / 2
            v = a + width[:, None] * t**2
            power = self._power - 1
            smooth = self._traction(v) / (width[:, None] * t**2) ** power
            return (2 * smooth * t ** (2 * power + 1)) @ weight

        return chebyshev_series(series, 128)

    @cached_property
    def _behind_shear_front(self) -> Array:
        """Series in (s - 1)/(s + 1), s = sqrt(u - b), of the primitive over (s + 1)^3."""

        def slope(s: Array) -> Array:
            return 2 * s * self._traction(1 + s**2)

        return series_behind_front(slope, float(self._near(np.array(1.0))), 3)

    def _near(self, u: Array) -> Array:
        a = self.factors.a
        series = chebyshev.chebval(2 * (u - a) / (1 - a) - 1, self._before_shear_front)
        return (u - a) ** self._power * series

    def __call__(self, u: ArrayLike) -> Array:
        """Return the primitive at slowness u [1/b], any shape; 0 ahead of the pressure front."""
        u = np.asarray(u, dtype=float)
        result, behind = np.empty(u.shape), u > 1
        s = np.sqrt(u[behind] - 1)
        series = chebyshev.chebval((s - 1) / (s + 1), self._behind_shear_front)
        result[behind] = (s + 1) ** 3 * series
        result[~behind] = self._near(np.clip(u[~behind], self.factors.a, 1))
        return result


@lru_cache(maxsize=64)
def stuck_primitive(poisson_ratio: float, mode: Literal["I", "II"]) -> StuckPrimitive:
    """Return the primitive of p* (mode I) or q* (mode II); its tables are cached."""
    return StuckPrimitive(rayleigh_factors(poisson_ratio), mode)
