"""How the faces of a line move against each other: the record of a march, and its transform."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Single = NDArray[np.float32]

MOST_VALUES = 1 << 24
"""Largest number of mean rates that a record keeps; they take 4 bytes each."""
FALL = 1e-9
"""What exp(-eta t) falls to over the window of a transform."""


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


class MotionRecord:
    """Mean rates of every k-th step; k doubles when they are too many."""

    def __init__(self) -> None:
        self._every, self._count, self._t = 1, 0, [0.0]
        self._rows: list[tuple[Single, ...]] = []
        self._moved: list[Array] = []

    def add(self, times: Sequence[float], *rates: Array) -> None:
        """Add steps.

        Parameters
        ----------
        times : (k + 1,) sequence
            Times of the levels and of the one before them [time].
        *rates : (k + 1, n) arrays
            Slip rates at these, and opening rates if the line may open [length / time].
        """
        lengths = np.diff(times)[:, None] / 2
        moved = [lengths * (one[:-1] + one[1:]) for one in rates]
        for time, *steps in zip(times[1:], *moved, strict=True):
            if self._moved:
                steps = [a + b for a, b in zip(self._moved, steps, strict=True)]
            self._moved = steps
            self._count += 1
            if self._count % self._every == 0:
                self._join(time)
                if len(self._rows) * sum(map(len, steps)) > MOST_VALUES:
                    self._thin()

    def _join(self, time: float) -> None:
        """Note the mean rates of the steps since the last row."""
        length = time - self._t[-1]
        self._rows.append(tuple((one / length).astype(np.float32) for one in self._moved))
        self._t.append(time)
        self._moved = []

    def _thin(self) -> None:
        self._every *= 2
        rows, t, count = self._rows, np.array(self._t), len(self._rows) // 2
        shares = ((t[1::2] - t[:-1:2])[:count] / (t[2::2] - t[:-2:2])[:count]).astype(np.float32)
        self._rows = [
            tuple(share * a + (1 - share) * b for a, b in zip(one, other, strict=True))
            for share, one, other in zip(shares, rows[::2], rows[1::2], strict=False)
        ]
        self._t = t[: 2 * count + 1 : 2].tolist()
        if len(rows) % 2:  # the last row waits for the steps that will join it
            self._moved = [np.asarray(one * (t[-1] - t[-2]), dtype=float) for one in rows[-1]]

    def motion(self, time: float) -> Motion:
        """Return the record until a time, that of the last step [time]."""
        rows, t = list(self._rows), list(self._t)
        if self._moved:
            rows.append(tuple((one / (time - t[-1])).astype(np.float32) for one in self._moved))
            t.append(time)
        nothing = np.zeros((len(rows), 0), dtype=np.float32)
        slip, *opening = (np.array(one) for one in zip(*rows, strict=True)) if rows else [nothing]
        return Motion(np.array(t), slip, opening[0] if opening else nothing)

    def go_on(self, earlier: Motion, time: float, steps: int) -> None:
        """Continue the record of an earlier march from a time, until which it took `steps`."""
        count = int(np.searchsorted(earlier.t, time, side="right")) - 1
        whole = [one for one in (earlier.slip, earlier.opening) if one.size or one is earlier.slip]
        self._t = earlier.t[: count + 1].tolist()
        self._rows = [tuple(one[row] for one in whole) for row in range(count)]
        self._count, self._every = steps, 2 ** round(math.log2(max(steps / max(count, 1), 1)))
        if time > self._t[-1]:
            self._moved = [(time - self._t[-1]) * one[count].astype(float) for one in whole]


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

    @property
    def size(self) -> int:
        """Number of times after which the transform repeats itself."""
        from scipy.fft import next_fast_len  # here, for `import semianalytic` is to be quick

        return int(next_fast_len(math.ceil(1.5 * self.count), real=True))

    @property
    def fall(self) -> float:
        """The rate eta of the window exp(-eta t) [1 / time]."""
        return math.log(1 / FALL) / (self.size * self.step)

    @property
    def frequencies(self) -> Complex:
        """Frequencies s = eta + i omega, omega >= 0, (size // 2 + 1,) [1 / time]."""
        omega = 2 * np.pi / (self.size * self.step) * np.arange(self.size // 2 + 1)
        return np.asarray(self.fall + 1j * omega)

    def means(self, t: Array, rates: Single) -> Array:
        """Return mean rates (count, n) between these times, given those between others.

        What has moved until a time is interpolated by cubic polynomials through the times given.
        """
        lengths, at = np.diff(t)[:, None], self.start + self.step * np.arange(self.count + 1)
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
        return np.asarray(np.diff(found, axis=0) / self.step)

    def transformed(self, means: Array) -> tuple[Complex, Complex]:
        """Return the amplitudes (q, frequencies) of exp(s t + i q j) and exp(s t - i q j).

        `means` (count, n) are those at nodes j.
        """
        from scipy.fft import fft, rfft

        size, half = self.size, self.size // 2 + 1
        fading = self.count // 4
        beyond = np.arange(1, fading + 1)
        # a point reflection about the last value goes on smoothly, while the cosine fades it out
        fade = np.square(np.cos(np.pi / 2 * beyond / (fading + 1)))[:, None]
        after = fade * (2 * means[-1] - means[-1 - beyond])
        lines = np.zeros((size, means.shape[1] // 2 + 1), dtype=complex)
        lines[: self.count], lines[self.count : self.count + fading] = rfft(means), rfft(after)
        middles = self.step * (np.arange(size) + 0.5)
        lines *= (self.step / means.shape[1] * np.exp(-self.fall * middles))[:, None]
        every = fft(lines.T.copy(), axis=1, overwrite_x=True)
        s = self.frequencies
        # Rates between times stand at their middles, half a step later; a mean over a step is less
        # than the rate there by sinh(z) / z.
        z = s * self.step / 2
        factor = np.exp(-1j * z.imag) * z / np.sinh(z)
        # Sharp ends ring, and the window makes what rings before its cause a million times larger.
        factor *= np.exp(-36.0 * (s.imag / s.imag[-1]) ** 8)
        return every[:, :half] * factor, every[:, -np.arange(half)].conj() * factor
