"""Our own codes on the sheets of interfaces: records at the stations."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from compare.benchmarks.interfaces.sheets import InterfaceSheet
from compare.interfaces.lines import line_of
from compare.records.record import Record
from semianalytic import solve

Array = NDArray[np.float64]

SAMPLES = 5
"""Samples of a record for each time of the answer, so that reading between them costs nothing: with
half or twice as many no error of `run` on 200 cells changes by a hundredth of it."""


def run_stations(sheet: InterfaceSheet, cells: int) -> tuple[Record, ...]:
    """Return what `run` computes at the stations, on so many cells over `sheet.extent`."""
    times = (
        sheet.end_time * np.arange(1, SAMPLES * len(sheet.times) + 1) / (SAMPLES * len(sheet.times))
    )
    done = solve(
        sheet.interface,
        end_time=sheet.end_time,
        nodes=sheet.nodes_of(cells),
        times=times.tolist(),
        estimate=False,
        **sheet.options,
    )
    fields = [done.at(getattr(done, name), sheet.stations) for name in sheet.report]
    return _records(sheet, done.t, fields)


def simulated_stations(sheet: InterfaceSheet, cells: int) -> tuple[Record, ...]:
    """Return what finite elements compute at the stations, on so many cells."""
    from fem.lines import simulate_line

    line = line_of(sheet.interface, sheet.nodes_of(cells))
    done = simulate_line(line, sheet.end_time, samples=SAMPLES * len(sheet.times))
    fields = [
        np.array([np.interp(sheet.stations, done.x, row) for row in getattr(done, name)])
        for name in sheet.report
    ]
    return _records(sheet, done.t, fields)


def _records(sheet: InterfaceSheet, t: Array, fields: Sequence[Array]) -> tuple[Record, ...]:
    """Return fields (m, k) at times (m,) as records of the k stations."""
    return tuple(
        Record(x, t, {name: one[:, i] for name, one in zip(sheet.report, fields, strict=True)})
        for i, x in enumerate(sheet.stations)
    )
