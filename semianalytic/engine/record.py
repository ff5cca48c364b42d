"""The record of a run: fields at some of its time levels, and all that continues it."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from semianalytic.engine.bodies.motion import MotionRecord
from semianalytic.engine.marched import Marched
from semianalytic.engine.stepping.acting import times_of_loads
from semianalytic.engine.stepping.advance import levels_of
from semianalytic.engine.stepping.state import Extremes, LineCheckpoint, State
from semianalytic.engine.stepping.steps import Stepper
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.results.sampled import Totals
from semianalytic.scene.errors import DataFileError, SceneError

Array = NDArray[np.float64]

FIELDS = ("slip", "slip_rate", "shear_traction", "state", "pressure", "felt_pressure", "gap")


class RunRecord:
    """Fields at every k-th level, thinned to a number of frames, or at given times.

    Parameters
    ----------
    stepper : Stepper
        The stepper of the run, which knows the nodes and which of them touch.
    every : int
        k, which doubles each time the number of frames exceeds its limit.
    frames : int
        Largest number of frames.
    times : sequence of float, optional
        Times [time], in increasing order, at which fields are recorded instead.
    slipping : float
        |slip rate| beyond which slip has begun at a node [length / time].
    """

    def __init__(
        self,
        stepper: Stepper,
        every: int,
        frames: int,
        times: Sequence[float] | None = None,
        slipping: float = 0.0,
    ) -> None:
        self.every, self.frames, self.count = every, frames, 0
        self.times = None if times is None else list(times)
        self.t: list[float] = []
        self.fields: dict[str, list[Array]] = {name: [] for name in FIELDS}
        self._stepper, self._touching = stepper, stepper.touching
        self._may_open, self._weights = stepper.unilateral is not None, stepper.grid.weights
        self._summed: list[list[float]] = [[] for _ in range(5)]  # of each of the `Totals`
        self.motion = MotionRecord()
        self.seen = Extremes.none(len(stepper.grid.x), slipping)

    def begin(self, now: State) -> None:
        """Record the state at the beginning of the run."""
        self._count([now.time] * 2, *levels_of([now] * 2, self._stepper))
        if self.times is None:
            self._write(now.time, self._shown(now))
        else:
            while self.times and self.times[0] <= now.time:
                self._write(self.times.pop(0), self._shown(now))

    def add(
        self,
        times: Sequence[float],
        rates: Array,
        slips: Array,
        works: Array,
        look: Callable[[int], State],
    ) -> None:
        """Record steps: fields if they are due, and totals and extremes always.

        Parameters
        ----------
        times : (k + 1,) sequence
            Times of the levels and of the one before them [time].
        rates, slips : (k + 1, n) arrays
            Slip rates at these, and slip.
        works : (k + 1, contact) array
            Work of friction until these [stress length].
        look : function
            Returns the state at one of these levels, given by its place.
        """
        self._count(times, rates, slips, works)
        opening = [look(level).gap_rate for level in range(len(times)) if self._may_open]
        self.motion.add(times, rates, *([np.array(opening)] if opening else []))
        for level, time in enumerate(times[1:], 1):
            self.count += 1
            if self.times is None:
                if self.count % self.every == 0:
                    self._write(time, self._shown(look(level)))
                    if len(self.t) > self.frames:
                        self._thin()
                continue
            while self.times and self.times[0] <= time * (1 + 1e-12):
                at = self.times.pop(0)
                self._write(at, self._between(look(level - 1), look(level), at))

    def end(self, now: State) -> None:
        """Record the last state unless the last step recorded it."""
        if self.times is None and self.t[-1] != now.time:
            self._write(now.time, self._shown(now))

    def _count(self, times: Sequence[float], rates: Array, slips: Array, works: Array) -> None:
        """Note totals, extremes of slip rates, and when slip begins."""
        rates = np.where(self._touching, rates, 0.0)
        self.seen = self.seen.with_levels(times, rates)
        slips, weights = slips[:, self._touching], self._weights[self._touching]
        largest, moved = np.abs(slips[1:]).max(axis=1, initial=0.0), np.abs(np.diff(slips, axis=0))
        # one by one, so that sums do not depend on how steps come in blocks
        paths = np.cumsum([*self._summed[2][-1:], *(moved * weights).sum(axis=1)])
        work, peaks = (works[1:] * weights).sum(axis=1), np.abs(rates[1:]).max(axis=1, initial=0.0)
        rows = times[1:], largest, paths[-len(moved) :], work, peaks
        for values, more in zip(self._summed, rows, strict=True):
            values += np.asarray(more).tolist()

    @property
    def totals(self) -> Totals:
        """Totals of the contact at all steps."""
        return Totals(*map(np.array, self._summed))

    @property
    def interface(self) -> InterfaceHistory:
        """The fields that are recorded."""
        known = {name: np.array(values) for name, values in self.fields.items()}
        return InterfaceHistory(
            self._stepper.grid.x, np.array(self.t), mask=self._touching, **known
        )

    def sum_from(self, earlier: Totals, time: float) -> None:
        """Continue the totals of an earlier march from a time."""
        steps = int((earlier.t <= time).sum())
        self._summed = [vars(earlier)[known.name][:steps].tolist() for known in fields(Totals)]

    def _write(self, time: float, shown: Sequence[Array]) -> None:
        self.t.append(time)
        for name, value in zip(FIELDS, shown, strict=True):
            self.fields[name].append(value)

    def _thin(self) -> None:
        self.every *= 2
        self.t = self.t[::2]
        for name in FIELDS:
            self.fields[name] = self.fields[name][::2]

    def _shown(self, now: State) -> tuple[Array, ...]:
        state = np.full(len(now.rate), np.nan)
        state[self._touching] = now.state
        felt = np.zeros(len(now.rate))
        felt[self._touching] = now.felt
        return now.slip, now.rate, now.traction, state, now.pressure, felt, now.gap

    def _between(self, before: State, now: State, time: float) -> tuple[Array, ...]:
        """Return the fields at a time within a step, over which all but slip is linear."""
        length = now.time - before.time
        share = min((time - before.time) / length, 1.0)
        pairs = zip(self._shown(before), self._shown(now), strict=True)
        shown = [value + share * (other - value) for value, other in pairs]
        shown[0] = before.slip + share * length * (before.rate + shown[1]) / 2
        return tuple(shown)


def checkpoint_at(stepper: Stepper, record: RunRecord, now: State, latest: float) -> LineCheckpoint:
    """Return what a march goes on from at a state until a latest time, but for `fingerprint`."""
    opening = None if stepper.unilateral is None else stepper.unilateral.memory.past()
    return LineCheckpoint(
        state=now,
        end=now,
        past=stepper.memory.past(),
        opening=opening,
        horizon=stepper.memory.horizon,
        fingerprint="",
        every=record.every,
        count=record.count,
        seen=record.seen,
        latest=latest,
    )


def fingerprint(stepper: Stepper, latest: float) -> str:
    """Return a digest of everything on the grid that a run depends on until a time [time]."""
    scene = stepper.scene
    parts: list[Any] = [scene.material, stepper.grid, scene.plate_rate]
    parts.append(scene.contact.intervals)  # ends within a cell have the same nodes
    if stepper.pair is not None:
        parts.append(stepper.pair)
    parts += [scene.mode, type(stepper.law).__name__, stepper.shortest, stepper.sweeps]
    values: list[Any] = []
    if is_dataclass(stepper.law):
        values = [getattr(stepper.law, field.name) for field in fields(stepper.law)]
    parts += [value for value in values if isinstance(value, str | bool)]
    digest = hashlib.sha256(repr(parts).encode())
    laid: list[Any] = [
        stepper.pressure,
        stepper.shear,
        stepper.touching,
        *stepper.loads(stepper.shortest),
    ]
    for load in stepper.acting:
        laid += [
            load.traction(stepper.grid.x, float(time), of=of)
            for of in ("shear", "pressure")
            for time in times_of_loads(latest)
        ]
    if stepper.unilateral is not None:
        laid += stepper.unilateral.loads(stepper.shortest)
        if stepper.unilateral.adhesion is not None:
            laid += [stepper.unilateral.adhesion.strength, stepper.unilateral.adhesion.length]
    laid += [value for value in values if isinstance(value, float | int | np.ndarray)]
    for value in laid:
        digest.update(np.ascontiguousarray(value).tobytes())
    return digest.hexdigest()


def resumed(stepper: Stepper, record: RunRecord, earlier: Marched, end_time: float) -> State:
    """Put the memory and the record of an earlier run in place and return its state."""
    kept = earlier.checkpoint
    assert isinstance(kept, LineCheckpoint)
    assert earlier.motion is not None
    if kept.fingerprint != fingerprint(stepper, kept.latest):
        raise DataFileError(
            "run: `go_on` is a run of another interface, grid or step; continue it with its own "
            "interface, `nodes` and `step_ratio`."
        )
    if kept.end.time >= end_time:
        raise SceneError(f"run: `end_time` must be beyond that of `go_on`, {kept.end.time:.6g}.")
    if record.seen.slipping != kept.seen.slipping:
        raise SceneError(
            f"run: slip began beyond {kept.seen.slipping:.6g} in the run that `go_on` "
            "continues; leave out `slipping`, or give the same."
        )
    since = kept.state.time
    gone = [time for time in record.times or () if time <= since]
    times = earlier.interface.t
    lost = [time for time in gone if not np.isclose(time, times, rtol=1e-12, atol=0.0).any()]
    if lost:
        raise SceneError(
            f"run: the run that `go_on` continues has gone beyond t = {lost[0]:.6g} and not "
            "stored it; leave out such `times`, or compute it again."
        )
    if kept.horizon != stepper.memory.horizon:
        raise SceneError(
            f"run: the memory of `go_on` reaches t = {kept.latest:g}; compute it again with "
            f"`latest` = {end_time:g} to continue it until then."
        )
    stepper.memory.put_back(kept.past)
    if stepper.unilateral is not None and kept.opening is not None:
        stepper.unilateral.memory.put_back(kept.opening)
    record.every, record.count = kept.every, kept.count
    record.t = list(earlier.interface.t)
    for name in FIELDS:
        record.fields[name] = list(getattr(earlier.interface, name))
    cut = record.times is None and record.count % record.every and record.t[-1] == since
    again = list[float]()
    while cut or record.t[-1] > since:
        # Frames of a step that is taken anew, or recorded only because the earlier run ended there.
        cut = False
        again.append(record.t.pop())
        for name in FIELDS:
            record.fields[name].pop()
    if record.times is not None:
        record.times = sorted({*again, *(time for time in record.times if time > since)})
    record.sum_from(earlier.totals, since)
    record.seen = kept.seen
    record.motion.go_on(earlier.motion, since, record.count)
    return kept.state
