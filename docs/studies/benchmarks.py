"""The data of compare/benchmarks: ``python -m docs.studies.benchmarks answers|classes [NAME]``.

``answers`` computes the limits of runs of the interfaces, with the difference from the limit of the
next coarser two grids as their error (minutes each).  ``classes`` runs our finite elements on 200,
100 and 50 cells (an hour for all sheets).  Both sign what they have written; ``sums`` signs alone,
after data/sheets.toml was edited.
"""

from __future__ import annotations

import argparse
import json
import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from compare.benchmarks.answers import checksums
from compare.benchmarks.scores import score
from compare.benchmarks.sheets import DATA, SUMS, Sheet, find_sheet, sheets
from compare.comparison.interfaces.comparing import line_of
from compare.output.places import write_text
from compare.records.record import QUANTITIES, Record, Records
from fem import simulate
from fem.lines import simulate_line
from semianalytic import Marched, solve
from semianalytic.scene.arrays import Array
from semianalytic.scene.given.finding import find_scene

Fields = Mapping[str, Array]

DOCS = Path(__file__).resolve().parents[1]
CELLS = (200, 100, 50)
"""Cells over `Sheet.extent` of the classes A, B and C."""
SAMPLES = 5
"""Samples of a record for each time of the answer, so that reading between them costs nothing: with
half or twice as many no error of `run` on 200 cells changes by a hundredth of it."""
LEAST = 1e-6
"""Smallest stated error, and smallest bound of a class where all is exact to rounding."""


def run_of(sheet: Sheet, nodes: int, samples: int = 1) -> Marched:
    """Run the interface of a sheet on so many nodes, with so many samples for each of its times."""
    scene, end = sheet.problem, sheet.end_time
    count = samples * len(sheet.times)
    times = (end * np.arange(1, count + 1) / count).tolist()
    settings: dict[str, Any] = {"times": times, "slipping": sheet.level, "estimate": False}
    scene = replace(scene, run={key: scene.run[key] for key in scene.run if key == "step_ratio"})
    return solve(scene, end_time=end, nodes=nodes, **settings)


def sampled(sheet: Sheet, nodes: int) -> Fields:
    """Return a run at the times and stations of a sheet (m, k), and its "arrivals" (k,)."""
    done = run_of(sheet, nodes)
    fields = {name: done.at(getattr(done.interface, name), sheet.stations) for name in sheet.report}
    onset = np.asarray(done.at(done.seen.onset, sheet.stations))
    return {"arrivals": np.where(np.isnan(onset), math.inf, onset), **fields}


def extrapolated(sheet: Sheet, nodes: int) -> tuple[Fields, dict[str, float]]:
    """Return the limit of runs on so many nodes and on half of them, with its errors."""
    fine, middle, coarse = (sampled(sheet, nodes // parts) for parts in (1, 2, 4))
    limit, before = _limit(sheet, middle, fine), _limit(sheet, coarse, middle)
    errors = {name: apart(name, before[name], values) for name, values in limit.items()}
    return limit, {name: max(error, LEAST) for name, error in errors.items()}


def _limit(sheet: Sheet, coarse: Fields, fine: Fields) -> Fields:
    """Return what two runs tend to; arrivals, read off within a step, do so at first order."""
    weights = {name: 1 / (2**sheet.order - 1) for name in fine} | {"arrivals": 1.0}
    with np.errstate(invalid="ignore"):  # of arrivals that never come
        limit = {name: item + weights[name] * (item - coarse[name]) for name, item in fine.items()}
    return limit | {"arrivals": np.nan_to_num(limit["arrivals"], nan=math.inf)}


def apart(name: str, values: Array, limit: Array) -> float:
    """Return the relative L1 difference of two fields, or the largest of arrivals [time]."""
    if name == "arrivals":
        known = np.isfinite(values) & np.isfinite(limit)
        return float(np.abs(values - limit)[known].max())
    return float(np.abs(values - limit).sum() / np.abs(limit).sum())


def simulated(sheet: Sheet, cells: int) -> Records:
    """Return what our finite elements record at the stations of a sheet on so many cells."""
    scene = sheet.problem
    if not scene.on_line:
        done = simulate(find_scene(sheet.name), 1.0, resolution=cells)
        fields = {name: getattr(done, name) for name in QUANTITIES}
        t = done.interface.t
        stations = [
            Record(x, t, {name: at(x, t) for name, at in fields.items()}) for x in sheet.stations
        ]
    else:
        nodes = round(scene.period * cells / sheet.extent)
        samples = SAMPLES * len(sheet.times)
        line = simulate_line(line_of(scene, nodes), sheet.end_time, samples=samples)
        stations = []
        for x in sheet.stations:
            values = {
                name: np.array([np.interp(x, line.x, row) for row in getattr(line, name)])
                for name in sheet.report
            }
            stations.append(Record(x, line.t, values))
    return Records(tuple(stations), source=f"fem {cells}", spacing=sheet.extent / cells)


def bounds(sheet: Sheet) -> dict[str, list[float]]:
    """Measure the classes of a sheet: never a smaller bound on coarser cells."""
    found = [
        {result.quantity: result.error for result in score(sheet, simulated(sheet, cells))}
        for cells in CELLS
    ]
    errors = {name: [_rounded_up(answer[name]) for answer in found] for name in found[0]}
    return {name: np.maximum.accumulate(error).tolist() for name, error in errors.items()}


def _rounded_up(error: float) -> float:
    """Round an error up to two digits."""
    error = max(error, LEAST)
    digit = 10.0 ** (math.floor(math.log10(error)) - 1)
    return float(f"{math.ceil(error / digit) * digit:.2g}")


def written(fields: Fields, errors: Mapping[str, float]) -> dict[str, Any]:
    """An answer as it is stored: to a tenth of its error, null for what never comes."""
    answers: dict[str, Any] = {}
    for name, field in fields.items():
        digits = math.ceil(1 - math.log10(errors[name]))
        rows = [_shortened(row, digits) for row in np.atleast_2d(field)]
        answers[name] = rows if field.ndim > 1 else rows[0]
    return {
        "answers": answers,
        "errors": {name: float(f"{error:.2g}") for name, error in errors.items()},
    }


def _shortened(row: Array, digits: int) -> list[float | None]:
    return [float(f"{size:.{digits}g}") if math.isfinite(size) else None for size in row.tolist()]


def write(name: str, document: Any, folder: Path = DATA) -> None:
    """Write a JSON file, a row of numbers a line, and sign the folder."""
    rows = re.compile(r"\[\s+([^\[\]{}]*?)\s+\]")
    text = json.dumps(document, indent=0, allow_nan=False)
    write_text(folder / name, rows.sub(lambda row: f"[{''.join(row[1].split())}]", text) + "\n")
    sign(folder)


def sign(folder: Path = DATA) -> None:
    """Write the checksums of all files of a folder."""
    files = sorted(path for path in folder.iterdir() if path.suffix in (".json", ".toml"))
    write_text(folder / SUMS, checksums({path.name: path.read_bytes() for path in files}))


def _chosen(names: list[str], interfaces: bool) -> Iterator[Sheet]:
    """Yield the sheets of the names; all that have stored answers, or classes, without any."""
    for sheet in map(find_sheet, names) if names else sheets().values():
        if sheet.is_interface if interfaces else sheet.classes:
            yield sheet


def main() -> None:
    """Write answers, classes or checksums."""
    parser = argparse.ArgumentParser(prog="python -m docs.studies.benchmarks", description=__doc__)
    parser.add_argument("what", choices=("answers", "classes", "sums"))
    parser.add_argument("names", nargs="*", metavar="NAME")
    options = parser.parse_args()
    if options.what == "sums":
        return sign()
    if options.what == "answers":
        for sheet in _chosen(options.names, interfaces=True):
            write(f"{sheet.name}.json", written(*extrapolated(sheet, sheet.nodes)))
        return
    known: dict[str, Any] = {item.name: item.classes for item in sheets().values() if item.classes}
    for sheet in _chosen(options.names, interfaces=False):
        known[sheet.name] = bounds(sheet)
    write("classes.json", known)


if __name__ == "__main__":
    main()
