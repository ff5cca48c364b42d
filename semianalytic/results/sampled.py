"""Answers that were recorded at nodes and time levels, and interpolation between the samples.

A solver that steps through time keeps an `InterfaceHistory` of the levels it stored and the
`Totals` of its steps; `SampledAnswer` makes an `Answer` of the two.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import zip_longest
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.results.answer import Arrival, OpenInterval, SlipInterval
from semianalytic.results.gridded import Gridded
from semianalytic.results.interface_history import InterfaceHistory, between
from semianalytic.results.intervals import (
    EDGE_STEPS,
    beside_openings,
    contact_positions,
    front_speeds,
    line_positions,
    open_intervals,
    slip_intervals,
)
from semianalytic.results.questions import (
    NO_SLIP,
    ONSET_SHARE,
    ROUNDING,
    Finder,
    Interval,
    added_up,
    check_times,
    onset_between,
    onsets,
)
from semianalytic.results.reading import Measured, Reading, sampled_reading
from semianalytic.scene.arguments import asked_in_units
from semianalytic.scene.arrays import Array
from semianalytic.scene.checks import checked_number, shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.scene import Scene

LEAST_SLIP = 1e-3
"""Slip over the largest one from which a node counts as one that has slipped."""


@dataclass(frozen=True, eq=False)
class Totals:
    """Totals of the whole contact at every step, stored or not, as (m,) arrays.

    Times t increase from 0 or before; max_slip [length], accumulated_slip [length^2], and
    frictional_work [stress length^2] are until each time, peak_rate, the largest |slip rate|
    [length / time], is that then, and empty where it was not recorded.
    """

    t: Array
    max_slip: Array
    accumulated_slip: Array
    frictional_work: Array
    peak_rate: Array = field(default_factory=lambda: np.zeros(0))

    def at(self, name: str, t: ArrayLike) -> Array:
        """Return the total of a name at times t [time], linear between steps, 0 before t = 0.

        Raises SceneError if a time is not finite or beyond the last.
        """
        t = np.asarray(t, dtype=float)
        check_times(t, self.t)
        return np.asarray(np.interp(t, self.t, getattr(self, name), left=0.0))


@asked_in_units
class SampledAnswer(Gridded):
    """An `Answer` that interpolates between samples, linearly in position and time.

    Fields are known at the stored levels only.  Between the end of a contact and the next node
    the fields are those of that node.

    Attributes
    ----------
    scene : Scene
        The scene that was computed.
    interface : InterfaceHistory
        Fields at the nodes and stored levels.
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
        return np.asarray(self._field("slip_rate", x, t))

    def slip(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Return the relative slip since t = 0 [length]; errors are those of `slip_rate`."""
        return np.asarray(self._field("slip", x, t))

    def shear_traction(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Return the shear traction [stress], base included; errors are those of `slip_rate`."""
        return np.asarray(self._field("shear_traction", x, t))

    def pressure(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Return the contact pressure [stress], base included, positive in compression.

        Errors are those of `slip_rate`.
        """
        return np.asarray(self._field("pressure", x, t))

    def gap(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Return the gap [length], 0 where closed; errors are those of `slip_rate`."""
        return np.asarray(self._field("gap", x, t))

    def path(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Return the accumulated |slip| [length], from the stored levels.

        Positions and times broadcast; errors are those of `slip_rate`.
        """
        return np.asarray(self._between(self._sums[0], x, t))

    def work_density(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Return the energy turned to heat at x until t, per area [stress length].

        It is that of the stored levels; errors are those of `path`.
        """
        return np.asarray(self._between(self._sums[1], x, t))

    @cached_property
    def _sums(self) -> tuple[Array, Array]:
        """Path and work of friction that the stored levels add up to, (m, n)."""
        return added_up(self.interface)

    def arrival(self, x: ArrayLike, of: Arrival = "slip") -> Array:
        """Return the first time at which the sides slip, or come apart, at x [time].

        Slip has begun where its rate passes 1 % of the largest one anywhere until then, or, along a
        line, `seen.slipping`, and an opening at the first stored level with a gap.  Times are
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
        onset = self._onset(of)
        return onset_between(self.interface.x, self._places(x), onset)

    def first_motion(self, x: ArrayLike, of: Arrival = "slip") -> Array:
        """Return the first time at which anything moves at x [time]; parameters as `arrival`.

        A slip rate of a millionth of the largest one counts here, so that this is the time of the
        slowest precursor that the grid shows.
        """
        onset = self._onset(of, NO_SLIP)
        return onset_between(self.interface.x, self._places(x), onset)

    def front_speed(self, x: ArrayLike) -> Array:
        """Return the speed of the slip front where it passes x [length / time].

        It is the inverse slope of the onsets of slip at 17 nodes (`front_speeds`): nan where slip
        does not begin at all of them, or begins at once; errors are those of `arrival`.
        """
        nodes, onset = self.interface.x, self._onset("slip")
        speeds = front_speeds(np.where(np.isfinite(onset), onset, np.nan), nodes[1] - nodes[0])
        found = onset_between(nodes, self._places(x), np.where(np.isnan(speeds), np.inf, speeds))
        return np.where(np.isfinite(found), found, np.nan)

    def max_slip(self, t: ArrayLike) -> Array:
        """Return the largest |slip| on the recorded contact at times t [length].

        Raises
        ------
        SceneError
            If a time is not finite or beyond the last step.
        """
        return np.asarray(self.totals.at("max_slip", t))

    def accumulated_slip(self, t: ArrayLike) -> Array:
        """Return the integral over the contact of the |slip| accumulated until t [length^2].

        Errors are those of `max_slip`.
        """
        return np.asarray(self.totals.at("accumulated_slip", t))

    def frictional_work(self, t: ArrayLike) -> Array:
        """Return the energy turned to heat on the contact until t per unit depth [stress length^2].

        Errors are those of `max_slip`.
        """
        return np.asarray(self.totals.at("frictional_work", t))

    def zones_at(self, t: float) -> tuple[SlipInterval, ...]:
        """Return the parts of the contact that slip at a time, in the order of x.

        `slip_intervals` finds them.  Between two stored levels these are the parts that slip at
        either; parts that are open at both are left out.

        Raises
        ------
        SceneError
            If the time is not a finite number or beyond the last.
        """
        t, seen = checked_number("zones_at: t", t), self.interface
        least = NO_SLIP * float(np.abs(seen.slip_rate[:, seen.touching]).max(initial=0.0))
        gap, rate = (self._frame(values, t) for values in (seen.gap, seen.slip_rate))
        # Open sides move along one another without friction, which is no slip of the contact.
        rubbing = np.where(gap > 0, 0.0, rate)
        zones = self._on_parts(rubbing, lambda x, values: slip_intervals(x, values, least))
        openings, near = self.openings_at(t), EDGE_STEPS * float(np.abs(seen.x).min())
        return tuple(beside_openings(zone, openings, near) for zone in zones)

    def openings_at(self, t: float) -> tuple[OpenInterval, ...]:
        """Return the open parts of the contact at a time, in the order of x.

        `open_intervals` finds them.  Errors are those of `zones_at`.
        """
        gap = self._frame(self.interface.gap, checked_number("openings_at: t", t))
        return tuple(self._on_parts(gap, open_intervals))

    def reading(self, x: ArrayLike, t: ArrayLike) -> Reading:
        """Return arrivals and fields at x until t, each with its error bar.

        A bar is 1.6 times the largest difference from the companion with half the nodes, within
        two of its nodes around the point and as far in time, and at least its mean over the
        contact, on a line over that part which has slipped; openings that no node shows are added.
        For arrivals the time a shear wave takes between two of these nodes is added.  It is inf
        without a companion.  Read `status` too: bars are not valid if it says "unresolved".

        Parameters
        ----------
        x, t : arrays
            Positions [length] and times [time], which broadcast; errors are those of `slip_rate`.
        """
        found = sampled_reading(self, x, t)
        if not self.scene.on_line or self.scene.may_open:
            return found
        # without a load that changes the pressure it is that of the base
        values = found.pressure.value, found.gap.value
        pressure, gap = (Measured(value, np.zeros(value.shape)) for value in values)
        return replace(found, pressure=pressure, gap=gap)

    _hidden: Any = 0.0

    @property
    def _reach(self) -> float:
        """Largest |x| of which something is known [length]."""
        nodes = self.interface.x
        # Nodes are the middles of cells: the last ends as far beyond its node as the first begins
        # before its own.
        return self.scene.period / 2 if self.scene.on_line else float(nodes[-1] + nodes[0])

    def _known_around(self: Any, x: Array, step: float) -> tuple[Array, Array]:
        """Return between which places this answer and its companion know the contact about x."""
        reach = min(self._reach, self.companion._reach)
        begins, ends = np.clip(np.transpose(self.scene.contact.intervals), -reach, reach)
        part = np.searchsorted(begins, x, side="right") - 1
        last = ends[part] - step / 8
        return np.minimum(x, begins[part] + step / 8), np.maximum(np.minimum(x, reach), last)

    @property
    def _moved(self: Any) -> Array:
        """Nodes of the companion whose differences count in the mean, which both know."""
        known = self.companion.interface
        if not self.scene.on_line:
            return np.asarray(known.x[known.x <= self.interface.x[-1]])
        # bars do not depend on how much of the line has not slipped
        slip = np.where(known.touching, np.abs(known.slip).max(axis=0), 0.0)
        return np.asarray(known.x[slip > LEAST_SLIP * slip.max(initial=0.0)])

    def _onset(self, of: str, share: float = ONSET_SHARE) -> Array:
        """Return the times at which something begins at the nodes, (n,); inf where it does not."""
        return onsets(self.interface, of, share)

    def _places(self, x: ArrayLike) -> Array:
        """Return places along the nodes; raise SceneError beyond them or off the contact."""
        along, reach = self.scene.on_line, self._reach
        x = line_positions(x) if along else contact_positions(x)
        beyond = x[np.abs(x) > reach * (1 + ROUNDING)]
        if beyond.size:
            size, remedy = "x", "on a greater length or to a later end time"
            if along:
                size, remedy = "|x|", "with a greater `period`"
            raise SceneError(
                f"this answer reaches to {size} = {reach:.6g}, got {shown(float(beyond[0]))}; ask "
                f"for nearer positions, or compute it {remedy}."
            )
        place = np.abs(x) if self.scene.even else x
        off = x[~self.scene.contact.touches(place)]
        if off.size:
            raise SceneError(
                f"the bodies do not touch at x = {off[0]:.6g}; ask for positions of the contact, "
                "or read nodes of the slot."
            )
        return place

    def _between(self, values: Array, x: ArrayLike, t: ArrayLike) -> Array:
        """Interpolate values (m, n) at places and times."""
        check_times(np.asarray(t, dtype=float), self.interface.t)
        x, t = np.broadcast_arrays(self._places(x), np.asarray(t, dtype=float))
        return interpolated(replace(self.interface, slip=values), "slip", x, t)

    def _frame(self, values: Array, t: float) -> Array:
        """Return values at the nodes at a time, (n,)."""
        known = self.interface.t
        check_times(np.asarray(t), known)
        if not self.scene.on_line and t <= min(known[0], 0.0):  # at rest
            return np.zeros(values.shape[1])
        earlier, later, on = between(known, np.asarray(t))
        return np.asarray((1 - on) * values[earlier] + on * values[later])

    def _on_parts(self, values: Array, found: Finder[Interval]) -> tuple[Interval, ...]:
        """Return the intervals that are found from values at nodes, on each part of the contact."""
        x, touching, half = self.interface.x, self.interface.touching, self.scene.period / 2
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

    def _field(self, name: str, x: ArrayLike, t: ArrayLike) -> Array:
        """Return a field at places and times."""
        values = self._between(getattr(self.interface, name), x, t)
        if self.scene.on_line:
            return values
        base = {"shear_traction": self.scene.base.shear, "pressure": self.scene.base.pressure}
        # a record begins before t = 0 where a load comes along the slot no faster than its waves
        before = np.asarray(t) < min(self.interface.t[0], 0.0)
        return np.asarray(np.where(before, base.get(name, 0.0), values))


def interpolated(history: InterfaceHistory, name: str, x: Array, t: Array) -> Array:
    """Interpolate a field at x, t linearly between samples; beyond them take the nearest."""
    (left, right, along), (earlier, later, on) = history.beside(x), between(history.t, t)
    field = getattr(history, name)
    before = (1 - along) * field[earlier, left] + along * field[earlier, right]
    after = (1 - along) * field[later, left] + along * field[later, right]
    return np.asarray((1 - on) * before + on * after)
