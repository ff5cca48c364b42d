"""Answers that were recorded at nodes and time levels, and interpolation between the samples.

A solver that steps through time keeps an `InterfaceHistory` of the levels it stored and the
`Totals` of every step; `SampledAnswer` makes an `Answer` of the two.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from semianalytic.results.gridded import Gridded
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.results.places import contact_positions
from semianalytic.results.questions import (
    ONSET_SHARE,
    ROUNDING,
    Finder,
    Interval,
    Questions,
    between,
    check_times,
    onsets,
)
from semianalytic.results.reading import Reading, sampled_reading
from semianalytic.scene.arguments import asked_in_units
from semianalytic.scene.errors import SceneError
from semianalytic.scene.scene import Scene

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Totals:
    """Totals of the whole contact at every step, stored or not, as (m,) arrays.

    Times t increase from 0 or before; max_slip [length], accumulated_slip [length^2], and
    frictional_work [stress length^2] are until each time.
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
    _hidden: Any = 0.0

    def _known_around(self: Any, x: Array, step: float) -> tuple[Array, float]:
        """Return between which places x > 0 the answer and its companion know the contact.

        It ends one node distance beyond the last node.
        """
        grids = (self.interface.x, self.companion.interface.x)
        return np.minimum(x, step / 8), min(float(nodes[-1] + nodes[0]) for nodes in grids)

    @property
    def _moved(self: Any) -> Array:
        """Nodes of the companion on the contact that both know."""
        nodes = self.companion.interface.x
        return np.asarray(nodes[nodes <= self.interface.x[-1]])

    @property
    def _seen(self) -> InterfaceHistory:
        return self.interface

    def _onset(self, of: str, share: float = ONSET_SHARE) -> Array:
        return onsets(self.interface, of, share)

    def _places(self, x: ArrayLike) -> Array:
        x, nodes = contact_positions(x), self.interface.x
        # Nodes are the middles of cells: the last ends as far beyond its node as the first begins
        # before its own.
        reach = nodes[-1] + nodes[0]
        if np.any(x > reach * (1 + ROUNDING)):
            raise SceneError(
                f"this answer reaches to x = {reach:.6g}; ask for nearer positions, or compute it "
                "on a greater length or to a later end time."
            )
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

    def _field(self, name: str, x: ArrayLike, t: ArrayLike) -> Array:
        base = {"shear_traction": self.scene.base.shear, "pressure": self.scene.base.pressure}
        # a record begins before t = 0 where a load comes along the slot no faster than its waves
        before = np.asarray(t) < min(self.interface.t[0], 0.0)
        values = self._between(getattr(self.interface, name), x, t)
        return np.asarray(np.where(before, base.get(name, 0.0), values))


def interpolated(history: InterfaceHistory, name: str, x: Array, t: Array) -> Array:
    """Interpolate a field at x, t linearly between samples; beyond them take the nearest."""
    (left, right, along), (earlier, later, on) = between(history.x, x), between(history.t, t)
    field = getattr(history, name)
    before = (1 - along) * field[earlier, left] + along * field[earlier, right]
    after = (1 - along) * field[later, left] + along * field[later, right]
    return np.asarray((1 - on) * before + on * after)
