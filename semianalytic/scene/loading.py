"""Loads as a superposition: tractions in place on the interface, and tractions taken off the slot.

All solvers take a load as this superposition.  The uncut line
y = 0 carries tractions "in place".  The slot is made by taking tractions off its faces, from which
waves run out.  A load on the slot leaves the base in place and takes the load off.  A load from far
away is a plane wave of normal incidence that both half-planes would let through as one body: from
t = 0 on the whole line carries base and load, and the load is taken off the slot faces, which keep
the base.  A wave that arrives at an angle, or a load that moves over the slot, does the same behind
a front t = p x of slowness p (`Scene.front_slowness`, semianalytic/scene/incident.py).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

from semianalytic.scene.arguments import checking_methods
from semianalytic.scene.checks import check_fields, checked_number, checked_size
from semianalytic.scene.errors import SceneError
from semianalytic.scene.material import Material
from semianalytic.scene.quantities import with_quantities

SLOT, REMOTE = "slot", "remote"
LOADED = (SLOT, REMOTE)
"""Places of a load: it is taken off the slot faces, or arrives as a plane wave from far away."""


@checking_methods
@with_quantities
@dataclass(frozen=True)
class Tractions:
    """A pair of tractions [stress]: pressure (positive in compression) and shear.

    Parameters
    ----------
    pressure : float or field
        Contact pressure, positive in compression [stress]; a number, or for marches also a function
        of x or a `Table`.
    shear : float or field
        Shear traction sigma_xy on y = 0, sigma_yz in antiplane shear [stress].

    Raises
    ------
    SceneError
        If one is neither a finite number nor a function.

    Examples
    --------
    >>> from semianalytic import Tractions
    >>> Tractions(pressure=5e6, shear=1e6)
    Tractions(pressure=5000000.0, shear=1000000.0)
    """

    pressure: Any = 0.0
    shear: Any = 0.0

    def __post_init__(self) -> None:
        numbers = [name for name in ("pressure", "shear") if not callable(getattr(self, name))]
        check_fields(self, "tractions", numbers)

    def plus(self, other: Tractions) -> Tractions:
        """Return the sum of two pairs of tractions."""
        return Tractions(self.pressure + other.pressure, self.shear + other.shear)

    def tractions(self, material: Material) -> Tractions:
        """Return the tractions of this load, the same in any solid."""
        return self

    def slowness(self, material: Material) -> float:
        """Return the slowness of its front along x, 0: it acts everywhere at once."""
        return 0.0


@checking_methods
class LineLoad:
    """A load of its own kind, which says itself where it acts; the base of those below."""

    pressure: float
    shear: float

    def tractions(self, material: Material) -> Tractions:
        """Return its pressure and shear, in any solid."""
        return Tractions(self.pressure, self.shear)

    def slowness(self, material: Material) -> float:
        """Return the slowness of its front along x; 0, since it has no front that moves over the
        slot.
        """
        return 0.0


@with_quantities
@dataclass(frozen=True)
class Patch(LineLoad):
    """Tractions that act suddenly on the interval |x| < speed * t, which grows from a point.

    Parameters
    ----------
    speed : float
        Speed w > 0 of either end of the patch [length / time].
    pressure, shear : float
        Change of pressure and of shear traction sigma_xy that the interface would carry on the
        patch if it stuck [stress].

    Raises
    ------
    SceneError
        If the speed is not positive, or a number is not finite.

    Examples
    --------
    >>> import semianalytic as sa
    >>> sa.Patch(speed=0.3, shear=1.0)
    Patch(speed=0.3, pressure=0.0, shear=1.0)
    """

    speed: float
    pressure: float = 0.0
    shear: float = 0.0

    def __post_init__(self) -> None:
        if isinstance(self.speed, int | float) and self.speed == 0:
            raise SceneError(
                "patch: its ends must move; for a load on a fixed interval give an "
                "InterfaceLoad, a function of x, and the contact of the scene."
            )
        check_fields(self, "patch", ("speed",), checked_size)
        check_fields(self, "patch", ("pressure", "shear"))


@dataclass(frozen=True)
class PointForce(LineLoad):
    """A line force on the interface at x = 0 that grows linearly in time, F = rate * t.

    It is the limit of a `Patch` whose speed tends to 0 at constant rate = 2 * speed * stress.

    Parameters
    ----------
    pressure, shear : float
        Rates of the force per unit depth across and along the interface [stress length / time];
        a negative pressure pulls the sides apart.

    Raises
    ------
    SceneError
        If a number is not finite.

    Examples
    --------
    >>> import semianalytic as sa
    >>> sa.PointForce(shear=1.0)
    PointForce(pressure=0.0, shear=1.0)
    """

    pressure: float = 0.0
    shear: float = 0.0

    def __post_init__(self) -> None:
        check_fields(self, "point force", ("pressure", "shear"))


@with_quantities
@dataclass(frozen=True)
class HalfLine(LineLoad):
    """Tractions that act suddenly on all of x < 0.

    Parameters
    ----------
    pressure, shear : float
        Change of pressure and of shear traction sigma_xy that the interface would carry on x < 0
        if it stuck [stress].

    Raises
    ------
    SceneError
        If a number is not finite.

    Examples
    --------
    >>> import semianalytic as sa
    >>> sa.HalfLine(shear=1.0)
    HalfLine(pressure=0.0, shear=1.0)
    """

    pressure: float = 0.0
    shear: float = 0.0

    def __post_init__(self) -> None:
        check_fields(self, "half-line", ("pressure", "shear"))


@dataclass(frozen=True)
class GrowingLoad(LineLoad):
    """Tractions that grow as a power of time: pressure P_0 t^n everywhere, shear Q_0 t^n.

    The pressure acts evenly on contact and slot faces, so that the slot does not disturb it; the
    slot faces x < 0 receive the change of shear traction -Q_0 t^n.  Strength and load keep their
    ratio, and edges their speeds.

    Parameters
    ----------
    pressure, shear : float
        P_0 > 0 and Q_0 [stress / time^n].
    power : 1 or 2
        n; a step, n = 0, is `Tractions`.

    Raises
    ------
    SceneError
        If a number is out of range.

    Examples
    --------
    >>> import semianalytic as sa
    >>> sa.GrowingLoad(2e6, 1e6)
    GrowingLoad(pressure=2000000.0, shear=1000000.0, power=1)
    """

    pressure: float
    shear: float
    power: int = 1

    def __post_init__(self) -> None:
        check_fields(self, "growing load", ("pressure", "shear"))
        power = checked_number(
            "growing load: power",
            self.power,
            "be 1 or 2 (a step is Tractions, other histories are marched)",
            lambda given: given in (1, 2),
        )
        object.__setattr__(self, "power", int(power))
        if not self.pressure > 0:
            raise SceneError(
                "growing load: pressure must be positive, because strength is proportional to it, "
                f"got {self.pressure:.6g}."
            )
        if not self.shear:
            raise SceneError("growing load: without shear nothing slips; give load a shear.")


WITHOUT_SLOT = Patch | PointForce | HalfLine
"""Loads of two bodies in contact along the whole line."""


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
