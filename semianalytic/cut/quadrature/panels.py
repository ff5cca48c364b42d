"""Panels of slowness between zone edges and wave fronts, with double-exponentially fine ends.

On each panel v = left + width / (1 + rho exp(-y)), or left + rho exp(y) on an unbounded last one,
and functions live on a uniform grid in y. Whatever power or logarithm a field has at a panel end,
it is analytic in a strip |Im y| < pi. The trapezoidal rule and sinc interpolation therefore
converge geometrically in the spacing, uniformly down to the ends.

`lay_panels` constructs the panels of a set of zones.

Shapes: a zone edge is a CutPoints of shape (1,), or (k, 1) for k neighbouring sets of zones at
once; node arrays are then (p, n) or (p, k, n), panel first, node last.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from semianalytic.cut.quadrature.layout import Layout, Pairs
from semianalytic.halfplane.lazily import cached_property
from semianalytic.halfplane.rayleigh import CutPoints, from_front
from semianalytic.halfplane.rules import Rule
from semianalytic.scene.arrays import Array

MANY_NODES = 1.2e7
"""Sets of zones times the cube of nodes per panel from which it pays to leave some nodes out."""


class _Piece(NamedTuple):
    """Points at distances (..., q) from the near end; `onto` (m, q) takes values there to nodes."""

    nodes: slice
    distances: Array
    onto: Array


@dataclass(frozen=True)
class Panels:
    """Consecutive panels from the longitudinal front inward, and the grid on each."""

    layout: Layout
    # right is None on an unbounded last panel
    left: tuple[CutPoints, ...]
    right: tuple[CutPoints | None, ...]
    ends: CutPoints  # all their ends, (m, ..., 1)
    widths: Array  # distances between consecutive ends, (m - 1, ..., 1)
    # v - left, right - v and dv/dy, (p, ..., n) each
    from_left: Array
    from_right: Array
    jacobian: Array
    at: CutPoints  # nodes, (p, ..., n)
    skew: Array  # rho of the maps, (p, ..., 1)
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
    def from_ends(self) -> Array:
        """Differences v - end at all nodes, (m, p, ..., n), exact in the panels that end there."""
        right = self.right[-1]
        ends = self.left if right is None else (*self.left, right)
        differences = np.empty((len(ends), *self.at.v.shape))
        # Each end is known best by its distance from its nearest front, so that differences are
        # formed from distances from that front.
        for i, end in enumerate(ends):
            own = from_front(self.ends.parts[:, i], end.fronts)
            np.subtract(from_front(self.at.parts, end.fronts), own, out=differences[i])
        panels = np.arange(len(self.left))
        # In the panels that end there, the distances come from the map itself and lose no digits.
        differences[panels, panels] = self.from_left
        bounded = panels[: len(ends) - 1]
        differences[bounded + 1, bounded] = -self.from_right[bounded]
        return differences

    def integrals(self, density: Array) -> Array:
        """Return integrals over whole panels, (p, ...); principal values at a pole at c."""
        return np.einsum("...n,...n,n->...", density, self.jacobian, self.rule.weights)

    def panel_of(self, at: CutPoints) -> np.ndarray:
        """Return the panels (m,) that contain points of one set of zones; -1 ahead of all."""
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
        """Return integrals of weights / (w - v), with the Jacobian in them, at targets, (r, ...,
        n).
        """
        source, behind = pairs.source, pairs.behind
        # Distances from the end between source and target add up: no digits are lost.
        own, other = np.empty_like(weights), np.abs(self.from_ends[pairs.near, pairs.target])
        own[:behind] = self.from_left[source[:behind]]
        own[behind:] = self.from_right[source[behind:]]
        weights = self.rule.weights * weights
        # w - v is negative for sources ahead of their targets; distances are positive.
        weights[behind:] *= -1
        if not len(source) or own[0].size * own.shape[-1] ** 2 < MANY_NODES:
            return _summed(weights, own, other)
        # From here on the nodes of both count outward from the end between them.
        for values, part in ((weights, slice(behind, None)), (own, slice(behind, None))):
            values[part] = values[part, ..., ::-1].copy()
        other[:behind] = other[:behind, ..., ::-1].copy()
        result, sizes = np.zeros_like(own), np.abs(weights) / own
        # A millionth of what the reach of a rule leaves out does not count either.
        least = 1e-6 * np.exp(-self.rule.reach / 2) * self.rule.spacing
        matter = sizes.reshape(len(own), -1, own.shape[-1]).max(axis=1) > least
        for i, (sent, target) in enumerate(zip(source, pairs.target, strict=True)):
            # Nodes whose contribution is negligible to every target are left out.
            counted = np.flatnonzero(matter[i])
            if not len(counted):
                continue
            rights, lefts = self.from_right[target], self.from_left[target]
            gap = other[i, ..., :1] - (rights[..., -1:] if i < behind else lefts[..., :1])
            kept, pieces = self._pieces(sent, gap)  # the gap is between the near ends of both
            kept = slice(max(kept.start, counted[0]), min(kept.stop, counted[-1] + 1))
            few = [weights[i, ..., kept], *(weights[i, ..., p.nodes] @ p.onto for p in pieces)]
            away = [own[i, ..., kept], *(piece.distances for piece in pieces)]
            condensed = np.concatenate(few, axis=-1), np.concatenate(away, axis=-1)
            self._spread(target, gap, *condensed, other[i], result[i])
        result[:behind] = result[:behind, ..., ::-1].copy()
        return result

    def _spread(
        self, target: int, gap: Array, weights: Array, own: Array, other: Array, result: Array
    ) -> None:
        """Write sums of weights / (own + other) to nodes (..., n) of a target over a gap."""
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
        at the near end as far as the gap is wide: its nearest singularity lies beyond.
        """
        half = self._far_halves[panel]
        if half is None:
            return slice(0, len(self.rule.y)), []
        far, size = half
        # The least gap over all sets of zones decides, 0 between neighbours.
        most, least = float(size.max()), float(gap.min())
        # With 5 or 20 halvings four named scenes take the same time.
        if not (least > 0 and least * 2.0**10 >= most):
            return slice(0, far.nodes.start), [far]
        near = self.rule.beside_end(max(1, int(np.ceil(np.log2(most / least)))))
        share = near.share / near.rest if self.right[panel] is None else near.share
        beside = _Piece(slice(0, near.count), size * share, near.onto)
        return slice(near.count, far.nodes.start), [far, beside]

    @cached_property
    def _far_halves(self) -> list[tuple[_Piece, Array] | None]:
        """The far half of each panel as a piece, and its width or rho; None where the map is
        skewed.
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
        """Panels on which fields vary to the end of the rule: around c, and the unbounded one."""
        over_c, last = self.layout.over_c, len(self.right) - 1
        unbounded = [i for i, right in enumerate(self.right) if right is None]
        if over_c < 0:
            return tuple(unbounded)
        # Slip near a narrow zone around c begins beyond the stick gaps on either side of that
        # zone.
        slips = 0 <= self.layout.pole < last
        near = 2 if slips and bool(np.all(self.widths[over_c] < 0.01)) else 1
        return (*range(max(over_c - near, 0), min(over_c + near, last) + 1), *unbounded)

    def principal_values(self, sources: np.ndarray, weights: Array) -> Array:
        """Return the Cauchy integrals at nodes of the sources (s,), by nodes of other parity."""
        # w - v = sqrt(jacobian(w) jacobian(v)) 2 sinh(dy / 2): one matrix serves all panels.
        root = np.sqrt(self.jacobian[sources])
        return self.rule.spacing / root * ((weights / root) @ self.rule.alternate)


def _summed(weights: Array, own: Array, other: Array) -> Array:
    """Return sums of weights / (own + other) over `own` (..., m), at `other` (..., n)."""
    m, n = own.shape[-1], other.shape[-1]
    rows, count = weights.reshape(-1, m, 1), weights.size // m
    # own + other as a product of rank 2, which BLAS forms in half the time of adding them up
    to, sources = np.ones((count, n, 2)), np.ones((count, 2, m))
    to[..., 0], sources[:, 1] = other.reshape(-1, n), own.reshape(-1, m)
    result = np.empty((len(to), n, 1))
    # Kernel values that stay in the processor's cache.
    step = max(1, min(len(to), 50_000 // (m * n)))
    kernel = np.empty((step, n, m))
    for start in range(0, len(to), step):
        part = slice(start, start + step)
        within = kernel[: len(to[part])]
        np.matmul(to[part], sources[part], out=within)
        np.reciprocal(within, out=within)
        np.matmul(within, rows[part], out=result[part])
    return result.reshape(other.shape)
