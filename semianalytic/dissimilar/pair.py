"""Two half-planes of different solids with a slot, friction and loads."""

from __future__ import annotations

from dataclasses import dataclass, field

from semianalytic.dissimilar.compliance import Compliance, compliance_of
from semianalytic.scene.checks import checked_number, shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.friction import CoulombFriction, FrictionLaw, ViscousFriction
from semianalytic.scene.quantities import made_in_si, with_quantities
from semianalytic.scene.scene import Material, Scene, Tractions
from semianalytic.scene.units import SI

LARGEST_CONTRAST = 1e5
"""Largest ratio of moduli or densities; at 1e4 the canonical matrix keeps nine digits."""

TRACTIONS = ("base_pressure", "base_shear", "load_pressure", "load_shear")
_OF_BODIES = ("shear_modulus", "density", "poisson_ratio")
PARAMETERS = (
    "friction",
    "viscosity",
    *TRACTIONS,
    *_OF_BODIES,
    *(f"lower_{name}" for name in _OF_BODIES),
)
"""Parameters of a pair with respect to which there are derivatives; those of a body without
"lower_" are of the upper one."""


@with_quantities
@dataclass(frozen=True)
class Pair:
    """Two half-planes in contact on x > 0, with an open slot on x < 0, in plane strain.

    Conventions are those of a `Scene`: pressure is positive in compression, shear traction is
    sigma_xy on y = 0, slip is that of the upper face relative to the lower one.

    Parameters
    ----------
    upper, lower : Material
        The solids on y > 0 and y < 0.
    friction : float
        Coulomb friction coefficient f > 0.
    base : Tractions
        Uniform tractions (P_b, Q_b) on the whole line y = 0, in place before t = 0.
    load : Tractions
        Step (P_0, Q_0): at t = 0 the slot faces receive the traction change (-P_0, -Q_0).
    friction_law : CoulombFriction or ViscousFriction
        Strength f p, or f p + viscosity |V|.
    units : str
        "SI" if all numbers are in m, s, kg and Pa, or "" for any consistent set.

    Raises
    ------
    SceneError
        If a part is of another kind, friction is not positive, the base does not press the bodies
        together or already slides, or the solids differ by more than 1e5 in modulus or density.

    Examples
    --------
    >>> import semianalytic as sa
    >>> gouge, rock = sa.Material(12e9, 2300, 0.25), sa.Material(30e9, 2700, 0.25)
    >>> pair = sa.Pair(gouge, rock, 0.4, sa.Tractions(10e6, 0.0), sa.Tractions(0.0, 4e6))
    >>> pair.exchanged.upper == rock
    True
    """

    upper: Material
    lower: Material
    friction: float
    base: Tractions
    load: Tractions
    friction_law: FrictionLaw = field(default_factory=CoulombFriction)
    units: str = field(default="", compare=False)

    def __post_init__(self) -> None:
        if made_in_si(self) and not self.units:
            object.__setattr__(self, "units", SI)
        if self.units not in ("", SI):
            raise SceneError(f'pair: units must be "SI" or left out, got {shown(self.units)}.')
        for name, kind in (
            ("upper", Material),
            ("lower", Material),
            ("base", Tractions),
            ("load", Tractions),
        ):
            if not isinstance(getattr(self, name), kind):
                raise SceneError(
                    f"pair: {name} must be a {kind.__name__}, got {shown(getattr(self, name))}."
                )
        if not isinstance(self.friction_law, CoulombFriction | ViscousFriction):
            raise SceneError(
                "pair: between different solids friction_law must be CoulombFriction or "
                f"ViscousFriction, got {shown(self.friction_law)}."
            )
        friction = checked_number(
            "pair: friction", self.friction, "be positive and finite", lambda given: given > 0
        )
        object.__setattr__(self, "friction", friction)
        check_contrast(self.upper, self.lower, LARGEST_CONTRAST)
        strength = self.friction * self.base.pressure
        if not self.base.pressure > 0:
            raise SceneError(
                "pair: base pressure must be positive, for nothing else holds the bodies together "
                f"far ahead of the waves, got {self.base.pressure}."
            )
        # A base exactly at friction lets slip run ahead of all waves, a case that is solved for
        # identical bodies alone.
        if not abs(self.base.shear) < strength:
            raise SceneError(
                "pair: the interface would slide as a whole; lower the base shear below friction "
                f"times base pressure, {strength:.6g}, got {self.base.shear:.6g}."
            )

    @property
    def compliance(self) -> Compliance:
        """Compliance of both bodies, in units of slowness and modulus of the upper one."""
        return compliance_of(self.upper, self.lower)

    @property
    def alike(self) -> Scene:
        """The scene of the upper body on one of its own kind, with the same friction and load."""
        return Scene(
            self.upper,
            self.friction,
            self.base,
            self.load,
            friction_law=self.friction_law,
            units=self.units,
        )

    @property
    def exchanged(self) -> Pair:
        """The same pair described from below: bodies change places, and y and shear change sign."""
        # Seen from below y points the other way: sigma_xy changes its sign, sigma_yy does not.
        base, load = (Tractions(one.pressure, -one.shear) for one in (self.base, self.load))
        return Pair(
            self.lower, self.upper, self.friction, base, load, self.friction_law, self.units
        )


def check_contrast(upper: Material, lower: Material, largest: float) -> None:
    """Raise SceneError if moduli or densities differ by more than a factor of `largest`."""
    for name in ("shear_modulus", "density"):
        ratio = getattr(upper, name) / getattr(lower, name)
        if not 1 / largest <= ratio <= largest:
            raise SceneError(
                f"pair: {name} of the two bodies must not differ by more than a factor of "
                f"{largest:g}, got {max(ratio, 1 / ratio):.3g}."
            )
