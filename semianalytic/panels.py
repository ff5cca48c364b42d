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
from itertools import groupby

import numpy as np

from semianalytic.rayleigh import Array, CutPoints, RayleighFactors

_CACHED = 50_000  # kernel values formed at once, so that they stay in the processor's cache
_MANY = 100  # nodes from which it pays to leave some out
_NEGLIGIBLE = 1e-6  # of what the reach of a rule leaves out
_STEPS = 32  # per power of two: fitted rules come in steps, so that their tables are met again


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
    """Uniform grid in y: spacing h, from -reach to reach, and `further` on either side."""

    spacing: float
    reach: float
    further: int = 0

    @cached_property
    def y(self) -> Array:
        count = int(np.ceil((self.reach + self.further) / self.spacing))
        return np.arange(-count, count + 1.0) * self.spacing

    @cached_property
    def core(self) -> slice:
        """Nodes without those that are further out than `reach`."""
        extra = int(self.further / self.spacing)
        return slice(extra, len(self.y) - extra)

    @property
    def tolerance(self) -> float:
        """The tolerance for which `rule_for` has this spacing."""
        return float(np.exp(2 - np.pi**2 / self.spacing))

    @cached_property
    def decay(self) -> Array:
        """exp(-y)."""
        return np.exp(-self.y)

    @cached_property
    def share(self) -> Array:
        """1 / (1 + exp(-y)), the share of a panel to the left of a node."""
        return 1 / (1 + self.decay)

    @cached_property
    def bell(self) -> Array:
        """Slope of `share`."""
        return self.share * self.share[::-1]

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


@lru_cache(maxsize=64)
def _finer_rule(rule: Rule, refinements: int, further: int) -> Rule:
    """A rule of 2^(-refinements / _STEPS) the spacing that goes `further`."""
    return Rule(rule.spacing * 2.0 ** (-refinements / _STEPS), rule.reach, further)


@dataclass(frozen=True)
class Pairs:
    """Source and target panels of Cauchy integrals; sources behind their targets come first.

    Attributes
    ----------
    source, target : (r,) arrays of panels
    near : (r,) array, the panel end between the two
    behind : int, how many sources lie behind (at larger slowness than) their target
    onto : (p, r) array, weights with which pairs add up at every panel
    """

    source: np.ndarray
    target: np.ndarray
    near: np.ndarray
    behind: int
    onto: Array

    def collect(self, values: Array) -> Array:
        """Weighted sums at all panels, (p, ..., n), of what pairs give, (r, ..., n)."""
        return (self.onto @ values.reshape(len(values), int(np.prod(values.shape[1:])))).reshape(
            -1, *values.shape[1:]
        )


def _paired(count: int, weights: dict[tuple[int, int], float]) -> Pairs:
    """Pairs of `count` panels from {(source, target): weight}."""
    chosen = sorted(weights, key=lambda pair: (pair[0] < pair[1], *pair))
    source, target = np.array(chosen, dtype=int).reshape(-1, 2).T
    onto = np.zeros((count, len(chosen)))
    onto[target, np.arange(len(chosen))] = [weights[pair] for pair in chosen]
    after = source < target
    return Pairs(source, target, source + after, int(np.sum(~after)), onto)


@dataclass(frozen=True)
class Layout:
    """Which panels there are, wherever exactly they end.

    Attributes
    ----------
    sense : per panel, 0 where the interface sticks
    zone : per panel, index of the slip zone, on stick of the one that follows inward
    ahead : int, number of panels ahead of the shear front
    slips_at_b, slips_at_c : bool, whether a zone covers the shear front, the Rayleigh front
    over_c : int, the panel that covers c; -1 if it is left out
    gap : bool, whether that panel sticks between two zones
    roots : (end, exponent) of the zone edges slower than c_t, with the exponent X has there
    """

    sense: tuple[int, ...]
    zone: tuple[int, ...]
    ahead: int
    slips_at_b: bool
    slips_at_c: bool
    over_c: int
    gap: bool
    roots: tuple[tuple[int, float], ...]

    @property
    def pole(self) -> int:
        """The panel that slips across c, where dV/dv has a pole; -1 if there is none."""
        return self.over_c if self.slips_at_c else -1

    @cached_property
    def slipping(self) -> np.ndarray:
        """(p,) whether a panel slips."""
        return np.array(self.sense) != 0

    @cached_property
    def stick(self) -> np.ndarray:
        """Panels that stick."""
        return np.flatnonzero(~self.slipping)

    @cached_property
    def slip(self) -> np.ndarray:
        """Panels that slip."""
        return np.flatnonzero(self.slipping)

    @cached_property
    def stick_ahead(self) -> np.ndarray:
        """Panels ahead of the shear front that stick."""
        return self.stick[self.stick < self.ahead]

    @cached_property
    def slip_ahead(self) -> np.ndarray:
        """Panels ahead of the shear front that slip."""
        return self.slip[self.slip < self.ahead]

    @cached_property
    def weights_ahead(self) -> Array:
        """Of the panels ahead of the shear front: 1 on slip, 2 on stick."""
        return 2.0 - self.slipping[: self.ahead]

    @cached_property
    def slip_behind(self) -> np.ndarray:
        """Panels behind the shear front that slip."""
        return self.slip[self.slip >= self.ahead]

    @cached_property
    def sign(self) -> Array:
        """(p,) sign of X, from the square roots it is made of."""
        panels = np.arange(len(self.sense))
        phase = np.zeros(len(panels))  # over pi
        for end, exponent in self.roots:
            phase += exponent * (panels >= end)
        at_b = 0.5 * (~self.slipping if self.slips_at_b else -1.0 * self.slipping)
        return np.asarray(np.cos(np.pi * (phase + at_b * (panels >= self.ahead))).round())

    @cached_property
    def phase_pairs(self) -> Pairs:
        """From the panels ahead of the shear front to those that see their phase in ln X.

        What slips ahead of the shear front or is joined to it by slip sees the phase of what
        sticks, all else that of what slips.
        """
        count = len(self.sense)
        by_stick = self.slipping & ((np.arange(count) < self.ahead) | self.slips_at_b)
        weights = {
            (source, target): 1.0 if self.sense[source] else -1.0
            for source in range(self.ahead)
            for target in range(count)
            if bool(self.sense[source]) != by_stick[target]
        }
        return _paired(count, weights)

    def pairs_from(self, sources: tuple[int, ...]) -> Pairs:
        """From some panels to all others."""
        return _pairs_from(len(self.sense), sources)

    @cached_property
    def regions(self) -> list[list[int]]:
        """Panels of each stretch of stick and of each zone, from the front inward."""
        keys = zip(self.slipping, self.zone, strict=True)
        groups = groupby(enumerate(keys), key=lambda item: item[1])
        return [[index for index, _ in group] for _, group in groups]


@lru_cache(maxsize=64)
def _pairs_from(count: int, sources: tuple[int, ...]) -> Pairs:
    return _paired(count, {(s, t): 1.0 for s in sources for t in range(count) if s != t})


_layout = lru_cache(maxsize=256)(Layout)


def _outline(
    factors: RayleighFactors, zones: tuple[Zone, ...], tail: bool
) -> tuple[list[CutPoints], Layout]:
    """Ends and layout of panels: cut at edges, at the shear front and beside the hidden root."""
    ends, senses, owners = [factors.front_a], [], []

    def extend(right: CutPoints | None, sense: int, zone: int) -> None:
        for end in (*factors.cuts, right):
            if end is right or (end and lies_between(ends[-1], end, right)):
                senses.append(sense)
                owners.append(zone)
                if end:
                    ends.append(end)

    for index, zone in enumerate(zones):
        if zone.left is not None:
            extend(zone.left, 0, index)
        extend(zone.right, zone.sense, index)
    if not zones or zones[-1].right is not None:
        extend(None, 0, len(zones))
    slips_at_b, slips_at_c = (
        any(lies_between(zone.left, front, zone.right) for zone in zones)
        for front in (factors.front_b, factors.front_c)
    )
    if not tail and len(senses) > 1:
        del senses[-1], owners[-1]
    place = {id(end): index for index, end in enumerate(ends)}
    over_c = sum(end.first[3] < 0 for end in ends) - 1  # the last panel that begins before c
    if over_c >= len(senses):
        over_c = -1
    roots = []
    for zone in zones:
        for edge, opening in ((zone.left, True), (zone.right, False)):
            if edge is not None and edge.first[2] > 0:
                smooth = opening == (edge.first[3] < 0)
                roots.append((place[id(edge)], 0.5 if smooth else -0.5))
    layout = _layout(
        tuple(senses),
        tuple(owners),
        min(place[id(factors.front_b)], len(senses)),
        slips_at_b,
        slips_at_c,
        over_c,
        not slips_at_c and over_c >= 0 and 0 < owners[over_c] < len(zones),
        tuple(roots),
    )
    return ends, layout


def lies_between(left: CutPoints | None, point: CutPoints, right: CutPoints | None) -> bool:
    """Whether a point lies between two others (None: no bound), judged on the first set."""
    if left is not None and not left.first_below(point):
        return False
    return right is None or point.first_below(right)


@dataclass(frozen=True)
class Panels:
    """Consecutive panels from the longitudinal front inward, and the grid on each.

    Attributes
    ----------
    layout : Layout
    left, right : tuple of CutPoints (right None on an unbounded last panel)
    ends : CutPoints of (m, ..., 1), all their ends
    from_left, from_right, jacobian : (p, ..., n) arrays, v - left, right - v and dv/dy
    at : CutPoints of (p, ..., n)
    skew : (p, ..., 1) array, rho of the maps
    rule : Rule
    """

    layout: Layout
    left: tuple[CutPoints, ...]
    right: tuple[CutPoints | None, ...]
    ends: CutPoints
    from_left: Array
    from_right: Array
    jacobian: Array
    at: CutPoints
    skew: Array
    rule: Rule

    @property
    def sense(self) -> tuple[int, ...]:
        """Per panel, 0 where the interface sticks."""
        return self.layout.sense

    @cached_property
    def widths(self) -> Array:
        """(m - 1, ..., 1) distances between consecutive ends."""
        return _steps(self.ends.parts, self._nearest)

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
        return self.rule.spacing * np.einsum("...n,...n->...", density, self.jacobian)

    def coordinate(self, panel: int, at: CutPoints) -> Array:
        """The y of (m,) points inside a panel of a single set of zones."""
        left, right = self.left[panel], self.right[panel]
        from_left = np.maximum(at.minus(left), 0.0)
        with np.errstate(divide="ignore"):
            if right is None:
                return np.log(from_left / self.skew[panel])
            to_right = np.maximum(-at.minus(right), 0.0)
            return np.log(from_left) - np.log(to_right) + np.log(self.skew[panel])

    def cauchy(self, pairs: Pairs, weights: Array) -> Array:
        """Integrals of weights / (w - v) over the sources of pairs at the nodes v of the targets.

        `weights` (r, ..., n) contain the jacobian; (r, ..., n).
        """
        source, behind = pairs.source, pairs.behind
        # Distances from the end between source and target add up: no digits are lost.
        own, other = np.empty_like(weights), np.abs(self.from_ends[pairs.near, pairs.target])
        own[:behind] = self.from_left[source[:behind]]
        own[behind:] = self.from_right[source[behind:]]
        weights = self.rule.spacing * weights
        weights[behind:] *= -1
        if own.shape[-1] < _MANY:
            return _summed(weights, own, other)
        result, least = np.zeros_like(own), _NEGLIGIBLE * np.exp(-self.rule.reach / 2)
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
        over_c = self.layout.over_c
        beside = range(over_c - 1, over_c + 2) if over_c >= 0 else ()
        return (*beside, *[i for i, right in enumerate(self.right) if right is None])

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
    step = max(1, min(len(to), _CACHED // (m * n)))
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
    if hidden.imag and layout.ahead:
        v = ends[0, : layout.ahead + 1]
        angle = np.abs(np.angle((hidden - v[:-1]) / (v[1:] - hidden))).reshape(layout.ahead, -1)
        strip = min(1.0, float((angle.min(axis=1) * layout.weights_ahead).min()) / np.pi)
    if layout.over_c >= 0:
        before, *after = np.abs(ends[3, layout.over_c : layout.over_c + 2])
        if layout.pole >= 0:
            other = after[0] if after else ends[0, layout.over_c]
            further = float(np.abs(np.log(other / before)).max())
        elif layout.gap:
            further = max(0.0, -float(np.log((before + after[0]).min())))
    refinements = int(np.ceil(-_STEPS * np.log2(strip)))
    return _finer_rule(rule, refinements, int(np.ceil(further)))


def lay_panels(
    factors: RayleighFactors,
    zones: tuple[Zone, ...],
    rule: Rule,
    sets: tuple[int, ...] = (),
    tail: bool = True,
) -> Panels:
    """Panels for a set of zones on a rule as fine and as long as they need.

    `sets` is (k, 1) if k sets of zones are wanted whatever the shape of their edges.  Without
    `tail` an unbounded panel after others is left out.
    """
    points, layout = _outline(factors, zones, tail)
    batch = max((sets, *(point.v.shape for point in points)), key=len)
    ends = np.empty((4, len(points), *batch))
    for i, point in enumerate(points):
        ends[:, i] = _aligned(point, batch)
    rule = _fitted_rule(factors, layout, ends, rule)
    bounded, middle = len(points) - 1, len(rule.y) // 2
    shape = (len(layout.sense), *batch[:-1], len(rule.y))
    from_left, from_right, jacobian = (np.empty(shape) for _ in range(3))
    parts = np.empty((4, *shape))
    width = _steps(ends, np.array([point.nearest for point in points]))
    np.multiply(width, rule.share, out=from_left[:bounded])
    np.multiply(width, rule.share[::-1], out=from_right[:bounded])
    np.multiply(width, rule.bell, out=jacobian[:bounded])
    lefts, rights = ends[:, :bounded], ends[:, 1:]
    parts[:, :bounded, ..., :middle] = lefts + from_left[:bounded, ..., :middle]
    parts[:, :bounded, ..., middle:] = rights - from_right[:bounded, ..., middle:]
    skew, pole = np.ones((shape[0], *batch)), layout.pole
    if len(layout.sense) > bounded:
        skew[-1] = ends[0, -1]
    if pole >= 0:
        # A node grid that straddles c evenly has its principal values from the plain sum.
        before = -ends[3, pole] * np.exp(-rule.spacing / 2)
        skew[pole] = before if pole == bounded else ends[3, pole + 1] / before
    if 0 <= pole < bounded:
        ratio = skew[pole] * rule.decay
        from_left[pole] = width[pole] / (1 + ratio)
        from_right[pole] = ratio * from_left[pole]
        jacobian[pole] = from_right[pole] / (1 + ratio)
        near_left = lefts[:, pole] + from_left[pole]
        parts[:, pole] = np.where(ratio > 1, near_left, rights[:, pole] - from_right[pole])
    if len(layout.sense) > bounded:
        from_left[-1] = jacobian[-1] = skew[-1] / rule.decay
        from_right[-1] = np.inf
        parts[:, -1] = ends[:, -1] + from_left[-1]
    return Panels(
        layout,
        tuple(points[: shape[0]]),
        (*points[1:], *[None] * (shape[0] - bounded)),
        CutPoints(ends),
        from_left,
        from_right,
        jacobian,
        CutPoints(parts),
        skew,
        rule,
    )
