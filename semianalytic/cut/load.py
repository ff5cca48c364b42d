"""Convert a scene to the load of the solver, in one unit of stress; refuse what opens wholly."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from semianalytic.cut.quadrature.layout import Layout, Zone
from semianalytic.halfplane.rayleigh import CutPoints, Mode, RayleighFactors
from semianalytic.halfplane.stuck import StuckTraction, stuck_traction, traction_of
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import TensionError
from semianalytic.scene.laws.coulomb import Coulomb
from semianalytic.scene.scene import Scene

LEAST_BASE = 1e-30
"""Base over its step, or step over base, that is nothing: openings end within 1e-60 of fronts."""
CRITICAL_BASE = 1e-14
"""Relative difference of a base from friction that is the rounding of the two products."""


@dataclass(frozen=True)
class Opened:
    """Open part of a contact, with the solution of the normal problem."""

    zone: Zone  # open part, with sense 1; right None is the contact edge
    # terms r / (k + edge) of the normal problem where the contact closes
    closing: tuple[tuple[CutPoints, float], ...]
    # P_b, P_0 [stress unit], and the slowness p of the front of the load
    base: float
    step: float
    # contact pressure [stress unit] at points on the cut, any shape
    pressure: Callable[[CutPoints], Array]
    # increasing slownesses and the pressures there, dense enough for interpolation, (2, n)
    known: Array
    slowness: float = 0.0

    def near_pressure(self, v: Array) -> Array:
        """Return the approximate contact pressure at slownesses v, by linear interpolation."""
        return np.interp(v, *self.known)


class LinearisedStrength(Protocol):
    """Strength that depends on slip rate in any way, linearised about a slip rate."""

    def at(self, points: CutPoints, layout: Layout, jacobian: Array) -> tuple[Array, Array]:
        """Return `resistance` and `given_slope` of a `Load` at the nodes (p, ..., n) of panels.

        `jacobian` is dv/dy there.
        """
        ...

    def carried(self, frictional: Array, speed: Array) -> Array:
        """Return the strength itself [stress unit] under f p [stress unit] and one-sided |V|."""
        ...


@dataclass(frozen=True)
class Load:
    """Friction and tractions in one unit of stress, slip rate far ahead in that unit / (mu b).

    For k sets of zones that differ in friction, friction and far_slip_rate are (k, 1) arrays.
    """

    friction: float | Array  # coefficient f
    # P_b, Q_b [stress unit]; compression and sigma_xy positive
    base_pressure: float
    base_shear: float
    # P_0, Q_0 [stress unit]
    load_pressure: float
    load_shear: float
    far_slip_rate: float | Array  # V(inf), one-sided [stress unit / (mu b)]
    # eta = dtau/d|V|, of the one-sided slip rate [mu b]: a number, (k, 1), or (p, ..., n) at the
    # nodes of panels; None if strength does not depend on slip rate
    resistance: float | Array | None = None
    # dg/dv, a part of the slope of strength given at the nodes of panels (p, ..., n) [stress unit];
    # None without.  It goes with resistance: without it V would jump at c by -pi g'(c) / m'(c),
    # m = M / i, where it slips.
    given_slope: Array | None = None
    # gives both on whatever panels; None without
    linearised: LinearisedStrength | None = None
    # where the contact is open and what its pressure is; None if it is closed
    opened: Opened | None = None
    # p, that of the front of the load over the slot [b]; 0 for a load that comes at once
    slowness: float = 0.0

    def stuck(self, factors: RayleighFactors, mode: Mode) -> StuckTraction:
        """Return the traction of a unit step that comes like the load, with nothing slipping."""
        return traction_of(factors, mode, self.slowness)

    def front_factor(self, at: CutPoints) -> float | Array:
        """Return k / (k + p) at k = -v on the cut, v / (v - p); 1 for a load that comes at once."""
        return at.v / (at.v - self.slowness) if self.slowness else 1.0

    @property
    def resists_rate(self) -> bool:
        """Whether strength depends on slip rate."""
        return self.resistance is not None or self.linearised is not None

    @property
    def critical(self) -> bool:
        """Whether the base shear traction reaches friction ahead of all waves (one set)."""
        strength = self.friction * self.base_pressure
        return bool(abs(self.base_shear) >= strength * (1 - CRITICAL_BASE))

    @property
    def frictionless(self) -> np.ndarray:
        """Whether no friction resists slip, or only rounding of the step of shear; () or (k,)."""
        strength = np.asarray(per_set(self.friction)) * max(self.base_pressure, self.load_pressure)
        # Below this, the sum of strength and load has no digit of the strength.
        negligible = 1e-15 * abs(self.load_shear)  # what rounding takes from the step
        return np.asarray((strength == 0) | (strength < negligible))

    def slips_from_front(self, sense: int) -> bool:
        """Whether slip of a sense may begin at the first front or ahead of all waves (one set).

        This requires no friction, or a base at friction that drives slip in this sense: otherwise
        the traction would have to jump at the front, which no load produces.
        """
        if self.frictionless or self.far_slip_rate:
            return True
        # A base without any traction is at friction in either sense.
        return self.critical and sense * self.base_shear >= 0

    @property
    def rests(self) -> bool:
        """Whether nothing slips (one set); the base may be at friction, and the contact open."""
        # A step of pressure alone drives slip only if the base carries shear.
        drives = self.load_pressure if self.base_shear else 0.0
        return not (self.load_shear or drives or self.far_slip_rate)

    def pressure(self, factors: RayleighFactors, at: CutPoints) -> Array:
        """Return the contact pressure at points on the cut [stress unit]; 0 where it is open."""
        if self.opened is not None:
            return self.opened.pressure(at)
        result = np.full(at.v.shape, self.base_pressure)
        if self.load_pressure:
            result = result + self.load_pressure * self.stuck(factors, "I").at(at)
        return result


def normal_load(base: float, step: float, slowness: float = 0.0) -> Load:
    """Return the load of the normal problem: minus pressure for traction, and no resistance."""
    return Load(0.0, 0.0, -base, 0.0, -step, 0.0, slowness=slowness)


def per_set(value: float | Array) -> float | Array:
    """Return a number as it is, and a (k, 1) array as (k,)."""
    return np.asarray(value)[..., 0] if np.ndim(value) else value


def scaled_load(scene: Scene) -> tuple[Load, float]:
    """Return the load of a scene in units of its largest traction, and that unit [stress]."""
    f, (base, load) = scene.coefficient, scene.superposition
    parts = (load.shear, f * load.pressure, base.shear, f * base.pressure)
    # A scene without tractions has the unit 1.
    # In this unit all numbers are at most 1, so that tolerances need no scale of their own.
    unit = max(abs(part) for part in parts) or 1.0
    return _in_unit(scene, f, scene.far_slip_rate, unit), unit


def common_load(scenes: Sequence[Scene], unit: float) -> Load:
    """Return the load of k scenes that differ in friction alone, in one unit of stress."""
    friction = np.array([[scene.coefficient] for scene in scenes])
    far_slip_rate = np.array([[scene.far_slip_rate] for scene in scenes])
    return _in_unit(scenes[0], friction, far_slip_rate, unit)


def _in_unit(
    scene: Scene, friction: float | Array, far_slip_rate: float | Array, unit: float
) -> Load:
    (base, load), impedance = scene.superposition, scene.material.shear_impedance
    viscosity = scene.law.viscosity if type(scene.law) is Coulomb else 0.0
    parts: tuple[float, float] = base.pressure / unit, base.shear / unit
    return Load(
        friction,
        *(_at_friction(friction, *parts, far_slip_rate) if isinstance(friction, float) else parts),
        load.pressure / unit,
        load.shear / unit,
        # From relative to one-sided slip rate, in units of stress / (rho c_t); for the same reason
        # eta = 2 viscosity / (rho c_t).
        far_slip_rate * impedance / (2 * unit),
        2 * viscosity / impedance if viscosity else None,
        slowness=scene.front_slowness * scene.material.shear_speed,
    )


def _at_friction(
    friction: float, pressure: float, shear: float, far_slip_rate: float | Array
) -> tuple[float, float]:
    """Return pressure and shear of a base, put at friction if only rounding keeps it off."""
    strength = friction * pressure
    # An edge that rounding keeps off a front has no place in double precision.
    if far_slip_rate or abs(abs(shear) - strength) > CRITICAL_BASE * strength:
        return pressure, shear
    return pressure, float(np.copysign(strength, shear))


def check_pressure(scene: Scene) -> None:
    """Raise TensionError where the contact of a scene would open all the way to infinity."""
    base, step = (part.pressure for part in scene.superposition)
    # p* = 0 ahead of all waves, so that the base alone holds the contact together there.
    if base < 0 or (step != 0 and base <= max(LEAST_BASE * step, 0.0)):
        raise TensionError(
            f"scene: under a base pressure of {base:.4g} nothing holds the contact together far "
            f"ahead; make it positive, at least {LEAST_BASE:.0e} of the step (docs/limits.md)."
        )


def contact_opens(scene: Scene) -> bool:
    """Return whether the contact opens: at its edge for P_0 < 0, else at the Rayleigh front.

    There P_b + P_0 p*(c) < 0.
    """
    base, step = (part.pressure for part in scene.superposition)
    slowness = scene.front_slowness * scene.material.shear_speed
    if not step:  # p* is not needed, nor are its tables
        return base < 0
    # p* has its minimum at the Rayleigh front, which is therefore the first place to open.
    stuck = stuck_traction(scene.material.poisson_ratio, "I", slowness)
    return step < -LEAST_BASE * base or base + step * stuck.at_rayleigh_front < 0
