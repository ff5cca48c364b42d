"""Rayleigh function, its Wiener-Hopf factors and the impedances of a half-plane.

All depend on the Poisson ratio alone; slowness is in units of b = 1/c_t, impedance of mu b.  On the
cut k = -v + i0 nothing is a principal value: M_+(-v) is M over M_-(-v) = M_+(v), off the cut.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Literal

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike, NDArray

from semianalytic.halfplane.lazily import cached_property
from semianalytic.halfplane.polynomials import chebyshev_series
from semianalytic.scene.arrays import Array, Complex
from semianalytic.scene.scene import Material

Mode = Literal["I", "II", "III"]
"""Modes of fracture: opening, sliding across the edge, and sliding along it (antiplane)."""


@dataclass(frozen=True)
class RayleighFactors:
    """Rayleigh function and Wiener-Hopf factors for one Poisson ratio, b = mu = 1.

    Use `rayleigh_factors(poisson_ratio)`, which keeps the tables of recent Poisson ratios.
    """

    poisson_ratio: float
    # Mode of the impedance M where none is named.  M_+(k) is (c + k) S_+(k) / (r + k)^1/2 with
    # r = a in mode I, b in mode II; in mode III, which has no Rayleigh wave, it is (b + k)^1/2.
    mode: Mode = "II"

    def chosen(self, which: np.ndarray) -> RayleighFactors:
        """Return the factors of some sets of zones: these, since there is only one ratio."""
        return self

    def single(self, index: int) -> RayleighFactors:
        """Return the factors of one of many sets of zones: these."""
        return self

    @cached_property
    def _unit_material(self) -> Material:
        return Material(1.0, 1.0, self.poisson_ratio)

    @cached_property
    def a(self) -> float:
        """Longitudinal slowness 1/c_l in units of b."""
        return 1.0 / self._unit_material.longitudinal_speed

    @cached_property
    def c(self) -> float:
        """Rayleigh slowness 1/c_R in units of b; in mode III the shear slowness, the last front."""
        return 1.0 / self._unit_material.rayleigh_speed if self.has_rayleigh_wave else 1.0

    @property
    def has_rayleigh_wave(self) -> bool:
        """Whether M vanishes at c and has the phase phi ahead of the shear front."""
        return self.mode != "III"

    @property
    def root(self) -> int:
        """The front r at which M_+ has its root, as a part of `CutPoints` (1 for a, 2 for b)."""
        return 1 if self.mode == "I" else 2

    @property
    def root_slowness(self) -> float:
        """Slowness r of the front at which M_+ has its root."""
        return self.a if self.root == 1 else 1.0

    @property
    def root_exponent(self) -> float:
        """Exponent of r + k in M_+."""
        return -0.5 if self.has_rayleigh_wave else 0.5

    @cached_property
    def kappa(self) -> float:
        """Constant kappa of M = kappa M_+ M_- [mu]: 2 (b^2 - a^2) / b^2; 1 in mode III."""
        return 2.0 * (1.0 - self.a**2) if self.has_rayleigh_wave else 1.0

    def phase(self, at: CutPoints) -> Array:
        """Return the phase phi(v) of the Rayleigh function on a < v < b, (3.12); 0 outside."""
        v = at.v
        product = -at.from_a * at.from_b * (v + self.a) * (v + 1)
        root = np.sqrt(np.maximum(product, 0.0))
        # Outside of a < v < b the product is negative, the root 0, and with it the phase.
        return np.arctan2(4 * v * v * root, np.square(1 - 2 * v * v))

    @cached_property
    def m_plus_at_zero(self) -> dict[Mode, float]:
        """Values of M_+(0) in all modes."""
        modes: tuple[Mode, ...] = ("I", "II", "III")
        return {mode: float(self.m_plus(0.0, mode)) for mode in modes}

    @cached_property
    def in_plane(self) -> RayleighFactors:
        """The factors of mode II, which hold the tables."""
        return self if self.mode == "II" else rayleigh_factors(self.poisson_ratio)

    def seen_in_plane(self, at: CutPoints) -> CutPoints:
        """Return points with their distance from the Rayleigh front, which mode III lacks."""
        if self.has_rayleigh_wave:
            return at
        return CutPoints(np.stack([*at.parts[:3], at.v - self.in_plane.c]))

    def of_in_plane(self, at: CutPoints) -> CutPoints:
        """Return points of an in-plane problem with the fronts of this mode."""
        return at if self.has_rayleigh_wave else CutPoints(at.parts[[0, 1, 2, 2]])

    @cached_property
    def _log_s_plus(self) -> Array:
        """Chebyshev series of ln S_+ over k >= 0 in (k - q)/(k + q), q^2 = a b."""
        if self.mode != "II":
            return self.in_plane._log_s_plus
        (at, density), q = self._phase_rule, np.sqrt(self.a)
        w = at.v

        def log_s_plus(z: Array) -> Array:
            k_over = q * (1 + z)  # k = k_over / (1 - z)
            # 1 / (w + k) times (1 - z) above and below, so that k = infinity is a point like any
            # other.
            return -(((1 - z)[:, None] / (w * (1 - z)[:, None] + k_over[:, None])) @ density)

        return chebyshev_series(log_s_plus, 256)

    @cached_property
    def _phase_rule(self) -> tuple[CutPoints, Array]:
        """Nodes and weights of (1/pi) int phi(w) ... dw over a < w < b (mode II)."""
        # Nodes crowd at both ends exponentially: for nu -> 0.5 the pole at -k comes near a.
        y = np.arange(-80.0, 80.08, 0.08)
        from_a, from_b = ((1 - self.a) / (1 + np.exp(sign * y)) for sign in (-1, 1))
        w = np.where(y < 0, self.a + from_a, 1 - from_b)
        at = CutPoints(np.stack([w, from_a, -from_b, w - self.c]))
        return at, self.phase(at) * from_a * from_b / (1 - self.a) * 0.08 / np.pi

    def log_s_plus_behind(self, at: CutPoints) -> Array:
        """Return ln S_+(-v) at v > b, where it is real, with all digits however small it is."""
        node, density = self.in_plane._phase_rule
        # v - w from two distances from b, near which both may lie.
        return np.asarray((1 / (at.from_b[..., None] - node.from_b)) @ density)

    def s_plus(self, k: ArrayLike) -> Array:
        """Return the factor S_+(k) of the Rayleigh function for k >= 0 (3.12), (4.20)."""
        k = np.asarray(k, dtype=float)
        q = np.sqrt(self.a)
        return np.exp(chebyshev.chebval((k - q) / (k + q), self._log_s_plus))

    def m_plus(self, k: ArrayLike, mode: Mode | None = None) -> Array:
        """Return the impedance factor M_+(k), k >= 0: (c + k) S_+(k) / sqrt(b + k) in mode II.

        It is the reciprocal of the article's F_+ (3.11) and G_+ (3.15).
        """
        k, mode = np.asarray(k, dtype=float), mode or self.mode
        if mode == "III":
            return np.sqrt(1.0 + k)
        c, root = self.in_plane.c, 1.0 if mode == "II" else self.a
        return (c + k) * self.s_plus(k) / np.sqrt(root + k)

    def m_plus_at_load(self, slowness: float, mode: Mode) -> Any:
        """Return M_+(-p) for a load whose front moves with slowness p < a; M_+(0) for p = 0."""
        if not slowness:
            return self.m_plus_at_zero[mode]
        return self.m_plus_off_cut(-slowness, mode)

    def m_plus_off_cut(self, k: float, mode: Mode | None = None) -> float:
        """Return M_+ at a number k > -a off the cut (k > -b in mode III).

        Ahead of the cut, -a < k < 0, it is M(k) / (kappa M_+(-k)), where M is real.
        """
        mode = mode or self.mode
        if k >= 0 or mode == "III":
            return float(self.m_plus(k, mode))
        # Differences of squares in factors: the front of a load may be close to a wave front.
        alpha, beta = np.sqrt((self.a - k) * (self.a + k)), np.sqrt((1 - k) * (1 + k))
        rayleigh = (1 - 2 * k * k) ** 2 + 4 * k * k * alpha * beta
        impedance = rayleigh / (beta if mode == "II" else alpha)
        return float(impedance / (self.in_plane.kappa * self.m_plus(-k, mode)))

    @cached_property
    def log_m_plus_far(self) -> tuple[float, float]:
        """Coefficients (l_1, l_2) of ln(M_+(k) / sqrt(k)) = l_1 / k + l_2 / k^2 + ..., large k."""
        r = self.root_slowness
        if not self.has_rayleigh_wave:
            return 0.5 * r, -0.25 * r * r
        c, (at, density) = self.in_plane.c, self.in_plane._phase_rule
        moments = float(density.sum()), float(density @ at.v)
        # ln(c + k) - ln(r + k) / 2, and ln S_+ = -(1/pi) int phi / (w + k) dw expanded in w / k.
        return c - r / 2 - moments[0], -c * c / 2 + r * r / 4 + moments[1]

    @cached_property
    def _spurious_roots(self) -> tuple[float, float]:
        """Coefficients (e1, e0) of z^2 + e1 z + e0, z = v^2: roots of R R* other than c^2."""
        lead, c2 = 16 * (1 - self.a**2), self.c**2
        return c2 - (24 - 16 * self.a**2) / lead, 1 / (lead * c2)

    @cached_property
    def hidden_root(self) -> complex:
        """The slowness, Im >= 0, at which the phase phi, continued off a < v < b, is singular.

        It is a zero of R on its other sheet, complex for nu > 0.263; 0 in mode III.
        """
        if not self.has_rayleigh_wave:
            return 0j
        e1, e0 = self._spurious_roots
        # z^2 + e1 z + e0 = 0 in z = v^2; of a conjugate pair the one above the axis stands for
        # both.
        root = complex(np.sqrt((-e1 + np.sqrt(complex(e1 * e1 - 4 * e0))) / 2))
        return complex(root.real, abs(root.imag))

    def reduced_rayleigh(self, v: ArrayLike) -> Array:
        """Return R(-v) / (c^2 - v^2) for v > b, a cubic in v^2 over R's conjugate, without
        cancellation.
        """
        z = np.square(np.asarray(v, dtype=float))
        return self._reduced_rayleigh(z, np.sqrt(z - self.a**2) * np.sqrt(np.maximum(z - 1, 0)))

    def _reduced_rayleigh(self, z: Array, root: Array) -> Array:
        """Return the reduced Rayleigh function from z = v^2 and sqrt((v^2 - a^2)(v^2 - b^2))."""
        e1, e0 = self.in_plane._spurious_roots
        conjugate = np.square(1 - 2 * z) + 4 * z * root
        return np.asarray(16 * (1 - self.a**2) * (z * (z + e1) + e0) / conjugate)

    def impedance_ahead(self, at: CutPoints, mode: Mode | None = None) -> tuple[Array, Array]:
        """Return real and imaginary part of the impedance M(-v + i0) where a < v < b (4.16)."""
        v, z, mode = at.v, np.square(at.v), mode or self.mode
        alpha, beta = np.sqrt(at.from_a * (v + self.a)), np.sqrt(-at.from_b * (v + 1))
        if mode == "III":
            return beta, np.zeros_like(beta)
        polynomial = np.square(1 - 2 * z)
        if mode == "II":
            return polynomial / beta, 4 * z * alpha
        return 4 * z * beta, -polynomial / alpha

    def impedance_behind(self, at: CutPoints, mode: Mode | None = None) -> Array:
        """Return the impedance M(-v + i0) / i where v > b; M is imaginary there (4.16)."""
        v, mode = at.v, mode or self.mode
        z, alpha2, beta2 = np.square(v), at.from_a * (v + self.a), at.from_b * (v + 1)
        if mode == "III":
            return np.asarray(np.sqrt(beta2))
        c = self.in_plane.c
        from_c = at.from_c if self.has_rayleigh_wave else v - c
        rayleigh = self._reduced_rayleigh(z, np.sqrt(alpha2 * beta2)) * from_c * (v + c)
        return np.asarray(rayleigh / np.sqrt(beta2 if mode == "II" else alpha2))

    @cached_property
    def impedance_slope_at_c(self) -> float:
        """Slope of M / i in v at the Rayleigh front, where it vanishes [mu / b]."""
        c = self.c
        alpha2, beta2 = c * c - self.a**2, c * c - 1
        rayleigh = self._reduced_rayleigh(np.asarray(c * c), np.sqrt(alpha2 * beta2))
        # M has the factors (v - c)(v + c), of which the first vanishes: it alone is differentiated.
        return 2 * c * rayleigh / np.sqrt(beta2 if self.mode == "II" else alpha2)

    def impedance_on_cut(self, at: CutPoints, mode: Mode | None = None) -> Complex:
        """Return the impedance M(-v + i0) of the half-plane on the cut v > a, v != b (4.16)."""
        ahead = at.from_b < 0
        result = np.empty(at.v.shape, dtype=complex)
        real, imag = self.impedance_ahead(at[ahead], mode)
        result[ahead] = real + 1j * imag
        result[~ahead] = 1j * self.impedance_behind(at[~ahead], mode)
        return result

    @cached_property
    def front_a(self) -> CutPoints:
        """The longitudinal front, (1,)."""
        return self.beside("a", [0.0])

    @cached_property
    def front_b(self) -> CutPoints:
        """The shear front, (1,)."""
        return self.beside("b", [0.0])

    @cached_property
    def front_c(self) -> CutPoints:
        """The Rayleigh front, (1,)."""
        return self.beside("c", [0.0])

    @cached_property
    def hiding(self) -> np.ndarray:
        """Where the hidden root is, (k,): 2 panels are cut near it, 1 complex ahead, else 0."""
        hidden = self.hidden_root
        return np.ravel((hidden.imag > 0) * (1 + (hidden.real > self.a)))

    @cached_property
    def cuts(self) -> list[CutPoints]:
        """Points at which fields change character: near the hidden root, the shear front.

        Of many ratios `hiding` is the same.
        """
        hidden = np.atleast_1d(self.hidden_root.real)
        return [*([self.cut(hidden)] if self.hiding[0] == 2 else []), self.front_b]

    @cached_property
    def _fronts(self) -> Array:
        return np.array([0.0, self.a, 1.0, self.c])

    def beside(self, front: Literal["a", "b", "c"], distance: ArrayLike) -> CutPoints:
        """Return points at signed distances from a front, however small."""
        d = np.asarray(distance, dtype=float)
        own = "_abc".index(front)
        shifts = self._fronts[own] - self._fronts
        return CutPoints(np.stack([shift + d for shift in shifts]))

    def cut(self, v: ArrayLike) -> CutPoints:
        """Return points on the cut from their slowness v > 0 alone."""
        v = np.asarray(v, dtype=float)
        return CutPoints(np.stack([v - front for front in self._fronts]))


@lru_cache(maxsize=256)
def rayleigh_factors(poisson_ratio: float, mode: Mode = "II") -> RayleighFactors:
    """Return the factors for one Poisson ratio; those of the 256 most recent ones are cached."""
    Material(1.0, 1.0, poisson_ratio)
    return RayleighFactors(poisson_ratio, mode)


@dataclass(frozen=True)
class CutPoints:
    """Slownesses on the cut: v, v - a, v - b and v - c [b], (4, ...), exact however small."""

    parts: Array

    @property
    def v(self) -> Array:
        """The slownesses v."""
        return self.parts[0]

    @property
    def from_a(self) -> Array:
        """Distances v - a."""
        return self.parts[1]

    @property
    def from_b(self) -> Array:
        """Distances v - b."""
        return self.parts[2]

    @property
    def from_c(self) -> Array:
        """Distances v - c."""
        return self.parts[3]

    def minus(self, other: CutPoints) -> Array:
        """Return the differences from other points, formed at the front nearest to these."""
        return from_front(self.parts, other.fronts) - from_front(other.parts, other.fronts)

    @cached_property
    def first(self) -> list[float]:
        """The parts of the first point."""
        flat: list[float] = self.parts.reshape(4, -1)[:, 0].tolist()
        return flat

    @cached_property
    def nearest(self) -> int:
        """The front nearest to the first point: 1 for a, 2 for b, 3 for c."""
        _, *distances = map(abs, self.first)
        return distances.index(min(distances)) + 1

    @cached_property
    def fronts(self) -> int | NDArray[np.intp]:
        """The front nearest to each point, as in `nearest`: one number if all have the same."""
        if self.parts.size == 4:
            return self.nearest
        each = np.abs(self.parts[1:]).argmin(axis=0) + 1
        return int(each.flat[0]) if (each == each.flat[0]).all() else each

    def first_below(self, other: CutPoints) -> bool:
        """Return whether the first of these points is below the first of others."""
        return self.first[other.nearest] < other.first[other.nearest]

    def __getitem__(self, index: Any) -> CutPoints:
        """Return some of the points."""
        return CutPoints(self.parts[:, index])


def from_front(parts: Array, fronts: int | NDArray[np.intp]) -> Array:
    """Return distances (...) from one front, or from that of each set, out of `parts` (4, ...)."""
    if isinstance(fronts, int):
        return np.asarray(parts[fronts])
    return np.where(fronts == 1, parts[1], np.where(fronts == 2, parts[2], parts[3]))
