"""Run one simulation, from a scene to its histories."""

from __future__ import annotations

import logging
import warnings
from collections.abc import Callable, Iterator
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

import fem  # specimens, whose modules build on this one, by their names
from fem.budget import Cost, check_fits, check_room, predict_cost
from fem.checkpoint import Keeper, run_identity, run_name
from fem.model import Model, build, timed
from fem.plan import Plan, make_plan
from fem.record import MeshRecord
from fem.results import Simulation
from fem.settings import Pace, Settings
from fem.snapshots import Snapshots
from semianalytic.results.interruption import deferred_interrupt
from semianalytic.scene.errors import ComputationError, SceneError
from semianalytic.scene.given.finding import of_scene
from semianalytic.scene.scene import Scene

_log = logging.getLogger(__name__)

RUNAWAY = 2.0
FIRST_JUDGED = 4
"""Largest kinetic energy over the work of the loads; in stable runs it is about 1 at most."""


@of_scene
def simulate(
    scene: Scene | str | PathLike[str] | Any,
    end_time: float | None = None,
    settings: Settings | None = None,
    *,
    snapshots: str | Path | None = None,
    checkpoint: str | Path | None = None,
    checkpoint_every: int | None = None,
    checkpoint_seconds: float | None = None,
    resume: bool = False,
    progress: Callable[[int, int], None] | None = None,
    memory: float | None = None,
    tell: Callable[[str], None] | None = None,
    **options: Any,
) -> Simulation:
    """Simulate a scene with finite elements and central differences.

    The method is described in docs/fem.md: contact and friction are satisfied exactly at every node
    pair of the interface, without a penalty.

    Parameters
    ----------
    scene : Scene, Specimen, str or path
        Materials, friction law, tractions and load histories, or a name or file as for `find`.  For
        a specimen, only end_time and the options of `Specimen.simulated` apply.
    end_time : float, optional
        T [time]; by default the time a shear wave takes over a length of 1.
    settings : Settings, optional
        Mesh, elements, time step and what is stored; the defaults of `Settings` unless given.
    snapshots : path, optional
        Folder for snapshots of the whole fields; the mesh is then made large enough for them.
    checkpoint : path, optional
        File to write checkpoints to.
    checkpoint_every : int, optional
        Steps between checkpoints, 100 if `checkpoint_seconds` is not given either; a further
        checkpoint is written when the run is interrupted.
    checkpoint_seconds : float, optional
        Wall-clock time between checkpoints [s]; a checkpoint is written when either interval has
        passed.
    resume : bool
        Resume from the checkpoint file if it exists; the result is the same to the last bit.
    progress : callable, optional
        Called with (step, steps) after each step.
    memory : float, optional
        Largest memory that the run may use [bytes], by default 70 % of what is available; see
        `fem.cost`.
    tell : callable, optional
        Called with a sentence when the mesh is too coarse for one of two materials or for slip
        weakening, or a snapshot or checkpoint cannot be written, while the run goes on; by default
        a warning is issued instead.
    **options
        Fields of `Settings` that replace those of `settings`: resolution, damping, step_ratio,
        model, mesh, every, frames.

    Returns
    -------
    Simulation, or LineSimulation for a specimen

    Raises
    ------
    SceneError
        If an option is out of range, a load turns back faster than the mesh can follow, the run
        would take too much memory, different materials slide ahead of all waves, or friction falls
        with slip rate faster than the interface can radiate.
    MissingLibraryError
        If a mesh has to be built that only gmsh can build, and gmsh cannot be loaded.
    DataFileError
        If the mesh cache cannot be used, the folder of snapshots or checkpoints cannot be written
        or has no room for them, or the checkpoint is damaged or of another run.  A run goes on if
        the disk becomes full later: see `Simulation.unwritten`.
    ComputationError
        If the run becomes unstable or values are no longer finite; files that were written are
        kept.
    KeyboardInterrupt
        On Ctrl-C, after a last checkpoint if checkpoints are written.

    Examples
    --------
    A coarse mesh, of 8 elements over the distance that a shear wave travels:

    >>> from fem import simulate
    >>> run = simulate("preloaded", resolution=8)
    >>> run.unknowns, run.status
    (1380, 'resolved')
    >>> round(float(run.max_slip(1.0)), 2)  # 0.83 in the limit of fine meshes
    0.58
    """
    specimen = fem.find_specimen(scene)
    if specimen is not None:
        simulation: Any = specimen.simulated(end_time, progress=progress, **options)
        return simulation
    plan = make_plan(scene, end_time, settings, options, full=snapshots is not None)
    pace = Pace(checkpoint_every, checkpoint_seconds)
    if resume and checkpoint is None:
        raise SceneError("simulate: there is nothing to resume from; give a checkpoint file.")
    cost = predict_cost(plan, checkpoints=checkpoint is not None)
    check_fits(plan, cost, memory, checkpoints=checkpoint is not None)
    kept = None if checkpoint is None else Path(checkpoint)
    folder = None if snapshots is None else Path(snapshots)
    _check_places(kept, folder, cost)
    complaints = Complaints(tell)
    complaints.hear(plan.caution)
    return run_plan(plan, pace, kept, folder, cost, complaints, resume=resume, progress=progress)


def run_plan(
    plan: Plan,
    pace: Pace,
    kept: Path | None,
    folder: Path | None,
    cost: Cost,
    complaints: Complaints,
    *,
    resume: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> Simulation:
    """Build the model of a plan and march it to its end; takes and raises what `simulate` does.

    Checkpoints are kept in a file, snapshots in a folder, and complaints receive sentences about
    those that cannot be written.
    """
    model = build(plan)
    seconds = dict(model.seconds)
    grid = plan.settings.mesh, plan.size, model.unknowns
    _log.info("simulate: %s, %s of side %.6g, %d unknowns", plan.name, *grid)
    with timed(seconds, "steps"), np.errstate(over="ignore", invalid="ignore"):
        record, identity = MeshRecord(model), run_identity(model)
        run = run_name(identity)
        keeper = Keeper(kept, pace, identity)
        started, written = keeper.resume(model, record) if resume else (0, [])
        pictures = folder and Snapshots(folder, model, run, started, written, cost.history)
        with deferred_interrupt() as interruption:
            for step in levels(model, started, model.steps + model.half_window):
                record.level(step)
                if pictures and pictures.is_due(step):
                    with timed(seconds, "snapshots"):
                        pictures.write(step)
                model.drift()
                frames = pictures.frames if pictures else []
                keeper.step_done(step, model, record, frames, interruption.pressed)
                complaints.hear(pictures.missing if pictures else "", keeper.missing)
                if interruption.pressed:
                    raise KeyboardInterrupt
                if progress is not None and 0 < step <= model.steps:
                    progress(step, model.steps)
    _log.info("simulate: %d steps in %.3g s", model.steps, seconds["steps"])
    settings = plan.settings
    return Simulation(
        scene=plan.scene,
        end_time=plan.end_time,
        resolution=settings.resolution,
        element_size=plan.size,
        damping=settings.damping,
        mesh=settings.mesh,
        model=plan.name,
        step_ratio=settings.step_ratio,
        time_step=model.time_step,
        critical_step=model.critical_step,
        rate_window=2 * model.half_window * model.time_step,
        steps=model.steps,
        unknowns=model.unknowns,
        seconds=seconds,
        run=run,
        unwritten=pictures.missing if pictures else "",
        **record.results(),
    )


def _check_places(checkpoint: Path | None, snapshots: Path | None, cost: Cost) -> None:
    """Raise DataFileError if snapshots or checkpoints cannot be written, or find no room."""
    if snapshots is not None:
        there = sum(frame.stat().st_size for frame in snapshots.glob("fields-*.vtu"))
        check_room(snapshots / "fields.pvd", cost.frames, "simulate: field snapshots", there)
    if checkpoint is not None:
        # the one before stays until the next one is complete
        there = checkpoint.stat().st_size if checkpoint.is_file() else 0
        check_room(checkpoint, 2 * cost.checkpoint, "simulate: checkpoints", there)


class Complaints:
    """Pass on each sentence about a file that could not be written, once."""

    def __init__(self, tell: Callable[[str], None] | None) -> None:
        self._tell = tell or self._warn
        self._heard: tuple[str, ...] = ()

    def hear(self, *sentences: str) -> None:
        """Pass on sentences that are new."""
        for sentence in sentences:
            if sentence and sentence not in self._heard:
                self._tell(sentence)
        self._heard = sentences

    @staticmethod
    def _warn(sentence: str) -> None:
        warnings.warn(sentence, stacklevel=6)


def levels(model: Model, started: int = 0, last: int | None = None) -> Iterator[int]:
    """Kick the bodies at one time level after the other; the caller lets the model `drift` between.

    The first level is 0 unless resumed, and the last one that of the end time unless given.
    """
    work = 0.0
    for step in range(started, (model.steps if last is None else last) + 1):
        model.kick(step)
        work = _check_stable(model, step, work)
        yield step


def _check_stable(model: Model, step: int, work: float) -> float:
    """Return the largest work of the loads so far; raise if the blocks move too fast for it."""
    kinetic = model.copies * sum(body.energy.kinetic for body in model.bodies)
    kinetic, work = kinetic / model.time_step**2, max(work, abs(model.joint.work.external))
    if step >= FIRST_JUDGED and kinetic > RUNAWAY * work:
        raise ComputationError(
            f"the simulation became unstable at step {step} of {model.steps}: its kinetic energy "
            f"is more than {RUNAWAY:g} times the work of the loads; lower `step_ratio` "
            f"(now {model.time_step / model.critical_step:.3g} of the critical step)."
        )
    return work
