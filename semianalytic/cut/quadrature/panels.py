"""Panels of slowness between zone edges and wave fronts, with double-exponentially fine ends.

On each panel v = left + width / (1 + rho exp(-y)), or left + rho exp(y) on an unbounded last one,
and functions live on a uniform grid in y. Whatever power or logarithm a field has at a panel end,
it is analytic in a strip |Im y| < pi. The trapezoidal rule and sinc interpolation therefore
converge geometrically in the spacing, uniformly down to the ends (docs/solver.md, "Quadrature").

`lay_panels` constructs the panels of a set of zones.

Shapes: a zone edge is a CutPoints of shape (1,), or (k, 1) for k neighbouring sets of zones at
once; node arrays are then (p, n) or (p, k, n), panel first, node last.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from semianalytic.cut.quadrature import tuning
from semianalytic.cut.quadrature.layout import Layout, Pairs, Zone, outline
from semianalytic.halfplane.rayleigh import Array, CutPoints, RayleighFactors
from semianalytic.halfplane.rules import Rule, finer_rule


class _Piece(NamedTuple):
    """Nodes (m,) of a panel for which a few points stand, at distances (..., q) from its near end.

    The matrix `onto` (m, q) takes values at the points to the nodes, and weights the other way.
    """

    nodes: slice
    distances: Array
    onto: Array


@dataclass(frozen=True)
class Panels:
    """Consecutive panels from the longitudinal front inward, and the grid on each.

    Attributes
    ----------
    layout : Layout
    left, right : tuple of CutPoints (right None on an unbounded last panel)
    ends : CutPoints of (m, ..., 1), all their ends
    widths : (m - 1, ..., 1) array, distances between consecutive ends
    from_left, from_right, jacobian : (p, ..., n) arrays, v - left, right - v and dv/dy
    at : CutPoints of (p, ..., n)
    skew : (p, ..., 1) array, rho of the maps
    rule : Rule
    """

    layout: Layout
    left: tuple[CutPoints, ...]
    right: tuple[CutPoints | None, ...]
    ends: CutPoints
    widths: Array
    from_left: Array
    from_right: Array
    jacobian: Array
    at: CutPoints
    skew: Array
    rule: Rule

    def seen_by(self, see: Callable[[CutPoints], CutPoints]) -> Panels:
        """Return the panels with all points mapped by a function of points."""
        left = tuple(see(end) for end in self.left)
        right = tuple(end if end is None else see(end) for end in self.right)
        return replace(self, left=left, right=right, ends=see(self.ends), at=see(self.at))

    @property
    def sense(self) -> tuple[int, ...]:
        """Sense of slip per panel, 0 where the interface sticks."""
        return self.layout.sense

    @cached_property
    def _nearest(self) -> np.ndarray:
        """Index of the front nearest to each end, (m,)."""
        right = self.right[-1]
        ends = self.left if right is None else (*self.left, right)
        return np.array([end.nearest for end in ends])

    @cached_property
    def from_ends(self) -> Array:
        """Differences v - end at all nodes, (m, p, ..., n), exact in the panels that end there."""
        parts = self.ends.parts
        # Each end is known best by its distance from its nearest front, so that differences are
        # formed from distances from that front.
        own = parts[self._nearest, np.arange(len(self._nearest))]
        differences = self.at.parts[self._nearest] - own[:, None]
        panels = np.arange(len(self.left))
        # In the panels that end there, the distances come from the map itself and lose no digits.
        differences[panels, panels] = self.from_left
        bounded = panels[: len(own) - 1]
        differences[bounded + 1, bounded] = -self.from_right[bounded]
        return differences

    def integrals(self, density: Array) -> Array:
        """Return integrals over whole panels, (p, ...); principal values at a pole at c."""
        return np.einsum("...n,...n,n->...", density, self.jacobian, self.rule.weights)

    def panel_of(self, at: CutPoints) -> np.ndarray:
        """Return the panels (m,) that contain points, for a single set of zones; -1 ahead of
        all."""
        return np.searchsorted([left.v[0] for left in self.left], at.v, "right") - 1

    def coordinate(self, panel: int, at: CutPoints) -> Array:
        """Return the coordinate y of (m,) points inside a panel of a single set of zones."""
        left, right = self.left[panel], self.right[panel]
        from_left = np.maximum(at.minus(left), 0.0)
        # Points at the ends have y = -inf and inf.
        with np.errstate(divide="ignore"):
            if right is None:
                return np.log(from_left / self.skew[panel])
            to_right = np.maximum(-at.minus(right), 0.0)
            return np.log(from_left) - np.log(to_right) + np.log(self.skew[panel])

    def inside(self, panel: int, y: Array) -> CutPoints:
        """Return points (m,) at given y inside a panel of a single set of zones."""
        skew, left = self.skew[panel], self.left[panel]
        if self.right[panel] is None:
            return CutPoints(left.parts + skew * np.exp(y))
        return CutPoints(left.parts + self.widths[panel] / (1 + skew * np.exp(-y)))

    def cauchy(self, pairs: Pairs, weights: Array) -> Array:
        """Return integrals of weights / (w - v) over the sources of pairs at nodes v of the
        targets.

        `weights` (r, ..., n) contain the Jacobian; the result is (r, ..., n).
        """
        source, behind = pairs.source, pairs.behind
        # Distances from the end between source and target add up: no digits are lost.
        own, other = np.empty_like(weights), np.abs(self.from_ends[pairs.near, pairs.target])
        own[:behind] = self.from_left[source[:behind]]
        own[behind:] = self.from_right[source[behind:]]
        weights = self.rule.weights * weights
        # w - v is negative for sources ahead of their targets; distances are positive.
        weights[behind:] *= -1
        if own.shape[-1] < tuning.MANY_NODES or not len(source):
            return _summed(weights, own, other)
        # From here on the nodes of both count outward from the end between them.
        for values, part in ((weights, slice(behind, None)), (own, slice(behind, None))):
            values[part] = values[part, ..., ::-1].copy()
        other[:behind] = other[:behind, ..., ::-1].copy()
        result, sizes = np.zeros_like(own), np.abs(weights) / own
        least = tuning.NEGLIGIBLE_WEIGHT * np.exp(-self.rule.reach / 2) * self.rule.spacing
        matter = sizes.reshape(len(own), -1, own.shape[-1]).max(axis=1) > least
        for i, (sent, target) in enumerate(zip(source, pairs.target, strict=True)):
            # Nodes whose contribution is negligible to every target are left out.
            counted = np.flatnonzero(matter[i])
            if not len(counted):
                continue
            first = (
                self.from_right[target, ..., -1:] if i < behind else self.from_left[target, ..., :1]
            )
            gap = other[i, ..., :1] - first  # between the near ends of both
            kept, pieces = self._pieces(sent, gap)
            kept = slice(max(kept.start, counted[0]), min(kept.stop, counted[-1] + 1))
            few = [
                weights[i, ..., kept],
                *(weights[i, ..., one.nodes] @ one.onto for one in pieces),
            ]
            away = [own[i, ..., kept], *(one.distances for one in pieces)]
            condensed = np.concatenate(few, axis=-1), np.concatenate(away, axis=-1)
            self._spread(target, gap, *condensed, other[i], result[i])
        result[:behind] = result[:behind, ..., ::-1].copy()
        return result

    def _spread(
        self, target: int, gap: Array, weights: Array, own: Array, other: Array, result: Array
    ) -> None:
        """Write sums of weights / (own + other) over (..., m) to the nodes (..., n) of a target.

        Nodes count from the near end, at distances `other` from that of the source, `gap` (..., 1)
        beyond it.
        """
        kept, pieces = self._pieces(target, gap)
        to, core = kept, self.rule.core
        if target not in self._long:
            to = slice(max(to.start, core.start), min(to.stop, core.stop))
        at = [other[..., to], *(gap + piece.distances for piece in pieces)]
        sums, done = _summed(weights, own, np.concatenate(at, axis=-1)), to.stop - to.start
        result[..., to] = sums[..., :done]
        # Beyond the inner nodes of the target the integral hardly changes.
        result[..., kept.start : to.start] = result[..., to.start, None]
        result[..., to.stop : kept.stop] = result[..., to.stop - 1, None]
        for piece in pieces:
            begun, done = done, done + piece.distances.shape[-1]
            result[..., piece.nodes] = sums[..., begun:done] @ piece.onto.T

    def _pieces(self, panel: int, gap: Array) -> tuple[slice, list[_Piece]]:
        """Return the nodes of a panel that are kept, and pieces of others, over a gap (..., 1).

        Nodes count from the near end. Seen from outside, 1 / (w - v) is smooth on the far half, and
        beside the near end as far as the gap is wide: its nearest singularity lies beyond.
        """
        half = self._far_halves[panel]
        if half is None:
            return slice(0, len(self.rule.y)), []
        far, size = half
        # The least gap over all sets of zones decides, 0 between neighbours.
        most, least = float(size.max()), float(gap.min())
        if not (least > 0 and least * 2.0**tuning.MOST_HALVINGS >= most):
            return slice(0, far.nodes.start), [far]
        near = self.rule.beside_end(max(1, int(np.ceil(np.log2(most / least)))))
        share = near.share / near.rest if self.right[panel] is None else near.share
        beside = _Piece(slice(0, near.count), size * share, near.onto)
        return slice(near.count, far.nodes.start), [far, beside]

    @cached_property
    def _far_halves(self) -> list[tuple[_Piece, Array] | None]:
        """The far half of each panel as a piece, and the panel's width, or rho of an unbounded one.

        None where the map is skewed, with its nodes elsewhere.
        """
        half = self.rule.beside_end(1)
        result: list[tuple[_Piece, Array] | None] = []
        nodes = slice(len(self.rule.y) - half.count, len(self.rule.y))
        for panel, right in enumerate(self.right):
            if right is None:
                size, share, onto = self.skew[panel], half.rest / half.share, half.onto_falling
                plain = np.all(size == self.ends.v[-1])
            else:
                size, share, onto = self.widths[panel], half.rest, half.onto[::-1]
                plain = np.all(self.skew[panel] == 1)
            result.append((_Piece(nodes, size * share, onto), size) if plain else None)
        return result

    @cached_property
    def _long(self) -> tuple[int, ...]:
        """Panels on which fields vary out to the end of the rule, not only to its `reach`.

        These are the panels around c and the unbounded one.
        """
        over_c, last = self.layout.over_c, len(self.right) - 1
        unbounded = [i for i, right in enumerate(self.right) if right is None]
        if over_c < 0:
            return tuple(unbounded)
        # what slips beside a strip around c begins beyond the stick gaps on either side of it
        # Slip beside a narrow zone around c begins beyond the stick gaps on either side of that
        # zone.
        slips = 0 <= self.layout.pole < last
        near = 2 if slips and bool(np.all(self.widths[over_c] < tuning.NARROW_STRIP)) else 1
        return (*range(max(over_c - near, 0), min(over_c + near, last) + 1), *unbounded)

    def principal_values(self, sources: np.ndarray, weights: Array) -> Array:
        """Return the Cauchy integrals at the nodes of the source panels (s,) themselves.

        They are principal values, from the nodes of other parity. For every map of `lay_panels`, w
        - v = sqrt(jacobian(w) jacobian(v)) 2 sinh(dy / 2).
        """
        # One matrix of 1 / (2 sinh(dy / 2)) therefore serves all panels.
        root = np.sqrt(self.jacobian[sources])
        return self.rule.spacing / root * ((weights / root) @ self.rule.alternate)


def _summed(weights: Array, own: Array, other: Array) -> Array:
    """Return sums of weights / (own + other) over the nodes of `own` (..., m), for `other` (...,
    n)."""
    m, n = own.shape[-1], other.shape[-1]
    rows, sources, to = weights.reshape(-1, m, 1), own.reshape(-1, 1, m), other.reshape(-1, n, 1)
    result = np.empty((len(to), n, 1))
    step = max(1, min(len(to), tuning.CACHED_KERNEL // (m * n)))
    kernel = np.empty((step, n, m))
    for start in range(0, len(to), step):
        part = slice(start, start + step)
        within = kernel[: len(to[part])]
        np.add(sources[part], to[part], out=within)
        np.reciprocal(within, out=within)
        np.matmul(within, rows[part], out=result[part])
    return result.reshape(other.shape)


def _steps(parts: Array, nearest: np.ndarray) -> Array:
    """Return distances (m - 1, ..., 1) between consecutive ends (4, m, ..., 1)."""
    # Measured from the front nearest to the left end, where narrow widths keep their digits.
    order, front = np.arange(len(nearest) - 1), nearest[:-1]
    return parts[front, order + 1] - parts[front, order]


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
    """Return a rule as fine and as long as the singularities near the panels require.

    Slip ahead of the shear front sees a pole at the hidden root. Stick, where fields are only
    integrated over whole panels, may have it at half the distance. Beside a narrow stick gap around
    c, dV/dv ~ 1/(v - c) over all scales down to the gap. A pole at c that is not in the middle of
    its panel has one end nearer than the other.
    """
    strip, further, hidden = 1.0, _beside_narrow(widths, rule), factors.hidden_root
    if np.any(hidden.imag) and layout.ahead:
        v = ends[0, : layout.ahead + 1]
        # The hidden root lies at this |Im y|, which limits the strip of analyticity.
        angle = np.abs(np.angle((hidden - v[:-1]) / (v[1:] - hidden))).reshape(layout.ahead, -1)
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
        strip = min(strip, tuning.STRIP_AT_CUT_C)
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

    Parameters
    ----------
    factors : RayleighFactors
    zones : tuple of Zone
    rule : Rule
    sets : tuple of int
        (k, 1) if there are k sets of zones whatever the shape of their edges.
    tail : bool
        Whether an unbounded panel after others is included.
    cuts : tuple of CutPoints
        Additional ends, such as c where slip resists its rate.
    opening : Zone or None
        Open part of the contact; panels also end where it begins and ends.
    """
    points, layout = outline(factors, zones, tail, cuts, opening)
    ends = _aligned_ends(points, sets)
    widths = _steps(ends, np.array([point.nearest for point in points]))
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
    """Nodes of panels under construction.

    The arrays are v - left, right - v and dv/dy (p, ..., n), and the parts of v (4, p, ..., n).
    """

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
    """Return rho of the maps, (p, ..., 1): 1 except where a panel slips across c or is unbounded.

    A node grid that straddles c evenly yields principal values by the plain sum.
    """
    bounded, pole = ends.shape[1] - 1, layout.pole
    skew = np.ones((len(layout.sense), *ends.shape[2:]))
    if len(layout.sense) > bounded:
        skew[-1] = ends[0, -1]
    if pole >= 0:
        # c lies half a spacing from a node: y(c) = spacing / 2.
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
