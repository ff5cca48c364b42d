"""Equal steps of a contact that stays closed, whose sums over time are made block by block."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from semianalytic.engine.stepping.balance import Balance
from semianalytic.engine.stepping.line import Grid
from semianalytic.engine.stepping.means import check_feedback, damped
from semianalytic.memory.line_memory import LineMemory
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import ComputationError
from semianalytic.scene.laws.law import Law

BLOCK_STEPS = 64
"""Steps that are recorded at once: 16 take 1.2 times as long, 256 as long (256 nodes)."""


class Level(NamedTuple):
    """The loads that act at one time level.

    Attributes
    ----------
    time : float
        Time of the level [time].
    step : float
        Length of the step that ends there [time].
    uncut, on_slot : float, or (n,) and (slots,) arrays
        Shear traction of the uncut line, and that of the slot faces [stress].
    pressure : (contact,) array
        Contact pressure at the nodes [stress].
    """

    time: float
    step: float
    uncut: float | Array
    on_slot: float | Array
    pressure: Array


@dataclass(frozen=True, eq=False)
class Reached:
    """The state that steps of a closed contact start from.

    Attributes
    ----------
    time : float
        Time reached [time].
    rate : (n,) array
        Relative slip rate, slots included [length / time].
    traction, slip : (kept,) arrays
        Shear traction [stress] and slip [length] of the nodes that are summed.
    state, work : (contact,) arrays
        State of friction, and work of friction [stress length].
    """

    time: float
    rate: Array
    traction: Array
    slip: Array
    state: Array
    work: Array


def block_of(size: int) -> int:
    """Return how many steps of so many nodes make a block, whose fields stay in the cache."""
    # With half a march takes 1.1 times as long.  An even number: a march on half the nodes takes
    # half as many steps.
    return 2 * max(1, min(BLOCK_STEPS, (1 << 15) // size) // 2)


class ClosedLine(Protocol):
    """A line whose contact stays closed, under laws that stick, as `EqualSteps` steps it.

    Attributes
    ----------
    grid : Grid
        Nodes.
    balance : Balance
        The local problem.
    law : Law
        Friction, drawn on the nodes of the contact.
    memory : LineMemory
        Memory of past slip.
    impedance, speed : float
        Traction per slip rate [stress time / length]; speed of shear waves, in whose paths the
        memory counts [length / time].
    sweeps : int
        Iterations of a step, even: with 1 or 3 marches grow; 4 change slip rates by up to 4e-5.
    jumps : sequence of float
        Times at which loads jump [time].
    kept : slice or (n,) array of bool
        Nodes whose traction and slip are wanted; those of the contact at least.
    damping : float
        Least feedback of the shortest wave; 0 damps nothing.
    means_last : bool
        Whether only the last sweep takes means over cells (`area_means`).
    plate_rate : float
        Slip rate of the bodies far away [length / time].
    """

    grid: Grid
    balance: Balance
    law: Law
    memory: LineMemory
    impedance: float
    speed: float
    jumps: Sequence[float]
    kept: slice | NDArray[np.bool_] = slice(None)
    damping: float = 0.0
    means_last: bool = False
    plate_rate: float = 0.0
    sweeps: int = 2

    def levels(self, ends: list[float], steps: list[float]) -> Iterator[Level]:
        """Yield the ends of steps of these lengths, which follow on those before [time]."""

    def after(self, time: float, step: float) -> Level:
        """Return a level just after loads have jumped, before steps of a length [time]."""


class EqualSteps:
    """The march of a closed contact in equal steps, under a law that sticks.

    Slip rate is linear in time over a step; the contribution of its end value to the memory is
    iterated in sweeps.

    Parameters
    ----------
    line : ClosedLine
        Nodes, friction, loads and memory.
    reached : Reached
        Where the steps start from.
    block : int, optional
        Steps whose sums are made at once; as many as stay in the cache by default.

    Attributes
    ----------
    time : float
        Time reached [time].
    times : list of float
        Times of the last block and the one before it, (k + 1,) [time].
    pressures : list of arrays
        Pressures of these, (contact,) each [stress].
    """

    def __init__(self, line: ClosedLine, reached: Reached, block: int | None = None) -> None:
        self._grid, self._balance, self._law = line.grid, line.balance, line.law
        self._memory, self._kept, self._impedance = line.memory, line.kept, line.impedance
        self._speed, self._sweeps, self._damping = line.speed, line.sweeps, line.damping
        self._means_last, self._plate = line.means_last, line.plate_rate
        self._follows = self._law.follows_state
        size = len(reached.rate)
        self.block = block or block_of(size)
        # the levels of a block, of which the first is the one before it
        values = reached.rate, reached.traction, reached.slip, reached.state, reached.work
        self._fields = [np.empty((self.block + 1, len(value))) for value in values]
        for field, value in zip(self._fields, values, strict=True):
            field[0] = value
        self._rates, self._tractions, self._slips, self._states, self._works = self._fields
        self._powers = np.zeros_like(self._works)
        self._last, self.times, self.pressures = 0, [reached.time], list[Array]()
        shape = self._grid.rows, self._memory.size
        self._transform = self._amplitudes(self._rates[0], np.empty(shape))
        self._stopping, self._step, self._feedback = np.empty(size), 0.0, np.zeros(shape[1])

    @property
    def time(self) -> float:
        """Time reached [time]."""
        return self.times[-1]

    def at(self, level: int) -> Reached:
        """Return the state at a level of the last block, of which 0 is the one before it."""
        return Reached(self.times[level], *(field[level].copy() for field in self._fields))

    @property
    def reached(self) -> Reached:
        """The state that is reached."""
        return self.at(self._last)

    @property
    def levels(self) -> tuple[Array, ...]:
        """Slip rate, traction, slip, state and work of the last block, (k + 1, ...) each.

        The first level is the one before the block.
        """
        return tuple(field[: self._last + 1] for field in self._fields)

    def recall(self, pressure: Array) -> None:
        """Go on from a level of an earlier march, with its pressure (contact,)."""
        self._turn_over()
        self.pressures = [pressure]
        rate, traction = self._rates[0], np.empty(len(self._rates[0]))
        traction[self._kept] = self._tractions[0]
        on, state = self._balance.on, self._states[0]
        self._balance.recall(traction[on], rate[on], state, pressure)
        self._powers[0] = self._power(rate[on], state, pressure)

    def jump(self, level: Level) -> None:
        """Change slip rate and traction as a jump of the loads does.

        The memory is an integral over the past, which a jump does not change; slip rate and
        traction change at once, through the local term.
        """
        self._turn_over()
        rate, state, balance = self._rates[0], self._states[0], self._balance
        balance.forget()
        balance.turn()
        self._memory.settle(self._transform)  # with which it no longer depends on the newest rate
        held = self._memory.convolution(self._transform)[0]
        self._stop(held * -self._impedance, level)
        balance.closed(self._stopping, level.on_slot, state, level.pressure, rate)
        self._tractions[0] = (self._stopping - self._impedance * rate)[self._kept]
        self._powers[0] = self._power(rate[balance.on], state, level.pressure)
        self._amplitudes(rate, self._transform)
        self.times, self.pressures = [level.time], [level.pressure]

    def advance(self, levels: Iterable[Level], stopping: Callable[[float], bool]) -> bool:
        """Take a block of steps; return whether it was stopped.

        Parameters
        ----------
        levels : iterable of Level
            The ends of the steps to come.
        stopping : function of time
            Called after each step; the block ends where it returns True.

        Raises
        ------
        ComputationError
            If a slip rate is no longer finite.
        """
        self._turn_over()
        stopped, steps = False, list[float]()
        for level in levels:
            self._step_to(level)
            self._last += 1
            self.times.append(level.time)
            self.pressures.append(level.pressure)
            steps.append(level.step)
            stopped = stopping(level.time)
            if stopped or self._last == self.block:
                break
        self._sum_up(np.array(steps)[:, None] / 2)
        return stopped

    def _turn_over(self) -> None:
        """Make the level that is reached the first of the next block."""
        if self._last:
            for field in (*self._fields, self._powers):
                field[0] = field[self._last]
            self._last, self.times, self.pressures = 0, [self.time], self.pressures[-1:]

    def _amplitudes(self, rate: Array, out: Array) -> Array:
        return self._grid.amplitudes(rate - self._plate if self._plate else rate, out)

    def _stop(self, amplitudes: Array, level: Level) -> None:
        """Find the traction of nodes that do not move, from what past slip exerts."""
        self._grid.values(amplitudes, self._stopping)
        self._stopping += level.uncut
        if self._plate:
            self._stopping += self._impedance * self._plate

    def _step_to(self, level: Level) -> None:
        """Take one step, from the last row of the block into the next one."""
        if level.step != self._step:
            self._step = level.step
            feedback = self._memory.table(self._speed * level.step).feedback[0]
            check_feedback(feedback)
            feedback = damped(feedback, self._grid.wavenumbers, self._damping)
            self._feedback = -self._impedance * feedback
        law, balance, transform, last = self._law, self._balance, self._transform, self._last
        rate, state, on = self._rates[last + 1], self._states[last], balance.on
        past = self._memory.advance(transform, self._speed * level.step)[0]
        past *= -self._impedance
        change = level.step, self.pressures[-1], level.pressure
        if self._follows:
            old = now = np.abs(self._rates[last][on])
        balance.turn()
        # Fixed-point iteration for the end value; its contraction factor is the feedback (< 1).
        # The state is iterated with it, since friction may depend on it.
        for sweep in range(self._sweeps):
            transform *= self._feedback
            transform += past
            self._stop(transform, level)
            if self._follows:
                state = law.evolved_under(self._states[last], (old + now) / 2, *change)
            means = not self._means_last or sweep == self._sweeps - 1
            balance.closed(self._stopping, level.on_slot, state, level.pressure, rate, means)
            if self._follows:
                now = np.abs(rate[on])
            self._amplitudes(rate, transform)
        # the first amplitude is the sum over all nodes, which is finite if all values are
        if not math.isfinite(transform[0, 0]):
            raise ComputationError(
                f"the march has values that are not finite at t = {level.time:.4g}; "
                "lower `step_ratio`."
            )
        if self._follows:
            state = law.evolved_under(self._states[last], (old + now) / 2, *change)
            self._states[last + 1] = state
        # tau = tau_stop - Z V
        traction = self._tractions[last + 1]
        np.multiply(rate[self._kept], -self._impedance, out=traction)
        traction += self._stopping[self._kept]
        self._powers[last + 1] = self._power(rate[on], state, level.pressure)

    def _power(self, rate: Array, state: Array, pressure: Array) -> Array:
        """Return the power of friction (contact,) [stress length / time].

        Where a zone ends within the stretch of a node, a part of it slips under its strength, and
        the traction at the node is less: hence the strength.
        """
        speed = np.abs(rate)
        speed *= self._balance.strength(speed, state, pressure)
        return speed

    def _sum_up(self, half: Array) -> None:
        """Add the steps of a block, of half lengths (k, 1), to slip, state and work."""
        block = slice(0, self._last + 1)
        rates = self._rates[block]
        # the rate is linear in time over a step: slip is exact, work by the trapezoidal rule
        sums = [
            (self._slips[block], rates[:, self._kept]),
            (self._works[block], self._powers[block]),
        ]
        if not self._follows:
            # without a law that asks for it the state is the accumulated |slip|
            sums.append((self._states[block], np.abs(rates[:, self._balance.on])))
        for field, values in sums:
            np.add(values[:-1], values[1:], out=field[1:])
            field[1:] *= half
            # row by row, a third of the time of np.add.accumulate
            for row in range(1, len(field)):
                field[row] += field[row - 1]
