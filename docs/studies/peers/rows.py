"""Rows of docs/data/peers.csv: two codes on several grids, their differences and their seconds."""

from __future__ import annotations

import argparse
import resource
import subprocess
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import semianalytic as sf
from docs.studies.pages import DATA, read_data
from docs.studies.runner import Row, write_table
from semianalytic.scene.arrays import Array

FILE = DATA / "peers.csv"


@dataclass(frozen=True)
class GridRun:
    """What a code computed on one grid: fields (times, places) by quantity, and its seconds."""

    grid: str
    fields: Mapping[str, Array]
    seconds: float | None


def off(left: Array, other: Array) -> float:
    """Return the L1 difference of two fields, relative to the mean of their L1 norms.

    Where one has several times as many places as the other, the common ones are compared; a place
    at the end that only one of them has is left out.
    """
    first, second = left.shape[-1], other.shape[-1]
    left = left[..., :: max(1, round(first / second))]
    other = other[..., :: max(1, round(second / first))]
    count = min(left.shape[-1], other.shape[-1])
    left, other = left[..., :count], other[..., :count]
    return float(2 * np.abs(left - other).sum() / (np.abs(left).sum() + np.abs(other).sum()))


def record(
    peer: str,
    case: str,
    command: str,
    pairs: Sequence[tuple[GridRun, GridRun]],
    limit: Mapping[str, Array] | None = None,
) -> None:
    """Print the rows of pairs of runs, theirs and ours, coarse grids first, and write them to the
    table in place of those of the same command and case.

    `limit` has the fields to which their grids tend, those of the finest by default.  A peer with
    a single grid has no error and no change of its own.  `their_error` lies between a grid of
    theirs and our finest, `our_error` between a grid of ours and that limit, changes between a grid
    and its next coarser one; all are relative, in L1.
    """
    several = len({their.grid for their, _ in pairs}) > 1
    rows: list[Row] = []
    for quantity, known in (limit or pairs[-1][0].fields).items():
        finest = pairs[-1][1].fields[quantity]
        before: tuple[Array, Array] | None = None
        for their, our in pairs:
            first, other = their.fields[quantity], our.fields[quantity]
            row: Row = {"peer": peer, "case": case, "quantity": quantity}
            row |= {"their_grid": their.grid, "our_grid": our.grid}
            row["their_error"] = rounded(off(first, finest)) if several else None
            row["our_error"] = rounded(off(other, known))
            row["their_change"] = rounded(off(first, before[0])) if several and before else None
            row["our_change"] = rounded(off(other, before[1])) if before else None
            row["their_seconds"] = their.seconds and rounded(their.seconds, 2)
            row["our_seconds"] = our.seconds and rounded(our.seconds, 2)
            rows.append(row | {"command": command})
            before = first, other
    print(*rows, sep="\n")
    kept = [
        row for row in read_data(FILE.stem)[1] if (row["command"], row["case"]) != (command, case)
    ]
    whole = sorted([*kept, *rows], key=lambda row: (row["peer"], row["case"]))
    write_table(FILE, whole, "; ".join(dict.fromkeys(row["command"] for row in whole)))


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
    fault: sf.Scene, end: float, nodes: int, times: Sequence[float] | Array, **options: Any
) -> tuple[sf.Marched, float]:
    """Run an interface; return it, and the seconds of the processor it took."""
    began = time.process_time()
    done = sf.solve(fault, end_time=end, nodes=nodes, times=list(times), estimate=False, **options)
    return done, time.process_time() - began


def fields_of(done: sf.Marched, *names: str) -> dict[str, Array]:
    """Return fields of a run (times, nodes) by their names in words."""
    return {name: getattr(done.interface, name.replace(" ", "_")) for name in names}


def places(description: str | None, *names: str) -> list[Path]:
    """Return the folders and programs of the command line, in the order of their names."""
    parser = argparse.ArgumentParser(description=description)
    for name in names:
        parser.add_argument(name, type=Path)
    return list(vars(parser.parse_args()).values())
