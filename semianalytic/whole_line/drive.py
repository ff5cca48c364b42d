"""The part of a load that drives slip, or opening, of bodies in contact along a whole line."""

from __future__ import annotations

from dataclasses import dataclass, replace

from semianalytic.scene.errors import SceneError
from semianalytic.scene.line.contact import Contact
from semianalytic.scene.loading import LineLoad, PointForce, Tractions
from semianalytic.scene.scene import Scene


@dataclass(frozen=True)
class Drive:
    """The stresses that drive motion of a whole line, without a slot.

    Shear beyond friction makes the interface slip; tension beyond the base pressure makes it open,
    where no shear acts.

    Parameters
    ----------
    scene : Scene
        Its load is a `Patch`, a `PointForce` or a `HalfLine`.

    Raises
    ------
    SceneError
        If its law or bodies are of another kind, strength is negative, the base alone makes the
        interface slide, the load opens the interface and shears it too, or it moves nothing.

    Examples
    --------
    >>> import semianalytic as sa
    >>> solid, base = sa.Material(1.0, 1.0, 1 / 3), sa.Tractions(1.0, 0.0)
    >>> drive = Drive(sa.Scene(solid, 0.5, base, sa.Patch(speed=0.3, shear=1.0)))
    >>> drive.excess, drive.missing
    (1.0, 0.5)
    """

    scene: Scene

    def __post_init__(self) -> None:
        check_law(self.scene, "whole line")
        if not self.base.pressure > 0:
            raise SceneError(
                "whole line: base pressure must be positive, or strength is negative, got "
                f"{self.base.pressure:.6g}."
            )
        self._check_base()
        self._check_load()

    @property
    def base(self) -> Tractions:
        """Tractions in place before t = 0."""
        return self.scene.base

    @property
    def load(self) -> LineLoad:
        """The load of the scene."""
        assert isinstance(self.scene.load, LineLoad)
        return self.scene.load

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
    def opens(self) -> bool:
        """Whether the load pulls the sides apart."""
        if isinstance(self.load, PointForce):
            return self.load.pressure < 0
        return self.base.pressure + self.load.pressure < 0

    @property
    def strength(self) -> float:
        """Shear that the interface bears outside of the load, f P_b [stress]."""
        return self.scene.coefficient * self.base.pressure

    @property
    def sense(self) -> int:
        """+1 where the upper side slips towards +x, -1 towards -x; 0 where the interface opens."""
        if self.opens:
            return 0
        # Next to a point force its own shear is infinite, and sets the sense whatever the base is.
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
        return self.sense * self.load.shear - self.scene.coefficient * self.load.pressure

    @property
    def missing(self) -> float:
        """The drive d > 0 that the base lacks [stress]: f P_b - s Q_b to slip, P_b to open."""
        return self.base.pressure if self.opens else self.strength - self.sense * self.base.shear


def check_law(scene: Scene, owner: str) -> None:
    """Raise SceneError unless bodies are equal and friction is constant, as closed forms need."""
    if scene.lower_material is not None or not isinstance(scene.friction, float):
        raise SceneError(
            f"{owner}: the closed form is of equal bodies and constant friction; leave out "
            "lower_material and the friction law, or march an interface (docs/engine.md)."
        )


def slot_scene(drive: Drive) -> Scene:
    """Return the scene with a slot on x < 0 that moves on x > 0 as under a `HalfLine`.

    On x < 0 the interface slips at once and its shear falls to the strength.  Slot faces move in
    the same way under a load equal to that fall.

    Examples
    --------
    >>> import semianalytic as sa
    >>> solid, base = sa.Material(1.0, 1.0, 1 / 3), sa.Tractions(1.0, 0.0)
    >>> slot_scene(Drive(sa.Scene(solid, 0.5, base, sa.HalfLine(shear=1.0)))).load
    Tractions(pressure=0.0, shear=0.5)
    """
    # Slip takes the shear from base plus load down to the strength: this fall radiates.
    drop = drive.excess - drive.missing
    load = Tractions(-drop, 0.0) if drive.opens else Tractions(0.0, drive.sense * drop)
    return replace(drive.scene, load=load, contact=Contact.half_line())
