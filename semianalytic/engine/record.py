"""The record of a run: fields at some of its time levels, and a few numbers of every step."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from semianalytic.engine.steps import State, Stepper

Array = NDArray[np.float64]

FIELDS = ("slip", "slip_rate", "shear_traction", "state")


class Record:
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
    """

    def __init__(
        self, stepper: Stepper, every: int, frames: int, times: Sequence[float] | None = None
    ) -> None:
        self.every, self.frames, self.count = every, frames, 0
        self.times = None if times is None else list(times)
        self.t: list[float] = []
        self.fields: dict[str, list[Array]] = {name: [] for name in FIELDS}
        self.step_times: list[float] = []
        self.peak_rates: list[float] = []
        self._touching = stepper.touching

    def begin(self, now: State) -> None:
        """Record the state at the beginning of the run."""
        self._peak(now)
        if self.times is None:
            self._write(now.time, self._shown(now))
        else:
            while self.times and self.times[0] <= now.time:
                self._write(self.times.pop(0), self._shown(now))

    def add(self, before: State, now: State) -> None:
        """Record a step: fields if they are due, and its time and largest slip rate always."""
        self.count += 1
        self._peak(now)
        if self.times is None:
            if self.count % self.every == 0:
                self._write(now.time, self._shown(now))
                if len(self.t) > self.frames:
                    self._thin()
            return
        while self.times and self.times[0] <= now.time * (1 + 1e-12):
            time = self.times.pop(0)
            self._write(time, self._between(before, now, time))

    def end(self, now: State) -> None:
        """Record the last state unless the last step recorded it."""
        if self.times is None and self.t[-1] != now.time:
            self._write(now.time, self._shown(now))

    def _peak(self, now: State) -> None:
        self.step_times.append(now.time)
        on = now.rate[self._touching]
        self.peak_rates.append(float(np.abs(on).max()) if len(on) else 0.0)

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
        return now.slip, now.rate, now.traction, state

    def _between(self, before: State, now: State, time: float) -> tuple[Array, ...]:
        """Return the fields at a time within a step, over which the rate is linear."""
        length = now.time - before.time
        share = min((time - before.time) / length, 1.0)
        (_, v0, f0, s0), (_, v1, f1, s1) = self._shown(before), self._shown(now)
        rate = v0 + share * (v1 - v0)
        slip = before.slip + share * length * (v0 + rate) / 2
        return slip, rate, f0 + share * (f1 - f0), s0 + share * (s1 - s0)
