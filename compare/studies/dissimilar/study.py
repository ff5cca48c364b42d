"""Map of growing waves over contrast and friction: a figure and two tables."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from compare.figures.saving import save_figure
from compare.output.tables import write_rows
from compare.studies.dissimilar.figure import growth_figure
from compare.studies.dissimilar.pairs import NAMED
from compare.studies.dissimilar.points import (
    GrowthPoint,
    NamedPoint,
    ThresholdPoint,
    column,
    contrasts,
    named_points,
    threshold_point,
)
from compare.tasks.workers import Progress, Task, run_tasks
from semianalytic.scene.checks import checked_count

_NAMED_FRICTIONS = 24
_THRESHOLDS_PER_COLUMN = 4
_QUICK = 12


@dataclass(frozen=True)
class GrowthResults:
    """All points of the map, the curves on it, and the named pairs, sorted."""

    points: list[GrowthPoint]
    thresholds: list[ThresholdPoint]
    named: list[NamedPoint]


def write_growth(
    output: Path,
    size: int,
    quick: bool = False,
    progress: Progress | None = None,
    form: str = "png",
    client: Any = None,
) -> GrowthResults:
    """Compute the map and write it with its curves and named pairs: dissimilar.png and three
    CSV files.

    Parameters
    ----------
    size : int
        Contrasts and frictions of the map; 12 if quick.
    progress : callable, optional
        Told how many tasks of how many are done.
    form : str
        Format of the figure.

    Raises
    ------
    SceneError
        If size is less than 2.
    DataFileError
        If a file cannot be written.
    """
    size = checked_count("regimes: size", size, 2, "a whole number from")
    output.mkdir(parents=True, exist_ok=True)
    results = growth_results(_QUICK if quick else size, progress, client)
    write_rows(output / "dissimilar.csv", results.points)
    write_rows(output / "dissimilar-thresholds.csv", results.thresholds)
    write_rows(output / "dissimilar-named.csv", results.named)
    figure = growth_figure(results.points, results.thresholds, results.named)
    save_figure(figure, output / f"dissimilar.{form}")
    return results


def growth_results(
    size: int, progress: Progress | None = None, client: Any = None
) -> GrowthResults:
    """The points of a map of a size, on all cores."""
    frictions = tuple(np.geomspace(0.01, 1.25, _NAMED_FRICTIONS).tolist())
    tasks: list[Task] = [(named_points, (name, frictions)) for name in NAMED]
    tasks += [(column, (contrast, size)) for contrast in contrasts(size)]
    tasks += [(threshold_point, (one,)) for one in contrasts(_THRESHOLDS_PER_COLUMN * size)]
    points: list[GrowthPoint] = []
    thresholds: list[ThresholdPoint] = []
    named: list[NamedPoint] = []
    for _, found in run_tasks(tasks, progress=progress, client=client):
        if isinstance(found, ThresholdPoint):
            thresholds.append(found)
        elif isinstance(found[0], NamedPoint):
            named += found
        else:
            points += found
    order = list(NAMED)
    return GrowthResults(
        sorted(points, key=lambda point: (point.contrast, point.friction)),
        sorted(thresholds, key=lambda point: point.contrast),
        sorted(named, key=lambda point: (order.index(point.pair), point.friction)),
    )
