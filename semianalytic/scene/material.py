"""The solid on both sides of the interface, and the speeds of its waves."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

from semianalytic.scene.checks import check_fields, checked_number, checked_size
from semianalytic.scene.quantities import with_quantities


@with_quantities
@dataclass(frozen=True)
class Material:
    """Isotropic linear elastic solid, the same on both sides of the interface.

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
        poisson_ratio = checked_number(
            "material: poisson_ratio",
            self.poisson_ratio,
            "lie strictly between -1 and 0.5",
            lambda given: -1 < given < 0.5,
        )
        object.__setattr__(self, "poisson_ratio", poisson_ratio)

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
        A is garbled (docs/theory.md, "What the article got wrong").
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

    @property
    def shear_impedance(self) -> float:
        """Traction per particle velocity of a plane shear wave, mu b [stress time / length]."""
        return self.density * self.shear_speed
