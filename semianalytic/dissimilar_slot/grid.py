"""Find zones on a grid in x/t, from piecewise linear slip and opening and complementarity.

With V and U linear between nodes of xi = x/t and n(xi) = xi Psi^T(1/xi) / n_inf,

    dT/dxi = -Im C^(-1) R z / (pi xi) - Re C^(-1) (dV/dxi, dU/dxi),
    z = z(0) + PV int n (dV, dU) / (xi_0 - xi),

on the cut, integrated inward from the fastest wave.  It is tested with the hat functions that carry
V and U, and solved by Lemke's pivoting for slip of either sense and for the gap:

    f p - tau >= 0,  f p + tau >= 0,  V_+ >= 0,  V_- >= 0,  p >= 0,  gap >= 0,

one of each pair zero.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from semianalytic.dissimilar.canonical import glued
from semianalytic.dissimilar.compliance import Compliance
from semianalytic.dissimilar_slot.densities.interface import LoadedBodies, rayleigh_slowness
from semianalytic.dissimilar_slot.densities.zones import MovingZone
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import ComputationError
from semianalytic.selfsimilar.zones.collocation import (
    at_nodes,
    clustered,
    element_integrals,
    hat_areas,
    hat_gram,
    integrated_tests,
    lemke,
)

_TOLERANCE = 1e-8
"""Tolerance of the canonical matrix on the grid, whose rates are one percent off."""


@dataclass(frozen=True, eq=False)
class SlownessGrid:
    """Nodes in xi and what depends on the bodies alone."""

    xi: Array  # from the contact edge to the fastest wave, where rates vanish, (n + 1,)
    response: Array  # tests of tau and sigma due to unit V and U at the nodes, (n, 2, n, 2)
    stuck: Array  # tests of the stuck tractions, from z(0), (n, 2, 2)
    weight: Array  # tests of 1, (n,)
    gram: Array  # tests of the hat functions, (n, n)
    opening: Array  # U from the gap over time at the nodes, (n, n)


@dataclass(frozen=True)
class Seen:
    """V and the gap over time (n,) at the nodes xi (n + 1,) of a grid."""

    xi: Array
    rate: Array
    gap: Array

    @property
    def states(self) -> list[int]:
        """State of each node: 0 stuck, +1 or -1 slipping, 2 open."""
        # Less is rounding left by pivoting.
        least_rate, least_gap = (1e-9 * np.abs(values).max() for values in (self.rate, self.gap))
        slipping = np.where(np.abs(self.rate) > least_rate, np.sign(self.rate), 0)
        return [int(s) for s in np.where(self.gap > least_gap, 2, slipping)]


@lru_cache(maxsize=16)
def grid_of(compliance: Compliance, size: int) -> SlownessGrid:
    """Return a grid of about `size` nodes, clustered at all wave fronts and at the contact edge."""
    slownesses = [*compliance.distinct_fronts, *map(rayleigh_slowness, compliance.bodies)]
    ends = [0.0]
    for end in sorted(1 / v for v in slownesses):
        if end - ends[-1] > 0.02 / compliance.first:  # nearer fronts count as one
            ends.append(end)
    ends[-1] = 1 / compliance.first
    # By the root of their length, so that short stretches between fronts get their share.
    lengths = np.sqrt(np.diff(ends))
    counts = np.maximum(np.round(size * lengths / lengths.sum()).astype(int), 5)
    xi, at, dxi = clustered(ends, counts)
    slopes, stuck = _slopes(compliance, xi, at.ravel())
    test, width = integrated_tests(xi, at, dxi), np.diff(xi)
    return SlownessGrid(
        xi,
        -np.einsum("mi,mnab->ianb", test, slopes),
        -np.einsum("mi,mab->iab", test, stuck),
        hat_areas(width)[:-1],
        hat_gram(width)[:-1, :-1],
        np.asarray(np.linalg.inv(_gap_from_rate(xi)), dtype=float),
    )


def _slopes(compliance: Compliance, xi: Array, at: Array) -> tuple[Array, Array]:
    """Return dT/dxi at points (m,) due to unit rates at nodes, (m, n, 2, 2), and to z(0), (m, 2,
    2).
    """
    canonical = glued(compliance, _TOLERANCE)
    inverse, rates = compliance.on_cut(1 / at).inverse, canonical.rates(1 / at)
    density = np.zeros((len(xi), 2, 2))
    psi = np.swapaxes(canonical.psi(1 / xi[1:]), -1, -2)
    density[1:] = xi[1:, None, None] * psi / canonical.limit
    cauchy = element_integrals(xi, at, density)
    turned = inverse.imag @ rates / (-np.pi * at)[:, None, None]
    gradient = np.einsum("mab,mnbc->mnac", turned, cauchy)
    # Re C^(-1) is local: it takes the slope of the element in which the point lies.
    own = np.searchsorted(xi, at) - 1
    gradient[np.arange(len(at)), own] -= inverse.real
    return at_nodes(gradient, np.diff(xi))[:, :-1], np.asarray(turned, dtype=float)


def _gap_from_rate(xi: Array) -> Array:
    """Return the matrix (n, n) from U to the gap over time, xi int U / xi'^2 dxi' outward, at
    nodes.
    """
    n = len(xi) - 1
    left, right = xi[1:-1], xi[2:]
    log, inverse = np.log(right / left), 1 / left - 1 / right
    of_left = (right * inverse - log) / (right - left)
    of_right = (log - left * inverse) / (right - left)
    element = np.zeros((n - 1, n + 1))
    rows = np.arange(n - 1)
    element[rows, rows + 1], element[rows, rows + 2] = of_left, of_right
    total = np.zeros((n, n + 1))
    total[1:] = xi[1:-1, None] * np.cumsum(element[::-1], axis=0)[::-1]
    total[0, 0] = 1.0  # at the contact edge the gap over time is the rate itself
    return total[:, :n]


def seen_on_grid(interface: LoadedBodies, size: int) -> Seen:
    """Return slip and opening on a grid of about `size` nodes; ComputationError if it fails."""
    grid = grid_of(interface.compliance, size)
    canonical = glued(interface.compliance, _TOLERANCE)
    stuck = grid.stuck @ canonical.constant(interface.load_shear, interface.load_pressure)
    f = interface.friction
    shear = stuck[:, 0] + interface.base_shear * grid.weight
    pressure = interface.base_pressure * grid.weight - stuck[:, 1]
    by_slip, by_gap = grid.response[:, :, :, 0], grid.response[:, :, :, 1] @ grid.opening
    film = interface.resistance * grid.gram
    falls = f * by_slip[:, 1] + by_slip[:, 0]  # of f p - tau per V, and of f p + tau below
    rises = f * by_slip[:, 1] - by_slip[:, 0]
    matrix = np.block(
        [
            [film - falls, falls - film, -f * by_gap[:, 1] - by_gap[:, 0]],
            [-film - rises, film + rises, -f * by_gap[:, 1] + by_gap[:, 0]],
            [-by_slip[:, 1], by_slip[:, 1], -by_gap[:, 1]],
        ]
    )
    given = np.concatenate([f * pressure - shear, f * pressure + shear, pressure])
    closed = slice(0, 2 * len(shear))
    try:
        # Most contacts stay closed, and without gaps a third of the unknowns are left out.
        z = _pivoted(matrix[closed, closed], given[closed], np.tile(grid.weight, 2))
        opens = bool(np.any(given[closed.stop :] + matrix[closed.stop :, closed] @ z < 0))
    except ComputationError:
        opens = True  # a contact kept closed may have no answer
    if opens:
        z = _pivoted(matrix, given, np.tile(grid.weight, 3))
    else:
        z = np.concatenate([z, np.zeros(len(shear))])
    forward, backward, gap = np.split(z, 3)
    return Seen(grid.xi, forward - backward, gap)


def _pivoted(matrix: Array, given: Array, weight: Array) -> Array:
    """Solve by Lemke's method with rows over powers of weights, until the path ends on no ray."""
    for power in (0.0, 1.0, 0.5, -1.0, 2.0):
        scale = weight**-power
        try:
            # A quarter is usual; paths that went on to 7 ended in 16 wrong zones, to 20 took 18 s.
            return lemke(matrix * scale[:, None], given * scale, 3 * len(given)).z
        except ComputationError as error:
            last = error
    raise last


@dataclass(frozen=True)
class _Run:
    """Neighbouring nodes in one state: 0 stuck, +1 or -1 slipping, 2 open."""

    state: int
    first: int
    last: int


def zones_seen(seen: Seen) -> tuple[MovingZone, ...]:
    """Return the zones from the fastest wave inward; openings have slip ahead and behind."""
    states = seen.states
    runs = [_Run(0, len(states), len(states))]  # nothing slips at the fastest wave
    for node in range(len(states) - 1, -1, -1):
        run = runs[-1]
        if states[node] == run.state:
            runs[-1] = _Run(run.state, node, run.last)
        else:
            runs.append(_Run(states[node], node, node))
    zones: list[MovingZone] = []
    start = 0.0  # slowness at which the present run begins
    for outer, inner in zip(runs, [*runs[1:], None], strict=True):
        stop, between, begin = (None, [], 0.0) if inner is None else _boundary(seen, outer, inner)
        if outer.state:
            sense = outer.state
            if outer.state == 2:  # of the slip ahead of it
                sense = zones[-1].sense if zones and zones[-1].right == start else 1
            zones.append(MovingZone(start, stop, sense, outer.state == 2))
        zones += between
        start = begin
    return tuple(zones)


def _boundary(seen: Seen, outer: _Run, inner: _Run) -> tuple[float, list[MovingZone], float]:
    """Return where one run ends, slip zones to put between, and where the next run begins."""
    near, far = seen.xi[inner.last], seen.xi[outer.first]
    senses = np.sign(seen.rate).astype(int)

    def at(share: float) -> float:  # of the way out from the last node of the inner run
        return float(1 / (near + share * (far - near)))

    states = {outer.state, inner.state}
    if states == {1, -1}:
        return at(0.6), [], at(0.4)  # Newton's method finds the true widths
    if 2 in states and 0 in states:
        node = inner.last if inner.state == 2 else outer.first
        if abs(seen.rate[node]) <= 1e-6 * seen.gap.max():  # no shear acts on the opening
            return at(0.5), [], at(0.5)  # nothing shears the interface
        slip = MovingZone(at(0.8), at(0.2), int(senses[node]) or 1)
        return slip.left, [slip], float(slip.right or 0.0)
    if 2 in states:
        return at(0.5), [], at(0.5)
    # The root near an edge puts it further from nodes that slip fast.
    slipping = inner.last if inner.state else outer.first
    inward = slipping - 1 if inner.state else slipping + 1
    run = inner if inner.state else outer
    known = run.first <= inward <= run.last
    ratio = abs(seen.rate[slipping] / seen.rate[inward]) if known else 0.5
    share = min(0.25 + 0.75 * ratio, 0.95)  # as in `selfsimilar.zones.guesses`
    edge = at(share if inner.state else 1 - share)
    return edge, [], edge
