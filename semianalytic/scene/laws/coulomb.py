"""Coulomb friction with cohesion and viscosity, which may follow pressure with a delay."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from semianalytic.scene.arrays import Array
from semianalytic.scene.laws.delay import LinearLaw
from semianalytic.scene.quantities import with_quantities


@with_quantities
@dataclass(frozen=True, eq=False, repr=False)
class Coulomb(LinearLaw):
    """Strength f p + cohesion + viscosity |V|, whatever the slip so far.

    Parameters
    ----------
    friction : field
        Coefficient f; a number, a function of x or a `Table`, like all parameters of laws.
    cohesion : field
        Strength without pressure [stress].
    viscosity : field
        Traction per slip rate [stress time / length].
    delay, delay_slip : field
        Time [time] and slip [length] over which friction follows pressure; see `DelayedLaw`.

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
    >>> round(float(slow.felt_pressure(10.0, 0.0, 1.0, 20.0, 20.0)), 6)  # 20 - 10 / e
    16.321206
    """

    friction: Any
    cohesion: Any = 0.0
    viscosity: Any = 0.0

    _not_negative = ("friction", "cohesion", "viscosity")

    def strength(self, pressure: Array, speed: Array, state: Array) -> Array:
        """Return f p + cohesion + viscosity |V|; see `Law.strength`."""
        return self.friction * pressure + self.cohesion + self.viscosity * speed

    def rate_slopes(self, pressure: Array, speed: Array) -> tuple[Array, Array, Array, Array]:
        """Return the derivatives of strength; see `Law.rate_slopes`."""
        none = 0.0 * (pressure + speed)
        return none + self.friction, none + self.viscosity, none, none
