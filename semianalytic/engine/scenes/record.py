"""A march beside a slot under way, and its record: fields at stored levels, totals of all."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from semianalytic.engine.scenes.marched import Marched
from semianalytic.engine.scenes.slot import SlotLine
from semianalytic.engine.stepping.advance import Span, through
from semianalytic.engine.stepping.blocks import EqualSteps
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.results.sampled import Totals

Array = NDArray[np.float64]


class Walk:
    """A march under way through spans of time, block by block, and its record: fields of the
    observed contact at every n-th level and the last; totals and extremes of all.

    Parameters
    ----------
    marched : Marched
        The march that goes on.
    spans : list of Span
        Spans to come.
    finest : float
        Shortest step of the whole march [time].
    every : int
        n; levels are counted from t = 0, so that a continued march stores the same ones.
    block : int, optional
        Steps of a block.
    """

    def __init__(
        self,
        marched: Marched,
        spans: list[Span],
        finest: float,
        every: int,
        block: int | None = None,
    ) -> None:
        self._marched, self._spans, self.every, self.taken = marched, spans, every, 0
        self.grid, self._line = marched.grid, SlotLine(marched, finest)
        self.blocks = EqualSteps(self._line, marched.reached, block)
        self.count = sum(span.steps(max(span.begin, marched.end_time)) for span in spans)
        self._seen, earlier, before = marched.seen, marched.interface, marched.statistics.steps
        whole = (before + self.count) // every - before // every
        # in addition to every n-th: the level at t = 0, the last, and one where the march may be
        # stopped
        levels = (not len(earlier.t)) + whole + bool((before + self.count) % every) + 1
        # a march ends where the contact would open, so that the gap, the last field, is zero
        stored = [getattr(earlier, field.name) for field in fields(earlier)][1:-1]
        # the pressure before is that of all levels where no load changes it
        self._steady = not marched.scene.superposition.taken_off.pressure
        self._held = np.zeros(marched.grid.observed)
        self._stored = _Rows(stored[:-1] if self._steady else stored, levels)
        summed = [getattr(marched.totals, field.name) for field in fields(Totals)]
        self._summed = _Rows(summed, (not before) + self.count)

    def steps(self, asked: Callable[[float], bool]) -> Iterator[bool]:
        """Step on block by block, and record it, until `asked` says so; yield whether it did."""
        stopped, blocks, start = False, self.blocks, self._marched.end_time

        def ends(time: float) -> bool:
            nonlocal stopped
            stopped = asked(time)
            return stopped

        first = self._line.after(start, self._spans[0].step)
        if start in (self._marched.begins, *self._line.jumps):
            blocks.jump(first)
            self._turn()
            self._begin(first.pressure)
        else:
            blocks.recall(first.pressure)
        for _ in through(self._line, blocks, self._spans, ends):
            if len(blocks.times) > 1:
                self._add(stopped)
            else:
                self._turn()
            yield stopped

    def _turn(self) -> None:
        """Add the level after a jump of loads to the extremes: both levels there are the same one,
        so that nothing is interpolated across the jump."""
        now = self.grid.observe(self.blocks.levels[0][-1:])
        self._seen = self._seen.with_levels(self.blocks.times[-1:] * 2, np.concatenate([now, now]))

    def _begin(self, pressure: Array) -> None:
        """Store the level that is reached if the record begins there."""
        at = self.blocks.times[-1:]
        if at[0] == self._marched.recorded_from and not self._stored.count:
            rate, traction, slip, path, work = (level[-1:] for level in self.blocks.levels)
            self._store(at, slip, rate, traction, [pressure])
            self._sum(at, slip, path, work)

    def _add(self, last: bool) -> None:
        """Add the levels of a block, at the end of which the march may have been stopped."""
        times, pressures = self.blocks.times, self.blocks.pressures
        rates, tractions, slips, paths, works = self.blocks.levels
        taken = len(times) - 1
        self.taken += taken
        # a span ends where the record begins
        if times[-1] <= self._marched.recorded_from:
            self._begin(pressures[-1])
            return
        self._seen = self._seen.with_levels(times, self.grid.observe(rates))
        self._sum(times[1:], slips[1:], paths[1:], works[1:])
        reached = self._marched.statistics.steps + self.taken
        kept = np.arange(reached - taken + 1, reached + 1) % self.every == 0
        kept[-1] |= last or self.taken == self.count
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
        slips, tractions = (field[:, : grid.observed] for field in (slips, tractions))
        rows = times, slips, grid.observe(rates), tractions
        if self._steady:
            self._held = pressures[-1][: grid.observed]
            self._stored.add(*rows)
        else:
            self._stored.add(*rows, [pressure[: grid.observed] for pressure in pressures])

    def _sum(self, times: Sequence[float], slips: Array, paths: Array, works: Array) -> None:
        """Add the totals of levels: sums over nodes times h are integrals over the contact."""
        # Each node is the middle of a stretch h (x = (i + 1/2) h): the midpoint rule.
        n, h = self.grid.observed, self.grid.spacing
        largest = np.abs(slips[:, :n]).max(axis=1)
        self._summed.add(times, largest, *(rows[:, :n].sum(axis=1) * h for rows in (paths, works)))

    def reached(self) -> Marched:
        """Return the march until the state reached."""
        times, *stored = self._stored.arrays()
        if self._steady:
            stored.append(np.broadcast_to(self._held, stored[0].shape))
        closed, before = np.broadcast_to(0.0, stored[0].shape), self._marched.statistics
        return replace(
            self._marched,
            interface=InterfaceHistory(self.grid.x, times, *[*stored, closed]),
            totals=Totals(*self._summed.arrays()),
            every=self.every,
            statistics=replace(before, steps=before.steps + self.taken),
            reached=self.blocks.reached,
            past=self._line.memory.past(),
            seen=self._seen,
        )


class _Rows:
    """Arrays of which rows are filled one after the other, so many `more` than there are."""

    def __init__(self, earlier: Sequence[Array], more: int) -> None:
        self.count = len(earlier[0])
        self._arrays = [np.empty((self.count + more, *stored.shape[1:])) for stored in earlier]
        for array, stored in zip(self._arrays, earlier, strict=True):
            array[: self.count] = stored

    def add(self, *rows: Any) -> None:
        """Fill rows, of which each array has some."""
        part = slice(self.count, self.count + len(rows[0]))
        for array, values in zip(self._arrays, rows, strict=True):
            array[part] = values
        self.count = part.stop

    def arrays(self) -> list[Array]:
        """Return the rows that are filled."""
        return [array[: self.count] for array in self._arrays]
