"""``slipfront simulate``: run the finite-element model of a scene and write its results."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from time import monotonic
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from rich.console import Console

from compare.comparison.mesh_choice import duration
from compare.comparison.report import simulation_document
from compare.output.leftovers import SNAPSHOTS, forget_other_runs
from compare.output.places import save_somewhere, working_folder
from compare.output.progress import progress_bar
from semianalytic import Scene
from semianalytic.parameters.overriding import override_scene
from semianalytic.scene.errors import DataFileError
from semianalytic.scene.extras import FEM, require
from semianalytic.scene.given.finding import find_scene, scene_folder, scene_label
from slipfront.cli import terminal
from slipfront.cli.options import (
    CHECKPOINT_OPTIONS,
    LOWER_OPTIONS,
    MESH_OPTIONS,
    SCENE_OPTIONS,
    AsJson,
    NoCompanions,
    NoSnapshots,
    Output,
    Quiet,
    SceneArgument,
    asked,
    in_bytes,
    with_options,
)

if TYPE_CHECKING:
    from fem import Simulation
    from fem.budget import Cost

Progress = Callable[[int, int], None]

CHECKPOINT = "checkpoint.h5"
WORTH_SAYING = 60.0
"""Predicted run time above which it is printed before a simulation starts [s]."""
WORTH_KEEPING = 1e8
"""Predicted size of its snapshots from which on that is said [bytes]."""
OVERRUN = 1.2
"""Times its budget from which on it is said that a comparison will exceed it."""
LOOKED_AT = 0.1
"""Part of the steps from which on they tell how long all will take."""


@with_options(
    overrides=SCENE_OPTIONS,
    lower=LOWER_OPTIONS,
    settings=MESH_OPTIONS,
    checkpoints=CHECKPOINT_OPTIONS,
)
def simulate_command(
    overrides: Mapping[str, Any],
    lower: Mapping[str, Any],
    settings: Mapping[str, Any],
    checkpoints: Mapping[str, Any],
    scene_name: SceneArgument,
    output: Output = None,
    no_snapshots: NoSnapshots = False,
    no_companions: NoCompanions = False,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Simulate a scene with finite elements; write the interface history and field snapshots.

    Two more runs on coarser meshes, which take a seventh of the time, then estimate the error of
    the first.

    With --checkpoint-every or --checkpoint-seconds, a run that was interrupted or killed resumes
    with the same options and --resume; the result is identical to the last bit.  A finished run
    removes its checkpoint.  The lower block may be of another material.
    """
    require("slipfront simulate", *FEM)
    label = scene_label(scene_name)
    directory = output or scene_folder(scene_name, {**overrides, **lower})
    scene = override_scene(find_scene(scene_name), **overrides, **lower)
    asked(scene, "end_time", settings.get("end_time"), "time")
    with working_folder(directory) as files:
        simulation = simulate_into(
            directory,
            scene,
            label,
            settings,
            checkpoints,
            snapshots=not no_snapshots,
            companions=not no_companions,
            quiet=quiet,
        )
    if as_json:
        terminal.print_json("simulate", simulation_document(simulation), files=files)
        return
    Console().print(f"Written to {directory}/", highlight=False)


@dataclass(frozen=True)
class Allowance:
    """How long a simulation with its companions and its comparison is expected and allowed to take.

    Attributes
    ----------
    expected, budget : float
        On this machine [s].
    """

    expected: float
    budget: float

    def watched(
        self, progress: Progress, predicted: Cost, label: str, tell: Callable[[str], None]
    ) -> Progress:
        """The progress of a simulation of a predicted cost, that tells once if all will take longer
        than the budget and a fifth."""
        from fem.budget import machine_pace

        share = machine_pace() * predicted.seconds / self.expected
        began, told = monotonic(), False

        def watch(step: int, steps: int) -> None:
            nonlocal told
            progress(step, steps)
            passed = monotonic() - began
            whole = passed * steps / step / share if step else 0.0
            if not told and step >= LOOKED_AT * steps and whole > OVERRUN * self.budget:
                told = True
                tell(
                    f"{label}: this will take about {duration(whole)}, more than the budget of "
                    f"{duration(self.budget)}: others have taken the cores since it was planned."
                )

        return watch


def simulate_into(
    directory: Path,
    scene: Scene,
    label: str,
    settings: Mapping[str, Any],
    checkpoints: Mapping[str, Any] = MappingProxyType({}),
    *,
    snapshots: bool,
    companions: bool = True,
    foretold: Collection[str] = (),
    allowance: Allowance | None = None,
    quiet: bool,
) -> Simulation:
    """Run the finite-element model and write its history, and snapshots if requested.

    Then the same on coarser meshes, if companions are wanted.  What is foretold is said before it
    starts, in place of what it is going to take.  That it will exceed its allowance is said as soon
    as its steps show it.
    """
    from fem import cost, simulate
    from fem.budget import check_room
    from fem.checkpoint import forget_checkpoint
    from fem.results import opening_sentence

    settings = {**settings, "memory": in_bytes(settings.get("memory"))}
    path = directory / CHECKPOINT
    checkpointing = _checkpointing(path, **checkpoints)
    predicted = cost(scene, **settings, snapshots=snapshots, checkpoint=bool(checkpointing))
    check_room(directory / "simulation.h5", predicted.history, "simulate: the histories")

    notes = Console(stderr=True)

    def tell(sentence: str) -> None:
        notes.print(sentence, highlight=False, soft_wrap=True)

    if checkpoints.get("resume") and not path.is_file():
        tell(f"{label}: there is no {path} to resume from; it starts at t = 0.")
    if not quiet:
        for sentence in _expected(predicted, directory, foretold):
            notes.print(f"{label}: {sentence}.", highlight=False, soft_wrap=True)
    with progress_bar(notes, quiet) as bar:
        progress = bar
        if allowance is not None and not quiet:
            progress = allowance.watched(bar, predicted, label, tell)
        simulation = simulate(
            scene,
            **settings,
            **checkpointing,
            snapshots=directory / SNAPSHOTS if snapshots else None,
            progress=progress,
            tell=tell,
        )
    save_somewhere(simulation.save, directory)
    forget_other_runs(directory, simulation.run)
    forget_checkpoint(path, simulation.run)
    if not quiet:
        notes.print(f"{label}: {terminal.simulation_line(simulation)}", highlight=False)
        if simulation.opened:
            sentence = opening_sentence(simulation)
            notes.print(f"{label}: {sentence}.", highlight=False, soft_wrap=True)
    if simulation.unwritten:
        raise DataFileError(f"{simulation.unwritten} The histories are in {directory}.")
    if not companions:
        return simulation
    return with_error_bars(simulation, directory, label, snapshots=snapshots, quiet=quiet)


def with_error_bars(
    simulation: Simulation,
    directory: Path,
    label: str,
    *,
    snapshots: bool,
    keep: bool = True,
    quiet: bool,
) -> Simulation:
    """Repeat a stored simulation on coarser meshes and print its error estimates.

    They are kept with it, if at all, once they are done: an interruption leaves it as it is.  With
    snapshots, and if they are kept, their last frames are beside those of the simulation.
    """
    from fem import with_companions

    notes = Console(stderr=True)
    with progress_bar(notes, quiet, "coarser meshes") as progress:
        folder = directory / SNAPSHOTS if snapshots and keep else None
        carrying = with_companions(simulation, progress, snapshots=folder)
    if keep and carrying.companion is not None:
        save_somewhere(carrying.save, directory)
    if not quiet:
        notes.print(f"{label}: {terminal.error_line(carrying)}.", highlight=False, soft_wrap=True)
    return carrying


def _expected(predicted: Cost, directory: Path, foretold: Collection[str]) -> Iterator[str]:
    """Yield messages to print before a run starts; times are predictions for this machine."""
    from fem.budget import machine_pace

    here = replace(predicted, seconds=machine_pace() * predicted.seconds)
    yield from foretold or ([str(here)] if here.seconds > WORTH_SAYING else [])
    if predicted.frames > WORTH_KEEPING:
        yield (
            f"field snapshots will take about {predicted.frames / 1e6:,.0f} MB in "
            f"{directory / SNAPSHOTS}; --no-snapshots leaves them out"
        )


def _checkpointing(
    path: Path,
    checkpoint_every: int = 0,
    checkpoint_seconds: float | None = None,
    resume: bool = False,
) -> dict[str, Any]:
    """Return the checkpoint options of a simulation; none if no checkpoints are requested."""
    if not (checkpoint_every or checkpoint_seconds is not None or resume):
        return {}
    return {
        "checkpoint": path,
        "checkpoint_every": checkpoint_every or None,
        "checkpoint_seconds": checkpoint_seconds,
        "resume": resume,
    }
