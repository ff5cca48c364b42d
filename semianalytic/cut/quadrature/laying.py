"""Lay the panels of a set of zones, and their nodes, on a rule as fine and as long as they need."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from semianalytic.cut.quadrature.layout import Layout, Zone, outline
from semianalytic.cut.quadrature.panels import Panels
from semianalytic.halfplane.rayleigh import CutPoints, RayleighFactors, from_front
from semianalytic.halfplane.rules import Rule, finer_rule
from semianalytic.scene.arrays import Array


def _steps(points: list[CutPoints], parts: Array) -> Array:
    """Return distances (m - 1, ..., 1) between consecutive ends (4, m, ..., 1)."""
    # Measured from the front nearest to the left end, where narrow widths keep their digits.
    steps = [
        from_front(parts[:, i + 1], point.fronts) - from_front(parts[:, i], point.fronts)
        for i, point in enumerate(points[:-1])
    ]
    return np.array(steps).reshape(len(steps), *parts.shape[2:])


def _aligned(point: CutPoints, batch: tuple[int, ...]) -> Array:
    """Return the parts of an edge, (4, 1) or (4, k, 1), as (4, ...) with the axes of `batch`."""
    if point.v.shape == batch:
        return point.parts
    return point.parts.reshape(4, *[1] * (len(batch) + 1 - point.parts.ndim), *point.v.shape)


def _beside_narrow(widths: Array, rule: Rule) -> float:
    """Return how much longer a rule must be because of panels far narrower than a neighbour.

    The fields of a panel bend at the width w of its neighbour from its end, over its own width.
    A rule that ends at a distance exp(-L) beyond that bend is off by about w^(1/2) exp(-L) / w, one
    that ends before it by w^(1/2): a stuck strip of 6e-14 behind the longitudinal front left errors
    of 1e-7 for all rules shorter than that.
    """
    if len(widths) < 2:
        return 0.0
    logs = np.log(np.maximum(widths, np.finfo(float).tiny))
    ratio = np.abs(np.diff(logs, axis=0)).max()
    digits = float(np.log(1 / rule.tolerance))
    return digits + min(float(ratio) / 2, digits) - rule.reach


def _fitted_rule(
    factors: RayleighFactors, layout: Layout, ends: Array, widths: Array, rule: Rule
) -> Rule:
    """Return a rule as fine and long as a hidden root, a narrow gap at c or a pole there needs."""
    strip, further, hidden = 1.0, _beside_narrow(widths, rule), factors.hidden_root
    if np.any(hidden.imag) and layout.ahead:
        v = ends[0, : layout.ahead + 1]
        # The hidden root lies at this |Im y|, which limits the strip of analyticity.
        angle = np.abs(np.angle((hidden - v[:-1]) / (v[1:] - hidden)))
        # one that is real lies off the panels
        angle = np.where(np.imag(hidden) > 0, angle, np.pi).reshape(layout.ahead, -1)
        strip = min(1.0, float((angle.min(axis=1) * layout.clearance_ahead).min()) / np.pi)
    if layout.over_c >= 0:
        before, *after = np.abs(ends[3, layout.over_c : layout.over_c + 2])
        if layout.pole >= 0:
            other = after[0] if after else ends[0, layout.over_c]
            # The map is skewed in y by the logarithm of the ratio of the distances of c from the
            # two ends.
            further = max(further, float(np.abs(np.log(other / before)).max()))
            if after:
                further = max(further, -float(np.log((before + after[0]).min())))
        elif layout.gap:
            further = max(further, -float(np.log((before + after[0]).min())))
    elif layout.slips_at_c:
        # M + eta vanishes at c + i eta / m'(c), at right angles from c, however small eta.
        strip = min(strip, 0.5)
    return finer_rule(rule, strip, further)


def lay_panels(
    factors: RayleighFactors,
    zones: tuple[Zone, ...],
    rule: Rule,
    sets: tuple[int, ...] = (),
    tail: bool = True,
    cuts: tuple[CutPoints, ...] = (),
    opening: Zone | None = None,
) -> Panels:
    """Return the panels for a set of zones on a rule as fine and as long as they need.

    `sets` is (k, 1) if there are k sets of zones whatever the shape of their edges; `tail` says
    whether an unbounded panel after others is included; `cuts` are additional ends, such as c where
    slip resists its rate; panels also end where the `opening` begins and ends.
    """
    points, layout = outline(factors, zones, tail, cuts, opening)
    ends = _aligned_ends(points, sets)
    widths = _steps(points, ends)
    rule = _fitted_rule(factors, layout, ends, widths, rule)
    skew, bounded = _skews(layout, ends, rule), len(points) - 1
    nodes = _Nodes.unset((len(layout.sense), *ends.shape[2:-1], len(rule.y)))
    nodes.lay_bounded(ends, widths, rule)
    if 0 <= layout.pole < bounded:
        nodes.lay_around_pole(ends, widths, skew, rule, layout.pole)
    if len(layout.sense) > bounded:
        nodes.lay_unbounded(ends, skew, rule)
    return Panels(
        layout,
        tuple(points[: len(layout.sense)]),
        (*points[1:], *[None] * (len(layout.sense) - bounded)),
        CutPoints(ends),
        widths,
        nodes.from_left,
        nodes.from_right,
        nodes.jacobian,
        CutPoints(nodes.parts),
        skew,
        rule,
    )


@dataclass(frozen=True)
class _Nodes:
    """v - left, right - v and dv/dy (p, ..., n) and the parts of v (4, p, ..., n), being laid."""

    from_left: Array
    from_right: Array
    jacobian: Array
    parts: Array

    @classmethod
    def unset(cls, shape: tuple[int, ...]) -> _Nodes:
        """Return empty arrays of a shape (p, ..., n)."""
        return cls(np.empty(shape), np.empty(shape), np.empty(shape), np.empty((4, *shape)))

    def lay_bounded(self, ends: Array, widths: Array, rule: Rule) -> None:
        """Fill in the panels between two ends, symmetric about their middle."""
        bounded, middle = len(widths), len(rule.y) // 2
        np.multiply(widths, rule.share, out=self.from_left[:bounded])
        np.multiply(widths, rule.share[::-1], out=self.from_right[:bounded])
        np.multiply(widths, rule.bell, out=self.jacobian[:bounded])
        # Each half counts from its own end, so that distances from fronts beyond that end stay
        # exact.
        near_left = ends[:, :bounded] + self.from_left[:bounded, ..., :middle]
        near_right = ends[:, 1:] - self.from_right[:bounded, ..., middle:]
        self.parts[:, :bounded, ..., :middle] = near_left
        self.parts[:, :bounded, ..., middle:] = near_right

    def lay_around_pole(
        self, ends: Array, widths: Array, skew: Array, rule: Rule, pole: int
    ) -> None:
        """Fill in the panel that slips across c, skewed so that its nodes straddle c."""
        ratio = skew[pole] * rule.decay
        self.from_left[pole] = widths[pole] / (1 + ratio)
        self.from_right[pole] = ratio * self.from_left[pole]
        self.jacobian[pole] = self.from_right[pole] / (1 + ratio)
        near_left = ends[:, pole] + self.from_left[pole]
        near_right = ends[:, pole + 1] - self.from_right[pole]
        self.parts[:, pole] = np.where(ratio > 1, near_left, near_right)

    def lay_unbounded(self, ends: Array, skew: Array, rule: Rule) -> None:
        """Fill in the panel that reaches the contact edge, v to infinity."""
        self.from_left[-1] = self.jacobian[-1] = skew[-1] / rule.decay
        self.from_right[-1] = np.inf
        self.parts[:, -1] = ends[:, -1] + self.from_left[-1]


def _skews(layout: Layout, ends: Array, rule: Rule) -> Array:
    """Return rho of the maps, (p, ..., 1): 1 unless a panel slips across c or is unbounded."""
    bounded, pole = ends.shape[1] - 1, layout.pole
    skew = np.ones((len(layout.sense), *ends.shape[2:]))
    if len(layout.sense) > bounded:
        skew[-1] = ends[0, -1]
    if pole >= 0:
        # Nodes straddle c evenly, y(c) = spacing / 2: the plain sum is then a principal value.
        before = -ends[3, pole] * np.exp(-rule.spacing / 2)
        skew[pole] = before if pole == bounded else ends[3, pole + 1] / before
    return skew


def _aligned_ends(points: list[CutPoints], sets: tuple[int, ...]) -> Array:
    """Return the parts of all ends, (4, m, 1), or (4, m, k, 1) if there are k sets of zones."""
    batch = max((sets, *(point.v.shape for point in points)), key=len)
    ends = np.empty((4, len(points), *batch))
    for i, point in enumerate(points):
        ends[:, i] = _aligned(point, batch)
    return ends
