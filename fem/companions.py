"""The same run on coarser meshes, from which a simulation tells how far it may be off."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from fem.budget import predict_cost
from fem.plan import LEAST_RESOLUTION, TWO_BLOCKS, Pace, Plan, Settings
from fem.results import Simulation
from fem.run import Complaints, run_plan
from fem.snapshots import COMPANIONS, companion_folder
from semianalytic.scene.errors import SceneError


def with_companions(
    simulation: Simulation,
    progress: Callable[[int, int], None] | None = None,
    *,
    snapshots: Path | None = None,
) -> Simulation:
    """The simulation, carrying the same run at twice and at four times its element size.

    Only what is missing is run, in about an eighth and a sixty-fourth of the time.  A companion is
    left out where its resolution would be below 8, or friction falls too fast with slip rate for
    it; so are those that would follow it.  It need not follow the loads.

    Parameters
    ----------
    simulation : Simulation
        Its own numbers stay.
    progress : callable, optional
        Called with (step, steps) after each step of each companion.
    snapshots : Path, optional
        Folder of the snapshots of the simulation, into whose `companion_folder` each companion
        writes its last frame; none are written unless given.

    Returns
    -------
    Simulation

    Raises
    ------
    MissingLibraryError, DataFileError, ComputationError
        As `simulate`.
    """
    resolutions = [round(simulation.resolution / 2**n) for n in range(1, COMPANIONS + 1)]
    folders = [snapshots and companion_folder(snapshots, n + 1) for n in range(COMPANIONS)]
    runs = list(zip(resolutions, folders, strict=True))
    return _carrying(simulation, runs, progress)


def _carrying(
    simulation: Simulation,
    runs: list[tuple[int, Path | None]],
    progress: Callable[[int, int], None] | None,
) -> Simulation:
    """The simulation with companions of the given resolutions and folders, one carried by
    another."""
    if not runs:
        return simulation
    companion = simulation.companion or _coarser(simulation, *runs[0], progress)
    if companion is None:
        return simulation
    return replace(simulation, companion=_carrying(companion, runs[1:], progress))


def _coarser(
    simulation: Simulation,
    resolution: int,
    folder: Path | None,
    progress: Callable[[int, int], None] | None,
) -> Simulation | None:
    """The same run at another resolution; None where there is none so coarse.

    It need not follow the loads: what it misses of them makes error bars wide.
    """
    if resolution < LEAST_RESOLUTION:
        return None
    settings = Settings(
        resolution=resolution,
        damping=simulation.damping,
        step_ratio=simulation.step_ratio,
        model="two-blocks" if simulation.model == TWO_BLOCKS else "auto",
        element=simulation.element,
        mesh=simulation.mesh,
        lower_material=simulation.lower_material,
        every=_levels_kept(simulation, resolution),
    )
    full = folder is not None
    if full:
        settings = replace(settings, frames=1)
    plan = Plan(simulation.scene, simulation.end_time, settings, full=full, follows=False)
    silent = Complaints(lambda _: None)  # the simulation has said what its mesh is too coarse for
    try:
        return run_plan(plan, Pace(), None, folder, predict_cost(plan), silent, progress=progress)
    except SceneError:
        return None


def _levels_kept(simulation: Simulation, resolution: int) -> int:
    """`every` that keeps levels about as far apart as the simulation does."""
    kept = round(simulation.interface.t[1] / simulation.time_step)
    return max(1, kept * resolution // simulation.resolution)
