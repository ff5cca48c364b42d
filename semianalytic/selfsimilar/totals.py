"""Power, work and slip of the contact of a self-similar solution, over all of it or a part.

Fields depend on x/t alone, so that at fixed x an integral over time is one over slowness, and
integrals over the contact grow like powers of time.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.cut.profile import Profile
from semianalytic.cut.totals import (
    contact_integral,
    dissipation,
    largest_slip_over_time,
    slipped_rate,
)
from semianalytic.halfplane.rayleigh import Array
from semianalytic.results.intervals import finite_times
from semianalytic.scene.errors import SceneError
from semianalytic.scene.scene import Scene
from semianalytic.selfsimilar.zones.motion import SlipZone, over_slowness


@dataclass(frozen=True, eq=False)
class ContactTotals:
    """Slip on the contact, and the energy that friction takes there.

    `profile` is in `rate_unit` and `stress_unit`; `moving` are parts in contact or open.
    """

    scene: Scene
    profile: Profile
    moving: tuple[SlipZone, ...]
    rate_unit: float
    stress_unit: float

    @property
    def _speed(self) -> float:
        return self.scene.material.shear_speed

    def work_density(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Return the energy turned to heat at x until t, per area [stress length]."""
        unit = self.rate_unit * self.stress_unit / self._speed
        # At fixed x, an integral over time is x / c_t times one over slowness.
        heat = over_slowness(self._speed, x, t, lambda u: dissipation(self.profile, u)[1])
        return unit * np.asarray(x, dtype=float) * heat

    def power(self, t: ArrayLike, inner: ArrayLike, outer: ArrayLike) -> Array:
        """Return the power turned to heat between two positions [stress length^2 / time]."""
        t, inner, outer = _intervals(t, inner, outer)
        time = np.maximum(t, 0.0)
        # The power beyond `inner` less the power beyond `outer`.
        per_time = self._power_per_time(inner, time) - self._power_per_time(outer, time)
        power = self.rate_unit * self.stress_unit * self._speed * per_time
        return np.asarray(np.multiply(power, time, out=np.zeros(t.shape), where=time > 0))

    def _power_per_time(self, x: Array, time: Array) -> Array:
        """Return the power beyond x over time, in units of `profile`, behind the first front."""
        value = np.full(x.shape, self._whole_power)
        # Slip ahead of all waves dissipates without bound; counted from the longitudinal front,
        # what lies beyond x = inf is then minus infinity, and the power of the contact +infinity.
        value[np.isinf(x)] = -np.inf if self.scene.far_slip_rate else 0.0
        part = (x > 0) & np.isfinite(x) & (time > 0)
        u = time[part] * self._speed / x[part]
        value[part] = dissipation(self.profile, u)[0]
        return value

    def work(self, t: ArrayLike, inner: ArrayLike, outer: ArrayLike) -> Array:
        """Return the energy turned to heat between two positions until t [stress length^2].

        Raises what `power` raises.
        """
        t, inner, outer = _intervals(t, inner, outer)
        twice = np.asarray(np.maximum(t, 0.0) * self.power(t, inner, outer))
        # By self-similarity the power beyond x is t F(x/t), and the work at x follows from F.
        for x, sign in ((inner, -1), (outer, 1)):
            part = (x > 0) & np.isfinite(x)
            twice[part] += sign * x[part] * self.work_density(x[part], t[part])
        return twice / 2

    def accumulated_slip(self, t: ArrayLike) -> Array:
        """Return the integral over the contact of |slip| until t [length^2]."""
        time = np.maximum(finite_times(t), 0.0)
        rate = math.inf if self.scene.far_slip_rate else self.rate_unit * self._whole_rate
        # The integral of |V| over x is proportional to t, and its time integral to t^2 / 2.
        area = rate * self._speed / 2
        return np.asarray(np.multiply(area, time**2, out=np.zeros(time.shape), where=time > 0))

    def max_slip(self, t: ArrayLike) -> Array:
        """Return the largest |slip| on the contact at times t [length].

        Raises what `accumulated_slip` raises.
        """
        return self.rate_unit * np.maximum(finite_times(t), 0.0) * self._largest_slip_over_time

    @cached_property
    def _whole_power(self) -> float:
        """Frictional power over time, in units of `profile`."""
        return contact_integral(self.profile, self.profile.carried_at_nodes)

    @cached_property
    def _whole_rate(self) -> float:
        """Integral of |slip rate| over the contact, over time, in units of `profile`."""
        speed = self._speed
        zones = [(zone.inner / speed, zone.outer / speed, zone.sense) for zone in self.moving]
        return slipped_rate(self.profile, zones)

    @cached_property
    def _largest_slip_over_time(self) -> float:
        """Largest |slip| / t on the contact, in units of `profile`."""
        return largest_slip_over_time(self.profile)


def _intervals(t: ArrayLike, inner: ArrayLike, outer: ArrayLike) -> tuple[Array, Array, Array]:
    """Return times and the ends of intervals of the contact, broadcast and checked."""
    t, inner, outer = np.broadcast_arrays(
        finite_times(t), *(np.asarray(values, dtype=float) for values in (inner, outer))
    )
    if not np.all((inner >= 0) & (inner <= outer) & np.isfinite(inner)):
        raise SceneError("the contact is x > 0; ask for an interval with 0 <= inner <= outer.")
    return t, inner, outer
