"""Cracks that grow from a point at a given speed: Kostrov, Burridge, Broberg.

A crack |x| < v t appears at t = 0 in a line under uniform traction, of which it takes off the
stress drop.  Slip is elliptic, one side moves by A sqrt(v^2 t^2 - x^2), and the transform of its
rate over x/t is W = C k / (e^2 - k^2)^(3/2), e = 1/v. Broberg (1960) solved mode I, Kostrov (1964)
mode III, Burridge (1969) mode II.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.halfplane.imaginary_axis import impedance_on_axis, over_axis
from semianalytic.halfplane.rayleigh import CutPoints, Mode, RayleighFactors, rayleigh_factors
from semianalytic.halfplane.running import RunningIntegral, panels_to
from semianalytic.scene.arguments import checking_methods
from semianalytic.scene.arrays import Array
from semianalytic.scene.checks import checked_number, checked_size
from semianalytic.scene.errors import SceneError
from semianalytic.scene.scene import Material

_NEAREST = 1e-13
"""Least distance from the tip over its position at which tractions are evaluated."""


@checking_methods
@dataclass(frozen=True, eq=False)
class PrescribedCrack:
    """A crack |x| < speed * t with a uniform stress drop, in an infinite line.

    Fields broadcast over positions x [length], of either sign, and times t [time]; tractions are
    changes from what was there before, positive ahead of the tips for a positive drop.

    Attributes
    ----------
    material : Material
    speed : float
        v, of either tip [length / time].
    drop : float
        Stress drop [stress]: change of the traction on the crack, with its sign reversed.
    mode : "I", "II" or "III"
    factors : RayleighFactors
    """

    material: Material
    speed: float
    drop: float
    mode: Mode
    factors: RayleighFactors

    @property
    def _slowness(self) -> float:
        return self.material.shear_speed / self.speed

    @cached_property
    def _constant(self) -> float:
        """C over the drop: drop = (C / pi) int_0^inf M(i eta) / (e^2 + eta^2)^(3/2) d eta."""
        e = self._slowness
        # The traction on the crack is uniform, so that one condition, the drop, fixes C.
        integral = over_axis(
            lambda eta: np.asarray(impedance_on_axis(self.factors, eta) / np.hypot(e, eta) ** 3)
        )
        return np.pi / integral

    @property
    def amplitude(self) -> float:
        """A of the displacement A sqrt(v^2 t^2 - x^2) of one side, per mu / drop: dimensionless."""
        return self._constant / (np.pi * self._slowness)

    def slip(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Relative slip, in mode I the opening [length]."""
        inside = self._inside(x, t)
        return 2 * self.amplitude * self.drop / self.material.shear_modulus * np.sqrt(inside)

    def _inside(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Return v^2 t^2 - x^2 on the crack, 0 ahead of it."""
        reach = self.speed * np.maximum(np.asarray(t, dtype=float), 0.0)
        distance = np.abs(np.asarray(x, dtype=float))
        # In factors: the difference of squares loses its digits at the tips, where slip has its
        # root.
        return np.asarray(np.maximum((reach - distance) * (reach + distance), 0.0))

    def slip_rate(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Relative slip rate [length / time], infinite at the tips; 0 ahead of them."""
        inside = self._inside(x, t)
        unit = 2 * self.amplitude * self.drop / self.material.shear_modulus
        moving = np.broadcast_to(self.speed**2 * np.asarray(t, dtype=float), inside.shape)
        return np.where(inside > 0, unit * moving / np.sqrt(inside), 0.0)

    def traction(self, x: ArrayLike, t: ArrayLike) -> Array:
        """Change of traction [stress]: -drop on the crack, singular ahead of its tips."""
        x, t = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(t, dtype=float))
        xi = np.divide(np.abs(x), t, out=np.full(x.shape, np.inf), where=t > 0)
        u = (self.material.shear_speed / xi).ravel()
        # At the tip itself the traction is infinite; nearer to it than this it follows the root
        # alone.
        stop = self._slowness * (1 - _NEAREST)
        ahead = self._running.at(np.minimum(u, stop)).reshape(x.shape)
        return self.drop * np.where(xi > self.speed, ahead, np.where(t > 0, -1.0, 0.0))

    @cached_property
    def _running(self) -> RunningIntegral:
        """Traction ahead of the tip over slowness, C Im M / (pi (e^2 - v^2)^(3/2))."""
        e, factors = self._slowness, self.factors
        gap = e * _NEAREST

        def slope(at: CutPoints, to_stop: Array) -> Array:
            imaginary = factors.impedance_on_cut(at).imag
            return np.asarray(
                self._constant * imaginary / (np.pi * ((to_stop + gap) * (e + at.v)) ** 1.5)
            )

        return RunningIntegral(factors, slope, panels_to(factors, e - gap, gap))

    def stress_intensity(self, t: ArrayLike) -> Array:
        """Stress intensity K of either tip at times t [stress sqrt(length)], growing as sqrt(t).

        It is C m(e) sqrt(t) / (sqrt(pi) e^(5/2)), m(e) = Im M(-e + i0): drop sqrt(pi v t) for a
        slow crack, and 0 at the Rayleigh speed (in mode III that of shear waves).
        """
        e = self._slowness
        impedance = float(self.factors.impedance_behind(self.factors.cut(np.array([e])))[0])
        unit = self._constant * impedance / (np.sqrt(np.pi) * e**2.5)
        length = self.material.shear_speed * np.maximum(np.asarray(t, dtype=float), 0.0)
        return np.asarray(self.drop * unit * np.sqrt(length))

    def energy_release_rate(self, t: ArrayLike) -> Array:
        """Energy that either tip takes per length at times t [stress length].

        It is pi K D / (4 sqrt(2 pi)), where relative slip is D sqrt(distance) behind the tip: the
        work that the traction ahead would do on the slip behind, for a short advance.
        """
        length = self.speed * np.maximum(np.asarray(t, dtype=float), 0.0)
        behind = 2 * self.amplitude * self.drop / self.material.shear_modulus * np.sqrt(2 * length)
        return np.asarray(np.pi / 4 * self.stress_intensity(t) * behind / np.sqrt(2 * np.pi))


def prescribed_crack(
    material: Material, speed: float, drop: float, mode: Mode = "II"
) -> PrescribedCrack:
    """Return the crack that grows from a point at a given speed under a uniform stress drop.

    Parameters
    ----------
    material : Material
    speed : float
        v, below the Rayleigh speed, in mode III below that of shear waves [length / time].
    drop : float
        Stress drop [stress].
    mode : "I" (Broberg), "II" (Burridge) or "III" (Kostrov)

    Raises
    ------
    SceneError
        If the mode is none of these, or the speed is not positive or too fast.

    Examples
    --------
    >>> from semianalytic import Material
    >>> from semianalytic.reference import prescribed_crack
    >>> solid = Material(1.0, 1.0, 1 / 3)
    >>> [round(prescribed_crack(solid, 0.5, 1.0, mode).amplitude, 7) for mode in ("I", "II", "III")]
    [0.5135005, 0.5882685, 0.8257256]
    """
    speed = checked_size("prescribed_crack: speed", speed)
    drop = checked_number("prescribed_crack: drop", drop)
    factors = rayleigh_factors(material.poisson_ratio, mode)
    limit = material.shear_speed / factors.c
    if not speed < limit:
        wave = "Rayleigh" if factors.has_rayleigh_wave else "shear"
        raise SceneError(
            f"prescribed_crack: speed must be below that of the {wave} wave, {limit:.6g}, where "
            f"tips absorb no energy, got {speed:.6g}."
        )
    return PrescribedCrack(material, speed, drop, mode, factors)
