"""Loads that are given by samples, interpolated linearly; and the names of histories in files."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.scene.arrays import Array
from semianalytic.scene.checks import LARGEST, checked_number, finite, shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.loads import Harmonic, LoadHistory, Pieces, Pulse, Ramp, Step
from semianalytic.scene.plugins import HISTORIES, kind_of
from semianalytic.scene.quantities import with_quantities


def _samples(given: Iterable[float]) -> Array:
    """Return the samples of a table (n,); raise SceneError unless all are finite numbers."""
    try:
        listed = list(given)
    except Exception as error:  # of any kind: the value may be of a class of another package
        raise SceneError("tabulated: times and values must be lists of numbers.") from error
    numbers = [finite(value) for value in listed]
    if None in numbers:
        value = listed[numbers.index(None)]
        raise SceneError(
            f"tabulated: times and values must be lists of numbers, all finite, got {shown(value)}."
        )
    samples = np.array(numbers, dtype=float)
    if np.any(np.abs(samples) > LARGEST):
        raise SceneError(f"tabulated: times and values must not exceed {LARGEST:g}.")
    return samples


@with_quantities
@dataclass(frozen=True)
class Tabulated(LoadHistory):
    """A load that is interpolated linearly between samples.

    It is 0 before the first sample and constant after the last.

    Parameters
    ----------
    t : sequence of float
        Increasing times >= 0 [time]; a time given twice is a jump.
    value_at_t : sequence of float
        Values at these times; a first value other than 0 is a jump at t[0].

    Raises
    ------
    SceneError
        If the samples are not finite numbers, not of one length, or not in order.

    Examples
    --------
    >>> from semianalytic import Tabulated
    >>> Tabulated(t=(0.0, 1.0, 2.0), value_at_t=(0.0, 1.0, 0.5)).value([0.5, 1.5, 9.0]).tolist()
    [0.5, 0.75, 0.5]
    """

    t: tuple[float, ...]
    value_at_t: tuple[float, ...]

    def __post_init__(self) -> None:
        times, values = _samples(self.t), _samples(self.value_at_t)
        if times.shape != values.shape or not len(times):
            raise SceneError("tabulated: give as many values as times, and at least one.")
        if times[0] < 0 or np.any(np.diff(times) < 0):
            raise SceneError("tabulated: times must start at 0 or later and not decrease.")
        if np.any((times[2:] == times[1:-1]) & (times[1:-1] == times[:-2])):
            raise SceneError(
                "tabulated: a time may be given twice, for a jump, but not more often."
            )
        with np.errstate(over="ignore"):
            steepest = np.divide(*(np.diff(part)[np.diff(times) > 0] for part in (values, times)))
        if np.any(np.abs(steepest) > LARGEST):
            raise SceneError(
                f"tabulated: values rise faster than {LARGEST:g} per time; "
                "give the same time twice for a jump."
            )
        object.__setattr__(self, "t", tuple(times.tolist()))
        object.__setattr__(self, "value_at_t", tuple(values.tolist()))

    def __repr__(self) -> str:
        if len(self.t) <= 4:
            return f"Tabulated(t={self.t}, value_at_t={self.value_at_t})"
        return f"Tabulated({len(self.t)} samples, t = {self.t[0]:.4g} ... {self.t[-1]:.4g})"

    @cached_property
    def pieces(self) -> Pieces:
        """The jumps where a time is given twice, and the kinks at the other samples."""
        times, values = np.array(self.t), np.array(self.value_at_t)
        width, rise = np.diff(times), np.diff(values)
        sloped = width > 0
        slopes = np.where(sloped, rise / np.where(sloped, width, 1.0), 0.0)
        jumps = [(times[0], values[0]), *zip(times[:-1][~sloped], rise[~sloped], strict=True)]
        kinks = [
            *zip(times[:-1][sloped], slopes[sloped], strict=True),
            *zip(times[1:][sloped], -slopes[sloped], strict=True),
        ]
        return Pieces(
            tuple((float(s), float(j)) for s, j in jumps if j),
            tuple((float(s), float(k)) for s, k in kinks if k),
        )

    def value(self, t: ArrayLike) -> Array:
        """Return f(t), any shape; at a jump the value before it."""
        # looked up, since a sum over the samples would take much longer
        t = np.asarray(t, dtype=float)
        times, values = np.array(self.t), np.array(self.value_at_t)
        after = np.searchsorted(times, t, "left")
        left, right = np.maximum(after - 1, 0), np.minimum(after, len(times) - 1)
        width = times[right] - times[left]
        share = np.where(width > 0, (t - times[left]) / np.where(width > 0, width, 1.0), 0.0)
        inside = values[left] + share * (values[right] - values[left])
        return np.where(t <= times[0], 0.0, inside)

    def integral(self, t: ArrayLike) -> Array:
        """Return the integral of f from 0 to t [time], any shape."""
        t = np.asarray(t, dtype=float)
        times, values = np.array(self.t), np.array(self.value_at_t)
        # areas up to each sample, by trapezoids
        areas = np.concatenate([[0.0], np.cumsum(np.diff(times) * (values[1:] + values[:-1]) / 2)])
        left = np.maximum(np.searchsorted(times, t, "left") - 1, 0)
        lag = np.maximum(t - times[left], 0.0)
        # beyond the last sample f stays what it was; before the first it is 0
        here = np.where(t > times[-1], values[-1], self.value(t))
        return areas[left] + lag * (values[left] + here) / 2

    def turn(self, width: float, until: float) -> float:
        """Return the largest turn around a sample or a midpoint; see `LoadHistory.turn`.

        Windows of the given width are placed around each of them in several ways.
        """
        width = checked_number("turn: width", width, "be 0 or more", lambda given: given >= 0)
        times, values = np.array(self.t), np.array(self.value_at_t)
        seen = times < until
        times = np.concatenate([times[:1], times[seen], [until]])
        values = np.concatenate([[0.0], values[seen], np.atleast_1d(self.value(until))])
        times = np.insert(times, slice(1, None), (times[1:] + times[:-1]) / 2)
        values = np.insert(values, slice(1, None), (values[1:] + values[:-1]) / 2)
        largest = float(np.abs(values).max())
        if len(times) < 3 or not largest:
            return 0.0
        highest = 0.0
        for sign in (1, -1):
            least = _Least(times, sign * values)
            # a turn is how far the sample stands above the least value before it, and after it
            for before in width * np.linspace(0, 1, 9):
                lower = np.maximum(least(-before, 0.0), least(0.0, width - before))
                highest = max(highest, float((sign * values - lower).max()))
        return highest / largest


class _Least:
    """Find the least value of a piecewise linear function in windows around its own samples."""

    def __init__(self, times: Array, values: Array) -> None:
        self._times, self._values = times, values
        # rows[k][i] is the least of the 2^k values from i on
        self._rows = [values]
        while (reach := 1 << (len(self._rows) - 1)) * 2 <= len(values):
            last = self._rows[-1]
            self._rows.append(np.minimum(last[:-reach], last[reach:]))

    def __call__(self, start: float, end: float) -> Array:
        """Return the least value over start <= t - times <= end, with start <= 0 <= end, (n,).

        If a window ends at the time of its sample, and another sample has the same time, only the
        sample itself and those on the side of the window count.
        """
        times, values = self._times, self._values
        own = np.arange(len(times))
        first = np.searchsorted(times, times + start, "left") if start else own
        stop = np.searchsorted(times, times + end, "right") if end else own + 1
        power = np.frexp(stop - first)[1] - 1
        least = np.empty(len(times))
        for k, row in enumerate(self._rows):
            at = power == k
            least[at] = np.minimum(row[first[at]], row[stop[at] - (1 << k)])
        for lag in (start, end):
            if lag:
                least = np.minimum(least, np.interp(times + lag, times, values))
        return least


HISTORY_KINDS: Mapping[str, type[LoadHistory]] = {
    "step": Step,
    "ramp": Ramp,
    "pulse": Pulse,
    "harmonic": Harmonic,
    "tabulated": Tabulated,
}
HISTORY_FIELDS = ("pressure_history", "shear_history")
"""Fields of a scene that are histories."""


def history_kind(history: LoadHistory) -> str | None:
    """Return the kind of a history in files; None if no installed package brings its class."""
    return kind_of(HISTORIES, LoadHistory, HISTORY_KINDS, type(history))
