"""Friction that follows a change of pressure with a delay."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, ClassVar

import numpy as np

from semianalytic.scene.arrays import Array
from semianalytic.scene.checks import finite
from semianalytic.scene.laws.law import Law, not_negative, positive


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class DelayedLaw(Law):
    """A law whose friction may follow a pressure p' that lags behind the contact pressure p.

    dp'/dt = (p - p') (1/delay + |V|/delay_slip), where a delay of 0 is left out (Prakash and
    Clifton 1993, simplified).  Between different bodies only this makes most friction well-posed.

    Parameters
    ----------
    delay : field
        Time t* in which friction follows pressure [time]; 0 for none.
    delay_slip : field
        Slip L over which friction follows pressure [length]; 0 for none.

    Raises
    ------
    SceneError
        If one of them is negative or not finite.
    """

    delay: Any = 0.0
    delay_slip: Any = 0.0

    # fields of the law that have to be 0 or more, and above 0
    _not_negative: ClassVar[tuple[str, ...]] = ()
    _positive: ClassVar[tuple[str, ...]] = ()

    def __post_init__(self) -> None:
        # The class is frozen; numbers are stored as plain floats, whatever their type was.
        for field in fields(self):
            if (number := finite(getattr(self, field.name))) is not None:
                object.__setattr__(self, field.name, number)
        owner = type(self).__name__
        names = ("delay", "delay_slip", *self._not_negative)
        not_negative(owner, **{name: getattr(self, name) for name in names})
        positive(owner, **{name: getattr(self, name) for name in self._positive})

    def pressure_delay(self, speed: Array) -> Any:
        """Return the time in which friction follows pressure; see `Law.pressure_delay`."""
        if not any(callable(value) or np.any(value) for value in (self.delay, self.delay_slip)):
            return 0.0
        delay, slip = np.asarray(self.delay, dtype=float), np.asarray(self.delay_slip, dtype=float)
        own = np.where(delay > 0, 1 / delay, np.where(slip > 0, 0.0, np.inf))
        return 1 / (own + np.where(slip > 0, speed / slip, 0.0))


class LinearLaw(DelayedLaw):
    """A law whose strength rises linearly with slip rate, by a viscosity, or not at all."""

    viscosity: Any = 0.0
    fall_with_rate = 0.0

    def steady_slope(self) -> Any:
        """Return the viscosity; see `Law.steady_slope`."""
        return self.viscosity
