"""The memory that a march needs, predicted before it starts."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from semianalytic.engine.scenes.marched import Marched
from semianalytic.engine.scenes.nodes import extents
from semianalytic.results.memory import check_memory, memory_limit
from semianalytic.scene.scene import Scene

BYTES_STORED = 32
"""Bytes per observed node and stored level: four fields."""

Array = NDArray[np.float64]


def state_bytes(size: int, poles: int) -> int:
    """Return the memory of a march on a grid of `size` nodes [bytes], measured at its peak."""
    # Bytes at the peak of a march, measured: eight complex arrays of poles.
    return size * (poles * 128 + 400)


def check_size(
    scene: Scene,
    latest: float,
    length: float,
    nodes: int,
    memory: float | None,
    companion: bool,
    entry: float = 0.0,
) -> None:
    """Refuse a grid whose state, with that of its companion, does not fit into the memory.

    Raises
    ------
    SceneError
        If it does not fit; `memory` [bytes] is what the march may take.
    """
    # all nodes over the observed ones, as in `causal_grid`
    share = sum(extents(scene, latest, length, entry)) / length
    size = int(min(share, 1e30) * min(nodes, 1e30))
    check_memory(
        state_bytes(size + companion * (size // 2), 25),  # 15 to 40 poles
        memory,
        f"march: a grid of {size:.3g} nodes",
        "lower `nodes`, `end_time` or `latest`, or raise `length`",
    )


def affordable_every(marched: Marched, memory: float | None, steps: int, table: float) -> int:
    """Return `every`, raised until the stored levels fit into the memory.

    Parameters
    ----------
    marched : Marched
        The march to be continued; its companion is counted too.
    memory : float or None
        Memory that the march may take [bytes].
    steps : int
        Steps that are to come.
    table : float
        Size of the pressure tables [bytes].

    Raises
    ------
    SceneError
        If the march does not fit even without storing anything.
    """
    both = [one for one in (marched, marched.companion) if one is not None]
    state = sum(state_bytes(one.grid.size, one.statistics.poles) for one in both)
    per_level = sum(one.grid.observed * BYTES_STORED for one in both)
    earlier = sum(len(one.interface.t) * one.grid.observed * BYTES_STORED for one in both)
    sums = len(both) * steps * 96  # for times, loads and totals
    fixed = int(state + table + sums + earlier + 16 * per_level)  # at least 16 levels must fit
    check_memory(
        fixed,
        memory,
        f"march: {steps:.6g} steps of {marched.grid.size} nodes",
        "lower `nodes` or `end_time`, or raise `step_ratio` or `length`",
    )
    # `fixed` has room for 16 levels already, which leaves one level more as a margin.
    levels = (memory_limit(memory) - fixed) // per_level + 1
    return max(marched.every, math.ceil(steps / levels))
