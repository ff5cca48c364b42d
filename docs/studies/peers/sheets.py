"""What other codes published, scored by the benchmark sheets of interfaces.

``python -m docs.studies.peers.sheets UGUCA FARMS`` writes docs/data/peers-sheets.csv.  UGUCA is a
checkout of github.com/chunhuizhao478/uguca_scec at commit 1db9efb, with the fields of TPV101 on
1,440 and 2,880 nodes; FARMS is one of github.com/chunhuizhao478/farms, with the stations of TPV205
that PyLith computed.  Neither is part of this package.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import semianalytic as sf
from compare.benchmarks.entries import Run
from compare.benchmarks.scores import GRADED, score
from compare.benchmarks.sheets import INTERFACE_SHEETS, find_sheet
from compare.output.tables import write_rows
from compare.records.record import Record, Records
from docs.studies.pages import DATA
from docs.studies.peers.rows import Array, rounded
from docs.studies.peers.tpv205 import MEGA, stations
from docs.studies.peers.uguca import FRAMES, published

COMMAND = "python -m docs.studies.peers.sheets UGUCA FARMS"
SPACING = {1440: 50.0, 2880: 25.0}
"""Their node distances [m]; fields are given on nodes of 50 m."""


@dataclass(frozen=True)
class Row:
    """Errors of a run on a sheet, as in `Score`, and their classes."""

    sheet: str
    code: str
    spacing: str
    arrival: float
    slip_rate: float
    slip: float
    shear_traction: float
    tolerance: str


def row_of(code: str, spacing: str, sheet: str, records: list[Record]) -> Row:
    """Score records of a sheet."""
    run = Run(find_sheet(sheet), code, "", math.nan, math.nan, Records(tuple(records), source=code))
    found = {one.quantity: one for one in score(run)}
    names = [name for name in GRADED if name in found]
    errors = {name: rounded(found[name].error, 2) for name in names}
    classes = "".join(found[name].tolerance or "-" for name in names)
    return Row(sheet, code, spacing, **errors, tolerance=classes)


def tpv101(folder: Path) -> Iterator[Row]:
    """Yield the rows of UGUCA, of the limit of its two grids, and of `run` at the same times."""
    sheet = INTERFACE_SHEETS["tpv101"]
    # their steps, of which every 20th is kept
    t: Array = 20 * 0.35 * 50 / 3464.0 * np.arange(float(FRAMES))
    fields = {
        nodes: {
            name: published(folder, nodes)[name.replace("_", " ")] for name in ("slip_rate", "slip")
        }
        for nodes in SPACING
    }
    limit = {name: 2 * fields[2880][name] - fields[1440][name] for name in fields[1440]}
    named = {f"{SPACING[nodes]:g} m": fields[nodes] for nodes in SPACING}
    for spacing, values in {**named, "limit": limit}.items():
        records = [
            Record(x, t[1:], {name: one[1:, round(x / 50)] for name, one in values.items()})
            for x in sheet.stations
        ]
        yield row_of("UGUCA", spacing, sheet.name, records)
    # what reading between so few times costs alone
    ours = sf.run(
        sheet.interface, sheet.end_time, 1440, times=t[1:].tolist(), estimate=False, step_ratio=0.35
    )
    read = {name: ours.at(getattr(ours, name), sheet.stations) for name in sheet.report}
    records = [
        Record(x, ours.t, {name: one[:, i] for name, one in read.items()})
        for i, x in enumerate(sheet.stations)
    ]
    yield row_of("slipfront run, at the times of UGUCA", "50 m", sheet.name, records)


def tpv205(folder: Path) -> Row:
    """Return the row of PyLith."""
    known = stations(folder)
    records = [
        Record(
            x,
            known[x / 1e3][1:, 0],
            {
                "slip": known[x / 1e3][1:, 1],
                "slip_rate": known[x / 1e3][1:, 2],
                "shear_traction": MEGA * known[x / 1e3][1:, 3],
            },
        )
        for x in find_sheet("tpv205").stations
    ]
    return row_of("PyLith", "200 m", "tpv205", records)


def main(uguca: Path, farms: Path) -> None:
    """Write the table."""
    rows = [*tpv101(uguca), tpv205(farms)]
    for row in rows:
        print(row)
    write_rows(DATA / "peers-sheets.csv", rows, command=COMMAND)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
