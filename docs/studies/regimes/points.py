"""Points of maps of regimes, traced curves between them, and openings, as rows.

For loadings and units see `semianalytic.regimes`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from docs.studies.runner import Row
from semianalytic import Material, Scene, Solution, Tractions, ViscousFriction, regimes, solve
from semianalytic.regimes import Loading, regime, scene_of, stuck_threshold
from semianalytic.scene.errors import ComputationError
from semianalytic.sweeps.sweep import sweep

POISSON_RATIOS = (-0.9, 0.49)
RTOL = 1e-8
AHEAD, EDGE = 1, -1
"""Signs of a step of pressure P_0: the contact opens ahead of the edge, or from the edge."""
OPENING_DECADES = (-3.0, 0.5)
"""Logarithms to base 10 of the smallest and the largest P_b / |P_0|."""
VISCOUS_RATIO, VISCOUS_DECADES, VISCOUS_FRICTION = 1 / 3, (-6.0, 2.0), 0.4
"""Poisson ratio, viscosities and largest friction of the map over viscosity."""


def middles(low: float, high: float, count: int) -> NDArray[np.float64]:
    """Return the centres of equal cells."""
    return low + (high - low) * (np.arange(count) + 0.5) / count


def frictions(loading: Loading, poisson_ratio: float, count: int) -> list[float]:
    """Return the frictions chi of a map's column, ascending.

    For a preload they have equal steps of log chi from 1e-3 to 1.  For a remote load they have
    equal steps from slightly below 1, where the whole contact slips, to slightly above the friction
    at which nothing slips.
    """
    if loading == "preload":
        return list((10.0 ** middles(-3.0, 0.0, count)).tolist())
    stuck = stuck_threshold(poisson_ratio)
    return list((1 + middles(-0.1, 1.1, count) * (stuck - 1)).tolist())


def front_frictions(loading: Loading, poisson_ratio: float, count: int) -> list[float]:
    """Return the frictions chi of one panel of the figure of front speeds."""
    if loading == "preload":
        return list((10.0 ** np.linspace(-3, 0.5, count)).tolist())
    return list(np.linspace(0.98, 1.02 * stuck_threshold(poisson_ratio), count).tolist())


def map_rows(part: str, loading: Loading, poisson_ratio: float, chi: Sequence[float]) -> list[Row]:
    """Solve points of given frictions in one sweep, or one by one if the sweep fails."""
    try:
        swept = sweep(scene_of(loading, poisson_ratio, chi[0]), chi, RTOL).solutions
        return [_map_row(part, loading, poisson_ratio, solution) for solution in swept]
    except ComputationError:
        return [_map_row(part, loading, poisson_ratio, one) for one in chi]


def _map_row(part: str, loading: Loading, nu: float, answer: Solution | float) -> Row:
    """Return the row of a solution, or of a friction for which there may be none."""
    row: Row = {"part": part, "loading": loading, "poisson_ratio": nu}
    if not isinstance(answer, Solution):
        try:
            found: Solution = solve(scene_of(loading, nu, answer), rtol=RTOL)
        except ComputationError:
            return row | {
                "chi": answer,
                "regime": "failed",
                "zones": [],
                "error_estimate": math.inf,
            }
    else:
        found = answer
    speed = found.scene.material.shear_speed
    return row | {
        "chi": found.scene.friction,
        "regime": regime(found) if found.status == "converged" else "failed",
        "zones": [[one.inner / speed, one.outer / speed, one.sense] for one in found.zones],
        "error_estimate": found.error_estimate,
    }


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
    ratios = [(AHEAD, 10 ** middles(*OPENING_DECADES, count))]
    if part == "speeds":
        threshold = regimes.opening_threshold(poisson_ratio)
        below = np.geomspace(10.0 ** OPENING_DECADES[0], threshold, count // 3, endpoint=False)
        near = threshold * (1 - np.geomspace(1e-4, 0.3, count // 3))
        ratios = [(AHEAD, np.union1d(below, near))]
        ratios += [(EDGE, np.logspace(*OPENING_DECADES, count // 3))]
    return [
        {"part": part} | opening_row(poisson_ratio, sign, ratio)
        for sign, several in ratios
        for ratio in several.tolist()
    ]


def viscosity_row(poisson_ratio: float, viscosity: float) -> Row:
    """Return frictions of a preload below which the front slips, and below which slip covers c_R.

    The second is nan if slip never covers c_R; viscosity is over rho c_t / 2.
    """
    closing = regimes.viscous_closing(poisson_ratio, viscosity)
    return {
        "poisson_ratio": poisson_ratio,
        "viscosity": viscosity,
        "nucleation": regimes.viscous_nucleation(poisson_ratio, viscosity),
        "closing": math.nan if closing is None else closing,
    }


def viscous_rows(part: str, value: float, count: int) -> list[Row]:
    """Return a column of the map over viscosity and friction, or curves at a Poisson ratio."""
    if part == "curves":
        several = np.logspace(*VISCOUS_DECADES, count).tolist()
        return [{"part": part} | viscosity_row(value, viscosity) for viscosity in several]
    rows: list[Row] = []
    for chi in middles(0.0, VISCOUS_FRICTION, count).tolist():
        scene = scene_of("preload", VISCOUS_RATIO, chi)
        law = ViscousFriction(value * scene.material.shear_impedance / 2)
        name = regime(solve(replace(scene, friction_law=law), rtol=1e-6))
        rows.append({"part": part, "viscosity": value, "chi": chi, "regime": name})
    return rows
