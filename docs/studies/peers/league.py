"""Seconds of UGUCA on sheets of the league, with set-up and stepping told apart.

``python -m docs.studies.peers.league DEFAULT FAST`` writes docs/data/peers-league.csv.  DEFAULT and
FAST are folders with a program each, `sheet CELLS [once]`, built with the flags that UGUCA gives
and with those of the machine.  It sets the sheet `preloaded` as tests/data/entrants/README.md says
and steps without writing stations; with `once` it takes one step alone.  None of it is part of this
package.  What our march works out once in a process (some 0.1 s) is not counted.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from statistics import median

from compare.benchmarks.entries import enter
from compare.benchmarks.sheets import find_sheet
from compare.output.tables import write_rows
from docs.studies.pages import DATA, read_data
from docs.studies.peers.rows import rounded, seconds_of

COMMAND = "python -m docs.studies.peers.league DEFAULT FAST"
CELLS = (50, 100, 200)
TURNS = 3
"""Runs of each program, in turn with ours; the median counts."""
BUILDS, REPEATS = ("default", "fast"), 3
FIRST = {"UGUCA, default build": "UGUCA", "UGUCA, fast build": "UGUCA", "slipfront march": ""}


@dataclass(frozen=True)
class SheetCost:
    """Seconds of the processor before the steps and in them, with the errors of the league."""

    code: str
    cells: int
    slip_rate: float
    slip: float
    setup: float
    stepping: float


def their_cost(program: Path, whole: list[str], once: list[str], here: Path) -> tuple[float, float]:
    """Return the seconds of a program before its steps and in them, from a run with one step."""
    setup, steps = (
        min(seconds_of([program.resolve(), *line], here) for _ in range(REPEATS))
        for line in (once, whole)
    )
    return setup, max(steps - setup, 0.0)


def costs(builds: dict[str, Path]) -> Iterator[SheetCost]:
    """Yield the medians of several runs on each grid."""
    sheet = find_sheet("preloaded")
    _, league = read_data("league")
    enter("march", sheet, CELLS[0])  # imports, and what is worked out once in a process
    for cells in CELLS:
        found: dict[str, list[tuple[float, float]]] = {name: [] for name in FIRST}
        for _ in range(TURNS):
            for build, folder in builds.items():
                with tempfile.TemporaryDirectory() as scratch:
                    line = [str(cells)]
                    cost = their_cost(folder / "sheet", line, [*line, "once"], Path(scratch))
                found[f"UGUCA, {build} build"].append(cost)
            began = time.process_time()
            enter("march", sheet, cells)
            found["slipfront march"].append((0.0, time.process_time() - began))
        for code, parts in found.items():
            (row,) = (
                one
                for one in league
                if one["sheet"] == sheet.name
                and one["code"] == (FIRST[code] or code)
                and float(one["cells"]) == cells
            )
            setup, stepping = (rounded(median(part), 2) for part in zip(*parts, strict=True))
            yield SheetCost(
                code, cells, float(row["slip_rate"]), float(row["slip"]), setup, stepping
            )


def main(default: Path, fast: Path) -> None:
    """Write the table."""
    rows = list(costs(dict(zip(BUILDS, (default, fast), strict=True))))
    write_rows(DATA / "peers-league.csv", rows, command=COMMAND)
    print(*rows, sep="\n")


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
