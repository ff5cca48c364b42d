"""Derivatives of a load and a material with respect to a parameter."""

from __future__ import annotations

from dataclasses import dataclass, replace

from semianalytic.cut.load import Load


@dataclass(frozen=True)
class Rates:
    """Derivatives with respect to a parameter: of the fields of `Load`, and of nu (1 or 0).

    `front_excess` is that of the base shear less friction, where slip starts at the longitudinal
    front of a base at friction; the base ahead of it then sticks [stress unit].
    """

    friction: float = 0.0
    base_pressure: float = 0.0
    base_shear: float = 0.0
    load_pressure: float = 0.0
    load_shear: float = 0.0
    far_slip_rate: float = 0.0
    resistance: float = 0.0
    poisson_ratio: float = 0.0
    slowness: float = 0.0
    front_excess: float = 0.0

    @property
    def nonlinear(self) -> bool:
        """Whether fields are not linear in what changes, for fixed zones."""
        return bool(self.poisson_ratio or self.resistance or self.slowness)

    @property
    def of_pressure(self) -> bool:
        """Whether a pressure of the base or the load changes."""
        return bool(self.base_pressure or self.load_pressure)

    def of_load(self, load: Load) -> Load | None:
        """Return the load whose fields are the derivatives of those of a load, for fixed zones.

        All fields are linear in shear tractions and in friction times pressure. The result is None
        if anything else changes: impedances, or the open part of the contact.
        """
        # A change of pressure moves the ends of the opening, and fields are not linear in these.
        if self.nonlinear or (load.opened and self.of_pressure):
            return None
        moved = ["base_shear", "load_shear", "far_slip_rate", "base_pressure", "load_pressure"]
        # d(f p) = df p + f dp, of which one part is zero.
        if self.friction or load.opened:  # whose pressure stays
            moved[3:] = ["friction"]
        return replace(load, **{name: getattr(self, name) for name in moved})
