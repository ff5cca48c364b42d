"""Studies of the losses of digits and the failures of the solver and of alternative methods.

Each function returns rows; for loadings and units see `semianalytic.regimes`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from compare.comparison.measures import relative_error
from compare.studies.stability.methods import (
    Array,
    GridAnswer,
    by_active_set,
    by_pivoting,
    grid_problem,
    zigzag,
)
from semianalytic import Material, Solution, regimes, solve
from semianalytic.cut.load import Load
from semianalytic.cut.profile import Profile
from semianalytic.cut.quadrature.layout import Zone
from semianalytic.cut.zones import ZoneFields
from semianalytic.halfplane.rayleigh import rayleigh_factors
from semianalytic.halfplane.rules import rule_for
from semianalytic.reference import (
    edge_speed_under_shear_step,
    slip_rate_under_shear_step,
)
from semianalytic.regimes import Loading, one_zone, scene_of, stuck_threshold
from semianalytic.scene.errors import ComputationError
from semianalytic.selfsimilar.zones.tuning import CLEAR_OF_EDGES

RTOL = 1e-10


@dataclass(frozen=True)
class StudyRow:
    """One measured value.

    Attributes
    ----------
    study, case, method : str
        Study, its scene or limit, and the solution method.
    parameter : float
        Varied parameter: a distance from a limit, a number of nodes, a tolerance.
    quantity : str
        Name of the measured quantity.
    value : float
        Measured value.
    status : str
        Status at the end of the computation.
    """

    study: str
    case: str
    method: str
    parameter: float
    quantity: str
    value: float
    status: str = "converged"


def closed_form(poisson_ratio: float, chi: float) -> tuple[float, float]:
    """Return front [c_t] and edge slip rate of a preloaded interface with one slow zone."""
    material = Material(1.0, 1.0, poisson_ratio)
    edge_rate = float(slip_rate_under_shear_step(material, 1.0, chi, 0.0))
    return edge_speed_under_shear_step(material, chi), edge_rate


def attempt(loading: Loading, poisson_ratio: float, chi: float, rtol: float) -> Solution | str:
    """Return the solution, or the message that says why there is none."""
    try:
        return solve(scene_of(loading, poisson_ratio, chi), rtol=rtol)
    except ComputationError as error:
        return str(error)


def limit_rows(limit: str, exponent: int) -> list[StudyRow]:
    """Solve scenes at a Poisson ratio 10^-exponent away from 0.5, 0 (either side) or -1."""
    distance = 10.0**-exponent
    nu = {"0.5": 0.5 - distance, "0+": distance, "0-": -distance, "-1": -1 + distance}[limit]
    rows = []
    shares = {"remote, 30 %": 0.3, "remote, 90 %": 0.9}
    scenes: dict[str, tuple[Loading, float]] = {
        "preload, χ = 1": ("preload", 1.0),
        "preload, χ = 0.2": ("preload", 0.2),
        "remote, all slips": ("remote", 0.9),
    }
    for name, share in shares.items():
        scenes[name] = ("remote", 1 + share * (stuck_threshold(nu) - 1))
    for name, (loading, chi) in scenes.items():
        solution = attempt(loading, nu, chi, RTOL)
        values = {"error estimate": math.nan}
        status = solution if isinstance(solution, str) else solution.status
        if isinstance(solution, Solution):
            values["error estimate"] = solution.error_estimate
            if name == "preload, χ = 1" and len(solution.zones) == 1:
                front, edge_rate = closed_form(nu, chi)
                values["edge error"] = abs(solution.zones[0].outer - front)
                values["slip rate error"] = abs(solution.edge_slip_rate / edge_rate - 1)
        rows += [
            StudyRow(f"nu to {limit}", name, "solver", distance, quantity, value, status)
            for quantity, value in values.items()
        ]
    return rows


def thresholds() -> dict[str, tuple[Loading, float, float]]:
    """Return frictions at which the set of zones changes: (loading, nu, chi) by name."""
    third, half = 1 / 3, -0.5
    chosen: dict[str, tuple[Loading, float, float]] = {
        "edge slips, ν = 1/3": ("remote", third, regimes.edge_threshold(third)),
        "edge slips, ν = −0.5": ("remote", half, regimes.edge_threshold(half)),
        "front slips, stuck edge, ν = −0.5": (
            "remote",
            half,
            regimes.nucleation("remote", half),
        ),
        "front slips, remote, ν = 1/3": ("remote", third, regimes.nucleation("remote", third)),
        "front slips, preload, ν = 1/3": (
            "preload",
            third,
            regimes.nucleation("preload", third),
        ),
        "reverse slip, ν = −0.5": ("preload", half, regimes.reverse_threshold(half)),
        "reverse slip, ν = −0.2": ("preload", -0.2, regimes.reverse_threshold(-0.2)),
        "all slips, ν = 1/3": ("remote", third, 1.0),
    }
    gap = regimes.gap_threshold("remote", third)
    if gap is not None:
        chosen["gap of 1e-14 at $c_R$, ν = 1/3"] = ("remote", third, gap)
    return chosen


def threshold_rows(name: str, loading: Loading, nu: float, chi: float) -> list[StudyRow]:
    """Solve scenes at relative distances 10^-1.5 to 10^-10, and 0, on both sides of a threshold."""
    rows = []
    for signed in (*(s * 10.0**-k for s in (1, -1) for k in (1.5, *range(2, 11))), 0.0):
        solution = attempt(loading, nu, chi * (1 + signed), 1e-8)
        if isinstance(solution, str):
            rows.append(StudyRow("threshold", name, "solver", signed, "zones", math.nan, solution))
            continue
        values = {"zones": len(solution.zones), "error estimate": solution.error_estimate}
        values["seconds"] = sum(solution.statistics.seconds.values())
        rows += [
            StudyRow("threshold", name, "solver", signed, quantity, float(value), solution.status)
            for quantity, value in values.items()
        ]
    return rows


def grid_rows(
    loading: Loading, nu: float, chi: float, size: int, placement: str, active: bool
) -> list[StudyRow]:
    """Solve the first stage on a grid; return error, odd-even mode, condition, pivots, rounds."""
    exact = solve(scene_of(loading, nu, chi), rtol=RTOL)
    problem = grid_problem(loading, nu, chi, size, placement)
    xi = problem.xi
    beside = xi[1:] * (1 - 1e-9)  # a zone that covers c_R has a logarithm there, at a node
    rate = np.append(exact.edge_slip_rate, exact.slip_rate(beside, 1.0)) / 2
    rate[-1] = 0.0
    scale = np.sqrt(np.abs(np.diag(problem.matrix)))
    scaled = problem.matrix / scale / scale[:, None]
    symmetric = float(np.linalg.eigvalsh((scaled + scaled.T) / 2)[0])
    case = f"{loading}, ν = {nu:.3g}, χ = {chi:g}"
    pivoted = by_pivoting(problem)
    values = {
        "condition": float(np.linalg.cond(scaled)),
        "least eigenvalue": symmetric,
        "rounds": pivoted.rounds,
        **_errors(xi, pivoted, rate),
    }
    rows = [
        StudyRow("grid", case, f"{placement}, pivoting", size, quantity, value, pivoted.status)
        for quantity, value in values.items()
    ]
    if active:
        other = by_active_set(problem)
        values = {"rounds": other.rounds, **_errors(xi, other, rate)}
        rows += [
            StudyRow("grid", case, f"{placement}, active set", size, quantity, value, other.status)
            for quantity, value in values.items()
        ]
    return rows


def _errors(xi: Array, answer: GridAnswer, exact: Array) -> dict[str, float]:
    """Return the relative mean error and odd-even mode of slip rates on a grid."""
    if answer.status != "solved":
        return {}
    error = relative_error(answer.slip_rate, exact, xi, 1)
    return {"slip rate error": error, "odd-even mode": zigzag(xi, answer.slip_rate, exact)}


def rule_rows(nu: float) -> list[StudyRow]:
    """Test quadrature rules on the closed form of one slow zone, chi = 1: balance and slip rate."""
    factors = rayleigh_factors(nu)
    front, exact = closed_form(nu, 1.0)
    edge = factors.beside("c", [1 / front - factors.c])
    load = Load(1.0, 1.0, 0.0, 0.0, 1.0, 0.0)
    rows = []
    for exponent in range(1, 15):
        fields = ZoneFields(factors, load, (Zone(edge, None, 1),), rule_for(10.0**-exponent))
        profile = Profile(fields)
        nodes = profile.panels.jacobian.size
        values = {
            "balance error": abs(float(fields.mismatch()[0])),
            "slip rate error": abs(2 * profile.edge_slip_rate / exact - 1),
            "tolerance": 10.0**-exponent,
        }
        rows += [
            StudyRow("rule", f"ν = {nu:.3g}", "solver", nodes, quantity, value)
            for quantity, value in values.items()
        ]
    return rows


def estimate_rows(loading: Loading, nu: float, chi: float) -> list[StudyRow]:
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
    rows = []
    for exponent in range(2, 12):
        solution = solve(scene_of(loading, nu, chi), rtol=10.0**-exponent)
        if len(solution.zones) != len(reference.zones):
            continue
        edges = [
            abs(mine - theirs)
            for one, other in zip(solution.zones, reference.zones, strict=True)
            for mine, theirs in ((one.inner, other.inner), (one.outer, other.outer))
            if mine != theirs
        ]
        other_rate = np.append(solution.slip_rate(speeds, 1.0), solution.edge_slip_rate)
        error = max([float(np.abs(other_rate - rate).max() / np.abs(rate).max()), *edges])
        values = {"true error": error, "error estimate": solution.error_estimate}
        rows += [
            StudyRow("estimate", case, "solver", 10.0**-exponent, name, value, solution.status)
            for name, value in values.items()
        ]
    return rows


def near_rayleigh_rows(nu: float) -> list[StudyRow]:
    """Return relative errors of the impedance at c + d, from the Rayleigh polynomial, v and d."""
    factors = rayleigh_factors(nu)
    c, a = factors.c, factors.a
    rows = []
    for exponent in np.arange(1, 16.5, 0.5):
        d = 10.0**-exponent
        exact = float(factors.impedance_on_cut(factors.beside("c", [d])).imag[0])
        v = c + d
        z = v * v
        polynomial = 4 * z * math.sqrt(z - a * a) - (1 - 2 * z) ** 2 / math.sqrt(z - 1)
        by_slowness = float(factors.impedance_on_cut(factors.cut([v])).imag[0])
        values = {"polynomial": polynomial, "from v": by_slowness}
        rows += [
            StudyRow("near c_R", f"ν = {nu:.3g}", name, d, "impedance error", abs(x / exact - 1))
            for name, x in values.items()
        ]
    return rows


def narrow_gap_rows(nu: float) -> list[StudyRow]:
    """Compare the half-width of the stick gap at c_R with its closed form as the gap narrows."""
    rows = []
    for unknown in np.arange(1.0, -0.6, -0.2):
        front = regimes.past_rayleigh(nu, float(unknown))
        zone = one_zone("remote", nu, front)
        log_width = regimes.rayleigh_logarithm(zone).log_half_width
        solution = attempt("remote", nu, zone.chi, RTOL)
        if isinstance(solution, str) or len(solution.zones) != 2:
            continue
        slow, ahead = solution.profile.fields.zones
        inward, outward = ahead.left, slow.right
        assert inward is not None  # a gap between two zones has both edges
        assert outward is not None
        gap = float(inward.minus(outward)[0])
        half = math.exp(log_width)
        values = {"gap error": abs(gap / (4 * half) - 1)}
        rows += [
            StudyRow("narrow gap", f"ν = {nu:.3g}", "solver", gap, name, value, solution.status)
            for name, value in values.items()
        ]
    return rows
