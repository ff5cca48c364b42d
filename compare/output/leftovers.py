"""What an earlier run left in a folder, removed once another one has taken its place.

Only what slipfront itself has written goes, and only when the simulation it belongs to has been
replaced by another: the folder then tells of one run.
"""

from __future__ import annotations

import json
from collections.abc import Container
from contextlib import suppress
from pathlib import Path

SNAPSHOTS = "snapshots"
REPORT = "report.json"
FIELDS = "fields.csv"
FIGURES = tuple(
    f"{name}.{form}"
    for name in ("slip_rate", "tractions", "fronts", "sense", "history", "wear", "gap", "fields")
    for form in ("png", "pdf", "svg")
)
"""By the names of `compare.figures.histories.comparison_figures`, and that of whole fields."""


def forget_other_runs(directory: Path, run: str) -> None:
    """Remove snapshots, and report with figures, of other simulations than the one kept there.

    Parameters
    ----------
    directory : Path
    run : str
        Identity of the simulation that is there now.

    Raises
    ------
    DataFileError
        If snapshots cannot be removed.
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
        with suppress(OSError):
            (directory / REPORT).unlink(missing_ok=True)


def forget_figures(directory: Path, kept: Container[str] = ()) -> None:
    """Remove the figures of an earlier comparison, and its table, that this one does not have.

    A folder without a report holds no comparison, and stays as it is.

    Parameters
    ----------
    directory : Path
    kept : names of files
    """
    if not (directory / REPORT).is_file():
        return
    for name in (*FIGURES, FIELDS):
        if name not in kept:
            with suppress(OSError):
                (directory / name).unlink(missing_ok=True)
