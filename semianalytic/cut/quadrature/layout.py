"""Determine which panels a set of slip zones has, and which of them interact.

Panels end at zone edges, at the shear front and near the hidden root of the Rayleigh function.
Everything that follows from their order alone is computed once per layout.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import groupby

import numpy as np

from semianalytic.halfplane.lazily import cached_property
from semianalytic.halfplane.rayleigh import CutPoints, RayleighFactors
from semianalytic.scene.arrays import Array


@dataclass(frozen=True)
class Zone:
    """Slip zone in slowness: left < v < right, sense +1 or -1.

    left None: slip from the longitudinal front on, or ahead of all waves. right None: slip up to
    the contact edge. A zone may hold an opening; it begins ahead of the opening, or with it, and
    `inward` is its sense behind the opening, 0 for the same sense. If `held`, it ends where the
    opening closes.
    """

    left: CutPoints | None
    right: CutPoints | None
    sense: int
    inward: int = 0
    held: bool = False

    def seen_by(self, see: Callable[[CutPoints], CutPoints]) -> Zone:
        """Return the zone with its edges mapped by a function of points."""
        left, right = (edge if edge is None else see(edge) for edge in (self.left, self.right))
        return replace(self, left=left, right=right)

    @property
    def last_sense(self) -> int:
        """Sense at the inner end."""
        return self.inward or self.sense


@dataclass(frozen=True)
class Pairs:
    """Source and target panels of Cauchy integrals; sources behind their targets come first."""

    # panels, (r,) each
    source: np.ndarray
    target: np.ndarray
    near: np.ndarray  # panel end between the two that is nearest to the source, (r,)
    behind: int  # number of sources behind (at larger slowness than) their target
    onto: Array  # weights with which pairs add up at every panel, (p, r)

    def collect(self, values: Array) -> Array:
        """Return weighted sums at all panels, (p, ..., n), of the values of pairs, (r, ..., n)."""
        shape = values.shape[1:]
        flat = values.reshape(len(values), int(np.prod(shape)))
        return (self.onto @ flat).reshape(-1, *shape)


def _paired(count: int, weights: dict[tuple[int, int], float]) -> Pairs:
    """Return pairs of `count` panels from {(source, target): weight}."""
    # Sources behind their targets come first, so that both groups are slices and not masks.
    chosen = sorted(weights, key=lambda pair: (pair[0] < pair[1], *pair))
    source, target = np.array(chosen, dtype=int).reshape(-1, 2).T
    onto = np.zeros((count, len(chosen)))
    onto[target, np.arange(len(chosen))] = [weights[pair] for pair in chosen]
    # The end nearest to the source is its right one if it lies ahead of the target, else its left.
    after = source < target
    return Pairs(source, target, source + after, int(np.sum(~after)), onto)


@dataclass(frozen=True)
class Layout:
    """Order and kinds of the panels, wherever exactly they end."""

    sense: tuple[int, ...]  # per panel, 0 where the interface sticks
    # per panel, index of the slip zone; on stick, of the zone that follows inward
    zone: tuple[int, ...]
    ahead: int  # number of panels ahead of the shear front
    behind_root: int  # first panel behind the root r of M_+
    # whether a zone covers that root, the shear front, the Rayleigh front; the last is False where
    # there is no Rayleigh wave
    slips_at_root: bool
    slips_at_b: bool
    slips_at_c: bool
    over_c: int  # panel that covers c; -1 if it is left out
    gap: bool  # whether that panel sticks between two zones
    # zone edges behind the root of M_+, with the exponent of X there
    roots: tuple[tuple[int, float], ...]
    root_exponent: float  # exponent of r + k in M_+
    open: tuple[bool, ...]  # per panel, whether the contact is open

    @property
    def pole(self) -> int:
        """Panel that slips across c, where dV/dv has a pole; -1 if there is none.

        Under resistance to slip rate there is no pole, and the panels end at c.
        """
        return self.over_c if self.slips_at_c else -1

    def begins(self, other: Layout) -> bool:
        """Return whether the panels of another layout begin with these."""
        count = len(self.sense)
        begun = other.sense[:count], other.zone[:count], other.open[:count]
        return (self.sense, self.zone, self.open, self.ahead) == (*begun, min(other.ahead, count))

    @cached_property
    def slipping(self) -> np.ndarray:
        """Whether each panel slips, (p,)."""
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
    def clearance_ahead(self) -> Array:
        """Factor by which singularities may be nearer to each panel ahead of the shear front.

        It is 1 on slip and 2 on stick, where singularities may be at half the distance.
        """
        return 2.0 - self.slipping[: self.ahead]

    @cached_property
    def slip_behind(self) -> np.ndarray:
        """Panels behind the shear front that slip."""
        return self.slip[self.slip >= self.ahead]

    @cached_property
    def sign(self) -> Array:
        """Sign of X on each panel, (p,), from the square roots in it."""
        panels = np.arange(len(self.sense))
        phase = np.zeros(len(panels))  # in units of pi
        for end, exponent in self.roots:
            # (e + k)^(1/2) turns by pi / 2 across its edge e; the total phase of X (or X / M_+) is
            # 0 or pi.
            phase += exponent * (panels >= end)
        # M_+ has the factor (r + k)^exponent.  Where slip covers r, X is regular there and X / M_+
        # has the root of 1 / M_+; where r sticks, X / M_+ is regular and X has the root of M_+.
        exponent = self.root_exponent
        of_root = -exponent * ~self.slipping if self.slips_at_root else exponent * self.slipping
        return np.asarray(np.cos(np.pi * (phase + of_root * (panels >= self.behind_root))).round())

    @cached_property
    def phase_pairs(self) -> Pairs:
        """Pairs from the panels ahead of the shear front to those that see their phase in ln X.

        Slip ahead of the shear front, or joined to it by slip, sees the phase of panels that stick.
        All other panels see that of panels that slip.
        """
        count = len(self.sense)
        by_stick = self.slipping & ((np.arange(count) < self.ahead) | self.slips_at_b)
        # The phases of stick and slip ahead of b add up to S_+, so that X can be written with
        # either; the one without the phase of the target itself is chosen.
        weights = {
            (source, target): 1.0 if self.sense[source] else -1.0
            for source in range(self.ahead)
            for target in range(count)
            if bool(self.sense[source]) != by_stick[target]
        }
        return _paired(count, weights)

    def pairs_from(self, sources: np.ndarray) -> Pairs:
        """Return the pairs from given panels to all others."""
        return _pairs_from(len(self.sense), tuple(sources.tolist()))

    @cached_property
    def regions(self) -> list[list[int]]:
        """Panels of each stretch of stick and of each zone, from the front inward."""
        return self._grouped(zip(self.slipping, self.zone, strict=True))

    @cached_property
    def closed_regions(self) -> list[list[int]]:
        """Panels of each stretch of stick and closed part of a zone, from the front inward."""
        parts = self._grouped(zip(self.slipping, self.zone, self.open, strict=True))
        return [part for part in parts if not self.open[part[0]]]

    @staticmethod
    def _grouped(keys: Iterable[tuple[object, ...]]) -> list[list[int]]:
        groups = groupby(enumerate(keys), key=lambda item: item[1])
        return [[index for index, _ in group] for _, group in groups]


@lru_cache(maxsize=1024)
def _pairs_from(count: int, sources: tuple[int, ...]) -> Pairs:
    return _paired(count, {(s, t): 1.0 for s in sources for t in range(count) if s != t})


_layout = lru_cache(maxsize=256)(Layout)


def outline(
    factors: RayleighFactors,
    zones: tuple[Zone, ...],
    tail: bool,
    cuts: tuple[CutPoints, ...] = (),
    opening: Zone | None = None,
    laid: bool = False,
) -> tuple[list[CutPoints], Layout]:
    """Return the ends and the layout of panels.

    They end at zone edges, fronts, the hidden root, more `cuts` and both ends of an opening, and on
    the way over a wide range.  Without `tail` the unbounded panel after others is left out; panels
    that are `laid` are not divided again.
    """
    ends, stretches = [factors.front_a], []

    def on_the_way(right: CutPoints) -> list[CutPoints]:
        return [] if laid else _on_the_way(factors, ends[-1], right)

    # The condition on T changes where the contact opens or closes, so panels end there too.
    edges = () if opening is None else (opening.left, opening.right)
    every = [*factors.cuts, *cuts, *(edge for edge in edges if edge is not None)]
    every.sort(key=lambda cut: cut.first)
    for right, zone, index in _stretches(zones):
        for cut in every:
            if lies_between(ends[-1], cut, right):
                for end in (*on_the_way(cut), cut):
                    stretches.append((*_state(zone, ends[-1], opening), index))
                    ends.append(end)
        if right is not None:
            for end in on_the_way(right):
                stretches.append((*_state(zone, ends[-1], opening), index))
                ends.append(end)
        stretches.append((*_state(zone, ends[-1], opening), index))
        if right is not None:
            ends.append(right)
    if not tail and len(stretches) > 1:
        del stretches[-1]
    senses, opens, owners = zip(*stretches, strict=True)
    before_b, before_c = (sum(end.first[front] < 0 for end in ends) for front in (2, 3))
    cut_at_c = any(end.first[3] == 0 for end in ends)
    # The panel that begins with the last end ahead of c covers c, unless an end lies at c.
    over_c = before_c - 1 if before_c <= len(senses) and not cut_at_c else -1
    slips_at_b, slips_at_c = (
        any(lies_between(zone.left, front, zone.right) for zone in zones)
        for front in (factors.front_b, factors.front_c)
    )
    # The stick that covers c lies between two zones if a zone is outward of it and one inward.
    gap = not slips_at_c and over_c >= 0 and 0 < owners[over_c] < len(zones)
    ahead, roots = min(before_b, len(senses)), _roots(zones, ends, factors.root)
    from_front = factors.root == 1
    at_root = zones[0].left is None if from_front and zones else slips_at_b and not from_front
    at_fronts = at_root, slips_at_b, slips_at_c and factors.has_rayleigh_wave
    order = senses, owners, ahead, 0 if from_front else ahead, *at_fronts
    return ends, _layout(*order, over_c, gap, roots, factors.root_exponent, opens)


def _on_the_way(factors: RayleighFactors, left: CutPoints, right: CutPoints) -> list[CutPoints]:
    """Return points (of the first set) that divide a wide interval behind the shear front."""
    ratio = right.first[0] / left.first[0]
    # A rule is accurate relative to the largest value on a panel, and fields grow like powers.
    # Under a base 1e6 times the step tractions were 1e3 tolerances off in one panel, and one
    # tolerance in eleven; beyond 1e14 the parts grow.
    if left.first[2] < 0 or ratio < 32.0:
        return []
    # Equal ratios of slowness from end to end: a power is then equally smooth on every part.
    count = int(np.ceil(np.log(ratio) / np.log(16.0)))
    count = min(count, 12)
    growth = np.log(right.v / left.v) / count
    return [factors.cut(left.v * np.exp(step * growth)) for step in range(1, count)]


def _state(zone: Zone | None, left: CutPoints, opening: Zone | None) -> tuple[int, bool]:
    """Return sense and openness of what begins at `left` in a zone, or in stick (None)."""
    if opening is None or opening.left is None or left.first_below(opening.left):
        return (zone.sense if zone else 0), False
    is_open = opening.right is None or left.first_below(opening.right)
    return (zone.last_sense if zone else 0), is_open


def _stretches(zones: tuple[Zone, ...]) -> Iterator[tuple[CutPoints | None, Zone | None, int]]:
    """Yield the end, the zone (None on stick) and its or the next index of stretches, inward."""
    for index, zone in enumerate(zones):
        if zone.left is not None:
            yield zone.left, None, index
        yield zone.right, zone, index
    if not zones or zones[-1].right is not None:
        yield None, None, len(zones)


def _roots(
    zones: tuple[Zone, ...], ends: list[CutPoints], root: int
) -> tuple[tuple[int, float], ...]:
    """Return (end, exponent) of X at zone edges behind the root of M_+."""
    place = {id(end): index for index, end in enumerate(ends)}
    roots = []
    for zone in zones:
        for edge, opening in ((zone.left, True), (zone.right, False)):
            if edge is not None and edge.first[root] > 0:
                # Im M changes its sign at c, and with it which of the two kinds of edge is smooth.
                smooth = opening == (edge.first[3] < 0)
                roots.append((place[id(edge)], 0.5 if smooth else -0.5))
    return tuple(roots)


def lies_between(left: CutPoints | None, point: CutPoints, right: CutPoints | None) -> bool:
    """Return whether a point lies between two others (None: no bound), judged on the first set."""
    if left is not None and not left.first_below(point):
        return False
    return right is None or point.first_below(right)
