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

from semianalytic.engine.scenes.friction import SceneFriction
from semianalytic.engine.scenes.loads import SWEEPS, FrontLoad, NodalPressure
from semianalytic.engine.scenes.marched import Marched
from semianalytic.engine.scenes.record import MarchRecord
from semianalytic.engine.scenes.state import MarchState
from semianalytic.engine.stepping.balance import Balance
from semianalytic.engine.stepping.blocks import Blocks, Level, Reached
from semianalytic.memory.line_memory import LineMemory, Past
from semianalytic.scene.errors import TensionError
from semianalytic.scene.friction import CoulombFriction
from semianalytic.scene.scene import Scene

SINGLE_SIZE = 4096
"""Nodes up to which the memory has single precision: slip rates change by 5e-6 of themselves."""

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
            _checked_pressure(scene, level, pressure.spacing)


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
        self.time_step, self.done = 0.0, 0
        self._marched, self._pressure, self._front = marched, pressure, front
        state, grid, scene = marched.state, marched.grid, marched.scene
        line, law = grid.line, SceneFriction(scene.friction_law, scene.friction)
        touching = np.arange(grid.size) >= grid.slot
        impedance = scene.material.shear_impedance / 2
        self._memory = LineMemory(marched.memory, line.wavenumbers, single=grid.size <= SINGLE_SIZE)
        self._memory.put_back(Past(state.modes[None], state.lasting[None]))
        self._blocks = Blocks(
            line,
            Balance(law, impedance, touching, line, falls=True),
            law,
            self._memory,
            Reached(state.time, state.rate, state.traction, state.slip, state.path, state.work),
            kept=grid.contact,
            impedance=impedance,
            speed=scene.material.shear_speed,
            sweeps=SWEEPS,
            damping=marched.damping,
            means_last=True,
        )

    @property
    def time(self) -> float:
        """Time reached [time]."""
        return self._blocks.time

    @property
    def state(self) -> MarchState:
        """The state that is reached; its memory is complete between segments only."""
        past, now = self._memory.past(), self._blocks.reached
        fields = now.rate, now.traction, now.slip, now.state, now.work
        return MarchState(now.time, past.modes[0], past.lasting[0], *fields)

    @property
    def rates(self) -> Array:
        """Slip rates at the levels of the last block and the one before it, (k + 1, size)."""
        return self._blocks.levels[0]

    def begin(self, segment: Segment) -> None:
        """Enter a segment, applying the load jump at its beginning."""
        marched, scene = self._marched, self._marched.scene
        self.time_step, self.done = segment.time_step, 0
        self._levels = _levels(scene, segment, self._pressure, self._front)
        first = next(self._levels)
        # A segment that begins neither with the load nor at a jump continues an earlier march,
        # whose rate is the right one already.
        if segment.begin == marched.begins or segment.begin in _jumps(scene):
            self._blocks.jump(first)
            rates, _, slips, *_ = self._blocks.levels
            self.record.jump(self.time, rates[0], slips[0])
        else:
            self._blocks.recall(first.pressure)
        if segment.begin == marched.recorded_from:
            self.record.begin(self.state, first.pressure)

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
        blocks = self._blocks
        blocks.advance(self._checked(), self.record.count, steps)
        self.done += len(blocks.pressures)
        self.record.add(blocks.times, blocks.pressures, *blocks.levels)

    def end(self) -> None:
        """Leave the segment, at its end or before it if the march was stopped."""
        # complete the memory, so that a segment of another step length can begin from it
        self._blocks.settle()

    def _checked(self) -> Iterator[Level]:
        """Return the levels to come, each of which is checked if loads change the pressure."""
        scene = self._marched.scene
        if not scene.superposition.taken_off.pressure:
            return self._levels
        return (_checked_pressure(scene, level, self.grid.spacing) for level in self._levels)


def _is_of_usual_size(scene: Scene, latest: float) -> bool:
    """Return whether slip rates until a time are far from the ends of single precision."""
    load, largest = scene.superposition.taken_off, 0.0
    for name, history in scene.acting_histories.items():
        times = np.append(np.linspace(0.0, latest, 50), history.pieces.breaks)
        largest = max(largest, float(np.abs(getattr(load, name) * history.value(times)).max()))
    return 1e-20 < largest / scene.material.shear_impedance < 1e20


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


def _checked_pressure(scene: Scene, level: Level, spacing: float) -> Level:
    """Return a level; raise if the contact would open or friction weakens too fast under it."""
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
    return level
