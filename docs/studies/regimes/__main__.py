"""Regimes of slip over Poisson ratio and friction: figures and tables of regimes.md and rate.md.

``python -m docs.studies.regimes --output docs --workers 2`` takes about two minutes.  For loadings
and units see `semianalytic.regimes`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from docs.studies.regimes import figures
from docs.studies.runner import Point, Row, Study, main, number
from semianalytic import Coulomb, Material, Scene, Solution, Tractions, regimes, solve
from semianalytic.reference import edge_speed_of_opening
from semianalytic.regimes import Loading, regime, scene_of, stuck_threshold, thresholds
from semianalytic.regimes.reverse_slip import log_frictionless_half_width
from semianalytic.scene.errors import ComputationError
from semianalytic.sweeps.sweep import sweep

RTOL = 1e-8
LOADINGS: tuple[Loading, ...] = ("preload", "remote")
SHOWN = (-0.5, 0.0, 1 / 3)
"""Poisson ratios of the panels of speeds."""
TABLED = (-0.9, -0.5, -0.2, 0.0, 0.2, 1 / 3, 0.4, 0.45)
REVERSED = (-0.9, -0.5, -0.2, 0.0, 0.2, 0.25, 0.3, 1 / 3, 0.4, 0.45)
VISCOSITIES = (1e-4, 1e-2, 0.1, 0.3, 1.0, 3.0, 10.0)


def middles(low: float, high: float, count: int) -> NDArray[np.float64]:
    """Return the centres of equal cells."""
    return low + (high - low) * (np.arange(count) + 0.5) / count


def frictions(part: str, loading: Loading, poisson_ratio: float, count: int) -> list[float]:
    """Return the frictions chi of a map's column, or of a panel of front speeds, ascending.

    For a preload they have equal steps of log chi, in a map from 1e-3 to 1.  For a remote load they
    have equal steps from slightly below 1, where the whole contact slips, to slightly above the
    friction at which nothing slips.
    """
    mapped, stuck = part == "map", stuck_threshold(poisson_ratio)
    if loading == "preload":
        chi = 10.0 ** (middles(-3.0, 0.0, count) if mapped else np.linspace(-3, 0.5, count))
    elif mapped:
        chi = 1 + middles(-0.1, 1.1, count) * (stuck - 1)
    else:
        chi = np.linspace(0.98, 1.02 * stuck, count)
    return list(chi.tolist())


def map_rows(part: str, loading: Loading, poisson_ratio: float, chi: Sequence[float]) -> list[Row]:
    """Solve points of given frictions in one sweep, or one by one if the sweep fails; of curves
    return those at a Poisson ratio."""
    if part == "curves":
        return [trace(loading, poisson_ratio)]
    found: list[Solution | None]
    try:
        found = [*sweep(scene_of(loading, poisson_ratio, chi[0]), chi, RTOL).solutions]
    except ComputationError:
        found = [None] * len(chi)
        for i, ratio in enumerate(chi):
            with suppress(ComputationError):
                found[i] = solve(scene_of(loading, poisson_ratio, ratio), rtol=RTOL)
    rows: list[Row] = []
    for ratio, solution in zip(chi, found, strict=True):
        row: Row = {"part": part, "loading": loading, "poisson_ratio": poisson_ratio, "chi": ratio}
        row |= {"regime": "failed", "zones": [], "error_estimate": math.inf}
        if solution is not None:
            speed = solution.scene.material.shear_speed
            name = regime(solution) if solution.status == "converged" else "failed"
            zones = [[z.inner / speed, z.outer / speed, z.sense] for z in solution.zones]
            row |= {"regime": name, "zones": zones, "error_estimate": solution.error_estimate}
        rows.append(row)
    return rows


def trace(loading: Loading, poisson_ratio: float) -> Row:
    """Return log10 of chi on all boundary curves at one Poisson ratio; None where there is none.

    "gap" is None if the gap at c_R never gets that narrow.
    """
    gap = regimes.gap_threshold(loading, poisson_ratio)
    row: Row = {"part": "curves", "loading": loading, "poisson_ratio": poisson_ratio}
    row["nucleation"] = math.log10(regimes.nucleation(loading, poisson_ratio))
    row["gap"] = None if gap is None else math.log10(gap)
    if loading == "remote":
        row["edge"] = math.log10(regimes.edge_threshold(poisson_ratio))
        return row | {"everywhere": 0.0}
    return row | {"reverse": math.log10(regimes.reverse_threshold(poisson_ratio))}


def opening_row(poisson_ratio: float, sign: int, ratio: float) -> Row:
    """Solve for the opening under a unit step of pressure of a sign, with a base P_b / |P_0|.

    Its ends are over c_t, and 0 if the contact stays closed.
    """
    material = Material(1.0, 1.0, poisson_ratio)
    scene = Scene(material, 0.0, Tractions(ratio, 0.0), Tractions(float(sign), 0.0))
    openings = solve(scene, rtol=RTOL).openings
    inner, outer = (openings[0].inner, openings[0].outer) if openings else (0.0, 0.0)
    row: Row = {"poisson_ratio": poisson_ratio, "sign": sign, "ratio": ratio}
    return row | {"inner": inner, "outer": outer}


def opening_rows(part: str, poisson_ratio: float, count: int) -> list[Row]:
    """Return a column of the map of openings, or the points of a panel of their speeds.

    These are for both signs, and dense at the threshold.
    """
    ratios = [(figures.AHEAD, 10 ** middles(*figures.OPENING_DECADES, count))]
    if part == "speeds":
        threshold = regimes.opening_threshold(poisson_ratio)
        below = np.geomspace(
            10.0 ** figures.OPENING_DECADES[0], threshold, count // 3, endpoint=False
        )
        near = threshold * (1 - np.geomspace(1e-4, 0.3, count // 3))
        ratios = [(figures.AHEAD, np.union1d(below, near))]
        ratios += [(figures.EDGE, np.logspace(*figures.OPENING_DECADES, count // 3))]
    return [
        {"part": part} | opening_row(poisson_ratio, sign, ratio)
        for sign, several in ratios
        for ratio in several.tolist()
    ]


def viscosity_row(poisson_ratio: float, viscosity: float) -> Row:
    """Return frictions of a preload below which the front slips, and below which slip covers c_R.

    The second is nan if slip never covers c_R; viscosity is over rho c_t / 2.
    """
    return {
        "poisson_ratio": poisson_ratio,
        "viscosity": viscosity,
        "nucleation": regimes.nucleation("preload", poisson_ratio, viscosity),
        "closing": number(regimes.viscous_closing(poisson_ratio, viscosity)),
    }


def viscous_rows(part: str, value: float, count: int) -> list[Row]:
    """Return a column of the map over viscosity and friction, or curves at a Poisson ratio."""
    if part == "curves":
        several = np.logspace(*figures.VISCOUS_DECADES, count).tolist()
        return [{"part": part} | viscosity_row(value, viscosity) for viscosity in several]
    rows: list[Row] = []
    for chi in middles(0.0, figures.VISCOUS_FRICTION, count).tolist():
        scene = scene_of("preload", figures.VISCOUS_RATIO, chi)
        film = value * scene.material.shear_impedance / 2
        law = Coulomb(scene.coefficient, viscosity=film)
        name = regime(solve(replace(scene, friction=law), rtol=1e-6))
        rows.append({"part": part, "viscosity": value, "chi": chi, "regime": name})
    return rows


def map_points(quick: bool) -> list[Point]:
    """Return columns of both maps, panels of speeds, and traced curves."""
    size, fronts, traced = (10, 12, 8) if quick else (100, 144, 57)
    points: list[Point] = []
    for loading in LOADINGS:
        for nu in middles(*figures.POISSON_RATIOS, size).tolist():
            points.append(("map", loading, nu, frictions("map", loading, nu, size)))
        for nu in SHOWN:
            chi = frictions("fronts", loading, nu, fronts)
            points += [("fronts", loading, nu, chi[i::6]) for i in range(6)]
        # denser where the gap of a preload narrows
        dense = np.linspace(0.47, figures.POISSON_RATIOS[1], traced // 6 + 1)
        ratios = np.union1d(np.linspace(*figures.POISSON_RATIOS, traced), dense)
        points += [("curves", loading, nu, []) for nu in ratios.tolist()]
    return points


def opening_points(quick: bool) -> list[Point]:
    """Return columns of the map of openings, and panels of their speeds."""
    size, count = (4, 9) if quick else (30, 60)
    mapped = [("map", nu, size) for nu in middles(*figures.POISSON_RATIOS, size).tolist()]
    return [*mapped, *(("speeds", nu, count) for nu in SHOWN)]


def viscous_points(quick: bool) -> list[Point]:
    """Return columns of the map over viscosity, and curves at some Poisson ratios."""
    size, count = (6, 9) if quick else (32, 41)
    viscosities = (10 ** middles(*figures.VISCOUS_DECADES, size)).tolist()
    ratios = (-0.2, 0.0, 0.2, figures.VISCOUS_RATIO, 0.45)
    return [*(("map", eta, size) for eta in viscosities), *(("curves", nu, count) for nu in ratios)]


def threshold_row(nu: float) -> Row:
    """Return the frictions chi at which the regime changes; the gap is nan if it never closes."""
    return {
        "poisson_ratio": nu,
        "preload_nucleation": regimes.nucleation("preload", nu),
        "edge": thresholds.edge_threshold_alone(nu),
        "stuck_front": thresholds.front_threshold_stuck(nu),
        "remote_nucleation": regimes.nucleation("remote", nu),
        "gap": number(regimes.gap_threshold("remote", nu)),
    }


def reverse_row(nu: float) -> Row:
    """Return the limit of reverse slip of a preload, and the half-width over c_R at no friction."""
    width = math.exp(log_frictionless_half_width(nu))
    return {"poisson_ratio": nu, "threshold": regimes.reverse_threshold(nu), "half_width": width}


def opening_table_row(nu: float) -> Row:
    """Return the base over the step below which the contact opens ahead, and ends of openings.

    These are over c_t: for half that base, and from the edge under a step of -1 base.
    """
    threshold = regimes.opening_threshold(nu)
    half = opening_row(nu, figures.AHEAD, threshold / 2)
    return {
        "poisson_ratio": nu,
        "threshold": threshold,
        "inner": half["inner"],
        "outer": half["outer"],
        "from_edge": edge_speed_of_opening(Material(1.0, 1.0, nu), 1.0),
    }


STUDIES = [
    Study("regimes-map", map_points, map_rows, lambda rows: [], figures.MAPS),
    Study("regimes-thresholds", lambda quick: [(nu,) for nu in TABLED], threshold_row),
    Study("regimes-reverse", lambda quick: [(nu,) for nu in REVERSED], reverse_row),
    Study("regimes-opening", lambda quick: [(nu,) for nu in TABLED], opening_table_row),
    Study(
        "regimes-viscosity",
        lambda quick: [(nu, viscosity) for nu in (0.0, 1 / 3, 0.45) for viscosity in VISCOSITIES],
        viscosity_row,
    ),
    Study(
        "openings-map",
        opening_points,
        opening_rows,
        lambda rows: [],
        {"regimes_openings": figures.openings_figure},
    ),
    Study(
        "viscosity-map",
        viscous_points,
        viscous_rows,
        lambda rows: [],
        {"regimes_viscosity": figures.viscosity_figure},
    ),
]

if __name__ == "__main__":
    raise SystemExit(main("docs.studies.regimes", STUDIES))
