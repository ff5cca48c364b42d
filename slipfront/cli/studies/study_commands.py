"""``slipfront chart``, and the option of studies that run on a cluster."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from compare.output.places import working_folder
from compare.output.progress import progress_bar
from semianalytic.scene.extras import CLUSTER, FEM, PLOT, require
from slipfront.cli.options import AsJson, FiguresForm, Quiet
from slipfront.cli.scenes.completion import CHARTED, one_of
from slipfront.cli.terminal import print_json

Output = Annotated[
    Path | None,
    typer.Option(metavar="DIR", help="Folder to write to, results/COMMAND if not given."),
]
Quick = Annotated[bool, typer.Option("--quick", help="Compute less, for a first look.")]


Scheduler = Annotated[
    str | None,
    typer.Option(
        metavar="ADDRESS",
        help="Work on the Dask cluster of this scheduler, as tcp://127.0.0.1:8786.",
    ),
]


def chart(
    scenes: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[SCENE...]",
            help=f"Scenes of the chart: {', '.join(CHARTED)}; all unless given.",
            autocompletion=one_of(*CHARTED),
        ),
    ] = None,
    output: Output = None,
    figures: FiguresForm = "png",
    quick: Quick = False,
    fresh: Annotated[bool, typer.Option("--fresh", help="Repeat finished measurements.")] = False,
    scheduler: Scheduler = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Chart error against time of every method; an interrupted chart resumes when restarted.

    --output docs refreshes the page of the documentation.
    """
    require("slipfront chart", *FEM, *PLOT)
    from compare.studies.chart.figure import slopes_table, write_chart
    from compare.studies.chart.points import FILE_NAME, SCENES
    from compare.studies.chart.study import measure_all
    from compare.studies.documents import chart_document

    directory = output or Path("results", "chart-quick" if quick else "chart")
    notes = Console(stderr=True)
    with on_scheduler(scheduler) as client, working_folder(directory) as files:
        with progress_bar(notes, quiet, "measuring") as progress:
            points = measure_all(
                directory / FILE_NAME,
                scenes or SCENES,
                quick=quick,
                fresh=fresh,
                progress=progress,
                tell=_teller(notes, quiet),
                client=client,
            )
        text = write_chart(directory, points, figures)
    if as_json:
        print_json("chart", chart_document(points), files=files)
        return
    Console().print(text, highlight=False, markup=False, soft_wrap=True)
    Console().print(slopes_table(points), highlight=False, markup=False)
    _written(f"{directory}/")


def on_scheduler(address: str | None) -> AbstractContextManager[Any]:
    """A client of the scheduler at an address; None without an address."""
    from compare.tasks.cluster import connected

    if address is not None:
        require("--scheduler", *CLUSTER)
    return connected(address)


def _teller(notes: Console, quiet: bool) -> Callable[[str], None] | None:
    """Return a function that prints lines on the progress of a study; None if quiet."""
    return None if quiet else partial(notes.print, highlight=False)


def _written(path: str | Path) -> None:
    Console().print(f"Written to {path}", highlight=False)
