"""``slipfront solve``: solve a scene exactly, or march it in time if it is not self-similar."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from compare.comparison.documents import solution_document
from compare.output.places import check_file, save_somewhere
from compare.output.printed import PrintedTable
from semianalytic import find, solve
from semianalytic.methods import chosen
from semianalytic.parameters.overriding import override_scene
from semianalytic.results.saved import SOLVED, SavedScene, read_answer
from semianalytic.scene.checks import checked_size
from semianalytic.scene.errors import SceneError
from semianalytic.scene.extras import HDF5, PLOT, require
from semianalytic.scene.given.finding import scene_label
from semianalytic.scene.loading import HalfLine
from slipfront.cli import options, terminal
from slipfront.cli.endings.refusals import check_converged, check_no_march_options
from slipfront.cli.scenes.completion import figure_names
from slipfront.cli.scenes.points import points_of, show_answer

if TYPE_CHECKING:
    from compare.figures.named import Draw


_POINTS = "Points of the contact"

_OPTIONS: Mapping[str, Any] = {
    "end_time": options.measured_option(
        "time",
        "Time T up to which to report [time]; a march ends there, at 1 / c_t by default.",
    ),
    "x": options.option(
        "Positions x > 0 at which to print arrivals and fields, as 0.05 or 5cm,10cm.",
        _POINTS,
        flag="--x",
        metavar="X,...",
    ),
    "t": options.option(
        "Times, as 3e-5 or 30us: slip, slip rate and tractions at --x, with their errors.",
        _POINTS,
        flag="--t",
        metavar="T,...",
    ),
    "plot": options.option("Draw slip rate and tractions (.png, .pdf).", metavar="FILE"),
    "figure": options.option(
        "Figure that --plot draws: interface, or one of an installed package.",
        complete=figure_names,
        metavar="NAME",
    ),
}


@options.with_options(
    _OPTIONS,
    overrides=options.SCENE_OPTIONS,
    lower=options.LOWER_OPTIONS,
    march_options=options.MARCH_OPTIONS,
)
def solve_command(
    overrides: Mapping[str, Any],
    lower: Mapping[str, Any],
    march_options: Mapping[str, Any],
    scene_name: options.SceneArgument,
    method: options.Method = "auto",
    end_time: float | None = None,
    x: list[str] | None = None,
    t: list[str] | None = None,
    as_json: options.AsJson = False,
    plot: Path | None = None,
    figure: str | None = None,
    quiet: options.Quiet = False,
) -> None:
    """Solve a scene: slip zones, edge velocities, and everything that happens until an end time.

    With --x 5cm --t 30us a table shows when slip begins at x, and slip, slip rate and tractions at
    t, each with its error; numbers may have units if the scene is in SI units.

    Step loads are solved exactly, also between different bodies, and so are lines without a slot
    and loads that grow as a power of time.  Other scenes are marched in time.  The lower body is
    lower_material of the file, or equals the upper one except for the numbers that are given.  The
    exit code is 4 if the solution has not converged, or a march is unresolved or misses --rtol; the
    best answer is printed in any case.
    """
    label = scene_label(scene_name)
    if Path(scene_name).suffix == ".h5":
        instead = "a TOML file or a saved exact answer; --go-on continues a saved march"
        problem = read_answer(scene_name, SOLVED, SavedScene, instead, "solve it again").scene
    else:
        problem = find(scene_name)
    problem = override_scene(problem, **overrides, **lower)
    if isinstance(problem.load, HalfLine):
        from semianalytic.whole_line.drive import Drive, slot_scene

        problem = slot_scene(Drive(problem))
    name, save = chosen(problem, method).name, march_options.get("save")
    if save is not None:
        check_file(save)
    asked_for = points_of(problem, x, t)
    end_time = options.asked(problem, "end_time", end_time, "time")
    times = [*(asked_for.t if asked_for else ()), *([] if end_time is None else [end_time])]
    draw = _drawing(plot, figure, max(times, default=None) if name == "self-similar" else None)
    if name == "space-time":
        from slipfront.cli.marching import march_command  # most scenes need no march

        shown: dict[str, Any] = {"as_json": as_json, "draw": draw, "plot": plot}
        march_command(problem, label, end_time, march_options, asked_for, quiet=quiet, **shown)
        return
    check_no_march_options({k: v for k, v in march_options.items() if k != "save"}, problem)
    if save is not None:
        if save.suffix == ".nc":
            raise SceneError("--save of an exact answer writes HDF5; give a name that ends in .h5.")
        require("a saved answer", *HDF5)
    if end_time is not None:
        checked_size("solve: end_time", end_time)
    solution = solve(problem, method="self-similar")
    if save is not None:
        save_somewhere(solution.save, save, save.name)

    def tables() -> Iterator[PrintedTable]:
        yield terminal.zones_table(solution, label)
        if end_time is not None:
            yield terminal.end_table(solution, end_time)
        yield terminal.facts_table(solution)

    document = solution_document(solution, end_time)
    files = {"Saved": save, "Drawn": plot}
    show_answer(solution, document, tables(), asked_for, files, draw, as_json=as_json)
    check_converged(solution, label)


def _drawing(plot: Path | None, figure: str | None, t: float | None) -> Draw | None:
    """Return what draws the requested figure, at a time; its output path is checked first."""
    if plot is None:
        if figure is not None:
            raise SceneError("--figure needs --plot; give both.")
        return None
    require("slipfront solve --plot", *PLOT)
    from compare.figures.named import DEFAULT_FIGURE, answer_figure, find_figure
    from compare.figures.saving import figure_format

    figure_format(plot)
    check_file(plot)
    if figure is None or figure == DEFAULT_FIGURE:
        return partial(answer_figure, t=t)
    return find_figure(figure)
