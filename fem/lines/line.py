"""The description of a periodic interface at the nodes of a mesh."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from semianalytic.scene.arrays import Array, Mask
from semianalytic.scene.laws.law import Law
from semianalytic.scene.material import Material

Tractions = Callable[..., tuple[Array, Array]]
"""Function of a time that returns the traction of the uncut line and that of slot faces, (n,) each;
with ``after=True`` their values after a jump at that time."""


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
    friction : Law
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
    shares : pair of (n,) arrays, optional
        Lengths of contact and of slot that belong to each node [length]; by default all of a node
        is one of them.
    """

    upper: Material
    lower: Material
    length: float
    x: Array
    touching: Mask
    friction: Law
    state: Array
    shear: Tractions
    pressure: Tractions
    opens: bool = False
    antiplane: bool = False
    plate_rate: float = 0.0
    shares: tuple[Array, Array] | None = None

    @property
    def lengths(self) -> tuple[Array, Array]:
        """Lengths of contact and of slot that belong to each node, (n,) [length]."""
        if self.shares is not None:
            return self.shares
        contact = np.where(self.touching, self.spacing, 0.0)
        return contact, self.spacing - contact

    @property
    def slots(self) -> Mask:
        """Whether some of a node's length is slot, (n,)."""
        return self.lengths[1] > 0

    @property
    def spacing(self) -> float:
        """Distance h of the nodes [length]."""
        return self.length / len(self.x)

    @property
    def is_odd(self) -> bool:
        """Whether the lower body moves oppositely to the upper one, so that one is enough."""
        return self.upper == self.lower and not self.opens
