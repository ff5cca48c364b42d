"""Answers that are wrong on purpose: told late or backward, or of a bent profile."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from semianalytic import (
    Answer,
    OpenInterval,
    OpenZone,
    Scene,
    SlipInterval,
    SlipZone,
    Solution,
)
from semianalytic.results.gridded import Gridded
from semianalytic.selfsimilar.answer import SelfSimilarAnswer

Array = NDArray[np.float64]

_EVEN, _GRADED, _CLUSTERED = 4000, 300, 200
_REACH = 1.1
"""End of the table of a profile, over c_l; fields farther ahead keep the values at the end."""
_FIRST, _NEAREST, _BESIDE = 1e-6, 1e-7, 0.05
"""First velocity, and least and largest distance of points from an edge or a front, over c_t."""


@dataclass(frozen=True, eq=False)
class Retold(Gridded):
    """An answer told with a delay, or with slip of the other sign.

    Attributes
    ----------
    original : Answer
    lag : float
        By which all of it is late [time].
    sense : int
        -1 where the sign of slip is to be wrong, and nothing else is.
    """

    original: Answer
    lag: float = 0.0
    sense: int = 1

    @property
    def scene(self) -> Scene:
        """See `Answer.scene`."""
        return self.original.scene

    @property
    def companion(self) -> Retold | None:
        """Companion by which a march judges its errors, retold alike; None if there is none."""
        own = getattr(self.original, "companion", None)
        return None if own is None else Retold(own, self.lag, self.sense)

    def slip_rate(self, x: ArrayLike, t: ArrayLike) -> Array:
        """See `Answer.slip_rate`."""
        return self.sense * self.original.slip_rate(x, self._time(t))

    def slip(self, x: ArrayLike, t: ArrayLike) -> Array:
        """See `Answer.slip`."""
        return self.sense * self.original.slip(x, self._time(t))

    def shear_traction(self, x: ArrayLike, t: ArrayLike) -> Array:
        """See `Answer.shear_traction`."""
        return self.original.shear_traction(x, self._time(t))

    def pressure(self, x: ArrayLike, t: ArrayLike) -> Array:
        """See `Answer.pressure`."""
        return self.original.pressure(x, self._time(t))

    def gap(self, x: ArrayLike, t: ArrayLike) -> Array:
        """See `Answer.gap`."""
        return self.original.gap(x, self._time(t))

    def max_slip(self, t: ArrayLike) -> Array:
        """See `Answer.max_slip`."""
        return self.original.max_slip(self._time(t))

    def accumulated_slip(self, t: ArrayLike) -> Array:
        """See `Answer.accumulated_slip`."""
        return self.original.accumulated_slip(self._time(t))

    def frictional_work(self, t: ArrayLike) -> Array:
        """See `Answer.frictional_work`."""
        return self.original.frictional_work(self._time(t))

    def zones_at(self, t: float) -> tuple[SlipInterval, ...]:
        """See `Answer.zones_at`."""
        zones = self.original.zones_at(t - self.lag)
        return tuple(SlipInterval(zone.start, zone.end, self.sense * zone.sense) for zone in zones)

    def openings_at(self, t: float) -> tuple[OpenInterval, ...]:
        """See `Answer.openings_at`."""
        return self.original.openings_at(t - self.lag)

    def _time(self, t: ArrayLike) -> Array:
        return np.asarray(t, dtype=float) - self.lag


@dataclass(frozen=True, eq=False)
class Profiled(SelfSimilarAnswer):
    """A self-similar answer of given fields at velocities x/t, linear between them.

    Slip and totals follow from them.  Nearer to the edge than the first velocity, and further than
    the last, fields are those there.

    Attributes
    ----------
    scene : Scene
    velocity : (n,) array
        Increasing from above 0 [length / time].
    rate : (n,) array
        Relative slip rate [length / time].
    shear, normal : (n,) arrays
        Shear traction and pressure, base included [stress].
    zones : tuple of SlipZone
        From the contact edge outward.
    gap_over_time : (n,) array
        How far the contact is open, over the time [length / time].
    openings : tuple of OpenZone
        From the contact edge outward.
    """

    scene: Scene
    velocity: Array
    rate: Array
    shear: Array
    normal: Array
    zones: tuple[SlipZone, ...]
    gap_over_time: Array
    openings: tuple[OpenZone, ...]

    def slip_rate(self, x: ArrayLike, t: ArrayLike) -> Array:
        """See `Answer.slip_rate`."""
        return self._at(self.rate, 0.0, x, t)

    def slip(self, x: ArrayLike, t: ArrayLike) -> Array:
        """See `Answer.slip`."""
        return np.asarray(t, dtype=float) * self._at(self._slip_over_time, 0.0, x, t)

    def shear_traction(self, x: ArrayLike, t: ArrayLike) -> Array:
        """See `Answer.shear_traction`."""
        return self._at(self.shear, self.scene.superposition.in_place.shear, x, t)

    def pressure(self, x: ArrayLike, t: ArrayLike) -> Array:
        """See `Answer.pressure`."""
        return self._at(self.normal, self.scene.superposition.in_place.pressure, x, t)

    def gap(self, x: ArrayLike, t: ArrayLike) -> Array:
        """See `Answer.gap`."""
        return np.asarray(t, dtype=float) * self._at(self.gap_over_time, 0.0, x, t)

    def max_slip(self, t: ArrayLike) -> Array:
        """See `Answer.max_slip`."""
        return np.maximum(t, 0.0) * float(np.abs(self._slip_over_time).max())

    def accumulated_slip(self, t: ArrayLike) -> Array:
        """See `Answer.accumulated_slip`."""
        return self._growing(np.abs(self.rate), t)

    def frictional_work(self, t: ArrayLike) -> Array:
        """See `Answer.frictional_work`."""
        return self._growing(np.abs(self.shear * self.rate), t)

    def _at(self, values: Array, at_rest: float, x: ArrayLike, t: ArrayLike) -> Array:
        x, t = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(t, dtype=float))
        velocity = np.divide(x, t, out=np.full(x.shape, np.inf), where=t > 0)
        return np.where(t < 0, at_rest, np.interp(velocity, self.velocity, values))

    @cached_property
    def _slip_over_time(self) -> Array:
        """Slip / t, (n,): the mean of the slip rate over slownesses up to t/x."""
        slowness = 1 / self.velocity
        steps = -np.diff(slowness) * (self.rate[:-1] + self.rate[1:]) / 2
        past = np.append(np.cumsum(steps[::-1])[::-1], 0.0)
        return self.velocity * (past + self.rate[-1] * slowness[-1])

    def _growing(self, values: Array, t: ArrayLike) -> Array:
        """Integral over all positions and times up to t; inf where it slips ahead of all waves."""
        over_time = math.inf
        if not values[-1]:
            over_time = np.trapezoid(values, self.velocity) + values[0] * self.velocity[0]
        time = np.maximum(t, 0.0)
        return np.multiply(over_time / 2, time**2, out=np.zeros(time.shape), where=time > 0)


@dataclass(frozen=True, eq=False)
class Tabulated(Profiled):
    """A solution as a table, which is quicker to read and knows the slot as well."""

    original: Solution

    def slot_velocity(self, x: ArrayLike, t: ArrayLike) -> tuple[Array, Array]:
        """See `Solution.slot_velocity`."""
        return self.original.slot_velocity(x, t)


def tabulated(solution: Solution) -> Tabulated:
    """Return a solution as a table that differs from it only in its last digits."""
    table = profiled(solution)
    return Tabulated(
        **{part.name: getattr(table, part.name) for part in fields(table)}, original=solution
    )


@lru_cache(maxsize=2)
def profiled(solution: Solution) -> Profiled:
    """Tabulate the fields of a solution on the contact so that they can be distorted."""
    material = solution.scene.material
    speed, reach = material.shear_speed, _REACH * material.longitudinal_speed
    openings = solution.openings
    opened = [end for part in openings for end in (part.inner, part.outer)]
    edges = np.array([*solution.edge_speeds.ravel(), *opened])
    fronts = (material.rayleigh_speed, speed, material.longitudinal_speed)
    ends = np.array([*edges[(edges > 0) & np.isfinite(edges)], *fronts])
    near = speed * np.geomspace(_NEAREST, _BESIDE, _CLUSTERED)
    velocity = np.concatenate(
        [
            np.geomspace(_FIRST * speed, reach, _GRADED),
            np.linspace(_FIRST * speed, reach, _EVEN),
            ends,
            np.add.outer(ends, [*near, *-near]).ravel(),
        ]
    )
    velocity = np.unique(velocity[(velocity > 0) & (velocity <= reach)])
    velocity = velocity[velocity != material.rayleigh_speed]  # slip there has a logarithm
    named = (solution.slip_rate, solution.shear_traction, solution.pressure, solution.gap)
    rate, shear, normal, gap = (field(velocity, 1.0) for field in named)
    return Profiled(solution.scene, velocity, rate, shear, normal, solution.zones, gap, openings)
