"""Map of rupture styles over the strength parameter S and distance: a figure and two tables."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from compare.figures.saving import save_figure
from compare.output.tables import write_rows
from compare.studies.supershear.figure import rupture_figure
from compare.studies.supershear.points import RupturePoint, TransitionPoint, rupture_points
from compare.tasks.workers import Progress, Task, run_tasks
from semianalytic.scene.checks import checked_count

STRENGTHS = (0.5, 1.6)
"""Values of S of the first and the last column.  Above 1.6 the transition is beyond 300 L_c, where
a map to 100 L_c shows sub-Rayleigh ruptures alone."""
_FARTHEST, _NODES = 100.0, 16
_QUICK_FARTHEST, _QUICK_NODES, _QUICK_SIZE = 12.0, 8, 4


@dataclass(frozen=True)
class RuptureResults:
    """Points of the map, by S and distance, and the transition of each S."""

    points: list[RupturePoint]
    transitions: list[TransitionPoint]


def write_ruptures(
    output: Path,
    size: int,
    quick: bool = False,
    progress: Progress | None = None,
    form: str = "png",
    client: Any = None,
) -> RuptureResults:
    """Follow one rupture for each S and write supershear.png and two CSV files.

    Parameters
    ----------
    size : int
        Values of S, and distances of the map up to 100 L_c; 4 and up to 12 L_c if quick.
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
    results = rupture_results(_QUICK_SIZE if quick else size, quick, progress, client)
    write_rows(output / "supershear.csv", results.points)
    write_rows(output / "supershear-transitions.csv", results.transitions)
    save_figure(rupture_figure(results.points, results.transitions), output / f"supershear.{form}")
    return results


def rupture_results(
    size: int, quick: bool = False, progress: Progress | None = None, client: Any = None
) -> RuptureResults:
    """Return the points of a map of a size, worked out on all cores."""
    farthest, nodes = (_QUICK_FARTHEST, _QUICK_NODES) if quick else (_FARTHEST, _NODES)
    # The longest runs, at high S, come first, so that no process waits for another at the end.
    strengths = np.linspace(*STRENGTHS, size).tolist()[::-1]
    tasks: list[Task] = [(rupture_points, (one, nodes, farthest, size)) for one in strengths]
    found = [result for _, result in run_tasks(tasks, progress=progress, client=client)]
    points = [point for some, _ in found for point in some]
    return RuptureResults(
        sorted(points, key=lambda point: (point.strength, point.distance)),
        sorted((change for _, change in found), key=lambda change: change.strength),
    )
