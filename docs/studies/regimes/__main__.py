"""Regimes of slip over Poisson ratio and friction: figures and tables of regimes.md and rate.md.

``python -m docs.studies.regimes --output docs --workers 2`` takes about two minutes.
"""

from __future__ import annotations

import math
from collections import Counter

import numpy as np

from docs.studies.regimes.figures import MAPS, openings_figure, viscosity_figure
from docs.studies.regimes.points import (
    AHEAD,
    POISSON_RATIOS,
    VISCOUS_DECADES,
    VISCOUS_RATIO,
    frictions,
    front_frictions,
    map_rows,
    middles,
    opening_row,
    opening_rows,
    trace,
    viscosity_row,
    viscous_rows,
)
from docs.studies.runner import Point, Row, Study, main
from semianalytic import Material
from semianalytic.reference import edge_speed_of_opening
from semianalytic.regimes import Loading, reverse_threshold
from semianalytic.regimes.reverse_slip import log_frictionless_half_width
from semianalytic.regimes.thresholds import (
    edge_threshold_alone,
    front_threshold_stuck,
    gap_threshold,
    nucleation,
    opening_threshold,
)

LOADINGS: tuple[Loading, ...] = ("preload", "remote")
SHOWN = (-0.5, 0.0, 1 / 3)
"""Poisson ratios of the panels of speeds."""
TABLED = (-0.9, -0.5, -0.2, 0.0, 0.2, 1 / 3, 0.4, 0.45)
REVERSED = (-0.9, -0.5, -0.2, 0.0, 0.2, 0.25, 0.3, 1 / 3, 0.4, 0.45)
VISCOSITIES = (1e-4, 1e-2, 0.1, 0.3, 1.0, 3.0, 10.0)


def map_points(quick: bool) -> list[Point]:
    """Return columns of both maps, panels of speeds, and traced curves."""
    size, fronts, traced = (10, 12, 8) if quick else (100, 144, 57)
    points: list[Point] = []
    for loading in LOADINGS:
        for nu in middles(*POISSON_RATIOS, size).tolist():
            points.append(("map", loading, nu, frictions(loading, nu, size)))
        for nu in SHOWN:
            chi = front_frictions(loading, nu, fronts)
            points += [("fronts", loading, nu, chi[i::6]) for i in range(6)]
        # denser where the gap of a preload narrows
        dense = np.linspace(0.47, POISSON_RATIOS[1], traced // 6 + 1)
        ratios = np.union1d(np.linspace(*POISSON_RATIOS, traced), dense)
        points += [("curves", loading, nu, []) for nu in ratios.tolist()]
    return points


def regime_rows(part: str, loading: Loading, nu: float, chi: list[float]) -> list[Row]:
    """Return the points of a column or panel, or those of the curves at a Poisson ratio."""
    return [trace(loading, nu)] if part == "curves" else map_rows(part, loading, nu, chi)


def counts(rows: list[Row]) -> list[Row]:
    """Return the number of points of each regime on both maps."""
    found = Counter((row["loading"], row["regime"]) for row in rows if row["part"] == "map")
    return [
        {"loading": loading, "regime": name, "points": number}
        for (loading, name), number in sorted(found.items())
    ]


def opening_points(quick: bool) -> list[Point]:
    """Return columns of the map of openings, and panels of their speeds."""
    size, count = (4, 9) if quick else (30, 60)
    mapped = [("map", nu, size) for nu in middles(*POISSON_RATIOS, size).tolist()]
    return [*mapped, *(("speeds", nu, count) for nu in SHOWN)]


def viscous_points(quick: bool) -> list[Point]:
    """Return columns of the map over viscosity, and curves at some Poisson ratios."""
    size, count = (6, 9) if quick else (32, 41)
    viscosities = (10 ** middles(*VISCOUS_DECADES, size)).tolist()
    ratios = (-0.2, 0.0, 0.2, VISCOUS_RATIO, 0.45)
    return [*(("map", one, size) for one in viscosities), *(("curves", nu, count) for nu in ratios)]


def threshold_row(nu: float) -> Row:
    """Return the frictions chi at which the regime changes; the gap is nan if it never closes."""
    gap = gap_threshold("remote", nu)
    return {
        "poisson_ratio": nu,
        "preload_nucleation": nucleation("preload", nu),
        "edge": edge_threshold_alone(nu),
        "stuck_front": front_threshold_stuck(nu),
        "remote_nucleation": nucleation("remote", nu),
        "gap": math.nan if gap is None else gap,
    }


def reverse_row(nu: float) -> Row:
    """Return the limit of reverse slip of a preload, and the half-width over c_R at no friction."""
    width = math.exp(log_frictionless_half_width(nu))
    return {"poisson_ratio": nu, "threshold": reverse_threshold(nu), "half_width": width}


def opening_table_row(nu: float) -> Row:
    """Return the base over the step below which the contact opens ahead, and ends of openings.

    These are over c_t: for half that base, and from the edge under a step of -1 base.
    """
    threshold = opening_threshold(nu)
    half = opening_row(nu, AHEAD, threshold / 2)
    return {
        "poisson_ratio": nu,
        "threshold": threshold,
        "inner": half["inner"],
        "outer": half["outer"],
        "from_edge": edge_speed_of_opening(Material(1.0, 1.0, nu), 1.0),
    }


def _no_table(rows: list[Row]) -> list[Row]:
    return []


STUDIES = [
    Study("regimes-map", map_points, regime_rows, counts, MAPS),
    Study("regimes-thresholds", lambda quick: [(nu,) for nu in TABLED], threshold_row),
    Study("regimes-reverse", lambda quick: [(nu,) for nu in REVERSED], reverse_row),
    Study("regimes-opening", lambda quick: [(nu,) for nu in TABLED], opening_table_row),
    Study(
        "regimes-viscosity",
        lambda quick: [(nu, one) for nu in (0.0, 1 / 3, 0.45) for one in VISCOSITIES],
        viscosity_row,
    ),
    Study(
        "openings-map",
        opening_points,
        opening_rows,
        _no_table,
        {"regimes_openings": openings_figure},
    ),
    Study(
        "viscosity-map",
        viscous_points,
        viscous_rows,
        _no_table,
        {"regimes_viscosity": viscosity_figure},
    ),
]

if __name__ == "__main__":
    raise SystemExit(main("docs.studies.regimes", STUDIES))
