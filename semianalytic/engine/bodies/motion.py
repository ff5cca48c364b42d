"""How the faces of a line move against each other: the record of a march, and its transform."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from semianalytic.scene.arrays import Array, Complex

Single = NDArray[np.float32]

MOST_VALUES = 1 << 24
"""Largest number of mean rates that a record keeps; they take 4 bytes each."""
QUIET = 5e-3
"""Change of rates, over the largest rate, up to which they are static."""
ECHOES = 20
"""Times of a shear wave along the line until waves of an event have died out, as in memories."""
FALL = 1e-9
"""Value of exp(-eta t) at the end of the window of a transform."""
TOGETHER = 32
"""Times that are transformed, and nodes that are interpolated, at once: they stay in the cache."""


@dataclass(frozen=True, eq=False)
class Motion:
    """Mean rates of slip and opening at the nodes of a line between times.

    Their products with the times between are the slip and opening that have come, whichever steps
    were joined; rates at single times would miss jumps of loads.

    Attributes
    ----------
    t : (m + 1,) array
        Times [time].
    slip : (m, n) array of single precision
        Mean slip rate from one time to the next [length / time].
    opening : (m, n) array of single precision
        Mean opening rate; (m, 0) where nothing opens.
    """

    t: Array
    slip: Single
    opening: Single

    def divided(
        self, begin: float, end: float, most: float, across: float
    ) -> tuple[Motion, Motion] | None:
        """Return what moves until a time at which all is static, and what moves beyond that.

        It is the last such time before `begin`, at most `most` before `end`; None if there is none.
        Static is what changed by at most `QUIET` each time a wave crossed the line in the time
        `across`, until the waves of an event have died out [time].
        """
        t, slip = self.t, self.slip
        last = min(int(np.searchsorted(t, end)) + 10, len(t) - 1)  # the last levels fade
        first = max(int(np.searchsorted(t, t[last] - most)), 1)
        largest = QUIET * float(np.abs(slip[first - 1 : last]).max(initial=0.0))
        for row in range(int(np.searchsorted(t, begin, side="right")) - 1, first - 1, -1):
            before = np.searchsorted(t, t[row] - across * np.arange(ECHOES + 1), side="right") - 1
            rows = [row, *np.unique(np.maximum(before[1:], 0))[::-1].tolist()]
            changes = (
                float(np.abs(slip[early:late] - slip[late]).max())
                * min(1.0, across / (t[late] - t[early]))
                for late, early in pairwise(rows)
            )
            if max(changes) <= largest:
                later = (field[row:last] - field[row - 1] for field in (slip, self.opening))
                earlier = Motion(t[: row + 1], slip[:row], self.opening[:row])
                return earlier, Motion(t[row : last + 1], *later)
        return None


class MotionRecord:
    """Mean rates of all steps, which are joined where they are too many."""

    def __init__(self, begin: float = 0.0) -> None:
        self._every, self._t = 1, [begin]
        self._steps = list[int]()  # of each row
        self._rows = list[list[Single]]()  # of slip, and of opening if there is any, in parts

    def add(self, times: Sequence[float], *rates: Array) -> None:
        """Add steps.

        Parameters
        ----------
        times : (k + 1,) sequence
            Times of the levels and of the one before them [time].
        *rates : (k + 1, n) arrays
            Slip rates at these, and opening rates if the line may open [length / time].
        """
        self._rows = self._rows or [[] for _ in rates]
        for rows, rate in zip(self._rows, rates, strict=True):
            rows.append(((rate[:-1] + rate[1:]) * 0.5).astype(np.float32))
        self._t += times[1:]
        self._steps += [1] * (len(times) - 1)
        width = sum(columns.shape[1] for columns in rates)
        if len(self._steps) * width > MOST_VALUES:
            if sum(self._steps) / self._every * width > MOST_VALUES / 2:
                self._every *= 2
            self._join()

    def _join(self) -> None:
        """Join rows, so that each has the mean rates of so many steps."""
        ends, t = np.cumsum(self._steps), np.array(self._t)
        _, starts = np.unique((ends - 1) // self._every, return_index=True)
        lengths = np.diff(t).astype(np.float32)[:, None]
        whole = np.add.reduceat(lengths, starts)
        for rows in self._rows:
            moved = np.add.reduceat(np.concatenate(rows) * lengths, starts)
            rows[:] = [np.asarray(moved / whole, np.float32)]
        self._t = [*t[starts].tolist(), self._t[-1]]
        self._steps = np.add.reduceat(self._steps, starts).tolist()

    def motion(self) -> Motion:
        """Return the record until the last step."""
        if not self._steps:
            return Motion(np.array(self._t), *[np.zeros((0, 0), np.float32)] * 2)
        if self._every > 1:
            self._join()
        slip, *opening = (np.concatenate(rows) for rows in self._rows)
        nothing = np.zeros((len(slip), 0), np.float32)
        return Motion(np.array(self._t), slip, opening[0] if opening else nothing)

    def go_on(self, earlier: Motion, time: float, steps: int) -> None:
        """Continue the record of an earlier march from a time, until which it took `steps`."""
        ends = np.minimum(earlier.t[1:], time)
        count = int((earlier.t[:-1] < time).sum())
        self._t = [*earlier.t[:1].tolist(), *ends[:count].tolist()]
        kept = [values for values in (earlier.slip, earlier.opening) if values.shape[1]]
        self._rows = [[values[:count]] for values in kept]
        self._every = 2 ** round(math.log2(max(steps / max(count, 1), 1)))
        self._steps = [self._every] * count
        if count:
            self._steps[-1] = max(steps - self._every * (count - 1), 1)


@dataclass(frozen=True, eq=False)
class Levels:
    """Evenly spaced times of a transform, and the window that lets it end.

    Attributes
    ----------
    start, step : float
        First time and spacing [time].
    count : int
        Number of intervals.
    """

    start: float
    step: float
    count: int

    @cached_property
    def size(self) -> int:
        """Number of times after which the transform repeats itself."""
        from scipy.fft import next_fast_len  # here, for `import semianalytic` is to be quick

        return int(next_fast_len(max(3 * self.count // 2, self.count + 2 * self.fading), real=True))

    @property
    def fading(self) -> int:
        """Number of times on which rates fade out: many, for some belong to the last level."""
        return max(self.count // 4, 40)

    @property
    def fall(self) -> float:
        """The rate eta of the window exp(-eta t) [1 / time]."""
        return math.log(1 / FALL) / (self.size * self.step)

    @cached_property
    def frequencies(self) -> Complex:
        """Frequencies s = eta + i omega, omega >= 0, (size // 2 + 1,) [1 / time]."""
        omega = 2 * np.pi / (self.size * self.step) * np.arange(self.size // 2 + 1)
        return np.asarray(self.fall + 1j * omega)

    def means(self, t: Array, rates: Any) -> Array:
        """Return mean rates (count, n) between these times, given those between others.

        The motion until a time is interpolated by cubic polynomials through the times given.
        """
        at: Array = np.asarray(self.start + self.step * np.arange(self.count + 1))
        # where steps are even, levels are those of the march
        most = min(len(at), len(t))
        apart = np.abs(at[:most] - t[:most]) > 1e-9 * self.step
        alike = (int(np.argmax(apart)) if apart.any() else most) - 1
        before = max(alike - 2, 0)
        if alike >= self.count:
            return np.asarray(rates[: self.count])
        found = np.empty((self.count, rates.shape[1]))
        found[:alike] = rates[:alike]
        for start in range(0, rates.shape[1], TOGETHER):
            some = slice(start, start + TOGETHER)
            here = _resampled(t[before:], rates[before:, some], at[alike:])
            found[alike:, some] = here / self.step
        return found

    def lines(self, means: Array) -> Complex:
        """Return transforms along x of mean rates (count, n), (n // 2, count)."""
        from scipy.fft import rfft

        lines = np.empty((means.shape[1] // 2, self.count), dtype=complex)
        for start in range(0, self.count, TOGETHER):
            rows = slice(start, start + TOGETHER)
            lines[:, rows] = rfft(means[rows].astype(float))[:, : len(lines)].T
        return lines

    @cached_property
    def _falls(self) -> Array:
        """Falls of the means until they have faded, (count + fading,)."""
        middles = self.step * (np.arange(self.count + self.fading) + 0.5)
        return np.asarray(self.step * np.exp(-self.fall * middles))

    @cached_property
    def _factor(self) -> Complex:
        """Factors that turn transforms of mean rates into those of rates, tapered."""
        s = self.frequencies
        # Rates between times stand at their middles, half a step later; a mean over a step is less
        # than the rate there by sinh(z) / z.
        z = s * self.step / 2
        # Sharp ends ring, and the window makes what rings before its cause a million times larger.
        taper = np.exp(-36.0 * (s.imag / s.imag[-1]) ** 8)
        return np.asarray(np.exp(-1j * z.imag) * z / np.sinh(z) * taper)

    def transformed(self, lines: Array) -> Complex:
        """Return the amplitudes of exp(s t) of mean rates (q, count), fallen and faded."""
        from scipy.fft import rfft

        count, beyond = self.count, np.arange(1, self.fading + 1)
        # a point reflection about the last value goes on smoothly, while the cosine fades it out
        fade = np.square(np.cos(np.pi / 2 * beyond / (self.fading + 1)))
        after = fade * (2 * lines[:, -1:] - lines[:, np.maximum(count - 1 - beyond, 0)])
        fallen = np.zeros((len(lines), self.size))
        np.multiply(lines, self._falls[:count], out=fallen[:, :count])
        np.multiply(after, self._falls[count:], out=fallen[:, count : count + self.fading])
        return np.asarray(rfft(fallen) * self._factor)


def _resampled(t: Array, rates: Any, at: Array) -> Array:
    """Return what moves between times `at` (k,), (k - 1, n), given mean rates between times t.

    The motion until a time is interpolated by cubic polynomials, and goes on beyond the last.
    """
    lengths = np.diff(t)[:, None]
    beyond, at = np.maximum(at - t[-1], 0.0)[:, None], np.minimum(at, t[-1])
    moved = np.zeros((len(t), rates.shape[1]))
    np.cumsum(lengths * rates, axis=0, out=moved[1:])
    slopes = np.empty_like(moved)
    slopes[1:-1] = (lengths[1:] * rates[:-1] + lengths[:-1] * rates[1:]) / (
        lengths[1:] + lengths[:-1]
    )
    slopes[0], slopes[-1] = rates[0], rates[-1]
    row = np.clip(np.searchsorted(t, at, side="right") - 1, 0, len(t) - 2)
    share = ((at - t[row]) / lengths[row, 0])[:, None]
    bend = share * (1 - share) * lengths[row]
    found = moved[row] + share * lengths[row] * rates[row]
    found += bend * (1 - share) * (slopes[row] - rates[row])
    found -= bend * share * (slopes[row + 1] - rates[row])
    found += beyond * rates[-1]
    return np.asarray(np.diff(found, axis=0))
