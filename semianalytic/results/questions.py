"""What is asked of a run at places and times between its nodes and frames, as of other answers."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import zip_longest
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from semianalytic.results.answer import FIELDS, OpenInterval, SlipInterval, checked_arrival
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.results.intervals import open_intervals, slip_intervals
from semianalytic.results.places import line_points, line_positions
from semianalytic.results.sampled import (
    NO_SLIP,
    between,
    check_times,
    onset_between,
    onsets,
    path_and_heat,
)
from semianalytic.scene.checks import checked_number, shown
from semianalytic.scene.errors import SceneError

Array = NDArray[np.float64]
Interval = TypeVar("Interval", SlipInterval, OpenInterval)


class Questions:
    """Questions to a `Run` about any place of the contact and any time until its end."""

    def history(self: Any, x: ArrayLike, t: ArrayLike) -> InterfaceHistory:
        """Return all fields at positions x (n,) of the contact and times t (m,), linear between.

        Raises
        ------
        SceneError
            If x or t is not finite, off the contact, or beyond the period or the end of the run.

        Examples
        --------
        >>> import semianalytic as sf
        >>> patch = sf.InterfaceLoad(lambda x: 1.0 * (abs(x) < 0.5))
        >>> line = sf.Interface(sf.Material(1.0, 1.0, 0.25), sf.Coulomb(0.5), 8.0, loads=[patch])
        >>> sf.solve(line, end_time=1.0, nodes=64).history([-0.3, 0.1], [0.5, 1.0]).slip.shape
        (2, 2)
        """
        x, t = (np.atleast_1d(np.asarray(one, dtype=float)) for one in (x, t))
        values = (_interpolated(self, getattr(self, name), x, t[:, None]) for name in FIELDS)
        return InterfaceHistory(x, t, *values)

    def path(self: Any, x: ArrayLike, t: ArrayLike) -> Array:
        """Return the accumulated |slip| [length], from the frames; errors are those of `history`.

        Positions and times broadcast.
        """
        return _interpolated(self, path_and_heat(self.slip, self.shear_traction)[0], x, t)

    def work_density(self: Any, x: ArrayLike, t: ArrayLike) -> Array:
        """Return the energy turned to heat at x until t, per area [stress length].

        It is that of the frames; errors are those of `history`.
        """
        return _interpolated(self, path_and_heat(self.slip, self.shear_traction)[1], x, t)

    def arrival(self: Any, x: ArrayLike, of: str = "slip") -> Array:
        """Return the first time at which the sides slip, or come apart, at x [time].

        "slip" is interpolated from `onset`, which is known at every step; "forward" and "reverse"
        begin where the rate of that sense passes 1 % of the largest one anywhere until then, and
        "opening" at the first frame with a gap.  It is inf where it has not come by the end.

        Raises
        ------
        SceneError
            If a position is not finite, off the contact or beyond the period, or there is no such
            arrival.
        """
        of, x = checked_arrival(of), line_positions(x)
        _check_places(self, x)
        onset = np.where(np.isnan(self.onset), np.inf, self.onset)
        known = onset if of == "slip" else onsets(self, of)
        place = np.abs(x) if self.interface.even else x
        return onset_between(self.x, place, np.where(self.touching, known, np.inf))

    def zones_at(self: Any, t: float) -> tuple[SlipInterval, ...]:
        """Return the parts of the contact that slip at a time, in the order of x.

        `slip_intervals` finds them on each part of the contact; open parts are not among them.

        Raises
        ------
        SceneError
            If the time is not a finite number or beyond the last.
        """
        least = NO_SLIP * float(np.abs(self.slip_rate[:, self.touching]).max(initial=0.0))
        gap, rate = (_frame(self, "zones_at", t, one) for one in (self.gap, self.slip_rate))
        rubbing = np.where(gap > 0, 0.0, rate)
        return tuple(_on_parts(self, rubbing, lambda x, rate: slip_intervals(x, rate, least)))

    def openings_at(self: Any, t: float) -> tuple[OpenInterval, ...]:
        """Return the open parts of the contact at a time, in the order of x, as `zones_at`."""
        gap = np.maximum(_frame(self, "openings_at", t, self.gap), 0.0)
        return tuple(_on_parts(self, gap, open_intervals))


def _check_places(run: Any, x: Array) -> None:
    """Raise SceneError for positions beyond the period or off the contact."""
    half = run.interface.length / 2
    beyond = x[np.abs(x) > half]
    if beyond.size:
        raise SceneError(
            f"this answer reaches to |x| = {half:.6g}, got {shown(float(beyond[0]))}; ask for "
            "nearer positions, or compute it with a greater `length`."
        )
    off = x[~run.interface.contact.touches(np.abs(x) if run.interface.even else x)]
    if off.size:
        raise SceneError(
            f"the bodies do not touch at x = {off[0]:.6g}; ask for positions of the contact, or "
            "read nodes of the slot."
        )


def _interpolated(run: Any, values: Array, x: ArrayLike, t: ArrayLike) -> Array:
    """Return a field of nodes and frames (m, n) at positions and times, which broadcast."""
    x, t = line_points(x, t)
    _check_places(run, x)
    check_times(t, run.t)
    places, which = np.unique(x, return_inverse=True)
    along, column = run.at(values, places), which.reshape(x.shape)
    earlier, later, on = between(run.t, t)
    return np.asarray((1 - on) * along[earlier, column] + on * along[later, column])


def _frame(run: Any, what: str, t: float, values: Array) -> Array:
    """Return a field at the nodes at one time (n,)."""
    time = np.asarray(checked_number(f"{what}: t", t))
    check_times(time, run.t)
    earlier, later, on = between(run.t, time)
    return np.asarray((1 - on) * values[earlier] + on * values[later])


def _on_parts(
    run: Any, values: Array, found: Callable[[Array, Array], tuple[Interval, ...]]
) -> Iterator[Interval]:
    """Yield the intervals that are found on each part of the contact from values at the nodes."""
    x, touching, half = run.x, run.touching, run.interface.length / 2
    if run.interface.even:
        own = np.flatnonzero(x > 0)[::-1]
        x, touching, values = (
            np.concatenate([image, nodes])
            for image, nodes in ((-x[own], x), (touching[own], touching), (values[own], values))
        )
    for begin, end in run.interface.contact.intervals:
        begin, end = max(begin, -half), min(end, half)
        on = touching & (begin < x) & (x < end)
        if on.sum() < 2:
            continue
        # distances from the begin of the part, which intervals from the first node on start at
        last = begin
        parts = found(x[on] - begin, values[on])
        for one, after in zip_longest(parts, parts[1:]):
            stop = min(begin + one.end, end) if math.isfinite(one.end) else end
            # ends on either side of a single node lie beyond it: the intervals share its place
            if after is not None and begin + after.start < stop:
                stop = (begin + after.start + stop) / 2
            yield replace(one, start=max(begin + one.start, last), end=stop)
            last = stop
