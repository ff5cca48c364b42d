"""The time steps of a march, in segments between jumps of the loads.

A step takes the loads at its end, computes the traction that would stop each node under the memory
of past slip, from it and the friction law the slip rate (`line.Line.slip_rate`), and adds the new
slip to the memory (`LineMemory`).  Steps are summed up and recorded in blocks.
See docs/spacetime.md, "Method".
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice, pairwise

import numpy as np
from numpy.typing import NDArray

from semianalytic.memory.cosines import cosines, from_cosines
from semianalytic.memory.line_memory import LineMemory, Past
from semianalytic.scene.errors import ComputationError, TensionError
from semianalytic.scene.scene import Scene
from semianalytic.spacetime.grid.grid_loads import SWEEPS, FrontLoad, NodalPressure
from semianalytic.spacetime.grid.line import Level, Line, damped
from semianalytic.spacetime.marched import Marched
from semianalytic.spacetime.record import MarchRecord
from semianalytic.spacetime.state import MarchState

BLOCK_STEPS = 64
"""Steps that are recorded at once: 16 take 1.2 times as long, 256 as long (256 nodes)."""

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Segment:
    """A span of time from `begin` to `end` [time], divided into equal steps, without load jumps."""

    begin: float
    end: float
    steps: int

    @property
    def time_step(self) -> float:
        """Length of one step [time]."""
        return (self.end - self.begin) / self.steps

    @property
    def coarser(self) -> Segment:
        """The same span of time in half as many steps, rounded up, for the companion march."""
        return Segment(self.begin, self.end, math.ceil(self.steps / 2))

    @property
    def levels(self) -> Array:
        """Begin and end of all steps, (steps + 1,) [time]."""
        # the end is taken as it is: a jump there has to fall on the level to the last digit
        return np.append(self.begin + self.time_step * np.arange(self.steps), self.end)


def segments_between(
    scene: Scene, start: float, end: float, step_ratio: float, spacing: float
) -> list[Segment]:
    """Divide the time from `start` to `end` at the load jumps, in steps c_t dt <= step_ratio h.

    Parameters
    ----------
    scene : Scene
        Its load histories determine the jumps, its material the shear wave speed.
    start, end : float
        First and last time [time].
    step_ratio : float
        Largest c_t dt / h.
    spacing : float
        Node distance h [length].
    """
    # a march that begins with a load far along the slot is recorded from t = 0 on at the latest
    ends = [start, *(at for at in {0.0, *_jumps(scene)} if start < at < end), end]
    ends.sort()
    speed, largest = scene.material.shear_speed, step_ratio * spacing
    return [
        Segment(begin, until, max(1, math.ceil(speed * (until - begin) / largest)))
        for begin, until in pairwise(ends)
    ]


def _jumps(scene: Scene) -> list[float]:
    """Return the times at which a load jumps, in increasing order [time].

    Jumps of a load whose front moves come to each node in turn.
    """
    if scene.front_slowness:
        return []
    histories = scene.acting_histories.values()
    return sorted({at for history in histories for at, _ in history.pieces.jumps})


def _levels(
    scene: Scene, segment: Segment, pressure: NodalPressure, front: FrontLoad | None
) -> Iterator[Level]:
    """Yield the levels of a segment.

    At a jump, the first level takes the shear load just after it and the last one that before it.
    """
    times, step = segment.levels, segment.time_step
    # the slot carries Q_b - Q_0 f
    loads, uncut = _shear_loads(scene, times), scene.superposition.in_place.shear
    arrives, kept = scene.arrives, scene.before_load.shear
    for now, load, on_contact in zip(times.tolist(), loads, pressure.over(times), strict=True):
        if front is not None:
            yield Level(now, step, *front.tractions("shear", now, step), on_contact)
        elif arrives:
            yield Level(now, step, kept + load, kept, on_contact)
        else:
            yield Level(now, step, uncut, uncut - load, on_contact)


def check_levels(
    scene: Scene,
    segments: Sequence[Segment],
    pressure: NodalPressure,
    front: FrontLoad | None,
) -> None:
    """Raise the errors that steps through segments would raise for the pressure.

    The pressure can be checked without marching because slip between identical bodies does not
    change it.

    Raises
    ------
    TensionError
        If the contact would open.
    SceneError
        If friction weakens too fast under a pressure that arises.
    """
    if not scene.superposition.taken_off.pressure:
        return
    for segment in segments:
        for level in islice(_levels(scene, segment, pressure, front), 1, None):
            _check_pressure(scene, level, pressure.spacing)


class Walk:
    """A march under way, carried block by block of steps through segments.

    Parameters
    ----------
    marched : Marched
        Where the march starts from; it is not changed.
    pressure : NodalPressure
        Contact pressure at the nodes.
    front : FrontLoad, optional
        The load, if its front moves.
    record : MarchRecord
        Where the steps are recorded.

    Attributes
    ----------
    time, time_step : float
        Time that is reached, and the length of the steps of the present segment [time].
    done : int
        Steps that have been taken in the present segment.
    """

    def __init__(
        self,
        marched: Marched,
        pressure: NodalPressure,
        front: FrontLoad | None,
        record: MarchRecord,
    ) -> None:
        self.grid, self.record = marched.grid, record
        self.time, self.time_step, self.done = marched.state.time, 0.0, 0
        self._marched, self._pressure, self._front = marched, pressure, front
        self._line = Line(marched.scene, marched.grid.slot)
        self._by_slip = self._line.by_path
        state, size = marched.state, marched.grid.size
        self._memory = LineMemory(marched.memory, self.grid.wavenumbers)
        self._memory.put_back(Past(state.modes[None], state.lasting[None]))
        # Slip rates whose five fields stay in the cache: with half a march takes 1.1 times as long.
        self._block = max(1, min(BLOCK_STEPS, (1 << 15) // size))
        # the levels of a block, of which the first is the one before it
        values = (state.rate, state.traction, state.slip, state.path, state.work)
        self._fields = [np.empty((self._block + 1, len(value))) for value in values]
        for field, value in zip(self._fields, values, strict=True):
            field[0] = value
        self._rates, self._tractions, self._slips, self._paths, self._works = self._fields
        self._powers = np.zeros_like(self._tractions)
        self._last = 0
        self._transform, self._stopping = np.empty((1, size)), np.empty(size)

    @property
    def state(self) -> MarchState:
        """The state that is reached; its memory is complete between segments only."""
        fields = (field[self._last].copy() for field in self._fields)
        past = self._memory.past()
        return MarchState(self.time, past.modes[0], past.lasting[0], *fields)

    @property
    def rates(self) -> Array:
        """Slip rates at the levels of the last block and the one before it, (k + 1, size)."""
        return self._rates[: self._last + 1]

    def begin(self, segment: Segment) -> None:
        """Enter a segment, applying the load jump at its beginning."""
        marched, grid, scene = self._marched, self.grid, self._marched.scene
        self._turn_over()
        self.time_step, self.done = segment.time_step, 0
        self._length = scene.material.shear_speed * segment.time_step
        feedback = self._memory.table(self._length).feedback[0]
        feedback = damped(feedback, grid.wavenumbers, marched.damping)
        self._feedback = -self._line.impedance * feedback
        self._levels = _levels(scene, segment, self._pressure, self._front)
        first = next(self._levels)
        # A segment that begins neither with the load nor at a jump continues an earlier march,
        # whose rate is the right one already.
        if segment.begin == marched.begins or segment.begin in _jumps(scene):
            self._line.forget()
            self._jump(first)
            self.record.jump(self.time, self._rates[0], self._slips[0])
        else:
            contact = self._rates[0, grid.contact]
            self._line.recall(first, self._tractions[0], contact, self._paths[0])
        self._powers[0] = self._line.power(self._rates[0, grid.contact], self._paths[0])
        if segment.begin == marched.recorded_from:
            self.record.begin(self.state, first.pressure)
        cosines(self._rates[0], self._transform[0])

    def advance(self, steps: int) -> None:
        """Take a block of up to so many steps, fewer if the march is stopped, and record it.

        Raises
        ------
        TensionError
            If the contact would open.
        SceneError
            If friction weakens too fast under a pressure that arises.
        ComputationError
            If a slip rate is no longer finite.
        """
        self._turn_over()
        times, pressures = [self.time], []
        while self._last < min(steps, self._block) and not self.record.stopped:
            level = next(self._levels)
            _check_pressure(self._marched.scene, level, self.grid.spacing)
            self._step(level)
            self._last += 1
            times.append(level.time)
            pressures.append(level.pressure)
            self.record.count()
        self.done += self._last
        self.time = times[-1]
        self._sum_up()
        self.record.add(times, pressures, *(field[: self._last + 1] for field in self._fields))

    def end(self) -> None:
        """Leave the segment, at its end or before it if the march was stopped."""
        # complete the memory, so that a segment of another step length can begin from it
        self._memory.settle(self._transform)

    def _turn_over(self) -> None:
        """Make the level that is reached the first of the next block."""
        if self._last:
            for field in (*self._fields, self._powers):
                field[0] = field[self._last]
            self._last = 0

    def _jump(self, level: Level) -> None:
        """Change slip rate and traction as a jump of the loads does.

        The memory is an integral over the past, which a jump does not change; slip rate and
        traction change at once, through the local term of (4.40).
        """
        stopping, rate, impedance = self._stopping, self._rates[0], self._line.impedance
        exerted = self._memory.convolution(self._transform)[0, 0]
        from_cosines(exerted * -impedance, stopping)
        stopping += level.uncut
        self._line.slip_rate(stopping, level, self._paths[0], rate)
        self._tractions[0] = (stopping - impedance * rate)[self.grid.contact]

    def _step(self, level: Level) -> None:
        """Take one step, from the last row of the block into the next one."""
        line, contact, last = self._line, self.grid.contact, self._last
        rate, stopping, transform = self._rates[last + 1], self._stopping, self._transform[0]
        past = self._memory.advance(self._transform, self._length)[0, 0]
        past *= -line.impedance
        # laws that do not ask for the path are given any
        path = self._paths[last if self._by_slip else 0]
        # Fixed-point iteration for the end value; its contraction factor is the feedback (< 1).
        # The accumulated slip is iterated with it, since friction may depend on it.
        for _ in range(SWEEPS):
            # docs/theory.md, "Any load history", without the local term V
            transform *= self._feedback
            transform += past
            from_cosines(transform, stopping)
            stopping += level.uncut
            line.slip_rate(stopping, level, path, rate)
            if self._by_slip:
                speeds = np.abs(self._rates[last, contact]) + np.abs(rate[contact])
                path = self._paths[last + 1] = self._paths[last] + level.step / 2 * speeds
            cosines(rate, transform)
        # the first cosine is the sum over all nodes, which one value that is not finite spoils
        if not math.isfinite(transform[0]):
            raise ComputationError(
                f"the march lost its finite values at t = {level.time:.4g}; lower `step_ratio`."
            )
        # tau = tau_stop - (rho c_t/2) V
        np.multiply(rate[contact], -line.impedance, out=self._tractions[last + 1])
        self._tractions[last + 1] += stopping[contact]
        self._powers[last + 1] = line.power(rate[contact], path)

    def _sum_up(self) -> None:
        """Add the steps of a block to slip, accumulated slip and work, one after the other."""
        block, half = slice(0, self._last + 1), self.time_step / 2
        rates = self._rates[block, self.grid.contact]
        # the rate is linear in time over a step: slip is exact, work by the trapezoidal rule
        sums = [(self._slips[block], rates), (self._works[block], self._powers[block])]
        if not self._by_slip:
            sums.append((self._paths[block], np.abs(rates)))
        for field, values in sums:
            np.add(values[:-1], values[1:], out=field[1:])
            field[1:] *= half
            # row by row, a third of the time of np.add.accumulate
            for row in range(1, len(field)):
                field[row] += field[row - 1]


def _shear_loads(scene: Scene, levels: Array) -> Array:
    """Return Q_0 f at evenly spaced levels (n,) [stress].

    At a jump the value is that before it, but at the first level that after it.  Where several
    breaks of the history lie within the step around a level, the exact mean over that step is
    taken (docs/spacetime.md, "What the grid resolves").
    """
    history = scene.shear_history
    loads, breaks = history.value(levels), np.array(history.pieces.breaks)
    loads[0] = history.value(math.nextafter(levels[0], math.inf))
    half = (levels[-1] - levels[0]) / (2 * (len(levels) - 1))
    inner = levels[1:-1]
    held = np.searchsorted(breaks, inner + half) - np.searchsorted(breaks, inner - half)
    means = history.mean(inner - half, inner + half)
    # Values at the levels represent one kink, but not several.
    loads[1:-1] = np.where(held >= 2, means, loads[1:-1])
    return np.asarray(scene.superposition.taken_off.shear * loads)


def _check_pressure(scene: Scene, level: Level, spacing: float) -> None:
    """Raise if the contact would open, or if friction weakens too fast under its pressure."""
    if scene.superposition.taken_off.pressure == 0:
        return
    pressure = level.pressure
    node = int(np.argmin(pressure))
    if pressure[node] < 0:
        solved = scene.is_self_similar and isinstance(scene.friction, float)
        raise TensionError(
            f"the pressure would turn tensile at x = {(node + 0.5) * spacing:.4g}, "
            f"t = {level.time:.4g}; raise the base pressure, {'use `solve`, ' if solved else ''}"
            "or simulate the scene with finite elements (docs/limits.md)."
        )
    scene.check_weakening(float(pressure.max()))
