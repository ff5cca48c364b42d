"""The record of a march: stored levels, and the extremes and totals over every step."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import fields

import numpy as np
from numpy.typing import NDArray

from semianalytic.engine.scenes.marched import Marched
from semianalytic.engine.scenes.state import MarchState
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.results.sampled import Totals

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
        rate = self._marched.grid.observe(state.rate)
        fields = (state.slip, rate, state.traction, pressure)
        self._store([state.time], *(field[None] for field in fields))
        self._sum([state.time], state.slip[None], state.path[None], state.work[None])

    def jump(self, time: float, rate: Array, slip: Array) -> None:
        """Include in `seen` the slip rate (size,) right after a jump of the loads."""
        # Both levels are the same one: nothing is interpolated across a jump.
        rate = self._marched.grid.observe(rate)
        self.seen = self.seen.with_levels(
            [time, time], np.stack([rate, rate]), slip[None, : self._observed]
        )

    def count(self, time: float) -> bool:
        """Count a step to a time, which belongs to the next levels that are added, and tell of it.

        Return whether the march is to end there.
        """
        self.done += 1
        self.stopped = self._progress is not None and (
            self._progress(self.done, self._steps) is True
        )
        return self.stopped

    def add(
        self,
        times: Sequence[float],
        pressures: Sequence[Array],
        rates: Array,
        tractions: Array,
        slips: Array,
        paths: Array,
        works: Array,
    ) -> None:
        """Add the levels of the last k steps, which lie within one segment.

        Parameters
        ----------
        times : (k + 1,) sequence
            Times of the levels and of the one before them [time].
        pressures : k arrays of (contact,)
            Pressure of the contact at the levels [stress].
        rates : (k + 1, size) array
            Slip rates at `times`.
        tractions, slips, paths, works : (k + 1, contact) arrays
            Fields of `MarchState` at `times`.
        """
        rates, taken = self._marched.grid.observe(rates), len(times) - 1
        kept = np.zeros(taken, dtype=bool)
        # a segment ends where the record begins
        if times[-1] > self._marched.recorded_from:
            self.seen = self.seen.with_levels(times, rates, slips[1:, : self._observed])
            self._sum(times[1:], slips[1:], paths[1:], works[1:])
            reached = self._marched.statistics.steps + self.done
            kept = np.arange(reached - taken + 1, reached + 1) % self._every == 0
            kept[-1] |= self.done == self._steps
        kept[-1] |= self.stopped
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
        pressures: Sequence[Array] | Array,
    ) -> None:
        """Store levels."""
        part = slice(self._stored, self._stored + len(times))
        self._times[part] = times
        for kept, field in zip(self._fields, (slips, rates, tractions), strict=False):
            kept[part] = field[:, : self._observed]
        for row, pressure in zip(self._fields[-1][part], pressures, strict=True):
            row[:] = pressure[: self._observed]
        self._stored += len(times)

    def _sum(self, times: Sequence[float], slips: Array, paths: Array, works: Array) -> None:
        """Add the totals of levels: sums over nodes times h are integrals over the contact."""
        n, part = self._observed, slice(self._summed, self._summed + len(times))
        # Each node is the middle of a stretch h (x = (i + 1/2) h): the midpoint rule.
        totals = (
            times,
            np.abs(slips[:, :n]).max(axis=1),
            paths[:, :n].sum(axis=1) * self._spacing,
            works[:, :n].sum(axis=1) * self._spacing,
        )
        for kept, total in zip(self._totals, totals, strict=True):
            kept[part] = total
        self._summed += len(times)

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
