"""``slipfront simulate``: run the finite-element model of a scene and write its results."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
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
from slipfront.cli import options, terminal
from slipfront.cli.endings.refusals import refuse_given, specimen_settings

if TYPE_CHECKING:
    from fem import Simulation, Specimen
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
"""Part of the steps from which on they predict the time of all."""


@options.with_options(
    overrides=options.SCENE_OPTIONS,
    lower=options.LOWER_OPTIONS,
    settings=options.MESH_OPTIONS,
    checkpoints=options.CHECKPOINT_OPTIONS,
)
def simulate_command(
    overrides: Mapping[str, Any],
    lower: Mapping[str, Any],
    settings: Mapping[str, Any],
    checkpoints: Mapping[str, Any],
    scene_name: options.SceneArgument,
    output: options.Output = None,
    no_snapshots: options.NoSnapshots = False,
    no_companions: options.NoCompanions = False,
    as_json: options.AsJson = False,
    quiet: options.Quiet = False,
) -> None:
    """Simulate a scene with finite elements; write the interface history and field snapshots.

    Two more runs on coarser meshes, which take a seventh of the time, then estimate the error of
    the first.

    With --checkpoint-every or --checkpoint-seconds, a run that was interrupted or killed resumes
    with the same options and --resume; the result is identical to the last bit.  A finished run
    removes its checkpoint.  The lower block may be of another material.
    """
    require("slipfront simulate", *FEM)
    from fem.lines.plates import find_specimen

    specimen = find_specimen(scene_name)
    if specimen is not None:
        others = {**overrides, **lower, **{name: n for name, n in checkpoints.items() if n}}
        given = specimen_settings(settings, others)
        simulate_plates(specimen, given, scene_name, output, as_json=as_json, quiet=quiet)
        return
    refuse_given({"size": settings.get("size")}, "is for specimens; this one takes --resolution")
    label = scene_label(scene_name)
    directory = output or scene_folder(scene_name, {**overrides, **lower})
    scene = override_scene(find_scene(scene_name), **overrides, **lower)
    options.asked(scene, "end_time", settings.get("end_time"), "time")
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


def simulate_plates(
    specimen: Specimen,
    given: Mapping[str, Any],
    source: str,
    output: Path | None,
    *,
    as_json: bool,
    quiet: bool,
) -> None:
    """Simulate a specimen with its own settings, or those given, and write `specimen.h5`."""
    from compare.comparison.interfaces.specimens import specimen_document
    from fem.lines.march import SPECIMEN_FORMAT
    from semianalytic.results.saved import write_answer

    notes, directory = Console(stderr=True), output or scene_folder(source, given)
    with working_folder(directory) as files:
        with progress_bar(notes, quiet) as progress:
            done = specimen.simulated(**given, progress=progress)

        def save(folder: Path) -> None:
            write_answer(folder / "specimen.h5", SPECIMEN_FORMAT, done)

        save_somewhere(save, directory)
    document = specimen_document(specimen, done)
    if not quiet:
        notes.print(
            f"{scene_label(source)}: {done.unknowns:,} unknowns, {done.steps} steps in "
            f"{done.seconds:.2g} s, largest slip {document['largest_slip']:.4g}, largest gap "
            f"{document['largest_gap']:.4g}",
            highlight=False,
        )
    if as_json:
        terminal.print_json("simulate", document, files=files)
        return
    Console().print(f"Written to {directory}/", highlight=False)


def watched(
    progress: Progress,
    predicted: Cost,
    allowed: tuple[float, float],
    label: str,
    tell: Callable[[str], None],
) -> Progress:
    """The progress of a simulation of a predicted cost, which reports once if all takes too long.

    Allowed are the seconds that the simulation, its companions and its comparison were expected to
    take on this machine, and those of the budget; a fifth more than these is too long.
    """
    from fem.budget import machine_pace

    expected, budget = allowed
    share = machine_pace() * predicted.seconds / expected
    began, told = monotonic(), False

    def watch(step: int, steps: int) -> None:
        nonlocal told
        progress(step, steps)
        whole = (monotonic() - began) * steps / step / share if step else 0.0
        if not told and step >= LOOKED_AT * steps and whole > OVERRUN * budget:
            told = True
            tell(
                f"{label}: this will take about {duration(whole)}, more than the budget of "
                f"{duration(budget)}: others have taken the cores since it was planned."
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
    allowed: tuple[float, float] | None = None,
    quiet: bool,
) -> Simulation:
    """Run the finite-element model and write its history, and snapshots if requested.

    Then the same on coarser meshes, if companions are wanted.  The predicted cost is
    printed before it starts, and a warning as soon as its steps show that it will take longer than
    allowed (`watched`).
    """
    from fem import cost, simulate
    from fem.budget import check_room, machine_pace
    from fem.checkpoint import forget_checkpoint
    from fem.results import opening_sentence

    settings = {**settings, "memory": options.in_bytes(settings.get("memory"))}
    path, every = directory / CHECKPOINT, checkpoints.get("checkpoint_every") or None
    seconds, resume = checkpoints.get("checkpoint_seconds"), bool(checkpoints.get("resume"))
    checkpointing: dict[str, Any] = {}
    if every or seconds is not None or resume:
        checkpointing = {"checkpoint": path, "checkpoint_every": every}
        checkpointing |= {"checkpoint_seconds": seconds, "resume": resume}
    predicted = cost(scene, **settings, snapshots=snapshots, checkpoint=bool(checkpointing))
    check_room(directory / "simulation.h5", predicted.history, "simulate: the histories")

    notes = Console(stderr=True)

    def tell(sentence: str) -> None:
        notes.print(sentence, highlight=False, soft_wrap=True)

    if resume and not path.is_file():
        tell(f"{label}: there is no {path} to resume from; it starts at t = 0.")
    if not quiet:
        here = replace(predicted, seconds=machine_pace() * predicted.seconds)
        for sentence in foretold or ([str(here)] if here.seconds > WORTH_SAYING else []):
            tell(f"{label}: {sentence}.")
        if predicted.frames > WORTH_KEEPING:
            tell(
                f"{label}: field snapshots will take about {predicted.frames / 1e6:,.0f} MB in "
                f"{directory / SNAPSHOTS}; --no-snapshots leaves them out."
            )
    with progress_bar(notes, quiet) as bar:
        progress = bar
        if allowed is not None and not quiet:
            progress = watched(bar, predicted, allowed, label, tell)
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
            tell(f"{label}: {opening_sentence(simulation)}.")
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
    snapshots, and if they are kept, their last frames are next to those of the simulation.
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
