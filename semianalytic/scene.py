"""What is loaded, by what, and with which friction: the description every solver shares.

Conventions (all modules): plane strain, interface y = 0, contact on x > 0, open slot on
x < 0.  Compressive pressure is positive.  Shear traction is sigma_xy on y = 0.  Slip and
slip rate are relative (upper face minus lower face), positive towards +x.  Any consistent
set of units will do.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

from scipy.optimize import brentq

from semianalytic.errors import SceneError


def _finite(owner: str, **values: float) -> None:
    for name, value in values.items():
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise SceneError(f"{owner}: {name} must be a number, got {value!r}.")
        if not math.isfinite(value):
            raise SceneError(f"{owner}: {name} must be finite, got {value!r}.")


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
    """

    shear_modulus: float
    density: float
    poisson_ratio: float

    def __post_init__(self) -> None:
        _finite(
            "material",
            shear_modulus=self.shear_modulus,
            density=self.density,
            poisson_ratio=self.poisson_ratio,
        )
        if self.shear_modulus <= 0:
            raise SceneError(f"material: shear_modulus must be positive, got {self.shear_modulus}.")
        if self.density <= 0:
            raise SceneError(f"material: density must be positive, got {self.density}.")
        if not -1 < self.poisson_ratio < 0.5:
            raise SceneError(
                "material: poisson_ratio must lie strictly between -1 and 0.5, "
                f"got {self.poisson_ratio}."
            )

    @cached_property
    def shear_speed(self) -> float:
        """Speed c_t of shear waves [length / time]."""
        return math.sqrt(self.shear_modulus / self.density)

    @cached_property
    def longitudinal_speed(self) -> float:
        """Speed c_l of pressure waves [length / time] (paper, (3.18))."""
        nu = self.poisson_ratio
        return self.shear_speed * math.sqrt(2 * (1 - nu) / (1 - 2 * nu))

    @cached_property
    def rayleigh_speed(self) -> float:
        """Speed c_R of Rayleigh waves [length / time]: the root of the Rayleigh function (4.17).

        Found from the cubic in (c_R/c_t)^2 (the paper's closed form, Appendix A, is garbled).
        """
        ratio2 = (self.shear_speed / self.longitudinal_speed) ** 2

        def cubic(r: float) -> float:
            return ((r - 8) * r + 24 - 16 * ratio2) * r - 16 * (1 - ratio2)

        root = brentq(cubic, 0.1, 1.0, xtol=1e-15, rtol=1e-15)
        return self.shear_speed * math.sqrt(root)

    @property
    def shear_impedance(self) -> float:
        """Traction per particle velocity of a plane shear wave, mu b [stress time / length]."""
        return self.density * self.shear_speed


@dataclass(frozen=True)
class Tractions:
    """A uniform pair of tractions [stress]: pressure (compression positive) and shear."""

    pressure: float
    shear: float

    def __post_init__(self) -> None:
        _finite("tractions", pressure=self.pressure, shear=self.shear)


@dataclass(frozen=True)
class Scene:
    """Two identical half-planes, Coulomb friction, base tractions and a step load.

    Parameters
    ----------
    material : Material
        The solid on both sides.
    friction : float
        Coulomb friction coefficient f >= 0.
    base : Tractions
        Uniform tractions (P_b, Q_b) on the whole line y = 0.
    step : Tractions
        Step (P_0, Q_0): at t = 0 the slot faces x < 0 receive the traction change
        (-P_0, -Q_0).  With base == step this is a sudden uniform remote load.

    Raises
    ------
    SceneError
        If friction is negative or not finite, if the base presses the interface apart, or if
        neither the base nor the state before a remote shock (base - step) can be at rest.
    """

    material: Material
    friction: float
    base: Tractions
    step: Tractions

    def __post_init__(self) -> None:
        _finite("scene", friction=self.friction)
        if self.friction < 0:
            raise SceneError(f"scene: friction must not be negative, got {self.friction}.")
        if self.base.pressure < 0:
            raise SceneError(
                "scene: base pressure must not be negative (compression is positive), "
                f"got {self.base.pressure}."
            )
        before = Tractions(
            self.base.pressure - self.step.pressure, self.base.shear - self.step.shear
        )
        if not (self._at_rest(self.base) or self._at_rest(before)):
            raise SceneError(
                "scene: the interface would already slide before the load arrives; lower the base "
                "shear below friction times base pressure, or make base and step equal "
                "(a sudden remote load)."
            )

    def _at_rest(self, tractions: Tractions) -> bool:
        strength = self.friction * tractions.pressure
        return tractions.pressure >= 0 and abs(tractions.shear) <= strength * (1 + 1e-12)

    @property
    def far_slip_rate(self) -> float:
        """Relative slip rate far ahead of all waves [length / time], 2 V(inf).

        Zero unless a sudden remote load exceeds friction everywhere.
        """
        excess = abs(self.base.shear) - self.friction * self.base.pressure
        return 2 * math.copysign(max(excess, 0.0), self.base.shear) / self.material.shear_impedance
