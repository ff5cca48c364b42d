"""Methods that all self-similar answers share: zones and openings whose edges move evenly."""

from __future__ import annotations

from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.halfplane.polynomials import gauss
from semianalytic.results.answer import Arrival, OpenInterval, SlipInterval
from semianalytic.results.gridded import Gridded
from semianalytic.results.reading import first_times
from semianalytic.scene.arguments import asked_in_units
from semianalytic.scene.arrays import Array
from semianalytic.scene.checks import checked_number
from semianalytic.selfsimilar.zones.motion import is_open

if TYPE_CHECKING:
    from semianalytic.scene.scene import Material
    from semianalytic.selfsimilar.zones.motion import OpenZone, SlipZone

_NODES = 60
"""Nodes between two edges or fronts of the integrals over time of `work_density`."""
_SAMPLED = 200
"""Velocities within an opening at which the sense of motion is looked at."""


@asked_in_units
class SelfSimilarAnswer(Gridded):
    """An answer whose fields depend on x/t, up to a power of time.

    Zones and openings are those of the classes that inherit from this one.
    """

    method = "self-similar"

    if TYPE_CHECKING:  # fields of some dataclasses, for which a property here would be a default

        @property
        def zones(self) -> tuple[SlipZone, ...]:
            """Slip zones in velocities, from the contact edge outward."""

        @property
        def openings(self) -> tuple[OpenZone, ...]:
            """Open parts in velocities, from the contact edge outward."""

        slip: Any
        slip_rate: Any
        shear_traction: Any
        pressure: Any
        scene: Any

    @property
    def _solids(self) -> tuple[Material, ...]:
        """The bodies, whose waves bend the fields."""
        return (self.scene.material,)

    @cached_property
    def _one_way(self) -> tuple[tuple[float, float], ...]:
        """Velocities between which the sides move along one another in one sense."""
        parts = [(zone.inner, zone.outer) for zone in self.zones]
        for gap in self.openings:
            v = np.linspace(gap.inner, gap.outer, _SAMPLED + 2)[1:-1]
            turns = np.flatnonzero(np.diff(np.sign(self.slip_rate(v, 1.0))))
            parts += pairwise([gap.inner, *(self._turn(v[k], v[k + 1]) for k in turns), gap.outer])
        return tuple(sorted(parts))

    def _turn(self, low: float, high: float) -> float:
        """Return the velocity between two at which the slip rate changes its sign."""
        sense = np.sign(self.slip_rate(low, 1.0))
        for _ in range(50):
            middle = (low + high) / 2
            same = np.sign(self.slip_rate(middle, 1.0)) == sense
            low, high = (middle, high) if same else (low, middle)
        return low

    def path(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Return the accumulated |slip| [length], the time integral of |slip rate|; raises like
        `slip_rate`."""
        x, t = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(t, dtype=float))
        total = np.abs(self.slip(x, np.minimum(t, 0.0)))
        # Slip rate has one sign in each part, so that its integral there is a difference of slips.
        for inner, outer in self._one_way:
            starts = np.minimum(t, x / outer)
            stops = np.minimum(t, x / inner) if inner else t
            total = total + np.abs(self.slip(x, stops) - self.slip(x, starts))
        return np.asarray(total)

    @np.errstate(divide="ignore", invalid="ignore")  # at the largest times and smallest positions
    def work_density(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Return the energy turned to heat at x until t, per area [stress length]; raises like
        `slip_rate`."""
        x, t = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(t, dtype=float))
        far, total = np.abs(x), np.abs(self.slip(x, t)) * 0.0
        ends = {end for zone in self.zones for end in (abs(zone.inner), zone.outer)}
        ends |= {part.inner for part in self.openings} | {part.outer for part in self.openings}
        for solid in self._solids:
            ends |= {solid.rayleigh_speed, solid.shear_speed, solid.longitudinal_speed}
        share, weight = gauss(_NODES)
        # nodes crowd at edges and fronts, where rates have roots and logarithms
        place, rule = share**2 * (3 - 2 * share), weight * 6 * share * (1 - share)
        for outer, inner in pairwise([*sorted(ends - {0.0, np.inf}, reverse=True), 0.0]):
            begin = np.minimum(far / outer, t)
            length = (np.minimum(far / inner, t) if inner else t) - begin
            at = begin[..., None] + np.maximum(length, 0.0)[..., None] * place
            moves = (length > 0)[..., None]
            at = np.where(moves, at, -1.0)  # before the load nothing moves
            power = self.shear_traction(x[..., None], at) * self.slip_rate(x[..., None], at)
            total = total + np.where(length > 0, length * (power @ rule), 0.0)
        return np.asarray(total)

    def stick_margin(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Return strength minus |shear traction| [stress] where the interface sticks, 0 where it
        slips or is open; raises like `slip_rate`.
        """
        strength = self.scene.strength(self.pressure(x, t), self.slip_rate(x, t))
        margin = strength - np.abs(self.shear_traction(x, t))
        return np.where(is_open(self.openings, x, t), 0.0, margin)

    def arrival(self, x: ArrayLike, of: Arrival = "slip") -> Array:
        """First time of slip or opening at x [time], inf without one; as `Solution.arrival`.

        "forward" and "reverse" refer to closed parts only; "slip" includes the motion of open
        parts.
        """
        if of == "opening":
            return first_times(x, self.openings)
        if of == "slip":
            return first_times(x, (*self.zones, *self.openings))
        sense = 1 if of == "forward" else -1
        return first_times(x, (zone for zone in self.zones if zone.sense == sense))

    def front_speed(self, x: ArrayLike) -> Array:
        """Speed at which the slip front passes x [length / time]: inf ahead of all waves, nan if it
        never does; raises like `arrival`."""
        when = self.arrival(x)
        speed = np.divide(np.abs(x), when, out=np.full(when.shape, np.inf), where=when > 0)
        return np.where(np.isfinite(when), speed, np.nan)

    def zones_at(self, t: float) -> tuple[SlipInterval, ...]:
        """Return the intervals that slip at a time [time], from the contact edge outward.

        Until t = 0 there are none.

        Raises
        ------
        SceneError
            If the time is not a finite number.
        """
        t = checked_number("zones_at: t", t)
        parts = self.zones if t > 0 else ()
        return tuple(SlipInterval(t * zone.inner, t * zone.outer, zone.sense) for zone in parts)

    def openings_at(self, t: float) -> tuple[OpenInterval, ...]:
        """Return the open intervals at a time, from the contact edge outward; raises like
        `zones_at`."""
        t = checked_number("openings_at: t", t)
        parts = self.openings if t > 0 else ()
        return tuple(OpenInterval(t * part.inner, t * part.outer) for part in parts)

    @property
    def edge_speeds(self) -> Array:
        """(m, 2) velocities of the inner and outer edge of each zone [length / time].

        From the contact edge outward; 0 is the contact edge itself, inf slip ahead of all waves.
        """
        return np.array([(zone.inner, zone.outer) for zone in self.zones]).reshape(-1, 2)
