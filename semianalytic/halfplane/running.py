"""Integrals over slowness up to any point, of functions with roots at wave fronts and at their end.

Panels v = l + (r - l) sin^2 turn roots at either end into analytic functions; they grow from the
fronts a and b, and shrink towards the end where a pole lies just beyond it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.halfplane.polynomials import gauss
from semianalytic.halfplane.rayleigh import CutPoints, RayleighFactors
from semianalytic.scene.arrays import Array

Slope = Callable[[CutPoints, Array], Array]
"""Values (..., n) at points (n,) of the cut that are so far (n,) from the end of the integral."""


def panels_to(factors: RayleighFactors, stop: float, least: float) -> Array:
    """Return ends of panels from the first front to `stop`, to whose end panels may shrink.

    Panels grow from the fronts a and b as their distance from the front before, and those next to
    `stop` halve until the last is shorter than `least`, the distance of what lies beyond.
    """
    a, ends = factors.a, [factors.c]
    if factors.has_rayleigh_wave:  # -a and a are the singular points about the first panels
        ends = [*_growing(a, 2 * a, min(1.0, stop)), 1.0]
    ends = ends[:-1] if stop <= 1.0 else [*ends[:-1], *_growing(1.0, 1.0 - a, stop)]
    length = stop - ends[-1]
    while length > max(least, 1e-14 * stop):  # nearer points are the same in rounding
        length /= 2
        ends.append(stop - length)
    return np.array([*ends, stop])


def _growing(start: float, length: float, stop: float) -> list[float]:
    """Return ends of panels that double in length, none nearer to `stop` than its panel is long."""
    ends = [start]
    while stop - ends[-1] > 2 * length:
        ends.append(ends[-1] + length)
        length *= 2
    return ends


@dataclass(frozen=True, eq=False)
class RunningIntegral:
    """The integrals of some functions over slowness from the first panel on.

    `slope` takes points on the cut and their distances from the last of the `ends` (p + 1,).
    """

    factors: RayleighFactors
    slope: Slope
    ends: Array

    @cached_property
    def _before(self) -> Array:
        """Integrals up to each end, (..., p + 1)."""
        left, right = self.ends[:-1], self.ends[1:]
        whole = self._over(left, right, np.full(len(left), np.pi / 2))
        zero = np.zeros((*whole.shape[:-1], 1))
        return np.concatenate([zero, np.cumsum(whole, axis=-1)], axis=-1)

    def _over(self, left: Array, right: Array, angle: Array) -> Array:
        """Return the integrals over parts of panels (m,): from the left up to sin^2(angle)."""
        # With 24 a patch at nu = 0.45 is off by 3e-14, with 64 nothing changes beyond 1e-15.
        t, weight = gauss(32)
        # A function may be infinite at the one point of an empty part.
        theta = np.maximum(angle, 1e-60)[:, None] * t
        sine, cosine = np.sin(theta), np.cos(theta)
        width = (right - left)[:, None]
        from_left, to_right = width * sine**2, width * cosine**2
        v = left[:, None] + from_left
        fronts = np.array([0.0, self.factors.a, 1.0, self.factors.c])
        away = [np.where(right[:, None] == front, -to_right, v - front) for front in fronts]
        pairs = zip(fronts, away, strict=True)
        parts = [np.where(left[:, None] == front, from_left, far) for front, far in pairs]
        # Counted from the end itself, near which the function may be singular.
        to_stop = (self.ends[-1] - right)[:, None] + to_right
        values = self.slope(CutPoints(np.stack(parts).reshape(4, -1)), to_stop.ravel())
        values = values.reshape(*values.shape[:-1], *v.shape)
        rule = angle[:, None] * weight * 2 * width * sine * cosine
        return np.asarray((values * rule).sum(axis=-1))

    @property
    def total(self) -> Array:
        """Integrals over all panels."""
        return self._before[..., -1]

    def at(self, u: ArrayLike) -> Array:
        """Return the integrals up to slownesses u (m,), (..., m); 0 ahead of the first panel."""
        place: Array = np.clip(np.asarray(u, dtype=float), self.ends[0], self.ends[-1])
        panel = np.clip(np.searchsorted(self.ends, place, "right") - 1, 0, len(self.ends) - 2)
        left, right = self.ends[panel], self.ends[panel + 1]
        share = np.clip((place - left) / (right - left), 0.0, 1.0)
        # sin^2 maps the panel, so that a part of it is the same map up to a smaller angle.
        part = self._over(left, right, np.arcsin(np.sqrt(share)))
        return np.asarray(self._before[..., panel] + part)
