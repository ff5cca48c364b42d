"""A march next to a slot under way, and its record: fields at stored levels, totals of all."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from semianalytic.engine.marched import Marched
from semianalytic.engine.nodes import SlotCheckpoint
from semianalytic.engine.slot import SlotLine
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
        start = marched.checkpoint
        assert isinstance(start, SlotCheckpoint)
        self._marched, self._start, self._spans = marched, start, spans
        self._line, self.every, self.taken = SlotLine(marched, finest), every, 0
        self.grid = start.grid
        self.blocks = EqualSteps(self._line, start.reached, block)
        self.count = sum(span.steps(max(span.begin, start.reached.time)) for span in spans)
        # recorded from t = 0, or before it if waves of the load come earlier
        self._first = start.begins if marched.scene.front_too_slow else 0.0
        self._seen, earlier, before = marched.seen, marched.interface, start.steps
        whole = (before + self.count) // every - before // every
        # in addition to every n-th: the level at t = 0, the last, and one where the march may be
        # stopped
        levels = (not len(earlier.t)) + whole + bool((before + self.count) % every) + 1
        stored = [earlier.t, earlier.slip, earlier.slip_rate, earlier.shear_traction]
        # the pressure before is that of all levels where no load changes it
        self._steady = not marched.scene.superposition.taken_off.pressure
        self._held = np.zeros(self.grid.observed)
        self._stored = _Rows(stored if self._steady else [*stored, earlier.pressure], levels)
        summed = [getattr(marched.totals, known.name) for known in fields(Totals)]
        self._summed = _Rows(summed, (not before) + self.count)

    def steps(self, asked: Callable[[float], bool]) -> Iterator[bool]:
        """Step on block by block, and record it, until `asked` says so; yield whether it did."""
        stopped, blocks, start = False, self.blocks, self._start.reached.time

        def ends(time: float) -> bool:
            nonlocal stopped
            stopped = asked(time)
            return stopped

        first = self._line.after(start, self._spans[0].step)
        if start in (self._start.begins, *self._line.jumps):
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
        if at[0] == self._first and not self._stored.count:
            rate, traction, slip, path, work = (level[-1:] for level in self.blocks.levels)
            self._store(at, slip, rate, traction, [pressure])
            self._sum(at, slip, rate, path, work)

    def _add(self, last: bool) -> None:
        """Add the levels of a block, at the end of which the march may have been stopped."""
        times, pressures = self.blocks.times, self.blocks.pressures
        rates, tractions, slips, paths, works = self.blocks.levels
        taken = len(times) - 1
        self.taken += taken
        # a span ends where the record begins
        if times[-1] <= self._first:
            self._begin(pressures[-1])
            return
        self._seen = self._seen.with_levels(times, self.grid.observe(rates))
        self._sum(times[1:], slips[1:], rates[1:], paths[1:], works[1:])
        reached = self._start.steps + self.taken
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

    def _sum(
        self, times: Sequence[float], slips: Array, rates: Array, paths: Array, works: Array
    ) -> None:
        """Add the totals of levels: sums over nodes times h are integrals over the contact."""
        # Each node is the middle of a stretch h (x = (i + 1/2) h): the midpoint rule.
        n, h = self.grid.observed, self.grid.spacing
        both = slips[:, :n], self.grid.observe(rates)
        largest, peaks = (np.abs(rows).max(axis=1) for rows in both)
        sums = (rows[:, :n].sum(axis=1) * h for rows in (paths, works))
        self._summed.add(times, largest, *sums, peaks)

    def reached(self, **known: Any) -> Marched:
        """Return the march until the state reached, with what else its checkpoint is to have."""
        times, *stored = self._stored.arrays()
        if self._steady:
            stored.append(np.broadcast_to(self._held, stored[0].shape))
        # a march ends where the contact would open: the gap is zero
        closed = np.broadcast_to(0.0, stored[0].shape)
        checkpoint = replace(
            self._start,
            every=self.every,
            steps=self._start.steps + self.taken,
            reached=self.blocks.reached,
            past=self._line.memory.past(),
            **known,
        )
        return replace(
            self._marched,
            interface=InterfaceHistory(self.grid.x, times, *[*stored, closed]),
            totals=Totals(*self._summed.arrays()),
            seen=self._seen,
            checkpoint=checkpoint,
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
