"""Advance a march and its companion from the state they have reached, from jump to jump.

A step takes the loads at its end, computes the traction that would stop each node under the memory
of past slip, from it and the friction law the slip rate, and adds the new slip to the memory.
Steps are summed up and recorded in blocks (`Blocks`; docs/spacetime.md, "Method").

The companion of a march is the same march on half the nodes in half the steps, whose levels are
every second of the march.  The difference between the two gives the error estimate
(docs/spacetime.md, "Error of a march").  The companion follows a block of steps behind: nothing has
to be stored for the comparison.  Each of its nodes lies half-way between two nodes of the march.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from semianalytic.engine.convergence import Departure
from semianalytic.engine.scenes.loads import (
    SWEEPS,
    FrontLoad,
    FrontPressure,
    GridPressure,
    table_bytes,
)
from semianalytic.engine.scenes.marched import Marched
from semianalytic.engine.scenes.nodes import state_bytes
from semianalytic.engine.scenes.record import MarchRecord
from semianalytic.engine.scenes.stepping import (
    Segment,
    levels_of,
    load_jumps,
    segments_between,
)
from semianalytic.engine.stepping.balance import Balance
from semianalytic.engine.stepping.blocks import BLOCK_STEPS, Blocks
from semianalytic.interface.law import InterfaceLaw
from semianalytic.memory.exponentials import fit_memory
from semianalytic.memory.impedance import Opening
from semianalytic.memory.line_memory import LineMemory
from semianalytic.results.memory import check_memory, memory_limit
from semianalytic.scene.friction import (
    CoulombFriction,
    FrictionLaw,
    RateFriction,
    SlipWeakening,
    ViscousFriction,
)

TOLERANCES = (1e-11, 1e-2)
"""Range of the memory's tolerance: 1e-11 takes 45 poles; 1e-2 is coarser than the grid."""
SINGLE_SIZE = 4096
"""Nodes up to which the memory has single precision: slip rates change by 5e-6 of themselves."""

BYTES_STORED = 32
"""Bytes per observed node and stored level: four fields."""

Progress = Callable[[int, int], object]
Array = NDArray[np.float64]


@dataclass(frozen=True)
class SceneFriction(InterfaceLaw):
    """The friction law of a scene, whose state is the accumulated |slip|, and its coefficient."""

    given: FrictionLaw
    friction: float

    def strength(self, pressure: Array, speed: Array, state: Array) -> Array:
        """Return the strength; see `InterfaceLaw.strength`."""
        return self.given.strength(self.friction * pressure, speed, state)

    def slip_speed(self, stopping: Array, pressure: Array, impedance: float, state: Array) -> Array:
        """Return the speed of balance; see `InterfaceLaw.slip_speed`."""
        return self.given.slip_speed(stopping, self.friction * pressure, impedance, state)

    def steady_slope(self) -> Any:
        """Return the viscosity, or None; see `InterfaceLaw.steady_slope`."""
        if type(self.given) is ViscousFriction:
            return self.given.viscosity
        return 0.0 if type(self.given) in (CoulombFriction, SlipWeakening) else None

    @property
    def follows_state(self) -> bool:
        """Whether strength may depend on the path; only these laws are known not to ask for it."""
        return not isinstance(self.given, CoulombFriction | RateFriction)


def advance(
    marched: Marched,
    end_time: float,
    memory: float | None,
    setup: float,
    progress: Progress | None,
) -> Marched:
    """Continue a march from the state reached to the end time, with its companion if there is one.

    Parameters
    ----------
    marched : Marched
        The march to be continued; it is not changed.
    end_time : float
        Time to march to [time].
    memory : float, optional
        Memory that the march may take [bytes].
    setup : float
        Time it took to make the grid and the memory [s], added to the statistics.
    progress : callable, optional
        Called with (step, steps) after each step, as in `march`.

    Raises
    ------
    SceneError
        If the march does not fit into the memory, or a step is beyond the stable range.
    TensionError
        If the pressure turns tensile at a node.
    ComputationError
        If values are no longer finite.
    """
    began = time.perf_counter()
    segments = segments_between(
        marched.scene, marched.end_time, end_time, marched.step_ratio, marched.grid.spacing
    )
    coarser, companion = [segment.coarser for segment in segments], marched.companion
    # `every` is chosen before the first step, from all memory that the march will hold at once.
    table = _table_bytes(marched, segments)
    table += 0.0 if companion is None else _table_bytes(companion, coarser)
    every = affordable_every(marched, memory, sum(part.steps for part in segments), table)
    walk, behind = _Walk(marched, segments, every, progress), None
    if companion is not None:
        # Half of `every`, rounded up, of half the steps: stored levels lie at about the same times.
        behind = _Walk(companion, coarser, -(-every // 2), None)
    departure = marched.departure
    for segment in segments:
        walk.begin(segment)
        if behind is not None:
            behind.begin(segment.coarser)
        while walk.done < segment.steps and not walk.record.stopped:
            walk.advance(BLOCK_STEPS)
            if behind is not None:
                behind.advance(walk.done // 2 - behind.done, walk.record.stopped)
                departure = _departure(departure, walk, behind)
        walk.blocks.settle()  # a segment of another step length may follow
        if behind is not None:
            behind.blocks.settle()
        if walk.record.stopped:
            break
    if companion is not None and behind is not None:
        companion = _reached(companion, behind, 0.0, 0.0)
    marched = replace(marched, companion=companion, departure=departure)
    return _reached(marched, walk, setup, time.perf_counter() - began)


def _departure(before: Departure, walk: _Walk, behind: _Walk) -> Departure:
    """Return a departure with the last block of a march and its companion, by the trapezoidal rule.

    Companion node i at (i + 1/2) 2h lies half-way between nodes 2i and 2i + 1 of the march.
    """
    slot, own = walk.grid.slot, behind.grid.observe(behind.blocks.levels[0])
    contact = walk.blocks.levels[0][::2, slot : slot + 2 * behind.grid.observed]
    rates = (contact[:, ::2] + contact[:, 1::2]) / 2
    cell = behind.grid.spacing * behind.time_step
    return Departure(
        before.difference + cell * float(np.trapezoid(np.abs(rates - own).sum(axis=1))),
        before.slip_rate + cell * float(np.trapezoid(np.abs(rates).sum(axis=1))),
    )


def affordable_every(marched: Marched, memory: float | None, steps: int, table: float) -> int:
    """Return `every`, raised until the stored levels fit into the memory.

    Parameters
    ----------
    marched : Marched
        The march to be continued; its companion is counted too.
    memory : float or None
        Memory that the march may take [bytes].
    steps : int
        Steps that are to come.
    table : float
        Size of the pressure tables [bytes].

    Raises
    ------
    SceneError
        If the march does not fit even without storing anything.
    """
    both = [one for one in (marched, marched.companion) if one is not None]
    state = sum(state_bytes(one.grid.size, one.statistics.poles) for one in both)
    per_level = sum(one.grid.observed * BYTES_STORED for one in both)
    earlier = sum(len(one.interface.t) * one.grid.observed * BYTES_STORED for one in both)
    sums = len(both) * steps * 96  # for times, loads and totals
    fixed = int(state + table + sums + earlier + 16 * per_level)  # at least 16 levels must fit
    check_memory(
        fixed,
        memory,
        f"march: {steps:.6g} steps of {marched.grid.size} nodes",
        "lower `nodes` or `end_time`, or raise `step_ratio` or `length`",
    )
    # `fixed` has room for 16 levels already, which leaves one level more as a margin.
    levels = (memory_limit(memory) - fixed) // per_level + 1
    return max(marched.every, math.ceil(steps / levels))


class _Walk:
    """A march under way, carried block by block of steps through segments.

    Parameters
    ----------
    marched : Marched
        Where the march starts from; it is not changed.
    segments : sequence of Segment
        The time steps to come.
    every : int
        Store every n-th level, and the last.
    progress : callable, optional
        Called with (step, steps) after each step; see `MarchRecord`.

    Attributes
    ----------
    time_step : float
        Length of the steps of the present segment [time].
    done : int
        Steps that have been taken in the present segment.
    """

    def __init__(
        self,
        marched: Marched,
        segments: Sequence[Segment],
        every: int,
        progress: Progress | None,
    ) -> None:
        self.grid, self.every, self.time_step, self.done = marched.grid, every, 0.0, 0
        self.record = MarchRecord(marched, sum(part.steps for part in segments), every, progress)
        self._marched, (self._pressure, self._front) = marched, _loads_on_grid(marched, segments)
        grid, scene, line = marched.grid, marched.scene, marched.grid.line
        law = SceneFriction(scene.friction_law, scene.friction)
        impedance = scene.material.shear_impedance / 2
        self.memory = LineMemory(marched.memory, line.wavenumbers, single=grid.size <= SINGLE_SIZE)
        self.memory.put_back(marched.past)
        touching = np.arange(grid.size) >= grid.slot
        self.blocks = Blocks(
            line,
            Balance(law, impedance, touching, line, falls=True),
            law,
            self.memory,
            marched.reached,
            kept=grid.contact,
            impedance=impedance,
            speed=scene.material.shear_speed,
            sweeps=SWEEPS,
            damping=marched.damping,
            means_last=True,
        )

    def begin(self, segment: Segment) -> None:
        """Enter a segment, applying the load jump at its beginning."""
        marched, scene, blocks = self._marched, self._marched.scene, self.blocks
        self.time_step, self.done = segment.time_step, 0
        self._levels = levels_of(scene, segment, self._pressure, self._front)
        first = next(self._levels)
        # A segment that begins neither with the load nor at a jump continues an earlier march,
        # whose rate is the right one already.
        if segment.begin == marched.begins or segment.begin in load_jumps(scene):
            blocks.jump(first)
            self.record.jump(blocks.reached)
        else:
            blocks.recall(first.pressure)
        if segment.begin == marched.recorded_from:
            self.record.begin(blocks.reached, first.pressure)

    def advance(self, steps: int, last: bool = False) -> None:
        """Take a block of up to so many steps, and record it; its end may be the `last` level.

        Raises
        ------
        TensionError
            If the contact would open.
        SceneError
            If friction weakens too fast under a pressure that arises.
        ComputationError
            If a slip rate is no longer finite.
        """
        blocks = self.blocks
        last |= blocks.advance(self._levels, self.record.count, steps)
        self.done += len(blocks.pressures)
        self.record.add(blocks, last)


def _loads_on_grid(
    marched: Marched, segments: Sequence[Segment]
) -> tuple[GridPressure | FrontPressure, FrontLoad | None]:
    """Return the pressure at the nodes of a march, and its load if the front of that moves."""
    scene, grid, finest = marched.scene, marched.grid, _finest(segments)
    front = None
    if scene.front_slowness:
        front = FrontLoad(scene, grid.nodes, grid.spacing, grid.slot, marched.entry)
        if scene.superposition.taken_off.pressure:
            material, memory = scene.material, marched.memory
            impedance = Opening(material.shear_speed / material.longitudinal_speed)
            # as accurate as the memory of shear
            tolerance = min(max(memory.error, 2 * TOLERANCES[0]), TOLERANCES[1])
            opening = fit_memory(impedance, memory.horizon, tolerance)
            start = (front, opening, grid.line.wavenumbers, marched.damping, marched.begins, finest)
            return FrontPressure(*start), front
    contact = grid.size - grid.slot
    return GridPressure(scene, contact, grid.spacing, segments[-1].end, finest), front


def _table_bytes(marched: Marched, segments: Sequence[Segment]) -> float:
    """Return the size of the pressure table of a march, or of its march of pressure [bytes]."""
    if marched.scene.front_slowness and marched.scene.superposition.taken_off.pressure:
        return state_bytes(marched.grid.size, marched.statistics.poles)
    contact = marched.grid.size - marched.grid.slot
    return table_bytes(marched.scene, contact, segments[-1].end / _finest(segments))


def _finest(segments: Sequence[Segment]) -> float:
    """Return the shortest time step of segments [time]."""
    return min(segment.time_step for segment in segments)


def _reached(marched: Marched, walk: _Walk, setup: float, steps: float) -> Marched:
    """Return the march at the state that was reached, with the seconds it took added."""
    before, record = marched.statistics, walk.record
    seconds = {
        "setup": before.seconds["setup"] + setup,
        "steps": before.seconds["steps"] + steps,
    }
    return replace(
        marched,
        interface=record.interface(),
        totals=record.totals(),
        every=walk.every,
        statistics=replace(before, steps=before.steps + record.done, seconds=seconds),
        reached=walk.blocks.reached,
        past=walk.memory.past(),
        seen=record.seen,
    )
