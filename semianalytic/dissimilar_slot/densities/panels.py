"""Panels on which the slopes of slip and opening rate are expanded, and their weights.

Zones are cut at wave fronts and where their equations change fast.  On a panel a slope q is the
unknown phi = omega q at equidistant points of the coordinate x of its stretch, with omega a power p
of the distance from either end.  A density like d^e at an end decays like exp(-(p + e) |x|).

The power selects the solution: on the line Re = -p of exponents the equations have exactly one, if
the wanted exponent e lies to its right and the next one, e - 1, to its left, p stays between 0
and 1, and nothing else comes between.  Far behind its start and far ahead of its end a zone is like
one that reaches the contact edge: there omega follows v to the power that it has at that edge.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import pairwise

import numpy as np

from semianalytic.dissimilar.compliance import Complex, Entries
from semianalytic.dissimilar.stretch import Points, Stretch, Values
from semianalytic.dissimilar_slot.densities.interface import LoadedBodies
from semianalytic.dissimilar_slot.densities.zones import MovingZone, neighbours
from semianalytic.scene.arrays import Array


@dataclass(frozen=True)
class End:
    """How a density behaves at one end of a panel: omega ~ d^power, phi ~ exp(-decay |x|)."""

    power: float
    decay: float


def edge_end(exponent: float, bounded: bool = False) -> End:
    """Return an end at which the density behaves like d^exponent, -1 < exponent < 1.

    With `bounded` it also has a bounded part, as V' has where slip turns to opening.
    """
    # The line Re = -p has to leave e to its right and e - 1 to its left, and p is between 0 and 1.
    low, high = max(0.0, -exponent), min(1.0, 1 - exponent)
    # The smallest singular value is 0.26 to 0.37 there; it falls like the distance from a bound.
    power = low + 0.65 * (high - low)
    slowest = min(exponent, 0.0) if bounded else exponent
    # An exponent nearer to -1 would need thousands of points.
    return End(power, max(power + slowest, 0.05))


def front_end(interface: LoadedBodies, v: float) -> End:
    """Return a cut inside a zone, where densities are bounded; d^(1/2) at a shear front of both
    bodies.
    """
    upper, lower = (body.b for body in interface.compliance.bodies)
    # Shear fronts within 3 % of one another count as one.
    shared = abs(upper - lower) < 0.03 * upper and min(abs(v - upper), abs(v - lower)) < 0.03 * v
    # Below 1/2; 0.2 and 0.4 give the same smallest singular value within a tenth.
    return End(0.3, 0.3) if shared else edge_end(0.0)


def contact_end(interface: LoadedBodies, zone: MovingZone) -> End:
    """Return the end of a zone at the contact edge, v -> infinity, where omega ~ v^power."""
    # The density falls like v^(-3/2) or v^(lambda - 2), whichever falls more slowly.
    slowest = -1.5 if zone.open else max(-1.5, interface.edge_decay(zone.sense) - 2)
    power = 1 - 0.35 * (slowest + 1)
    return End(power, -(power + slowest))


@dataclass(frozen=True, eq=False)
class Panel:
    """Nodes (first + i) spacing, i = 0 ... count - 1, on one stretch of a zone of index `zone`.

    `fall` is the power of v in omega between ends that are far apart.
    """

    zone: int
    sense: int
    open: bool
    stretch: Stretch
    spacing: float
    first: int
    count: int
    left: End
    right: End
    fall: float

    @property
    def unknowns(self) -> int:
        """How many unknowns it has: slip alone, or slip and opening."""
        return self.count * (2 if self.open else 1)

    @cached_property
    def x(self) -> Array:
        """(2 n - 1,): the nodes and after them the points half-way between."""
        nodes = self.spacing * (self.first + np.arange(self.count))
        return np.concatenate([nodes, nodes[:-1] + self.spacing / 2])

    @cached_property
    def points(self) -> Points:
        """The points of `x`."""
        return self.stretch.at(self.x)

    @cached_property
    def jacobian(self) -> Array:
        """dv/dx at these points."""
        return np.asarray(self.stretch.slope(self.points))

    @cached_property
    def weight(self) -> Array:
        """omega at these points, with the root of the width for unit of slowness."""
        at, stretch = self.points, self.stretch
        fall = at.v**self.fall
        if stretch.right is None:
            return np.asarray((at.from_left / at.v) ** self.left.power * fall * stretch.left**0.5)
        width = stretch.right - stretch.left
        share = (at.from_left * stretch.right / (at.v * width)) ** self.left.power
        return np.asarray(share * (at.to_right / width) ** self.right.power * fall * width**0.5)

    def entries(self, interface: LoadedBodies) -> Entries:
        """The compliance at these points."""
        fronts = interface.compliance.fronts
        return interface.compliance.on_cut(self.points.v, self.stretch.minus(self.points, fronts))

    def own_kernel(self) -> Array:
        """Return the weights of J(w) / (w - v) for densities phi of the panel itself, (2 n - 1, n).

        The integral is a principal value at the nodes v and half-way between them.
        """
        kernel = _kernel(self.count, self.spacing, self.stretch.right is not None)
        if self.stretch.right is None:
            return kernel / self.weight[: self.count]
        cosh = np.cosh(self.x / 2)
        # J(w) / (w - v) = cosh(x_v / 2) / (2 cosh(x_w / 2) sinh((x_w - x_v) / 2)) for the map of a
        # bounded panel.
        return kernel / (self.weight * cosh)[: self.count] * cosh[:, None]

    def above(self, masses: Values, place: Array, offset: Complex) -> Values:
        """Return int J(w) / (w - v) dw at -v = place + offset on and above the axis, (m, f).

        As in `own_kernel` the integral of the sinc series is exact: it has the factor
        1 - exp(-i pi (y - x_j) / h) of node x_j, y being the coordinate of v, Im y <= 0, which
        tends to 1 off the axis, and on it makes the limit from above.

        The masses (n, f) are J dw at the nodes.
        """
        points, h, nodes = self.points, self.spacing, slice(0, self.count)
        left, right = self.stretch.left, self.stretch.right
        from_left = -((left + place) + offset)
        if right is None:
            difference = points.from_left[nodes] - from_left[:, None]
            y = np.log(from_left / left)
        else:
            to_right = (right + place) + offset
            difference = np.where(
                (np.abs(from_left) < np.abs(to_right))[:, None],
                points.from_left[nodes] - from_left[:, None],
                to_right[:, None] - points.to_right[nodes],
            )
            y = np.log(from_left) - np.log(to_right)
        nearest = np.clip(np.rint(y.real / h).astype(int) - self.first, 0, self.count - 1)
        x = self.x[nearest]
        away = x - y
        close = np.abs(away) < h / 2
        rows, there = np.arange(len(y)), nearest[close]
        # The closest node is left out of the sums and added below, with its factor in closed form.
        difference[rows[close], there] = np.inf
        kernel = 1 / difference
        # exp(i pi x_j / h) at the nodes.
        signs = (-1.0) ** (self.first + np.arange(self.count))
        total = kernel @ masses
        total -= np.exp(-1j * np.pi / h * y)[:, None] * (kernel @ (masses * signs[:, None]))
        # The node that is closest, without the difference of two large numbers.
        # A point nearer than 1e-13 is taken to be a node at this distance.
        away = np.where(np.abs(away) < 1e-13, 1e-13, away)[close]
        apart = self.jacobian[there] * -np.expm1(-away)
        if right is not None:
            apart = self.jacobian[there] * 2 * np.sinh(away / 2)
            apart *= np.cosh(x[close] / 2) / np.cosh(y[close] / 2)
        factor = -np.expm1(1j * np.pi / h * away) / apart
        total[close] += factor[:, None] * masses[there]
        return np.asarray(total)

    def other_kernel(self, source: Panel) -> Array:
        """Return the weights of `own_kernel` for densities phi of another panel, (2 n - 1, m)."""
        common = max(self.stretch.left, source.stretch.left)  # an end between the two, or of both
        ends = np.array([common])
        target = self.stretch.minus(self.points, ends)[0]
        nodes = slice(0, source.count)
        difference = source.stretch.minus(source.points, ends)[0][nodes] - target[:, None]
        strength = source.spacing * source.jacobian[nodes] / source.weight[nodes]
        return np.asarray(np.divide(strength, difference, out=difference))


@lru_cache(maxsize=64)
def _kernel(count: int, spacing: float, bounded: bool) -> Array:
    """Return the Cauchy kernel in the coordinate x times the spacing, (2 n - 1, n).

    At a node only the nodes at odd distance count, twice: the trapezoidal rule of twice the spacing
    has the pole half-way between its points.
    """
    nodes = np.arange(count)
    steps = nodes - np.concatenate([nodes, nodes[:-1] + 0.5])[:, None]
    apart = np.clip(spacing * np.where(steps, steps, 1.0), -1200.0, 1200.0)
    with np.errstate(over="ignore"):
        kernel = 1 / (2 * np.sinh(apart / 2) if bounded else -np.expm1(-apart))
    kernel[:count] *= np.where(steps[:count] % 2, 2.0, 0.0)
    return np.asarray(spacing * kernel)


@lru_cache(maxsize=64)
def between_nodes(count: int) -> Array:
    """Return the matrix of sinc interpolation from nodes to points half-way between, (n - 1, n)."""
    return np.sinc(np.arange(count - 1)[:, None] + 0.5 - np.arange(count))


@dataclass(frozen=True)
class PanelRule:
    """Spacing in x of the nodes, and the share of a density at which panels are cut off."""

    spacing: float
    cutoff: float


@lru_cache(maxsize=32)
def rule_for(tolerance: float) -> PanelRule:
    """Return a rule on which slip rates are right to about a tolerance at every point.

    The sinc series is off by 0.06 to 0.4 exp(-pi^2 / h), a cut-off c by c^1.5.
    """
    return PanelRule(float(np.pi**2 / np.log(0.3 / tolerance)), float(tolerance**0.66))


def tolerance_of(spacing: float) -> float:
    """Return the tolerance of the rule with a spacing, the inverse of `rule_for`."""
    return float(0.3 * np.exp(-(np.pi**2) / spacing))


def panels_of(
    interface: LoadedBodies, zones: Sequence[MovingZone], rule: PanelRule
) -> tuple[Panel, ...]:
    """Return the panels of all zones, in order of slowness."""
    panels = []
    for index, (ahead, zone, behind) in enumerate(neighbours(zones)):
        first, last = edge_exponents(interface, ahead, zone, behind)
        far = contact_end(interface, zone)
        left = edge_end(first, zone.open or ahead is not None)
        right = far if last is None else edge_end(last, zone.open or behind is not None)
        cuts = {*interface.compliance.distinct_fronts}
        cuts.update(interface.sharp_turns(zone.sense, zone.open))
        if zone.open and zone.right is None:  # poles lie on panels that end
            cuts.update(2.0 * c for c in interface.rayleigh_slownesses if c > zone.left)
        inside = sorted(v for v in cuts if zone.left < v and (zone.right is None or v < zone.right))
        ends = [zone.left, *inside, zone.right]
        for start, stop in pairwise(ends):
            assert start is not None
            stretch, h = Stretch(start, stop), rule.spacing
            first_end = left if start == zone.left else front_end(interface, start)
            inner = stop is not None and stop != zone.right
            last_end = front_end(interface, stop) if inner and stop is not None else right
            # phi falls like exp(-decay |x|), and a panel ends where that is the cut-off.
            reach = np.log(1 / rule.cutoff)
            lengths = (reach / first_end.decay + stretch.lead, reach / last_end.decay)
            before, after = (int(np.ceil(length / h)) for length in lengths)
            nodes = h, -before, before + after + 1, first_end, last_end, far.power
            panels.append(Panel(index, zone.sense, zone.open, stretch, *nodes))
    return tuple(panels)


@lru_cache(maxsize=64)  # panels and the tractions at their edges ask for the same
def edge_exponents(
    interface: LoadedBodies, before: MovingZone | None, zone: MovingZone, after: MovingZone | None
) -> tuple[float, float | None]:
    """Return the exponents of V' and U' at both edges of a zone; None at the contact edge.

    The exponent is -theta_K / pi where slip starts and theta_K / pi where it heals.  It is
    -theta_N / pi where slip turns to opening and theta_N / pi - 1 where an opening closes, lower by
    one since the gap has to vanish there as well as its rate.
    """
    slip, opening = interface.slip_turn, interface.open_turn
    if zone.open:
        left = -opening(zone.sense, zone.left)
    elif before is not None:
        # Slip behind an opening starts where the gap closes, with the exponents of the opening
        # there.
        left = opening(zone.sense, zone.left) - 1
    else:
        left = -slip(zone.sense, zone.left)
    if zone.right is None:
        return left, None
    if zone.open:
        sense = after.sense if after is not None else zone.sense
        return left, opening(sense, zone.right) - 1
    if after is not None:
        return left, -opening(zone.sense, zone.right)
    return left, slip(zone.sense, zone.right)
