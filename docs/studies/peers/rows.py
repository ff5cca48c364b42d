"""Rows of docs/data/peers.csv: two codes on several grids, their differences and their seconds."""

from __future__ import annotations

import argparse
import resource
import subprocess
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import semianalytic as sf
from compare.output.tables import PARSERS, write_rows
from docs.studies.pages import DATA, read_data

Array = NDArray[np.float64]
FILE = DATA / "peers.csv"
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


@dataclass(frozen=True)
class GridRun:
    """What a code computed on one grid: fields (times, places) by quantity, and its seconds."""

    grid: str
    fields: Mapping[str, Array]
    seconds: float | None


def off(one: Array, other: Array) -> float:
    """Return the L1 difference of two fields, relative to the mean of their L1 norms.

    Where one has several times as many places as the other, the common ones are compared; a place
    at the end that only one of them has is left out.
    """
    first, second = one.shape[-1], other.shape[-1]
    one = one[..., :: max(1, round(first / second))]
    other = other[..., :: max(1, round(second / first))]
    count = min(one.shape[-1], other.shape[-1])
    one, other = one[..., :count], other[..., :count]
    return float(2 * np.abs(one - other).sum() / (np.abs(one).sum() + np.abs(other).sum()))


def compared(
    peer: str,
    case: str,
    command: str,
    pairs: Sequence[tuple[GridRun, GridRun]],
    limit: Mapping[str, Array] | None = None,
) -> list[Row]:
    """Return the rows of pairs of runs, theirs and ours, coarse grids first.

    `limit` has the fields to which their grids tend, those of the finest by default.  A peer with
    a single grid has no error and no change of its own.
    """
    several = len({their.grid for their, _ in pairs}) > 1
    limit = limit or pairs[-1][0].fields
    rows = []
    for quantity, known in limit.items():
        before: tuple[Array, Array] | None = None
        for their, our in pairs:
            one, other = their.fields[quantity], our.fields[quantity]
            rows.append(
                Row(
                    peer,
                    case,
                    quantity,
                    their.grid,
                    our.grid,
                    rounded(off(one, pairs[-1][1].fields[quantity])) if several else None,
                    rounded(off(other, known)),
                    rounded(off(one, before[0])) if several and before else None,
                    rounded(off(other, before[1])) if before else None,
                    rounded(their.seconds, 2) if their.seconds is not None else None,
                    rounded(our.seconds, 2) if our.seconds is not None else None,
                    command,
                )
            )
            before = one, other
    return rows


def replace_rows(rows: Sequence[Row], file: Path = FILE) -> None:
    """Print rows, and write them to a table in place of those of the same command and case."""
    print(*rows, sep="\n")
    renewed = {(row.command, row.case) for row in rows}
    known = read_data(file.stem, file.parent)[1] if file.exists() else []
    kept = [
        Row(**{one.name: _CELLS[str(one.type)](cells[one.name]) for one in fields(Row)})
        for cells in known
        if (cells["command"], cells["case"]) not in renewed
    ]
    whole = sorted([*kept, *rows], key=lambda row: (row.peer, row.case))
    command = "; ".join(dict.fromkeys(row.command for row in whole))
    write_rows(file, whole, command=command)


def record(peer: str, case: str, *arguments: Any) -> None:
    """Print and write the rows of pairs of runs, as `compared` returns them."""
    replace_rows(compared(peer, case, *arguments))


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


def timed_run(
    fault: sf.Interface, end: float, nodes: int, times: Sequence[float] | Array, **options: Any
) -> tuple[sf.Run, float]:
    """Run an interface; return it, and the seconds of the processor it took."""
    began = time.process_time()
    done = sf.solve(fault, end_time=end, nodes=nodes, times=list(times), estimate=False, **options)
    return done, time.process_time() - began


def places(description: str | None, *names: str) -> list[Path]:
    """Return the folders and programs of the command line, in the order of their names."""
    parser = argparse.ArgumentParser(description=description)
    for name in names:
        parser.add_argument(name, type=Path)
    return list(vars(parser.parse_args()).values())
