"""The description of a periodic interface at the nodes of a mesh."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from semianalytic.scene.material import Material

Array = NDArray[np.float64]
Tractions = Callable[..., tuple[Array, Array]]
"""Function of a time that returns the traction of the uncut line and that of slot faces, (n,) each;
with ``after=True`` their values after a jump at that time."""


class Friction(Protocol):
    """Strength of an interface at the nodes of its contact, and the evolution of its state.

    All arguments and results are arrays (contact,).
    """

    has_threshold: bool
    """Whether the interface sticks below its strength at rest."""

    def strength(self, pressure: Array, speed: Array, state: Array) -> Any:
        """Return the shear traction that is carried at a speed |V| >= 0 [stress]."""

    def evolved_under(
        self, state: Array, speed: Array, time: float, before: Array, after: Array
    ) -> Any:
        """Return the state after a time at a mean speed, under a pressure that changes."""

    def felt_pressure(
        self, felt: Array, speed: Array, time: float, before: Array, after: Array
    ) -> Array:
        """Return the pressure that friction follows after a time at a mean speed."""


@dataclass(frozen=True, eq=False)
class Line:
    """An interface on a periodic line, described at evenly spaced nodes.

    Parameters
    ----------
    upper : Material
        The solid on y > 0.
    lower : Material
        The solid on y < 0.
    length : float
        Period of the line [length].
    x : (n,) array
        Positions of nodes [length], length / n apart.
    touching : (n,) array of bool
        Whether the bodies touch there; the rest is slot.
    friction : Friction
        Law of the nodes that touch.
    state : (contact,) array
        Its state at t = 0.
    shear, pressure : Tractions
        Tractions over time; changes of pressure may open the contact.
    opens : bool
        Whether loads or slip change the pressure.
    antiplane : bool
        Whether slip is along z.
    plate_rate : float
        Slip rate of the bodies far away [length / time], at which they move at t = 0.
    """

    upper: Material
    lower: Material
    length: float
    x: Array
    touching: NDArray[np.bool_]
    friction: Friction
    state: Array
    shear: Tractions
    pressure: Tractions
    opens: bool = False
    antiplane: bool = False
    plate_rate: float = 0.0

    @property
    def spacing(self) -> float:
        """Distance h of the nodes [length]."""
        return self.length / len(self.x)

    @property
    def is_odd(self) -> bool:
        """Whether the lower body moves oppositely to the upper one, so that one is enough."""
        return self.upper == self.lower and not self.opens
