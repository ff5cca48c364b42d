"""``slipfront benchmark``: problem sheets with exact answers, and scores of records of any code."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.markup import escape

from compare.benchmarks.sheet import Sheet
from compare.benchmarks.sheets import ALL_SHEETS, find_sheet
from compare.output.places import check_file, working_folder
from compare.output.printed import Table
from semianalytic.scene.errors import SceneError
from semianalytic.scene.extras import FEM, PLOT, require
from slipfront.cli.options import AsJson, FiguresForm
from slipfront.cli.scenes.completion import CODES, one_of, sheet_names
from slipfront.cli.terminal import print_json

if TYPE_CHECKING:
    from compare.benchmarks.scores import Score

app = typer.Typer(
    help="Benchmark problems with exact answers for any code, and scores of its results.",
    invoke_without_command=True,
)

SheetName = Annotated[
    str, typer.Argument(metavar="NAME", help="Name of a sheet.", autocompletion=sheet_names)
]


@app.callback()
def benchmark(context: typer.Context, as_json: AsJson = False) -> None:
    """List the problem sheets; show, export and score with the commands below."""
    if context.invoked_subcommand is not None:
        if as_json:
            name = context.invoked_subcommand
            raise SceneError(f"--json follows the command: slipfront benchmark {name} --json.")
    elif as_json:
        from compare.benchmarks.documents import sheets_document

        print_json("benchmark", sheets_document())
    else:
        table = Table("sheet", "problem", "to report", title="Benchmarks")
        for name, sheet in ALL_SHEETS.items():
            table.add_row(name, sheet.title, ", ".join(sheet.report).replace("_", " "))
        Console().print(table)


@app.command()
def show(name: SheetName, as_json: AsJson = False) -> None:
    """Show a sheet: problem, what to report, answer, tolerance classes."""
    if as_json:
        from compare.benchmarks.documents import sheet_document

        print_json("benchmark show", sheet_document(find_sheet(name)))
        return
    from compare.benchmarks.pages import as_markdown, sheet_blocks

    typer.echo(as_markdown(list(sheet_blocks(find_sheet(name)))))


@app.command()
def export(
    directory: Annotated[Path, typer.Argument(metavar="DIR", help="Folder to write to.")],
    names: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[NAME...]", help="Sheets to write; all by default.", autocompletion=sheet_names
        ),
    ] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace existing files.")] = False,
    as_json: AsJson = False,
) -> None:
    """Write sheets, figures, exact answers with checksums, and inputs for UGUCA and SEM2DPACK."""
    require("slipfront benchmark export", *PLOT)
    from compare.benchmarks.export import export as export_sheets

    sheets = _sheets(names)
    files = export_sheets(directory, sheets, overwrite=overwrite)
    if as_json:
        document = {"sheets": [sheet.name for sheet in sheets]}
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
            autocompletion=sheet_names,
        ),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Folder for scores.csv, scores.json and scores.png."),
    ] = None,
    figures: FiguresForm = "png",
    as_json: AsJson = False,
) -> None:
    """Score runs: arrivals, slip, slip rate and tractions over all stations."""
    if output is not None:
        require("slipfront benchmark score --output", *PLOT)
    from compare.benchmarks.entries import read_run, told_apart
    from compare.benchmarks.scores import score as score_run

    given = None if sheet is None else find_sheet(sheet)
    runs = told_apart([read_run(path, given) for path in files])
    scores = [one for run in runs for one in score_run(run)]
    written: list[Path] = []
    if output is not None:
        from compare.benchmarks.reports import write_scores

        with working_folder(output) as written:
            write_scores(output, scores, figures)
    if as_json:
        from compare.benchmarks.documents import scores_document

        print_json("benchmark score", scores_document(scores), files=written)
        return
    Console().print(_score_table(scores))
    if output is not None:
        Console().print(f"Written to {output}/", highlight=False, markup=False)


@app.command()
def enter(
    code: Annotated[
        str,
        typer.Argument(
            metavar="CODE",
            help="fem or march; for interfaces fem or run.",
            autocompletion=one_of(*CODES),
        ),
    ],
    name: SheetName,
    cells: Annotated[
        int, typer.Option(help="Cells over c_t T, or over what the sheet says.")
    ] = 100,
    output: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="File to write; CODE-NAME-CELLS.csv by default."),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Run one of slipfront's own codes on a sheet and write its records as an entry."""
    from compare.benchmarks.entries import enter as enter_run
    from compare.benchmarks.entries import write_run

    sheet = find_sheet(name)
    if code == "fem":
        require("slipfront benchmark enter fem", *FEM)
    path = output or Path(f"{code}-{name}-{cells}.csv")
    check_file(path)
    run = enter_run(code, sheet, cells)
    write_run(path, run)
    if as_json:
        from compare.benchmarks.documents import run_document

        print_json("benchmark enter", run_document(run), files=[path])
        return
    Console().print(f"Written to {path}", highlight=False, markup=False)


def _sheets(names: Sequence[str] | None) -> list[Sheet]:
    """Return the named sheets, each once; all sheets if no names are given."""
    return [find_sheet(name) for name in dict.fromkeys(names or ALL_SHEETS)]


def _score_table(scores: Sequence[Score]) -> Table:
    """Return a table with a row per run: its errors, each with its tolerance class."""
    from compare.benchmarks.scores import GRADED

    runs: dict[tuple[str, str], dict[str, Score]] = {}
    for one in scores:
        runs.setdefault((one.sheet, one.label), {})[one.quantity] = one
    asked = [name for name in GRADED if any(name in run for run in runs.values())]
    title = "Arrival: RMS error over T; else: relative L1 error over all stations"
    table = Table("sheet", "run", title=title, box=SIMPLE_HEAD, pad_edge=False)
    for name in asked:
        table.add_column(name.replace("_", " "), justify="right")
    for names, run in runs.items():
        cells = (_graded(run.get(name)) for name in asked)
        table.add_row(*map(escape, names), *cells)
    notes: dict[tuple[str, str], list[str]] = {}
    for one in scores:
        if one.note:
            notes.setdefault((one.label, one.note), []).append(one.quantity.replace("_", " "))
    lines = (f"{label}, {', '.join(names)}: {note}" for (label, note), names in notes.items())
    table.caption = escape("\n".join(lines)) or None
    return table


def _graded(one: Score | None) -> str:
    """Return an error and its class; an empty cell where the sheet does not ask for it."""
    return "" if one is None else f"{one.error:.2g} {one.tolerance or '-'}"
