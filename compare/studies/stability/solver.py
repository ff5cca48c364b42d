"""Stability study of the semi-analytic solver: where methods fail, as figures and a table."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from compare.output.tables import write_rows
from compare.studies.stability.figures import save_figures
from compare.studies.stability.methods import PLACEMENTS
from compare.studies.stability.sweeps import (
    StudyRow,
    estimate_rows,
    grid_rows,
    limit_rows,
    narrow_gap_rows,
    near_rayleigh_rows,
    rule_rows,
    threshold_rows,
    thresholds,
)
from compare.tasks.workers import Progress, Task, run_tasks
from semianalytic.regimes import Loading

GRID_SCENES = (("preload", 1 / 3, 0.2), ("preload", 0.0, 0.1), ("remote", 1 / 3, 1.1))
ESTIMATE_SCENES: tuple[tuple[Loading, float, float], ...] = (
    ("preload", 1 / 3, 1.0),
    ("preload", 1 / 3, 0.2),
    ("preload", -0.5, 0.02),
    ("remote", 1 / 3, 1.25),
    ("remote", 1 / 3, 1.1),
)
LIMITS = ("0.5", "0+", "0-", "-1")
RULE_POISSON_RATIOS = (-0.99, 0.0, 1 / 3, 0.499)
_SIZES = (20, 40, 80, 160, 320, 640)
_LARGE_SIZES = (1000, 2000)
_DEEPEST = 9


def write_solver_stability(
    output: Path,
    quick: bool = False,
    progress: Progress | None = None,
    form: str = "png",
    client: Any = None,
) -> list[StudyRow]:
    """Study limits, thresholds, grids and rules; write figures and stability-solver.csv.

    If `quick`, grids are small and points few, which takes less than a minute; otherwise it takes
    some minutes.  A `client` of a Dask cluster runs the study there.

    Raises
    ------
    DataFileError
        If a file cannot be written.
    ComputationError
        If a threshold cannot be found, or a basic scene of a study cannot be solved.
    """
    output.mkdir(parents=True, exist_ok=True)
    rows: list[StudyRow] = []
    for _, part in run_tasks(study_tasks(quick), progress=progress, client=client):
        rows += part
    rows.sort(key=_order)
    write_rows(output / "stability-solver.csv", rows)
    save_figures(output, rows, form)
    return rows


def _order(row: StudyRow) -> tuple[str, str, str, str, float]:
    return (row.study, row.case, row.method, row.quantity, row.parameter)


def study_tasks(quick: bool) -> list[Task]:
    """Return all computations of the study, the longest first."""
    sizes = _SIZES[:3] if quick else _SIZES
    scenes = GRID_SCENES[:1] if quick else GRID_SCENES
    tasks: list[Task] = []
    if not quick:
        loading, nu, chi = GRID_SCENES[0]
        for size in reversed(_LARGE_SIZES):
            tasks.append((grid_rows, (loading, nu, chi, size, "galerkin", False)))
    for size in reversed(sizes):
        for loading, nu, chi in scenes:
            for placement in PLACEMENTS:
                tasks.append((grid_rows, (loading, nu, chi, size, placement, True)))
    for name, (loading, nu, chi) in thresholds().items():
        if not quick or "1/3" in name:
            tasks.append((threshold_rows, (name, loading, nu, chi)))
    for limit in LIMITS:
        for exponent in range(1, 4 if quick else _DEEPEST + 1):
            tasks.append((limit_rows, (limit, exponent)))
    for scene in ESTIMATE_SCENES[: 1 if quick else None]:
        tasks.append((estimate_rows, scene))
    for nu in RULE_POISSON_RATIOS:
        tasks.append((rule_rows, (nu,)))
    for nu in RULE_POISSON_RATIOS[1:3]:
        tasks.append((near_rayleigh_rows, (nu,)))
        tasks.append((narrow_gap_rows, (nu,)))
    return tasks
