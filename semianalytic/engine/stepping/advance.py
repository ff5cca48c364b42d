"""A march from one stop to the next: in blocks of equal steps where the law allows, or one by one.

Both kinds of march, along a line and next to a slot, go through the same spans of time: each ends
at a jump of the loads, or where the march does.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import islice, pairwise
from typing import NamedTuple

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
from semianalytic.engine.stepping.steps import Stepper

Array = NDArray[np.float64]

CUT = 1e-9
"""Steps that almost reach a stop, by so much of their length, are stretched to it: no sliver is
left."""


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
    """Steps of a march: times of k levels and the one before, slip rates and slip, work of friction
    on the contact, and states by place."""

    times: Sequence[float]
    rates: Array
    slips: Array
    works: Array
    look: Callable[[int], State]


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
    stepper: Stepper,
    now: State,
    stops: Sequence[float],
    asked: Callable[[float], bool],
    keep: Callable[[State], None],
) -> Iterator[Taken]:
    """Yield the steps of a run through times to stop at, with `asked` and `keep` as of `through`.

    Parameters
    ----------
    stepper : Stepper
        The interface on its grid.
    now : State
        Where to start from.
    stops : sequence of float
        Times of jumps to come, and the end [time].
    """
    if stepper.ladder.climbs:
        yield from _one_by_one(stepper, now, stops, asked, keep)
        return
    fields = now.rate, now.traction, now.slip, now.state, now.work[stepper.touching]
    blocks = EqualSteps(stepper, Reached(now.time, *fields))
    blocks.recall(stepper.pressure)

    def look(level: int) -> State:
        """Return the state at a level of the last block."""
        at, work = blocks.at(level), np.zeros(len(now.rate))
        work[stepper.touching] = at.work
        return replace(now, **vars(at) | {"work": work}, rung=0, pace=0.0)

    begin = max((at for at in stepper.jumps if at <= now.time), default=0.0)
    spans = [Span(*span, stepper.shortest) for span in pairwise([max(begin, 0.0), *stops])]
    for _ in through(stepper, blocks, spans, asked, lambda: keep(look(len(blocks.times) - 1))):
        if len(blocks.times) > 1:
            rates, _, slips, _, works = blocks.levels
            yield Taken(blocks.times, rates, slips, works, look)


def _one_by_one(
    stepper: Stepper,
    now: State,
    stops: Sequence[float],
    asked: Callable[[float], bool],
    keep: Callable[[State], None],
) -> Iterator[Taken]:
    """Yield the steps of a run one by one, each as long as friction and convergence allow."""
    for stop in stops:
        if stop is not stops[0]:
            now = stepper.jump(now)
        while now.time < stop:
            if stop == stops[-1] and stop - now.time <= stepper.ladder.length(now.rung + 1):
                keep(now)
            both = [now, stepper.advance(now, stop)]
            now = both[1]
            stopped = asked(now.time)
            yield Taken([state.time for state in both], *levels_of(both, stepper), both.__getitem__)
            if stopped:
                return


def levels_of(states: Sequence[State], stepper: Stepper) -> tuple[Array, Array, Array]:
    """Return slip rate, slip and work of friction on the contact in states, (k, ...) each."""
    on = stepper.touching
    rows = zip(*((now.rate, now.slip, now.work[on]) for now in states), strict=True)
    rates, slips, works = map(np.array, rows)
    return rates, slips, works
