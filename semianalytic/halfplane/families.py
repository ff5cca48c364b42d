"""Half-planes of many Poisson ratios at once; the ratio is one more array axis.

The factors of k ratios hold (k, 1) arrays where those of one hold numbers, and so broadcast against
the (p, k, n) arrays of k sets of zones.  Tables of many ratios are interpolated, between few that
are tabulated, in the square root q of the longitudinal slowness, of which all of them are analytic
functions.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike

from semianalytic.halfplane.lazily import cached_property
from semianalytic.halfplane.rayleigh import CutPoints, Mode, RayleighFactors, rayleigh_factors
from semianalytic.halfplane.stuck import StuckTraction, stuck_traction, traction_of
from semianalytic.scene.arrays import Array, Complex

_ENDS = (-0.999, -0.95, -0.8, -0.5, -0.2, 0.05, 0.2, 0.32, 0.4, 0.44, 0.47, 0.485)
"""Poisson ratios between which tables are interpolated; beyond them each table is computed."""
_NODES = 12
"""Tabulated ratios in each of these intervals, which give all others to rounding (tests)."""


@dataclass(frozen=True)
class _Tables:
    """Chebyshev series (m, k, 1): ln S_+, and stuck tractions ahead of and behind b by mode."""

    log_s_plus: Array
    stuck: dict[Mode, tuple[Array, Array]]

    def mapped(self, change: Callable[[Array], Array]) -> _Tables:
        """Return the tables with a function applied to every series."""
        stuck = {mode: (change(factor), change(two)) for mode, (factor, two) in self.stuck.items()}
        return _Tables(change(self.log_s_plus), stuck)


@dataclass(frozen=True, eq=False)
class RayleighFamily(RayleighFactors):
    """Rayleigh function and Wiener-Hopf factors of k Poisson ratios.

    Numbers of `RayleighFactors` are (k, 1) arrays here.  Use `rayleigh_family(ratios)`.
    """

    poisson_ratio: Any  # (k, 1)
    a: Any = field(kw_only=True, repr=False)
    c: Any = field(kw_only=True, repr=False)
    tables: _Tables = field(kw_only=True, repr=False)

    def chosen(self, which: np.ndarray) -> RayleighFamily:
        """Return the factors of some of the ratios."""
        tables = self.tables.mapped(lambda series: series[:, which])
        ratio = self.poisson_ratio[which]
        return RayleighFamily(ratio, a=self.a[which], c=self.c[which], tables=tables)

    def single(self, index: int) -> RayleighFactors:
        """Return the factors of one of the ratios."""
        return rayleigh_factors(float(self.poisson_ratio[index, 0]))

    def s_plus(self, k: ArrayLike) -> Array:
        k, q = np.asarray(k, dtype=float), np.sqrt(self.a)
        return np.exp(_summed((k - q) / (k + q), self.tables.log_s_plus))

    @cached_property
    def m_plus_at_zero(self) -> dict[Mode, Any]:
        s_plus = self.s_plus(0.0)
        return {"I": self.c * s_plus / np.sqrt(self.a), "II": self.c * s_plus, "III": 1.0}

    @cached_property
    def hidden_root(self) -> Any:
        e1, e0 = self._spurious_roots
        root = np.sqrt((-e1 + np.sqrt(np.asarray(e1 * e1 - 4 * e0, dtype=complex))) / 2)
        return root.real + 1j * np.abs(root.imag)

    def impedance_on_cut(self, at: CutPoints, mode: Mode | None = None) -> Complex:
        """Return the impedance M(-v + i0) on the cut, at points on one side of the shear front."""
        # All ratios of a family have their panels in the same order, and so on the same side of b.
        if at.from_b.flat[0] > 0:
            return np.asarray(1j * self.impedance_behind(at, mode))
        real, imag = self.impedance_ahead(at, mode)
        return np.asarray(real + 1j * imag)

    @cached_property
    def _fronts(self) -> Array:
        return np.stack([np.zeros_like(self.a), self.a, np.ones_like(self.a), self.c])


@dataclass(frozen=True)
class _StuckFamily(StuckTraction):
    """Stuck tractions of a family, at slownesses u that broadcast to (..., k, n)."""

    series: tuple[Array, Array] = field(kw_only=True)

    @cached_property
    def _scale(self) -> Any:
        factors = self.factors
        return 1 / (np.pi * factors.kappa * factors.m_plus_at_zero[self.mode])

    @property
    def _before_shear_front(self) -> Array:
        return self.series[0]

    @property
    def _behind_shear_front(self) -> Array:
        return self.series[1]

    def at(self, points: CutPoints) -> Array:
        behind, result = points.from_b > 0, np.zeros(points.v.shape)
        if behind.any():
            s = np.sqrt(np.maximum(points.from_b, 0.0))
            result = (s + 1) * _summed((s - 1) / (s + 1), self.series[1])
        if not behind.all():
            width, power = 1 - self.factors.a, 1.5 if self.mode == "II" else 0.5
            near = np.clip(points.from_a, 0.0, width)
            ahead = near**power * _summed(2 * near / width - 1, self.series[0])
            result = np.where(behind, result, ahead)
        return np.asarray(result)


@traction_of.register
def _(factors: RayleighFamily, mode: Mode, slowness: float = 0.0) -> StuckTraction:
    if slowness:
        raise ValueError("families hold tables of loads that come at once")
    return _StuckFamily(factors, mode, series=factors.tables.stuck[mode])


def _summed(x: Array, series: Array) -> Array:
    """Return the values at x (..., k, n) of Chebyshev series (m, k, 1)."""
    return np.asarray(chebyshev.chebval(x, series, tensor=False))


def rayleigh_family(ratios: Array) -> RayleighFamily:
    """Return the factors of Poisson ratios (k,), in any order."""
    different, place = np.unique(ratios, return_inverse=True)
    interval = np.searchsorted(_ENDS, different, "right") - 1
    parts = []
    for i in np.unique(interval):
        some = different[interval == i]
        inside = 0 <= i < len(_ENDS) - 1
        # Interpolation costs the tables of its nodes: it pays from as many ratios on.
        parts.append(_interpolated(int(i), some) if inside and len(some) > _NODES else _each(some))
    tables = _joined(parts)
    a = np.sqrt((1 - 2 * different) / (2 * (1 - different)))[:, None]
    family = RayleighFamily(different[:, None], a=a, c=_rayleigh_slowness(a), tables=tables)
    return family.chosen(place)


def _rayleigh_slowness(a: Array) -> Array:
    """Return c for longitudinal slownesses a, b = 1; see `Material.rayleigh_speed`."""
    low, high = np.full_like(a, 0.1), np.ones_like(a)
    while np.any((low < (middle := (low + high) / 2)) & (middle < high)):
        cubic = ((middle - 8) * middle + 24 - 16 * a * a) * middle - 16 * (1 - a * a)
        low, high = np.where(cubic < 0, middle, low), np.where(cubic < 0, high, middle)
    return 1 / np.sqrt(high)


def _each(ratios: Array) -> _Tables:
    """Compute the tables of each of the Poisson ratios (k,)."""
    return _joined([_single(rayleigh_factors(float(ratio))) for ratio in ratios])


def _single(factors: RayleighFactors) -> _Tables:
    """Compute the tables of one Poisson ratio."""
    series: dict[Mode, tuple[Array, Array]] = {}
    for stuck in (stuck_traction(factors.poisson_ratio, "I"), traction_of(factors, "II")):
        series[stuck.mode] = stuck._before_shear_front, stuck._behind_shear_front
    return _Tables(factors._log_s_plus, series).mapped(lambda table: table[:, None, None])


def _joined(parts: list[_Tables]) -> _Tables:
    """Join tables side by side; shorter series are padded with zeros."""

    def together(series: list[Array]) -> Array:
        longest = max(map(len, series))
        padded = [np.pad(table, ((0, longest - len(table)), (0, 0), (0, 0))) for table in series]
        return np.concatenate(padded, axis=1)

    stuck: dict[Mode, tuple[Array, Array]] = {}
    for mode in parts[0].stuck:
        ahead, behind = (together([part.stuck[mode][i] for part in parts]) for i in (0, 1))
        stuck[mode] = ahead, behind
    return _Tables(together([part.log_s_plus for part in parts]), stuck)


def _root(ratio: ArrayLike) -> Array:
    """Return q, the square root of the longitudinal slowness over the shear slowness."""
    ratio = np.asarray(ratio, dtype=float)
    return np.asarray(((1 - 2 * ratio) / (2 * (1 - ratio))) ** 0.25)


@lru_cache(maxsize=16)
def _tabulated(interval: int) -> tuple[Array, _Tables]:
    """Return the roots q (m,) in an interval of Poisson ratios that are tabulated, with tables."""
    start, stop = _root(_ENDS[interval]), _root(_ENDS[interval + 1])
    angle = np.pi * (np.arange(_NODES) + 0.5) / _NODES
    # Tables are smooth in q, which falls like (1 - 2 nu)^(1/4) towards nu = 1/2; in nu they are
    # not.
    q = (start + stop) / 2 + (start - stop) / 2 * np.cos(angle)
    a2 = q**4
    return q, _each((1 - 2 * a2) / (2 - 2 * a2))


def _interpolated(interval: int, ratios: Array) -> _Tables:
    """Interpolate the tables of Poisson ratios (k,) in one interval from those tabulated there."""
    nodes, tables = _tabulated(interval)
    away = _root(ratios)[:, None] - nodes
    weights = np.sin(np.pi * (np.arange(_NODES) + 0.5) / _NODES) * (-1.0) ** np.arange(_NODES)
    exact = away == 0
    # Barycentric weights at Chebyshev points; a ratio that is one of them takes its own table.
    share = weights / np.where(exact, 1.0, away)
    share = np.where(exact.any(axis=1, keepdims=True), exact, share)
    share /= share.sum(axis=1, keepdims=True)
    return tables.mapped(lambda series: np.einsum("kj,mjo->mko", share, series))
