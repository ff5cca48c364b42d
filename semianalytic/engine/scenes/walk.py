"""A march under way: steps in blocks through segments of time, and what is recorded of them.

A step takes the loads at its end, computes the traction that would stop each node under the memory
of past slip, from it and the friction law the slip rate, and adds the new slip to the memory.
Steps are summed up and recorded in blocks (`EqualSteps`; docs/spacetime.md, "Method").
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from semianalytic.engine.scenes.loads import SWEEPS, FrontPressure, GridFront, GridPressure
from semianalytic.engine.scenes.marched import Marched
from semianalytic.engine.scenes.stepping import Segment, levels_of, load_jumps
from semianalytic.engine.stepping.balance import Balance
from semianalytic.engine.stepping.blocks import EqualSteps
from semianalytic.memory.exponentials import fit_memory
from semianalytic.memory.impedance import Opening
from semianalytic.memory.line_memory import LineMemory
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.results.sampled import Totals

TOLERANCES = (1e-11, 1e-2)
"""Range of the memory's tolerance: 1e-11 takes 45 poles; 1e-2 is coarser than the grid."""
SINGLE_SIZE = 4096
"""Nodes up to which the memory has single precision: slip rates change by 5e-6 of themselves."""
SINGLE_RATES = 1e-20, 1e20
"""Slip rates [length / time] that single precision, 1e-38 to 3e38, holds with all their sums."""

Progress = Callable[[int, int], object]
Array = NDArray[np.float64]


class Walk:
    """A march under way, carried block by block of steps through segments, with its record.

    Levels and totals lie in arrays that are allocated at their final length.

    Parameters
    ----------
    marched : Marched
        Where the march starts from; it is not changed.
    segments : sequence of Segment
        The time steps to come.
    finest : float
        Shortest step of the whole march [time].
    every : int
        Store every n-th level, and the last.
    progress : callable, optional
        Called with (step, steps) after each step until it returns True; the march then ends at the
        next even step, which its companion reaches as well.

    Attributes
    ----------
    time_step : float
        Length of the steps of the present segment [time].
    done : int
        Steps that have been taken in the present segment.
    stopped : bool
        Whether the march has ended because `progress` asked for it.
    """

    def __init__(
        self,
        marched: Marched,
        segments: Sequence[Segment],
        finest: float,
        every: int,
        progress: Progress | None,
    ) -> None:
        self.grid, self.every, self.time_step, self.done = marched.grid, every, 0.0, 0
        self._marched, (self._pressure, self._front) = marched, _loads_on_grid(marched, finest)
        self._progress, self._steps = progress, sum(part.steps for part in segments)
        self._taken, self.stopped, self._seen, self._asked = 0, False, marched.seen, False
        earlier, before = marched.interface, marched.statistics.steps
        # Levels are counted from t = 0, so that a continued march stores the same ones.
        whole = (before + self._steps) // every - before // every
        # besides every n-th: the level at t = 0, the last, and one where the march may be stopped
        levels = (not len(earlier.t)) + whole + bool((before + self._steps) % every) + 1
        # a march ends where the contact would open, so that the gap, the last field, is zero
        stored = [getattr(earlier, one.name) for one in fields(earlier)][1:-1]
        self._stored = _Rows(stored, levels)
        summed = [getattr(marched.totals, one.name) for one in fields(Totals)]
        self._summed = _Rows(summed, (not before) + self._steps)
        grid, scene, line = marched.grid, marched.scene, marched.grid.line
        law = scene.law
        impedance = scene.material.shear_impedance / 2
        # rates of units that are far from 1 would leave the range of single precision
        sizes = [max(abs(one.pressure), abs(one.shear)) for one in scene.superposition]
        usual = SINGLE_RATES[0] < max(sizes) / impedance < SINGLE_RATES[1]
        single = usual and grid.size <= SINGLE_SIZE
        self._memory = LineMemory(marched.memory, line.wavenumbers, single=single)
        self._memory.put_back(marched.past)
        touching = np.arange(grid.size) >= grid.slot
        self.blocks = EqualSteps(
            line,
            Balance(law, impedance, touching, line, falls=True),
            law,
            self._memory,
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
        if not segment.first and segment.begin in (marched.begins, *load_jumps(scene)):
            blocks.jump(first)
            # Both levels are the same one: nothing is interpolated across a jump.
            now = blocks.reached
            rates = self.grid.observe(np.stack([now.rate, now.rate]))
            self._seen = self._seen.with_levels([now.time] * 2, rates)
        else:
            blocks.recall(first.pressure)
        if segment.start == marched.recorded_from and not self._stored.count:
            rate, traction, slip, path, work = blocks.levels
            self._store([blocks.time], slip, rate, traction, [first.pressure])
            self._sum([blocks.time], slip, path, work)

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
        last |= blocks.advance(self._levels, self._count, steps)
        self.done += len(blocks.pressures)
        self._add(last)

    def _count(self, time: float) -> bool:
        """Count a step, which belongs to the next levels that are added, and report it.

        Return whether the march is to end there.
        """
        self._taken += 1
        if self._progress is not None and not self._asked:
            self._asked = self._progress(self._taken, self._steps) is True
        self.stopped = self._asked and self._taken % 2 == 0
        return self.stopped

    def _add(self, last: bool) -> None:
        """Add the levels of the last block; with the `last` one the march ends."""
        times, pressures = self.blocks.times, self.blocks.pressures
        rates, tractions, slips, paths, works = self.blocks.levels
        taken, kept = len(times) - 1, np.zeros(len(times) - 1, dtype=bool)
        # a segment ends where the record begins
        if times[-1] > self._marched.recorded_from:
            self._seen = self._seen.with_levels(times, self.grid.observe(rates))
            self._sum(times[1:], slips[1:], paths[1:], works[1:])
            reached = self._marched.statistics.steps + self._taken
            kept = np.arange(reached - taken + 1, reached + 1) % self.every == 0
            kept[-1] |= self._taken == self._steps
        kept[-1] |= last
        rows = np.flatnonzero(kept)
        if len(rows):
            # all rows without the copy of an index, which would take as long as the storing
            part = slice(1, None) if len(rows) == taken else rows + 1
            pressed = [pressures[row] for row in rows.tolist()]
            self._store(np.asarray(times)[part], slips[part], rates[part], tractions[part], pressed)

    def _store(
        self,
        times: Sequence[float] | Array,
        slips: Array,
        rates: Array,
        tractions: Array,
        pressures: Sequence[Array],
    ) -> None:
        """Store levels at the observed nodes."""
        grid = self.grid
        observed = [one[: grid.observed] for one in pressures]
        slips, tractions = (field[:, : grid.observed] for field in (slips, tractions))
        self._stored.add(times, slips, grid.observe(rates), tractions, observed)

    def _sum(self, times: Sequence[float], slips: Array, paths: Array, works: Array) -> None:
        """Add the totals of levels: sums over nodes times h are integrals over the contact."""
        # Each node is the middle of a stretch h (x = (i + 1/2) h): the midpoint rule.
        n, h = self.grid.observed, self.grid.spacing
        largest = np.abs(slips[:, :n]).max(axis=1)
        self._summed.add(times, largest, *(one[:, :n].sum(axis=1) * h for one in (paths, works)))

    def reached(self, setup: float, seconds: float) -> Marched:
        """Return the march until the state reached; seconds [s] are added to its statistics."""
        times, *stored = self._stored.arrays()
        closed, before = np.broadcast_to(0.0, stored[0].shape), self._marched.statistics
        taken = {"setup": setup, "steps": seconds}
        taken = {name: before.seconds[name] + more for name, more in taken.items()}
        return replace(
            self._marched,
            interface=InterfaceHistory(self.grid.x, times, *[*stored, closed]),
            totals=Totals(*self._summed.arrays()),
            every=self.every,
            statistics=replace(before, steps=before.steps + self._taken, seconds=taken),
            reached=self.blocks.reached,
            past=self._memory.past(),
            seen=self._seen,
        )


def _loads_on_grid(
    marched: Marched, finest: float
) -> tuple[GridPressure | FrontPressure, GridFront | None]:
    """Return the pressure at the nodes of a march, and its load if the front of that moves."""
    scene, grid = marched.scene, marched.grid
    front = None
    if scene.front_slowness:
        front = GridFront(scene, grid.nodes, grid.spacing, grid.slot, marched.entry)
        if scene.superposition.taken_off.pressure:
            material, memory = scene.material, marched.memory
            impedance = Opening(material.shear_speed / material.longitudinal_speed)
            # as accurate as the memory of shear
            tolerance = min(max(memory.error, 2 * TOLERANCES[0]), TOLERANCES[1])
            opening = fit_memory(impedance, memory.horizon, tolerance)
            start = (front, opening, grid.line.wavenumbers, marched.damping, marched.begins, finest)
            return FrontPressure(*start), front
    contact = grid.size - grid.slot
    return GridPressure(scene, contact, grid.spacing, marched.latest, finest), front


class _Rows:
    """Arrays of which rows are filled one after the other, so many `more` than there are."""

    def __init__(self, earlier: Sequence[Array], more: int) -> None:
        self.count = len(earlier[0])
        self._arrays = [np.empty((self.count + more, *one.shape[1:])) for one in earlier]
        for array, one in zip(self._arrays, earlier, strict=True):
            array[: self.count] = one

    def add(self, *rows: Any) -> None:
        """Fill rows, of which each array has some."""
        part = slice(self.count, self.count + len(rows[0]))
        for array, values in zip(self._arrays, rows, strict=True):
            array[part] = values
        self.count = part.stop

    def arrays(self) -> list[Array]:
        """Return the rows that are filled."""
        return [array[: self.count] for array in self._arrays]
