"""Panels of slowness between zone edges and wave fronts, with double-exponentially fine ends.

On each panel v = left + width / (1 + rho exp(-y)) (or left + rho exp(y) on the last, unbounded
one) and functions live on a uniform grid in y.  Whatever power or logarithm a field has at a
panel end, it is analytic in a strip |Im y| < pi, so the trapezoidal rule and sinc
interpolation converge geometrically in the spacing, uniformly down to the ends.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import groupby, pairwise

import numpy as np
from scipy.special import sici

from semianalytic.rayleigh import Array, CutPoints, RayleighFactors


@dataclass(frozen=True)
class Zone:
    """A slip zone in slowness: left < v < right, sense +1 or -1.

    left None: slip ahead of all waves; right None: slip up to the contact edge.
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
        return self.spacing * np.arange(-count, count + 1)

    @cached_property
    def running(self) -> Array:
        """Matrix of sinc indefinite integration: integrals from -inf to each node."""
        return _running(len(self.y)) * self.spacing

    def interpolate_running(self, y: Array, density: Array) -> Array:
        """Integral from -inf to y of the sinc interpolant of `density` ((n,) or (k, n))."""
        weight = 0.5 + sici((y[:, None] - self.y) * (np.pi / self.spacing))[0] / np.pi
        return self.spacing * weight @ density.T


@lru_cache(maxsize=32)
def _running(n: int) -> Array:
    step = 0.5 + sici(np.pi * np.arange(1 - n, n))[0] / np.pi
    order = np.arange(n)
    return step[order[:, None] - order + n - 1]


def rule_for(tolerance: float) -> Rule:
    """Grid on which end exponents of at least 1/2 are integrated to about `tolerance`."""
    digits = np.log(1 / tolerance)
    return Rule(float(np.pi**2 / (digits + 2)), float(2 * digits + 2))


@dataclass(frozen=True)
class Panels:
    """Consecutive panels from the longitudinal front inward, and the grid on each.

    Attributes
    ----------
    left, right : tuple of CutPoints (right None on the unbounded last panel)
    sense : (p,) array, 0 where the interface sticks
    zone : (p,) array, index of the slip zone, on stick of the one that follows inward
    from_left, from_right, jacobian : (p, n) arrays, v - left, right - v and dv/dy
    skew : (p,) array, rho of the map
    at : CutPoints of (p, n) arrays
    rule : Rule
    """

    left: tuple[CutPoints, ...]
    right: tuple[CutPoints | None, ...]
    sense: Array
    zone: Array
    from_left: Array
    from_right: Array
    jacobian: Array
    at: CutPoints
    skew: Array
    rule: Rule

    @cached_property
    def regions(self) -> list[list[int]]:
        """Panels of each stretch of stick and of each zone, from the front inward."""
        keys = zip(self.sense != 0, self.zone, strict=True)
        groups = groupby(enumerate(keys), key=lambda item: item[1])
        return [[index for index, _ in group] for _, group in groups]

    def nodes(self, panel: int | list[int]) -> CutPoints:
        """The nodes of one panel, or of several in one row."""
        at = self.at
        parts = (at.v, at.from_a, at.from_b, at.from_c)
        return CutPoints(*(part[panel].ravel() for part in parts))

    def minus(self, point: CutPoints) -> Array:
        """v - point at all nodes, exact in the panels that end at the point."""
        difference = self.at.minus(point)
        for i, (left, right) in enumerate(zip(self.left, self.right, strict=True)):
            if left is point:
                difference[i] = self.from_left[i]
            elif right is point:
                difference[i] = -self.from_right[i]
        return difference

    def coordinate(self, panel: int, v: CutPoints) -> Array:
        """The y of points inside a panel."""
        left, right = self.left[panel], self.right[panel]
        from_left = np.maximum(v.minus(left), 0.0)
        with np.errstate(divide="ignore"):
            if right is None:
                return np.log(from_left / self.skew[panel])
            to_right = np.maximum(-v.minus(right), 0.0)
            return np.log(from_left) - np.log(to_right) + np.log(self.skew[panel])

    def cauchy(self, source: int, weights: Array, targets: Array) -> Array:
        """Integral of weights / (w - v) over panel `source`, for the nodes v of other panels.

        `weights` (n,) contain the jacobian; `targets` are panel indices; the result is (k, n).
        """
        right = self.right[source]
        to_left = self.minus(self.left[source])[targets]
        if right is None:
            difference = self.from_left[source] - to_left[..., None]
        else:
            to_right = self.minus(right)[targets]
            difference = np.where(
                (np.abs(to_right) < np.abs(to_left))[..., None],
                -self.from_right[source] - to_right[..., None],
                self.from_left[source] - to_left[..., None],
            )
        difference[difference == 0] = np.inf
        return self.rule.spacing * (1 / difference) @ weights

    def principal_value(self, source: int, weights: Array) -> Array:
        """The same at the panel's own nodes, as a principal value (nodes of the other parity)."""
        x, z = self.from_left[source], self.from_right[source]
        half = x < z
        difference = np.where(half[:, None] & half, x - x[:, None], z[:, None] - z)
        order = np.arange(len(x))
        other = (order[:, None] - order) % 2 == 1
        kernel = np.divide(
            2 * self.rule.spacing, difference, where=other, out=np.zeros_like(difference)
        )
        return kernel @ weights


def _skew(
    factors: RayleighFactors, left: CutPoints, right: CutPoints | None, spacing: float
) -> float:
    """Factor rho in the map of a panel; it puts c midway between nodes where the panel covers it.

    A pole at c then has its principal value from the trapezoidal rule itself.
    """
    before = -float(left.from_c)
    if right is None:
        return before * np.exp(-spacing / 2) if before > 0 else float(left.v)
    after = float(right.from_c)
    return after / before * np.exp(spacing / 2) if before > 0 and after > 0 else 1.0


@dataclass(frozen=True)
class Span:
    """Where one panel lies: its ends (right None: unbounded), its sense of slip and its zone."""

    left: CutPoints
    right: CutPoints | None
    sense: int
    zone: int


def spans_of(factors: RayleighFactors, zones: tuple[Zone, ...]) -> list[Span]:
    """Panels for a set of zones: cut at edges, at the shear front and beside the hidden root."""
    whole: list[Span] = []
    position: CutPoints | None = factors.cut(factors.a)
    for index, zone in enumerate(zones):
        assert position is not None
        if zone.left is not None:
            whole.append(Span(position, zone.left, 0, index))
        whole.append(Span(zone.left or position, zone.right, zone.sense, index))
        position = zone.right
    if position is not None:
        whole.append(Span(position, None, 0, len(zones)))
    hidden = factors.hidden_root
    cuts = [factors.cut(hidden.real)] if hidden.imag and hidden.real > factors.a else []
    cuts.append(factors.cut(1.0))
    spans = []
    for span in whole:
        ends: list[CutPoints | None] = [span.left, span.right]
        ends[1:1] = [
            cut
            for cut in cuts
            if cut.minus(span.left) > 0 and (span.right is None or span.right.minus(cut) > 0)
        ]
        for left, right in pairwise(ends):
            assert left is not None
            spans.append(Span(left, right, span.sense, span.zone))
    return spans


def analytic_strip(factors: RayleighFactors, spans: list[Span]) -> float:
    """Half-width of the strip of y in which fields are analytic, over pi; at most 1.

    Slip ahead of the shear front sees a pole at the hidden root; stick, where fields are only
    integrated over whole panels, may come twice as near.
    """
    hidden, width = factors.hidden_root, 1.0
    for span in spans:
        if span.right is not None and span.right.from_b <= 0 and hidden.imag:
            ratio = (hidden - complex(span.left.v)) / (complex(span.right.v) - hidden)
            share = abs(float(np.angle(ratio))) / np.pi
            width = min(width, share if span.sense else 2 * share)
    return width


def lay_panels(factors: RayleighFactors, spans: list[Span], rule: Rule) -> Panels:
    """Panels on given spans, with the nodes of a rule on each."""
    y = rule.y
    skew, from_left, from_right, jacobian, points = [], [], [], [], []
    for span in spans:
        left, right = span.left, span.right
        rho = _skew(factors, left, right, rule.spacing)
        skew.append(rho)
        if right is None:
            distance = rho * np.exp(y)
            from_left.append(distance)
            from_right.append(np.full_like(y, np.inf))
            jacobian.append(distance)
            points.append(left.shifted(distance))
            continue
        width = right.minus(left)
        from_left.append(width / (1 + rho * np.exp(-y)))
        from_right.append(width / (1 + np.exp(y) / rho))
        jacobian.append(from_left[-1] * from_right[-1] / width)
        lower, upper = left.shifted(from_left[-1]), right.shifted(-from_right[-1])
        nearer_left = from_left[-1] < from_right[-1]
        points.append(
            CutPoints(
                *(
                    np.where(nearer_left, getattr(lower, name), getattr(upper, name))
                    for name in ("v", "from_a", "from_b", "from_c")
                )
            )
        )
    return Panels(
        tuple(span.left for span in spans),
        tuple(span.right for span in spans),
        np.array([span.sense for span in spans], dtype=int),
        np.array([span.zone for span in spans], dtype=int),
        np.array(from_left),
        np.array(from_right),
        np.array(jacobian),
        CutPoints(
            *(
                np.array([getattr(p, name) for p in points])
                for name in ("v", "from_a", "from_b", "from_c")
            )
        ),
        np.array(skew),
        rule,
    )
