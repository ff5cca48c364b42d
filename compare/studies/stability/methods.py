"""Ways to solve the first stage that the solver does not use, kept to show why.

Slip rate is piecewise linear on the nodes of the solver's own grid.  Coulomb's law is asked for
at points (collocation) instead of in the mean over hat functions (Galerkin), and the linear
complementarity problem is solved by an active set instead of by pivoting.  b = mu = 1.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from semianalytic.halfplane.rayleigh import gauss, rayleigh_factors
from semianalytic.halfplane.stuck import stuck_traction
from semianalytic.regimes import Loading, scene_of
from semianalytic.scene.errors import ComputationError
from semianalytic.selfsimilar.collocation import lemke, slip_grid

Array = NDArray[np.float64]
PLACEMENTS = ("galerkin", "nodes", "midpoints")
_GAUSS = 6
_MOST_ROUNDS = 200


@dataclass(frozen=True, eq=False)
class GridProblem:
    """w = q + M V, V >= 0, w >= 0, V w = 0 for slip of one sense.

    Attributes
    ----------
    xi : (n + 1,) nodes [c_t], the last at the longitudinal front, where V = 0
    matrix : (n, n), minus traction due to the nodal slip rates
    q : (n,), friction bound less the stuck traction
    """

    xi: Array
    matrix: Array
    q: Array


@dataclass(frozen=True, eq=False)
class GridAnswer:
    """Nodal slip rates (n + 1,), what finding them took, and how it ended.

    status is "solved", "cycles (period p)", "singular", "no end" or what pivoting reported.
    """

    slip_rate: Array
    rounds: int
    status: str


def grid_problem(
    loading: Loading, poisson_ratio: float, chi: float, size: int, placement: str
) -> GridProblem:
    """Complementarity problem of a scene on a grid of about `size` nodes.

    Parameters
    ----------
    placement : {"galerkin", "nodes", "midpoints"}
        Test with hat functions; or ask for Coulomb's law at the nodes (at a quarter of the first
        element in place of the contact edge, where traction is infinite); or between them.
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
    """Corrective traction at points due to nodal slip rates, (points, nodes without the last).

    The gradient of `semianalytic.selfsimilar.collocation` integrated inward by Gauss rules between
    all nodes and points.
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
    """Complementary pivoting, as the solver does it."""
    try:
        pivoted = lemke(problem.matrix, problem.q)
    except ComputationError as error:
        return GridAnswer(np.full(len(problem.xi), np.nan), 0, str(error))
    return GridAnswer(np.append(pivoted.z, 0.0), pivoted.pivots, "solved")


def by_active_set(problem: GridProblem) -> GridAnswer:
    """Primal-dual active set (semismooth Newton): guess who slips, solve, swap all who object."""
    n = len(problem.q)
    slips = problem.q < 0
    seen: dict[bytes, int] = {}
    rate = np.zeros(n)
    for rounds in range(1, _MOST_ROUNDS + 1):
        key = slips.tobytes()
        if key in seen:
            period = rounds - seen[key]
            return GridAnswer(np.append(rate, 0.0), rounds, f"cycles (period {period})")
        seen[key] = rounds
        rate = np.zeros(n)
        try:
            rate[slips] = np.linalg.solve(problem.matrix[np.ix_(slips, slips)], -problem.q[slips])
        except np.linalg.LinAlgError:
            return GridAnswer(np.append(rate, 0.0), rounds, "singular")
        slack = problem.q + problem.matrix @ rate
        following = np.where(slips, rate > 0, slack < 0)
        if np.array_equal(following, slips):
            return GridAnswer(np.append(rate, 0.0), rounds, "solved")
        slips = following
    return GridAnswer(np.append(rate, 0.0), _MOST_ROUNDS, "no end")


def zigzag(xi: Array, rate: Array, exact: Array) -> float:
    """Amplitude of the odd-even mode in the error, relative to the largest exact slip rate.

    Median over nodes inside slip, two nodes off its edges, of the error less the weighted mean of
    its neighbours, halved: what a smooth error and the few nodes beside an edge do not show in.
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
