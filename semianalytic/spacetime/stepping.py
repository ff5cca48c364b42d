"""The time steps of a march, in segments between jumps of the loads.

A step takes the loads at its end, computes the traction that would stop each node under the memory
of past slip (`Line.begun`), from it and the friction law the slip rate (`Line.slip_rate`), and adds
the new slip to the memory (`Recursion`).  Steps are recorded in blocks.  See docs/spacetime.md,
"Method".
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from itertools import islice, pairwise

import numpy as np
from numpy.typing import NDArray

from semianalytic.scene.errors import ComputationError, TensionError
from semianalytic.scene.friction import CoulombFriction, RateFriction
from semianalytic.scene.scene import Scene
from semianalytic.spacetime.grid_pressure import (
    GridPressure,
    knows_slipping_edge,
    spilled_pressure,
)
from semianalytic.spacetime.marched import Grid, Marched, MarchState
from semianalytic.spacetime.record import MarchRecord
from semianalytic.spacetime.recursion import Recursion
from semianalytic.spacetime.tuning import (
    AVERAGED_BREAKS,
    BLOCK_STEPS,
    CELL_WIDTH,
    STEP_VALUES,
    SWEEPS,
)

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Indices = NDArray[np.intp]


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
        """This span in half as many steps, rounded up, for the companion."""
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
    ends = [start, *(at for at in _jumps(scene) if start < at < end), end]
    speed, largest = scene.material.shear_speed, step_ratio * spacing
    return [
        Segment(begin, until, max(1, math.ceil(speed * (until - begin) / largest)))
        for begin, until in pairwise(ends)
    ]


def _jumps(scene: Scene) -> list[float]:
    """Return the times at which a load jumps, in increasing order [time]."""
    histories = scene.acting_histories.values()
    return sorted({at for history in histories for at, _ in history.pieces.jumps})


@dataclass(frozen=True, eq=False)
class Level:
    """The loads that act at one time level.

    Attributes
    ----------
    time : float
        Time of the level [time].
    step : float
        Length of the step that ends there [time].
    shear_load : float
        Shear traction Q_0 f that is taken off the slot [stress].
    pressure : (contact,) array
        Contact pressure at the nodes [stress].
    spilled : (m,) array or None
        Pressure whose friction an edge that slips leaves on the last nodes of the slot, with the
        sign of slip there [stress].
    """

    time: float
    step: float
    shear_load: float
    pressure: Array
    spilled: Array | None = None


def _levels(
    scene: Scene, segment: Segment, pressure: GridPressure, sense: Callable[[], float]
) -> Iterator[Level]:
    """Yield the levels of a segment.

    At a jump, the first level takes the shear load just after it and the last one that before it.
    `sense` is asked before each level for the sign of the slip rate at the edge: the pressure of an
    edge that sticks is used until it slips, so that it decides whether the edge slips.
    """
    times, step = segment.levels, segment.time_step
    loads = _shear_loads(scene, times)
    rows, own = pressure.over(times), knows_slipping_edge(scene)
    left = spilled_pressure(scene, pressure.spacing, times) if own else times
    for row, (now, load) in enumerate(zip(times.tolist(), loads, strict=True)):
        sign = sense() if own else 0.0
        spilled = sign * left[row] if sign else None
        yield Level(now, step, load, rows(row, sign != 0), spilled)


def check_levels(scene: Scene, segments: Sequence[Segment], pressure: GridPressure) -> None:
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
        for level in islice(_levels(scene, segment, pressure, lambda: 0.0), 1, None):
            _check_pressure(scene, level, pressure.spacing)


class Line:
    """The line y = 0 in a step: shear is prescribed on the slot, the contact obeys friction.

    Parameters
    ----------
    scene : Scene
        Material, friction law and tractions.
    grid : Grid
        The nodes.

    Attributes
    ----------
    impedance : float
        Traction that slip releases at once, per relative slip rate [stress time / length].
    """

    def __init__(self, scene: Scene, grid: Grid) -> None:
        # rho c_t / 2: half of it because V is the relative rate of two bodies
        self.impedance = scene.material.shear_impedance / 2
        self._law, self._friction = scene.friction_law, scene.friction
        self._sticks = scene.friction > 0
        self._coulomb = type(scene.friction_law) is CoulombFriction
        self._held, self._slot = scene.superposition.in_place.shear, grid.slot
        self._pressed = self._dry = self._opposite = np.zeros(0)

    def begun(self, past: Array) -> Array:
        """Return the part of the stopping traction that is known before a step, per cosine.

        `past` (size,) is the convolution over past slip in (4.40) [length / time]; the result is
        the traction of (4.40) without the local term V [stress], in cosines.
        """
        known = past * -self.impedance
        known[0] += 2 * len(past) * self._held  # a constant is the first cosine
        return known

    def slip_rate(
        self, stopping: Array, level: Level, path: Array, rate: Array, partly: bool = True
    ) -> tuple[Indices, Array]:
        """Find the relative slip rate of all nodes (size,) [length / time], written to `rate`.

        On the slot the shear traction is prescribed; on the contact tau = tau_stop - (rho c_t/2) V
        must satisfy the friction law.

        Parameters
        ----------
        stopping : (size,) array
            Shear traction at which a node would not move [stress].
        level : Level
            Loads at the time of the slip rate.
        path : (contact,) array
            Accumulated |slip| [length].
        rate : (size,) array
            Where the result is written.
        partly : bool
            Whether nodes beside the end of a zone slip on a part of their cell.

        Returns
        -------
        (indices, array)
            The contact nodes that slip on a part of their cell, and what the traction of the part
            that slips, which is the strength, is above the mean over the cell [stress].
        """
        slot, at, above = self._slot, _NOWHERE, _NOTHING
        on_contact, moving = stopping[slot:], rate[slot:]
        if level.pressure is not self._pressed:
            self._pressed, self._dry = level.pressure, self._friction * level.pressure
            self._opposite = -self._dry
        if self._coulomb:
            # the part beyond friction, in the sense of the traction that it reduces: V tau >= 0
            np.maximum(on_contact, self._opposite, out=moving)
            np.minimum(moving, self._dry, out=moving)
            np.subtract(on_contact, moving, out=moving)
            if partly and self._sticks:
                at, mean = _partly(on_contact, self._dry, moving != 0)
                if len(at):
                    moving[at] = mean
                    above = mean + np.copysign(self._dry[at], mean) - on_contact[at]
            moving *= 1 / self.impedance
        else:
            strength = self._law.strength(self._dry, 0.0, path)
            size = np.abs(on_contact)
            if partly and self._sticks:
                at, mean = _partly(on_contact, strength, size > strength)
                if len(at):
                    size[at] = np.abs(mean) + strength[at]
                    above = np.copysign(size[at], mean) - on_contact[at]
            speed = self._law.slip_speed(size, self._dry, self.impedance, path)
            # adding 0.0 keeps the rate of nodes that stick at +0.0
            np.add(np.copysign(speed, on_contact), 0.0, out=moving)
        # the slot carries Q_b - Q_0 f: tau_stop - (rho c_t/2) V equals it
        np.subtract(stopping[:slot], self._held - level.shear_load, out=rate[:slot])
        if level.spilled is not None:
            rate[slot - len(level.spilled) : slot] -= self._friction * level.spilled
        rate[:slot] *= 1 / self.impedance
        return at, above

    def spilled_power(self, level: Level, rate: Array) -> float:
        """Return what friction that was left on the slot does per time, at slip rates (size,).

        A slipping edge leaves some of the singular friction of the first cells on the slot
        (`SLIPPING_EDGE`).  It is friction of the contact, whose work the first node carries.
        """
        if level.spilled is None:
            return 0.0
        near = rate[self._slot - len(level.spilled) : self._slot]
        return self._friction * float(level.spilled @ near)


def _partly(stopping: Array, strength: Array, slips: Flags) -> tuple[Indices, Array]:
    """Return the nodes that slip on a part of their cell, and the mean traction that moves them.

    A node stands for `CELL_WIDTH` cells of the line, on which the excess of the stopping traction
    over strength is linear, with the slope of its neighbours; it slips at the mean of its positive
    part.  A node that began to slip all at once as the tip passes it would send waves back.
    """
    before = (slips[1:] ^ slips[:-1]).nonzero()[0]
    if not len(before):
        return _NOWHERE, _NOTHING
    at = np.concatenate([before, before + 1])
    if before[0] == 0 or before[-1] == len(slips) - 2:  # the end nodes have no slope
        at = at[(at > 0) & (at < len(slips) - 1)]
    near = at + _NEIGHBOURS
    below, own, above = np.abs(stopping[near]) - strength[near]
    half = CELL_WIDTH / 4 * np.abs(above - below)
    inside = (np.abs(own) < half).nonzero()[0]
    if len(inside) < len(at):
        at, own, half = at[inside], own[inside], half[inside]
    return at, np.copysign(np.square(own + half) / (4 * half), stopping[at])


_NEIGHBOURS = np.array([[-1], [0], [1]])
_NOWHERE, _NOTHING = np.zeros(0, dtype=np.intp), np.zeros(0)


class Walk:
    """A march under way, carried block by block of steps through segments.

    Parameters
    ----------
    marched : Marched
        Where the march starts from; it is not changed.
    pressure : GridPressure
        Contact pressure at the nodes.
    record : MarchRecord
        Where the steps are recorded.

    Attributes
    ----------
    time : float
        Time that is reached [time].
    done : int
        Steps that have been taken in the present segment.
    block : int
        Largest number of steps that are taken at once.
    """

    def __init__(self, marched: Marched, pressure: GridPressure, record: MarchRecord) -> None:
        self.grid, self.record = marched.grid, record
        self.time, self.done = marched.state.time, 0
        state, grid = marched.state.copy(), marched.grid
        self._modes, self._lasting = state.modes, state.lasting
        self._marched, self._pressure = marched, pressure
        self._line = Line(marched.scene, grid)
        law = marched.scene.friction_law
        self._by_slip = not isinstance(law, CoulombFriction | RateFriction)
        self.block = max(1, min(BLOCK_STEPS, STEP_VALUES // grid.size))
        contact = grid.size - grid.slot
        self._rates = np.empty((self.block + 1, grid.size))
        self._tractions, self._slips, self._paths, self._works = np.empty(
            (4, self.block + 1, contact)
        )
        # level by level in a block: the first row is the level before it
        self._fields = (self._rates, self._tractions, self._slips, self._paths, self._works)
        values = (state.rate, state.traction, state.slip, state.path, state.work)
        for field, value in zip(self._fields, values, strict=True):
            field[0] = value
        self._last = 0
        self._spilled = np.zeros(self.block + 1)
        self._above: list[tuple[int, Indices, Array]] = []
        self._transform, self._stopping = np.empty((2, grid.size))

    @property
    def state(self) -> MarchState:
        """The state that is reached; its memory is complete between segments only."""
        return MarchState(
            self.time,
            self._modes,
            self._lasting,
            *(field[self._last].copy() for field in self._fields),
        )

    @property
    def time_step(self) -> float:
        """Length of the steps of the present segment [time]."""
        return self._segment.time_step

    def begin(self, segment: Segment) -> None:
        """Enter a segment, applying the load jump at its beginning."""
        marched, grid, scene = self._marched, self.grid, self._marched.scene
        self._go_back()
        self._segment = segment
        phase = grid.wavenumbers * scene.material.shear_speed * segment.time_step
        self._recursion = Recursion(
            marched.memory, phase, marched.damping, self._modes, self._lasting
        )
        self._feedback = -self._line.impedance * self._recursion.feedback
        self._levels = _levels(scene, segment, self._pressure, self._edge_sense)
        first = next(self._levels)
        # A segment that begins neither at t = 0 nor at a jump continues an earlier march, whose
        # rate is the right one already.
        if segment.begin == 0 or segment.begin in _jumps(scene):
            self._jump(first)
            self.record.jump(self.time, self._rates[0], self._slips[0])
        self._spilled[0] = self._line.spilled_power(first, self._rates[0])
        if segment.begin == 0:
            self.record.begin(self.state, first.pressure)
        self.done = 0
        cosines(self._rates[0], self._transform)
        self._recursion.enter(self._transform)

    def _edge_sense(self) -> float:
        """Return the sign of the slip rate at the first node, 0 where it sticks."""
        return float(np.sign(self._rates[self._last, self.grid.slot]))

    def _jump(self, level: Level) -> None:
        """Change slip rate and traction as a jump of the loads does.

        The memory is an integral over the past, which a jump does not change; slip rate and
        traction change at once, through the local term of (4.40).
        """
        stopping, rate = self._stopping, self._rates[0]
        from_cosines(self._line.begun(self._recursion.exerted()), stopping)
        at, above = self._line.slip_rate(stopping, level, self._paths[0], rate)
        contact = self.grid.contact
        self._tractions[0] = stopping[contact] - self._line.impedance * rate[contact]
        self._tractions[0, at] += above

    @property
    def rates(self) -> Array:
        """Slip rates at the levels of the last block, that before it included, (k + 1, size)."""
        return self._rates[: self._last + 1]

    def _go_back(self) -> None:
        """Make the level that is reached the first row of the next block."""
        if self._last:
            for field in (*self._fields, self._spilled):
                field[0] = field[self._last]
            self._last = 0

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
        self._go_back()
        times, pressures, half = [self.time], [], 0.0
        while self._last < min(steps, self.block) and not self.record.stopped:
            level = next(self._levels)
            _check_pressure(self._marched.scene, level, self.grid.spacing)
            half = level.step / 2
            self._step(level, half)
            self._last += 1
            times.append(level.time)
            pressures.append(level.pressure)
            self.record.count()
        self.done += self._last
        self.time = times[-1]
        self._sum_up(half)
        fields = (field[: self._last + 1] for field in self._fields)
        self.record.add(times, pressures, self._above, *fields)
        self._above.clear()

    def _step(self, level: Level, half: float) -> None:
        """Take one step into the next row; `half` is half its length [time]."""
        line, contact, new = self._line, self.grid.contact, self._last + 1
        rate, stopping, transform = self._rates[new], self._stopping, self._transform
        past = line.begun(self._recursion.step(transform))
        # the path matters to laws that look at it; others are given any
        path = self._paths[new - 1 if self._by_slip else 0]
        # Fixed-point iteration for the end value; its contraction factor is the feedback (< 1).
        # The accumulated slip is iterated with it, since friction may depend on it.  Cells that
        # slip in part are left to the last sweep: errors change by 7 % at most.
        for sweep in range(SWEEPS):
            transform *= self._feedback
            transform += past
            from_cosines(transform, stopping)
            at, above = line.slip_rate(stopping, level, path, rate, sweep == SWEEPS - 1)
            if self._by_slip:
                speeds = np.abs(self._rates[new - 1][contact]) + np.abs(rate[contact])
                path = self._paths[new] = self._paths[new - 1] + half * speeds
            cosines(rate, transform)
        # the first cosine is the sum over all nodes, which one value that is not finite spoils
        if not math.isfinite(transform[0]):
            raise ComputationError(
                f"the march lost its finite values at t = {level.time:.4g}; lower `step_ratio`."
            )
        np.multiply(rate[contact], -line.impedance, out=self._tractions[new])
        self._tractions[new] += stopping[contact]
        self._tractions[new, at] += above
        self._spilled[new] = line.spilled_power(level, rate)
        self._above.append((new, at, above))

    def _sum_up(self, half: float) -> None:
        """Add the steps of a block to slip, accumulated slip and work, in order."""
        last = self._last
        rates, tractions = self._rates[: last + 1, self.grid.contact], self._tractions[: last + 1]
        # the rate is linear in time over a step: slip is exact, work by the trapezoidal rule
        power = tractions * rates
        power[:, 0] += self._spilled[: last + 1]
        sums = [(self._slips, rates), (self._works, power)]
        if not self._by_slip:
            sums.append((self._paths, np.abs(rates)))
        for field, values in sums:
            np.add(values[:-1], values[1:], out=field[1 : last + 1])
            field[1 : last + 1] *= half
            np.add.accumulate(field[: last + 1], axis=0, out=field[: last + 1])

    def end(self) -> None:
        """Leave the segment, at its end or before it if the march was stopped."""
        # complete the memory, so that a segment of another step length can begin from it
        self._recursion.leave(self._transform)


def cosines(rate: Array, out: Array) -> None:
    """Write the amplitudes of the cosines of a slip rate, (size,), to `out`."""
    # type 2: nodes half a spacing from the ends, even about both of them
    _transform()(rate, 2, (0,), 0, out)


def from_cosines(amplitudes: Array, out: Array) -> None:
    """Write the values at the nodes (size,) that have these amplitudes to `out`."""
    _transform()(amplitudes, 3, (0,), 2, out)


@cache
def _transform() -> Callable[[Array, int, tuple[int], int, Array], object]:
    """Return the cosine transform (values, type, axes, 0 or 2 to divide by 2 n, out)."""
    # scipy.fft spends 12 microseconds around each of these calls, twice what 500 nodes take; where
    # a version of scipy keeps the function elsewhere, scipy.fft serves
    try:
        module = import_module("scipy.fft._pocketfft.pypocketfft")
    except ImportError:
        from scipy.fft import dct, idct

        def public(values: Array, kind: int, axes: tuple[int], scaling: int, out: Array) -> None:
            out[:] = idct(values, type=2) if scaling else dct(values, type=2)

        return public
    found: Callable[[Array, int, tuple[int], int, Array], object] = module.dct
    return found


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
    loads[1:-1] = np.where(held >= AVERAGED_BREAKS, means, loads[1:-1])
    return np.asarray(scene.superposition.taken_off.shear * loads)


def _check_pressure(scene: Scene, level: Level, spacing: float) -> None:
    """Raise if the contact would open, or if friction weakens too fast under its pressure."""
    if scene.superposition.taken_off.pressure == 0:
        return
    pressure = level.pressure
    node = int(np.argmin(pressure))
    if pressure[node] < 0:
        solved = scene.is_self_similar and scene.friction_law == CoulombFriction()
        raise TensionError(
            f"the pressure would turn tensile at x = {(node + 0.5) * spacing:.4g}, "
            f"t = {level.time:.4g}; raise the base pressure, {'use `solve`, ' if solved else ''}"
            "or simulate the scene with finite elements (docs/limits.md)."
        )
    scene.check_weakening(float(pressure.max()))
