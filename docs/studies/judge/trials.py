"""All trials of the judge, in two tables that go on where an earlier run was stopped."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

from compare.output.tables import append_rows, started_rows
from compare.tasks.workers import Progress, run_tasks
from compare.tasks.workers import Task as WorkerTask
from docs.studies.judge.right_trials import COUNTS, judged_rows
from docs.studies.judge.rows import JudgedRow, SpoiltRow
from docs.studies.judge.scenes import (
    HISTORIES,
    METRES,
    NEAR,
    OPENINGS,
    OUT_OF_PLANE,
    STEPS,
    VISCOUS,
    power_scenes,
)
from docs.studies.judge.spoilt_trials import spoilt_rows

SEED = 25
QUICK_COUNTS = {
    STEPS: 6,
    HISTORIES: 2,
    OPENINGS: 3,
    NEAR: 2,
    VISCOUS: 1,
    OUT_OF_PLANE: 1,
    METRES: 1,
}
QUICK_RESOLUTION = 40
QUICK_POWER = 2


_JUDGED, _SPOILT = "judged", "spoilt"
_Key = tuple[str, str, int]
"""Kind, group or scene, and index of a trial: two scenes have the name of a map each."""


def run_trials(
    directory: Path, quick: bool = False, progress: Progress | None = None, client: Any = None
) -> tuple[list[JudgedRow], list[SpoiltRow]]:
    """All rows, those of an earlier run included; two tables in a folder.

    Raises
    ------
    DataFileError
        If a table cannot be written.
    """
    directory.mkdir(parents=True, exist_ok=True)
    counts = QUICK_COUNTS if quick else COUNTS
    names = list(power_scenes())[: QUICK_POWER if quick else None]
    resolution = QUICK_RESOLUTION if quick else None
    wanted: dict[_Key, WorkerTask] = {
        (_SPOILT, name, index): (spoilt_rows, (name, index, resolution, not quick))
        for index, name in enumerate(names)
    }
    wanted |= {
        (_JUDGED, group, index): (judged_rows, (group, SEED, index, resolution))
        for group, count in counts.items()
        for index in range(count)
    }
    # by index: whatever part of them is done is one of all groups
    tasks = dict(sorted(wanted.items(), key=lambda task: task[0][2]))
    part = "-quick" if quick else ""
    tables = {
        SpoiltRow: directory / f"judge-spoilt{part}.csv",
        JudgedRow: directory / f"judge-rows{part}.csv",
    }
    kept = {kind: _whole(started_rows(table, kind)) for kind, table in tables.items()}
    known = {_trial_of(row) for rows in kept.values() for row in rows}
    left = [key for key in tasks if key not in known]
    for _, rows in run_tasks([tasks[key] for key in left], None, progress, client):
        append_rows(tables[type(rows[0])], rows)
        kept[type(rows[0])] += rows
    judged, spoiled = (
        sorted((row for row in kept[kind] if _trial_of(row) in tasks), key=_trial_of)
        for kind in (JudgedRow, SpoiltRow)
    )
    return judged, spoiled


def _trial_of(row: JudgedRow | SpoiltRow) -> _Key:
    """Return the trial that a row belongs to: its kind, its group or scene, and its index."""
    if isinstance(row, JudgedRow):
        return _JUDGED, row.group, row.index
    return _SPOILT, row.scene, row.index


def _whole(rows: list[Any]) -> list[Any]:
    """Rows of those trials of which all are there."""
    counts = Counter(map(_trial_of, rows))
    return [row for row in rows if counts[_trial_of(row)] == row.of]
