"""Loads as a superposition: tractions in place on the interface, and tractions taken off the slot.

All solvers take a load as this superposition (docs/theory.md, "Setting and signs").  The uncut line
y = 0 carries tractions "in place".  The slot is made by taking tractions off its faces, from which
waves run out.  A load on the slot leaves the base in place and takes the load off.  A load from far
away is a plane wave of normal incidence that both half-planes would let through as one body: from
t = 0 on the whole line carries base and load, and the load is taken off the slot faces, which keep
the base.  A wave that arrives at an angle, or a load that moves over the slot, does the same behind
a front t = p x of slowness p (`Scene.front_slowness`, semianalytic/scene/incident.py).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from semianalytic.scene.checks import check_fields
from semianalytic.scene.material import Material
from semianalytic.scene.quantities import with_quantities

SLOT, REMOTE = "slot", "remote"
LOADED = (SLOT, REMOTE)
"""Places of a load: it is taken off the slot faces, or arrives as a plane wave from far away."""


@with_quantities
@dataclass(frozen=True)
class Tractions:
    """A uniform pair of tractions [stress]: pressure (positive in compression) and shear.

    Parameters
    ----------
    pressure : float
        Contact pressure, positive in compression [stress].
    shear : float
        Shear traction sigma_xy on y = 0, sigma_yz in antiplane shear [stress].

    Raises
    ------
    SceneError
        If one is not a finite number.

    Examples
    --------
    >>> from semianalytic import Tractions
    >>> Tractions(pressure=5e6, shear=1e6)
    Tractions(pressure=5000000.0, shear=1000000.0)
    """

    pressure: float
    shear: float

    def __post_init__(self) -> None:
        check_fields(self, "tractions", ("pressure", "shear"))

    def plus(self, other: Tractions) -> Tractions:
        """Return the sum of two pairs of tractions."""
        return Tractions(self.pressure + other.pressure, self.shear + other.shear)

    def tractions(self, material: Material) -> Tractions:
        """Return the tractions of this load, themselves in any solid."""
        return self

    def slowness(self, material: Material) -> float:
        """Return the slowness of its front along x, 0: it comes everywhere at once."""
        return 0.0


class Superposition(NamedTuple):
    """A load in the form in which all solvers take it.

    Attributes
    ----------
    in_place : Tractions
        Tractions of the contact from t = 0 on, or behind the front of a wave that arrives at an
        angle, ahead of the waves from the slot.
    taken_off : Tractions
        Tractions taken off the slot faces, each to be multiplied by its history f(t).
    """

    in_place: Tractions
    taken_off: Tractions
