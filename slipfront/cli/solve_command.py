"""``slipfront solve``: solve a scene exactly, or march it in time if it is not self-similar."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console

from compare.comparison.documents import solution_document
from compare.output.places import check_file
from semianalytic import Scene, solve
from semianalytic.prediction import chosen_method
from semianalytic.scene.checks import checked_size
from semianalytic.scene.errors import SceneError
from semianalytic.scene.extras import PLOT, require
from semianalytic.scene.given.finding import describes_line, find_blocks, scene_label
from semianalytic.scene.given.overriding import override_scene
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
    lower_body,
    measured_option,
    option_name,
    with_options,
)
from slipfront.cli.scenes.completion import figure_names
from slipfront.cli.scenes.points import Points, points_of, points_table

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

    Step loads are self-similar and solved exactly; other load histories are marched in time.  Whole
    lines without a slot, and loads that grow as a power of time, are solved exactly as well, and so
    are step loads between different bodies: the lower one is lower_material of the file,
    or is like the upper one but for the numbers that are given.  The exit code is 4 if the solution
    has not converged, or if the error estimate of a march exceeds --rtol; the best answer is
    printed all the same.
    """
    label = scene_label(scene_name)
    if describes_line(scene_name):
        from slipfront.cli.scenes.lines import line_command, slot_scene_of  # which need scipy

        if lower:
            raise SceneError(
                f"{option_name(next(iter(lower)))} is for scenes with a slot; leave it out for "
                f"{label}, or march two bodies without a slot with slipfront run (docs/engine.md)."
            )
        alike = slot_scene_of(scene_name, overrides)
        if alike is None:
            if march_options:
                raise SceneError(
                    f"{option_name(next(iter(march_options)))} is for the space-time solver, which "
                    f"takes scenes with a slot; leave it out for {label}."
                )
            if x is not None or t is not None:
                raise SceneError(
                    f"--x and --t are for scenes with a slot; leave them out for {label}, and ask "
                    "its answer in Python for slip at points (docs/whole_line.md)."
                )
            line_command(
                scene_name,
                label,
                overrides,
                end_time,
                method=method,
                as_json=as_json,
                plot=plot,
                figure=figure,
            )
            return
        scene = alike
    else:
        scene, other = find_blocks(scene_name)
        scene = override_scene(scene, **overrides)
        body = lower_body(scene, other, lower)
        if body not in (None, scene.material):
            from semianalytic.dissimilar.described import pair_of
            from slipfront.cli.scenes.pairs import check_pair_options, pair_command

            check_pair_options(method, march_options, plot, figure)
            assert body is not None
            pair = pair_of(scene, body)
            end_time = asked(scene, "end_time", end_time, "time")
            pair_command(pair, label, end_time, points_of(scene, x, t), as_json=as_json)
            return
    draw = _drawing(plot, figure)
    end_time, points = asked(scene, "end_time", end_time, "time"), points_of(scene, x, t)
    if chosen_method(scene, method) == "space-time":
        from slipfront.cli.marching import march_command  # most scenes need no march

        march_command(
            scene,
            label,
            end_time,
            march_options,
            points,
            as_json=as_json,
            draw=draw,
            plot=plot,
            quiet=quiet,
        )
        return
    check_no_march_options(march_options)
    _solve_exactly(scene, label, end_time, points, as_json=as_json, draw=draw, plot=plot)


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
    scene: Scene,
    label: str,
    end_time: float | None,
    points: Points | None,
    *,
    as_json: bool,
    draw: Draw | None,
    plot: Path | None,
) -> None:
    """Solve a self-similar scene and print the result."""
    if end_time is not None:
        checked_size("solve: end_time", end_time)
    solution = solve(scene)
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
