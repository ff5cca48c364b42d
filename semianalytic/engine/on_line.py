"""Questions to a run along a line: places of either sign, on the parts of its contact."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cached_property
from itertools import zip_longest
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from semianalytic.engine.beside_edges import EdgeNodes
from semianalytic.engine.bodies.marched_bodies import MarchedAnswer
from semianalytic.results.intervals import line_points, line_positions
from semianalytic.results.questions import (
    ONSET_SHARE,
    Finder,
    Interval,
    Questions,
    added_up,
    between,
    check_times,
    onsets,
    onsets_until,
)
from semianalytic.results.reading import Measured, Reading, sampled_reading
from semianalytic.results.sampled import Totals
from semianalytic.scene.arguments import asked_in_units
from semianalytic.scene.checks import shown
from semianalytic.scene.errors import SceneError

Array = NDArray[np.float64]

MOST_OFF = 0.1
"""Largest error of the work of stored levels, over that of all steps, with which they add up."""
LEAST_SLIP = 1e-3
"""Slip over the largest one from which a node counts as one that has slipped."""


@asked_in_units
class LineAnswer(Questions, MarchedAnswer):
    """Questions to a `Run` about any place of the contact and any time until its end."""

    method = "space-time"
    interface: Any

    @cached_property
    def totals(self: Any) -> Totals:
        """Totals of the contact at the stored times; raises as `path` does."""
        weights = self._weights[self._on]
        path, work = (sums[:, self._on] @ weights for sums in self._sums)
        return Totals(self.interface.t, self._largest, path, work)

    @property
    def _largest(self: Any) -> Array:
        """Largest |slip| of the contact at the stored times, (m,)."""
        return np.asarray(np.abs(self.interface.slip[:, self._on]).max(axis=1, initial=0.0))

    def max_slip(self: Any, t: ArrayLike) -> Array:
        """Return the largest |slip| on the contact at times t [length]; errors as for `slip`."""
        t = np.asarray(t, dtype=float)
        check_times(t, self.interface.t)
        return np.asarray(np.interp(t, self.interface.t, self._largest))

    @cached_property
    def _sums(self: Any) -> tuple[Array, Array]:
        """Sums from one stored level to the next; refused if their work is not that of all steps.

        Frames at a few `times` may have passed over most of the slip and its return.
        """
        path, work = added_up(self.interface)
        exact, t, weights = self.work["friction"], self.interface.t, self._weights[self._on]
        off = abs(float(work[-1, self._on] @ weights) - exact)
        # slip of rounding errors does the work of none
        stress = np.abs(self.interface.shear_traction[:, self._on]).max(initial=0.0)
        none = 1e-9 * stress**2 * self.end_time / self.scene.impedance * weights.sum()
        if t[0] > 0 or t[-1] < self.end_time or off > MOST_OFF * exact + none:
            raise SceneError(
                "path, work_density: the stored times are too few to add up path and work; leave "
                "out `times`, or lower `every`. The attribute `work` has the work of all steps."
            )
        return path, work

    @property
    def error_estimate(self: Any) -> float:
        """Estimated relative error of the slip rate; nan without a run on half the nodes."""
        return float(self.error_estimates.get("slip_rate", np.nan))

    def reading(self: Any, x: ArrayLike, t: ArrayLike) -> Reading:
        """Return what happens at x until t, arrivals and fields, each with a bar of its error.

        A bar is 1.6 times the largest difference from the companion with half the nodes, within
        two of its nodes around the point and as far in time, and at least its mean over the contact
        that has slipped; openings that no node shows are added.  It is inf without a companion.

        Parameters
        ----------
        x, t : arrays
            Positions [length] and times [time], which broadcast.

        Raises
        ------
        SceneError
            If x or t is not finite, not on the contact, or beyond what was recorded.
        """
        found = sampled_reading(self, x, t)
        if self.scene.may_open:
            return found
        # without a load that changes the pressure it is that of the base
        values = found.pressure.value, found.gap.value
        pressure, gap = (Measured(value, np.zeros(value.shape)) for value in values)
        return replace(found, pressure=pressure, gap=gap)

    def _known_around(self: Any, x: Array, step: float) -> tuple[Array, Array]:
        """Return between which places the part of the contact lies on which x is."""
        half = self.scene.period / 2
        begins, ends = np.clip(np.transpose(self.scene.contact.intervals), -half, half)
        part = np.searchsorted(begins, x, side="right") - 1
        return np.minimum(x, begins[part] + step / 8), np.maximum(x, ends[part] - step / 8)

    @cached_property
    def _hidden(self: Any) -> float:
        """Part of what drives slip that openings which no node shows take off."""
        return EdgeNodes(self).missed_opening[1]

    @property
    def _moved(self: Any) -> Array:
        """Nodes of the companion where the contact has slipped: bars do not depend on how much of
        the line has not."""
        known = self.companion.interface
        slip = np.where(known.touching, np.abs(known.slip).max(axis=0), 0.0)
        return np.asarray(known.x[slip > LEAST_SLIP * slip.max(initial=0.0)])

    @property
    def _seen(self) -> Any:
        return self.interface

    @property
    def _on(self: Any) -> NDArray[np.bool_]:
        return np.asarray(self.interface.touching)

    def _onset(self: Any, of: str, share: float = ONSET_SHARE) -> Array:
        known = self.onset
        if of == "opening" or share != ONSET_SHARE:
            known = onsets(self.interface, of, share)
        elif of != "slip":
            never, t = np.full(len(known), np.inf), self.interface.t
            rate, least = self.interface.slip_rate, np.full(len(t), self.checkpoint.slipping)
            times, rates = np.append(t[:1], t), np.vstack([rate[:1], rate])
            signs = (1, -1) if of == "forward" else (-1, 1)
            mine, other = (onsets_until(never, times, sign * rates, least) for sign in signs)
            # the first of both senses is known at every step
            known = np.where((mine <= other) & np.isfinite(mine), known, mine)
        return np.where(self._on & ~np.isnan(known), known, np.inf)

    def _places(self: Any, x: ArrayLike) -> Array:
        """Return places along the nodes; raise SceneError beyond the period or off the contact."""
        x, half = line_positions(x), self.scene.period / 2
        beyond = x[np.abs(x) > half]
        if beyond.size:
            raise SceneError(
                f"this answer reaches to |x| = {half:.6g}, got {shown(float(beyond[0]))}; ask for "
                "nearer positions, or compute it with a greater `period`."
            )
        place = np.abs(x) if self.scene.even else x
        off = x[~self.scene.contact.touches(place)]
        if off.size:
            raise SceneError(
                f"the bodies do not touch at x = {off[0]:.6g}; ask for positions of the contact, "
                "or read nodes of the slot."
            )
        return place

    def _field(self: Any, name: str, x: ArrayLike, t: ArrayLike) -> Array:
        return np.asarray(self._between(getattr(self.interface, name), x, t))

    def _between(self: Any, values: Array, x: ArrayLike, t: ArrayLike) -> Array:
        x, t = line_points(x, t)
        self._places(x)
        check_times(t, self.interface.t)
        places, which = np.unique(x, return_inverse=True)
        along, column = self.at(values, places), which.reshape(x.shape)
        earlier, later, on = between(self.interface.t, t)
        return np.asarray((1 - on) * along[earlier, column] + on * along[later, column])

    def _frame(self: Any, values: Array, t: float) -> Array:
        time = np.asarray(t)
        check_times(time, self.interface.t)
        earlier, later, on = between(self.interface.t, time)
        return np.asarray((1 - on) * values[earlier] + on * values[later])

    def _on_parts(self: Any, values: Array, found: Finder[Interval]) -> tuple[Interval, ...]:
        x, touching, half = self.interface.x, self._on, self.scene.period / 2
        intervals = list[Interval]()
        if self.scene.even:
            own = np.flatnonzero(x > 0)[::-1]
            x, touching, values = (
                np.concatenate([image, nodes])
                for image, nodes in ((-x[own], x), (touching[own], touching), (values[own], values))
            )
        for begin, end in self.scene.contact.intervals:
            begin, end = max(begin, -half), min(end, half)
            on = touching & (begin < x) & (x < end)
            if on.sum() < 2:
                continue
            # distances from the begin of the part, which intervals from the first node on start at
            last = begin
            parts = found(x[on] - begin, values[on])
            for part, after in zip_longest(parts, parts[1:]):
                stop = min(begin + part.end, end) if math.isfinite(part.end) else end
                # ends on either side of a single node lie beyond it: the intervals share its place
                if after is not None and begin + after.start < stop:
                    stop = (begin + after.start + stop) / 2
                intervals.append(replace(part, start=max(begin + part.start, last), end=stop))
                last = stop
        return tuple(intervals)
