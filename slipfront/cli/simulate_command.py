"""``slipfront simulate``: run the finite-element model of a scene and write its results."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from rich.console import Console

from compare.comparison.report import simulation_document
from compare.output.leftovers import SNAPSHOTS, forget_other_runs
from compare.output.places import save_somewhere, working_folder
from compare.output.progress import progress_bar
from semianalytic import Scene
from semianalytic.scene.errors import DataFileError
from semianalytic.scene.extras import FEM, require
from semianalytic.scene.named import find_blocks, override_scene, scene_folder, scene_label
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
    in_bytes,
    with_options,
)

if TYPE_CHECKING:
    from fem import Simulation
    from fem.budget import Cost

CHECKPOINT = "checkpoint.h5"
WORTH_SAYING = 60.0
"""Predicted run time above which it is printed before a simulation starts [s]."""
WORTH_KEEPING = 1e8
"""Predicted size of snapshots above which it is printed [bytes]."""


@with_options(
    overrides=SCENE_OPTIONS,
    lower=LOWER_OPTIONS,
    settings=MESH_OPTIONS,
    checkpoints=CHECKPOINT_OPTIONS,
)
def simulate_command(
    overrides: Mapping[str, Any],
    lower: Mapping[str, float],
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
    removes its checkpoint.  The lower block may be of another material, but the theory does not
    apply to two materials.
    """
    require("slipfront simulate", *FEM)
    label = scene_label(scene_name)
    directory = output or scene_folder(scene_name, {**overrides, **lower})
    scene, lower_material = find_blocks(scene_name)
    scene = override_scene(scene, **overrides)
    if lower or lower_material:
        changes = {name.removeprefix("lower_"): value for name, value in lower.items()}
        settings = {
            **settings,
            "lower_material": replace(lower_material or scene.material, **changes),
        }
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
    quiet: bool,
) -> Simulation:
    """Run the finite-element model and write its history, and snapshots if requested.

    Companion runs on coarser meshes follow unless `companions` is false.  `foretold` holds
    sentences that are printed before the run in place of the predicted cost.
    """
    from fem import cost, opening_sentence, simulate
    from fem.budget import check_room
    from fem.checkpoint import forget_checkpoint

    settings = {**settings, "memory": in_bytes(settings.get("memory"))}
    path = directory / CHECKPOINT
    checkpointing = _checkpointing(path, **checkpoints)
    predicted = cost(scene, **settings, snapshots=snapshots, checkpoint=bool(checkpointing))
    check_room(directory / "simulation.h5", predicted.history, "simulate: the histories")

    notes = Console(stderr=True)
    if not quiet:
        for sentence in _expected(predicted, directory, foretold):
            notes.print(f"{label}: {sentence}.", highlight=False, soft_wrap=True)
    with progress_bar(notes, quiet) as progress:
        simulation = simulate(
            scene,
            **settings,
            **checkpointing,
            snapshots=directory / SNAPSHOTS if snapshots else None,
            progress=progress,
            tell=lambda sentence: notes.print(sentence, highlight=False, soft_wrap=True),
        )
    save_somewhere(simulation.save, directory)
    forget_other_runs(directory, simulation.run)
    forget_checkpoint(path, simulation.run)
    if not quiet:
        if simulation.remark:
            notes.print(f"{label}: {simulation.remark}", highlight=False, soft_wrap=True)
        notes.print(f"{label}: {terminal.simulation_line(simulation)}", highlight=False)
        if simulation.opened:
            sentence = opening_sentence(simulation)
            notes.print(f"{label}: {sentence}.", highlight=False, soft_wrap=True)
    if simulation.unwritten:
        raise DataFileError(f"{simulation.unwritten} The histories are in {directory}.")
    return with_error_bars(simulation, directory, label, quiet=quiet) if companions else simulation


def with_error_bars(
    simulation: Simulation, directory: Path, label: str, *, keep: bool = True, quiet: bool
) -> Simulation:
    """Repeat a stored simulation on coarser meshes and print its error estimates.

    The coarser runs are stored only when both are done (and `keep` is true), so an interruption
    leaves the stored simulation as it was.
    """
    from fem import with_companions

    notes = Console(stderr=True)
    with progress_bar(notes, quiet, "coarser meshes") as progress:
        carrying = with_companions(simulation, progress)
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
