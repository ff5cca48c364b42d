"""Identical half-planes in contact along a whole line, and the loads that make it slip or open."""

from __future__ import annotations

from dataclasses import dataclass

from semianalytic.scene.checks import check_fields, checked_number, checked_size, shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.scene import ANTIPLANE, IN_PLANE, MODES, Material, Scene, Tractions
from semianalytic.scene.units import SI


@dataclass(frozen=True)
class Patch:
    """Tractions that act at once on a stretch |x| < speed * t, which grows from a point.

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
        object.__setattr__(self, "speed", checked_size("patch: speed", self.speed))
        check_fields(self, "patch", ("pressure", "shear"))


@dataclass(frozen=True)
class PointForce:
    """A line force on the interface at x = 0 that grows evenly in time, F = rate * t.

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


@dataclass(frozen=True)
class HalfLine:
    """Tractions that act at once on all of x < 0.

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


LineLoad = Patch | PointForce | HalfLine
LOADS: dict[str, type[LineLoad]] = {
    "patch": Patch,
    "point-force": PointForce,
    "half-line": HalfLine,
}
"""Kinds of load on a whole line, as scene files name them."""


@dataclass(frozen=True)
class WholeLine:
    """Two half-planes of one solid in contact along the whole line y = 0, without a slot.

    Conventions are those of a `Scene`: pressure is positive in compression, shear traction is
    sigma_xy on y = 0, or sigma_yz in antiplane shear, slip is that of the upper side relative to
    the lower one.  Shear beyond friction makes the interface slip; tension beyond the base pressure
    makes it open, where no shear acts.

    Parameters
    ----------
    material : Material
    friction : float
        Coulomb friction coefficient f >= 0.
    base : Tractions
        Uniform tractions (P_b, Q_b) in place before t = 0, P_b > 0.
    load : Patch, PointForce or HalfLine
    mode : "in-plane" or "antiplane"
        Direction of shear and slip.
    units : "" or "SI"

    Raises
    ------
    SceneError
        If a part is of another kind, strength is negative, the base alone makes the interface
        slide, the load opens the interface and shears it too, or it moves nothing.

    Examples
    --------
    >>> import semianalytic as sa
    >>> solid, base = sa.Material(1.0, 1.0, 1 / 3), sa.Tractions(1.0, 0.0)
    >>> line = sa.WholeLine(solid, 0.5, base, sa.Patch(speed=0.3, shear=1.0))
    >>> line.excess, line.missing
    (1.0, 0.5)
    """

    material: Material
    friction: float
    base: Tractions
    load: LineLoad
    mode: str = IN_PLANE
    units: str = ""

    def __post_init__(self) -> None:
        for name, kinds, called in (
            ("material", Material, "a Material"),
            ("base", Tractions, "Tractions"),
            ("load", LineLoad, "a Patch, a PointForce or a HalfLine"),
        ):
            if not isinstance(getattr(self, name), kinds):
                given = getattr(self, name)
                hint = ""
                if name == "load" and isinstance(given, Tractions):
                    hint = "; tractions on the faces of a slot belong to a Scene, which has a slot"
                raise SceneError(f"whole line: {name} must be {called}, got {shown(given)}{hint}.")
        friction = checked_number(
            "whole line: friction", self.friction, "not be negative", lambda given: given >= 0
        )
        object.__setattr__(self, "friction", friction)
        if self.mode not in MODES:
            raise SceneError(
                f"whole line: mode must be {' or '.join(MODES)}, got {shown(self.mode)}."
            )
        if self.units not in ("", SI):
            raise SceneError(
                f"whole line: units must be {SI!r} or left out, got {shown(self.units)}."
            )
        if not self.base.pressure > 0:
            raise SceneError(
                "whole line: base pressure must be positive, or strength is negative, got "
                f"{self.base.pressure:.6g}."
            )
        self._check_base()
        self._check_load()

    def _check_base(self) -> None:
        """Raise SceneError if the base alone slides, or what opens is sheared."""
        if self.opens:
            if self.load.shear or self.base.shear:
                raise SceneError(
                    "whole line: the load opens the interface, and nothing would resist this shear "
                    f"there; raise the base pressure above {-self.load.pressure:.6g}, or set the "
                    "shear of base and load to 0."
                )
        elif not abs(self.base.shear) < self.strength:
            raise SceneError(
                "whole line: the interface would slide as a whole; lower the base shear below "
                f"friction times base pressure, {self.strength:.6g}, got {self.base.shear:.6g}."
            )

    def _check_load(self) -> None:
        """Raise SceneError if the load moves nothing, or is one that has no answer."""
        if isinstance(self.load, PointForce):
            if self.load.shear and self.load.pressure:
                raise SceneError(
                    "whole line: under a point force with both pressure and shear the pressure is "
                    "infinite where slip starts; set its pressure or its shear to 0."
                )
            if not (self.load.shear or self.load.pressure < 0):
                raise SceneError(
                    "whole line: the point force moves nothing; give it a shear, or a negative "
                    "pressure."
                )
        elif not self.excess > self.missing:
            raise SceneError(
                f"whole line: nothing slips, because the load adds {self.excess:.6g} to the shear "
                f"that drives slip, and the base lacks {self.missing:.6g} to overcome friction; "
                "raise the load, or lower friction."
            )

    @property
    def antiplane(self) -> bool:
        """Whether shear and slip are along z."""
        return self.mode == ANTIPLANE

    @property
    def opens(self) -> bool:
        """Whether the load pulls the sides apart."""
        if isinstance(self.load, PointForce):
            return self.load.pressure < 0
        return self.base.pressure + self.load.pressure < 0

    @property
    def strength(self) -> float:
        """Shear that the interface bears outside of the load, f P_b [stress]."""
        return self.friction * self.base.pressure

    @property
    def sense(self) -> int:
        """+1 where the upper side slips towards +x, -1 towards -x; 0 where the interface opens."""
        if self.opens:
            return 0
        # Beside a point force its own shear is infinite, and sets the sense whatever the base is.
        share = 0.0 if isinstance(self.load, PointForce) else self.base.shear
        return 1 if share + self.load.shear >= 0 else -1

    @property
    def excess(self) -> float:
        """The drive S of the motion that the load adds [stress]; F_0 for a point force.

        It is s Q - f P where the interface slips in the sense s, and -P where it opens.
        """
        if self.opens:
            return -self.load.pressure
        # Pressure of the load raises the strength, and so lowers the drive.
        return self.sense * self.load.shear - self.friction * self.load.pressure

    @property
    def missing(self) -> float:
        """The drive d > 0 that the base lacks [stress]: f P_b - s Q_b to slip, P_b to open."""
        return self.base.pressure if self.opens else self.strength - self.sense * self.base.shear

    @property
    def slot_scene(self) -> Scene:
        """The scene with a slot on x < 0 that moves in the same way on x > 0 as this half-line.

        On x < 0 the interface slips at once and its shear falls to the strength.  Slot faces move
        in the same way under a load equal to that fall.

        Raises
        ------
        SceneError
            If the load is not a `HalfLine`.

        Examples
        --------
        >>> import semianalytic as sa
        >>> solid, base = sa.Material(1.0, 1.0, 1 / 3), sa.Tractions(1.0, 0.0)
        >>> line = sa.WholeLine(solid, 0.5, base, sa.HalfLine(shear=1.0))
        >>> line.slot_scene.load
        Tractions(pressure=0.0, shear=0.5)
        """
        if not isinstance(self.load, HalfLine):
            raise SceneError("slot_scene: only a HalfLine moves like a slot.")
        # Slip takes the shear from base plus load down to the strength: this fall radiates.
        drop = self.excess - self.missing
        load = Tractions(-drop, 0.0) if self.opens else Tractions(0.0, self.sense * drop)
        given = self.material, self.friction, self.base, load
        return Scene(*given, mode=self.mode, units=self.units)
