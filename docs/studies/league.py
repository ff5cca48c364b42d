"""Make the tables of docs/benchmarks.md.

``python -m docs.studies.league classes`` measures the tolerance classes, for the package and for
docs/data.  ``... league`` scores the runs of slipfront's own codes and those of other codes in
tests/data/entrants; ``... figure`` draws them; ``... sheets`` lists the problems.  Classes and the
league take ``--sheets NAME ...``, and keep what is known of the other sheets.
"""

from __future__ import annotations

import argparse
import math
import shutil
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from compare.benchmarks.answers import DATA, written_document
from compare.benchmarks.classes import COMMAND, FILE, Tolerance, tolerances
from compare.benchmarks.entries import Run, enter, read_run
from compare.benchmarks.figures import score_figure
from compare.benchmarks.scores import ARRIVAL, GRADED, Score, score
from compare.benchmarks.sheet import CELLS, Sheet
from compare.benchmarks.sheets import INTERFACE_SHEETS, RATED_SHEETS, find_sheet
from compare.figures.saving import figure_png
from compare.output.tables import write_rows
from docs.studies.pages import read_data
from semianalytic.results.files import write_bytes
from semianalytic.scene.errors import SceneError, SlipfrontError

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs" / "data"
ENTRANTS = ROOT / "tests" / "data" / "entrants"
LEAST_BOUND = 1e-6
"""Smallest bound of a class, where the finite elements are exact to rounding."""
MARCH_CELLS = 100
DRAWN = ("preloaded", "auxetic", "antiplane", "lift-off-shear")
"""Sheets shown in the figure."""


def measured_classes(sheet: Sheet) -> Iterator[Tolerance]:
    """Measure the classes of a sheet with the finite elements."""
    coarse, middle, fine = (_errors(score(enter("fem", sheet, cells))) for cells in CELLS)
    marched = {} if _is_own_reference(sheet) else _march_errors(sheet)
    for name in fine:
        a = _bound(fine[name])
        b = max(a, _bound(middle[name]))
        c = max(b, _bound(coarse[name]))
        yield Tolerance(sheet.name, name, a, b, c, marched.get(name, math.nan))


def _errors(scores: Iterable[Score]) -> dict[str, float]:
    return {one.quantity: one.error for one in scores}


def _is_own_reference(sheet: Sheet) -> bool:
    """Return whether the answer to a sheet is that of the marcher itself, and no limit of grids."""
    return sheet.is_marched and not sheet.is_interface


def _marcher(sheet: Sheet) -> str:
    """Return our code of integral equations for a sheet."""
    return "run" if sheet.is_interface else "march"


def _march_errors(sheet: Sheet) -> dict[str, float]:
    """Return the errors of the marcher, or of `run`; none if it refuses the scene."""
    try:
        return _errors(score(enter(_marcher(sheet), sheet, MARCH_CELLS)))
    except SceneError:
        return {}


def _bound(error: float) -> float:
    """Round an error up to two digits."""
    error = max(error, LEAST_BOUND)
    digit = 10.0 ** (math.floor(math.log10(error)) - 1)
    return float(f"{math.ceil(error / digit) * digit:.2g}")


@dataclass(frozen=True)
class LeagueRow:
    """One run with its errors, as in `Score`, their classes, and the observed order.

    `order` is the order of the slip rate, or of the sheet's first quantity, since the next coarser
    grid of the same code.
    """

    sheet: str
    code: str
    version: str
    cells: float
    arrival: float
    arrival_cells: float
    slip_rate: float
    slip: float
    shear_traction: float
    pressure: float
    tolerance: str
    order: float
    seconds: float


def league_rows(runs: Iterable[Run]) -> list[LeagueRow]:
    """Return the rows of runs, sorted by sheet, code and cells."""
    order = list(RATED_SHEETS)
    ranked = sorted(runs, key=lambda run: (order.index(run.sheet.name), run.code, run.cells))
    rows: list[LeagueRow] = []
    for run in ranked:
        scores = {one.quantity: one for one in score(run)}
        errors = {name: scores[name].error if name in scores else math.nan for name in GRADED}
        arrival = scores.get(ARRIVAL)
        row = LeagueRow(
            sheet=run.sheet.name,
            code=run.code,
            version=run.version,
            cells=run.cells,
            **errors,
            arrival_cells=arrival.second if arrival else math.nan,
            tolerance="".join(scores[name].tolerance or "-" for name in GRADED if name in scores),
            order=_order(rows[-1] if rows else None, run, errors[run.sheet.report[0]]),
            seconds=run.seconds,
        )
        rows.append(row)
    return rows


def _order(before: LeagueRow | None, run: Run, error: float) -> float:
    """Return the observed order since the row before; nan if that has another code or sheet."""
    if before is None or (before.sheet, before.code) != (run.sheet.name, run.code):
        return math.nan
    was = getattr(before, run.sheet.report[0])
    if not (run.cells > before.cells and was > LEAST_BOUND and error > LEAST_BOUND):
        return math.nan
    return math.log(was / error) / math.log(run.cells / before.cells)


def own_runs(
    names: Iterable[str] = tuple(RATED_SHEETS), resolutions: Iterable[int] = CELLS
) -> Iterator[Run]:
    """Yield runs of slipfront's own codes on the sheets that they accept."""
    for sheet in map(find_sheet, names):
        for cells in resolutions:
            yield enter("fem", sheet, cells)
            if _is_own_reference(sheet):
                continue
            try:
                yield enter(_marcher(sheet), sheet, cells)
            except SceneError:
                continue


def others_runs(folder: Path = ENTRANTS) -> Iterator[Run]:
    """Yield the runs of other codes, files CODE/SHEET/CELLS.csv in a folder.

    Raises
    ------
    DataFileError
        If a CSV file is no record of a run.
    """
    for path in sorted(folder.glob("*/*/*.csv")):
        yield read_run(path)


def _known_rows() -> list[LeagueRow]:
    """Return the rows of docs/data/league.csv."""
    rows = []
    for row in read_data("league", DOCS)[1]:
        values: dict[str, Any] = {
            key: one if key in _TEXT or one.isdigit() else float(one) for key, one in row.items()
        }
        rows.append(LeagueRow(**values))
    return rows


_TEXT = ("sheet", "code", "version", "tolerance")
"""Columns of the league that hold no numbers."""


def league_figure(others: Iterable[Run]) -> Figure:
    """Draw the finest run of every code on the sheets `DRAWN`."""
    runs = list(own_runs(DRAWN, CELLS[-1:]))
    runs += [one for one in others if one.sheet.name in DRAWN]
    finest: dict[tuple[str, str], Run] = {}
    for run in sorted(runs, key=lambda run: run.cells):
        finest[run.sheet.name, run.code] = run
    return score_figure([one for run in finest.values() for one in score(run)])


@dataclass(frozen=True)
class SheetRow:
    """One line on a sheet: what it tests, what moves or opens, and whether it is marched."""

    sheet: str
    title: str
    tests: str
    parts: str


def sheet_rows() -> list[SheetRow]:
    """Return all sheets with the exact answers that the package exports."""
    return [
        SheetRow(sheet.name, sheet.title, sheet.tests, _parts(sheet))
        for sheet in RATED_SHEETS.values()
    ]


@dataclass(frozen=True)
class InterfaceRow:
    """One sheet of an interface: what it tests, and the stated errors of its answer.

    Errors are relative, but that of arrivals is in units of time.
    """

    sheet: str
    title: str
    tests: str
    nodes: int
    order: int
    slip: float
    slip_rate: float
    shear_traction: float
    arrivals: float


def interface_rows() -> list[InterfaceRow]:
    """Return all sheets of interfaces with the stated errors of their answers."""
    return [
        InterfaceRow(
            sheet.name,
            sheet.title,
            sheet.tests,
            sheet.nodes,
            sheet.order,
            **written_document(sheet)["errors"],
        )
        for sheet in INTERFACE_SHEETS.values()
    ]


def _parts(sheet: Sheet) -> str:
    """Return zones and openings of a sheet over c_t in words."""
    answers = written_document(sheet)["answers"]
    if sheet.is_marched:
        return "marched"
    parts = [
        f"{'slip' if sense > 0 else 'reverse slip'} {inner:.4g} to {outer:.4g}"
        for inner, outer, sense in answers["zones"]
    ]
    parts += [f"open {inner:.4g} to {outer:.4g}" for inner, outer in answers["openings"]]
    return ", ".join(parts) or "stuck"


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure classes or write the league table; return the exit code."""
    program = "python -m docs.studies.league"
    parser = argparse.ArgumentParser(prog=program, description=__doc__)
    parser.add_argument("table", choices=("sheets", "classes", "league", "figure"))
    parser.add_argument(
        "--sheets", nargs="*", choices=tuple(RATED_SHEETS), default=tuple(RATED_SHEETS)
    )
    parser.add_argument("--entrants", type=Path, default=ENTRANTS, help="where others' runs are")
    options = parser.parse_args(arguments)
    try:
        if options.table == "sheets":
            write_rows(DOCS / "benchmark-sheets.csv", sheet_rows(), command=f"{program} sheets")
            write_rows(
                DOCS / "benchmark-interfaces.csv", interface_rows(), command=f"{program} sheets"
            )
        elif options.table == "classes":
            sheets = map(find_sheet, options.sheets)
            classes = [one for sheet in sheets for one in measured_classes(sheet)]
            kept = [one for one in tolerances().values() if one.sheet not in options.sheets]
            ranks = list(RATED_SHEETS)
            classes = sorted([*kept, *classes], key=lambda one: ranks.index(one.sheet))
            write_rows(DATA / FILE, classes, command=COMMAND)
            shutil.copyfile(DATA / FILE, DOCS / f"benchmark-{FILE}")
        elif options.table == "figure":
            figure = league_figure(others_runs(options.entrants))
            write_bytes(ROOT / "docs" / "figures" / "league.png", figure_png(figure))
        else:
            others = [
                run for run in others_runs(options.entrants) if run.sheet.name in options.sheets
            ]
            rows = league_rows([*own_runs(options.sheets), *others])
            rows += [one for one in _known_rows() if one.sheet not in options.sheets]
            ranks = list(RATED_SHEETS)
            rows.sort(key=lambda row: ranks.index(row.sheet))
            write_rows(DOCS / "league.csv", rows, command=f"{program} league")
    except SlipfrontError as error:
        parser.exit(error.exit_code, f"{error}\n")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
