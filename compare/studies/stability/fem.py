"""Failures of the finite-element model: when they occur, how fast, and how the program reacts."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from compare.figures.saving import save_figure
from compare.figures.style import describe, new_figure, scene_words, styled
from compare.output.files import write_text
from compare.studies.profiles import errors_of
from compare.tasks.workers import Progress, run_tasks
from semianalytic import Scene, Tractions, solve
from semianalytic.scene.errors import ComputationError, SlipfrontError
from semianalytic.scene.given.named import NAMED_SCENES

if TYPE_CHECKING:
    from fem import Simulation

CSV_NAME = "fem-stability.csv"

STEP_RATIOS = (0.5, 0.7, 0.9, 0.95, 1.0, 1.01, 1.02, 1.05)
DAMPINGS = (0.0, 0.02, 0.1, 0.2)
POISSON_RATIOS = (0.3, 0.4, 0.45, 0.49, 0.499)
ELEMENTS = ("P1", "Q1", "Q2")

_PRELOADED = NAMED_SCENES["preloaded"].scene
_UNLOADED = Scene(_PRELOADED.material, 0.5, Tractions(1.0, 0.0), Tractions(-1.0, 0.5))
_RECLOSING = Scene(_PRELOADED.material, 0.5, Tractions(0.02, 0.0), Tractions(1.0, 0.5))


@dataclass(frozen=True)
class Trial:
    """One simulation of the study.

    Attributes
    ----------
    study : str
        "step", "aspect", "locking" or "chatter".
    scene : Scene
    resolution : int
    element, mesh : str
    step_ratio, damping : float
        Arguments of `fem.simulate`.
    """

    study: str
    scene: Scene
    resolution: int
    element: str = "Q1"
    mesh: str = "squares"
    step_ratio: float = 0.95
    damping: float = 0.02


@dataclass(frozen=True)
class Outcome:
    """Outcome of a trial, one line of the CSV file.

    Attributes
    ----------
    study, element, mesh : str
    resolution : int
    poisson_ratio, step_ratio, damping : float
        Settings of the trial; the step ratio is the requested one.
    aspect : float
        Largest height of an element over its width.
    outcome : str
        "completed" or "stopped".
    step, steps : int
        Last completed step, and number of steps until the end.
    error : float
        Relative L1 error of the final slip rate; nan if stopped or no exact solution is known.
    energy_residual : float
        Largest imbalance over the external work; nan if stopped.
    switches : int
        Largest number of times a node opened or closed.
    energy_gained : float
        Largest energy that friction or closing gaps returned in a step, over the external work.
    message : str
        Message of the program when it stopped.
    """

    study: str
    element: str
    mesh: str
    resolution: int
    poisson_ratio: float
    step_ratio: float
    damping: float
    aspect: float
    outcome: str
    step: int
    steps: int
    error: float
    energy_residual: float
    switches: int
    energy_gained: float
    message: str


def fem_stability(
    output: Path,
    quick: bool = False,
    progress: Progress | None = None,
    form: str = "png",
    client: Any = None,
) -> tuple[Outcome, ...]:
    """Run all trials; write `fem-stability.csv` and `fem-stability.png` into a folder.

    Parameters
    ----------
    output : path
        Folder, made if necessary.
    quick : bool
        Whether to use coarse meshes and fewer trials, for an overview.
    progress : callable, optional
        Called with the number of finished trials and of all trials.
    form : str
        Format of the figure.
    client : distributed.Client, optional
        Client of a Dask cluster that runs the trials instead of this machine.

    Returns
    -------
    tuple of Outcome

    Raises
    ------
    DataFileError
        If the files cannot be written.
    MissingLibraryError
        If meshes must be built and gmsh cannot be loaded.
    """
    planned = tuple(trials(quick))
    done = dict(run_tasks([(run_trial, (trial,)) for trial in planned], 1, progress, client))
    outcomes = tuple(done[index] for index in range(len(planned)))
    write_text(output / CSV_NAME, csv_text(outcomes))
    save_figure(stability_figure(outcomes), output / f"fem-stability.{form}")
    return outcomes


def trials(quick: bool) -> Iterator[Trial]:
    """Yield all trials, or only the quick ones."""
    resolution = 40 if quick else 100
    for element in ELEMENTS[1:2] if quick else ELEMENTS:
        for damping in DAMPINGS[1:2] if quick else DAMPINGS:
            for ratio in STEP_RATIOS[3:] if quick else STEP_RATIOS:
                yield Trial(
                    "step", _PRELOADED, resolution, element, step_ratio=ratio, damping=damping
                )
    for finer in (25, 50) if quick else (25, 50, 100, 200):
        for mesh in ("squares", "graded"):
            yield Trial("aspect", _PRELOADED, finer, mesh=mesh)
    for element in ELEMENTS:
        for poisson_ratio in POISSON_RATIOS[:2] if quick else POISSON_RATIOS:
            material = replace(_PRELOADED.material, poisson_ratio=poisson_ratio)
            scene = replace(_PRELOADED, material=material)
            yield Trial("locking", scene, 20 if quick else 40, element)
    for scene in (_UNLOADED, _RECLOSING):
        for damping in DAMPINGS[:2]:
            for element in ELEMENTS:
                yield Trial("chatter", scene, resolution, element, damping=damping)


def run_trial(trial: Trial) -> Outcome:
    """Simulate a trial and record its outcome."""
    from fem import simulate
    from fem.plan import make_plan

    names = ("resolution", "element", "mesh", "step_ratio", "damping")
    options = {name: getattr(trial, name) for name in names}
    blocks = make_plan(trial.scene, None, None, options).blocks
    reached = [0, 0]

    def note(step: int, steps: int) -> None:
        reached[:] = step, steps

    simulation, message = None, ""
    try:
        simulation = simulate(trial.scene, **options, progress=note)
    except ComputationError as error:
        message = str(error)
    return Outcome(
        study=trial.study,
        element=trial.element,
        mesh=trial.mesh,
        resolution=trial.resolution,
        poisson_ratio=trial.scene.material.poisson_ratio,
        step_ratio=trial.step_ratio,
        damping=trial.damping,
        aspect=float(np.diff(blocks.rows)[-1] / blocks.size),
        outcome="completed" if simulation else "stopped",
        step=reached[0],
        steps=reached[1],
        error=_error(simulation) if simulation else math.nan,
        energy_residual=simulation.energy.residual if simulation else math.nan,
        switches=_switches(simulation) if simulation else 0,
        energy_gained=_energy_gained(simulation) if simulation else math.nan,
        message=message,
    )


def csv_text(outcomes: Sequence[Outcome]) -> str:
    """Return the outcomes as CSV with a heading."""
    text = io.StringIO()
    writer = csv.DictWriter(text, [field.name for field in fields(Outcome)], lineterminator="\n")
    writer.writeheader()
    for outcome in outcomes:
        row = asdict(outcome)
        writer.writerow({k: f"{v:.6g}" if isinstance(v, float) else v for k, v in row.items()})
    return text.getvalue()


@styled
def stability_figure(outcomes: Sequence[Outcome]) -> Figure:
    """Draw where runs above the critical step stop, and errors over damping, mesh and nu."""
    figure = describe(
        new_figure(10, 7), f"preloaded but for what varies: {scene_words(_PRELOADED)}"
    )
    (steps, dampings), (aspects, locking) = figure.subplots(2, 2)

    tried = [o for o in outcomes if o.study == "step"]
    stopping = [o for o in tried if o.step_ratio == STEP_RATIOS[-1]]
    _draw(steps, stopping, "damping", lambda o: o.step / max(o.steps, 1), "element")
    steps.set(
        xlabel=r"damping $\eta\, c_t / h$",
        ylabel=f"part of the run completed at {STEP_RATIOS[-1]:g} × critical step",
        ylim=(0, 1.05),
    )

    kept = [o for o in tried if o.step_ratio == STEP_RATIOS[3]]
    _draw(dampings, kept, "damping", lambda o: o.error, "element")
    dampings.set(xlabel=r"damping $\eta\, c_t / h$", ylabel="relative L1 error", yscale="log")

    sizes = [o for o in outcomes if o.study == "aspect"]
    _draw(aspects, sizes, "resolution", lambda o: o.error, "mesh")
    aspects.set(xlabel=r"$c_t T / h$", ylabel="relative L1 error", xscale="log", yscale="log")

    soft = [o for o in outcomes if o.study == "locking"]
    _draw(locking, soft, "poisson_ratio", lambda o: o.error, "element")
    locking.set(xlabel="Poisson ratio", ylabel="relative L1 error", yscale="log")
    for panel in (steps, dampings, aspects, locking):
        if panel.lines:
            panel.legend()
    return figure


def _draw(
    panel: Axes,
    outcomes: Sequence[Outcome],
    over: str,
    value: Callable[[Outcome], float],
    by: str,
) -> None:
    """Draw one line per value of the field `by`, in the order of the outcomes."""
    keys = dict.fromkeys(getattr(o, by) for o in outcomes)
    for key, marker in zip(keys, "osD^v", strict=False):
        line = [o for o in outcomes if getattr(o, by) == key]
        panel.plot(
            [getattr(o, over) for o in line], [value(o) for o in line], f"{marker}-", label=key
        )


def _error(simulation: Simulation) -> float:
    """Return the relative L1 error of the final profile; nan if there is no exact solution."""
    try:
        return errors_of(simulation, solve(simulation.scene)).last
    except SlipfrontError:
        return math.nan


def _switches(simulation: Simulation) -> int:
    is_open = simulation.is_open
    return int((is_open[1:] != is_open[:-1]).sum(axis=0).max(initial=0))


def _energy_gained(simulation: Simulation) -> float:
    energy = simulation.energy
    least = min(np.diff(taken, prepend=0.0).min() for taken in (energy.friction, energy.impact))
    return max(0.0, -float(least)) / float(np.abs(energy.external).max())
