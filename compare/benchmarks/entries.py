"""Runs of codes on a sheet: by our own codes, written and read in the form that all hand in.

A file is CSV with a heading ``t,x,slip_rate,slip,shear_traction,pressure`` or some of these, in
units mu = rho = c_t = T = 1, behind lines as ``# code: slipfront fem`` of `LABELS`.  Where slip
rates are means over a step, a line says ``from t to t + 0.005``.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from importlib.metadata import version
from io import StringIO
from pathlib import Path
from time import perf_counter

from compare.benchmarks.interfaces.entries import run_stations, simulated_stations
from compare.benchmarks.interfaces.sheets import SI, InterfaceSheet
from compare.benchmarks.sheet import STATIONS, Sheet
from compare.benchmarks.sheets import find_sheet
from compare.output.files import write_text
from compare.records.read import read_records
from compare.records.record import QUANTITIES, Record, Records
from compare.records.text import lines_of
from semianalytic import solve
from semianalytic.results.sampled import SampledAnswer
from semianalytic.scene.checks import checked_count
from semianalytic.scene.errors import DataFileError, SceneError
from semianalytic.scene.given.finding import find_blocks

LABELS = ("benchmark", "code", "version", "cells", "seconds")
"""Labels of the comment lines of a file; cells are counted over c_t T, or what the sheet says."""
LEAST_CELLS = 8


@dataclass(frozen=True, eq=False)
class Run:
    """The results of one code for a sheet on one grid.

    Attributes
    ----------
    sheet : Sheet
    code, version : str
    cells : float
        Over `Sheet.extent`; nan if the file does not say.
    seconds : float
        That it took; nan if the file does not say.
    records : Records
    step : float
        Slip rates are means from t to t + step; 0 if they are those at t.
    """

    sheet: Sheet
    code: str
    version: str
    cells: float
    seconds: float
    records: Records
    step: float = 0.0


def run_label(code: str, cells: float) -> str:
    """Code and cells of a run, as figures and tables name it."""
    return code if math.isnan(cells) else f"{code} {cells:g}"


Stations = tuple[Record, ...]


def _simulated(sheet: Sheet, cells: int) -> Stations:
    if isinstance(sheet, InterfaceSheet):
        return simulated_stations(sheet, cells)
    from fem import simulate

    lower = find_blocks(sheet.name)[1] if sheet.is_pair else None
    return _stations_of(simulate(sheet.scene, 1.0, resolution=cells, lower_material=lower))


def _marched(sheet: Sheet, cells: int) -> Stations:
    if sheet.is_interface:
        raise SceneError(f"enter: march takes scenes, and {sheet.name} is an interface; give run.")
    nodes = math.ceil(cells * sheet.scene.fastest_speed)
    return _stations_of(
        solve(sheet.scene, method="space-time", end_time=1.0, nodes=nodes, companion=False)
    )


def _run(sheet: Sheet, cells: int) -> Stations:
    if not isinstance(sheet, InterfaceSheet):
        raise SceneError(f"enter: run takes interfaces, and {sheet.name} is none; give march.")
    return run_stations(sheet, cells)


def _stations_of(answer: SampledAnswer) -> Stations:
    times = answer.interface.t
    return tuple(
        Record(x, times, {name: getattr(answer, name)(x, times) for name in QUANTITIES})
        for x in STATIONS
    )


CODES: Mapping[str, Callable[[Sheet, int], Stations]] = {
    "fem": _simulated,
    "march": _marched,
    "run": _run,
}
"""Our own codes that can be run on a sheet: scenes by fem and march, interfaces by fem and run."""


def enter(code: str, sheet: Sheet, cells: int) -> Run:
    """Run one of our own codes on a sheet.

    Parameters
    ----------
    code : str
        A key of `CODES`.
    sheet : Sheet
    cells : int
        Over c_t T, or over what the sheet of an interface says.

    Raises
    ------
    SceneError
        If there is no such code, cells are too few, or the code does not take the scene.
    """
    if code not in CODES:
        raise SceneError(f"There is no code called {code!r} to enter; choose {', '.join(CODES)}.")
    if sheet.is_line:
        raise SceneError(
            f"enter: {code} takes scenes with a slot, and {sheet.name} has none; hand in records "
            "of another code, or choose another sheet."
        )
    if sheet.is_pair and code == "march":
        raise SceneError(
            f"enter: march knows identical bodies only, and {sheet.name} is of two; enter fem, or "
            "hand in records of slipfront run (docs/engine.md)."
        )
    cells = checked_count("enter: cells", cells, LEAST_CELLS, "a whole number from")
    began = perf_counter()
    stations = CODES[code](sheet, cells)
    seconds = perf_counter() - began
    records = Records(stations, source=f"slipfront {code}", spacing=sheet.extent / cells)
    return Run(sheet, f"slipfront {code}", version("slipfront"), cells, seconds, records)


def run_text(run: Run) -> str:
    """A run as it is handed in; values to eight digits."""
    stream = StringIO(newline="")
    said = (run.sheet.name, run.code, run.version, f"{run.cells:g}", f"{run.seconds:.3g}")
    for label, value in zip(LABELS, said, strict=True):
        stream.write(f"# {label}: {value}\n")
    table = csv.writer(stream, lineterminator="\n")
    names = [one for one in QUANTITIES if one in run.records.stations[0].values]
    table.writerow(["t", "x", *names])
    for station in run.records.stations:
        for level, t in enumerate(station.t):
            values = (station.values[name][level] for name in names)
            table.writerow([f"{value:.8g}" for value in (t, station.x, *values)])
    return stream.getvalue()


def write_run(path: Path, run: Run) -> None:
    """Write a run as it is handed in, whole or not at all; raises a DataFileError."""
    write_text(path, run_text(run))


def read_run(path: Path, sheet: Sheet | None = None) -> Run:
    """A run from the file that was handed in.

    Parameters
    ----------
    path : Path
    sheet : Sheet, optional
        That it is of, unless the file says so.

    Raises
    ------
    DataFileError
        If the file cannot be read as one, or says another sheet than the one given.
    SceneError
        If neither says which sheet it is of.
    """
    said = _labels(path)
    named = said.get("benchmark")
    if sheet is None and named is None:
        raise SceneError(f"{path} does not say of which benchmark it is; give `sheet`.")
    if sheet is not None and named not in (None, sheet.name):
        raise DataFileError(f"{path} is of {named}, not of {sheet.name}; leave `sheet` out.")
    cells, seconds = (_number(said.get(name, "nan"), path) for name in ("cells", "seconds"))
    sheet = sheet or find_sheet(str(named))
    records = _one_run(path, sheet)
    return Run(
        sheet,
        said.get("code", path.stem),
        said.get("version", ""),
        cells,
        seconds,
        records,
        records.stated.step or 0.0,
    )


def told_apart(runs: Sequence[Run]) -> list[Run]:
    """The runs, those of the same sheet, code and cells called by their files as well."""
    marks = [(run.sheet.name, run_label(run.code, run.cells)) for run in runs]
    return [
        replace(run, code=f"{run.code} ({Path(run.records.source).name})")
        if marks.count(mark) > 1
        else run
        for run, mark in zip(runs, marks, strict=True)
    ]


def _labels(path: Path) -> dict[str, str]:
    """Return the labels that the comment lines of a file give."""
    said = {}
    for line in lines_of(path):
        label, colon, value = line.removeprefix("#").partition(":")
        if line.startswith("#") and colon and label.strip() in LABELS:
            said[label.strip()] = value.strip()
    return said


def _number(text: str, path: Path) -> float:
    """A number above 0 of a comment, or nan."""
    try:
        number = float(text)
    except ValueError as error:
        raise DataFileError(f"{path}: {text[:40]!r} is no number.") from error
    if number <= 0 or math.isinf(number):
        raise DataFileError(f"{path}: {text[:40]!r} is no number of cells or seconds.")
    return number


def _one_run(path: Path, sheet: Sheet) -> Records:
    """The records of a file, which are in the units of its sheet."""
    (records,) = read_records([path])
    if isinstance(sheet, InterfaceSheet) and sheet.units == SI:
        return records  # numbers with units were converted to the SI
    for name, unit in records.stated.units.items():
        raise DataFileError(
            f"{path}: {name} is in {unit.name}; hand it in where mu = rho = c_t = T = 1, without "
            "a unit."
        )
    return records
