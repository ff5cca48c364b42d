"""The longer commands of ``slipfront``: maps of regimes, stability studies, the article redone."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from compare import terminal
from semianalytic.errors import SceneError

Output = Annotated[
    Path | None,
    typer.Option(metavar="DIR", help="Folder to write to, results/COMMAND if not given."),
]
Quick = Annotated[bool, typer.Option("--quick", help="Coarser and smaller: a look at everything.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Show results only, no progress.")]


def regimes(
    loading: Annotated[
        str, typer.Option(help="preload (shear step), remote (sudden remote load) or both.")
    ] = "both",
    size: Annotated[int, typer.Option(help="Points along each axis of a map.")] = 100,
    output: Output = None,
    quick: Quick = False,
    quiet: Quiet = False,
) -> None:
    """Map how the interface slips over Poisson ratio and friction, with traced boundaries.

    An interrupted run continues when it is started again with the same size.
    """
    from compare.regimes import write_regimes

    directory = output or Path("results", "regimes")
    with terminal.progress_bar(Console(stderr=True), quiet, "mapping") as progress:
        write_regimes(directory, size, loading, quick, progress)
    Console().print(f"Written to {directory}/", highlight=False)


def stability(
    solver: Annotated[
        bool, typer.Option("--solver", help="Study the semi-analytic solver.")
    ] = False,
    fem: Annotated[bool, typer.Option("--fem", help="Study the finite-element model.")] = False,
    output: Output = None,
    quick: Quick = False,
    quiet: Quiet = False,
) -> None:
    """Study where the methods fail, how, and what the program does about it."""
    if not (solver or fem):
        raise SceneError("say what to study: --solver, --fem or both.")
    directory = output or Path("results", "stability")
    if solver:
        from compare.solver_stability import write_solver_stability

        with terminal.progress_bar(Console(stderr=True), quiet, "studying") as progress:
            write_solver_stability(directory, quick, progress)
    if fem:
        from compare.fem_stability import fem_stability

        with terminal.progress_bar(Console(stderr=True), quiet, "studying") as progress:
            fem_stability(directory, quick, progress)
    Console().print(f"Written to {directory}/", highlight=False)


def article(output: Output = None, quick: Quick = False, quiet: Quiet = False) -> None:
    """Redraw the article's figures by three methods and judge its claims."""
    from compare.article import claims_table, write_article

    directory = output or Path("results", "article")
    notes = Console(stderr=True)

    def tell(line: str) -> None:
        notes.print(line, highlight=False)

    found = write_article(directory, quick, None if quiet else tell)
    Console().print(claims_table(found.claims), highlight=False, markup=False)
    Console().print(f"Written to {directory}/", highlight=False)
