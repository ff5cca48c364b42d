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


def advanced(
    stepper: Stepper,
    now: State,
    stop: float,
    add: Callable[[Sequence[float], Array, Callable[[int], State]], None],
    asked: Callable[[float], bool],
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
    """
    stopped = False
    if stepper.ladder.climbs:
        while now.time < stop and not stopped:
            before, now = now, stepper.advance(now, stop)
            stopped, both = asked(now.time), [before, now]
            add([one.time for one in both], np.array([one.rate for one in both]), both.__getitem__)
        return now, stopped
    blocks, levels = _blocks(stepper, now), _levels(stepper, now.time, stop)

    def look(level: int) -> State:
        """Return the state at a level of the last block."""
        at, work = blocks.at(level), np.zeros(len(now.rate))
        work[stepper.touching] = at.work
        return replace(now, **vars(at) | {"work": work}, rung=0, pace=0.0)

    while blocks.time < stop and not stopped:
        stopped = blocks.advance(levels, asked)
        add(blocks.times, blocks.levels[0], look)
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
        plate_rate=stepper.interface.plate_rate,
    )
    blocks.recall(stepper.pressure)
    return blocks


def _levels(stepper: Stepper, time: float, stop: float) -> Iterator[Level]:
    """Yield the ends of the shortest steps until a time to stop at [time]."""
    shortest = stepper.shortest
    while time < stop:
        ends, steps = list[float](), list[float]()
        while len(ends) < BLOCK_STEPS and time < stop:
            # A step that almost reaches the stop is stretched to it: no sliver is left.
            last = stop - time <= shortest * (1 + 1e-9)
            steps.append(stop - time if last else shortest)
            time = stop if last else time + shortest
            ends.append(time)
        for end, step, loads in zip(ends, steps, stepper.loads.over(ends), strict=True):
            yield Level(end, step, *loads, stepper.pressure)
