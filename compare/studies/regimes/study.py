"""Slip regimes over Poisson ratio and friction: maps, boundaries, and front speeds.

`write_regimes` maps the regimes of two loadings over (nu, chi), traces the curves between them, and
writes figures and tables.  For loadings and units see `semianalytic.regimes`.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, get_args

import numpy as np

from compare.figures.saving import save_figure
from compare.output.tables import append_rows, write_rows
from compare.studies.regimes.figures import (
    RegimeResults,
    front_speeds_figure,
    regimes_figure,
    reverse_figure,
)
from compare.studies.regimes.openings import (
    OpeningPoint,
    opening_column,
    opening_speeds,
    openings_figure,
    sorted_openings,
)
from compare.studies.regimes.points import (
    POISSON_RATIOS,
    BoundaryPoint,
    MapPoint,
    kept_columns,
    map_column,
    map_points,
    poisson_ratios,
    sorted_points,
    trace,
)
from compare.tasks.workers import Progress, Task, run_tasks
from semianalytic.regimes import Loading, reverse_threshold, stuck_threshold
from semianalytic.scene.checks import checked_count
from semianalytic.scene.errors import SceneError

FRONT_POISSON_RATIOS = (-0.5, 0.0, 1 / 3)
REVERSE_POISSON_RATIOS = (-0.5, -0.2, 0.0)
_QUICK_SIZE = 10
_COUNTS = {False: (57, 144, 33), True: (8, 12, 5)}
"""Numbers of traced Poisson ratios, and of frictions per panel of speeds and of reverse slip."""
_OPENING_COUNTS = {False: (30, 60), True: (4, 9)}
"""Numbers of points along either axis of the map of openings, and per panel of their speeds."""


def front_frictions(loading: Loading, poisson_ratio: float, count: int) -> list[float]:
    """Return the frictions chi of one panel of the figure of front speeds."""
    if loading == "preload":
        return (10.0 ** np.linspace(-3, 0.5, count)).tolist()
    return np.linspace(0.98, 1.02 * stuck_threshold(poisson_ratio), count).tolist()


def reverse_points(poisson_ratio: float, count: int) -> list[MapPoint]:
    """Solve preloaded scenes with frictions from 1/30 to almost 1 of the limit of reverse slip."""
    threshold = reverse_threshold(poisson_ratio)
    return map_points(
        "preload", poisson_ratio, (threshold * np.geomspace(1 / 30, 0.98, count)).tolist()
    )


def write_regimes(
    output: Path,
    size: int = 100,
    loading: str = "both",
    quick: bool = False,
    progress: Progress | None = None,
    form: str = "png",
    client: Any = None,
) -> RegimeResults:
    """Map regimes on size x size points, trace their boundaries, and write figures and CSV files.

    The files are regimes-LOADING.csv and .png (or in another `form`), boundaries.csv,
    front-speeds.csv and .png, for the preload reverse-slip.csv and .png, and openings.csv and .png.
    If `quick`, there are fewer points.  Finished columns of a map are kept in a hidden file, from
    which an interrupted run continues when it is started again with the same size.

    Raises
    ------
    SceneError
        If size (at least 2) or loading ("both", "preload" or "remote") is out of range.
    DataFileError
        If a file cannot be written.
    ComputationError
        If a boundary cannot be traced.
    """
    known = get_args(Loading)
    if loading not in (*known, "both"):
        raise SceneError(f"loading must be one of both, {', '.join(known)}, got {loading!r}.")
    size = checked_count("regimes: size", size, 2, "a whole number from")
    count = min(size, _QUICK_SIZE) if quick else size
    loadings: list[Loading] = [name for name in known if loading in (name, "both")]
    output.mkdir(parents=True, exist_ok=True)
    results = _computed(output, loadings, count, quick, progress, client)
    for name in loadings:
        write_rows(output / f"regimes-{name}.csv", results.points[name])
        save_figure(regimes_figure(name, results), output / f"regimes-{name}.{form}")
        _part(output, name, count).unlink(missing_ok=True)
    write_rows(output / "boundaries.csv", results.curves)
    write_rows(output / "front-speeds.csv", results.fronts)
    save_figure(front_speeds_figure(results), output / f"front-speeds.{form}")
    if "preload" in loadings:
        write_rows(output / "reverse-slip.csv", results.reverse)
        save_figure(reverse_figure(results), output / f"reverse-slip.{form}")
    columns, speeds = _openings(quick, client)
    write_rows(output / "openings.csv", [*columns, *speeds])
    save_figure(openings_figure(columns, speeds), output / f"openings.{form}")
    return results


def _openings(quick: bool, client: Any) -> tuple[list[OpeningPoint], list[OpeningPoint]]:
    """Solve openings under a step of pressure: points of the map, and of the panels of speeds."""
    size, count = _OPENING_COUNTS[quick]
    columns = [(opening_column, (nu, size)) for nu in poisson_ratios(size).tolist()]
    speeds = [(opening_speeds, (nu, count)) for nu in FRONT_POISSON_RATIOS]
    parts: tuple[list[OpeningPoint], list[OpeningPoint]] = ([], [])
    for index, points in run_tasks([*columns, *speeds], client=client):
        parts[index >= size].extend(points)
    return sorted_openings(parts[0]), sorted_openings(parts[1])


def _part(output: Path, loading: Loading, count: int) -> Path:
    return output / f".regimes-{loading}-{count}.csv.part"


def _traced_ratios(count: int) -> list[float]:
    """Return Poisson ratios at which to trace curves, denser where the gap of a preload narrows."""
    whole = np.linspace(*POISSON_RATIOS, count)
    return np.union1d(whole, np.linspace(0.47, POISSON_RATIOS[1], count // 6 + 1)).tolist()


def _computed(
    output: Path,
    loadings: Sequence[Loading],
    count: int,
    quick: bool,
    progress: Progress | None,
    client: Any,
) -> RegimeResults:
    traced, shown, within = _COUNTS[quick]
    kept = {name: kept_columns(_part(output, name, count), name, count) for name in loadings}
    curves: list[BoundaryPoint] = []
    fronts: list[MapPoint] = []
    reverse: list[MapPoint] = []
    columns: list[MapPoint] = []
    tasks: list[tuple[list, Task]] = []
    for name in loadings:
        for nu in _traced_ratios(traced):
            tasks.append((curves, (trace, (name, nu))))
        for nu in FRONT_POISSON_RATIOS:
            chi = front_frictions(name, nu, shown)
            tasks += [(fronts, (map_points, (name, nu, chi[i::6]))) for i in range(6)]
        if name == "preload":
            tasks += [(reverse, (reverse_points, (nu, within))) for nu in REVERSE_POISSON_RATIOS]
        for nu in poisson_ratios(count).tolist():
            if nu not in kept[name]:
                tasks.append((columns, (map_column, (name, nu, count))))
    for index, result in run_tasks([task for _, task in tasks], progress=progress, client=client):
        destination = tasks[index][0]
        destination += result
        if destination is columns:
            append_rows(_part(output, result[0].loading, count), result)
    points = {
        name: sorted_points(
            [point for rows in kept[name].values() for point in rows]
            + [point for point in columns if point.loading == name]
        )
        for name in loadings
    }
    curves.sort(key=lambda point: (point.loading, point.curve, point.poisson_ratio))
    return RegimeResults(points, curves, sorted_points(fronts), sorted_points(reverse))
