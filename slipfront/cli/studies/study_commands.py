"""The longer commands of ``slipfront``: maps of regimes, stability studies, the article redone."""

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
from semianalytic.scene.errors import SceneError
from semianalytic.scene.extras import CLUSTER, FEM, PLOT, require
from slipfront.cli.options import AsJson, FiguresForm, Quiet
from slipfront.cli.scenes.completion import LOADINGS, one_of
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


def regimes(
    loading: Annotated[
        str,
        typer.Option(
            help="preload (shear step), remote (sudden remote load) or both.",
            autocompletion=one_of(*LOADINGS),
        ),
    ] = "both",
    size: Annotated[int, typer.Option(help="Points along each axis of a map.")] = 100,
    dissimilar: Annotated[
        bool,
        typer.Option(
            "--dissimilar",
            help="Map instead how fast waves grow while two different bodies slide.",
        ),
    ] = False,
    supershear: Annotated[
        bool,
        typer.Option(
            "--supershear",
            help="Map instead where ruptures that weaken with slip overtake shear waves.",
        ),
    ] = False,
    output: Output = None,
    figures: FiguresForm = "png",
    quick: Quick = False,
    scheduler: Scheduler = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Map how the interface slips over Poisson ratio and friction, with traced boundaries.

    An interrupted run continues when it is started again with the same size; one of --dissimilar
    or --supershear begins anew.
    """
    if dissimilar and supershear:
        raise SceneError("regimes: give --dissimilar or --supershear, not both.")
    require("slipfront regimes", *PLOT)
    from compare.studies.dissimilar.study import write_growth
    from compare.studies.documents import growth_document, regimes_document, ruptures_document
    from compare.studies.regimes.study import write_regimes
    from compare.studies.supershear.study import write_ruptures

    directory = output or Path("results", "regimes")
    bar = _progress(quiet, "mapping")
    document: dict[str, Any]
    with on_scheduler(scheduler) as client, working_folder(directory) as files, bar as progress:
        if dissimilar:
            document = growth_document(
                write_growth(directory, size, quick, progress, figures, client)
            )
        elif supershear:
            document = ruptures_document(
                write_ruptures(directory, size, quick, progress, figures, client)
            )
        else:
            document = regimes_document(
                write_regimes(directory, size, loading, quick, progress, figures, client)
            )
    if as_json:
        print_json("regimes", document, files=files)
    else:
        _written(f"{directory}/")


def stability(
    solver: Annotated[
        bool, typer.Option("--solver", help="Study the semi-analytic solver.")
    ] = False,
    fem: Annotated[bool, typer.Option("--fem", help="Study the finite-element model.")] = False,
    space_time: Annotated[
        bool, typer.Option("--space-time", help="Study the space-time solver.")
    ] = False,
    output: Output = None,
    figures: FiguresForm = "png",
    quick: Quick = False,
    scheduler: Scheduler = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Study where the methods fail, how, and what the program does about it."""
    if not (solver or fem or space_time):
        raise SceneError("say what to study: --solver, --fem, --space-time or several.")
    require("slipfront stability", *PLOT, *(FEM if fem else ()))
    from compare.studies.documents import stability_document

    directory = output or Path("results", "stability")
    chosen: dict[str, Callable[..., Any]] = {}
    if solver:
        from compare.studies.stability.solver import write_solver_stability

        chosen["solver"] = write_solver_stability
    if fem:
        from compare.studies.stability.fem import fem_stability

        chosen["fem"] = fem_stability
    if space_time:
        from compare.studies.stability.spacetime import write_stability

        chosen["space_time"] = write_stability
    tables = {}
    with on_scheduler(scheduler) as client, working_folder(directory) as files:
        for name, study in chosen.items():
            with _progress(quiet, "studying") as progress:
                rows = study(directory, quick, progress, figures, client)
            tables[name] = rows if isinstance(rows, dict) else {"rows": rows}
    if as_json:
        print_json("stability", stability_document(tables), files=files)
    else:
        _written(f"{directory}/")


def article(
    output: Output = None,
    figures: FiguresForm = "png",
    quick: Quick = False,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Redraw the article's figures by three methods and judge its claims."""
    require("slipfront article", *FEM, *PLOT)
    from compare.studies.article.study import claims_table, write_article
    from compare.studies.documents import article_document

    directory = output or Path("results", "article")
    with working_folder(directory) as files:
        found = write_article(directory, quick, _teller(Console(stderr=True), quiet), figures)
    if as_json:
        print_json("article", article_document(found), files=files)
        return
    Console().print(claims_table(found.claims), highlight=False, markup=False)
    _written(f"{directory}/")


def on_scheduler(address: str | None) -> AbstractContextManager[Any]:
    """A client of the scheduler at an address; None without an address."""
    from compare.tasks.cluster import connected

    if address is not None:
        require("--scheduler", *CLUSTER)
    return connected(address)


def _progress(quiet: bool, doing: str) -> AbstractContextManager[Callable[[int, int], None]]:
    return progress_bar(Console(stderr=True), quiet, doing)


def _teller(notes: Console, quiet: bool) -> Callable[[str], None] | None:
    """Return a function that prints lines on the progress of a study; None if quiet."""
    return None if quiet else partial(notes.print, highlight=False)


def _written(path: str | Path) -> None:
    Console().print(f"Written to {path}", highlight=False)
