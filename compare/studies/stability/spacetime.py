"""Limits of space-time marches, and growth of their error with step, nu, friction and time."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from compare.figures.saving import save_figure
from compare.figures.style import cycle, describe, new_figure, styled
from compare.output.tables import write_rows
from compare.studies.profiles import last_march, step_error
from compare.studies.stability.sweeps import StudyRow
from compare.tasks.workers import Progress, run_tasks
from semianalytic import Marched, Material, Scene, solve
from semianalytic.scene.errors import SlipfrontError
from semianalytic.scene.given.named import NAMED_SCENES

RAN = "ran"
STEP_RATIOS = (0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.65, 0.7, 0.75, 0.8)
POISSON_RATIOS = (-0.99, -0.9, -0.7, -0.5, -0.2, 0.0, 0.2, 0.4, 0.45, 0.49, 0.499, 0.4999)
FRICTIONS = {
    "preloaded": (0.02, 0.05, 0.1, 0.2, 0.3, 0.45, 0.6, 1.0, 2.0, 5.0),
    "remote-shock": (0.3, 0.8, 0.99, 1.01, 1.1, 1.2, 1.25, 1.3, 1.38, 1.41),
}
END_TIMES = (1.0, 2.0, 4.0, 8.0, 16.0)
FLOOR = 1e-3
"""Error at which refused runs are drawn [%]."""

Trial = tuple[str, str, float, Scene, Callable[[], Marched]]
"""Study, case, value of the varied parameter, scene, and function that marches it."""


def trials(quick: bool) -> Iterator[Trial]:
    """Yield all marches of the study; if `quick`, on coarse grids and over shorter times."""
    nodes = 128 if quick else 512
    preloaded = NAMED_SCENES["preloaded"].scene
    for damping in (0.0, 0.7):
        for ratio in STEP_RATIOS:
            run = partial(last_march, preloaded, nodes, step_ratio=ratio, damping=damping)
            yield "step ratio", f"damping {damping:g}", ratio, preloaded, run
    for nu in POISSON_RATIOS:
        scene = replace(preloaded, material=Material(1.0, 1.0, nu))
        for damping in (0.0, 0.7):
            run = partial(last_march, scene, nodes, damping=damping)
            yield "Poisson ratio", f"damping {damping:g}", nu, scene, run
    for name, frictions in FRICTIONS.items():
        for chi in frictions:
            scene = replace(NAMED_SCENES[name].scene, friction=chi)
            yield "friction", name, chi, scene, partial(last_march, scene, nodes)
    for end in END_TIMES[:3] if quick else END_TIMES:
        settings = {"end_time": end, "nodes": int(nodes * end / 4), "every": 10**9}
        run = partial(solve, preloaded, method="space-time", **settings)
        yield "end time", "preloaded", end, preloaded, run


def stability_rows(
    quick: bool, progress: Progress | None = None, client: Any = None
) -> list[StudyRow]:
    """Return the relative L1 error of the slip rate of every march; nan if a march was refused.

    The status of a refused march is the message of the refusal.
    """
    tasks = [(trial_row, (trial,)) for trial in trials(quick)]
    done = dict(run_tasks(tasks, 1, progress, client))
    return [done[index] for index in range(len(tasks))]


def trial_row(trial: Trial) -> StudyRow:
    """Return the row of one march."""
    study, case, value, scene, run = trial
    try:
        error, status = step_error(scene, run()), RAN
    except SlipfrontError as refusal:
        error, status = math.nan, str(refusal)
    return StudyRow(study, case, "space-time", value, "slip rate error", error, status)


def write_stability(
    output: Path,
    quick: bool = False,
    progress: Progress | None = None,
    form: str = "png",
    client: Any = None,
) -> list[StudyRow]:
    """Run the study; write stability-space-time.csv and .png into a folder.

    A `client` of a Dask cluster runs the marches there.

    Raises
    ------
    DataFileError
        If a file cannot be written.
    """
    output.mkdir(parents=True, exist_ok=True)
    rows = stability_rows(quick, progress, client)
    write_rows(output / "stability-space-time.csv", rows)
    save_figure(stability_figure(rows), output / f"stability-space-time.{form}")
    return rows


@styled
def stability_figure(rows: Sequence[StudyRow]) -> Figure:
    """Draw the errors of the study's four parts; crosses at the bottom are refused runs."""
    labels = {
        "step ratio": r"$c_t\,\Delta t / h$",
        "Poisson ratio": r"$\nu$",
        "friction": r"$f$ times pressure over shear of the load",
        "end time": r"end time, at constant $h$",
    }
    figure = new_figure(9, 6.5)
    named = (NAMED_SCENES[name].scene for name in FRICTIONS)
    kept = zip(FRICTIONS, named, strict=True)
    scenes = (f"{k} (ν = {s.material.poisson_ratio:.3g}, f = {s.friction:g})" for k, s in kept)
    describe(figure, f"marches of {' and '.join(scenes)}, one thing varied at a time")
    for panel, (study, label) in zip(figure.subplots(2, 2).ravel(), labels.items(), strict=True):
        part = [row for row in rows if row.study == study]
        for case, colour in zip(dict.fromkeys(row.case for row in part), cycle(), strict=False):
            own = [row for row in part if row.case == case]
            ran = [(row.parameter, 100 * row.value) for row in own if row.status == RAN]
            refused = [(row.parameter, FLOOR) for row in own if row.status != RAN]
            panel.plot(*zip(*ran, strict=True), ".-", color=colour, label=case)
            panel.plot([x for x, _ in refused], [y for _, y in refused], "x", color=colour)
        panel.set(xlabel=label, ylabel="L1 error of slip rate [%]", yscale="log")
        if study in ("friction", "end time"):
            panel.set_xscale("log")
            panel.xaxis.set_minor_formatter(NullFormatter())
        panel.legend()
    return figure
