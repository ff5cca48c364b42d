"""Answers that were recorded at nodes and time levels, and interpolation between the samples.

A solver that steps through time keeps an `InterfaceHistory` of the levels it stored and the
`Totals` of every step; `SampledAnswer` makes an `Answer` of the two.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from semianalytic.results.answer import (
    OpenInterval,
    SlipInterval,
    checked_arrival,
)
from semianalytic.results.gridded import Gridded
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.results.intervals import (
    EDGE_STEPS,
    beside_openings,
    front_speeds,
    open_intervals,
    slip_intervals,
)
from semianalytic.results.places import contact_positions, finite_times
from semianalytic.results.reading import Reading, sampled_reading
from semianalytic.scene.checks import checked_number
from semianalytic.scene.errors import SceneError
from semianalytic.scene.quantities import asked_in_units
from semianalytic.scene.scene import Scene

Array = NDArray[np.float64]

ROUNDING = 1e-9
"""Relative amount by which a time or position may exceed the last one."""
ONSET_SHARE = 0.01
"""Share of the largest slip rate that is slip; a tenth would let it begin ahead of the waves."""
NO_SLIP = 1e-6
"""Fraction of the largest recorded slip rate that counts as none; it is exactly 0 in stick."""


@dataclass(frozen=True, eq=False)
class Totals:
    """Totals of the whole contact at every step, stored or not, as (m,) arrays.

    Attributes
    ----------
    t : (m,) array
        Times, increasing from 0, or before it as the record does [time].
    max_slip : (m,) array
        Largest |slip| at each time [length].
    accumulated_slip : (m,) array
        Integral over the contact of the accumulated |slip| [length^2].
    frictional_work : (m,) array
        Energy turned to heat per unit depth until each time [stress length^2].
    """

    t: Array
    max_slip: Array
    accumulated_slip: Array
    frictional_work: Array

    def at(self, name: str, t: ArrayLike) -> Array:
        """Return the total of a name at times t [time], linear between steps, 0 before t = 0.

        Raises
        ------
        SceneError
            If a time is not finite or beyond the last.
        """
        t = np.asarray(t, dtype=float)
        check_times(t, self.t)
        return np.asarray(np.interp(t, self.t, getattr(self, name), left=0.0))


@asked_in_units
class SampledAnswer(Gridded):
    """An `Answer` that interpolates between samples, linearly in position and time.

    Fields are known at the stored levels only, totals at every step.  Between the contact edge and
    the first node the fields are those of the first node, and likewise as far beyond the last one.

    Attributes
    ----------
    scene : Scene
        The scene that was computed.
    interface : InterfaceHistory
        Fields from t = 0 on, at x > 0.
    totals : Totals
        Totals of the recorded contact.
    """

    scene: Scene
    interface: InterfaceHistory
    totals: Totals

    def slip_rate(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Return the relative slip rate, upper minus lower side [length / time].

        Raises
        ------
        SceneError
            If x or t is not finite, not on the contact, or beyond what was recorded.
        """
        return self._field("slip_rate", x, t)

    def slip(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Return the relative slip since t = 0 [length]; errors are those of `slip_rate`."""
        return self._field("slip", x, t)

    def shear_traction(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Return the shear traction [stress], base included; errors are those of `slip_rate`."""
        return self._field("shear_traction", x, t, self.scene.base.shear)

    def pressure(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Return the contact pressure [stress], base included, positive in compression.

        Errors are those of `slip_rate`.
        """
        return self._field("pressure", x, t, self.scene.base.pressure)

    def gap(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Return the gap [length], 0 where closed; errors are those of `slip_rate`."""
        return self._field("gap", x, t)

    def path(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Return the accumulated |slip| [length], from the stored levels; errors as `slip_rate`."""
        return self._accumulated(0, x, t)

    def work_density(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Return the energy turned to heat at x until t, per area [stress length].

        It is that of the stored levels; errors are those of `slip_rate`.
        """
        return self._accumulated(1, x, t)

    @cached_property
    def _sums(self) -> tuple[InterfaceHistory, InterfaceHistory]:
        """Histories whose slip is the path, and the work, that the stored levels add up to."""
        seen = self.interface
        path, heat = path_and_heat(seen.slip, seen.shear_traction)
        return replace(seen, slip=np.abs(seen.slip[:1]) + path), replace(seen, slip=heat)

    def _accumulated(self, which: int, x: ArrayLike, t: ArrayLike) -> Array:
        check_times(np.asarray(t, dtype=float), self.interface.t)
        _check_positions(np.asarray(x, dtype=float), self.interface.x)
        x, t = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(t, dtype=float))
        return interpolated(self._sums[which], "slip", x, t)

    def front_speed(self, x: ArrayLike) -> Array:
        """Return the speed of the slip front as it comes to x [length / time].

        It is the inverse slope of the onsets of slip at 17 nodes (`front_speeds`): nan where slip
        does not come to all of them, or comes at once; errors are those of `arrival`.
        """
        x = np.asarray(x, dtype=float)
        _check_positions(x, self.interface.x)
        nodes, onset = self.interface.x, self._onset("slip")
        speeds = front_speeds(np.where(np.isfinite(onset), onset, np.nan), nodes[1] - nodes[0])
        found = onset_between(self.interface.x, x, np.where(np.isnan(speeds), np.inf, speeds))
        return np.where(np.isfinite(found), found, np.nan)

    def max_slip(self, t: ArrayLike) -> Array:
        """Return the largest |slip| on the recorded contact at times t [length].

        Raises
        ------
        SceneError
            If a time is not finite or beyond the last step.
        """
        return self.totals.at("max_slip", t)

    def accumulated_slip(self, t: ArrayLike) -> Array:
        """Return the integral over the contact of the |slip| accumulated until t [length^2].

        Errors are those of `max_slip`.
        """
        return self.totals.at("accumulated_slip", t)

    def frictional_work(self, t: ArrayLike) -> Array:
        """Return the energy turned to heat on the contact until t per unit depth [stress length^2].

        Errors are those of `max_slip`.
        """
        return self.totals.at("frictional_work", t)

    def arrival(self, x: ArrayLike, of: str = "slip") -> Array:
        """Return the first time at which the sides slip, or come apart, at x [time].

        Slip has begun where its rate passes 1 % of the largest one anywhere until then, and an
        opening at the first stored level with a gap.  Times are interpolated linearly between
        levels and nodes.

        Parameters
        ----------
        x : array
            Positions [length], positive, within what was recorded.
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
        x, onset = np.asarray(x, dtype=float), self._onset(checked_arrival(of))
        _check_positions(x, self.interface.x)
        return onset_between(self.interface.x, x, onset)

    def first_motion(self, x: ArrayLike, of: str = "slip") -> Array:
        """Return the first time at which anything moves at x [time]; parameters as `arrival`.

        A slip rate of a millionth of the largest one counts here, so that this is the time of the
        slowest precursor that the grid shows.
        """
        x = np.asarray(x, dtype=float)
        return onset_between(self.interface.x, x, self._onset(checked_arrival(of), NO_SLIP))

    def _onset(self, of: str, share: float = ONSET_SHARE) -> Array:
        """Return the times at which something begins at the nodes, from the stored levels (n,)."""
        return onsets(self.interface, of, share)

    def reading(self, x: ArrayLike, t: ArrayLike) -> Reading:
        """Return what happens at x until t, arrivals and fields, each with a bar of its error.

        A bar is 1.6 times the largest difference from the companion with half the nodes, within
        two of its nodes around the point and as far in time; arrivals have the time a shear wave
        takes between two of these nodes besides.  It is inf without a companion.  Read `status`
        too: bars do not hold where it says "unresolved".

        Parameters
        ----------
        x, t : arrays
            Positions [length] and times [time], which broadcast.

        Raises
        ------
        SceneError
            If x or t is not finite, not on the contact, or beyond what was recorded.
        """
        return sampled_reading(self, x, t)

    def zones_at(self, t: float) -> tuple[SlipInterval, ...]:
        """Return the parts that slip at a time, from the contact edge outward.

        `slip_intervals` finds them.  Between two stored levels these are the parts that slip at
        either; parts that are open at both are left out.

        Raises
        ------
        SceneError
            If the time is not a finite number or beyond the last.
        """
        t = checked_number("zones_at: t", t)
        if t <= min(self.interface.t[0], 0.0):
            return ()
        seen = self.interface
        least = NO_SLIP * float(np.abs(seen.slip_rate).max(initial=0.0))
        # Open sides move along one another without friction, which is no slip of the contact.
        rubbing = np.where(self.gap(seen.x, t) > 0, 0.0, self.slip_rate(seen.x, t))
        openings, near = self.openings_at(t), EDGE_STEPS * float(seen.x[0])
        return tuple(
            beside_openings(zone, openings, near) for zone in slip_intervals(seen.x, rubbing, least)
        )

    def openings_at(self, t: float) -> tuple[OpenInterval, ...]:
        """Return the open parts at a time, from the contact edge outward.

        `open_intervals` finds them.  Errors are those of `zones_at`.
        """
        t = checked_number("openings_at: t", t)
        if t <= min(self.interface.t[0], 0.0):
            return ()
        return open_intervals(self.interface.x, self.gap(self.interface.x, t))

    def _field(self, name: str, x: ArrayLike, t: ArrayLike, at_rest: float = 0.0) -> Array:
        x, t = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(t, dtype=float))
        _check_positions(x, self.interface.x)
        check_times(t, self.interface.t)
        # a record begins before t = 0 where a load comes along the slot no faster than its waves
        before = t < min(self.interface.t[0], 0.0)
        return np.asarray(np.where(before, at_rest, interpolated(self.interface, name, x, t)))


def path_and_heat(slip: Array, shear: Array) -> tuple[Array, Array]:
    """Return |slip| and work of friction that add up from level to level, (m, n) each."""
    steps, held = np.abs(np.diff(slip, axis=0)), np.abs(shear)
    none = np.zeros((1, slip.shape[1]))
    work = steps * (held[1:] + held[:-1]) / 2
    return np.cumsum(np.vstack([none, steps]), axis=0), np.cumsum(np.vstack([none, work]), axis=0)


class Sampled(Protocol):
    """Fields (m, n) at nodes x (n,) and times t (m,)."""

    @property
    def x(self) -> Array: ...
    @property
    def t(self) -> Array: ...
    @property
    def slip_rate(self) -> Array: ...
    @property
    def gap(self) -> Array: ...


def onsets(seen: Sampled, of: str, share: float = ONSET_SHARE) -> Array:
    """Return the times at which something begins at the nodes, from the stored levels (n,).

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
    threshold = np.maximum(share * largest, NO_SLIP * largest[-1])[:, None]
    begun = rate > threshold
    level = begun.argmax(axis=0)
    before, node = np.maximum(level - 1, 0), np.arange(len(seen.x))
    late, speed = rate[before, node], rate[level, node]
    # At the first level, or after a jump, there is no earlier value to interpolate from.
    rise = np.where(speed > late, speed - late, 1.0)
    along = np.clip((threshold[level, 0] - late) / rise, 0.0, 1.0)
    times = seen.t[before] + (seen.t[level] - seen.t[before]) * along
    return np.where(begun.any(axis=0), times, np.inf)


def onset_between(nodes: Array, x: Array, onset: Array) -> Array:
    """Interpolate onsets (n,) at nodes (n,), some of which may be inf, at positions x [time]."""
    left, right, along = between(nodes, x)
    # A node that never begins has inf, which a mean would pass on: the nearer node decides
    # then.
    nearest = np.where(along < 0.5, onset[left], onset[right])
    both = np.isfinite(onset[left]) & np.isfinite(onset[right])
    first, second = (np.where(both, onset[side], 0.0) for side in (left, right))
    return np.where(both, (1 - along) * first + along * second, nearest)


def interpolated(history: InterfaceHistory, name: str, x: Array, t: Array) -> Array:
    """Interpolate a field linearly between the samples of a history; beyond them take the nearest.

    Parameters
    ----------
    history : InterfaceHistory
        The samples.
    name : str
        Name of the field, such as "slip_rate".
    x, t : arrays of one shape
        Positions [length] and times [time].
    """
    (left, right, along), (earlier, later, on) = between(history.x, x), between(history.t, t)
    field = getattr(history, name)
    before = (1 - along) * field[earlier, left] + along * field[earlier, right]
    after = (1 - along) * field[later, left] + along * field[later, right]
    return np.asarray((1 - on) * before + on * after)


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


def _check_positions(x: Array, nodes: Array) -> None:
    """Raise SceneError for positions that are not finite, off the contact or beyond the nodes."""
    contact_positions(x)
    # Nodes are the middles of cells: the last cell ends as far beyond its node as the first begins
    # before its own.
    reach = nodes[-1] + nodes[0]
    if np.any(x > reach * (1 + ROUNDING)):
        raise SceneError(
            f"this answer reaches to x = {reach:.6g}; ask for nearer positions, or compute it on a "
            "greater length or to a later end time."
        )
