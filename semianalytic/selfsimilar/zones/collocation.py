"""First stage: slip rate piecewise linear in xi = x/t, Coulomb's law as complementarity.

The corrective traction of a slip rate V(xi) with free slot faces is

    dtau/dxi = -(Im M(-v) / (pi n(xi))) [ PV int n V' dxi0 / (xi0 - xi) - M_-(0) V(inf) ]
               - Re M(-v) V'(xi),          v = 1/xi,  n(xi) = xi M_+(1/xi),

integrated inward from the longitudinal front.  It is tested with the same hat functions that carry
V (Galerkin), which leaves no odd-even mode, and solved by Lemke's pivoting.  b = mu = 1 and
one-sided slip rates throughout.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np

from semianalytic.cut.load import Load
from semianalytic.cut.quadrature.layout import Zone
from semianalytic.halfplane.polynomials import gauss
from semianalytic.halfplane.rayleigh import Mode, rayleigh_factors
from semianalytic.halfplane.stuck import stuck_traction
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import ComputationError
from semianalytic.selfsimilar.zones import tuning


@dataclass(frozen=True)
class SlipGrid:
    """Nodes in xi [c_t] from the edge to the longitudinal front, and what depends on nu alone."""

    xi: Array  # nodes, from 0 to c_l, clustered at 0, c_R, c_t and c_l, (n + 1,)
    # corrective traction of the nodal slip rates, tested with the hat functions [mu b], (n, n)
    operator: Array
    far: Array  # the same for a unit slip rate far ahead, V = 1 at the last node and beyond, (n,)
    # tests of 1, q* and p*, (n,) each
    weight: Array
    shear: Array
    pressure: Array
    gram: Array  # tests of the hat functions themselves, (n, n + 1)
    sample: Array  # takes values at the slownesses of `points` (m,) to their tests, (n, m)
    points: Array


@dataclass(frozen=True)
class GridSlip:
    """Slip rate and traction of the first stage at the nodes xi [c_t], in units b = mu = 1."""

    xi: Array
    slip_rate: Array
    pivots: int


def clustered(ends: Sequence[float] | Array, counts: np.ndarray) -> tuple[Array, Array, Array]:
    """Return nodes (n + 1,) that cluster at all ends, and Gauss points and weights (n, g) between.

    `counts` are the numbers of elements from one end to the next.
    """
    t, weight = gauss(tuning.GAUSS_PER_ELEMENT)
    nodes, points, weights = [np.zeros(1)], [], []
    for (left, right), count in zip(pairwise(ends), counts, strict=True):
        s = np.arange(count + 1) / count
        # Sine-squared spacing clusters the nodes at both ends, where fields are not smooth.
        nodes.append(left + (right - left) * np.sin(np.pi / 2 * s[1:]) ** 2)
        sub = (s[:-1, None] + t / count) * np.pi / 2
        points.append(left + (right - left) * np.sin(sub) ** 2)
        weights.append((right - left) * np.sin(2 * sub) * np.pi / 2 * weight / count)
    return np.concatenate(nodes), np.concatenate(points), np.concatenate(weights)


def hat_areas(width: Array) -> Array:
    """Return the integrals (n + 1,) of hat functions on elements of widths (n,)."""
    return np.convolve(width, [0.5, 0.5])


def hat_gram(width: Array) -> Array:
    """Return the integrals (n + 1, n + 1) of products of two hat functions."""
    return (np.diag(np.convolve(width, [2, 2])) + np.diag(width, 1) + np.diag(width, -1)) / 6


def integrated_tests(xi: Array, at: Array, dxi: Array) -> Array:
    """Return weights (m, n) from slopes of a function to minus its hat tests, 0 at the last node.

    int hat tau dxi = tau(c_l) int hat - int (dtau/dxi) (int_0^xi hat) dxi.
    """
    n, width = len(xi) - 1, np.diff(xi)
    local, area = (at - xi[:-1, None]) / width[:, None], hat_areas(width)
    passed = np.zeros((n, at.shape[1], n))
    passed += np.where(np.arange(n)[:, None] > np.arange(n), area[:n], 0.0)[:, None]
    rows = np.arange(n)
    passed[rows, :, rows] = area[:n, None] - width[:, None] / 2 * (1 - local) ** 2
    passed[rows[:-1], :, rows[1:]] = width[:-1, None] / 2 * local[:-1] ** 2
    return np.asarray((passed * dxi[:, :, None]).reshape(-1, n))


def element_integrals(xi: Array, at: Array, density: Array) -> Array:
    """Return Cauchy integrals (m, n, ...) at points (m,) of each element of densities (n + 1, ...).

    Those of a linear function are a logarithm and a constant.
    """
    axes = (..., *[None] * (density.ndim - 1))
    width, offset = np.diff(xi)[axes], xi - at[:, None]
    slope = np.diff(density, axis=0) / width
    log = np.diff(np.log(np.abs(offset)), axis=1)[axes]
    return np.asarray((density[:-1] - slope * offset[:, :-1][axes]) * log + slope * width)


def at_nodes(gradient: Array, width: Array) -> Array:
    """Return effects (m, n + 1, ...) of values at nodes from those (m, n, ...) of their slopes."""
    by_node = np.zeros((len(gradient), len(width) + 1, *gradient.shape[2:]))
    per_value = gradient / width[(..., *[None] * (gradient.ndim - 2))]
    by_node[:, 1:] += per_value
    by_node[:, :-1] -= per_value
    return by_node


@lru_cache(maxsize=32)
def slip_grid(poisson_ratio: float, size: int, mode: Mode = "II") -> SlipGrid:
    """Return a grid of about `size` nodes with its operator; recent Poisson ratios are cached."""
    factors = rayleigh_factors(poisson_ratio, mode)
    ends, shares = np.array([0.0, 1.0, 1 / factors.a]), np.array([0.65, 0.35])
    if factors.has_rayleigh_wave:
        ends, shares = np.insert(ends, 1, 1 / factors.c), np.array([0.4, 0.25, 0.35])
    xi, point, dxi = clustered(ends, np.maximum(np.round(size * shares).astype(int), 4))
    n = len(xi) - 1
    width = np.diff(xi)

    # Corrective traction gradient at the Gauss points due to a unit V' on each element.
    v = 1 / point.ravel()
    impedance = factors.impedance_on_cut(factors.cut(v))
    density = point.ravel() * factors.m_plus(v)
    # n(xi) tends to 0 at the contact edge.
    node_density = np.zeros(n + 1)
    node_density[1:] = xi[1:] * factors.m_plus(1 / xi[1:])
    cauchy = element_integrals(xi, point.ravel(), node_density)
    gradient = -(impedance.imag / (np.pi * density))[:, None] * cauchy
    own = np.repeat(np.arange(n), tuning.GAUSS_PER_ELEMENT)
    gradient[np.arange(len(own)), own] -= impedance.real
    by_node = at_nodes(gradient, width)
    # Slip at the last node and beyond also radiates far ahead: the term with M_-(0) V(inf).
    far = by_node[:, -1] + impedance.imag / (np.pi * density) * factors.m_plus_at_zero[mode]

    test, area = integrated_tests(xi, point, dxi), hat_areas(width)[:n]
    local, rows = (point - xi[:-1, None]) / width[:, None], np.arange(n)
    hats = np.zeros((n, tuning.GAUSS_PER_ELEMENT, n))
    hats[rows, :, rows] = 1 - local
    hats[rows[:-1], :, rows[1:]] = local[:-1]
    sample = (hats * dxi[:, :, None]).reshape(-1, n)
    return SlipGrid(
        xi,
        -(test.T @ by_node)[:, :n],
        -test.T @ far - area,
        area,
        sample.T @ stuck_traction(poisson_ratio, mode)(v),
        sample.T @ stuck_traction(poisson_ratio, "I")(v),
        hat_gram(width)[:n],
        sample.T,
        v,
    )


def slip_on_grid(
    poisson_ratio: float, load: Load, size: int = tuning.GRIDS[0], mode: Mode = "II"
) -> GridSlip:
    """Solve |tau| <= f p, V (tau -+ f p) = 0 on about `size` nodes; tau = 0 where it is open.

    ComputationError says that complementary pivoting fails.
    """
    grid, far_slip_rate = slip_grid(poisson_ratio, size, mode), float(load.far_slip_rate)
    shear, normal = grid.shear, grid.pressure
    if load.slowness:
        factors = rayleigh_factors(poisson_ratio, mode)
        shear = grid.sample @ load.stuck(factors, mode)(grid.points)
        if load.load_pressure:
            normal = grid.sample @ load.stuck(factors, "I")(grid.points)
    stuck = load.base_shear * grid.weight + load.load_shear * shear + far_slip_rate * grid.far
    pressure = load.base_pressure * grid.weight + load.load_pressure * normal
    friction, stiffness = float(load.friction), -grid.operator
    if load.resistance is not None:
        eta = np.full(len(stiffness), load.resistance)
        if load.opened is not None:
            eta[is_open(load.opened.zone, grid.xi[:-1])] = 0.0
        # Next to an opening the matrix is lumped: the film of a closed node then depends on V at
        # that node alone.
        gram = grid.gram if load.opened is None else np.eye(*grid.gram.shape) * grid.weight[:, None]
        stiffness = stiffness + eta[:, None] * gram[:, :-1]
        stuck -= eta * far_slip_rate * gram[:, -1]
    if load.opened is None:
        rate, pivots = _complementary(stuck, friction * pressure, stiffness)
    else:
        strength = friction * (grid.sample @ load.opened.near_pressure(grid.points))
        rate, pivots = _slip_beside(load.opened.zone, grid.xi[:-1], stuck, strength, stiffness)
    return GridSlip(grid.xi, np.append(rate, far_slip_rate), pivots)


def is_open(opening: Zone, xi: Array) -> np.ndarray:
    """Return which velocities xi >= 0 [c_t] an opening covers, (n,)."""
    assert opening.left is not None
    inner = 0.0 if opening.right is None else 1 / opening.right.v[0]
    return (xi < 1 / opening.left.v[0]) & ((xi > inner) | (inner == 0))


def _slip_beside(
    opening: Zone, xi: Array, stuck: Array, strength: Array, stiffness: Array
) -> tuple[Array, int]:
    """Return the slip rates of all nodes and the pivots, with those of an opening moving freely."""
    free = is_open(opening, xi)
    bound = ~free
    # tau = 0 at the free nodes eliminates them (Schur complement).
    beyond = np.column_stack([stiffness[np.ix_(free, bound)], stuck[free]])
    inner = np.linalg.solve(stiffness[np.ix_(free, free)], beyond)
    across = stiffness[np.ix_(bound, free)]
    reduced = stiffness[np.ix_(bound, bound)] - across @ inner[:, :-1]
    rate, left = np.zeros(len(xi)), stuck[bound] - across @ inner[:, -1]
    rate[bound], pivots = _complementary(left, strength[bound], reduced)
    rate[free] = inner[:, -1] - inner[:, :-1] @ rate[bound]
    return rate, pivots


def _complementary(stuck: Array, strength: Array, stiffness: Array) -> tuple[Array, int]:
    """Return slip rates for which |stuck - stiffness rate| <= strength, and the pivots."""
    # Most scenes slip one way only: half the unknowns, if the other inequality then holds.
    sense = float(np.sign(stuck[np.argmax(np.abs(stuck) - strength)])) or 1.0
    one_way = lemke(stiffness, strength - sense * stuck)
    rate, pivots = sense * one_way.z, one_way.pivots
    least = stiffness @ one_way.z - 1e-9 * np.abs(stuck).max()
    if np.any(strength + sense * stuck < least):
        matrix = np.block([[stiffness, -stiffness], [-stiffness, stiffness]])
        both_ways = lemke(matrix, np.concatenate([strength - stuck, strength + stuck]))
        forward, backward = np.split(both_ways.z, 2)
        rate, pivots = forward - backward, pivots + both_ways.pivots
    return rate, pivots


@dataclass(frozen=True)
class Complementary:
    """Solution z of w = q + M z, w >= 0, z >= 0, w z = 0, and the number of pivots."""

    z: Array
    pivots: int


def lemke(matrix: Array, q: Array, most_pivots: int | None = None) -> Complementary:
    """Solve w = q + M z, w >= 0, z >= 0, w.z = 0 by complementary pivoting.

    ComputationError says that the path ends on a ray or takes `most_pivots`, 20 n by default.
    """
    n = len(q)
    if np.all(q >= 0):
        return Complementary(np.zeros(n), 0)
    # Tableau of w - M z - d z0 = q; columns: w (0..n-1), z (n..2n-1), z0 (2n), right-hand side.
    tableau = np.hstack([np.eye(n), -matrix, -np.ones((n, 1)), q[:, None]])
    basis = np.arange(n)
    scale = np.abs(matrix).max()
    # z0 enters first, in the row that is most negative.
    row, entering = int(np.argmin(q)), 2 * n
    for pivot in range(1, (most_pivots or 20 * n) + 1):
        leaving = basis[row]
        basis[row] = entering
        tableau[row] /= tableau[row, entering]
        column = tableau[:, entering].copy()
        column[row] = 0.0
        tableau -= np.outer(column, tableau[row])
        # z0 has left: the basis is a solution.
        if leaving == 2 * n:
            z = np.zeros(2 * n)
            z[basis] = np.maximum(tableau[:, -1], 0.0)
            return Complementary(z[n:], pivot)
        # The complement of the variable that left enters, so that w z = 0 holds throughout.
        entering = leaving + n if leaving < n else leaving - n
        column = tableau[:, entering]
        allowed = column > 1e-12 * scale
        if not allowed.any():
            raise ComputationError(
                "the complementarity problem of stick and slip ended on a ray after "
                f"{pivot} pivots; use another number of grid points."
            )
        ratio = np.full(n, np.inf)
        ratio[allowed] = tableau[allowed, -1] / column[allowed]
        row = int(np.argmin(ratio))
        tied = np.flatnonzero(ratio <= ratio[row] + 1e-14)
        # Among tied rows prefer that of z0, which ends the path.
        if 2 * n in basis[tied]:
            row = int(tied[np.flatnonzero(basis[tied] == 2 * n)[0]])
    raise ComputationError(
        f"the complementarity problem of stick and slip took over {most_pivots or 20 * n} pivots; "
        "use another number of grid points."
    )
