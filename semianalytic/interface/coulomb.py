"""Coulomb friction with cohesion and viscosity, which may follow pressure with a delay."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from semianalytic.interface.law import InterfaceLaw, not_negative

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Coulomb(InterfaceLaw):
    """Strength f p + cohesion + viscosity |V|, whatever the slip so far.

    With a delay, friction follows a pressure p' that lags behind p (Prakash and Clifton 1993,
    simplified): dp'/dt = (p - p') (1/delay + |V|/delay_slip), where a delay of 0 is left out.
    The state of the law is p' then.  Between different bodies only this makes most friction
    well-posed (docs/dissimilar.md).

    Parameters
    ----------
    friction : field
        Coefficient f; a number, a function of x or a `Table`, like all parameters of laws.
    cohesion : field
        Strength without pressure [stress].
    viscosity : field
        Traction per slip rate [stress time / length].
    delay : field
        Time t* in which friction follows pressure [time]; 0 for none.
    delay_slip : field
        Slip L over which friction follows pressure [length]; 0 for none.

    Raises
    ------
    SceneError
        If a parameter is negative or not finite.

    Examples
    --------
    >>> from semianalytic import Coulomb
    >>> Coulomb(0.6, cohesion=1.0, viscosity=0.5).strength(10.0, 2.0, 0.0)
    8.0
    >>> slow = Coulomb(0.6, delay=1.0)
    >>> round(float(slow.evolved_under(10.0, 0.0, 1.0, 20.0, 20.0)), 6)  # 20 - 10 / e
    16.321206
    """

    friction: Any
    cohesion: Any = 0.0
    viscosity: Any = 0.0
    delay: Any = 0.0
    delay_slip: Any = 0.0

    def __post_init__(self) -> None:
        not_negative(
            "Coulomb",
            friction=self.friction,
            cohesion=self.cohesion,
            viscosity=self.viscosity,
            delay=self.delay,
            delay_slip=self.delay_slip,
        )

    @property
    def is_delayed(self) -> bool:
        """Whether friction lags behind the pressure anywhere."""
        return any(callable(one) or np.any(one) for one in (self.delay, self.delay_slip))

    def strength(self, pressure: Array, speed: Array, state: Array) -> Array:
        """Return f p + cohesion + viscosity |V|; see `InterfaceLaw.strength`."""
        felt = state if self.is_delayed else pressure
        return self.friction * felt + self.cohesion + self.viscosity * speed

    def slip_speed(self, stopping: Array, pressure: Array, impedance: float, state: Array) -> Array:
        """Return the speed of balance; see `InterfaceLaw.slip_speed`."""
        dry = self.strength(pressure, np.zeros(np.shape(pressure)), state)
        return np.maximum(stopping - dry, 0.0) / (impedance + self.viscosity)

    def rate_slope(self, pressure: Array, speed: Array, state: Array) -> Array:
        """Return the viscosity; see `InterfaceLaw.rate_slope`."""
        return np.broadcast_to(np.asarray(self.viscosity, dtype=float), pressure.shape)

    def pressure_delay(self, speed: Array) -> Any:
        """Return the time in which friction follows pressure; see `InterfaceLaw.pressure_delay`."""
        if not self.is_delayed:
            return 0.0
        with np.errstate(divide="ignore"):
            return 1 / self._pace(speed)

    def _pace(self, speed: Array) -> Array:
        """Return 1/delay + |V|/delay_slip [1 / time]; inf where there is no delay at all."""
        delay, slip = np.asarray(self.delay, dtype=float), np.asarray(self.delay_slip, dtype=float)
        with np.errstate(divide="ignore", invalid="ignore"):
            own = np.where(delay > 0, 1 / delay, np.where(slip > 0, 0.0, np.inf))
            return np.asarray(own + np.where(slip > 0, speed / slip, 0.0))

    def start(self, pressure: Array, shear: Array, speed: Array) -> Array:
        """Return the pressure that friction follows at t = 0; see `InterfaceLaw.start`."""
        return np.array(pressure) if self.is_delayed else np.zeros(len(pressure))

    def evolved_under(
        self, state: Array, speed: Array, time: float, before: Array, after: Array
    ) -> Array:
        """Return the state after a time, exactly; see `InterfaceLaw.evolved_under`."""
        if not self.is_delayed:
            return self.evolved(state, speed, time)
        lag = np.asarray(self._pace(speed) * time)
        left = np.exp(-lag)
        # Mean of exp(-lag s) over the step: the share of the pressure at its end that is missing.
        with np.errstate(invalid="ignore", divide="ignore"):
            mean = np.where(lag > 1e-8, -np.expm1(-lag) / lag, 1 - lag / 2)
            mean = np.where(lag < np.inf, mean, 0.0)
        return np.asarray(left * state + (mean - left) * before + (1 - mean) * after)
