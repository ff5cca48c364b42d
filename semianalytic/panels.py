"""Panels of slowness between zone edges and wave fronts, with double-exponentially fine ends.

On each panel v = left + width / (1 + rho exp(-y)) (or left + rho exp(y) on the last, unbounded
one) and functions live on a uniform grid in y.  Whatever power or logarithm a field has at a
panel end, it is analytic in a strip |Im y| < pi, so the trapezoidal rule and sinc
interpolation converge geometrically in the spacing, uniformly down to the ends.

Shapes: a zone edge is a CutPoints of shape (1,), or (k, 1) for k neighbouring sets of zones at
once; node arrays are then (p, n) or (p, k, n), panel first, node last.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import groupby, pairwise

import numpy as np

from semianalytic.rayleigh import Array, CutPoints, RayleighFactors

_CACHED = 50_000  # kernel values formed at once, so that they stay in the processor's cache
_MANY = 100  # nodes from which it pays to leave some out
_NEGLIGIBLE = 1e-6  # of what the reach of a rule leaves out


@dataclass(frozen=True)
class Zone:
    """A slip zone in slowness: left < v < right, sense +1 or -1.

    left None: slip from the longitudinal front on, or ahead of all waves; right None: slip up to
    the contact edge.
    """

    left: CutPoints | None
    right: CutPoints | None
    sense: int


@dataclass(frozen=True)
class Rule:
    """Uniform grid in y: spacing h, from -reach to reach."""

    spacing: float
    reach: float

    @cached_property
    def y(self) -> Array:
        count = int(np.ceil(self.reach / self.spacing))
        return np.arange(-count, count + 1.0) * self.spacing

    @property
    def tolerance(self) -> float:
        """The tolerance for which `rule_for` has this spacing."""
        return float(np.exp(2 - np.pi**2 / self.spacing))

    @cached_property
    def decay(self) -> Array:
        """exp(-y)."""
        return np.exp(-self.y)

    def running(self, density: Array) -> Array:
        """Integrals from -inf to each node of the sinc interpolant of `density` (..., n)."""
        return self.spacing * (density @ _running(len(self.y)))

    def halved(self, density: Array) -> Array:
        """Its integrals from -inf to the middle node, (...)."""
        n = len(self.y)
        return self.spacing * (density @ _running(n)[:, n // 2])

    @property
    def alternate(self) -> Array:
        """1 / sinh((y_i - y_j) / 2) where i - j is odd, 0 elsewhere."""
        return _alternate(len(self.y), self.spacing)

    def interpolate_running(self, y: Array, density: Array) -> Array:
        """Integral from -inf to y of the sinc interpolant of `density` ((n,) or (k, n))."""
        return self.spacing * _sinc_step((y[:, None] - self.y) / self.spacing) @ density.T


def _sinc_step(x: Array) -> Array:
    """Integral of sinc from -inf to x."""
    from scipy.special import sici  # here, for `import semianalytic` is to be quick

    return np.asarray(0.5 + sici(np.pi * x)[0] / np.pi)


@lru_cache(maxsize=32)
def _running(n: int) -> Array:
    step = _sinc_step(np.arange(1.0 - n, n))
    order = np.arange(n)
    return step[order - order[:, None] + n - 1]


@lru_cache(maxsize=32)
def _alternate(n: int, spacing: float) -> Array:
    steps = np.arange(1 - n, n)
    inverse = np.zeros(len(steps))
    inverse[steps % 2 != 0] = 1 / np.sinh(steps[steps % 2 != 0] * (spacing / 2))
    order = np.arange(n)
    return inverse[order[:, None] - order + n - 1]


@lru_cache(maxsize=64)
def rule_for(tolerance: float) -> Rule:
    """Grid on which end exponents of at least 1/2 are integrated to about `tolerance`."""
    digits = np.log(1 / tolerance)
    return Rule(float(np.pi**2 / (digits + 2)), float(2 * digits + 2))


@dataclass(frozen=True)
class Span:
    """Where one panel lies: its ends (right None: unbounded), its sense of slip and its zone."""

    left: CutPoints
    right: CutPoints | None
    sense: int
    zone: int

    def has_pole(self, factors: RayleighFactors) -> bool:
        """Whether it slips across c, where dV/dv has a pole."""
        return bool(self.sense) and lies_between(self.left, factors.front_c, self.right)

    def strip(self, factors: RayleighFactors) -> float:
        """Half-width over pi of the strip of y free of the hidden root; at most 1."""
        hidden = factors.hidden_root
        if not hidden.imag or self.right is None or self.right.from_b.flat[0] > 0:
            return 1.0
        ratio = (hidden - self.left.v) / (self.right.v - hidden)
        return float(np.abs(np.angle(ratio)).min()) / np.pi

    def imbalance(self, factors: RayleighFactors) -> float:
        """How far, in y, a pole lies off the middle of the span."""
        if not self.has_pole(factors):
            return 0.0
        before = -self.left.from_c
        after = self.left.v if self.right is None else self.right.from_c
        return float(np.abs(np.log(after / before)).max())


def spans_of(factors: RayleighFactors, zones: tuple[Zone, ...]) -> list[Span]:
    """Panels for a set of zones: cut at edges, at the shear front and beside the hidden root."""
    whole: list[Span] = []
    position: CutPoints | None = factors.front_a
    for index, zone in enumerate(zones):
        assert position is not None
        if zone.left is not None:
            whole.append(Span(position, zone.left, 0, index))
        whole.append(Span(zone.left or position, zone.right, zone.sense, index))
        position = zone.right
    if position is not None:
        whole.append(Span(position, None, 0, len(zones)))
    spans = []
    for span in whole:
        inside = [cut for cut in factors.cuts if lies_between(span.left, cut, span.right)]
        for left, right in pairwise([span.left, *inside, span.right]):
            assert left is not None
            spans.append(Span(left, right, span.sense, span.zone))
    return spans


def lies_between(left: CutPoints | None, point: CutPoints, right: CutPoints | None) -> bool:
    """Whether a point lies between two others (None: no bound), judged on the first set."""
    if left is not None and not left.first_below(point):
        return False
    return right is None or point.first_below(right)


def fitted_rule(
    factors: RayleighFactors, spans: list[Span], rule: Rule, further: float = 0.0
) -> Rule:
    """A rule as fine as the singularities near the spans demand, and `further` in reach."""
    spacing = rule.spacing * analytic_strip(factors, spans)
    reach = rule.reach + further + max(span.imbalance(factors) for span in spans)
    return rule if (spacing, reach) == (rule.spacing, rule.reach) else Rule(spacing, reach)


def analytic_strip(factors: RayleighFactors, spans: list[Span]) -> float:
    """Half-width of the strip of y in which fields are analytic, over pi; at most 1.

    Slip ahead of the shear front sees a pole at the hidden root; stick, where fields are only
    integrated over whole panels, may come twice as near.
    """
    shares = [span.strip(factors) * (1 if span.sense else 2) for span in spans]
    return min(1.0, *shares)


@dataclass(frozen=True)
class Panels:
    """Consecutive panels from the longitudinal front inward, and the grid on each.

    Attributes
    ----------
    left, right : tuple of CutPoints (right None on the unbounded last panel)
    sense : (p,) array, 0 where the interface sticks
    zone : (p,) array, index of the slip zone, on stick of the one that follows inward
    from_left, from_right, jacobian : (p, ..., n) arrays, v - left, right - v and dv/dy
    at : CutPoints of (p, ..., n)
    skew : (p, ..., 1) array, rho of the map
    rule : Rule
    """

    left: tuple[CutPoints, ...]
    right: tuple[CutPoints | None, ...]
    sense: np.ndarray
    zone: np.ndarray
    from_left: Array
    from_right: Array
    jacobian: Array
    at: CutPoints
    skew: Array
    rule: Rule

    @cached_property
    def ahead(self) -> np.ndarray:
        """(p,) whether a panel lies ahead of the shear front."""
        return self.at.from_b.reshape(len(self.left), -1)[:, 0] < 0

    @cached_property
    def regions(self) -> list[list[int]]:
        """Panels of each stretch of stick and of each zone, from the front inward."""
        keys = zip(self.sense != 0, self.zone, strict=True)
        groups = groupby(enumerate(keys), key=lambda item: item[1])
        return [[index for index, _ in group] for _, group in groups]

    @cached_property
    def _differences(self) -> dict[int, Array]:
        return {}

    def minus(self, point: CutPoints) -> Array:
        """v - point at all nodes, exact in the panels that end at the point."""
        if id(point) not in self._differences:
            difference = self.at.minus(point)
            for i, (left, right) in enumerate(zip(self.left, self.right, strict=True)):
                if left is point:
                    difference[i] = self.from_left[i]
                elif right is point:
                    difference[i] = -self.from_right[i]
            self._differences[id(point)] = difference
        return self._differences[id(point)]

    def integrals(self, density: Array) -> Array:
        """(p, ...) integrals over whole panels; principal values at a pole at c."""
        return self.rule.spacing * np.sum(density * self.jacobian, axis=-1)

    def coordinate(self, panel: int, at: CutPoints) -> Array:
        """The y of (m,) points inside a panel of a single set of zones."""
        left, right = self.left[panel], self.right[panel]
        from_left = np.maximum(at.minus(left), 0.0)
        with np.errstate(divide="ignore"):
            if right is None:
                return np.log(from_left / self.skew[panel])
            to_right = np.maximum(-at.minus(right), 0.0)
            return np.log(from_left) - np.log(to_right) + np.log(self.skew[panel])

    def cauchy(self, source: int, weights: Array, targets: np.ndarray) -> Array:
        """Integral of weights / (w - v) over panel `source`, for the nodes v of other panels.

        `weights` (..., n) contain the jacobian; `targets` are t panel indices; (t, ..., n).
        """
        left, right = self.left[source], self.right[source]
        result = np.empty((len(targets), *weights.shape))
        # Distances from the end between source and target add up: no digits are lost.
        before = targets < source
        if before.any():
            own, other = self.from_left[source], -self.minus(left)[targets[before]]
            result[before] = self._summed(weights, own, other)
        if not before.all():
            assert right is not None
            own, other = self.from_right[source], self.minus(right)[targets[~before]]
            result[~before] = -self._summed(weights, own, other)
        return self.rule.spacing * result

    def _summed(self, weights: Array, own: Array, other: Array) -> Array:
        """Sums of weights / (own + other) over the nodes that matter."""
        if own.shape[-1] < _MANY:
            return _summed(weights, own, other)
        bound = (np.abs(weights) / own).reshape(-1, own.shape[-1]).max(axis=0)
        matter = np.flatnonzero(bound > _NEGLIGIBLE * np.exp(-self.rule.reach / 2))
        if not len(matter):
            return np.zeros_like(other)
        nodes = slice(matter[0], matter[-1] + 1)
        return _summed(weights[..., nodes], own[..., nodes], other)

    def principal_value(self, source: int, weights: Array) -> Array:
        """The same at the panel's own nodes, as a principal value (nodes of the other parity).

        For every map of `lay_panels`, w - v = sqrt(jacobian(w) jacobian(v)) 2 sinh(dy / 2).
        """
        root = np.sqrt(self.jacobian[source])
        return self.rule.spacing / root * ((weights / root) @ self.rule.alternate)


def _summed(weights: Array, own: Array, other: Array) -> Array:
    """Sums of weights / (own + other) over the nodes of `own` (..., m), for `other` (t, ..., n)."""
    m, n = own.shape[-1], other.shape[-1]
    if other.size * m <= _CACHED:
        kernel = np.reciprocal(own[..., None, :] + other[..., None])
        return np.asarray((kernel @ weights[..., None])[..., 0])
    result = np.empty((len(other), own.size // m, n))
    sources, rows = own.reshape(-1, 1, m), weights.reshape(-1, m, 1)
    to = other.reshape(*result.shape, 1)
    step = max(1, min(len(sources), _CACHED // (m * n)))
    kernel = np.empty((step, n, m))
    for start in range(0, len(sources), step):
        part = slice(start, start + step)
        count = len(sources[part])
        for target in range(len(to)):
            np.add(sources[part], to[target, part], out=kernel[:count])
            np.reciprocal(kernel[:count], out=kernel[:count])
            result[target, part] = (kernel[:count] @ rows[part])[..., 0]
    return result.reshape(other.shape)


def _aligned(point: CutPoints, batch: tuple[int, ...]) -> Array:
    """Parts of an edge, (4, 1) or (4, k, 1), as (4, ...) with the axes of `batch`."""
    if point.v.shape == batch:
        return point.parts
    return point.parts.reshape(4, *[1] * (len(batch) + 1 - point.parts.ndim), *point.v.shape)


def lay_panels(
    factors: RayleighFactors, spans: list[Span], rule: Rule, sets: tuple[int, ...] = ()
) -> Panels:
    """Panels on given spans, with the nodes of a rule on each.

    `sets` is (k, 1) if k sets of zones are wanted whatever the shape of the ends.
    """
    ends = [end for span in spans for end in (span.left, span.right) if end is not None]
    batch = max((sets, *(end.v.shape for end in ends)), key=len)
    lefts, rights = (np.empty((4, len(spans), *batch)) for _ in range(2))
    width, skew = np.ones((len(spans), *batch)), np.ones((len(spans), *batch))
    unbounded = spans[-1].right is None
    for i, span in enumerate(spans):
        left, right = span.left, span.right
        lefts[:, i] = rights[:, i] = _aligned(left, batch)
        if right is not None:
            rights[:, i] = _aligned(right, batch)
            width[i] = right.minus(left)
        # A node grid that straddles c evenly has its principal values from the plain sum.
        if span.has_pole(factors):
            skew[i] = (1.0 if right is None else right.from_c) / -left.from_c
            skew[i] *= np.exp(rule.spacing / 2)
        if right is None:
            skew[i] = 1 / skew[i] if span.has_pole(factors) else left.v
    ratio = skew * rule.decay
    share = 1 / (1 + ratio)
    from_left = width * share
    from_right = ratio * from_left
    jacobian = from_right * share
    parts = np.where(ratio > 1, lefts + from_left, rights - from_right)
    if unbounded:
        from_left[-1] = jacobian[-1] = skew[-1] / rule.decay
        from_right[-1] = np.inf
        parts[:, -1] = lefts[:, -1] + from_left[-1]
    return Panels(
        tuple(span.left for span in spans),
        tuple(span.right for span in spans),
        np.array([span.sense for span in spans], dtype=int),
        np.array([span.zone for span in spans], dtype=int),
        from_left,
        from_right,
        jacobian,
        CutPoints(parts),
        skew,
        rule,
    )
