"""The friction of a scene as a law of the march."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from semianalytic.interface.law import InterfaceLaw
from semianalytic.scene.friction import (
    CoulombFriction,
    FrictionLaw,
    RateFriction,
    SlipWeakening,
    ViscousFriction,
)

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SceneFriction(InterfaceLaw):
    """The friction law of a scene, whose state is the accumulated |slip|, and its coefficient."""

    given: FrictionLaw
    friction: float

    def strength(self, pressure: Array, speed: Array, state: Array) -> Array:
        """Return the strength; see `InterfaceLaw.strength`."""
        return self.given.strength(self.friction * pressure, speed, state)

    def slip_speed(self, stopping: Array, pressure: Array, impedance: float, state: Array) -> Array:
        """Return the speed of balance; see `InterfaceLaw.slip_speed`."""
        return self.given.slip_speed(stopping, self.friction * pressure, impedance, state)

    def steady_slope(self) -> Any:
        """Return the viscosity, or None; see `InterfaceLaw.steady_slope`."""
        if type(self.given) is ViscousFriction:
            return self.given.viscosity
        return 0.0 if type(self.given) in (CoulombFriction, SlipWeakening) else None

    @property
    def follows_state(self) -> bool:
        """Whether strength may depend on the path; only these laws are known not to ask for it."""
        return not isinstance(self.given, CoulombFriction | RateFriction)
