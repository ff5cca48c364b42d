"""Questions to answers that were recorded, about places and times between the samples."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from semianalytic.results.answer import OpenInterval, SlipInterval, checked_arrival
from semianalytic.results.intervals import (
    EDGE_STEPS,
    beside_openings,
    finite_times,
    front_speeds,
    open_intervals,
    slip_intervals,
)
from semianalytic.scene.arguments import asked_in_units
from semianalytic.scene.checks import checked_number
from semianalytic.scene.errors import SceneError

Array = NDArray[np.float64]
Interval = TypeVar("Interval", SlipInterval, OpenInterval)
Finder = Callable[[Array, Array], tuple[Interval, ...]]
"""Function that finds intervals of x (n,) from values (n,) at these places."""

ROUNDING = 1e-9
"""Relative amount by which a time or position may exceed the last one."""
ONSET_SHARE = 0.01
"""Share of the largest slip rate that is slip; a tenth would let it begin ahead of the waves."""
NO_SLIP = 1e-6
"""Fraction of the largest recorded slip rate that counts as none; it is exactly 0 in stick."""


@asked_in_units
class Questions:
    """Questions to recorded fields, about any place of the contact and any time until the end.

    A class that inherits from this one says in `_seen` which fields (m, n) it has at nodes x (n,)
    and times t (m,), and in `totals` what the whole contact did; `_field` gives a field at places
    and times, `_onset` the times at which something begins at the nodes, `_places`
    checks positions and says where along the nodes they are, `_between` interpolates a field,
    `_frame` gives it at the nodes at one time, and `_on_parts` finds intervals along the contact.
    """

    def slip_rate(self: Any, x: ArrayLike, t: ArrayLike) -> Array:
        """Return the relative slip rate, upper minus lower side [length / time].

        Raises
        ------
        SceneError
            If x or t is not finite, not on the contact, or beyond what was recorded.
        """
        return np.asarray(self._field("slip_rate", x, t))

    def slip(self: Any, x: ArrayLike, t: ArrayLike) -> Array:
        """Return the relative slip since t = 0 [length]; errors are those of `slip_rate`."""
        return np.asarray(self._field("slip", x, t))

    def shear_traction(self: Any, x: ArrayLike, t: ArrayLike) -> Array:
        """Return the shear traction [stress], base included; errors are those of `slip_rate`."""
        return np.asarray(self._field("shear_traction", x, t))

    def pressure(self: Any, x: ArrayLike, t: ArrayLike) -> Array:
        """Return the contact pressure [stress], base included, positive in compression.

        Errors are those of `slip_rate`.
        """
        return np.asarray(self._field("pressure", x, t))

    def gap(self: Any, x: ArrayLike, t: ArrayLike) -> Array:
        """Return the gap [length], 0 where closed; errors are those of `slip_rate`."""
        return np.asarray(self._field("gap", x, t))

    def path(self: Any, x: ArrayLike, t: ArrayLike) -> Array:
        """Return the accumulated |slip| [length], from the stored levels.

        Positions and times broadcast.

        Raises
        ------
        SceneError
            If x or t is not finite, not on the contact, or beyond what was recorded.
        """
        return np.asarray(self._between(self._sums[0], x, t))

    def work_density(self: Any, x: ArrayLike, t: ArrayLike) -> Array:
        """Return the energy turned to heat at x until t, per area [stress length].

        It is that of the stored levels; errors are those of `path`.
        """
        return np.asarray(self._between(self._sums[1], x, t))

    @cached_property
    def _sums(self: Any) -> tuple[Array, Array]:
        """Path and work of friction that the stored levels add up to, (m, n)."""
        return added_up(self._seen)

    def arrival(self: Any, x: ArrayLike, of: str = "slip") -> Array:
        """Return the first time at which the sides slip, or come apart, at x [time].

        Slip has begun where its rate passes 1 % of the largest one anywhere until then, or the
        `slipping` of a `Run`, and an opening at the first stored level with a gap.  Times are
        interpolated linearly between levels and nodes.

        Parameters
        ----------
        x : array
            Positions [length] on the contact, within what was recorded.
        of : str
            "slip" of either sense, "forward" or "reverse" for slip towards +x or -x alone, or
            "opening".  Slip includes the motion of open parts.

        Returns
        -------
        array
            Times of the shape of x; inf where it has not come by the end.

        Raises
        ------
        SceneError
            If a position is not finite, off the contact or beyond the nodes, or there is no such
            arrival.
        """
        onset = self._onset(checked_arrival(of))
        return onset_between(self._seen.x, self._places(x), onset)

    def first_motion(self: Any, x: ArrayLike, of: str = "slip") -> Array:
        """Return the first time at which anything moves at x [time]; parameters as `arrival`.

        A slip rate of a millionth of the largest one counts here, so that this is the time of the
        slowest precursor that the grid shows.
        """
        onset = self._onset(checked_arrival(of), NO_SLIP)
        return onset_between(self._seen.x, self._places(x), onset)

    def front_speed(self: Any, x: ArrayLike) -> Array:
        """Return the speed of the slip front as it comes to x [length / time].

        It is the inverse slope of the onsets of slip at 17 nodes (`front_speeds`): nan where slip
        does not come to all of them, or comes at once; errors are those of `arrival`.
        """
        nodes, onset = self._seen.x, self._onset("slip")
        speeds = front_speeds(np.where(np.isfinite(onset), onset, np.nan), nodes[1] - nodes[0])
        found = onset_between(nodes, self._places(x), np.where(np.isnan(speeds), np.inf, speeds))
        return np.where(np.isfinite(found), found, np.nan)

    def max_slip(self: Any, t: ArrayLike) -> Array:
        """Return the largest |slip| on the recorded contact at times t [length].

        Raises
        ------
        SceneError
            If a time is not finite or beyond the last step.
        """
        return np.asarray(self.totals.at("max_slip", t))

    def accumulated_slip(self: Any, t: ArrayLike) -> Array:
        """Return the integral over the contact of the |slip| accumulated until t [length^2].

        Errors are those of `max_slip`.
        """
        return np.asarray(self.totals.at("accumulated_slip", t))

    def frictional_work(self: Any, t: ArrayLike) -> Array:
        """Return the energy turned to heat on the contact until t per unit depth [stress length^2].

        Errors are those of `max_slip`.
        """
        return np.asarray(self.totals.at("frictional_work", t))

    def zones_at(self: Any, t: float) -> tuple[SlipInterval, ...]:
        """Return the parts of the contact that slip at a time, in the order of x.

        `slip_intervals` finds them.  Between two stored levels these are the parts that slip at
        either; parts that are open at both are left out.

        Raises
        ------
        SceneError
            If the time is not a finite number or beyond the last.
        """
        t, seen = checked_number("zones_at: t", t), self._seen
        least = NO_SLIP * float(np.abs(seen.slip_rate[:, self._on]).max(initial=0.0))
        gap, rate = (self._frame(values, t) for values in (seen.gap, seen.slip_rate))
        # Open sides move along one another without friction, which is no slip of the contact.
        rubbing = np.where(gap > 0, 0.0, rate)
        zones = self._on_parts(rubbing, lambda x, values: slip_intervals(x, values, least))
        openings, near = self.openings_at(t), EDGE_STEPS * float(np.abs(seen.x).min())
        return tuple(beside_openings(zone, openings, near) for zone in zones)

    def openings_at(self: Any, t: float) -> tuple[OpenInterval, ...]:
        """Return the open parts of the contact at a time, in the order of x.

        `open_intervals` finds them.  Errors are those of `zones_at`.
        """
        gap = self._frame(self._seen.gap, checked_number("openings_at: t", t))
        return tuple(self._on_parts(gap, open_intervals))


def added_up(seen: Any) -> tuple[Array, Array]:
    """Return |slip| and work of friction that add up from one level to the next, (m, n) each."""
    slip, shear = seen.slip, np.abs(seen.shear_traction)
    steps, none = np.abs(np.diff(slip, axis=0)), np.zeros((1, slip.shape[1]))
    work = np.vstack([none, steps * (shear[1:] + shear[:-1]) / 2])
    path = np.abs(slip[:1]) + np.cumsum(np.vstack([none, steps]), axis=0)
    return path, np.cumsum(work, axis=0)


def onsets(seen: Any, of: str, share: float = ONSET_SHARE) -> Array:
    """Return the times at which something begins at the nodes, (n,), from fields at x and t (m, n).

    A share of the largest slip rate so far counts as slip.
    """
    if of == "opening":
        opened = seen.gap > 0
        return np.where(opened.any(axis=0), seen.t[opened.argmax(axis=0)], np.inf)
    # The wanted sense counts positive; the other one must not pass for slip.
    rate = {"forward": 1.0, "reverse": -1.0}.get(of, 0.0) * seen.slip_rate
    rate = np.maximum(rate, 0.0) if of != "slip" else np.abs(seen.slip_rate)
    # Measured by what was until then, so that later and larger slip does not delay an onset.
    largest = np.maximum.accumulate(np.abs(seen.slip_rate).max(axis=1, initial=0.0))
    # rounding moves nodes of elements before any slip, when nothing larger was there
    threshold = np.maximum(share * largest, NO_SLIP * largest[-1])
    # at the first level there is no earlier value to interpolate from
    t, speeds = (np.concatenate([values[:1], values]) for values in (seen.t, rate))
    return onsets_until(np.full(len(seen.x), np.inf), t, speeds, threshold)


def onsets_until(
    onset: Array, times: Sequence[float] | Array, speeds: Array, threshold: Array
) -> Array:
    """Return the times at which slip has begun at the nodes, (n,), with k more levels.

    Parameters
    ----------
    onset : (n,) array
        Times known so far [time]; not finite where slip has not begun.
    times : (k + 1,) sequence
        Times of the levels and of the one before them [time]; a jump is two levels at one time.
    speeds : (k + 1, n) array
        |slip rate| at these [length / time], linear between them.
    threshold : (k,) array
        |slip rate| beyond which slip has begun, at each of the k levels [length / time].
    """
    # most nodes slip already, or not yet: the few others are looked at level by level
    waiting = ~np.isfinite(onset)
    waiting = np.flatnonzero(waiting & (speeds[1:].max(axis=0) > threshold.min()))
    if not len(waiting):
        return onset
    begins = speeds[1:, waiting] > threshold[:, None]
    first = np.argmax(begins, axis=0)
    began = np.flatnonzero(begins[first, np.arange(len(waiting))])
    if not len(began):
        return onset
    level, node, t = first[began], waiting[began], np.asarray(times)
    old, new = speeds[level, node], speeds[level + 1, node]
    rises = new > old
    share = np.where(rises, (threshold[level] - old) / np.where(rises, new - old, 1.0), 0.0)
    onset = onset.copy()
    onset[node] = t[level] + (t[level + 1] - t[level]) * np.clip(share, 0.0, 1.0)
    return onset


def onset_between(nodes: Array, x: Array, onset: Array) -> Array:
    """Interpolate onsets (n,) at nodes (n,), some of which may be inf, at positions x [time]."""
    left, right, along = between(nodes, x)
    # A node that never begins has inf, which a mean would pass on: the nearer node decides
    # then.
    nearest = np.where(along < 0.5, onset[left], onset[right])
    both = np.isfinite(onset[left]) & np.isfinite(onset[right])
    first, second = (np.where(both, onset[side], 0.0) for side in (left, right))
    return np.where(both, (1 - along) * first + along * second, nearest)


def between(samples: Array, at: Array) -> tuple[NDArray[np.intp], NDArray[np.intp], Array]:
    """Return the samples on either side, and the fraction of the way from one to the other."""
    after = np.clip(np.searchsorted(samples, at, "right"), 0, len(samples) - 1)
    before = np.maximum(after - 1, 0)
    width = samples[after] - samples[before]
    share = (at - samples[before]) / np.where(width > 0, width, 1.0)
    return before, after, np.clip(share, 0.0, 1.0)


def check_times(t: Array, recorded: Array) -> None:
    """Raise SceneError for times that are not finite or later than what was recorded."""
    if np.any(finite_times(t) > recorded[-1] * (1 + ROUNDING)):
        raise SceneError(
            f"this answer ends at t = {recorded[-1]:.6g}; ask for earlier times, or compute it to "
            "a later end time."
        )
