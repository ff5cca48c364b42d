"""Advance a march and its companion from the state they have reached, from jump to jump.

The companion of a march is the same march on half the nodes in half the steps.  The difference
between the two gives the error estimate (docs/spacetime.md, "Error of a march").  The companion
follows a block of steps behind: little has to be stored for the comparison, and either grid stays
in the processor cache for a while.  Each of its nodes lies half-way between two nodes of the march.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from semianalytic.engine.convergence import Departure
from semianalytic.engine.scenes.loads import (
    FrontLoad,
    FrontPressure,
    GridPressure,
    NodalPressure,
    table_bytes,
)
from semianalytic.engine.scenes.marched import Marched
from semianalytic.engine.scenes.record import MarchRecord
from semianalytic.engine.scenes.room import affordable_every, state_bytes
from semianalytic.engine.scenes.stepping import Segment, Walk, segments_between
from semianalytic.memory.exponentials import fit_memory
from semianalytic.memory.impedance import Opening

TOLERANCES = (1e-11, 1e-2)
"""Range of the memory's tolerance: 1e-11 takes 45 poles; 1e-2 is coarser than the grid."""

Array = NDArray[np.float64]


def advance(
    marched: Marched,
    end_time: float,
    memory: float | None,
    setup: float,
    progress: Callable[[int, int], object] | None,
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
    walk = _walk(marched, segments, every, progress)
    if companion is None:
        for segment in segments:
            _march_segment(segment, walk, None)
        return _reached(marched, walk, every, setup, time.perf_counter() - began)
    # Half of `every`, rounded up, of half the steps: stored levels lie at about the same times.
    own_every = -(-every // 2)
    # The companion has no progress of its own; it stops where the march was stopped.
    behind = _walk(companion, coarser, own_every, lambda done, steps: follower.stopping)
    follower = Follower(behind, walk, marched.departure)
    for segment in segments:
        _march_segment(segment, walk, follower)
    companion = _reached(companion, behind, own_every, 0.0, follower.seconds)
    marched = replace(marched, companion=companion, departure=follower.departure)
    return _reached(marched, walk, every, setup, time.perf_counter() - began)


def _march_segment(segment: Segment, walk: Walk, follower: Follower | None) -> None:
    """March to the end of a segment, or until stopped; do nothing if already stopped."""
    if walk.record.stopped:
        return
    walk.begin(segment)
    if follower is not None:
        follower.begin(segment)
    while walk.done < segment.steps and not walk.record.stopped:
        walk.advance(segment.steps - walk.done)
        if follower is not None:
            follower.follow()
    walk.end()
    if follower is not None:
        follower.end()


def _walk(
    marched: Marched,
    segments: Sequence[Segment],
    every: int,
    progress: Callable[[int, int], object] | None,
) -> Walk:
    """Prepare a march for its way through segments."""
    pressure, front = loads_on_grid(marched, segments)
    steps = sum(segment.steps for segment in segments)
    return Walk(marched, pressure, front, MarchRecord(marched, steps, every, progress))


def loads_on_grid(
    marched: Marched, segments: Sequence[Segment]
) -> tuple[NodalPressure, FrontLoad | None]:
    """Return the pressure at the nodes of a march, and its load if the front of that moves.

    Parameters
    ----------
    marched : Marched
        The march; its grid, memory and damping are used.
    segments : sequence of Segment
        The time steps to come.
    """
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
            start = (front, opening, grid.wavenumbers, marched.damping, marched.begins, finest)
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


def _reached(marched: Marched, walk: Walk, every: int, setup: float, steps: float) -> Marched:
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
        every=every,
        statistics=replace(before, steps=before.steps + record.done, seconds=seconds),
        state=walk.state,
        seen=record.seen,
    )


class Follower:
    """A companion under way, behind the march it follows.

    Parameters
    ----------
    walk : Walk
        The steps of the companion.
    leader : Walk
        The steps of the march.
    departure : Departure
        Difference between the two until now.

    Attributes
    ----------
    departure : Departure
        Difference between the two, updated with each step of the companion.
    stopping : bool
        Whether the step under way is the last, because the march was stopped.
    seconds : float
        Time that the companion has taken [s].
    """

    def __init__(self, walk: Walk, leader: Walk, departure: Departure) -> None:
        self.departure, self.stopping, self.seconds = departure, False, 0.0
        self._walk, self._leader = walk, leader

    def begin(self, segment: Segment) -> None:
        """Enter a segment of the march, after the march has entered it."""
        self._steps, self._segment = segment.steps, segment.coarser
        self._walk.begin(self._segment)
        self._rates = self._paired(self._leader.rates)
        self._difference, self._slip_rate = self._look(self._rates, self._walk.rates)

    def follow(self) -> None:
        """Catch up with a block of steps of the march; if it was stopped, to a level before."""
        began = time.perf_counter()
        done, whole = self._leader.done, self._segment.steps
        self._rates = np.concatenate([self._rates[-1:], self._paired(self._leader.rates[1:])])
        # Times are compared as whole numbers: level i of n steps of the march and level j of m
        # steps of the companion are at i m and j n.
        reached = (done * whole - self._leader.record.stopped) // self._steps
        first = done - len(self._rates) + 1
        while self._walk.done < reached:
            before = self._walk.done
            self._walk.advance(reached - before)
            levels = self._steps * np.arange(before + 1, self._walk.done + 1)
            # the level of the march at or after each, and the share of the level before it
            after, share = -(-levels // whole) - first, (-levels % whole)[:, None] / whole
            rates = self._rates[after]
            if share.any():
                rates = (1 - share) * rates + share * self._rates[np.maximum(after - 1, 0)]
            self._add(rates)
        self.seconds += time.perf_counter() - began

    def end(self) -> None:
        """Leave the segment where the march leaves it."""
        self._walk.end()
        if self._leader.record.stopped:
            # the march may have stopped between two levels of the companion: one step of its own
            # length brings the companion to the same time
            self.stopping = True
            self._walk.begin(Segment(self._walk.time, self._leader.time, 1))
            self._walk.advance(1)
            self._add(self._paired(self._leader.rates[-1:]))
            self._walk.end()

    def _add(self, rates: Array) -> None:
        """Add the last steps of the companion, by the trapezoidal rule.

        `rates` (k, n) are the slip rates of the march at their ends, at the companion's nodes.
        """
        differences, slip_rates = self._look(rates, self._walk.rates[1:])
        half = self._walk.grid.spacing * self._walk.time_step / 2
        self.departure = Departure(
            self.departure.difference + half * _ends(self._difference, differences),
            self.departure.slip_rate + half * _ends(self._slip_rate, slip_rates),
        )
        self._difference, self._slip_rate = differences, slip_rates

    def _look(self, rates: Array, own: Array) -> tuple[Array, Array]:
        """Sum |V - V of the companion| and |V| over the nodes, given V of the march, (k, n)."""
        own = self._walk.grid.observe(own)
        return np.abs(rates - own).sum(axis=1), np.abs(rates).sum(axis=1)

    def _paired(self, rates: Array) -> Array:
        """Return slip rates of the march (k, size) at the nodes of the companion, (k, n)."""
        # companion node i at (i + 1/2) 2h lies half-way between nodes 2i and 2i + 1 of the march
        slot = self._leader.grid.slot
        contact = rates[:, slot : slot + 2 * self._walk.grid.observed]
        return np.asarray((contact[:, ::2] + contact[:, 1::2]) / 2)


def _ends(before: Array, now: Array) -> float:
    """Return the sum over steps of the values at both their ends.

    `now` holds the values at the ends of the steps, `before` ends with that at the start of the
    first one.
    """
    return float(before[-1] + 2 * now[:-1].sum() + now[-1])
