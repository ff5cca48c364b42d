"""``slipfront benchmark``: problem sheets with exact answers, and scores of records of any code."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.markup import escape

from compare.benchmarks.sheets import SI, Sheet, find_sheet, sheet_names, sheets
from compare.output.printed import PrintedTable
from semianalytic.results.answer import FIELDS, TOTALS
from semianalytic.results.datasets import QUANTITIES
from semianalytic.scene.errors import SceneError
from semianalytic.scene.units import unit
from slipfront.cli.options import AsJson
from slipfront.cli.scenes import completion
from slipfront.cli.terminal import print_json

if TYPE_CHECKING:
    from compare.benchmarks.scores import Score

app = typer.Typer(
    help="Benchmark problems with answers of known error for any code, and scores of its results.",
    invoke_without_command=True,
)

SheetName = Annotated[
    str, typer.Argument(metavar="NAME", help="Name of a sheet.", autocompletion=completion.sheets)
]
_DIMENSIONS = {
    "stations": "length",
    "times": "time",
    "zones": "length / time",
    "openings": "length / time",
    "arrivals": "time",
    **{name: QUANTITIES[name][0] for name in (*FIELDS, *TOTALS)},
}


@app.callback()
def benchmark(context: typer.Context, as_json: AsJson = False) -> None:
    """List the problem sheets; show, export and score with the commands below."""
    if context.invoked_subcommand is not None:
        if as_json:
            name = context.invoked_subcommand
            raise SceneError(f"--json follows the command: slipfront benchmark {name} --json.")
    elif as_json:
        named = map(find_sheet, sheet_names())
        listed = [{**asdict(sheet), "scene": sheet.document} for sheet in named]
        print_json("benchmark", {"sheets": listed})
    else:
        table = PrintedTable("sheet", "problem", "to report", title="Benchmarks")
        for name in sheet_names():
            sheet = find_sheet(name)
            table.add_row(name, sheet.title, ", ".join(sheet.report).replace("_", " "))
        Console().print(table)


@app.command()
def show(name: SheetName, as_json: AsJson = False) -> None:
    """Show a sheet: problem, what to report, answer, accuracy classes."""
    sheet = find_sheet(name)
    if as_json:
        print_json("benchmark show", _document(sheet))
        return
    from compare.benchmarks.pages import page_of

    typer.echo(page_of(sheet), nl=False)


def _document(sheet: Sheet) -> dict[str, Any]:
    """A sheet with its answer, and the units of its numbers."""
    from compare.benchmarks.answers import answer_to, fields_of, numbers_of, stated_errors

    fields = {name: values.tolist() for name, values in fields_of(sheet, answer_to(sheet)).items()}
    answers = {**numbers_of(sheet), **fields}
    named = {name: unit(_DIMENSIONS[name], SI if sheet.units == SI else "") for name in _DIMENSIONS}
    return {
        "sheet": {**asdict(sheet), "scene": sheet.document},
        "times": list(sheet.times),
        "answers": answers,
        "errors": stated_errors(sheet),
        "units": {
            "sheet": {"stations": named["stations"]},
            "times": named["times"],
            "answers": {name: named[name] for name in answers},
        },
    }


@app.command()
def export(
    directory: Annotated[Path, typer.Argument(metavar="DIR", help="Folder to write to.")],
    names: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[NAME...]",
            help="Sheets to write; by default all of the page on benchmarks.",
            autocompletion=completion.sheets,
        ),
    ] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace existing files.")] = False,
    as_json: AsJson = False,
) -> None:
    """Write sheets: a page, a table of the answer and the problem as a file, with checksums."""
    from compare.benchmarks.pages import export as export_sheets

    chosen = [find_sheet(name) for name in dict.fromkeys(names or sheets())]
    files = export_sheets(directory, chosen, overwrite=overwrite)
    if as_json:
        document = {"sheets": [sheet.name for sheet in chosen]}
        print_json("benchmark export", document, files=files)
        return
    Console().print(f"Written to {directory}/", highlight=False, markup=False)


@app.command()
def score(
    files: Annotated[list[Path], typer.Argument(metavar="FILE...", help="Records of runs, CSV.")],
    sheet: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="Name of the sheet, if the files do not give it.",
            autocompletion=completion.sheets,
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Score runs: verdict of `validate`, and errors of arrivals, slip, slip rate and tractions."""
    from compare.benchmarks.scores import score_files

    given = None if sheet is None else find_sheet(sheet)
    scores = score_files(files, given)
    if as_json:
        units = {"error": "1", "held": "1"}
        document = {"scores": [asdict(row) for row in scores], "units": {"scores": units}}
        print_json("benchmark score", document)
        return
    for note in dict.fromkeys(f"{row.sheet}: {note}" for row in scores for note in row.notes):
        typer.echo(f"Note: {note}.")
    Console().print(_score_table(scores))


def _score_table(scores: Sequence[Score]) -> PrintedTable:
    """Return a table with a row per run: its verdict, and its errors, each with its class."""
    from compare.benchmarks.scores import ENOUGH, GRADED

    runs: dict[tuple[str, str], dict[str, Score]] = {}
    for row in scores:
        run = f"{row.sheet} {Path(row.file).name}", row.verdict or "-"
        runs.setdefault(run, {})[row.quantity] = row
    asked = [name for name in GRADED if any(name in run for run in runs.values())]
    title = "Arrival: RMS error over T; else: relative L1 error over all stations"
    table = PrintedTable("run", "verdict", title=title, box=SIMPLE_HEAD, pad_edge=False)
    for name in asked:
        table.add_column(name.replace("_", "\n"), justify="right", no_wrap=True)
    for names, errors in runs.items():
        found = (errors.get(name) for name in asked)
        cells = ("" if cell is None else f"{cell.error:.2g} {cell.grade or '-'}" for cell in found)
        table.add_row(*map(escape, names), *cells)
    if any(row.held < ENOUGH for row in scores):
        table.caption = f"no class (-) below {100 * ENOUGH:.0f} % of the time at all stations"
    return table
