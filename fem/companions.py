"""Companions of a simulation: the same run on coarser meshes, for estimates of its error."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from fem.budget import predict_cost
from fem.plan import TWO_BLOCKS, Plan
from fem.results import Simulation
from fem.run import Complaints, run_plan
from fem.settings import COMPANIONS, LEAST_RESOLUTION, Pace, Settings
from fem.snapshots import companion_folder
from semianalytic.scene.arguments import checking
from semianalytic.scene.errors import SceneError


@checking
def with_companions(
    simulation: Simulation,
    progress: Callable[[int, int], None] | None = None,
    *,
    snapshots: str | Path | None = None,
) -> Simulation:
    """Return the simulation with companions, the same run at twice and four times its element size.

    Only what is missing is run, in about an eighth and a sixty-fourth of the time.  A companion is
    left out where its resolution would be below 8, or friction falls too fast with slip rate for
    it; so are those that would follow it.  It may be too coarse for the loads.

    Parameters
    ----------
    simulation : Simulation
        The simulation; its own numbers are not changed.
    progress : callable, optional
        Called with (step, steps) after each step of each companion.
    snapshots : path, optional
        Folder of the snapshots of the simulation, into whose `companion_folder` each companion
        writes its last frame; none are written unless given.

    Returns
    -------
    Simulation

    Raises
    ------
    MissingLibraryError, DataFileError, ComputationError
        If a companion fails, for the reasons given at `simulate`.

    Examples
    --------
    >>> from fem import simulate, with_companions
    >>> from semianalytic import find
    >>> fine = with_companions(simulate(find("preloaded"), resolution=16))
    >>> fine.resolution, fine.companion.resolution
    (16, 8)
    """
    chain = [simulation]
    for number in range(1, COMPANIONS + 1):
        resolution = round(simulation.resolution / 2**number)
        folder = None if snapshots is None else companion_folder(Path(snapshots), number)
        coarser = chain[-1].companion or _coarser(chain[-1], resolution, folder, progress)
        if coarser is None:
            break
        chain.append(coarser)
    carrying = chain.pop()
    while chain:
        carrying = replace(chain.pop(), companion=carrying)
    log = logging.getLogger(__name__)
    if simulation.companion is None and log.isEnabledFor(logging.INFO):  # it takes time
        log.info("simulate: error estimate %.1e of the slip rate", carrying.error_estimate)
    return carrying


def _coarser(
    simulation: Simulation,
    resolution: int,
    folder: Path | None,
    progress: Callable[[int, int], None] | None,
) -> Simulation | None:
    """Run the same simulation at another resolution; None if none is possible at that resolution.

    It may be too coarse for the loads; error bars then become wide.
    """
    if resolution < LEAST_RESOLUTION:
        return None
    # stored levels are about as far apart as in the simulation
    kept = round(simulation.interface.t[1] / simulation.time_step)
    settings = Settings(
        resolution=resolution,
        damping=simulation.damping,
        step_ratio=simulation.time_step / simulation.critical_step,
        model="two-blocks" if simulation.model == TWO_BLOCKS else "auto",
        mesh=simulation.mesh,
        every=max(1, kept * resolution // simulation.resolution),
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
