"""Rows of docs/data/peers.csv, the difference that they hold, and the seconds of a program."""

from __future__ import annotations

import resource
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from compare.output.tables import PARSERS, write_rows
from docs.studies.pages import read_data

Array = NDArray[np.float64]
DATA = Path(__file__).resolve().parents[2] / "data"
FILE = DATA / "peers.csv"
Kind = TypeVar("Kind")
_CELLS = PARSERS | {"float | None": lambda text: float(text) if text else None}


@dataclass(frozen=True)
class Row:
    """One quantity of one problem, computed by a peer and by the engine.

    `their_error` lies between a grid of theirs and our finest, `our_error` between a grid of ours
    and their finest; `their_change` and `our_change` lie between a grid of a code and its next
    coarser one.  All are relative, in L1.  Seconds are those of the processor.
    """

    peer: str
    case: str
    quantity: str
    their_grid: str
    our_grid: str
    their_error: float | None
    our_error: float | None
    their_change: float | None
    our_change: float | None
    their_seconds: float | None
    our_seconds: float | None
    command: str


def off(one: Array, other: Array) -> float:
    """Return the L1 difference of two arrays, relative to the mean of their L1 norms."""
    return float(2 * np.abs(one - other).sum() / (np.abs(one).sum() + np.abs(other).sum()))


def replace_rows(rows: Sequence[Row], file: Path = FILE) -> None:
    """Write rows to docs/data/peers.csv in place of those of the same command and case."""
    renewed = {(row.command, row.case) for row in rows}
    kept = rows_in(file, Row) if file.exists() else []
    kept = [row for row in kept if (row.command, row.case) not in renewed]
    whole = sorted([*kept, *rows], key=lambda row: (row.peer, row.case))
    command = "; ".join(dict.fromkeys(row.command for row in whole))
    write_rows(file, whole, command=command)


def rows_in(file: Path, kind: type[Kind]) -> list[Kind]:
    """Return the rows of a file that `write_rows` wrote, as instances of a dataclass."""
    return [
        kind(**{one.name: _CELLS[str(one.type)](cells[one.name]) for one in fields(kind)})  # type: ignore[arg-type]
        for cells in read_data(file.stem, file.parent)[1]
    ]


def rounded(value: float, digits: int = 3) -> float:
    """Return a number with some significant digits, for a table."""
    return float(f"{value:.{digits}g}")


def seconds_of(command: Sequence[str | Path], folder: Path) -> float:
    """Run a program in a folder on one thread; return the seconds of the processor it took."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    environment = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "PATH": "/usr/bin:/bin"}
    with (folder / "log").open("w") as log:
        subprocess.run(list(map(str, command)), cwd=folder, check=True, stdout=log, env=environment)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
