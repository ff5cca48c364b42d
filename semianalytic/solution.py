"""The solved scene: everything on the interface as functions of position and time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.errors import SceneError
from semianalytic.history import InterfaceHistory
from semianalytic.profile import Profile
from semianalytic.rayleigh import Array
from semianalytic.scene import Scene
from semianalytic.stuck import stress_intensity


@dataclass(frozen=True)
class SlipZone:
    """Part of the interface that slips: inner * t < x < outer * t.

    Attributes
    ----------
    inner, outer : float
        Velocities of the edges [length / time]; inner 0 is the contact edge, outer inf is slip
        ahead of all waves.
    sense : int
        +1 where the upper side slips towards +x, -1 towards -x.
    """

    inner: float
    outer: float
    sense: int


@dataclass(frozen=True)
class Statistics:
    """What a solution took.

    Attributes
    ----------
    pivots : int, of complementary pivoting on the grid
    newton_steps : int, of the zone edges
    zone_sets : int, sets of zones tried until Coulomb's law held everywhere
    unknowns : int, zone edges
    nodes : int, of all panels
    seconds : dict of stage to time [s]
    """

    pivots: int
    newton_steps: int
    zone_sets: int
    unknowns: int
    nodes: int
    seconds: dict[str, float]


@dataclass(frozen=True)
class Solution:
    """Self-similar slip on the interface of a scene.

    All fields broadcast over positions x > 0 [length] and times t [time]; before t = 0 they are
    the base state.  Slip and slip rate are relative, upper minus lower side.

    Attributes
    ----------
    scene : Scene
    zones : tuple of SlipZone, from the contact edge outward
    status : str
        "converged", or a sentence saying what to distrust.
    error_estimate : float
        Estimate, meant as a bound, of the error of zone edges (relative to c_t) and of the slip
        rate (relative to its largest value).
    statistics : Statistics
    profile : Profile
        The fields over slowness, in units b = mu = 1 and `stress`.
    stress : float
        Unit of stress of `profile`.
    """

    scene: Scene
    zones: tuple[SlipZone, ...]
    status: str
    error_estimate: float
    statistics: Statistics
    profile: Profile
    stress: float

    def _evaluate(self, x: ArrayLike, t: ArrayLike, field: Callable[[Array], Array]) -> Array:
        """A field over slowness (m,), or several (k, m), at x, t; 0 before t = 0."""
        x, t = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(t, dtype=float))
        if not (np.all(np.isfinite(x)) and np.all(np.isfinite(t))):
            raise SceneError("positions and times must be finite numbers.")
        if np.any(x <= 0):
            raise SceneError("the contact is x > 0; ask for positive positions.")
        u = (t * self.scene.material.shear_speed / x).ravel()
        value = np.where(u >= 0, field(np.maximum(u, 0.0)), 0.0)
        return value.reshape((*value.shape[:-1], *x.shape))

    @property
    def _rate_unit(self) -> float:
        return 2 * self.stress / self.scene.material.shear_impedance

    def slip_rate(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Relative slip rate [length / time].

        Raises
        ------
        SceneError
            If a position is not positive, or x or t is not finite.
        """
        return self._rate_unit * self._evaluate(x, t, self.profile.slip_rate)

    def slip(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Relative slip [length], the time integral of `slip_rate` since t = 0; raises as it."""
        time = np.asarray(t, dtype=float)
        return self._rate_unit * time * self._evaluate(x, t, self.profile.slip_over_time)

    def shear_traction(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Total shear traction sigma_xy [stress], base included; raises as `slip_rate`."""
        change = self._evaluate(x, t, self.profile.shear_change)
        return self.scene.base.shear + self.stress * change

    def pressure(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Contact pressure [stress], base included; slip does not change it.

        Raises as `slip_rate`.
        """
        change = self._evaluate(x, t, self.profile.pressure_change)
        return self.scene.base.pressure + self.stress * change

    def stick_margin(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Friction bound less shear traction, f p - |tau| [stress]; 0 where it slips."""
        bound = self.scene.friction * self.pressure(x, t)
        return bound - np.abs(self.shear_traction(x, t))

    def history(self, x: ArrayLike, t: ArrayLike) -> InterfaceHistory:
        """All interface fields at positions x (n,) and times t (m,)."""
        x, t = np.asarray(x, dtype=float), np.asarray(t, dtype=float)
        fields = (self.slip, self.slip_rate, self.shear_traction, self.pressure)
        return InterfaceHistory(x, t, *(field(x[None, :], t[:, None]) for field in fields))

    @cached_property
    def edge_slip_rate(self) -> float:
        """Relative slip rate at the contact edge, x -> 0+ [length / time]; 0 if it sticks."""
        return self._rate_unit * self.profile.edge_slip_rate

    def stress_intensity(self, t: ArrayLike) -> tuple[Array, Array]:
        """(K_I, K_II) at the contact edge at times t [stress sqrt(length)] (3.13), (3.16).

        pressure ~ K_I / sqrt(2 pi x) and shear traction ~ K_II / sqrt(2 pi x) of the actual
        state; a slipping edge has |K_II| = f K_I.
        """
        scene = self.scene
        unit = type(scene.step)(1.0, 1.0)
        mode_one, mode_two = stress_intensity(scene.material, unit, t)
        mode_one = scene.step.pressure * mode_one
        if self.profile.edge_slips:
            return mode_one, self.profile.panels.sense[-1] * scene.friction * mode_one
        return mode_one, self.stress * self.profile.edge_intensity * mode_two

    def frictional_power(self, t: ArrayLike) -> Array:
        """Power turned to heat on the contact per unit depth at times t [stress length^2 / time].

        Grows linearly in time; infinite when the interface slips ahead of all waves.
        """
        time = np.maximum(np.asarray(t, dtype=float), 0.0)
        if self.scene.far_slip_rate:
            return np.where(time > 0, np.inf, 0.0)
        unit = self._rate_unit * self.stress * self.scene.material.shear_speed
        return unit * self.profile.frictional_power * time

    def energy_flux(self, t: ArrayLike) -> Array:
        """Power that leaves the solids through the contact, per unit depth, at times t.

        [stress length^2 / time], in units of `frictional_power`, to which it is equal: friction
        takes all of it.  The edges of slip zones take none, for slip rate vanishes there at
        least like |x - edge|^(1/2) (between c_t and c_l like |x - edge|^(1 - phi/pi)) under a
        finite traction; nor does a stuck contact edge, which is singular but does not move.
        What the load does beyond that is radiated; it is infinite, as the slot is.
        """
        return self.frictional_power(t)

    @property
    def front_speeds(self) -> Array:
        """(m, 2) velocities of the inner and outer edge of each zone [length / time].

        From the contact edge outward; 0 is the contact edge itself, inf slip ahead of all waves.
        """
        return np.array([(zone.inner, zone.outer) for zone in self.zones]).reshape(-1, 2)

    def slot_velocity(self, x: ArrayLike, t: ArrayLike) -> tuple[Array, Array]:
        """Particle velocity (v_x, v_y) [length / time] of the upper slot face at x < 0.

        Logarithmically infinite at the Rayleigh front.

        Raises
        ------
        SceneError
            If a position is not negative, or x or t is not finite.
        """
        x = np.asarray(x, dtype=float)
        if np.any(x >= 0):
            raise SceneError("the slot is x < 0; ask for negative positions.")
        unit = self._rate_unit / 2
        both = self._evaluate(-x, t, lambda v: np.stack(self.profile.slot_velocity(v)))
        tangential, normal = both
        return unit * tangential, unit * normal
