"""Power, work and slip of the contact of a self-similar solution, over all of it or a part.

Fields depend on x/t alone, so that at fixed x an integral over time is one over slowness, and
integrals over the contact grow like powers of time.
"""

from __future__ import annotations

import math
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.cut.profile import Profile
from semianalytic.cut.totals import (
    contact_integral,
    dissipation,
    largest_slip_over_time,
    slipped_rate,
)
from semianalytic.results.intervals import finite_times
from semianalytic.scene.arguments import asked_in_units
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import SceneError
from semianalytic.selfsimilar.answer import SelfSimilarAnswer
from semianalytic.selfsimilar.zones.motion import SlipZone, over_slowness


@asked_in_units
class ContactTotals(SelfSimilarAnswer):
    """Slip on the contact, and the energy that friction takes there, from a profile over slowness.

    `_motion` are parts in contact or open, where the sides move along one another.
    """

    if TYPE_CHECKING:  # what the class has that inherits from this one
        profile: Profile
        stress_unit: float

        @property
        def _rate_unit(self) -> float:
            """Relative slip rate over that of `profile`."""

        @property
        def _motion(self) -> tuple[SlipZone, ...]:
            """Zones of motion, of either sense."""

    @property
    def _speed(self) -> float:
        return float(self.scene.material.shear_speed)

    @np.errstate(divide="ignore", invalid="ignore")  # at the smallest positions
    def work_density(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Return the energy turned to heat at x until t, per area [stress length]; raises like
        `slip_rate`."""
        unit = self._rate_unit * self.stress_unit / self._speed
        # At fixed x, an integral over time is x / c_t times one over slowness.
        heat = over_slowness(self._speed, x, t, lambda u: dissipation(self.profile, u)[1])
        return unit * np.asarray(x, dtype=float) * heat

    def frictional_power(
        self, t: ArrayLike, inner: ArrayLike = 0.0, outer: ArrayLike = np.inf
    ) -> Array:
        """Return the power turned to heat on the contact per unit depth at times t [stress length^2
        / time].

        It covers positions between inner and outer [length], which broadcast with t. Over the whole
        contact it grows linearly in time; it is infinite if the interface slips ahead of all waves.

        No other power leaves the solids through the contact. The edges of slip zones take none:
        slip rate vanishes there at least like |x - edge|^(1/2) (between c_t and c_l like |x -
        edge|^(1 - phi/pi)) under a finite traction. A stuck contact edge is singular, but it does
        not move. The rest of the work of the load is radiated; it is infinite, because the slot is.

        Raises
        ------
        SceneError
            If inner is negative, infinite or above outer, or t is not finite.
        """
        t, inner, outer = _intervals(t, inner, outer)
        time = np.maximum(t, 0.0)
        # The power beyond `inner` less the power beyond `outer`.
        per_time = self._power_per_time(inner, time) - self._power_per_time(outer, time)
        power = self._rate_unit * self.stress_unit * self._speed * per_time
        return np.asarray(np.multiply(power, time, out=np.zeros(t.shape), where=time > 0))

    def _power_per_time(self, x: Array, time: Array) -> Array:
        """Return the power beyond x over time, in units of `profile`, behind the first front."""
        value = np.full(x.shape, self._whole_power)
        # Slip ahead of all waves dissipates without bound; counted from the longitudinal front,
        # what lies beyond x = inf is then minus infinity, and the power of the contact +infinity.
        value[np.isinf(x)] = -np.inf if self.scene.far_slip_rate else 0.0
        u = np.divide(time * self._speed, x, out=np.zeros(x.shape), where=x > 0)
        part = (u > 0) & np.isfinite(u)
        value[part] = dissipation(self.profile, u[part])[0]
        return value

    @cached_property
    def _whole_power(self) -> float:
        """Frictional power over time, in units of `profile`."""
        return contact_integral(self.profile, self.profile.carried_at_nodes)

    def frictional_work(
        self, t: ArrayLike, inner: ArrayLike = 0.0, outer: ArrayLike = np.inf
    ) -> Array:
        """Return the energy turned to heat on the contact until t, per unit depth [stress
        length^2].

        It is the time integral of `frictional_power`, with the same parameters and errors.
        """
        t, inner, outer = _intervals(t, inner, outer)
        twice = np.asarray(np.maximum(t, 0.0) * self.frictional_power(t, inner, outer))
        # By self-similarity the power beyond x is t F(x/t), and the work at x follows from F.
        for x, sign in ((inner, -1), (outer, 1)):
            part = (x > 0) & np.isfinite(x)
            twice[part] += sign * x[part] * self.work_density(x[part], t[part])
        return twice / 2

    def accumulated_slip(self, t: ArrayLike) -> Array:
        """Return the integral over the contact of `path`, the |slip| accumulated until t
        [length^2].

        It grows like t^2, and is infinite if the interface slips ahead of all waves.

        Raises
        ------
        SceneError
            If a time is not finite.
        """
        time = np.maximum(finite_times(t), 0.0)
        rate = math.inf if self.scene.far_slip_rate else self._rate_unit * self._whole_rate
        # The integral of |V| over x is proportional to t, and its time integral to t^2 / 2.
        area = rate * self._speed / 2
        return np.asarray(np.multiply(area, time**2, out=np.zeros(time.shape), where=time > 0))

    @cached_property
    def _whole_rate(self) -> float:
        """Integral of |slip rate| over the contact, over time, in units of `profile`."""
        speed = self._speed
        zones = [(zone.inner / speed, zone.outer / speed, zone.sense) for zone in self._motion]
        return slipped_rate(self.profile, zones)

    def max_slip(self, t: ArrayLike) -> Array:
        """Return the largest |slip| on the contact, or its limit at the edge, at times t [length].

        It grows linearly in time; raises like `accumulated_slip`.
        """
        return self._rate_unit * np.maximum(finite_times(t), 0.0) * self._largest_slip_over_time

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
