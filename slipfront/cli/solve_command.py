"""``slipfront solve``: solve a scene exactly, or march it in time if it is not self-similar."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console

from compare.comparison.documents import solution_document
from compare.output.places import check_file
from semianalytic import find, solve
from semianalytic.methods import chosen
from semianalytic.parameters.overriding import override_scene
from semianalytic.scene.checks import checked_size
from semianalytic.scene.errors import SceneError
from semianalytic.scene.extras import PLOT, require
from semianalytic.scene.given.finding import scene_label
from semianalytic.scene.loading import HalfLine
from slipfront.cli import terminal
from slipfront.cli.endings.refusals import check_converged, check_no_march_options
from slipfront.cli.options import (
    LOWER_OPTIONS,
    MARCH_OPTIONS,
    SCENE_OPTIONS,
    AsJson,
    Method,
    Quiet,
    SceneArgument,
    asked,
    measured_option,
    with_options,
)
from slipfront.cli.scenes.completion import figure_names
from slipfront.cli.scenes.points import AskedPoints, points_of, points_table

if TYPE_CHECKING:
    from compare.figures.named import Draw


_POINTS = "Points of the contact"
_Positions = Annotated[
    list[str] | None,
    typer.Option(
        "--x",
        metavar="X,...",
        help="Positions x > 0 to tell about, as 0.05 or 5cm,10cm: when slip comes there.",
        rich_help_panel=_POINTS,
    ),
]
_Times = Annotated[
    list[str] | None,
    typer.Option(
        "--t",
        metavar="T,...",
        help="Times, as 3e-5 or 30us: slip, slip rate and tractions at --x, with their errors.",
        rich_help_panel=_POINTS,
    ),
]


@with_options(overrides=SCENE_OPTIONS, lower=LOWER_OPTIONS, march_options=MARCH_OPTIONS)
def solve_command(
    overrides: Mapping[str, Any],
    lower: Mapping[str, Any],
    march_options: Mapping[str, Any],
    scene_name: SceneArgument,
    method: Method = "auto",
    end_time: Annotated[
        float | None,
        measured_option(
            "time",
            "Time T up to which to report [time]; a march ends there, at 1 / c_t by default.",
        ),
    ] = None,
    x: _Positions = None,
    t: _Times = None,
    as_json: AsJson = False,
    plot: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Draw slip rate and tractions (.png, .pdf).")
    ] = None,
    figure: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="Figure that --plot draws: interface, or one of an installed package.",
            autocompletion=figure_names,
        ),
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Solve a scene: slip zones, edge velocities, and everything that happens until an end time.

    With --x 5cm --t 30us a table says when slip comes to x, and slip, slip rate and tractions at t,
    each with the bar of its error; numbers may have units if the scene is in those of the SI.

    Step loads are self-similar and solved exactly; other load histories are marched in time, and so
    are interfaces: contacts, fields along x and friction with state.  Whole lines without a slot,
    and loads that grow as a power of time, are solved exactly as well, and so are step loads
    between different bodies: the lower one is lower_material of the file, or is like the upper one
    but for the numbers that are given.  The exit code is 4 if the solution has not converged, or a
    march is unresolved or misses --rtol; the best answer is printed all the same.
    """
    label, problem = scene_label(scene_name), find(scene_name)
    problem = override_scene(problem, **overrides, **lower)
    if isinstance(problem.load, HalfLine):
        from semianalytic.whole_line.drive import Drive, slot_scene

        problem = slot_scene(Drive(problem))
    name = chosen(problem, method).name
    asked_for = points_of(problem, x, t)
    end_time = asked(problem, "end_time", end_time, "time")
    draw = _drawing(plot, figure)
    shown: dict[str, Any] = {"as_json": as_json, "draw": draw, "plot": plot}
    if name == "space-time":
        from slipfront.cli.marching import march_command  # most scenes need no march

        march_command(problem, label, end_time, march_options, asked_for, quiet=quiet, **shown)
        return
    check_no_march_options(march_options, problem)
    _solve_exactly(problem, label, end_time, asked_for, **shown)


def _drawing(plot: Path | None, figure: str | None) -> Draw | None:
    """Return the function that draws the requested figure; its output path is checked first."""
    if plot is None:
        if figure is not None:
            raise SceneError("--figure needs --plot; give both.")
        return None
    require("slipfront solve --plot", *PLOT)
    from compare.figures.named import DEFAULT_FIGURE, find_figure
    from compare.figures.saving import figure_format

    figure_format(plot)
    check_file(plot)
    return find_figure(DEFAULT_FIGURE if figure is None else figure)


def _solve_exactly(
    problem: Any,
    label: str,
    end_time: float | None,
    points: AskedPoints | None,
    *,
    as_json: bool,
    draw: Draw | None,
    plot: Path | None,
) -> None:
    """Solve a self-similar problem and print the result.

    Raises
    ------
    ComputationError
        If the answer has not converged; it is printed before.
    """
    if end_time is not None:
        checked_size("solve: end_time", end_time)
    solution = solve(problem, method="self-similar")
    if draw is not None and plot is not None:
        from compare.figures.saving import save_figure

        save_figure(draw(solution), plot)
    if as_json:
        document = solution_document(solution, end_time)
        document = document if points is None else points.with_units(document, solution)
        terminal.print_json("solve", document, files=[] if plot is None else [plot])
    else:
        console = Console()
        if points is not None:  # what was asked for comes first
            console.print(points_table(solution, points))
        console.print(terminal.zones_table(solution, label))
        if end_time is not None:
            console.print(terminal.end_table(solution, end_time))
        console.print(terminal.facts_table(solution))
        if plot is not None:
            console.print(f"Drawn in {plot}", highlight=False)
    check_converged(solution, label)
