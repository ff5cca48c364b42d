"""What is asked of a run along a line: places of either sign, on the parts of its contact."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import zip_longest
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from semianalytic.results.answer import FIELDS
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.results.places import line_points, line_positions
from semianalytic.results.questions import (
    ONSET_SHARE,
    Finder,
    Interval,
    Questions,
    between,
    check_times,
    onsets,
)
from semianalytic.scene.checks import shown
from semianalytic.scene.errors import SceneError

Array = NDArray[np.float64]


class LineAnswer(Questions):
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
        values = (self._between(getattr(self, name), x, t[:, None]) for name in FIELDS)
        return InterfaceHistory(x, t, *values)

    @property
    def _seen(self) -> Any:
        return self

    @property
    def _on(self: Any) -> NDArray[np.bool_]:
        return np.asarray(self.touching)

    def _onset(self: Any, of: str, share: float = ONSET_SHARE) -> Array:
        at_every_step = of == "slip" and share == ONSET_SHARE
        known = self.onset if at_every_step else onsets(self, of, share)
        return np.where(self.touching & ~np.isnan(known), known, np.inf)

    def _places(self: Any, x: ArrayLike) -> Array:
        """Return places along the nodes; raise SceneError beyond the period or off the contact."""
        x, half = line_positions(x), self.interface.length / 2
        beyond = x[np.abs(x) > half]
        if beyond.size:
            raise SceneError(
                f"this answer reaches to |x| = {half:.6g}, got {shown(float(beyond[0]))}; ask for "
                "nearer positions, or compute it with a greater `length`."
            )
        place = np.abs(x) if self.interface.even else x
        off = x[~self.interface.contact.touches(place)]
        if off.size:
            raise SceneError(
                f"the bodies do not touch at x = {off[0]:.6g}; ask for positions of the contact, "
                "or read nodes of the slot."
            )
        return place

    def _between(self: Any, values: Array, x: ArrayLike, t: ArrayLike) -> Array:
        x, t = line_points(x, t)
        self._places(x)
        check_times(t, self.t)
        places, which = np.unique(x, return_inverse=True)
        along, column = self.at(values, places), which.reshape(x.shape)
        earlier, later, on = between(self.t, t)
        return np.asarray((1 - on) * along[earlier, column] + on * along[later, column])

    def _frame(self: Any, values: Array, t: float) -> Array:
        time = np.asarray(t)
        check_times(time, self.t)
        earlier, later, on = between(self.t, time)
        return np.asarray((1 - on) * values[earlier] + on * values[later])

    def _on_parts(self: Any, values: Array, found: Finder[Interval]) -> tuple[Interval, ...]:
        x, touching, half = self.x, self.touching, self.interface.length / 2
        intervals = list[Interval]()
        if self.interface.even:
            own = np.flatnonzero(x > 0)[::-1]
            x, touching, values = (
                np.concatenate([image, nodes])
                for image, nodes in ((-x[own], x), (touching[own], touching), (values[own], values))
            )
        for begin, end in self.interface.contact.intervals:
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
                intervals.append(replace(one, start=max(begin + one.start, last), end=stop))
                last = stop
        return tuple(intervals)
