"""The record of a march: stored levels, and the extremes and totals over every step."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields

import numpy as np
from numpy.typing import NDArray

from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.results.sampled import Totals
from semianalytic.spacetime.marched import Marched, MarchState

Array = NDArray[np.float64]

_FIELDS = ("slip", "slip_rate", "shear_traction", "pressure")
"""Fields that are stored of each level; a march ends where the contact would open."""


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
        Called with (step, steps) after each step; if it returns True the march is `stopped`.

    Attributes
    ----------
    done : int
        Steps recorded since the march was entered.
    stopped : bool
        Whether `progress` has ended the march.
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
        self._observed, self._spacing = marched.grid.observed, marched.grid.spacing
        self.done, self.stopped, self.seen = 0, False, marched.seen
        earlier, before = marched.interface, marched.statistics.steps
        self._stored = len(earlier.t)
        # Levels are counted from t = 0, so that a continued march stores the same ones.
        whole = (before + steps) // every - before // every
        # besides every n-th: the level at t = 0, the last, and one where the march may be stopped
        levels = self._stored + (not self._stored) + whole + bool((before + steps) % every) + 1
        self._times = _extended(earlier.t, levels)
        self._fields = [_extended(getattr(earlier, name), levels) for name in _FIELDS]
        self._summed = len(marched.totals.t)
        self._totals = [
            _extended(getattr(marched.totals, field.name), self._summed + (not before) + steps)
            for field in fields(Totals)
        ]

    def begin(self, state: MarchState, pressure: Array) -> None:
        """Store the level at t = 0, with the pressure of the contact, unless it is stored."""
        if self._stored:
            return
        self._store(state, pressure)
        self._sum(state)

    def jump(self, state: MarchState) -> None:
        """Include in `seen` the slip rate right after a jump of the loads."""
        # Both levels are the same one: nothing is interpolated across a jump.
        rate = self._marched.grid.observe(state.rate)
        self.seen = self.seen.with_level(
            state.time, state.time, rate, rate, state.slip[: self._observed]
        )

    def add(self, before: MarchState, state: MarchState, pressure: Array) -> None:
        """Add the level `state` that follows `before`, with the pressure of the contact."""
        reached = self._marched.statistics.steps + self.done + 1
        if state.time > self._marched.recorded_from:
            self._see(before, state)
        self.done += 1
        self.stopped = self._progress is not None and (
            self._progress(self.done, self._steps) is True
        )
        last = self.done == self._steps or self.stopped
        recorded = state.time > self._marched.recorded_from or self.stopped
        if recorded and (reached % self._every == 0 or last):
            self._store(state, pressure)

    def _see(self, before: MarchState, state: MarchState) -> None:
        """Include a level in extremes and totals."""
        observe = self._marched.grid.observe
        self.seen = self.seen.with_level(
            before.time,
            state.time,
            observe(before.rate),
            observe(state.rate),
            state.slip[: self._observed],
        )
        self._sum(state)

    def _store(self, state: MarchState, pressure: Array) -> None:
        """Store a level."""
        self._times[self._stored] = state.time
        rate = state.rate[self._marched.grid.contact]
        for kept, field in zip(
            self._fields, (state.slip, rate, state.traction, pressure), strict=True
        ):
            kept[self._stored] = field[: self._observed]
        self._stored += 1

    def _sum(self, state: MarchState) -> None:
        """Add the totals of a level: sums over nodes times h are integrals over the contact."""
        slip, path, work = (
            field[: self._observed] for field in (state.slip, state.path, state.work)
        )
        # Each node is the middle of a stretch h (x = (i + 1/2) h): the midpoint rule.
        largest = np.abs(slip).max()
        totals = (state.time, largest, path.sum() * self._spacing, work.sum() * self._spacing)
        for kept, total in zip(self._totals, totals, strict=True):
            kept[self._summed] = total
        self._summed += 1

    def interface(self) -> InterfaceHistory:
        """Return the stored levels."""
        kept = slice(0, self._stored)
        fields = [field[kept] for field in self._fields]
        # a march ends where the contact would open, so the gap is zero throughout
        closed = np.broadcast_to(0.0, (self._stored, self._observed))
        return InterfaceHistory(self._marched.grid.x, self._times[kept], *[*fields, closed])

    def totals(self) -> Totals:
        """Return the totals of every step."""
        return Totals(*(total[: self._summed] for total in self._totals))


def _extended(earlier: Array, rows: int) -> Array:
    """Return an array of so many rows that begins with the rows of an earlier one."""
    longer = np.empty((rows, *earlier.shape[1:]))
    longer[: len(earlier)] = earlier
    return longer
