"""A march under way on its grid, and beside a slot with its companion.

The companion of a march beside a slot is the same march on half the nodes in half the steps, whose
levels are every second of the march.  The difference between the two gives the error estimate
(docs/spacetime.md, "Error of a march").  The companion follows a block of steps behind: nothing has
to be stored for the comparison.  Each of its nodes lies half-way between two nodes of the march.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import repeat
from typing import Any

import numpy as np

from semianalytic.engine.convergence import Departure
from semianalytic.engine.estimate import judged
from semianalytic.engine.loads import table_bytes
from semianalytic.engine.marched import Marched
from semianalytic.engine.nodes import ContactGrid, MarchCheckpoint, SlotLayout, state_bytes
from semianalytic.engine.record import MarchRecord, checkpoint_at, resumed
from semianalytic.engine.slot import SlotLine, spans_to, spans_until
from semianalytic.engine.stepping.advance import Taken, stepped
from semianalytic.engine.stepping.blocks import block_of
from semianalytic.engine.stepping.state import State
from semianalytic.results.memory import check_memory
from semianalytic.scene.scene import Scene

BYTES_STORED = 32
"""Bytes per observed node and stored level: four fields."""

Part = tuple[ContactGrid, SlotLayout]
"""Nodes and layout of a march beside a slot, or of its companion."""


class Walk:
    """A march under way on one grid, and its record.

    Parameters
    ----------
    line : Stepper or SlotLine
        What is marched.
    record : MarchRecord
        Its record.
    end_time, latest : float
        Time to march to, and up to which the march may go on after that [time].
    earlier : Marched, optional
        The march that goes on; it is not changed.
    """

    def __init__(
        self,
        line: Any,
        record: MarchRecord,
        end_time: float,
        latest: float,
        earlier: Marched | None,
    ) -> None:
        self._line, self.record, self._latest = line, record, latest
        if earlier is None:
            self.now = line.jump(line.begin())
            if self.now.time == record.first:
                record.begin(self.now)
        else:
            self.now = resumed(line, record, earlier)
        self._spans = line.spans(self.now.time, end_time)
        self._kept: MarchCheckpoint | None = None

    def steps(self, asked: Callable[[float], bool], block: int | None = None) -> Iterator[Taken]:
        """Step on until `asked` says so, record steps, and yield them."""
        for taken in stepped(self._line, self.now, self._spans, asked, self._keep, block):
            self.record.add(taken)
            self.now = taken.look(len(taken.times) - 1)
            yield taken

    def _keep(self, state: State) -> None:
        self._kept = checkpoint_at(self._line, self.record, state, self._latest)

    def marched(self, nodes: int, stopped: bool = False, **known: Any) -> Marched:
        """Return the march until the state reached, with what else its checkpoint is to have."""
        line, record, now = self._line, self.record, self.now
        if stopped or self._kept is None:
            self._keep(now)
        assert self._kept is not None
        record.end(now)
        known |= {"end": now, "every": record.every}
        return Marched(
            scene=line.scene,
            nodes=nodes,
            interface=record.interface,
            totals=record.totals,
            seen=record.seen,
            status="",
            motion=None if record.motion is None else record.motion.motion(),
            checkpoint=replace(self._kept, **known),
        )


def advance(
    scene: Scene,
    parts: Sequence[Part],
    end_time: float,
    every: int,
    *,
    memory: float | None,
    stops: Callable[[float], bool],
    earlier: Marched | None = None,
    rtol: float | None = None,
    setup: float = 0.0,
) -> Marched:
    """March beside a slot until an end time [time], with its companion if there is one.

    A level is stored at least every so many steps, as the memory [bytes] allows.  `stops` is called
    with the time after each step; the march ends where it has returned True and its companion has a
    level.  An `earlier` march that is continued is not changed.  The `setup` of grid and memory
    took so long [s].
    """
    began, (grid, layout) = time.perf_counter(), parts[0]
    since = layout.begins if earlier is None else earlier.end_time
    whole = spans_until(scene, grid, layout)
    spans = spans_to(whole, since, end_time)
    if earlier is not None and not spans:  # the end has been reached but for rounding
        return earlier
    steps = sum(span.steps(max(span.begin, since)) for span in spans)
    # `every` is chosen before the first step, from all memory that the march will need at once.
    stored = 0 if earlier is None else len(earlier.interface.t)
    finest = min(span.step for span in whole)
    every = max(every, affordable_every(scene, parts, steps, finest, stored, memory))
    walks, first = list[Walk](), layout.begins if scene.front_too_slow else 0.0
    marches = [earlier, earlier.companion] if earlier is not None else [None] * 2
    for (nodes, laid), march in zip(parts, marches, strict=False):
        line = SlotLine(scene, nodes, laid, since)
        # half of `every`, rounded up, of half the steps: levels lie at about the same times
        levels = -(-every // laid.stride)
        record = MarchRecord(line, levels, first=first, steps=steps // laid.stride)
        walks.append(Walk(line, record, end_time, laid.latest, march))
    counted, told, ended = 0, False, False

    def asked(at: float) -> bool:
        nonlocal counted, told, ended
        counted += 1
        told = told or stops(at)
        ended = told and counted % 2 == 0  # where the companion has a level
        return ended

    block, walk, companion = block_of(grid.size), walks[0], None
    follows: Iterator[Any] = repeat(None)
    if len(walks) > 1:
        follows = walks[1].steps(lambda at: ended and at >= walk.now.time, block // 2)
    before = {} if earlier is None else earlier.checkpoint.seconds
    departure = Departure() if earlier is None else earlier.checkpoint.departure
    for taken in walk.steps(asked, block):
        other = next(follows)
        if other is not None:
            departure = _departure(departure, taken, other, grid, parts[1][0])
    if len(walks) > 1:
        companion = walks[1].marched(parts[1][0].observed)
    seconds = {"setup": setup, "steps": time.perf_counter() - began}
    seconds = {name: before.get(name, 0.0) + more for name, more in seconds.items()}
    reached = walk.marched(grid.observed, rtol=rtol, departure=departure, seconds=seconds)
    return judged(replace(reached, companion=companion))


def _departure(
    before: Departure, taken: Taken, other: Taken, grid: ContactGrid, coarse: ContactGrid
) -> Departure:
    """Return a departure with the last block of a march and its companion, by the trapezoidal rule.

    Companion node i at (i + 1/2) 2h lies half-way between nodes 2i and 2i + 1 of the march.
    """
    own, contact = other.rates[:, coarse.shown], taken.rates[::2, grid.slot :]
    contact = contact[:, : 2 * coarse.observed]
    rates = (contact[:, ::2] + contact[:, 1::2]) / 2
    return Departure(
        *(
            value + coarse.spacing * float(np.trapezoid(np.abs(field).sum(axis=1), other.times))
            for value, field in ((before.difference, rates - own), (before.slip_rate, rates))
        )
    )


def affordable_every(
    scene: Scene,
    parts: Sequence[Part],
    steps: int,
    finest: float,
    stored: int,
    memory: float | None,
) -> int:
    """Return how many of the steps to come a stored level must have to fit into the memory.

    So many levels are `stored`, and the shortest step of the whole march is the `finest` [time].
    A march that does not fit even without storing anything is refused with a SceneError.
    """
    state, table, per_level = 0.0, 0.0, 0
    for grid, layout in parts:
        own = state_bytes(grid.size, len(layout.kernel.poles))
        state, per_level = state + own, per_level + grid.observed * BYTES_STORED
        # the pressure table of a march, or its march of pressure
        if scene.front_slowness and scene.superposition.taken_off.pressure:
            table += own
        else:
            taken = layout.latest / (layout.stride * finest)
            table += table_bytes(scene, grid.size - grid.slot, taken)
    sums = len(parts) * steps * 96  # for times, loads and totals
    fixed = int(state + table + sums + (stored + 16) * per_level)  # at least 16 levels must fit
    allowed = check_memory(
        fixed,
        memory,
        f"march: {steps:.6g} steps of {parts[0][0].size} nodes",
        "lower `nodes` or `end_time`, or raise `step_ratio` or `length`",
    )
    # `fixed` has room for 16 levels already, which leaves one level more as a margin.
    levels = (allowed - fixed) // per_level + 1
    return math.ceil(steps / levels)
