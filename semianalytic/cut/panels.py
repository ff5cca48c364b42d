"""Panels of slowness between zone edges and wave fronts, with double-exponentially fine ends.

On each panel v = left + width / (1 + rho exp(-y)) (or left + rho exp(y) on the last, unbounded
one) and functions live on a uniform grid in y.  Whatever power or logarithm a field has at a
panel end, it is analytic in a strip |Im y| < pi, so the trapezoidal rule and sinc
interpolation converge geometrically in the spacing, uniformly down to the ends.

`lay_panels` lays them; a `RunningIntegral` gains slip rate from its slope, slip from slip rate, and
traction along them.

Shapes: a zone edge is a CutPoints of shape (1,), or (k, 1) for k neighbouring sets of zones at
once; node arrays are then (p, n) or (p, k, n), panel first, node last.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from semianalytic.cut import tuning
from semianalytic.cut.layout import Layout, Pairs, Zone, outline
from semianalytic.halfplane.rayleigh import Array, CutPoints, RayleighFactors
from semianalytic.halfplane.rules import Rule, finer_rule


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
        """The panels with all points as a function of points gives them."""
        left = tuple(see(end) for end in self.left)
        right = tuple(end if end is None else see(end) for end in self.right)
        return replace(self, left=left, right=right, ends=see(self.ends), at=see(self.at))

    @property
    def sense(self) -> tuple[int, ...]:
        """Per panel, 0 where the interface sticks."""
        return self.layout.sense

    @cached_property
    def _nearest(self) -> np.ndarray:
        """(m,) fronts nearest to the ends."""
        right = self.right[-1]
        ends = self.left if right is None else (*self.left, right)
        return np.array([end.nearest for end in ends])

    @cached_property
    def from_ends(self) -> Array:
        """(m, p, ..., n): v - end at all nodes, exact in the panels that end there."""
        parts = self.ends.parts
        own = parts[self._nearest, np.arange(len(self._nearest))]
        differences = self.at.parts[self._nearest] - own[:, None]
        panels = np.arange(len(self.left))
        differences[panels, panels] = self.from_left
        bounded = panels[: len(own) - 1]
        differences[bounded + 1, bounded] = -self.from_right[bounded]
        return differences

    def integrals(self, density: Array) -> Array:
        """(p, ...) integrals over whole panels; principal values at a pole at c."""
        return np.einsum("...n,...n,n->...", density, self.jacobian, self.rule.weights)

    def coordinate(self, panel: int, at: CutPoints) -> Array:
        """The y of (m,) points inside a panel of a single set of zones."""
        left, right = self.left[panel], self.right[panel]
        from_left = np.maximum(at.minus(left), 0.0)
        with np.errstate(divide="ignore"):
            if right is None:
                return np.log(from_left / self.skew[panel])
            to_right = np.maximum(-at.minus(right), 0.0)
            return np.log(from_left) - np.log(to_right) + np.log(self.skew[panel])

    def inside(self, panel: int, y: Array) -> CutPoints:
        """Points (m,) at given y inside a panel of a single set of zones."""
        skew, left = self.skew[panel], self.left[panel]
        if self.right[panel] is None:
            return CutPoints(left.parts + skew * np.exp(y))
        return CutPoints(left.parts + self.widths[panel] / (1 + skew * np.exp(-y)))

    def cauchy(self, pairs: Pairs, weights: Array) -> Array:
        """Integrals of weights / (w - v) over the sources of pairs at the nodes v of the targets.

        `weights` (r, ..., n) contain the jacobian; (r, ..., n).
        """
        source, behind = pairs.source, pairs.behind
        # Distances from the end between source and target add up: no digits are lost.
        own, other = np.empty_like(weights), np.abs(self.from_ends[pairs.near, pairs.target])
        own[:behind] = self.from_left[source[:behind]]
        own[behind:] = self.from_right[source[behind:]]
        weights = self.rule.weights * weights
        weights[behind:] *= -1
        if own.shape[-1] < tuning.MANY_NODES:
            return _summed(weights, own, other)
        result, least = np.zeros_like(own), tuning.NEGLIGIBLE_WEIGHT * np.exp(-self.rule.reach / 2)
        for i, (sizes, target) in enumerate(zip(np.abs(weights) / own, pairs.target, strict=True)):
            bound = sizes.reshape(-1, own.shape[-1]).max(axis=0)
            matter = np.flatnonzero(bound > self.rule.spacing * least)
            if not len(matter):
                continue
            near = slice(matter[0], matter[-1] + 1)
            to = slice(None) if target in self._long else self.rule.core
            result[i, ..., to] = _summed(
                weights[i, ..., near], own[i, ..., near], other[i, ..., to]
            )
            if target not in self._long:
                result[i, ..., : to.start] = result[i, ..., to.start, None]
                result[i, ..., to.stop :] = result[i, ..., to.stop - 1, None]
        return result

    @cached_property
    def _long(self) -> tuple[int, ...]:
        """Panels on which fields vary out to where the rule ends, not only to its `reach`: those
        around c and the unbounded one."""
        over_c, last = self.layout.over_c, len(self.right) - 1
        unbounded = [i for i, right in enumerate(self.right) if right is None]
        if over_c < 0:
            return tuple(unbounded)
        # what slips beside a strip around c begins beyond the stick gaps on either side of it
        slips = 0 <= self.layout.pole < last
        near = 2 if slips and bool(np.all(self.widths[over_c] < tuning.NARROW_STRIP)) else 1
        return (*range(max(over_c - near, 0), min(over_c + near, last) + 1), *unbounded)

    def principal_values(self, sources: np.ndarray, weights: Array) -> Array:
        """The same at the own nodes of panels (s,), as principal values (nodes of other parity).

        For every map of `lay_panels`, w - v = sqrt(jacobian(w) jacobian(v)) 2 sinh(dy / 2).
        """
        root = np.sqrt(self.jacobian[sources])
        return self.rule.spacing / root * ((weights / root) @ self.rule.alternate)


def _summed(weights: Array, own: Array, other: Array) -> Array:
    """Sums of weights / (own + other) over the nodes of `own` (..., m), for `other` (..., n)."""
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
    """Distances (m - 1, ..., 1) between consecutive ends (4, m, ..., 1)."""
    order, front = np.arange(len(nearest) - 1), nearest[:-1]
    return parts[front, order + 1] - parts[front, order]


def _aligned(point: CutPoints, batch: tuple[int, ...]) -> Array:
    """Parts of an edge, (4, 1) or (4, k, 1), as (4, ...) with the axes of `batch`."""
    if point.v.shape == batch:
        return point.parts
    return point.parts.reshape(4, *[1] * (len(batch) + 1 - point.parts.ndim), *point.v.shape)


def _fitted_rule(factors: RayleighFactors, layout: Layout, ends: Array, rule: Rule) -> Rule:
    """A rule as fine and as long as the singularities near the panels demand.

    Slip ahead of the shear front sees a pole at the hidden root; stick, where fields are only
    integrated over whole panels, may come twice as near.  Beside a narrow stick gap around c,
    dV/dv ~ 1/(v - c) over all scales down to the gap; a pole at c off the middle of its panel
    sees one end nearer than the other.
    """
    strip, further, hidden = 1.0, 0.0, factors.hidden_root
    if np.any(hidden.imag) and layout.ahead:
        v = ends[0, : layout.ahead + 1]
        angle = np.abs(np.angle((hidden - v[:-1]) / (v[1:] - hidden))).reshape(layout.ahead, -1)
        strip = min(1.0, float((angle.min(axis=1) * layout.clearance_ahead).min()) / np.pi)
    if layout.over_c >= 0:
        before, *after = np.abs(ends[3, layout.over_c : layout.over_c + 2])
        if layout.pole >= 0:
            other = after[0] if after else ends[0, layout.over_c]
            further = float(np.abs(np.log(other / before)).max())
            if after:
                further = max(further, -float(np.log((before + after[0]).min())))
        elif layout.gap:
            further = max(0.0, -float(np.log((before + after[0]).min())))
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
    """Panels for a set of zones on a rule as fine and as long as they need.

    `sets` is (k, 1) if there are k sets of zones whatever the shape of their edges.  Without
    `tail` an unbounded panel after others is left out.  `cuts` are more ends, such as c where
    slip resists its rate; there are others where the contact opens and closes.
    """
    points, layout = outline(factors, zones, tail, cuts, opening)
    ends = _aligned_ends(points, sets)
    rule = _fitted_rule(factors, layout, ends, rule)
    widths = _steps(ends, np.array([point.nearest for point in points]))
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
    """Nodes of panels while they are laid: v - left, right - v and dv/dy (p, ..., n), and the parts
    of v (4, p, ..., n)."""

    from_left: Array
    from_right: Array
    jacobian: Array
    parts: Array

    @classmethod
    def unset(cls, shape: tuple[int, ...]) -> _Nodes:
        """Arrays of a shape (p, ..., n) to be filled."""
        return cls(np.empty(shape), np.empty(shape), np.empty(shape), np.empty((4, *shape)))

    def lay_bounded(self, ends: Array, widths: Array, rule: Rule) -> None:
        """Panels between two ends, even about their middle."""
        bounded, middle = len(widths), len(rule.y) // 2
        np.multiply(widths, rule.share, out=self.from_left[:bounded])
        np.multiply(widths, rule.share[::-1], out=self.from_right[:bounded])
        np.multiply(widths, rule.bell, out=self.jacobian[:bounded])
        near_left = ends[:, :bounded] + self.from_left[:bounded, ..., :middle]
        near_right = ends[:, 1:] - self.from_right[:bounded, ..., middle:]
        self.parts[:, :bounded, ..., :middle] = near_left
        self.parts[:, :bounded, ..., middle:] = near_right

    def lay_around_pole(
        self, ends: Array, widths: Array, skew: Array, rule: Rule, pole: int
    ) -> None:
        """The panel that slips across c, skewed so that its nodes straddle c."""
        ratio = skew[pole] * rule.decay
        self.from_left[pole] = widths[pole] / (1 + ratio)
        self.from_right[pole] = ratio * self.from_left[pole]
        self.jacobian[pole] = self.from_right[pole] / (1 + ratio)
        near_left = ends[:, pole] + self.from_left[pole]
        near_right = ends[:, pole + 1] - self.from_right[pole]
        self.parts[:, pole] = np.where(ratio > 1, near_left, near_right)

    def lay_unbounded(self, ends: Array, skew: Array, rule: Rule) -> None:
        """The panel that reaches the contact edge, v to infinity."""
        self.from_left[-1] = self.jacobian[-1] = skew[-1] / rule.decay
        self.from_right[-1] = np.inf
        self.parts[:, -1] = ends[:, -1] + self.from_left[-1]


def _skews(layout: Layout, ends: Array, rule: Rule) -> Array:
    """rho of the maps, (p, ..., 1): 1 but on the panel that slips across c and the unbounded one.

    A node grid that straddles c evenly has its principal values from the plain sum.
    """
    bounded, pole = ends.shape[1] - 1, layout.pole
    skew = np.ones((len(layout.sense), *ends.shape[2:]))
    if len(layout.sense) > bounded:
        skew[-1] = ends[0, -1]
    if pole >= 0:
        before = -ends[3, pole] * np.exp(-rule.spacing / 2)
        skew[pole] = before if pole == bounded else ends[3, pole + 1] / before
    return skew


def _aligned_ends(points: list[CutPoints], sets: tuple[int, ...]) -> Array:
    """Parts of all ends, (4, m, 1), or (4, m, k, 1) if there are k sets of zones."""
    batch = max((sets, *(point.v.shape for point in points)), key=len)
    ends = np.empty((4, len(points), *batch))
    for i, point in enumerate(points):
        ends[:, i] = _aligned(point, batch)
    return ends


@dataclass(frozen=True)
class Power:
    """A density with the integral amount s^exponent beside an end of a panel, of any exponent above
    -1: s is the share of the panel up to there, 1 at its other end.

    A negative exponent counts with its finite part, as if the integral were 0 where s is.

    Attributes
    ----------
    panel : int
    at_left : bool, whether the end is its left one
    exponent, amount : (..., 1) arrays
    """

    panel: int
    at_left: bool
    exponent: Array
    amount: Array

    def share(self, panels: Panels) -> Array:
        """s at the nodes, (..., n)."""
        distance = panels.from_left if self.at_left else panels.from_right
        return self._over_width(panels, distance[self.panel])

    def _over_width(self, panels: Panels, distance: Array) -> Array:
        if panels.right[self.panel] is None:
            return np.asarray(distance / (distance + panels.skew[self.panel]))
        return np.asarray(distance / panels.widths[self.panel])

    def by_y(self, panels: Panels) -> Array:
        """The density at the nodes times dv/dy, (..., n); like v^-3 on an unbounded panel."""
        share, exponent = self.share(panels), self.exponent
        power = (self.amount if self.at_left else -self.amount) * exponent * share**exponent
        if panels.right[self.panel] is None:
            power = power * (1 + exponent) * (1 - share)
        return np.asarray(power * (1 - share))

    def _up_to(self, panels: Panels, share: Array) -> Array:
        """Its integral from the left end of the panel."""
        power = np.where(share > 0, np.where(share > 0, share, 1.0) ** self.exponent, 0.0)
        if panels.right[self.panel] is None:
            power = power * (1 + self.exponent * (1 - share))
        return np.asarray(self.amount * (power if self.at_left else power - 1))

    def at_nodes(self, panels: Panels) -> Array:
        """Its integrals from the left end of the panel to the nodes, (..., n)."""
        return self._up_to(panels, self.share(panels))

    def inside(self, panels: Panels, at: CutPoints) -> Array:
        """The same to points (m,) inside (one set of zones)."""
        left, right = panels.left[self.panel], panels.right[self.panel]
        distance = at.minus(left) if self.at_left or right is None else -at.minus(right)
        return self._up_to(panels, self._over_width(panels, np.maximum(distance, 0.0)))

    def moment_by_y(self, panels: Panels) -> Array:
        """The density times v less the end, at the nodes, times dv/dy, (..., n)."""
        from_end = panels.from_left if self.at_left else -panels.from_right
        return np.asarray(from_end[self.panel] * self.by_y(panels))

    def end(self, panels: Panels) -> Array:
        """Where the end is, (..., 1)."""
        return np.asarray(panels.ends.v[self.panel + (not self.at_left)])

    @property
    def total(self) -> Array:
        """Its integral over the panel, (...)."""
        return np.asarray((self.amount if self.at_left else -self.amount)[..., 0])


def split_power(
    panels: Panels, density: Array, panel: int, at_left: bool, exponent: Array
) -> Power:
    """The power of an exponent that a density (p, ..., n) has beside an end of a panel; it is taken
    out of the density.

    Over that the density is g_0 + g_1 s + g_2 s ln s.  Three nodes tell these, of which the nearest
    to the end is where rounding leaves as much of g_1 s as is left out.
    """
    unit = Power(panel, at_left, exponent, np.ones_like(exponent))
    jacobian, shape, share = panels.jacobian[panel], unit.by_y(panels), unit.share(panels)
    away = share.reshape(-1, share.shape[-1]).min(axis=0) > tuning.LEAST_SHARE
    nodes = np.flatnonzero(away)[:: 1 if at_left else -1]
    stride = max(1, round(tuning.SHARE_LOGARITHM / panels.rule.spacing))
    three, near = nodes[[0, stride, 2 * stride]], ~away
    terms = np.stack([np.ones_like(share), share, share * np.log(share)], axis=-1)
    over = (density[panel] * jacobian)[..., three] / shape[..., three]
    fitted = np.linalg.solve(terms[..., three, :], over[..., None])
    power = replace(unit, amount=fitted[..., 0, :])
    density[panel] -= power.by_y(panels) / jacobian
    left = (terms[..., near, 1:] @ fitted[..., 1:, :])[..., 0]
    density[panel][..., near] = left * shape[..., near] / jacobian[..., near]
    return power


@dataclass(frozen=True)
class RunningIntegral:
    """Integrals of a density g(v), and of v g, from the left end of each panel.

    g may have a simple pole at c inside a panel, and decay like tail / v^2 on the unbounded
    one.  Both are integrated in closed form, the rest by sinc indefinite integration.

    Attributes
    ----------
    panels : Panels
    density : (p, ..., n) array, g at the nodes, without its powers
    c : float, Rayleigh slowness
    tail : float or (...) array, limit of v^2 g (needed for the moment v g only)
    powers : tuple of Power, parts of g that are large beside ends of panels
    residue : (...) array, that of g at c where it is known; None to interpolate it between nodes,
        with half as many digits as integrals have
    """

    panels: Panels
    density: Array
    c: float
    tail: float | Array = 0.0
    powers: tuple[Power, ...] = ()
    residue: Array | None = None

    @cached_property
    def totals(self) -> Array:
        """(p, ...) integrals of g over whole panels; principal values where g has a pole."""
        result = self.panels.integrals(self.density)
        for power in self.powers:
            result[power.panel] += power.total
        return result

    @cached_property
    def halves(self) -> Array:
        """(p, ...) integrals of g from the left end of each panel to the middle node."""
        panels = self.panels
        result = panels.rule.halved(self.density * panels.jacobian)
        for power in self.powers:
            result[power.panel] += power.at_nodes(panels)[..., len(panels.rule.y) // 2]
        return result

    def _powers_on(self, panel: int) -> list[Power]:
        return [power for power in self.powers if power.panel == panel]

    @cached_property
    def residues(self) -> Array:
        """(p, ...) residues of g at c, 0 on panels that do not cover it."""
        panels, rule, pole = self.panels, self.panels.rule, self.panels.layout.pole
        result = np.zeros(self.density.shape[:-1])
        if pole >= 0 and self.residue is not None:
            result[pole] = self.residue
        elif pole >= 0:
            left, right = panels.left[pole], panels.right[pole]
            share = 1.0 if right is None else (right.from_c / right.minus(left))[..., 0]
            decaying = 1.0 if right is not None else np.square(self.c / panels.at.v[pole])
            numerator = self.density[pole] * panels.at.from_c[pole] * panels.jacobian[pole]
            kernel = np.sinc((rule.spacing / 2 - rule.y) / rule.spacing)
            result[pole] = (numerator * decaying) @ kernel / (-left.from_c[..., 0] * share)
        return result

    def level_at_c(self, panel: int) -> Array:
        """Integral of g from the left end of the panel that covers c up to there, less the residue
        times ln |v - c|; (...)."""
        rule, left = self.panels.rule, self.panels.left[panel]
        regular = rule.interpolate_running(np.array([rule.spacing / 2]), self._regular[panel])[0]
        log = -np.log(np.abs(left.from_c))
        if self.panels.right[panel] is None:
            log = log - np.log(self.c / left.v) + 1 - self.c / left.v
        return np.asarray(regular + self.residues[panel] * log[..., 0])

    @cached_property
    def _regular(self) -> Array:
        """(p, ..., n): g without pole, times dv/dy."""
        panels = self.panels
        rest, i = self.density * panels.jacobian, self._pole
        if i is not None:
            shape = 1.0 if panels.right[i] is not None else np.square(self.c / panels.at.v[i])
            pole = self.residues[i][..., None] * shape / panels.at.from_c[i]
            rest[i] = (self.density[i] - pole) * panels.jacobian[i]
        return rest

    @cached_property
    def _pole(self) -> int | None:
        """The panel on which g has a pole."""
        pole = self.panels.layout.pole
        return pole if pole >= 0 and self.residues[pole].any() else None

    def _regular_moment(self, panel: int) -> Array:
        """(n,): v g without pole and tail, times dv/dy."""
        panels = self.panels
        v, moment = panels.at.v[panel], panels.at.v[panel] * self._regular[panel]
        if panels.right[panel] is None:
            density = self.tail * panels.from_left[panel] / np.square(v)
            moment = moment - density * panels.jacobian[panel]
        for power in self._powers_on(panel):
            moment = moment + power.moment_by_y(panels)
        return moment

    def __call__(self, panel: int, at: CutPoints) -> Array:
        """Integral of g from the panel's left end to points inside it (one set of zones)."""
        y = self.panels.coordinate(panel, at)
        regular = self.panels.rule.interpolate_running(y, self._regular[panel])
        return regular + self._of_pole(panel, at) + self._of_powers(panel, at)

    def _of_powers(self, panel: int, at: CutPoints) -> Array | float:
        """Closed form of the powers' part of the integral of g."""
        return sum(power.inside(self.panels, at) for power in self._powers_on(panel))

    def slope(self, panel: int, at: CutPoints) -> Array:
        """What the integral grows by per v inside a panel, g between its nodes (one set of zones).

        To a share of the largest g dv/dy: near ends where that is small g itself is less exact.
        """
        left, right, v = self.panels.left[panel], self.panels.right[panel], at.v
        per_y = at.minus(left)
        if right is not None:
            per_y = per_y * -at.minus(right) / self.panels.widths[panel]
        y = self.panels.coordinate(panel, at)
        pole = self.residues[panel] / at.from_c if panel == self._pole else np.zeros(v.shape)
        if right is None:
            pole = pole * np.square(self.c / v)
        return np.asarray(self.panels.rule.interpolate(y, self._regular[panel]) / per_y + pole)

    @cached_property
    def at_nodes(self) -> Array:
        """(p, ..., n): integrals of g from the left end of each panel to its nodes."""
        result = self.panels.rule.running(self._regular)
        if self._pole is not None:
            result[self._pole] += self._of_pole(self._pole, self.panels.at[self._pole])
        for power in self.powers:
            result[power.panel] += power.at_nodes(self.panels)
        return result

    def with_moment(self, panel: int, at: CutPoints) -> tuple[Array, Array]:
        """Integrals of g and of v g from the panel's left end to points inside it."""
        y = self.panels.coordinate(panel, at)
        both = np.stack([self._regular[panel], self._regular_moment(panel)])
        plain, moment = self.panels.rule.interpolate_running(y, both).T
        left, residue = self.panels.left[panel], self.residues[panel]
        bounded = self.panels.right[panel] is not None
        if residue:
            log = self._log(panel, at)
            if bounded:
                moment = moment + residue * (at.minus(left) + self.c * log)
            else:
                moment = moment + residue * self.c * (log - np.log(at.v / left.v))
        if not bounded:
            moment = moment + self.tail * (np.log(at.v / left.v) + left.v / at.v - 1)
        for power in self._powers_on(panel):
            moment = moment + power.end(self.panels) * power.inside(self.panels, at)
        return plain + self._of_pole(panel, at) + self._of_powers(panel, at), moment

    def _log(self, panel: int, at: CutPoints) -> Array:
        # At c itself V is infinite; x/t cannot tell it from its neighbours in rounding.
        return np.log(np.maximum(np.abs(at.from_c / self.panels.left[panel].from_c), 1e-16))

    def _of_pole(self, panel: int, at: CutPoints) -> Array | float:
        """Closed form of the pole's part of the integral of g."""
        if panel != self._pole:
            return 0.0
        log, left = self._log(panel, at), self.panels.left[panel]
        if self.panels.right[panel] is None:
            log = log - np.log(at.v / left.v) + self.c / at.v - self.c / left.v
        return self.residues[panel][..., None] * log
