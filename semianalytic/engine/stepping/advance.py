"""A march from one stop to the next: in blocks of equal steps where the law allows, or one by one.

Both kinds of march, along a line and next to a slot, go through the same spans of time: each ends
at a jump of the loads, or where the march does.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import islice
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from semianalytic.engine.stepping.blocks import (
    BLOCK_STEPS,
    ClosedLine,
    EqualSteps,
    Level,
    Reached,
)
from semianalytic.engine.stepping.state import State
from semianalytic.scene.arrays import Array

CUT = 1e-9
"""Steps that almost reach a stop, by so much of their length, are stretched to it: no sliver is
left."""


Part = slice | NDArray[np.intp]
"""Some levels, by their places."""
_STEPPED = "slip_rate", "shear_traction", "slip", "state", "work"
"""Fields of `EqualSteps.levels`."""
_MEMBERS = {"slip_rate": "rate", "shear_traction": "traction", "felt_pressure": "felt"}
"""Names of fields in `State`, where they are others."""


class Span(NamedTuple):
    """A time between stops, in steps of one length, of which the last is cut, (3,) [time].

    Levels are counted from its begin: a march that goes on has the same ones to the last bit.
    """

    begin: float
    stop: float
    step: float

    def level(self, time: float) -> int:
        """Return the number of the level at a time."""
        return round((time - self.begin) / self.step)

    def steps(self, time: float) -> int:
        """Return how many steps lead from a level, given by its time, to the stop."""
        return math.ceil((self.stop - self.begin) / self.step - CUT) - self.level(time)


class Taken(NamedTuple):
    """Steps of a march: times of k levels and the one before, slip rates of all nodes, slip, and
    work of friction on the contact; or the one level just after loads have jumped.

    `show` returns a field of some of these levels by its name in `InterfaceHistory`, slip rates at
    all nodes, states at those of the contact; `look` returns the state at a level, by its place.
    """

    times: Sequence[float]
    rates: Array
    slips: Array
    works: Array
    show: Callable[[str, Part], Array]
    look: Callable[[int], State]


def _of(levels: Sequence[Any], part: Part) -> Sequence[Any]:
    """Return some of what there is at levels."""
    return levels[part] if isinstance(part, slice) else [levels[at] for at in part]


def taken_of(states: Sequence[State]) -> Taken:
    """Return states, one after the other, as steps."""

    def show(name: str, part: Part) -> Array:
        return np.array([getattr(now, _MEMBERS.get(name, name)) for now in _of(states, part)])

    times, every = [state.time for state in states], slice(None)
    rates, slips, works = (show(name, every) for name in ("slip_rate", "slip", "work"))
    return Taken(times, rates, slips, works, show, states.__getitem__)


def through(
    line: ClosedLine,
    blocks: EqualSteps,
    spans: Sequence[Span],
    asked: Callable[[float], bool],
    keep: Callable[[], None] | None = None,
) -> Iterator[None]:
    """Step through spans of time block by block, and yield after each, and after each jump.

    Parameters
    ----------
    line : ClosedLine
        The line that is marched.
    blocks : EqualSteps
        Its march, which has the levels of the last block.
    spans : sequence of Span
        Spans to come.
    asked : function of time
        Called after each step; the march ends there if it returns True.
    keep : function, optional
        Called before the last step of all, which is cut to end at a stop.
    """
    for number, span in enumerate(spans):
        if number and blocks.time in line.jumps:
            blocks.jump(line.after(blocks.time, span.step))
            yield
        levels = _levels(line, blocks.time, span)
        left, last = span.steps(blocks.time), number == len(spans) - 1 and keep is not None
        while left > last:
            stopped = blocks.advance(islice(levels, left - last), asked)
            left -= len(blocks.times) - 1
            yield
            if stopped:
                return
        if last:
            assert keep is not None
            keep()
            blocks.advance(levels, asked)
            yield


def _levels(line: ClosedLine, time: float, span: Span) -> Iterator[Level]:
    """Yield the ends of the steps of a span from a time on."""
    now = span.level(time)
    last = now + span.steps(time)
    while now < last:
        count = min(8 * BLOCK_STEPS, last - now)  # loads are evaluated at once
        ends = (span.begin + span.step * np.arange(now + 1, now + count + 1)).tolist()
        steps, now = [span.step] * count, now + count
        if now == last:
            rest = span.stop - (span.begin + span.step * (last - 1))
            # a step of another length costs a table of the memory
            steps[-1] = span.step if abs(rest - span.step) < CUT * span.step else rest
            ends[-1] = span.stop
        yield from line.levels(ends, steps)


def stepped(
    line: Any,
    now: State,
    spans: Sequence[Span],
    asked: Callable[[float], bool],
    keep: Callable[[State], None],
    block: int | None = None,
) -> Iterator[Taken]:
    """Yield the steps of a march through spans of time, and the levels after jumps of loads.

    It starts from the state `now` of a Stepper or SlotLine, in blocks of so many steps.  `asked`
    and `keep` are those of `through`; `keep` takes the state, where lines have last steps that are
    cut.
    """
    if line.climbs:
        yield from _one_by_one(line, now, [span.stop for span in spans], asked, keep)
        return
    blocks = EqualSteps(line, reached_at(now), block)
    blocks.recall(line.after(now.time, spans[0].step).pressure)

    def look(level: int) -> State:
        """Return the state at a level of the last block."""
        pressed = {} if "pressure" in line.steady else {"pressure": blocks.pressures[level]}
        return replace(now, **vars(blocks.at(level)) | pressed, rung=0, pace=0.0)

    def show(name: str, part: Part) -> Array:
        if name == "pressure":
            return np.array(_of(blocks.pressures, part))
        return blocks.levels[_STEPPED.index(name)][part]

    def kept() -> None:
        keep(look(len(blocks.times) - 1))

    for _ in through(line, blocks, spans, asked, kept if line.is_cut else None):
        rates, _, slips, _, works = blocks.levels
        yield Taken(blocks.times, rates, slips, works, show, look)


def reached_at(now: State) -> Reached:
    """Return what blocks of steps start from at a state."""
    return Reached(now.time, now.rate, now.traction, now.slip, now.state, now.work)


def _one_by_one(
    stepper: Any,
    now: State,
    stops: Sequence[float],
    asked: Callable[[float], bool],
    keep: Callable[[State], None],
) -> Iterator[Taken]:
    """Yield the steps of a run one by one, each as long as friction and convergence allow."""
    for stop in stops:
        if stop is not stops[0]:
            now = stepper.jump(now)
            yield taken_of([now])
        while now.time < stop:
            if stop == stops[-1] and stop - now.time <= stepper.ladder.length(now.rung + 1):
                keep(now)
            both = [now, stepper.advance(now, stop)]
            now = both[1]
            stopped = asked(now.time)
            yield taken_of(both)
            if stopped:
                return
