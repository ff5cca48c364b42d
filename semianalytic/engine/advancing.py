"""Advance a march and its companion from the state they have reached, from jump to jump.

The companion of a march is the same march on half the nodes in half the steps, whose levels are
every second of the march.  The difference between the two gives the error estimate
(docs/spacetime.md, "Error of a march").  The companion follows a block of steps behind: nothing has
to be stored for the comparison.  Each of its nodes lies half-way between two nodes of the march.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import repeat
from typing import Any

import numpy as np
from numpy.typing import NDArray

from semianalytic.engine.convergence import Departure
from semianalytic.engine.estimate import judged
from semianalytic.engine.loads import table_bytes
from semianalytic.engine.marched import Marched
from semianalytic.engine.nodes import SlotCheckpoint, state_bytes
from semianalytic.engine.slot import spans_to, spans_until
from semianalytic.engine.slot_record import Walk
from semianalytic.engine.stepping.advance import Span
from semianalytic.results.memory import check_memory, memory_limit

BYTES_STORED = 32
"""Bytes per observed node and stored level: four fields."""

Array = NDArray[np.float64]
Progress = Callable[[int, int], object]


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
    began, start = time.perf_counter(), marched.checkpoint
    assert isinstance(start, SlotCheckpoint)
    # The steps are those of a march until `latest`, wherever it stops and goes on.
    whole = spans_until(marched)
    finest, spans = min(span.step for span in whole), spans_to(whole, start.reached.time, end_time)
    if not spans:  # the end has been reached but for rounding
        return marched
    # `every` is chosen before the first step, from all memory that the march will need at once.
    every = affordable_every(marched, memory, spans, finest)
    walk, behind = Walk(marched, spans, finest, every), None
    counted, told = 0, False

    def asked(at: float) -> bool:
        nonlocal counted, told
        counted += 1
        if progress is not None and not told:
            told = progress(counted, walk.count) is True
        return told and counted % 2 == 0  # where the companion has a level

    departure, companion, ended = start.departure, marched.companion, False
    follows: Iterator[bool] = repeat(False)
    if companion is not None:
        coarser = [span._replace(step=2 * span.step) for span in spans]
        # Half of `every`, rounded up, of half the steps: levels lie at about the same times.
        behind = Walk(companion, coarser, 2 * finest, -(-every // 2), walk.blocks.block // 2)
        follows = behind.steps(lambda at: ended and at >= walk.blocks.time)
    for last in walk.steps(asked):
        ended = last
        next(follows)
        if behind is not None:
            departure = _departure(departure, walk, behind)
    if behind is not None:
        companion = behind.reached()
    seconds = {"setup": setup, "steps": time.perf_counter() - began}
    taken = {name: more + seconds[name] for name, more in start.seconds.items()}
    reached = walk.reached(departure=departure, seconds=taken)
    return judged(replace(reached, companion=companion))


def _departure(before: Departure, walk: Walk, behind: Walk) -> Departure:
    """Return a departure with the last block of a march and its companion, by the trapezoidal rule.

    Companion node i at (i + 1/2) 2h lies half-way between nodes 2i and 2i + 1 of the march.
    """
    coarse, slot = behind.grid, walk.grid.slot
    own = coarse.observe(behind.blocks.levels[0])
    contact = walk.blocks.levels[0][::2, slot : slot + 2 * coarse.observed]
    rates = (contact[:, ::2] + contact[:, 1::2]) / 2
    times = behind.blocks.times
    return Departure(
        *(
            value + coarse.spacing * float(np.trapezoid(np.abs(field).sum(axis=1), times))
            for value, field in ((before.difference, rates - own), (before.slip_rate, rates))
        )
    )


def affordable_every(marched: Any, memory: float | None, spans: list[Span], finest: float) -> int:
    """Return `every`, raised until the stored levels fit into the memory.

    Parameters
    ----------
    marched : Marched
        The march to be continued; its companion is counted too.
    memory : float or None
        Memory that the march may take [bytes].
    spans : list of Span
        The steps that are to come.
    finest : float
        Shortest step of the whole march [time].

    Raises
    ------
    SceneError
        If the march does not fit even without storing anything.
    """
    both = [march for march in (marched, marched.companion) if march is not None]
    reached, size = marched.checkpoint.reached.time, marched.checkpoint.grid.size
    steps = sum(span.steps(max(span.begin, reached)) for span in spans)
    table = sum(_table_bytes(march, at * finest) for at, march in enumerate(both, 1))
    state = sum(_state_bytes(march) for march in both)
    per_level = sum(march.nodes * BYTES_STORED for march in both)
    earlier = sum(len(march.interface.t) * march.nodes * BYTES_STORED for march in both)
    sums = len(both) * steps * 96  # for times, loads and totals
    fixed = int(state + table + sums + earlier + 16 * per_level)  # at least 16 levels must fit
    check_memory(
        fixed,
        memory,
        f"march: {steps:.6g} steps of {size} nodes",
        "lower `nodes` or `end_time`, or raise `step_ratio` or `length`",
    )
    # `fixed` has room for 16 levels already, which leaves one level more as a margin.
    levels = (memory_limit(memory) - fixed) // per_level + 1
    return max(marched.checkpoint.every, math.ceil(steps / levels))


def _table_bytes(marched: Any, finest: float) -> float:
    """Return the size of the pressure table of a march, or of its march of pressure [bytes]."""
    if marched.scene.front_slowness and marched.scene.superposition.taken_off.pressure:
        return _state_bytes(marched)
    start = marched.checkpoint
    contact = start.grid.size - start.grid.slot
    return table_bytes(marched.scene, contact, start.latest / finest)


def _state_bytes(marched: Any) -> int:
    """Return the memory that a march needs for its state [bytes]."""
    return state_bytes(marched.checkpoint.grid.size, len(marched.checkpoint.memory.poles))
