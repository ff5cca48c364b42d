"""One simulation from a scene to its histories."""

from __future__ import annotations

import math
import sys
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from fem.assembly import make_space
from fem.budget import Cost, check_fits, predict_cost
from fem.checkpoint import Keeper, run_identity, run_name
from fem.model import Model, build_model
from fem.plan import Plan
from fem.record import Record
from fem.resolution import check_resolved
from fem.results import Simulation
from fem.room import check_room
from fem.settings import Pace, Settings
from fem.snapshots import Snapshots
from meshes import cached_mesh
from meshes.blocks import causal_margin
from semianalytic.results.interruption import deferred_interrupt
from semianalytic.scene.errors import ComputationError, SceneError
from semianalytic.scene.scene import Material, Scene

RUNAWAY = 2.0
FIRST_JUDGED = 4
"""Kinetic energy over the work of the loads; in stable runs it is about 1 at most."""


def simulate(
    scene: Scene,
    end_time: float | None = None,
    resolution: int = 100,
    *,
    damping: float = 0.02,
    step_ratio: float = 0.95,
    model: str = "auto",
    element: str = "Q1",
    mesh: str = "squares",
    lower_material: Material | None = None,
    every: int = 1,
    snapshots: str | Path | None = None,
    frames: int = 20,
    checkpoint: str | Path | None = None,
    checkpoint_every: int | None = None,
    checkpoint_seconds: float | None = None,
    resume: bool = False,
    progress: Callable[[int, int], None] | None = None,
    memory: float | None = None,
    tell: Callable[[str], None] | None = None,
) -> Simulation:
    """Simulate a scene with finite elements and central differences.

    Loads follow the histories of the scene, friction its law.

    Parameters
    ----------
    scene : Scene
    end_time : float, optional
        T [time]; by default the time a shear wave takes over a length of 1.
    resolution : int
        Node distances per c_t T, at least 8: h = c_t T / resolution.
    damping : float
        eta of the Kelvin-Voigt damping C = eta K, in units of h / c_t; 0 for none.
    step_ratio : float
        Largest time step over the critical one, above 0.  Beyond 1 the scheme is unstable; up
        to 1.5 is accepted to show it.
    model : str
        "auto" uses one block wherever symmetry allows, which is exact; "two-blocks" never does.
    element : str
        "P1" linear triangles, "Q1" bilinear or "Q2" biquadratic quadrilaterals, all with
        diagonal mass.
    mesh : str
        "squares"; "graded", rows that grow away from the interface; or "triangles",
        unstructured, for P1.  P1 cuts squares and graded rows along a diagonal.
    lower_material : Material, optional
        Of the lower block, if it is not that of the scene.  The semi-analytic theory does not
        apply then.
    every : int
        Store every n-th step in the histories; the last one is always stored.
    snapshots : path, optional
        Folder for pictures of the whole fields; the mesh is then large enough for them.
    frames : int
        Number of pictures, at evenly spaced steps up to the end time.
    checkpoint : path, optional
        File to write checkpoints to.
    checkpoint_every : int, optional
        Steps between checkpoints, 100 if `checkpoint_seconds` is not given either; another one
        is written when the run is interrupted.
    checkpoint_seconds : float, optional
        Wall-clock time between checkpoints [s]; one is due when either is.
    resume : bool
        Go on from the checkpoint file if it is there; the result is the same to the last bit.
    progress : callable, optional
        Called with (step, steps) after each step.
    memory : float, optional
        Most that the run may take [bytes], 70 % of what is available if not given; see `fem.cost`.
    tell : callable, optional
        Called with a sentence when a snapshot or checkpoint cannot be written, while the run goes
        on; unless given, that is a warning.

    Returns
    -------
    Simulation

    Raises
    ------
    SceneError
        If an option is out of range, a load swings faster than the mesh can follow, the run would
        take too much memory, different materials slide ahead of all waves, or friction falls with
        slip rate faster than the interface can radiate.
    MissingLibraryError
        If a mesh has to be built and gmsh cannot be loaded.
    DataFileError
        If the mesh cache cannot be used, the folder of snapshots or checkpoints cannot be written
        or has no room for them, or the checkpoint is damaged or of another run.  A disk that gets
        full later ends no run: see `Simulation.unwritten`.
    ComputationError
        If the run goes unstable or values are no longer finite; what was written stays.
    KeyboardInterrupt
        On Ctrl-C, after a last checkpoint if there are any.
    """
    end_time = 1 / scene.material.shear_speed if end_time is None else end_time
    settings = Settings(
        end_time, resolution, damping, step_ratio, model, element, mesh, every, frames
    )
    resolution, every, frames = settings.resolution, settings.every, settings.frames
    damping, step_ratio = settings.damping, settings.step_ratio
    check_resolved(scene, lower_material, settings.end_time, resolution)
    pace = Pace(checkpoint_every, checkpoint_seconds)
    if resume and checkpoint is None:
        raise SceneError("simulate: there is nothing to resume from; give a checkpoint file.")
    full = snapshots is not None
    plan = Plan(scene, settings, lower_material, full)
    cost = predict_cost(plan, checkpoints=checkpoint is not None)
    check_fits(plan, cost, memory, checkpoints=checkpoint is not None)
    kept = None if checkpoint is None else Path(checkpoint)
    folder = None if snapshots is None else Path(snapshots)
    _check_places(kept, folder, cost)
    seconds: dict[str, float] = {}

    with _timed(seconds, "mesh"):
        space = make_space(cached_mesh(plan.blocks), plan.family)
    with _timed(seconds, "assembly"):
        built = build_model(
            scene,
            space,
            name=plan.name,
            size=plan.size,
            end_time=float(settings.end_time),
            damping_time=plan.damping_time,
            step_ratio=step_ratio,
            lower_material=lower_material,
        )
    with _timed(seconds, "steps"), np.errstate(over="ignore", invalid="ignore"):
        fastest = plan.fastest
        record = Record(built, every, plan.slot_length)
        identity = run_identity(scene, lower_material, settings, full, built)
        run = run_name(identity)
        keeper = Keeper(kept, pace, identity)
        started, written = keeper.resume(built, record) if resume else (0, [])
        framed = np.unique(
            np.rint(np.linspace(0, built.steps, frames + 1)[1:]).astype(int)
        ).tolist()
        pictures = None
        if folder is not None:
            due = sum(step < started for step in framed)
            pictures = Snapshots(folder, built, scene, run, written, due, cost.history)
        complaints = _Complaints(tell)
        forerun = causal_margin(fastest, settings.end_time, plan.size, plan.damping_time)
        with deferred_interrupt() as interruption:
            for step in _march(built, record, started, fastest.longitudinal_speed, forerun):
                if pictures is not None and step in framed and not pictures.failed:
                    with _timed(seconds, "snapshots"):
                        pictures.write(step * built.time_step, framed.index(step) + 1)
                _drift(built, step)
                listed = [] if pictures is None else pictures.frames
                keeper.step_done(step, built, record, listed, interruption.pressed)
                complaints.hear(pictures.missing if pictures else "", keeper.missing)
                if interruption.pressed:
                    raise KeyboardInterrupt
                if progress is not None and step:
                    progress(step, built.steps)
    interface, slot, energy = record.histories()
    return Simulation(
        scene=scene,
        end_time=float(settings.end_time),
        resolution=resolution,
        element_size=plan.size,
        damping=damping,
        element=element,
        mesh=mesh,
        model=plan.name,
        lower_material=lower_material,
        time_step=built.time_step,
        critical_step=built.critical_step,
        steps=built.steps,
        unknowns=built.unknowns,
        interface=interface,
        state=record.states,
        path=built.interface.path,
        friction_work=built.interface.friction_work(),
        slot=slot,
        energy=energy,
        seconds=seconds,
        peak_memory=peak_memory(),
        run=run,
        unwritten=pictures.missing if pictures else "",
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


class _Complaints:
    """Passes on each sentence about what could not be written, once."""

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
        warnings.warn(sentence, stacklevel=4)


def _march(
    model: Model, record: Record, started: int, speed: float, forerun: float
) -> Iterator[int]:
    """Kick, time level by time level; whoever iterates lets the bodies drift.

    Parameters
    ----------
    model : Model
    record : Record
        Told about every time level.
    started : int
        First time level, 0 unless resumed.
    speed : float
        Fastest wave [length / time].
    forerun : float
        How far beyond its front nodes may already move [length].
    """
    work = 0.0
    for step in range(started, model.steps + 1):
        front = speed * (step + 1) * model.time_step
        for load in model.loads:
            load.set(step)
        for body in model.bodies:
            body.activate(model.numbering.reached(front + forerun))
            body.kick(_part(step))
        work = _check_stable(model, step, work)
        model.interface.act(_part(step))
        record.level(step)
        yield step


def _part(step: int) -> float:
    """Fraction of a step for which the forces at a time level act."""
    return 0.5 if step == 0 else 1.0


def _drift(model: Model, step: int) -> None:
    for body in model.bodies:
        body.drift(_part(step))


def _check_stable(model: Model, step: int, work: float) -> float:
    """Largest work of the loads so far; raise if the blocks move faster than that can explain."""
    kinetic = sum(body.energy.kinetic for body in model.bodies)
    if not math.isfinite(kinetic):
        raise ComputationError(
            f"the simulation lost its finite values at step {step} of {model.steps}; "
            "lower the step ratio, or give loads and moduli of ordinary size."
        )
    loads = sum(body.energy.external for body in model.bodies) * model.copies
    base = model.interface.work.external * model.time_step**2
    work = max(work, abs(loads) + abs(base))
    # The work of the base tractions on slip is known one step late, which counts at the start.
    if step >= FIRST_JUDGED and kinetic * model.copies > RUNAWAY * work:
        raise ComputationError(
            f"the simulation went unstable at step {step} of {model.steps}: its kinetic energy "
            f"is more than {RUNAWAY:g} times the work of the loads; lower the step ratio "
            f"(now {model.time_step / model.critical_step:.3g} of the critical step)."
        )
    return work


@contextmanager
def _timed(seconds: dict[str, float], stage: str) -> Iterator[None]:
    started = time.perf_counter()
    yield
    seconds[stage] = seconds.get(stage, 0.0) + time.perf_counter() - started


def peak_memory() -> int:
    """Largest memory of this process since its program started [bytes].

    On Linux `ru_maxrss` still holds that of the process it was started from.
    """
    status = Path("/proc/self/status")
    if status.exists():
        lines = dict(line.split(":", 1) for line in status.read_text().splitlines() if ":" in line)
        if "VmHWM" in lines:
            return 1024 * int(lines["VmHWM"].split()[0])
    import resource

    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else 1024 * peak
