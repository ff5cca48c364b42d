"""The steps of a march, in segments between jumps of the loads.

A step takes the loads at its end, the traction that would stop each node under what the past exerts
(`Line.stopping_traction`), the slip rate that friction leaves of it (`Line.slip_rate`), and what
that adds to the memory (`Recursion`).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import islice, pairwise

import numpy as np
from numpy.typing import NDArray

from semianalytic.scene.errors import ComputationError, TensionError
from semianalytic.scene.friction import CoulombFriction
from semianalytic.scene.scene import Scene
from semianalytic.spacetime.grid_pressure import GridPressure
from semianalytic.spacetime.marched import Grid, Marched, MarchState
from semianalytic.spacetime.record import MarchRecord
from semianalytic.spacetime.recursion import Recursion, exerted
from semianalytic.spacetime.tuning import AVERAGED_BREAKS, SWEEPS

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Segment:
    """A span of time within which no load jumps, in equal steps; begin and end [time]."""

    begin: float
    end: float
    steps: int

    @property
    def time_step(self) -> float:
        """[time]."""
        return (self.end - self.begin) / self.steps

    @property
    def coarser(self) -> Segment:
        """In half the steps."""
        return Segment(self.begin, self.end, math.ceil(self.steps / 2))

    @property
    def levels(self) -> Array:
        """Begin and end of all steps, (steps + 1,) [time]."""
        return np.append(self.begin + self.time_step * np.arange(self.steps), self.end)


def segments_between(
    scene: Scene, start: float, end: float, step_ratio: float, spacing: float
) -> list[Segment]:
    """Segments from a time to another in steps of c_t dt <= step_ratio spacing."""
    ends = [start, *(at for at in _jumps(scene) if start < at < end), end]
    speed, largest = scene.material.shear_speed, step_ratio * spacing
    return [
        Segment(begin, until, max(1, math.ceil(speed * (until - begin) / largest)))
        for begin, until in pairwise(ends)
    ]


def _jumps(scene: Scene) -> list[float]:
    """Times at which a load jumps, in order [time]."""
    histories = scene.acting_histories.values()
    return sorted({at for history in histories for at, _ in history.pieces.jumps})


@dataclass(frozen=True, eq=False)
class Level:
    """What acts at a time level.

    Attributes
    ----------
    time, step : float
        And the step that ends there [time].
    shear_load : float
        Q_0 f [stress].
    pressure : (contact,) array
        On the contact [stress].
    """

    time: float
    step: float
    shear_load: float
    pressure: Array


def _levels(scene: Scene, segment: Segment, pressure: GridPressure) -> Iterator[Level]:
    """Levels of a segment; the first takes the load just after it, the others that before."""
    times, step = segment.levels, segment.time_step
    loads = _shear_loads(scene, times)
    for now, load, on_contact in zip(times.tolist(), loads, pressure.over(times), strict=True):
        yield Level(now, step, load, on_contact)


def check_levels(scene: Scene, segments: Sequence[Segment], pressure: GridPressure) -> None:
    """Raise what steps through segments would for the pressure, which slip does not change.

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
        for level in islice(_levels(scene, segment, pressure), 1, None):
            _check_pressure(scene, level, pressure.spacing)


@dataclass(frozen=True)
class Line:
    """The line y = 0 as a step sees it: tractions of the slot are prescribed, the contact rubs."""

    scene: Scene
    grid: Grid

    @cached_property
    def impedance(self) -> float:
        """Traction that slip takes off per relative slip rate [stress time / length]."""
        return self.scene.material.shear_impedance / 2

    def stopping_traction(self, past: Array) -> Array:
        """Shear traction at which no node would move, (size,) [stress].

        `past` is what past slip exerts, per cosine, over the impedance [length / time].
        """
        from scipy.fft import idct

        held = self.scene.superposition.in_place.shear
        return np.asarray(held - self.impedance * idct(past, type=2))

    def slip_rate(self, stopping: Array, level: Level, path: Array) -> Array:
        """Relative slip rate of all nodes (size,) [length / time].

        Parameters
        ----------
        stopping : (size,) array
            Shear traction at which a node would not move [stress].
        level : Level
        path : (contact,) array
            Accumulated |slip| [length].
        """
        scene, slot, on_contact = self.scene, self.grid.slot, stopping[self.grid.contact]
        speed = scene.friction_law.slip_speed(
            np.abs(on_contact), scene.friction * level.pressure, self.impedance, path
        )
        rate, held = np.empty(len(stopping)), scene.superposition.in_place.shear
        rate[:slot] = (stopping[:slot] - (held - level.shear_load)) / self.impedance
        rate[slot:] = np.where(on_contact < 0, 0.0 - speed, speed)
        return rate

    def traction(self, stopping: Array, rate: Array) -> Array:
        """Shear traction of the contact at a slip rate (size,), (contact,) [stress]."""
        contact = self.grid.contact
        return np.asarray(stopping[contact] - self.impedance * rate[contact])


class Walk:
    """A march on its way: what it has reached, carried on step by step through segments.

    Parameters
    ----------
    marched : Marched
        Left as it is.
    pressure : GridPressure
    record : MarchRecord

    Attributes
    ----------
    state, before : MarchState
        What is reached, and where the last step began.
    done : int
        Steps of the segment.
    """

    def __init__(self, marched: Marched, pressure: GridPressure, record: MarchRecord) -> None:
        self.grid, self.record = marched.grid, record
        self.state = self.before = marched.state.copy()
        self.done = 0
        self._marched, self._pressure = marched, pressure
        self._line = Line(marched.scene, marched.grid)

    def begin(self, segment: Segment) -> None:
        """Enter a segment; its loads jump first."""
        marched, grid, scene = self._marched, self.grid, self._marched.scene
        phase = grid.wavenumbers * scene.material.shear_speed * segment.time_step
        self._recursion = Recursion(marched.memory, phase, marched.damping)
        self._levels = _levels(scene, segment, self._pressure)
        first = next(self._levels)
        if segment.begin == 0 or segment.begin in _jumps(scene):
            self.state = _after_jump(self._line, self.state, first)
            self.record.jump(self.state)
        if segment.begin == 0:
            self.record.begin(self.state, first.pressure)
        self.before, self.done = self.state, 0
        self._transform = _cosines(self.state.rate)
        self._recursion.enter(self.state.modes, self.state.lasting, self._transform)

    def step(self) -> None:
        """Take the next step; the memory in place."""
        level = next(self._levels)
        _check_pressure(self._marched.scene, level, self.grid.spacing)
        self.before = self.state
        self._recursion.step(self.state.modes, self.state.lasting, self._transform)
        self.state, self._transform = _step(
            self._line, self._recursion, self.before, self._transform, level
        )
        self.done += 1
        self.record.add(self.before, self.state, level.pressure)

    def end(self) -> None:
        """Leave the segment, at its end or before."""
        self._recursion.leave(self.state.modes, self.state.lasting, self._transform)


def _after_jump(line: Line, state: MarchState, level: Level) -> MarchState:
    """What a jump of the loads makes of a state at once."""
    stopping = line.stopping_traction(exerted(state.modes, state.lasting))
    rate = line.slip_rate(stopping, level, state.path)
    return replace(state, rate=rate, traction=line.traction(stopping, rate))


def _step(
    line: Line, recursion: Recursion, before: MarchState, transform: Array, level: Level
) -> tuple[MarchState, Array]:
    """The state one step later, and the cosines of its slip rate; given those of the rate before.

    The memory is that of the new level already, but for the end value of the rate.
    """
    contact, half = line.grid.contact, level.step / 2
    past, old, path = exerted(before.modes, before.lasting), before.rate[contact], before.path
    for _ in range(SWEEPS):
        stopping = line.stopping_traction(past + recursion.feedback * transform)
        rate = line.slip_rate(stopping, level, path)
        path = before.path + half * (np.abs(old) + np.abs(rate[contact]))
        transform = _cosines(rate)
    if not math.isfinite(float(transform[0])):
        raise ComputationError(
            f"the march lost its finite values at t = {level.time:.4g}; lower `step_ratio`."
        )
    traction, new = line.traction(stopping, rate), rate[contact]
    work = before.work + half * (before.traction * old + traction * new)
    slip = before.slip + half * (old + new)
    modes, lasting = before.modes, before.lasting
    return MarchState(level.time, modes, lasting, rate, traction, slip, path, work), transform


def _cosines(rate: Array) -> Array:
    """Amplitudes of the cosines of a slip rate, (size,)."""
    from scipy.fft import dct  # here, for `import semianalytic` is to be quick

    return np.asarray(dct(rate, type=2))


def _shear_loads(scene: Scene, levels: Array) -> Array:
    """Q_0 f at evenly spaced levels [stress], at a jump the value before it, at the first after it.

    Where several of the breaks of the history lie within the step around a level, its exact mean.
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
    """Raise if the contact would open, or friction weaken too fast under its pressure."""
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
