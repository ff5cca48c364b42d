"""Prediction of what a simulation needs: unknowns, steps, memory, time and disk space."""

from __future__ import annotations

import math
import shutil
import tempfile
import time
from bisect import bisect_right
from dataclasses import dataclass, replace
from functools import cache
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from scipy import sparse

from fem.plan import Plan, make_plan
from fem.settings import LEAST_RESOLUTION, Settings
from semianalytic.results.files import make_folder, refusal, remove_empty
from semianalytic.results.memory import check_memory, memory_limit
from semianalytic.scene.errors import DataFileError
from semianalytic.scene.given.finding import of_scene
from semianalytic.scene.scene import Scene

LIBRARIES = 10_000_000
"""Memory that does not depend on the mesh [bytes]."""
ASSEMBLY = {"squares": 1000, "triangles": 1500}
"""Memory per displacement unknown of the mesh while its matrix is put together [bytes]."""
STEPPING = {"squares": 560, "triangles": 660}
"""Memory per unknown of the mesh while the bodies march, without histories [bytes]."""
BODY = 56
"""Memory per unknown of each body [bytes]."""
STEP_TIME = {"squares": 11e-9, "triangles": 9e-9}
"""Time per unknown and step, counting unknowns that do not move yet as well [s]."""
STEP_OVERHEAD = 0.3e-3
"""Time per step that does not depend on the mesh [s]."""
SETUP_TIME = {"squares": 1.3e-6, "triangles": 20e-6}
"""Time to mesh and to assemble, per unknown [s]; of triangles most of it for the mesh."""
FRAME_TIME = 0.8e-6
"""Time per node of both blocks to write a frame [s]: 0.7e-6 on squares, 1.0e-6 on triangles."""
FRAME_SIZE = {"squares": (16, 30), "triangles": (27, 40)}
"""Size of a frame per node of both blocks at t = 0, and its increase per (t/T)^2 [bytes]."""
HISTORY_SIZE = 0.5
"""Size of `simulation.h5` over that of the histories in memory, which it compresses."""
PACE_UNKNOWNS = 2**16
"""Size of the matrix whose product measures how fast a machine is: larger than a cache."""
PACE_SECONDS = 0.4
"""Duration of the timing of such products [s], long enough to be interrupted as a simulation is
where others share the cores: half of it missed half of the time lost to them."""
PACE_TIME = 0.75e-3
"""Time of that product on an idle core of 2024, to which the times above belong [s]."""


@dataclass(frozen=True)
class Cost:
    """Prediction of what a simulation needs.

    Attributes
    ----------
    nodes : int
        Nodes of the mesh.
    unknowns : int
        Displacement unknowns of all bodies.
    steps : int
        Time steps.
    memory : int
        Peak memory in addition to what the process already uses [bytes], accurate to 30 %; below
        about 30,000 unknowns it may be too large by up to half.
    seconds : float
        Rough wall-clock time on an idle core of 2024 [s].
    history, frames, checkpoint : int
        Sizes of `simulation.h5`, of all field snapshots, and of a checkpoint near the end [bytes].

    Examples
    --------
    >>> from fem import cost
    >>> from semianalytic import find
    >>> predicted = cost(find("preloaded"), resolution=8)
    >>> predicted.unknowns, predicted.steps
    (1380, 18)
    """

    nodes: int
    unknowns: int
    steps: int
    memory: int
    seconds: float
    history: int
    frames: int
    checkpoint: int

    def __str__(self) -> str:
        minutes = max(round(self.seconds / 60), 1)
        time = f"{minutes} minute{'s' * (minutes > 1)}"
        if minutes > 90:
            time = f"{minutes / 60:.1f} hours"
        return (
            f"{self.unknowns:,} unknowns and {self.steps:,} steps will take about {time} "
            f"and {self.memory / 1e9:.1f} GB"
        )


@of_scene
def cost(
    scene: Scene | str | PathLike[str],
    end_time: float | None = None,
    settings: Settings | None = None,
    *,
    snapshots: bool = False,
    checkpoint: bool = False,
    memory: Any = math.inf,
    **options: Any,
) -> Cost:
    """Predict what `simulate` would need with these options, without building anything.

    Parameters
    ----------
    scene, end_time, settings, **options
        Arguments of `simulate`.
    snapshots, checkpoint : bool
        Whether field snapshots and checkpoints would be written.
    memory : float, optional
        Memory above which a run is refused [bytes]; none by default, and that of `simulate` if
        None.

    Returns
    -------
    Cost

    Raises
    ------
    SceneError
        If an option is out of range, a load turns back faster than the mesh can follow, or the run
        would need more memory than the limit.

    Examples
    --------
    >>> from fem import cost
    >>> cost("preloaded", resolution=8).unknowns
    1380
    """
    plan = make_plan(scene, end_time, settings, options, full=snapshots)
    predicted = predict_cost(plan, checkpoints=checkpoint)
    if not (isinstance(memory, float) and memory == math.inf):
        check_fits(plan, predicted, memory, checkpoints=checkpoint)
    return predicted


def predict_cost(plan: Plan, steps: int | None = None, *, checkpoints: bool = False) -> Cost:
    """Predict what a plan needs, of its own steps or as many as given; checkpoints, if they are
    written, pass through memory."""
    steps, every = plan.steps() if steps is None else steps, plan.settings.every
    mesh_kind, frames = plan.settings.mesh, plan.settings.frames if plan.full else 0
    matrices = 1 if plan.is_half or len(set(plan.scene.bodies)) == 1 else 2
    mesh = max(map(len, plan.bodies)) * plan.nodes * matrices // (1 if plan.is_half else 2)
    unknowns = sum(map(len, plan.bodies)) * plan.nodes
    shown = plan.nodes * (2 if plan.is_half else 1)
    contact = plan.blocks.right + 1
    slot = min(round(plan.slot_length / plan.size), plan.blocks.left)
    levels = math.ceil(steps / every) + 1
    fields = 33 if plan.is_half else 41  # with a gap where it may open
    record = levels * (fields * contact + 16 * slot) + 72 * steps
    checkpoint = 16 * unknowns + record
    least, growing = FRAME_SIZE[mesh_kind]
    grown = (frames + 1) * (2 * frames + 1) / (6 * frames) if frames else 0.0
    written = max(HISTORY_SIZE * record, checkpoint if checkpoints else 0)
    stepping = STEPPING[mesh_kind] * mesh + BODY * unknowns + record + written
    return Cost(
        nodes=plan.nodes,
        unknowns=unknowns,
        steps=steps,
        memory=int(LIBRARIES + max(ASSEMBLY[mesh_kind] * mesh, stepping)),
        seconds=(STEP_TIME[mesh_kind] * unknowns + STEP_OVERHEAD) * steps
        + SETUP_TIME[mesh_kind] * mesh
        + FRAME_TIME * shown * frames,
        history=int(HISTORY_SIZE * record),
        frames=int(shown * (least * frames + growing * grown)),
        checkpoint=checkpoint,
    )


@cache
def machine_pace() -> float:
    """Return how many times as long this machine takes as `Cost.seconds` says.

    By the mean time of sparse products such as a step is made of, measured once per process: what
    others leave of the cores counts too.
    """
    row = 2 * round(math.sqrt(PACE_UNKNOWNS / 2))
    offsets = [across * row + along for across in (-1, 0, 1) for along in range(-2, 4)]
    diagonals = np.ones((len(offsets), PACE_UNKNOWNS))
    matrix = sparse.spdiags(diagonals, offsets, PACE_UNKNOWNS, PACE_UNKNOWNS).tocsr()
    vector, products = np.ones(PACE_UNKNOWNS), 0
    matrix @ vector  # the first one fetches all of it
    start = time.perf_counter()
    passed = 0.0
    while passed < PACE_SECONDS:
        matrix @ vector
        products += 1
        passed = time.perf_counter() - start
    return passed / products / PACE_TIME


def check_fits(plan: Plan, cost: Cost, limit: float | None, *, checkpoints: bool = False) -> None:
    """Raise SceneError if a run needs more memory than it may; say which mesh or `every` would fit.

    The limit, a positive number, is in bytes; 70 % of what is available if None.
    """
    allowed = memory_limit(limit)
    if cost.memory <= allowed:
        return
    settings = plan.settings

    def memory(resolution: int, every: int) -> int:
        changed = replace(settings, resolution=resolution, every=every)
        steps = math.ceil(cost.steps * resolution / settings.resolution)
        return predict_cost(replace(plan, settings=changed), steps, checkpoints=checkpoints).memory

    sizes = range(settings.resolution)
    too_large = bisect_right(
        sizes, allowed, LEAST_RESOLUTION, key=lambda n: memory(n, settings.every)
    )
    advice = [f"lower `resolution` to {too_large - 1}"] if too_large > LEAST_RESOLUTION else []
    if memory(settings.resolution, cost.steps) <= allowed:
        every = settings.every
        while memory(settings.resolution, every) > allowed:
            every *= 2
        advice.insert(0, f"raise `every` to {every}")
    check_memory(
        cost.memory,
        limit,
        f"simulate: {cost.unknowns:,} unknowns and {cost.steps:,} steps",
        " or ".join(advice) or "shorten `end_time` or raise `memory`",
    )


def free_space(folder: Path) -> int:
    """Return the free space on the disk of a folder, which need not exist yet [bytes]."""
    place = folder.absolute()
    while not place.exists():
        place = place.parent
    return shutil.disk_usage(place).free


def check_room(path: Path, needed: int, parts: str, freed: int = 0) -> None:
    """Raise DataFileError if files cannot be written, or find no room, in the folder of a path.

    Needed is their size, freed that of files that are removed first [bytes]; parts name them as the
    subject of the sentence.
    """
    folder = path.absolute().parent
    made: list[Path] = []
    try:
        made = make_folder(folder)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise DataFileError(refusal(path, error, needed)) from error
    finally:
        remove_empty(made)
    free = free_space(folder) + freed
    if needed > free:
        raise DataFileError(
            f"{parts} need about {needed / 1e6:,.1f} MB in {folder}, and {free / 1e6:,.1f} MB are "
            "free; make room, choose another folder, or write fewer snapshots or steps."
        )
