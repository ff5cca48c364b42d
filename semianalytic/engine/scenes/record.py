"""The record of a march: stored levels, and the extremes and totals over every step."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from semianalytic.engine.scenes.marched import Marched
from semianalytic.engine.stepping.blocks import Blocks, Reached
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.results.sampled import Totals

Array = NDArray[np.float64]


class MarchRecord:
    """The recorded levels of a march, in arrays that are allocated at their final length.

    Parameters
    ----------
    marched : Marched
        The march so far; its levels and totals are kept.
    steps : int
        Steps that are to come.
    every : int
        Store every n-th level, and the last.
    progress : callable, optional
        Called with (step, steps) after each step until it returns True; the march then ends at the
        next even step, which its companion reaches as well.

    Attributes
    ----------
    done : int
        Steps recorded since the march was entered.
    stopped : bool
        Whether the march has ended because `progress` asked for it.
    seen : Extremes
        Extremes over every step, stored or not.
    """

    def __init__(
        self,
        marched: Marched,
        steps: int,
        every: int,
        progress: Callable[[int, int], object] | None,
    ) -> None:
        self._marched, self._steps, self._every, self._progress = marched, steps, every, progress
        self.done, self.stopped, self.seen, self._asked = 0, False, marched.seen, False
        earlier, before = marched.interface, marched.statistics.steps
        # Levels are counted from t = 0, so that a continued march stores the same ones.
        whole = (before + steps) // every - before // every
        # besides every n-th: the level at t = 0, the last, and one where the march may be stopped
        levels = (not len(earlier.t)) + whole + bool((before + steps) % every) + 1
        # a march ends where the contact would open, so that the gap, the last field, is zero
        stored = [getattr(earlier, one.name) for one in fields(earlier)][1:-1]
        self._levels = _Rows(stored, levels)
        summed = [getattr(marched.totals, one.name) for one in fields(Totals)]
        self._totals = _Rows(summed, (not before) + steps)

    def begin(self, now: Reached, pressure: Array) -> None:
        """Store the level at t = 0, with the pressure of the contact, unless it is stored."""
        if not self._levels.count:
            values = now.slip, now.rate, now.traction, now.state, now.work
            slip, rate, traction, path, work = (value[None] for value in values)
            self._store([now.time], slip, rate, traction, [pressure])
            self._sum([now.time], slip, path, work)

    def jump(self, now: Reached) -> None:
        """Include in `seen` the slip rate right after a jump of the loads."""
        # Both levels are the same one: nothing is interpolated across a jump.
        rates = self._marched.grid.observe(np.stack([now.rate, now.rate]))
        self.seen = self.seen.with_levels([now.time] * 2, rates)

    def count(self, time: float) -> bool:
        """Count a step, which belongs to the next levels that are added, and report it.

        Return whether the march is to end there.
        """
        self.done += 1
        if self._progress is not None and not self._asked:
            self._asked = self._progress(self.done, self._steps) is True
        self.stopped = self._asked and self.done % 2 == 0
        return self.stopped

    def add(self, blocks: Blocks, last: bool) -> None:
        """Add the levels of the last block; with the `last` one the march ends."""
        times, pressures = blocks.times, blocks.pressures
        rates, tractions, slips, paths, works = blocks.levels
        taken, kept = len(times) - 1, np.zeros(len(times) - 1, dtype=bool)
        # a segment ends where the record begins
        if times[-1] > self._marched.recorded_from:
            self.seen = self.seen.with_levels(times, self._marched.grid.observe(rates))
            self._sum(times[1:], slips[1:], paths[1:], works[1:])
            reached = self._marched.statistics.steps + self.done
            kept = np.arange(reached - taken + 1, reached + 1) % self._every == 0
            kept[-1] |= self.done == self._steps
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
        grid = self._marched.grid
        observed = [one[: grid.observed] for one in pressures]
        slips, tractions = (field[:, : grid.observed] for field in (slips, tractions))
        self._levels.add(times, slips, grid.observe(rates), tractions, observed)

    def _sum(self, times: Sequence[float], slips: Array, paths: Array, works: Array) -> None:
        """Add the totals of levels: sums over nodes times h are integrals over the contact."""
        # Each node is the middle of a stretch h (x = (i + 1/2) h): the midpoint rule.
        n, h = self._marched.grid.observed, self._marched.grid.spacing
        largest = np.abs(slips[:, :n]).max(axis=1)
        self._totals.add(times, largest, *(one[:, :n].sum(axis=1) * h for one in (paths, works)))

    def interface(self) -> InterfaceHistory:
        """Return the stored levels."""
        times, *stored = self._levels.arrays()
        closed = np.broadcast_to(0.0, stored[0].shape)
        return InterfaceHistory(self._marched.grid.x, times, *[*stored, closed])

    def totals(self) -> Totals:
        """Return the totals of every step."""
        return Totals(*self._totals.arrays())


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
