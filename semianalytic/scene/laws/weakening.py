"""Friction that weakens with slip, behind a given front, or with slip rate."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from semianalytic.scene.arrays import Array
from semianalytic.scene.checks import checked_word
from semianalytic.scene.laws.delay import DelayedLaw, LinearLaw
from semianalytic.scene.quantities import with_quantities


@with_quantities
@dataclass(frozen=True, eq=False, repr=False)
class SlipWeakening(LinearLaw):
    """Friction that falls with accumulated slip from static to dynamic, linearly or exponentially.

    Strength is (f_d + (f_s - f_d) w) p + cohesion w, with w = max(1 - slip / distance, 0), or
    exp(-slip / distance).

    Parameters
    ----------
    static, dynamic : field
        Coefficients before and after weakening.
    distance : field
        Slip over which friction falls, or falls by a factor e [length].
    cohesion : field
        Strength without pressure, lost with slip [stress].
    shape : str
        "linear" or "exponential".
    delay, delay_slip : field
        Time [time] and slip [length] over which friction follows pressure; see `DelayedLaw`.

    Raises
    ------
    SceneError
        If a parameter is out of range.

    Examples
    --------
    >>> import numpy as np
    >>> from semianalytic import SlipWeakening
    >>> law = SlipWeakening(static=0.6, dynamic=0.2, distance=0.4)
    >>> law.strength(1.0, 0.0, np.array([0.0, 0.2, 1.0])).round(6).tolist()
    [0.6, 0.4, 0.2]
    """

    static: Any
    dynamic: Any
    distance: Any
    cohesion: Any = 0.0
    shape: str = field(
        default="linear", metadata={"dimension": "", "meaning": "linear or exponential"}
    )

    _not_negative = ("static", "dynamic", "cohesion")
    _positive = ("distance",)

    def __post_init__(self) -> None:
        super().__post_init__()
        checked_word("SlipWeakening: shape", self.shape, ("linear", "exponential"))

    def _left(self, state: Array) -> Array:
        if self.shape == "linear":
            return np.maximum(1 - state / self.distance, 0.0)
        return np.exp(-state / self.distance)

    def strength(self, pressure: Array, speed: Array, state: Array) -> Array:
        """Return the weakened strength; see `Law.strength`."""
        left = self._left(state)
        friction = self.dynamic + (self.static - self.dynamic) * left
        return np.asarray(friction * pressure + self.cohesion * left + 0 * speed)

    def weakening(self, pressure: Array) -> float:
        """Return the steepest fall [stress / length]; see `Law.weakening`."""
        fall = (self.static - self.dynamic) * pressure + self.cohesion
        return float(np.max(fall / self.distance, initial=0.0))


@with_quantities
@dataclass(frozen=True, eq=False, repr=False)
class ForcedFront(LinearLaw):
    """Friction that falls from static to dynamic when a front arrives, whatever the slip.

    The state is the time since t = 0.  With a static friction that is never reached the front is
    that of a rupture of prescribed speed (Kostrov 1964).

    Parameters
    ----------
    static, dynamic : field
        Coefficients before and after the front.
    arrival : field
        Time at which the front arrives [time], such as ``lambda x: abs(x) / speed``.
    fall : field
        Time over which friction falls from then on [time]; 0 for at once.
    delay, delay_slip : field
        Time [time] and slip [length] over which friction follows pressure; see `DelayedLaw`.

    Raises
    ------
    SceneError
        If a parameter is out of range.

    Examples
    --------
    >>> import numpy as np
    >>> from semianalytic import ForcedFront
    >>> law = ForcedFront(static=0.6, dynamic=0.2, arrival=1.0, fall=2.0)
    >>> law.strength(1.0, 0.0, np.array([0.5, 2.0, 4.0])).round(6).tolist()
    [0.6, 0.4, 0.2]
    """

    static: Any
    dynamic: Any
    arrival: Any
    fall: Any = 0.0

    _not_negative = ("static", "dynamic", "fall")

    def evolved(self, state: Array, speed: Array, time: float) -> Array:
        """Return the time since t = 0; see `Law.evolved`."""
        return state + time

    def strength(self, pressure: Array, speed: Array, state: Array) -> Array:
        """Return the strength at a time; see `Law.strength`."""
        since, fall = state - self.arrival, np.asarray(self.fall, dtype=float)
        gone = np.where(fall > 0, np.clip(since / np.where(fall > 0, fall, 1.0), 0, 1), since >= 0)
        friction = self.static + (self.dynamic - self.static) * gone
        return np.asarray(friction * pressure + 0 * speed)


@with_quantities
@dataclass(frozen=True, eq=False, repr=False)
class RateWeakening(DelayedLaw):
    """Friction that falls with slip rate: f_d + (f_s - f_d) / (1 + |V| / rate), times pressure.

    Parameters
    ----------
    static, dynamic : field
        Coefficients at rest and at high speed.
    rate : field
        Slip rate at which half the difference is lost [length / time].
    cohesion : field
        Strength without pressure [stress].
    delay, delay_slip : field
        Time [time] and slip [length] over which friction follows pressure; see `DelayedLaw`.

    Raises
    ------
    SceneError
        If a parameter is out of range.

    Examples
    --------
    >>> from semianalytic import RateWeakening
    >>> RateWeakening(0.6, 0.2, rate=1.0).strength(1.0, 1.0, 0.0)
    0.4
    """

    static: Any
    dynamic: Any
    rate: Any
    cohesion: Any = 0.0

    _not_negative = ("static", "dynamic", "cohesion")
    _positive = ("rate",)

    def strength(self, pressure: Array, speed: Array, state: Array) -> Array:
        """Return the strength at a speed; see `Law.strength`."""
        friction = self.dynamic + (self.static - self.dynamic) / (1 + speed / self.rate)
        return friction * pressure + self.cohesion

    def slip_speed(
        self, stopping: Array, pressure: Array, impedance: Array | float, state: Array
    ) -> Array:
        """Return the speed of balance; see `Law.slip_speed`."""
        # Multiplied by (V + rate), the balance is a quadratic in w = impedance V.
        excess = stopping - self.static * pressure - self.cohesion
        knee = impedance * self.rate
        linear = excess + (self.static - self.dynamic) * pressure - knee
        root = np.sqrt(np.maximum(linear**2 + 4 * knee * excess, 0.0))
        return np.where(excess > 0, (linear + root) / 2, 0.0) / impedance

    def rate_slopes(self, pressure: Array, speed: Array) -> tuple[Array, Array, Array, Array]:
        """Return the derivatives of strength; see `Law.rate_slopes`."""
        above, lost = speed + self.rate, self.static - self.dynamic
        first = -lost * self.rate / np.square(above) + 0 * pressure
        by_pressure = self.dynamic + lost * self.rate / above + 0 * pressure
        return by_pressure, pressure * first, first, -2 * pressure * first / above

    @cached_property
    def fall_with_rate(self) -> float:
        """Fall of strength per slip rate at rest, where it is largest; see `Law.fall_with_rate`."""
        return float((self.static - self.dynamic) / self.rate)
