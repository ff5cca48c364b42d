"""The solid on both sides of the interface, and the speeds of its waves."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

from semianalytic.scene.checks import check_fields, checked_number, checked_size
from semianalytic.scene.errors import SceneError
from semianalytic.scene.quantities import in_si, is_quantity, made_in_si, with_quantities
from semianalytic.scene.units import InSI

_RATIO = "lie strictly between -1 and 0.5"


def _is_ratio(given: float) -> bool:
    return -1 < given < 0.5


@with_quantities
@dataclass(frozen=True)
class Material:
    """Isotropic linear elastic solid of both bodies, or of one of two.

    Parameters
    ----------
    shear_modulus : float
        Shear modulus [stress], positive.
    density : float
        Mass density [mass / length^3], positive.
    poisson_ratio : float
        Poisson ratio, -1 < poisson_ratio < 0.5.

    Raises
    ------
    SceneError
        If a parameter is not a finite number or outside its range.

    Examples
    --------
    >>> from semianalytic import Material
    >>> steel = Material(shear_modulus=80e9, density=7800.0, poisson_ratio=0.25)
    >>> round(steel.shear_speed), round(steel.longitudinal_speed)
    (3203, 5547)
    >>> round(steel.rayleigh_speed / steel.shear_speed, 4)
    0.9194
    """

    shear_modulus: float
    density: float
    poisson_ratio: float

    def __post_init__(self) -> None:
        check_fields(self, "material", ("shear_modulus", "density"), checked_size)
        check_fields(self, "material", ("poisson_ratio",), checked_number, _RATIO, _is_ratio)

    @classmethod
    def from_young(cls, E: float, nu: float, rho: float) -> Material:
        """Make a solid of Young's modulus E [stress], Poisson ratio nu and density rho.

        Its shear modulus is E / (2 (1 + nu)).

        Raises
        ------
        SceneError
            If a number is out of range.

        Examples
        --------
        >>> from semianalytic import Material
        >>> Material.from_young(E=200e9, nu=0.25, rho=7800.0).shear_modulus
        80000000000.0
        """
        if not is_quantity(E):
            checked_size("material: E", E)
        ratio = checked_number("material: nu", nu, _RATIO, _is_ratio)
        return cls(E / (2 * (1 + ratio)), rho, ratio)

    @classmethod
    def from_speeds(cls, c_l: float, c_t: float, rho: float) -> Material:
        """Make a solid of the speeds of its pressure and shear waves [length / time] and density.

        Its shear modulus is rho c_t^2, its Poisson ratio (r - 2) / (2 r - 2), r = (c_l/c_t)^2.

        Raises
        ------
        SceneError
            If a number is out of range, or c_l is not above c_t sqrt(4/3), where nu is -1.

        Examples
        --------
        >>> from semianalytic import Material
        >>> Material.from_speeds(c_l=2000.0, c_t=1000.0, rho=1000.0)
        Material(shear_modulus=1000000000.0, density=1000.0, poisson_ratio=0.3333333333333333)
        """
        given = {"c_l": (c_l, "length / time"), "c_t": (c_t, "length / time")}
        given["rho"] = rho, "mass / length^3"
        fast, slow, density = (
            checked_size(f"material: {name}", in_si(f"material: {name}", value, dimension))
            for name, (value, dimension) in given.items()
        )
        square = (fast / slow) ** 2
        if not square > 4 / 3:
            raise SceneError(
                f"material: c_l must be above c_t sqrt(4/3) = {slow * math.sqrt(4 / 3):.6g}, where "
                f"the Poisson ratio is -1, got {fast:.6g}."
            )
        modulus = density * slow**2
        if any(map(is_quantity, (c_l, c_t, rho))):
            modulus = InSI(modulus, "Pa", 1.0)
        return cls(modulus, density, (square - 2) / (2 * square - 2))

    def plane_stress(self) -> Material:
        """Return the solid whose plane strain is the plane stress of a thin plate of this one.

        Its Poisson ratio is nu / (1 + nu), so that its pressure waves have the speed of those of
        the plate, sqrt(E / (rho (1 - nu^2))).

        Raises
        ------
        SceneError
            If nu is not above -1/2, where the plate has no such solid.

        Examples
        --------
        >>> from semianalytic import Material
        >>> round(Material.from_young(5e9, 0.35, 1180.0).plane_stress().longitudinal_speed)
        2197
        """
        ratio = self.poisson_ratio
        if not ratio > -0.5:
            raise SceneError(
                f"material: plane stress needs a Poisson ratio above -1/2, got {ratio:g}."
            )
        modulus = InSI(self.shear_modulus, "Pa", 1.0) if made_in_si(self) else self.shear_modulus
        return Material(modulus, self.density, ratio / (1 + ratio))

    @cached_property
    def shear_speed(self) -> float:
        """Speed c_t of shear waves [length / time]."""
        return math.sqrt(self.shear_modulus / self.density)

    @cached_property
    def longitudinal_speed(self) -> float:
        """Speed c_l of pressure waves [length / time] (article, (3.18))."""
        nu = self.poisson_ratio
        return self.shear_speed * math.sqrt(2 * (1 - nu) / (1 - 2 * nu))

    @cached_property
    def rayleigh_speed(self) -> float:
        """Speed c_R of Rayleigh waves [length / time]: the root of the Rayleigh function (4.17).

        It is found from the cubic for (c_R/c_t)^2, since the closed form of the article's Appendix
        A is misprinted: it has an undefined k.
        """
        ratio2 = (self.shear_speed / self.longitudinal_speed) ** 2

        def cubic(r: float) -> float:
            return ((r - 8) * r + 24 - 16 * ratio2) * r - 16 * (1 - ratio2)

        # The cubic has one root between 0.1 and 1 and is negative below it; bisect to the last
        # digit.
        low, high = 0.1, 1.0
        while low < (middle := (low + high) / 2) < high:
            low, high = (middle, high) if cubic(middle) < 0 else (low, middle)
        return self.shear_speed * math.sqrt(high)

    @cached_property
    def shear_impedance(self) -> float:
        """Traction per particle velocity of a plane shear wave, mu b [stress time / length]."""
        return self.density * self.shear_speed
