"""What a march is going to take of the memory of the machine, before it starts."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from semianalytic.results.memory import check_memory, memory_limit
from semianalytic.scene.scene import Scene
from semianalytic.spacetime.marched import Marched
from semianalytic.spacetime.tuning import (
    BYTES_PER_NODE,
    BYTES_PER_POLE,
    BYTES_PER_STEP,
    BYTES_STORED,
    LEAST_LEVELS,
    TYPICAL_POLES,
)

Array = NDArray[np.float64]

_HUGE = 1e30


def state_bytes(size: int, poles: int) -> int:
    """What a march takes for a grid of `size` nodes in all [bytes], measured at its peak."""
    return size * (poles * BYTES_PER_POLE + BYTES_PER_NODE)


def check_size(
    scene: Scene, latest: float, length: float, nodes: int, memory: float | None
) -> None:
    """Refuse a grid whose state does not fit into the memory, before it is made."""
    reach = scene.material.longitudinal_speed * latest / length
    share = max(1.0, (reach + 1) / 2) + reach / 2
    size = int(min(share, _HUGE) * min(nodes, _HUGE))
    check_memory(
        state_bytes(size, TYPICAL_POLES),
        memory,
        f"march: a grid of {size:.3g} nodes",
        "give fewer nodes, an earlier end time or `latest`, or a longer length",
    )


def affordable_every(marched: Marched, memory: float | None, steps: int, table: float) -> int:
    """`every`, raised until what is stored fits into the memory.

    Raises
    ------
    SceneError
        If the march does not fit even without storing anything.
    """
    grid, earlier = marched.grid, len(marched.interface.t)
    state = state_bytes(grid.size, marched.statistics.poles)
    per_level = grid.observed * BYTES_STORED
    fixed = int(state + table + steps * BYTES_PER_STEP + (earlier + LEAST_LEVELS) * per_level)
    check_memory(
        fixed,
        memory,
        f"march: {steps:.6g} steps of {grid.size} nodes",
        "give fewer nodes, longer steps, an earlier end time, or a longer length",
    )
    levels = (memory_limit(memory) - fixed) // per_level + 1
    return max(marched.every, math.ceil(steps / levels))
