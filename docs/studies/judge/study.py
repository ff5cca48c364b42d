"""How far the judge can be trusted: false alarms, error bars, power against spoilt answers.

``python -m docs.studies.judge`` runs the trials and resumes them after an interruption.
``python -m docs.studies.judge.study alarms bars power strengths faults --csv docs/data`` writes
the tables of docs/judge.md from the same trials.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

from rich.console import Console

from compare.figures.saving import save_figure
from compare.output.progress import progress_bar
from compare.output.tables import write_rows
from compare.studies.tables import Study, run_studies
from compare.tasks.workers import Progress
from docs.studies.judge.figure import judge_figure
from docs.studies.judge.rows import JudgedRow, SpoiltRow
from docs.studies.judge.tables import (
    AlarmRow,
    BarRow,
    FaultRow,
    PowerRow,
    StrengthRow,
    alarm_rows,
    bar_rows,
    fault_rows,
    power_rows,
    strength_rows,
)
from docs.studies.judge.trials import run_trials

FOLDER = Path("results", "stability")
"""Default folder of the trials; the tables of the docs are made from it."""


def write_judge(
    directory: Path,
    quick: bool = False,
    progress: Progress | None = None,
    form: str = "png",
    client: Any = None,
) -> dict[str, Sequence[object]]:
    """Run what is missing of the trials; write their tables and the figure into a folder.

    A `client` of a Dask cluster lets that run them.

    Returns
    -------
    dict
        Rows of the tables "alarms", "bars", "power", "strengths" and "faults".

    Raises
    ------
    DataFileError
        If a file cannot be written.
    """
    judged, spoilt = run_trials(directory, quick, progress, client)
    tables: dict[str, Sequence[object]] = {
        "alarms": alarm_rows(judged),
        "bars": bar_rows(judged),
        "power": power_rows(spoilt),
        "strengths": strength_rows(spoilt),
        "faults": fault_rows(spoilt),
    }
    for name, rows in tables.items():
        write_rows(directory / f"judge-{name}.csv", rows)
    save_figure(judge_figure(judged, spoilt), directory / f"judge.{form}")
    return tables


@cache
def _trials() -> tuple[list[JudgedRow], list[SpoiltRow]]:
    with progress_bar(Console(stderr=True), False, "judging") as progress:
        return run_trials(FOLDER, False, progress)


def alarms() -> list[AlarmRow]:
    """False alarms of all trials."""
    return alarm_rows(_trials()[0])


def bars() -> list[BarRow]:
    """Error bars of all trials."""
    return bar_rows(_trials()[0])


def power() -> list[PowerRow]:
    """Spoilt answers of all trials."""
    return power_rows(_trials()[1])


def strengths() -> list[StrengthRow]:
    """Mistakes of all trials by how far they move a row."""
    return strength_rows(_trials()[1])


def faults() -> list[FaultRow]:
    """Simulations at fault of all trials."""
    return fault_rows(_trials()[1])


STUDIES: dict[str, Study] = {
    "alarms": alarms,
    "bars": bars,
    "power": power,
    "strengths": strengths,
    "faults": faults,
}

if __name__ == "__main__":
    raise SystemExit(run_studies("docs.studies.judge.study", "judge", STUDIES))
