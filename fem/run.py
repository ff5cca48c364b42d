"""One simulation from a scene to its histories."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from fem.model import TWO_BLOCKS, Model, build_model, choose_model
from fem.record import Record
from fem.results import Simulation
from fem.snapshots import Snapshots
from meshes import cached_mesh, causal_blocks
from meshes.blocks import causal_margin, observed_slot
from semianalytic.errors import ComputationError, SceneError
from semianalytic.scene import Scene


def simulate(
    scene: Scene,
    end_time: float | None = None,
    resolution: int = 100,
    *,
    damping: float = 0.02,
    step_ratio: float = 0.95,
    model: str = "auto",
    every: int = 1,
    snapshots: str | Path | None = None,
    frames: int = 20,
    progress: Callable[[int, int], None] | None = None,
) -> Simulation:
    """Simulate a scene with finite elements and central differences.

    Parameters
    ----------
    scene : Scene
    end_time : float, optional
        T [time]; by default the time a shear wave takes over a length of 1.
    resolution : int
        Elements per c_t T, at least 8: the element size is h = c_t T / resolution.
    damping : float
        eta of the Kelvin-Voigt damping C = eta K, in units of h / c_t; 0 for none.
    step_ratio : float
        Largest time step over the critical one, in (0, 1].
    model : str
        "auto" uses one block wherever symmetry allows, which is exact; "two-blocks" never does.
    every : int
        Store every n-th step in the histories; the last one is always stored.
    snapshots : path, optional
        Folder for pictures of the whole fields; the mesh is then large enough for them.
    frames : int
        Number of pictures, at evenly spaced steps up to the end time.
    progress : callable, optional
        Called with (step, steps) after each step.

    Returns
    -------
    Simulation

    Raises
    ------
    SceneError
        If an option is out of range.
    MissingLibraryError
        If a mesh has to be built and gmsh cannot be loaded.
    DataFileError
        If the mesh cache cannot be used.
    ComputationError
        If values are no longer finite.
    """
    if end_time is None:
        end_time = 1 / scene.material.shear_speed
    _check_options(end_time, resolution, damping, step_ratio, model, every, frames)
    end_time = float(end_time)
    size = scene.material.shear_speed * end_time / resolution
    damping_time = damping * size / scene.material.shear_speed
    name = choose_model(scene, model)
    seconds: dict[str, float] = {}

    with _timed(seconds, "mesh"):
        mesh = cached_mesh(
            causal_blocks(
                scene.material,
                end_time,
                size,
                damping_time=damping_time,
                full=snapshots is not None,
                lower=name == TWO_BLOCKS,
            )
        )
    with _timed(seconds, "assembly"):
        built = build_model(
            scene,
            mesh,
            name=name,
            size=size,
            end_time=end_time,
            damping_time=damping_time,
            step_ratio=step_ratio,
        )
    with _timed(seconds, "steps"), np.errstate(over="ignore", invalid="ignore"):
        record = Record(built, every, observed_slot(scene.material, end_time))
        pictures = Snapshots(snapshots, built, scene) if snapshots is not None else None
        framed = set(np.rint(np.linspace(0, built.steps, frames + 1)[1:]).astype(int).tolist())
        forerun = causal_margin(scene.material, end_time, size, damping_time)
        for step in _march(built, record, scene.material.longitudinal_speed, forerun):
            if pictures is not None and step in framed:
                with _timed(seconds, "snapshots"):
                    pictures.write(step * built.time_step)
            if progress is not None and step:
                progress(step, built.steps)
    interface, slot, energy = record.histories()
    return Simulation(
        scene=scene,
        end_time=end_time,
        resolution=int(resolution),
        element_size=size,
        damping=float(damping),
        model=name,
        time_step=built.time_step,
        critical_step=built.critical_step,
        steps=built.steps,
        unknowns=built.unknowns,
        interface=interface,
        slot=slot,
        energy=energy,
        seconds=seconds,
        peak_memory=_peak_memory(),
    )


def _march(model: Model, record: Record, speed: float, forerun: float) -> Iterator[int]:
    """Take all steps, yielding after the tractions of each time level are known.

    Parameters
    ----------
    model : Model
    record : Record
        Told about every time level.
    speed : float
        Fastest wave [length / time].
    forerun : float
        How far beyond its front nodes may already move [length].
    """
    for step in range(model.steps + 1):
        part = 0.5 if step == 0 else 1.0
        front = speed * (step + 1) * model.time_step
        for body in model.bodies:
            body.activate(model.numbering.reached(front + forerun))
            body.kick(part)
            if not math.isfinite(body.energy.kinetic):
                raise ComputationError(
                    f"the simulation lost its finite values at step {step} of {model.steps}; "
                    "lower the step ratio, or give loads and moduli of ordinary size."
                )
        model.interface.act(part)
        record.level(step)
        yield step
        for body in model.bodies:
            body.drift(part)


def _check_options(
    end_time: float,
    resolution: int,
    damping: float,
    step_ratio: float,
    model: str,
    every: int,
    frames: int,
) -> None:
    _check_number("end_time", end_time)
    _check_number("damping", damping)
    _check_number("step_ratio", step_ratio)
    if end_time <= 0:
        raise SceneError(f"simulate: end_time must be positive, got {end_time}.")
    if damping < 0:
        raise SceneError(f"simulate: damping must not be negative, got {damping}.")
    if not 0 < step_ratio <= 1:
        raise SceneError(f"simulate: step_ratio must be above 0 and at most 1, got {step_ratio}.")
    _check_count("resolution", resolution, 8)
    _check_count("every", every, 1)
    _check_count("frames", frames, 1)
    if model not in ("auto", "two-blocks"):
        raise SceneError(f"simulate: model must be 'auto' or 'two-blocks', got {model!r}.")


def _check_number(name: str, value: float) -> None:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise SceneError(f"simulate: {name} must be a finite number, got {value!r}.")


def _check_count(name: str, value: int, least: int) -> None:
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or value < least:
        raise SceneError(f"simulate: {name} must be an integer of at least {least}, got {value!r}.")


@contextmanager
def _timed(seconds: dict[str, float], stage: str) -> Iterator[None]:
    started = time.perf_counter()
    yield
    seconds[stage] = seconds.get(stage, 0.0) + time.perf_counter() - started


def _peak_memory() -> int:
    """Largest memory this process has held [bytes]."""
    import resource

    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else 1024 * peak
