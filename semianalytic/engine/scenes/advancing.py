"""Advance a march and its companion from the state they have reached, from jump to jump.

The companion of a march is the same march on half the nodes in half the steps, whose levels are
every second of the march.  The difference between the two gives the error estimate
(docs/spacetime.md, "Error of a march").  The companion follows a block of steps behind: nothing has
to be stored for the comparison.  Each of its nodes lies half-way between two nodes of the march.
"""

from __future__ import annotations

import math
import time
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from semianalytic.engine.convergence import Departure
from semianalytic.engine.scenes.loads import table_bytes
from semianalytic.engine.scenes.marched import Marched
from semianalytic.engine.scenes.nodes import state_bytes
from semianalytic.engine.scenes.stepping import segments_between
from semianalytic.engine.scenes.walk import Progress, Walk
from semianalytic.engine.stepping.blocks import BLOCK_STEPS
from semianalytic.results.memory import check_memory, memory_limit

BYTES_STORED = 32
"""Bytes per observed node and stored level: four fields."""

Array = NDArray[np.float64]


def advance(
    marched: Marched,
    end_time: float,
    memory: float | None,
    setup: float,
    progress: Progress | None,
) -> Marched:
    """Continue a march from the state reached to the end time, with its companion if there is one.

    Parameters
    ----------
    marched : Marched
        The march to be continued; it is not changed.
    end_time : float
        Time to march to [time].
    memory : float, optional
        Memory that the march may take [bytes].
    setup : float
        Time it took to make the grid and the memory [s], added to the statistics.
    progress : callable, optional
        Called with (step, steps) after each step, as in `march`.

    Raises
    ------
    SceneError
        If the march does not fit into the memory, or a step is beyond the stable range.
    TensionError
        If the pressure turns tensile at a node.
    ComputationError
        If values are no longer finite.
    """
    began = time.perf_counter()
    # The steps are those of a march until `latest`, wherever it stops and goes on.
    span = marched.begins, marched.latest
    whole = segments_between(marched.scene, *span, marched.step_ratio, marched.grid.spacing)
    finest = min(one.time_step for one in whole)
    parts = (one.between(marched.end_time, end_time) for one in whole)
    segments = [one for one in parts if one.steps]
    coarser = [segment.halved for segment in segments]
    companion = marched.companion
    # `every` is chosen before the first step, from all memory that the march will hold at once.
    table = _table_bytes(marched, finest)
    table += 0.0 if companion is None else _table_bytes(companion, 2 * finest)
    every = affordable_every(marched, memory, sum(part.steps for part in segments), table)
    walk, behind = Walk(marched, segments, finest, every, progress), None
    if companion is not None:
        # Half of `every`, rounded up, of half the steps: stored levels lie at about the same times.
        behind = Walk(companion, coarser, 2 * finest, -(-every // 2), None)
    departure = marched.departure
    for segment, half in zip(segments, coarser, strict=True):
        walk.begin(segment)
        if behind is not None:
            behind.begin(half)
        while walk.done < segment.steps and not walk.stopped:
            walk.advance(BLOCK_STEPS)
            if behind is not None:
                behind.advance(walk.done // 2 - behind.done, walk.stopped)
                departure = _departure(departure, walk, behind)
        walk.blocks.settle()  # a segment of another step length may follow
        if behind is not None:
            behind.blocks.settle()
        if walk.stopped:
            break
    if companion is not None and behind is not None:
        companion = behind.reached(0.0, 0.0)
    marched = walk.reached(setup, time.perf_counter() - began)
    return replace(marched, companion=companion, departure=departure)


def _departure(before: Departure, walk: Walk, behind: Walk) -> Departure:
    """Return a departure with the last block of a march and its companion, by the trapezoidal rule.

    Companion node i at (i + 1/2) 2h lies half-way between nodes 2i and 2i + 1 of the march.
    """
    slot, own = walk.grid.slot, behind.grid.observe(behind.blocks.levels[0])
    contact = walk.blocks.levels[0][::2, slot : slot + 2 * behind.grid.observed]
    rates = (contact[:, ::2] + contact[:, 1::2]) / 2
    cell = behind.grid.spacing * behind.time_step
    return Departure(
        before.difference + cell * float(np.trapezoid(np.abs(rates - own).sum(axis=1))),
        before.slip_rate + cell * float(np.trapezoid(np.abs(rates).sum(axis=1))),
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


def _table_bytes(marched: Marched, finest: float) -> float:
    """Return the size of the pressure table of a march, or of its march of pressure [bytes]."""
    if marched.scene.front_slowness and marched.scene.superposition.taken_off.pressure:
        return state_bytes(marched.grid.size, marched.statistics.poles)
    contact = marched.grid.size - marched.grid.slot
    return table_bytes(marched.scene, contact, marched.latest / finest)
