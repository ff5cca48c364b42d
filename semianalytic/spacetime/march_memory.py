"""What a march takes: a prediction before it starts, and the levels that are stored."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.results.memory import check_memory, memory_limit
from semianalytic.scene.scene import Scene
from semianalytic.spacetime.marched import Grid, Marched

Array = NDArray[np.float64]

_LEAST_LEVELS = 16
_TYPICAL_POLES = 25
_BYTES_PER_POLE = 80
_BYTES_PER_NODE = 400
_BYTES_STORED = 32
_BYTES_PER_STEP = 64
_HUGE = 1e30
_FIELDS = ("slip", "slip_rate", "shear_traction", "pressure")


def state_bytes(size: int, poles: int) -> int:
    """What a march takes for a grid of `size` nodes in all [bytes], measured at its peak."""
    return size * (poles * _BYTES_PER_POLE + _BYTES_PER_NODE)


def check_size(
    scene: Scene, latest: float, length: float, nodes: int, memory: float | None
) -> None:
    """Refuse a grid whose state does not fit into the memory, before it is made."""
    reach = scene.material.longitudinal_speed * latest / length
    share = max(1.0, (reach + 1) / 2) + reach / 2
    size = int(min(share, _HUGE) * min(nodes, _HUGE))
    check_memory(
        state_bytes(size, _TYPICAL_POLES),
        memory,
        f"march: a grid of {size:.3g} nodes",
        "lower `nodes`, `end_time` or `latest`, or raise `length`",
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
    per_level = grid.observed * _BYTES_STORED
    fixed = int(state + table + steps * _BYTES_PER_STEP + (earlier + _LEAST_LEVELS) * per_level)
    check_memory(
        fixed,
        memory,
        f"march: {steps:.6g} steps of {grid.size} nodes",
        "lower `nodes` or `end_time`, or raise `step_ratio` or `length`",
    )
    levels = (memory_limit(memory) - fixed) // per_level + 1
    return max(marched.every, math.ceil(steps / levels))


class Stored:
    """Levels of a march as they are stored, in arrays that are as long as they will be."""

    def __init__(
        self, earlier: InterfaceHistory, grid: Grid, before: int, steps: int, every: int
    ) -> None:
        self._filled = len(earlier.t)
        whole = (before + steps) // every - before // every
        levels = self._filled + (not self._filled) + whole + bool((before + steps) % every)
        self._x, self._t = grid.x, np.empty(levels + 1)
        self._fields = [np.empty((levels + 1, grid.observed)) for _ in _FIELDS]
        self._t[: self._filled] = earlier.t
        for field, name in zip(self._fields, _FIELDS, strict=True):
            field[: self._filled] = getattr(earlier, name)

    def add(self, now: float, *fields: Array) -> None:
        """Store a level: slip, slip rate, shear traction and pressure of the contact."""
        self._t[self._filled] = now
        for kept, field in zip(self._fields, fields, strict=True):
            kept[self._filled] = field[: len(self._x)]
        self._filled += 1

    def history(self) -> InterfaceHistory:
        """What was stored."""
        kept = slice(0, self._filled)
        return InterfaceHistory(self._x, self._t[kept], *(field[kept] for field in self._fields))
