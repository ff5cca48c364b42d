"""``slipfront chart``: error against computing time of every method that answers a scene."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

import typer
from rich.console import Console

from compare.output.places import working_folder
from compare.output.progress import progress_bar
from semianalytic.scene.checks import checked_size
from semianalytic.scene.extras import FEM, PLOT, require
from semianalytic.scene.given.named import DEFAULT_SCENE
from slipfront.cli import options
from slipfront.cli.scenes.completion import scene_names
from slipfront.cli.terminal import print_json

_OPTIONS: Mapping[str, Any] = {
    "scenes": typer.Argument(
        metavar="[SCENE...]",
        help=f"Names of scenes, or TOML files; {DEFAULT_SCENE} unless given.",
        autocompletion=scene_names,
    ),
    "end_time": options.measured_option(
        "time", "Time of the comparison [time]; 1 / c_t by default."
    ),
    "output": options.option("Folder to write to, results/chart if not given.", metavar="DIR"),
    "fresh": options.option("Repeat finished measurements.", flag="--fresh"),
    "budget": options.option("Time for each scene, such as 30s, 5min or 1h.", metavar="TIME"),
}


@options.with_options(_OPTIONS)
def chart(
    scenes: list[str] | None = None,
    end_time: float | None = None,
    output: Path | None = None,
    figures: options.FiguresForm = "png",
    fresh: bool = False,
    budget: str = "40s",
    as_json: options.AsJson = False,
    quiet: options.Quiet = False,
) -> None:
    """Chart the error of each method that answers a scene against its computing time.

    The reference is the exact answer of a self-similar scene, otherwise a fine march.  Points
    that exceed the budget are listed; the same command measures them later.
    """
    require("slipfront chart", *FEM, *PLOT)
    from compare.chart.figure import chart_document, described, write_chart
    from compare.chart.methods import find_problem
    from compare.chart.points import measure_all, not_measured

    seconds = options.in_seconds(budget) or math.inf

    problems = [find_problem(source) for source in scenes or [DEFAULT_SCENE]]
    if end_time is not None:
        checked_size("--end-time", end_time)
        ends = [options.asked(problem.scene, "end_time", end_time, "time") for problem in problems]
        problems = [find_problem(task.source, at) for task, at in zip(problems, ends, strict=True)]
    directory, notes = output or Path("results", "chart"), Console(stderr=True)
    with working_folder(directory) as files:
        with progress_bar(notes, quiet, "measuring") as progress:
            tell = None if quiet else partial(notes.print, highlight=False)
            points = measure_all(directory, problems, end_time, fresh, progress, tell, seconds)
        write_chart(directory, points, [problem.label for problem in problems], figures)
    missing = not_measured(problems, points)
    if as_json:
        print_json("chart", {**chart_document(points), "not_measured": missing}, files=files)
        return
    if missing:
        listed = ", ".join(f"{label} {method} {setting:g}" for label, method, setting in missing)
        notes.print(f"Not measured within --budget {budget}: {listed}.", markup=False)
    for part in (*described(points), f"Written to {directory}/"):
        Console().print(part, highlight=False, markup=False)
