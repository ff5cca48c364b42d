"""The record of a march: fields at some of its time levels, and all that continues it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import fields
from typing import Any

import numpy as np

from semianalytic.engine.bodies.motion import MotionRecord
from semianalytic.engine.marched import Marched
from semianalytic.engine.nodes import MarchCheckpoint
from semianalytic.engine.stepping.advance import Part, Taken, taken_of
from semianalytic.engine.stepping.state import Extremes, State
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.results.sampled import Totals
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import SceneError


class MarchRecord:
    """Fields at every k-th level, thinned to a number of frames, or at given times.

    Parameters
    ----------
    line : Stepper or SlotLine
        The line that is marched, which knows the nodes and which of them touch.
    every : int
        k, which doubles each time the number of frames exceeds its limit.
    frames : float
        Largest number of frames.
    times : sequence of float, optional
        Times [time], in increasing order, at which fields are recorded instead.
    slipping : float, optional
        |slip rate| beyond which slip has begun at a node [length / time].
    first : float
        Time at which the record begins [time].
    steps : int
        Steps to come, for which there is room at once.
    """

    def __init__(
        self,
        line: Any,
        every: int,
        frames: float = math.inf,
        times: Sequence[float] | None = None,
        slipping: float | None = None,
        first: float = 0.0,
        steps: int = 64,
    ) -> None:
        self.every, self.frames, self.count, self.first = every, frames, 0, first
        self.times = None if times is None else list(times)
        self._line, self._grid, self._is_whole = line, line.nodes, bool(line.touching.all())
        self._names = [name for name in line.fields if name not in line.steady]
        self._rows, self._summed = _Rows(int(min(frames, steps // every)) + 3), _Rows(steps + 1)
        self._weights = self._grid.weights[line.touching]
        self._is_even = bool((self._weights == self._weights[0]).all())
        # a line drives the bodies by itself; beside a slot they need a longer one (`freed`)
        self.motion = MotionRecord() if line.layout is None else None
        self.seen, self._scratch = Extremes.none(len(self._grid.x), slipping), np.empty((2, 0, 0))

    def begin(self, now: State) -> None:
        """Record the state at which the record begins."""
        taken = taken_of([now] * 2)
        self._count(taken)
        if self.times is None or self.times[0] <= now.time:
            self._write(taken, slice(1, 2))
            self.times = self.times and [time for time in self.times if time > now.time]

    def add(self, taken: Taken) -> None:
        """Record steps: fields if they are due, and totals and extremes always."""
        times, steps = taken.times, len(taken.times) - 1
        if not steps:
            # both levels at a jump are the same one, so that nothing is interpolated across it
            rates = np.repeat(self._rates(taken), 2, axis=0)
            known = rates, np.abs(rates), self.seen.path
            self.seen = self.seen.with_levels([times[0]] * 2, *known)
            return
        if times[-1] <= self.first:
            self.count += steps
            if times[-1] == self.first:
                self.begin(taken.look(steps))
            return
        self._count(taken)
        if self.motion is not None:
            may_open = self._line.unilateral is not None
            opening = [taken.look(level).gap_rate for level in range(steps + 1) if may_open]
            self.motion.add(times, taken.rates, *([np.array(opening)] if opening else []))
        done = 0
        while self.times is None and done < steps:
            ahead = np.arange(1, steps - done + 1)
            due = done + ahead[(self.count + ahead) % self.every == 0]
            due = due[: int(min(self.frames + 1 - self._rows.count, steps))]
            if not len(due):
                break
            # all rows without the copy of an index, which would take as long as the storing
            self._write(taken, slice(1, None) if len(due) == steps else due)
            self.count, done = self.count + int(due[-1]) - done, int(due[-1])
            if self._rows.count > self.frames:
                self.every *= 2
                self._rows.thin()
        self.count += steps - done
        for level in range(1, steps + 1):
            while self.times and self.times[0] <= times[level] * (1 + 1e-12):
                self._write_between(taken, level, self.times.pop(0))

    def end(self, now: State) -> None:
        """Record the last state unless the last step recorded it."""
        if self.times is None and self._rows.arrays()[0][-1] != now.time:
            self._write(taken_of([now]), slice(None))

    def _rates(self, taken: Taken) -> Array:
        """Return slip rates at the nodes that are recorded, 0 on slots, (k + 1, n)."""
        rates = taken.rates[:, self._grid.shown]
        return rates if self._is_whole else np.where(self._line.touching, rates, 0.0)

    def _count(self, taken: Taken) -> None:
        """Note totals, extremes of slip rates, and when slip begins."""
        n, on = len(self._grid.x), slice(None) if self._is_whole else self._line.touching
        rates, slips = self._rates(taken), taken.slips[:, :n]
        if len(self._scratch[0]) < len(rates):  # arrays of this size are new pages each time
            self._scratch = np.empty((2, *rates.shape))
        speeds, moved = self._scratch[:, : len(rates)]
        speeds = np.abs(rates, out=speeds)
        # the rate is linear in time over a step; slip may turn back within one
        sizes = speeds if self._is_whole else np.abs(taken.rates)
        moved = np.add(sizes[1:], sizes[:-1], out=moved[1:])
        moved *= np.diff(taken.times)[:, None] / 2
        works, slips = taken.works[1:, : len(self._weights)], slips[1:, on]
        extremes = slips.max(axis=1, initial=0.0), 0.0 - slips.min(axis=1, initial=0.0)
        largest = np.maximum(*extremes)
        # one by one, so that sums do not depend on how steps come in blocks
        so_far = self._summed.arrays()[2][-1:].tolist() if self._summed.count else []
        paths = np.cumsum([*so_far, *self._over(moved[:, on])])[-len(moved) :]
        peaks = speeds[1:].max(axis=1, initial=0.0)
        self._summed.add(taken.times[1:], largest, paths, self._over(works), peaks)
        moved[0] += self.seen.path
        self.seen = self.seen.with_levels(taken.times, rates, speeds, moved.sum(axis=0))

    def _over(self, rows: Array) -> Array:
        """Return integrals of rows (k, contact) over the contact, (k,)."""
        if self._is_even:
            return np.asarray(rows.sum(axis=1) * self._weights[0])
        return np.asarray((rows * self._weights).sum(axis=1))

    @property
    def totals(self) -> Totals:
        """Totals of the contact at all steps."""
        return Totals(*self._summed.arrays())

    @property
    def interface(self) -> InterfaceHistory:
        """The fields that are recorded."""
        t, *rows = self._rows.arrays()
        known, shape = dict(zip(self._names, rows, strict=True)), (len(t), len(self._grid.x))
        known |= {name: np.broadcast_to(row, shape) for name, row in self._line.steady.items()}
        mask = self._line.touching if self._line.layout is None else None
        return InterfaceHistory(self._grid.x, t, mask=mask, **known)

    def _placed(self, taken: Taken, part: Part) -> list[Array]:
        """Return the fields that change at some levels, at the nodes that are recorded."""
        n, found = len(self._grid.x), list[Array]()
        for name in self._names:
            values = taken.show(name, part)
            if name == "slip_rate":
                values = values[:, self._grid.shown]
            elif name in ("state", "felt_pressure") and not self._is_whole:
                on, values = values, np.full((len(values), n), np.nan if name == "state" else 0.0)
                values[:, self._line.touching] = on
            found.append(values[:, :n])
        return found

    def _write(self, taken: Taken, part: Part) -> None:
        self._rows.add(np.asarray(taken.times)[part], *self._placed(taken, part))

    def _write_between(self, taken: Taken, level: int, time: float) -> None:
        """Record the fields at a time within a step, over which all but slip is linear."""
        begin, length = taken.times[level - 1], taken.times[level] - taken.times[level - 1]
        share = min((time - begin) / length, 1.0)
        both = self._placed(taken, np.array([level - 1, level]))
        pairs = dict(zip(self._names, both, strict=True))
        rows = {name: two[:1] + share * (two[1:] - two[:1]) for name, two in pairs.items()}
        gained = share * length * (pairs["slip_rate"][:1] + rows["slip_rate"]) / 2
        rows["slip"] = pairs["slip"][:1] + gained
        self._rows.add([time], *rows.values())

    def go_on(self, earlier: Marched) -> None:
        """Take up the record of an earlier march until where it goes on from."""
        kept = earlier.checkpoint
        since, known = kept.state.time, earlier.interface
        self.every, self.count, self.seen = max(self.every, kept.every), kept.count, kept.seen
        # but for levels that were recorded only because the earlier march ended there
        again = known.t > since
        again[-1] |= self.times is None and bool(kept.count % kept.every) and known.t[-1] == since
        if self.times is not None:
            beyond = [time for time in self.times if time > since]
            self.times = sorted({*known.t[again].tolist(), *beyond})
        rows = [known.t, *(getattr(known, name) for name in self._names)]
        self._rows.add(*(values[~again] for values in rows))
        totals = [getattr(earlier.totals, part.name) for part in fields(Totals)]
        self._summed.add(*(values[earlier.totals.t <= since] for values in totals))
        if self.motion is not None and earlier.motion is not None:
            self.motion.go_on(earlier.motion, since, self.count)


class _Rows:
    """Arrays of which rows are filled one after the other, with room for so many at once."""

    def __init__(self, room: int) -> None:
        self.count, self._room, self._arrays = 0, room, list[Array]()

    def add(self, *rows: Any) -> None:
        """Fill rows, of which each array has some."""
        begin, self.count = self.count, self.count + len(rows[0])
        if not self._arrays or self.count > len(self._arrays[0]):
            self._room = max(self._room, self.count) + (begin and max(self._room, self.count))
            earlier, self._arrays = self.arrays(), []
            for at, values in enumerate(rows):
                self._arrays.append(np.empty((self._room, *np.shape(values)[1:])))
                if begin:
                    self._arrays[at][:begin] = earlier[at][:begin]
        for array, values in zip(self._arrays, rows, strict=True):
            array[begin : self.count] = values

    def thin(self) -> None:
        """Drop every second row."""
        kept = [array[: self.count : 2].copy() for array in self._arrays]
        self.count = len(kept[0])
        for array, values in zip(self._arrays, kept, strict=True):
            array[: self.count] = values

    def arrays(self) -> list[Array]:
        """Return the rows that are filled."""
        return [array[: self.count] for array in self._arrays]


def checkpoint_at(line: Any, record: MarchRecord, now: State, latest: float) -> MarchCheckpoint:
    """Return what a march goes on from at a state until a latest time."""
    past, *opening = (memory.past() for memory in line.every_memory())
    return MarchCheckpoint(
        grid=line.nodes,
        state=now,
        end=now,
        past=past,
        opening=opening[0] if opening else None,
        every=record.every,
        count=record.count,
        seen=record.seen,
        latest=latest,
        layout=line.layout,
        settings=line.settings,
    )


def resumed(line: Any, record: MarchRecord, earlier: Marched) -> State:
    """Put the memory and the record of an earlier march in place and return its state."""
    kept = earlier.checkpoint
    now, times = kept.state, earlier.interface.t
    gone = [time for time in record.times or () if time <= now.time]
    lost = [time for time in gone if not np.isclose(time, times, rtol=1e-12, atol=0.0).any()]
    if lost:
        raise SceneError(
            f"march: the march that `go_on` continues has gone beyond t = {lost[0]:.6g} and not "
            "stored it; leave out such `times`, or compute it again."
        )
    pasts = kept.past, *([] if kept.opening is None else [kept.opening])
    for memory, past in zip(line.every_memory(), pasts, strict=True):
        memory.put_back(past)
    record.go_on(earlier)
    # a march that ended at a jump has the values before it
    return line.jump(now) if now.time in line.jumps and now.time == earlier.end_time else now
