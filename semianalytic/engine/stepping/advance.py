"""A run from one stop to the next: in equal steps where the law allows, or one by one."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from semianalytic.engine.stepping.blocks import BLOCK_STEPS, EqualSteps, Level, Reached
from semianalytic.engine.stepping.state import State
from semianalytic.engine.stepping.steps import Stepper

Array = NDArray[np.float64]

CUT = 1 + 1e-9
"""Steps that almost reach a stop, by so much of their length, are stretched to it: no sliver is
left."""


def advanced(
    stepper: Stepper,
    now: State,
    stop: float,
    add: Callable[[Sequence[float], Array, Callable[[int], State]], None],
    asked: Callable[[float], bool],
    keep: Callable[[State], None] | None = None,
) -> tuple[State, bool]:
    """Return the state at a time to stop at, and whether the run was stopped before.

    Parameters
    ----------
    stepper : Stepper
        The interface on its grid.
    now : State
        Where to start from.
    stop : float
        Time to stop at [time].
    add : function
        Takes what `Record.add` takes, after one step or several.
    asked : function of time
        Called after each step; the run ends there if it returns True.
    keep : function, optional
        Called with the state before a step that may be the last, and is then cut to end at `stop`.
    """
    stopped = False
    if stepper.ladder.climbs:
        while now.time < stop and not stopped:
            if keep is not None and stop - now.time <= stepper.ladder.length(now.rung + 1):
                keep(now)
            before, now = now, stepper.advance(now, stop)
            stopped, both = asked(now.time), [before, now]
            add([one.time for one in both], np.array([one.rate for one in both]), both.__getitem__)
        return now, stopped
    blocks = _blocks(stepper, now)

    def look(level: int) -> State:
        """Return the state at a level of the last block."""
        at, work = blocks.at(level), np.zeros(len(now.rate))
        work[stepper.touching] = at.work
        return replace(now, **vars(at) | {"work": work}, rung=0, pace=0.0)

    for whole in (True, False):
        levels = _levels(stepper, blocks.time, stop, whole)
        least = stepper.shortest * CUT if whole else 0.0
        while stop - blocks.time > least and not stopped:
            stopped = blocks.advance(levels, asked)
            add(blocks.times, blocks.levels[0], look)
        if whole and keep is not None and not stopped:
            keep(look(len(blocks.times) - 1))
    return look(len(blocks.times) - 1), stopped


def _blocks(stepper: Stepper, now: State) -> EqualSteps:
    """Return the march in equal steps from a state on."""
    fields = now.rate, now.traction, now.slip, now.state, now.work[stepper.touching]
    blocks = EqualSteps(
        stepper.grid,
        stepper.balance,
        stepper.law,
        stepper.memory,
        Reached(now.time, *fields),
        kept=slice(None),
        impedance=stepper.impedance,
        speed=stepper.speed,
        sweeps=stepper.sweeps,
        plate_rate=stepper.scene.plate_rate,
    )
    blocks.recall(stepper.pressure)
    return blocks


def _levels(stepper: Stepper, time: float, stop: float, whole: bool) -> Iterator[Level]:
    """Yield the ends of the shortest steps until a time to stop at [time], or of the `whole` ones
    before the last."""
    shortest = stepper.shortest
    least = shortest * CUT if whole else 0.0
    while stop - time > least:
        ends, steps = list[float](), list[float]()
        while len(ends) < BLOCK_STEPS and stop - time > least:
            last = stop - time <= shortest * CUT
            steps.append(stop - time if last else shortest)
            time = stop if last else time + shortest
            ends.append(time)
        for end, step, loads in zip(ends, steps, stepper.loads.over(ends), strict=True):
            yield Level(end, step, *loads, stepper.pressure)
