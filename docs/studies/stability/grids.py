"""Alternative solutions of the first stage, kept to show why the solver does not use them.

Slip rate is piecewise linear on the nodes of the solver's own grid.  Coulomb's law can hold at
points (collocation) instead of in the mean over hat functions (Galerkin), and an active set can
replace pivoting for the linear complementarity problem.  Units are b = mu = 1.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from semianalytic.halfplane.polynomials import gauss
from semianalytic.halfplane.rayleigh import rayleigh_factors
from semianalytic.halfplane.stuck import stuck_traction
from semianalytic.regimes import Loading, scene_of
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import ComputationError
from semianalytic.selfsimilar.zones.collocation import lemke, slip_grid

PLACEMENTS = ("galerkin", "nodes", "midpoints")
_GAUSS = 6
_MOST_ROUNDS = 200


class GridProblem(NamedTuple):
    """Complementarity problem w = q + M V, V >= 0, w >= 0, V w = 0 for slip of one sense.

    It has nodes xi (n + 1,) [c_t], the last at the longitudinal front, where V = 0; the negative
    traction due to nodal slip rates (n, n); and friction bound minus stuck traction q (n,).
    """

    xi: Array
    matrix: Array
    q: Array


class GridAnswer(NamedTuple):
    """Nodal slip rates (n + 1,), the effort of finding them, and "solved" or why not."""

    slip_rate: Array
    rounds: int
    status: str


def grid_problem(
    loading: Loading, poisson_ratio: float, chi: float, size: int, placement: str
) -> GridProblem:
    """Set up the complementarity problem of a scene on a grid of about `size` nodes.

    The placement "galerkin" tests with hat functions.  "nodes" demands Coulomb's law at the nodes,
    but for the contact edge, where traction is infinite, at a quarter of the first element;
    "midpoints" demands it between the nodes.
    """
    grid = slip_grid(poisson_ratio, size)
    scene = scene_of(loading, poisson_ratio, chi)
    held, load = scene.superposition
    if placement == "galerkin":
        shear, pressure, weight = grid.shear, grid.pressure, grid.weight
        matrix = -grid.operator
    else:
        xi = grid.xi
        points = (xi[:-1] + xi[1:]) / 2 if placement == "midpoints" else xi[:-1].copy()
        if placement == "nodes":
            points[0] = xi[1] / 4
        shear = stuck_traction(poisson_ratio, "II")(1 / points)
        pressure = stuck_traction(poisson_ratio, "I")(1 / points)
        weight = np.ones_like(points)
        matrix = -traction_operator(poisson_ratio, xi, points)
    strength = chi * (held.pressure * weight + load.pressure * pressure)
    return GridProblem(grid.xi, matrix, strength - held.shear * weight - load.shear * shear)


def traction_operator(poisson_ratio: float, xi: Array, points: Array) -> Array:
    """Return the corrective traction at points due to nodal slip rates, without the last node.

    The gradient of `semianalytic.selfsimilar.zones.collocation` is integrated inward by Gauss rules
    between all nodes and points.  The result is (points, nodes - 1).
    """
    factors = rayleigh_factors(poisson_ratio)
    breaks = np.union1d(xi, points)
    t, weight = gauss(_GAUSS)
    width = np.diff(breaks)
    at = (breaks[:-1, None] + width[:, None] * t).ravel()
    impedance = factors.impedance_on_cut(factors.cut(1 / at))
    density = at * factors.m_plus(1 / at)
    node_density = np.zeros_like(xi)
    node_density[1:] = xi[1:] * factors.m_plus(1 / xi[1:])
    element = np.diff(xi)
    slope = np.diff(node_density) / element
    offset = xi - at[:, None]
    log = np.diff(np.log(np.abs(offset)), axis=1)
    cauchy = (node_density[:-1] - slope * offset[:, :-1]) * log + slope * element
    gradient = -(impedance.imag / (np.pi * density))[:, None] * cauchy
    own = np.searchsorted(xi, at) - 1
    gradient[np.arange(len(at)), own] -= impedance.real
    by_break = (
        gradient.reshape(len(width), _GAUSS, -1) * (width[:, None] * weight)[..., None]
    ).sum(1)
    inward = -np.cumsum(by_break[::-1], axis=0)[::-1] / element
    inward = inward[np.searchsorted(breaks, points)]
    by_node = np.zeros((len(points), len(xi)))
    by_node[:, 1:] += inward
    by_node[:, :-1] -= inward
    return by_node[:, :-1]


def by_pivoting(problem: GridProblem) -> GridAnswer:
    """Solve by complementary pivoting, like the solver."""
    try:
        pivoted = lemke(problem.matrix, problem.q)
    except ComputationError as error:
        return GridAnswer(np.full(len(problem.xi), np.nan), 0, str(error))
    return GridAnswer(np.append(pivoted.z, 0.0), pivoted.pivots, "solved")


def by_active_set(problem: GridProblem) -> GridAnswer:
    """Solve by a primal-dual active set (semismooth Newton), swapping all nodes that disagree."""
    slips, known = problem.q < 0, dict[bytes, int]()
    rate = np.zeros(len(slips))
    status = "no end"
    for rounds in range(1, _MOST_ROUNDS + 1):
        key = slips.tobytes()
        if key in known:
            status = f"cycles (period {rounds - known[key]})"
            break
        known[key] = rounds
        rate = np.zeros(len(slips))
        try:
            rate[slips] = np.linalg.solve(problem.matrix[np.ix_(slips, slips)], -problem.q[slips])
        except np.linalg.LinAlgError:
            status = "singular"
            break
        following = np.where(slips, rate > 0, problem.q + problem.matrix @ rate < 0)
        if np.array_equal(following, slips):
            status = "solved"
            break
        slips = following
    return GridAnswer(np.append(rate, 0.0), rounds, status)


def zigzag(xi: Array, rate: Array, exact: Array) -> float:
    """Return the amplitude of the odd-even mode in the error over the largest exact slip rate.

    It is half the median difference of the error from the weighted mean of its neighbours, over
    nodes at least two nodes inside slip.  Smooth errors and the few nodes near edges do not
    affect it.
    """
    slips = (rate > 0) & (exact > 0)
    inside = np.convolve(slips, np.ones(5), "same") == 5
    inside[:2] = inside[-2:] = False
    if not inside.any():
        return float("nan")
    error = rate - exact
    left, right = np.diff(xi)[:-1], np.diff(xi)[1:]
    mean = np.zeros_like(error)
    mean[1:-1] = (right * error[:-2] + left * error[2:]) / (left + right)
    return float(np.median(np.abs((error - mean)[inside] / 2)) / exact.max())
