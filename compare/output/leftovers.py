"""Removal of files that an earlier run has left in a folder.

Only files written by slipfront are removed, and only if another simulation has replaced the one
they belong to.  The folder then describes a single run.
"""

from __future__ import annotations

import json
from collections.abc import Container
from contextlib import suppress
from pathlib import Path

SNAPSHOTS = "snapshots"
REPORT, PAGE = "report.json", "report.html"
FIELDS = "fields.csv"
FIGURES = tuple(
    f"{name}.{form}"
    for name in ("interface", "fronts", "sense", "history", "gap", "fields")
    for form in ("png", "pdf", "svg")
)
"""Names of figures in `compare.figures.histories.comparison_figures`, and that of whole fields."""


def forget_other_runs(directory: Path, run: str) -> None:
    """Remove snapshots, report and figures of other simulations than the run in the folder.

    DataFileError if snapshots cannot be removed.
    """
    from fem.snapshots import forget_other_frames

    forget_other_frames(directory / SNAPSHOTS, run)
    try:
        document = json.loads((directory / REPORT).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return
    simulated = document.get("finite_elements") if isinstance(document, dict) else None
    if isinstance(simulated, dict) and simulated.get("run") != run:
        forget_figures(directory)
        for name in (PAGE, REPORT):
            with suppress(OSError):
                (directory / name).unlink(missing_ok=True)


def forget_figures(directory: Path, kept: Container[str] = ()) -> None:
    """Remove figures and table of an earlier comparison, but for those kept.

    A folder without a report contains no comparison, and stays as it is.
    """
    if not (directory / REPORT).is_file():
        return
    for name in (*FIGURES, FIELDS):
        if name not in kept:
            with suppress(OSError):
                (directory / name).unlink(missing_ok=True)
