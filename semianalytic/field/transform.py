"""The transform of a surface traction anywhere in the upper half-plane of slowness.

T(k) = int dtau(xi) / (1 + k xi) is analytic off the cut k < -a, on which `semianalytic.cut` knows
it.  At any k above the real axis it follows from its values on the axis by Cauchy's integral, over
that of a function known everywhere:

    T(k) = sum_j W_j rho_j T_j / (w_j - k)  /  sum_j W_j rho_j / (w_j - k),

in which the errors of the rule, those of a pole nearby above all, are the same above and below.
rho falls off fast enough at infinity and has its only pole in the lower half.

A load whose front moves over the slot with slowness p gives T a pole at k = -p and T(0) = 0:
T (k + p) / k takes its place, which has neither.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, TypeVar

import numpy as np

from semianalytic.cut.zones import ZoneFields
from semianalytic.field import tuning
from semianalytic.halfplane.rayleigh import CutPoints
from semianalytic.scene.arrays import Array, Complex


@dataclass(frozen=True)
class Centre:
    """A point of the real axis: k = -v or v of a point on the cut (sign -1 or 1), or 0 (None).

    `end` is the index of the end of panels at which it lies, if it does.
    """

    sign: int
    point: CutPoints | None = None
    end: int | None = None

    @property
    def place(self) -> float:
        """Value of k."""
        return 0.0 if self.point is None else self.sign * self.point.first[0]

    def fronts(self, fronts: Array) -> tuple[Array, Array]:
        """Return the distances from the fronts (3,): k + front, k - front."""
        if self.point is None:
            return fronts, -fronts
        gaps = np.array(self.point.first[1:])
        far = self.point.first[0] + fronts
        return (-gaps, -far) if self.sign < 0 else (far, gaps)

    def distance(self, other: Centre) -> float:
        """Return how far another centre lies to the right."""
        if self.point is None or other.point is None or self.sign != other.sign:
            return other.place - self.place
        return float(self.sign * other.point.minus(self.point)[0])


@dataclass(frozen=True)
class Transform:
    """The transform T in the closed upper half-plane, b = mu = 1, with its unbounded panel."""

    fields: ZoneFields

    @cached_property
    def _beyond(self) -> tuple[Array, Array]:
        """Values (2 n,) of k + a at nodes right of the cut, in two panels, and their slope in y."""
        # The pole of the fading factor then sees no panel under more than a right angle.
        rule, width = self.fields.panels.rule, self.fields.factors.a + 1.0
        near, far = width * rule.share, np.exp(rule.y)
        return np.append(near, width + far), np.append(width * rule.bell, far)

    @cached_property
    def _borders(self) -> list[Centre]:
        """Where slip that meets resistance borders on an opening: T has a factor k - border for
        each.
        """
        left = self.fields.panels.left
        return [Centre(-1, left[panel + 1], panel + 1) for panel, _ in self.fields.borders]

    @cached_property
    def _right(self) -> Array:
        """T times its factors (2 n,) right of the cut, from its imaginary part on the cut."""
        panels, beyond = self.fields.panels, self._beyond[0]
        knots = self._knots
        sent = panels.jacobian * self._cut.imag
        for knot in knots:
            sent = sent / -(panels.at.v + knot)
        # v + k = (v - a) + (k + a): both distances from the front of the cut are exact.
        # Pieces stay in the processor's cache.
        from_a, pieces = panels.at.from_a.ravel(), np.array_split(beyond, 1 + len(beyond) // 20)
        sums = [(1 / (from_a + piece[:, None])) @ sent.ravel() for piece in pieces]
        k, result = beyond - self.fields.factors.a, np.concatenate(sums)
        result *= -panels.rule.spacing / np.pi
        # Divided differences at the knots make the integral converge, which T itself, growing as
        # k^1/2, does not allow.
        result *= np.prod(k[:, None] - knots, axis=1)
        for knot, value in zip(knots, self._known(knots), strict=True):
            others = knots[knots != knot]
            result += value * np.prod((k[:, None] - others) / (knot - others), axis=1)
        return result

    @property
    def _slowness(self) -> float:
        """Slowness p of the front of the load."""
        return self.fields.load.slowness

    @cached_property
    def pole(self) -> Centre | None:
        """The pole of T at k = -p; None if the load comes at once, with T(0) in its place."""
        slowness = self._slowness
        if not slowness:
            return None
        return Centre(-1 if slowness > 0 else 1, self.fields.factors.cut([abs(slowness)]))

    @property
    def _knots(self) -> Array:
        """Points k at which T is known: 0 and more, or some away from the pole and from 0."""
        knots = np.arange(len(self._borders) + 1.0)
        if not self._slowness:
            return knots
        # One of two points 1/2 apart is always farther from the pole of a moving load.
        beside = np.abs(knots + 1.0 + self._slowness).min() < 0.25
        return knots + (1.5 if beside else 1.0)

    def _known(self, knots: Array) -> Array:
        """Return T times its factors at 0 and at some k > 0."""
        fields, load = self.fields, self.fields.load
        value = fields.stick_transform_off_cut(knots) * fields.factors.m_plus(knots)
        if self._slowness:
            # T of a load that moves has a pole at k = -p and is 0 at k = 0: both are divided out.
            value *= (knots + self._slowness) / knots
        else:
            value[0] = float(np.ravel(load.load_shear - load.far_slip_rate)[0])
        for border in self._borders:
            value = value * (knots - border.place)
        return np.asarray(value)

    @cached_property
    def _cut(self) -> Complex:
        """T times its factors on the panels."""
        result, panels = self.fields.transform, self.fields.panels
        if self._slowness:
            result = result * (panels.at.v - self._slowness) / panels.at.v
        for border in self._borders:
            result = result * -panels.from_ends[border.end]
        return result

    @cached_property
    def _values(self) -> Complex:
        """T times its factors at all nodes of the axis, (m,)."""
        return np.concatenate([self._cut.ravel(), self._right])

    @cached_property
    def _weights(self) -> Array:
        panels = self.fields.panels
        every = np.concatenate([panels.jacobian.ravel(), self._beyond[1]])
        return panels.rule.spacing * every

    def _offsets(self, centre: Centre) -> Array:
        """Return w - centre at all nodes w, (m,)."""
        panels, a = self.fields.panels, self.fields.factors.a
        if centre.point is None or centre.sign > 0:
            left, right = -panels.at.v - centre.place, self._beyond[0] - a - centre.place
        else:
            right = self._beyond[0] + centre.point.first[1]
            own = panels.from_ends[centre.end] if centre.end is not None else None
            own = panels.at.minus(centre.point) if own is None else own
            left = -own
        return np.concatenate([left.ravel(), right])

    def beside(self, centres: list[Centre], owners: np.ndarray, offset: Complex) -> Complex:
        """Return T at k = centre + offset, (c, m), Im >= 0, of centres of indices (c,)."""
        result = np.empty_like(offset)
        largest = np.maximum(np.abs(offset).max(axis=1), 1.0)
        # Transforms are formed at |k| not far above a scale.
        sizes = np.ceil(np.log(largest) / np.log(tuning.SCALES) + 1e-12)
        for size in np.unique(sizes):
            over = 1 / (1 + self._offsets(Centre(0)) / (1j * tuning.SCALES**size))
            # T(k) is Cauchy's integral of T f over that of f: the fading factor f, analytic above
            # the axis, drops out, and with it the errors that both integrals share.  T grows like
            # k^1/2 at most, so the integrand falls like k^-3/2.
            fading = self._weights * np.prod([over] * (2 + len(self._borders)), axis=0)
            carried = fading * self._values
            weights = np.stack([carried.real, carried.imag, fading.real, fading.imag], axis=1)
            for owner in np.unique(owners[sizes == size]):
                here = (sizes == size) & (owners == owner)
                result[here] = self._near(centres[owner], offset[here], weights)
        return result

    def _near(self, centre: Centre, offset: Complex, weights: Array) -> Complex:
        """Return T at k = centre + offset, (c, m), from weights (n, 4) of T and of 1 at nodes."""
        distances, size, result = self._offsets(centre), np.abs(offset), np.empty_like(offset)
        weight, away = np.abs(weights.view(complex)).sum(axis=1), np.abs(distances)
        # Cells share sums in rings three steps wide; half and twice the width are up to 15 % slower
        # What a ring is does not depend on the cells at hand, and so no digit does.
        step, low, high = np.pi / tuning.SECTORS, size.min(axis=1), size.max(axis=1)
        rings = np.floor(np.log(low) / (3 * step)), np.rint(np.log(high / low) / step)
        tolerance = tuning.NEGLIGIBLE * self.fields.panels.rule.tolerance
        for ring, span in np.unique(rings, axis=1).T:
            rows = (rings[0] == ring) & (rings[1] == span)
            nearest, farthest = np.exp([3 * step * ring, (3 * ring + 3 + span) * step]).tolist()
            # The most that a node adds to any point of the ring.
            sizes = weight / (away + nearest)
            kept = sizes > tolerance * sizes.max()
            seen = _Seen.of(distances[kept], weights[kept], nearest, farthest, tolerance)
            above, below = seen.sums(offset[rows].ravel())
            result[rows] = (above / below).reshape(-1, offset.shape[1])
        for border in self._borders:
            result /= offset + border.distance(centre)
        if self.pole is not None:
            result *= (centre.place + offset) / (offset + self.pole.distance(centre))
        return result


class _Seen(NamedTuple):
    """Nodes of the axis as points in a ring around 0 see them."""

    # nodes that are not far, (n,), and the real and imaginary parts of two weights in turn, (n, 4)
    place: Array
    weights: Array
    # coefficients (2, p) of the sums over nodes far nearer to 0, in (within / k)^j / k, and over
    # those far beyond, in (k / beyond)^j; p = 0 without such nodes
    inner: Complex
    outer: Complex
    within: float
    beyond: float

    @classmethod
    def of(
        cls, place: Array, weights: Array, nearest: float, farthest: float, tolerance: float
    ) -> _Seen:
        """Return nodes (n,) with weights (n, 4) as points between two distances from 0 see them."""
        within, beyond = nearest / tuning.FAR, farthest * tuning.FAR
        if len(place) < tuning.MANY_SEEN:
            none = np.empty((2, 0), dtype=complex)
            return cls(place, weights, none, none, within, beyond)
        terms = int(np.ceil(-np.log(tolerance) / np.log(tuning.FAR)))
        inside, outside = np.abs(place) < within, np.abs(place) > beyond
        # 1 / (w - k) in powers of w / k, and in powers of k / w.
        # Multipoles: nodes far nearer and nodes far beyond are summed once for all points of the
        # ring.
        inner = powers(place[inside] / within, terms) @ -weights[inside]
        beyond_weights = weights[outside] / place[outside, None]
        outer = powers(beyond / place[outside], terms) @ beyond_weights
        near = ~(inside | outside)
        return cls(place[near], weights[near], _paired(inner).T, _paired(outer).T, within, beyond)

    def sums(self, at: Complex) -> Complex:
        """Return the sums (2, m) of both weights over place - at, (m,)."""
        result, terms = _cauchy(self.place, self.weights, at), self.inner.shape[1]
        if terms:
            result += self.inner @ powers(self.within / at, terms) / at
            result += self.outer @ powers(at / self.beyond, terms)
        return result


def _paired(parts: Array) -> Complex:
    """Return complex numbers (..., 2) from real and imaginary parts in turn, (..., 4)."""
    return np.asarray(parts[..., ::2] + 1j * parts[..., 1::2])


Numbers = TypeVar("Numbers", Array, Complex)


def powers(z: Numbers, count: int) -> Numbers:
    """Return the powers (count, m) of z (m,) from 0 on, each from two of half its exponent."""
    result = np.empty((count, len(z)), dtype=z.dtype)
    result[0] = 1.0
    known, factor = 1, z
    while known < count:
        more = min(known, count - known)
        np.multiply(result[:more], factor, out=result[known : known + more])
        known += more
        factor = factor * factor
    return result


def _cauchy(place: Array, weights: Array, at: Complex) -> Complex:
    """Return sums (2, m) of two complex weights (n, 4), parts in turn, over place - at."""
    real, imag = np.empty((2, len(at), 4))
    step = max(1, 60_000 // max(len(place), 1))  # kernel values that stay in the processor's cache
    for start in range(0, len(at), step):
        part = slice(start, start + step)
        along = place - at.real[part, None]
        over = np.square(along)
        over += np.square(at.imag[part, None])
        np.reciprocal(over, out=over)
        imag[part] = (over @ weights) * at.imag[part, None]
        along *= over
        real[part] = along @ weights
    first = real[:, ::2] - imag[:, 1::2]
    return np.asarray((first + 1j * (real[:, 1::2] + imag[:, ::2])).T)
