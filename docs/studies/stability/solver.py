"""Losses of digits and failures of the solver and of alternative methods, as rows of one table.

For loadings and units see `semianalytic.regimes`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from compare.comparison.measures import relative_error
from docs.studies.runner import Point, Row
from docs.studies.stability import grids
from semianalytic import Material, Solution, regimes, solve
from semianalytic.cut.load import Load
from semianalytic.cut.profile import Profile
from semianalytic.cut.quadrature.layout import Zone
from semianalytic.cut.zones import ZoneFields
from semianalytic.halfplane.rayleigh import rayleigh_factors
from semianalytic.halfplane.rules import rule_for
from semianalytic.reference import edge_speed_under_shear_step, slip_rate_under_shear_step
from semianalytic.regimes import Loading, one_zone, scene_of, stuck_threshold
from semianalytic.scene.errors import ComputationError
from semianalytic.selfsimilar.zones.tuning import CLEAR_OF_EDGES

RTOL = 1e-10


GRID_SCENES = (("preload", 1 / 3, 0.2), ("preload", 0.0, 0.1), ("remote", 1 / 3, 1.1))
ESTIMATE_SCENES = (
    ("preload", 1 / 3, 1.0),
    ("preload", 1 / 3, 0.2),
    ("preload", -0.5, 0.02),
    ("remote", 1 / 3, 1.25),
    ("remote", 1 / 3, 1.1),
)
RULE_POISSON_RATIOS = (-0.99, 0.0, 1 / 3, 0.499)
SIZES, LARGE_SIZES = (20, 40, 80, 160, 320, 640), (1000, 2000)
DEEPEST = 9
"""Poisson ratios approach their limits to 10 to the minus this."""


def solver_points(quick: bool) -> list[Point]:
    """Return all computations, each as the name of its function and the arguments of this."""
    loading, nu, chi = GRID_SCENES[0]
    large = () if quick else LARGE_SIZES
    points: list[Point] = [
        ("grid", *scene, size, placement, True)
        for size in SIZES[: 3 if quick else None]
        for scene in GRID_SCENES[: 1 if quick else None]
        for placement in grids.PLACEMENTS
    ]
    points += [("grid", loading, nu, chi, size, "galerkin", False) for size in large]
    points += [
        ("threshold", name, *scene)
        for name, scene in thresholds().items()
        if not quick or "1/3" in name
    ]
    depths = range(1, 4 if quick else DEEPEST + 1)
    points += [("limit", limit, depth) for limit in ("0.5", "0+", "0-", "-1") for depth in depths]
    points += [("estimate", *scene) for scene in ESTIMATE_SCENES[: 1 if quick else None]]
    points += [("rule", nu) for nu in RULE_POISSON_RATIOS]
    narrow = ("near c_R", "narrow gap")
    return [*points, *((kind, nu) for nu in RULE_POISSON_RATIOS[1:3] for kind in narrow)]


def solver_rows(kind: str, *arguments: Any) -> list[Row]:
    """Return the rows of one computation."""
    return COMPUTED[kind](*arguments)


def table(rows: list[Row]) -> list[Row]:
    """Return the rows in the order of the table."""
    names = ("study", "case", "method", "quantity", "parameter")
    return sorted(rows, key=lambda row: tuple(row[name] for name in names))


def _rows(
    study: str,
    case: str,
    parameter: float,
    values: Mapping[str, float],
    status: str = "converged",
    method: str = "solver",
) -> list[Row]:
    """Return a row for each measured value."""
    names = ("study", "case", "method", "parameter", "quantity", "value", "status")
    return [
        dict(zip(names, (study, case, method, parameter, *value, status), strict=True))
        for value in values.items()
    ]


def closed_form(poisson_ratio: float, chi: float) -> tuple[float, float]:
    """Return front [c_t] and edge slip rate of a preloaded interface with one slow zone."""
    material = Material(1.0, 1.0, poisson_ratio)
    edge_rate = float(slip_rate_under_shear_step(material, 1.0, chi, 0.0))
    return edge_speed_under_shear_step(material, chi), edge_rate


def attempt(loading: Loading, nu: float, chi: float, rtol: float) -> tuple[Solution | None, str]:
    """Return the solution and its status, or None and the message that says why there is none."""
    try:
        solution = solve(scene_of(loading, nu, chi), rtol=rtol)
        return solution, solution.status
    except ComputationError as error:
        return None, str(error)


def limit_rows(limit: str, exponent: int) -> list[Row]:
    """Solve scenes at a Poisson ratio 10^-exponent away from 0.5, 0 (either side) or -1."""
    distance = 10.0**-exponent
    nu = {"0.5": 0.5 - distance, "0+": distance, "0-": -distance, "-1": -1 + distance}[limit]
    rows: list[Row] = []
    range_of_slip = stuck_threshold(nu) - 1
    scenes: dict[str, tuple[Loading, float]] = {
        "preload, χ = 1": ("preload", 1.0),
        "preload, χ = 0.2": ("preload", 0.2),
        "remote, all slips": ("remote", 0.9),
        "remote, 30 %": ("remote", 1 + 0.3 * range_of_slip),
        "remote, 90 %": ("remote", 1 + 0.9 * range_of_slip),
    }
    for name, (loading, chi) in scenes.items():
        solution, status = attempt(loading, nu, chi, RTOL)
        values = {"error estimate": solution.error_estimate if solution else math.nan}
        if solution and name == "preload, χ = 1" and len(solution.zones) == 1:
            front, edge_rate = closed_form(nu, chi)
            values["edge error"] = abs(solution.zones[0].outer - front)
            values["slip rate error"] = abs(solution.edge_slip_rate / edge_rate - 1)
        rows += _rows(f"nu to {limit}", name, distance, values, status)
    return rows


def thresholds() -> dict[str, tuple[Loading, float, float]]:
    """Return frictions at which the set of zones changes: (loading, nu, chi) by name."""
    third, half = 1 / 3, -0.5
    edge, front = regimes.edge_threshold, regimes.nucleation
    reverse = regimes.reverse_threshold
    chosen: dict[str, tuple[Loading, float, float]] = {
        "edge slips, ν = 1/3": ("remote", third, edge(third)),
        "edge slips, ν = −0.5": ("remote", half, edge(half)),
        "front slips, stuck edge, ν = −0.5": ("remote", half, front("remote", half)),
        "front slips, remote, ν = 1/3": ("remote", third, front("remote", third)),
        "front slips, preload, ν = 1/3": ("preload", third, front("preload", third)),
        "reverse slip, ν = −0.5": ("preload", half, reverse(half)),
        "reverse slip, ν = −0.2": ("preload", -0.2, reverse(-0.2)),
        "all slips, ν = 1/3": ("remote", third, 1.0),
    }
    gap = regimes.gap_threshold("remote", third)
    if gap is not None:
        chosen["gap of 1e-14 at $c_R$, ν = 1/3"] = ("remote", third, gap)
    return chosen


def threshold_rows(name: str, loading: Loading, nu: float, chi: float) -> list[Row]:
    """Solve scenes at relative distances 10^-1.5 to 10^-10, and 0, on both sides of a threshold."""
    rows: list[Row] = []
    for signed in (*(s * 10.0**-k for s in (1, -1) for k in (1.5, *range(2, 11))), 0.0):
        solution, status = attempt(loading, nu, chi * (1 + signed), 1e-8)
        values = {"zones": math.nan}
        if solution:
            values = {"zones": len(solution.zones) * 1.0, "error estimate": solution.error_estimate}
            values["seconds"] = sum(solution.statistics.seconds.values())
        rows += _rows("threshold", name, signed, values, status)
    return rows


def grid_rows(
    loading: Loading, nu: float, chi: float, size: int, placement: str, active: bool
) -> list[Row]:
    """Solve the first stage on a grid; return error, odd-even mode, condition, pivots, rounds."""
    exact = solve(scene_of(loading, nu, chi), rtol=RTOL)
    problem = grids.grid_problem(loading, nu, chi, size, placement)
    xi = problem.xi
    beside = xi[1:] * (1 - 1e-9)  # a zone that covers c_R has a logarithm there, at a node
    rate = np.append(exact.edge_slip_rate, exact.slip_rate(beside, 1.0)) / 2
    rate[-1] = 0.0
    scale = np.sqrt(np.abs(np.diag(problem.matrix)))
    scaled = problem.matrix / scale / scale[:, None]
    symmetric = float(np.linalg.eigvalsh((scaled + scaled.T) / 2)[0])
    case, rows = f"{loading}, ν = {nu:.3g}, χ = {chi:g}", list[Row]()
    values = {"condition": float(np.linalg.cond(scaled)), "least eigenvalue": symmetric}
    methods = {"pivoting": grids.by_pivoting} | (
        {"active set": grids.by_active_set} if active else {}
    )
    for name, method in methods.items():
        answer = method(problem)
        values["rounds"] = answer.rounds
        if answer.status == "solved":
            values["slip rate error"] = relative_error(answer.slip_rate, rate, xi, 1)
            values["odd-even mode"] = grids.zigzag(xi, answer.slip_rate, rate)
        rows += _rows("grid", case, size, values, answer.status, f"{placement}, {name}")
        values = {}
    return rows


def rule_rows(nu: float) -> list[Row]:
    """Test quadrature rules on the closed form of one slow zone, chi = 1: balance and slip rate."""
    factors = rayleigh_factors(nu)
    front, exact = closed_form(nu, 1.0)
    edge = factors.beside("c", [1 / front - factors.c])
    load = Load(1.0, 1.0, 0.0, 0.0, 1.0, 0.0)
    rows: list[Row] = []
    for exponent in range(1, 15):
        fields = ZoneFields(factors, load, (Zone(edge, None, 1),), rule_for(10.0**-exponent))
        profile = Profile(fields)
        nodes = profile.panels.jacobian.size
        values = {
            "balance error": abs(float(fields.mismatch()[0])),
            "slip rate error": abs(2 * profile.edge_slip_rate / exact - 1),
            "tolerance": 10.0**-exponent,
        }
        rows += _rows("rule", f"ν = {nu:.3g}", nodes, values)
    return rows


def estimate_rows(loading: Loading, nu: float, chi: float) -> list[Row]:
    """Compare errors of edges and slip rate with the solver's estimate.

    The reference is a solution at 1e-12.  Slip rates are compared only at the distances from
    edges and c_R for which the estimate holds.
    """
    reference = solve(scene_of(loading, nu, chi), rtol=1e-12)
    case = f"{loading}, ν = {nu:.3g}, χ = {chi:g}"
    material = reference.scene.material
    speeds = np.linspace(0.013, 0.997, 311) * material.longitudinal_speed
    marks = np.append(reference.edge_speeds, material.rayleigh_speed)
    near = np.abs(speeds[:, None] - marks).min(axis=1) < CLEAR_OF_EDGES * material.shear_speed
    speeds = speeds[~near]
    rate = np.append(reference.slip_rate(speeds, 1.0), reference.edge_slip_rate)
    rows: list[Row] = []
    for exponent in range(2, 12):
        solution = solve(scene_of(loading, nu, chi), rtol=10.0**-exponent)
        if len(solution.zones) != len(reference.zones):
            continue
        edges = [
            abs(mine - theirs)
            for zone, other in zip(solution.zones, reference.zones, strict=True)
            for mine, theirs in ((zone.inner, other.inner), (zone.outer, other.outer))
            if mine != theirs
        ]
        other_rate = np.append(solution.slip_rate(speeds, 1.0), solution.edge_slip_rate)
        error = max([float(np.abs(other_rate - rate).max() / np.abs(rate).max()), *edges])
        values = {"true error": error, "error estimate": solution.error_estimate}
        rows += _rows("estimate", case, 10.0**-exponent, values, solution.status)
    return rows


def near_rayleigh_rows(nu: float) -> list[Row]:
    """Return relative errors of the impedance at c + d, from the Rayleigh polynomial, v and d."""
    factors = rayleigh_factors(nu)
    c, a = factors.c, factors.a
    rows: list[Row] = []
    for exponent in np.arange(1, 16.5, 0.5):
        d = 10.0**-exponent
        exact = float(factors.impedance_on_cut(factors.beside("c", [d])).imag[0])
        v = c + d
        z = v * v
        polynomial = 4 * z * math.sqrt(z - a * a) - (1 - 2 * z) ** 2 / math.sqrt(z - 1)
        by_slowness = float(factors.impedance_on_cut(factors.cut([v])).imag[0])
        for name, x in (("polynomial", polynomial), ("from v", by_slowness)):
            error = {"impedance error": abs(x / exact - 1)}
            rows += _rows("near c_R", f"ν = {nu:.3g}", d, error, method=name)
    return rows


def narrow_gap_rows(nu: float) -> list[Row]:
    """Compare the half-width of the stick gap at c_R with its closed form as the gap narrows."""
    rows: list[Row] = []
    for unknown in np.arange(1.0, -0.6, -0.2):
        front = regimes.past_rayleigh(nu, float(unknown))
        zone = one_zone("remote", nu, front)
        log_width = regimes.rayleigh_logarithm(zone).log_half_width
        solution, status = attempt("remote", nu, zone.chi, RTOL)
        if solution is None or len(solution.zones) != 2:
            continue
        slow, ahead = solution.profile.fields.zones
        inward, outward = ahead.left, slow.right
        assert inward is not None  # a gap between two zones has both edges
        assert outward is not None
        gap = float(inward.minus(outward)[0])
        half = math.exp(log_width)
        error = {"gap error": abs(gap / (4 * half) - 1)}
        rows += _rows("narrow gap", f"ν = {nu:.3g}", gap, error, status)
    return rows


COMPUTED: dict[str, Callable[..., list[Row]]] = {
    "grid": grid_rows,
    "threshold": threshold_rows,
    "limit": limit_rows,
    "estimate": estimate_rows,
    "rule": rule_rows,
    "near c_R": near_rayleigh_rows,
    "narrow gap": narrow_gap_rows,
}
