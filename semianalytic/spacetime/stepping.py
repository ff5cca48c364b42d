"""The time steps of a march, in segments between jumps of the loads.

A step takes the loads at its end, computes the traction that would stop each node under the memory
of past slip (`Line.stopping_traction`), from it and the friction law the slip rate
(`Line.slip_rate`), and adds the new slip to the memory (`Recursion`).  See docs/spacetime.md,
"Method".
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
from semianalytic.spacetime.grid_loads import FrontLoad, NodalPressure
from semianalytic.spacetime.marched import Grid, Marched, MarchState
from semianalytic.spacetime.record import MarchRecord
from semianalytic.spacetime.recursion import Recursion, exerted
from semianalytic.spacetime.tuning import AVERAGED_BREAKS, SWEEPS

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


@dataclass(frozen=True, eq=False)
class Level:
    """The loads that act at one time level.

    Attributes
    ----------
    time : float
        Time of the level [time].
    step : float
        Length of the step that ends there [time].
    uncut, on_slot : float, or (size,) and (slot,) arrays
        Shear traction of the uncut interface, and that of the slot faces [stress].
    pressure : (contact,) array
        Contact pressure at the nodes [stress].
    """

    time: float
    step: float
    uncut: float | Array
    on_slot: float | Array
    pressure: Array


def _levels(
    scene: Scene, segment: Segment, pressure: NodalPressure, front: FrontLoad | None
) -> Iterator[Level]:
    """Yield the levels of a segment.

    At a jump, the first level takes the shear load just after it and the last one that before it.
    """
    times, step = segment.levels, segment.time_step
    loads, held = _shear_loads(scene, times), scene.superposition.in_place.shear
    for now, load, on_contact in zip(times.tolist(), loads, pressure.over(times), strict=True):
        # the slot carries Q_b - Q_0 f
        uncut: float | Array = held
        on_slot: float | Array = held - load
        if front is not None:
            uncut, on_slot = front.tractions("shear", now, step)
        elif scene.arrives:
            on_slot = scene.before_load.shear
            uncut = on_slot + load
        yield Level(now, step, uncut, on_slot, on_contact)


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


@dataclass(frozen=True)
class Line:
    """The line y = 0 in a step: shear is prescribed on the slot, the contact obeys friction."""

    scene: Scene
    grid: Grid

    @cached_property
    def impedance(self) -> float:
        """Traction that slip releases at once, per relative slip rate [stress time / length]."""
        # rho c_t / 2: half of it because V is the relative rate of two bodies
        return self.scene.material.shear_impedance / 2

    def stopping_traction(self, past: Array, level: Level) -> Array:
        """Return the shear traction of all nodes if none of them moved now, (size,) [stress].

        Parameters
        ----------
        past : (size,) array
            Convolution over past slip in (4.40), per cosine [length / time].
        level : Level
            Loads at the time.
        """
        from scipy.fft import idct

        # docs/theory.md, "Any load history", without the local term V
        return np.asarray(level.uncut - self.impedance * idct(past, type=2))

    def slip_rate(self, stopping: Array, level: Level, path: Array) -> Array:
        """Return the relative slip rate of all nodes (size,) [length / time].

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
        """
        scene, slot, on_contact = self.scene, self.grid.slot, stopping[self.grid.contact]
        speed = scene.friction_law.slip_speed(
            np.abs(on_contact), scene.friction * level.pressure, self.impedance, path
        )
        rate = np.empty(len(stopping))
        # on the slot tau_stop - (rho c_t/2) V is what its faces carry
        rate[:slot] = (stopping[:slot] - level.on_slot) / self.impedance
        # Slip has the sense of the traction that it reduces: V tau >= 0.  0.0 - speed, and not
        # -speed, keeps the rate of nodes that stick at +0.0.
        rate[slot:] = np.where(on_contact < 0, 0.0 - speed, speed)
        return rate

    def traction(self, stopping: Array, rate: Array) -> Array:
        """Return the shear traction of the contact at a slip rate (size,), (contact,) [stress]."""
        contact = self.grid.contact
        return np.asarray(stopping[contact] - self.impedance * rate[contact])


class Walk:
    """A march under way, carried step by step through segments.

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
    state, before : MarchState
        The state that is reached, and the state at the beginning of the last step.
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
        self.state = self.before = marched.state.copy()
        self.done = 0
        self._marched, self._pressure, self._front = marched, pressure, front
        self._line = Line(marched.scene, marched.grid)

    def begin(self, segment: Segment) -> None:
        """Enter a segment, applying the load jump at its beginning."""
        marched, grid, scene = self._marched, self.grid, self._marched.scene
        phase = grid.wavenumbers * scene.material.shear_speed * segment.time_step
        self._recursion = Recursion(marched.memory, phase, marched.damping)
        self._levels = _levels(scene, segment, self._pressure, self._front)
        first = next(self._levels)
        # A segment that begins neither with the load nor at a jump continues an earlier march,
        # whose rate is the right one already.
        if segment.begin == marched.begins or segment.begin in _jumps(scene):
            self.state = _after_jump(self._line, self.state, first)
            self.record.jump(self.state)
        if segment.begin == marched.recorded_from:
            self.record.begin(self.state, first.pressure)
        self.before, self.done = self.state, 0
        self._transform = _cosines(self.state.rate)
        self._recursion.enter(self.state.modes, self.state.lasting, self._transform)

    def step(self) -> None:
        """Take the next step; the memory of the state is updated in place."""
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
        """Leave the segment, at its end or before it if the march was stopped."""
        # complete the memory, so that a segment of another step length can begin from it
        self._recursion.leave(self.state.modes, self.state.lasting, self._transform)


def _after_jump(line: Line, state: MarchState, level: Level) -> MarchState:
    """Return the state right after a jump of the loads.

    The memory is an integral over the past, which a jump does not change; slip rate and traction
    change at once, through the local term of (4.40).
    """
    stopping = line.stopping_traction(exerted(state.modes, state.lasting), level)
    rate = line.slip_rate(stopping, level, state.path)
    return replace(state, rate=rate, traction=line.traction(stopping, rate))


def _step(
    line: Line, recursion: Recursion, before: MarchState, transform: Array, level: Level
) -> tuple[MarchState, Array]:
    """Return the state one step later, and the cosines of its slip rate.

    Parameters
    ----------
    line : Line
        Tractions and friction on y = 0.
    recursion : Recursion
        Its `feedback` is what the end value of the rate contributes to the memory.
    before : MarchState
        State at the beginning of the step, except for its memory: that belongs to the end of the
        step already, the contribution of the end value left out.
    transform : (size,) array
        Cosines of the slip rate at the beginning of the step, the first guess for its end.
    level : Level
        Loads at the end of the step.

    Raises
    ------
    ComputationError
        If the slip rate is no longer finite.
    """
    contact, half = line.grid.contact, level.step / 2
    past, old, path = exerted(before.modes, before.lasting), before.rate[contact], before.path
    # Fixed-point iteration for the end value; its contraction factor is the feedback (< 1).  The
    # accumulated slip is iterated with it, since friction may depend on it.
    for _ in range(SWEEPS):
        stopping = line.stopping_traction(past + recursion.feedback * transform, level)
        rate = line.slip_rate(stopping, level, path)
        path = before.path + half * (np.abs(old) + np.abs(rate[contact]))
        transform = _cosines(rate)
    # the first cosine is the sum over all nodes, which one value that is not finite spoils
    if not math.isfinite(float(transform[0])):
        raise ComputationError(
            f"the march lost its finite values at t = {level.time:.4g}; lower `step_ratio`."
        )
    traction, new = line.traction(stopping, rate), rate[contact]
    # the rate is linear in time over a step: slip is exact, work by the trapezoidal rule
    work = before.work + half * (before.traction * old + traction * new)
    slip = before.slip + half * (old + new)
    modes, lasting = before.modes, before.lasting
    return MarchState(level.time, modes, lasting, rate, traction, slip, path, work), transform


def _cosines(rate: Array) -> Array:
    """Return the amplitudes of the cosines of a slip rate, (size,)."""
    from scipy.fft import dct  # here, for `import semianalytic` is to be quick

    # type 2: nodes half a spacing from the ends, even about both of them
    return np.asarray(dct(rate, type=2))


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
