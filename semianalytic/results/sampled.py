"""Answers that were recorded at nodes and time levels, and interpolation between the samples.

A solver that steps through time keeps an `InterfaceHistory` of the levels it stored and the
`Totals` of every step; `SampledAnswer` makes an `Answer` of the two.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from semianalytic.results.gridded import Gridded
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.results.intervals import front_speeds
from semianalytic.results.places import contact_positions
from semianalytic.results.questions import (
    ONSET_SHARE,
    ROUNDING,
    Finder,
    Interval,
    Questions,
    between,
    check_times,
    onset_between,
    onsets,
)
from semianalytic.results.reading import Reading, sampled_reading
from semianalytic.scene.errors import SceneError
from semianalytic.scene.given.arguments import asked_in_units
from semianalytic.scene.scene import Scene

Array = NDArray[np.float64]


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
class SampledAnswer(Questions, Gridded):
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

    _on = slice(None)

    @property
    def _seen(self) -> InterfaceHistory:
        return self.interface

    def _onset(self, of: str, share: float = ONSET_SHARE) -> Array:
        return onsets(self.interface, of, share)

    def _places(self, x: ArrayLike) -> Array:
        x = np.asarray(x, dtype=float)
        _check_positions(x, self.interface.x)
        return x

    def _between(self, values: Array, x: ArrayLike, t: ArrayLike) -> Array:
        check_times(np.asarray(t, dtype=float), self.interface.t)
        x, t = np.broadcast_arrays(self._places(x), np.asarray(t, dtype=float))
        return interpolated(replace(self.interface, slip=values), "slip", x, t)

    def _frame(self, values: Array, t: float) -> Array:
        rests = t <= min(self.interface.t[0], 0.0)
        return np.zeros(values.shape[1]) if rests else self._between(values, self.interface.x, t)

    def _on_parts(self, values: Array, found: Finder[Interval]) -> tuple[Interval, ...]:
        return found(self.interface.x, values)

    def _field(self, name: str, x: ArrayLike, t: ArrayLike, at_rest: float = 0.0) -> Array:
        # a record begins before t = 0 where a load comes along the slot no faster than its waves
        before = np.asarray(t) < min(self.interface.t[0], 0.0)
        values = self._between(getattr(self.interface, name), x, t)
        return np.asarray(np.where(before, at_rest, values))


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
