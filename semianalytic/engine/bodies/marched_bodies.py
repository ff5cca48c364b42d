"""Velocity, stress and displacement in both bodies after a march.

Three parts add up (docs/spacetime.md, "Fields in the bodies").  Jumps of the loads on an interface
that sticks have exact fields (`field.stuck_steps`).  Slip ahead of all waves sends plane waves, and
loads the slot by minus its traction.  The remaining tractions of y = 0 are continuous: they come
from slip of the contact and from kinks and waves of the loads (`remainder`).  Their fields are
summed over wavenumbers and frequencies (`wavefield`).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from semianalytic.engine.bodies.remainder import Remainder, SlotLoad, far_traction
from semianalytic.engine.bodies.wavefield import Quantity, Spectrum, evaluated
from semianalytic.field.body import checked_points
from semianalytic.field.stuck_steps import stuck_step
from semianalytic.halfplane.rayleigh import Mode
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.results.questions import ROUNDING, check_times
from semianalytic.scene.contact import traction_ahead
from semianalytic.scene.errors import SceneError
from semianalytic.scene.scene import Material, Scene

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class MarchedBodies:
    """The fields in both bodies of a marched scene, which its `Marched` returns.

    Attributes
    ----------
    scene : Scene
        The scene that was marched.
    interface : InterfaceHistory
        Fields of the contact at the observed nodes, the first half a node distance from the edge,
        and at the stored levels.
    share : float
        Part of the wavenumbers that are summed.
    """

    scene: Scene
    interface: InterfaceHistory
    share: float = 1.0

    def velocity(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> Array:
        """Return the particle velocity; see `Marched.velocity`."""
        return self._change("velocity", x, y, t)

    def stress(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> Array:
        """Return the stress; see `Marched.stress`."""
        rows = self._change("stress", x, y, t)
        # pressure is positive in compression, sigma_yy in tension
        rows[1] -= traction_ahead(self.scene, "pressure", x, t)
        rows[-1] += traction_ahead(self.scene, "shear", x, t)
        return rows

    def displacement(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> Array:
        """Return the displacement; see `Marched.displacement`."""
        return self._change("displacement", x, y, t)

    def _change(self, quantity: Quantity, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> Array:
        """Return the rows (n, ...) of a quantity since t = 0, without the base."""
        x, y, t = checked_points(x, y, t)
        self._check_reach(x, y, t)
        begun = t > 0
        at = x[begun], y[begun], t[begun]
        # the sums are made in the upper body; the sign bit tells 0.0 and -0.0, the two faces, apart
        signs = np.where(np.signbit(at[1]), self._mirrored(quantity)[:, None], 1.0)
        changes = signs * (self._waves(quantity, *at) + self._plane_waves(quantity, *at))
        changes *= self._unit(quantity)
        for slot in (self._remainder.normal, self._remainder.shear):
            if slot.jumps:
                rows = self._rows(quantity, slot.mode)
                changes[rows] += self._of_jumps(slot, quantity, *at)[rows]
        result = np.zeros((len(changes), *x.shape))
        result[:, begun] = changes
        return result

    def _of_jumps(self, slot: SlotLoad, quantity: Quantity, x: Array, y: Array, t: Array) -> Array:
        """Return the rows (n, p) of the fields of load jumps on a stuck interface, at points (p,).

        Beside an edge that slips, the stuck stress intensity is taken away again by the sum over
        wavenumbers, which ends at the highest of them.  That part of it is therefore followed no
        closer to the edge than this sum follows it.
        """
        # Stress at a twentieth of the shortest wave is off by 1 to 2 times itself, with 0.6 or 2.4
        # by up to 2.5, without by 5 times.
        least = 1.0 / self._spectra[0].wavenumbers[-1]
        distance = np.hypot(x, y)
        near = (distance < least) & (quantity == "stress" and slot.mode != "I")
        total = _of_steps(self._solid, slot, quantity, x, y, t)
        if near.any():
            share = np.interp(t[near], self.interface.t, self._remainder.singular_share)
            followed = share * np.where(share == 0, 0.0, total[:, near])
            r = distance[near]
            # The share that stays under a singular pressure is exact at the point itself; the rest
            # is evaluated at the distance `least`, on the same ray from the edge.
            out = least / np.where(r > 0, r, 1.0)
            at = np.where(r > 0, out * x[near], least), out * y[near], t[near]
            total[:, near] = followed + (1 - share) * _of_steps(self._solid, slot, quantity, *at)
        return total

    @property
    def _solid(self) -> Material:
        """The material of both bodies."""
        return self.scene.material

    @cached_property
    def _remainder(self) -> Remainder:
        """The tractions of y = 0 that have no exact fields."""
        scene, times = self.scene, self.interface.t
        load, far = scene.superposition.taken_off, far_traction(scene, times)
        normal = SlotLoad.of("I", load.pressure, scene.pressure_history, times)
        shear = SlotLoad.of(scene.shear_mode, load.shear, scene.shear_history, times)
        if np.any(far):
            # Where the whole line slips ahead of all waves, its plane waves change the traction of
            # the slot faces too.  The load taken off them makes up for it: a jump at t = 0, and
            # what follows it.
            jumps = (*shear.jumps, (0.0, float(far[0])))
            shear = replace(shear, jumps=jumps, rest=shear.rest + (far - far[0]))
        return Remainder(scene, self.interface, far, normal, shear, self.share)

    @cached_property
    def _spectra(self) -> tuple[Spectrum, ...]:
        """The amplitudes of these tractions over wavenumbers and frequencies."""
        return self._remainder.spectra()

    def _rows(self, quantity: Quantity, mode: Mode) -> slice:
        """Return the rows of a quantity that a mode contributes to: those of z or the others."""
        plane = 3 if quantity == "stress" else 2
        return slice(plane, None) if mode == "III" else slice(0, plane)

    def _mirrored(self, quantity: Quantity) -> Array:
        """Return the signs that turn fields of shear in the upper body into those of the lower one.

        They relate a point of the lower body to its mirror image in the upper one.
        """
        # v_x is odd in y, v_y even, since slip is antisymmetric; sigma_xy is continuous, so even,
        # sigma_xx and sigma_yy odd.  Likewise v_z and sigma_xz odd, sigma_yz even.
        count = 3 - (not self.scene.antiplane)
        if quantity == "stress":
            return np.array([-1.0, -1.0, 1.0, -1.0, 1.0])[: 2 * count - 1]
        return np.array([-1.0, 1.0, -1.0])[:count]

    def _unit(self, quantity: Quantity) -> float:
        """Return the unit of a quantity computed with c_t = mu = 1 and stress in its own unit."""
        material = self.scene.material
        inverse = {"stress": 1.0, "velocity": material.shear_impedance}
        return 1 / inverse.get(quantity, material.shear_modulus)

    def _waves(self, quantity: Quantity, x: Array, y: Array, t: Array) -> Array:
        """Return the rows (n, p) summed over wavenumbers, at points mirrored into the upper body.

        They vanish beyond the distance that waves from the edge have reached.
        """
        result = np.zeros((len(self._mirrored(quantity)), len(x)))
        inside = np.abs(x) < self._remainder.reach
        for spectrum in self._spectra:
            sheared = "I" if spectrum.shear is None else self.scene.shear_mode
            rows = self._rows(quantity, sheared)
            for seen, here in _seen_by_bodies(spectrum, inside, np.signbit(y)):
                at = x[here], np.abs(y[here]), self._solid.shear_speed * t[here]
                result[rows, here] += evaluated(seen, quantity, self._ratio, sheared, *at)
        return result

    def _plane_waves(self, quantity: Quantity, x: Array, y: Array, t: Array) -> Array:
        """Return the rows (n, p) of plane waves, at points mirrored into the upper body.

        They come from slip ahead of all waves, and from the slot beyond the waves of the edge,
        where the sum over wavenumbers is left out.
        """
        left, result = self._remainder, np.zeros((len(self._mirrored(quantity)), len(x)))
        depth, time = np.abs(y), self._solid.shear_speed * t
        if np.any(left.far):
            result += self._plane_wave(quantity, left.shear.mode, left.far, depth, time)
        behind = x <= -left.reach
        for slot in (left.normal, left.shear):
            if slot.varies and behind.any():
                wave = self._plane_wave(quantity, slot.mode, slot.rest, depth[behind], time[behind])
                # taken off the slot: the change of pressure is minus the load, that of sigma_yy
                # plus the load; that of the shear traction is minus the load
                pressed = np.where(np.signbit(y[behind]), -1.0, 1.0)
                result[:, behind] += (pressed if slot.mode == "I" else -1.0) * wave
        return result

    def _plane_wave(
        self, quantity: Quantity, mode: Mode, traction: Array, depth: Array, time: Array
    ) -> Array:
        """Return the rows (n, p) of the plane wave that a uniform traction sends upwards.

        `traction` (m,) is given at the stored levels, `depth` and `time` (c_t t) are (p,).
        """
        slowness = self._ratio if mode == "I" else 1.0
        levels = self._solid.shear_speed * self.interface.t
        if quantity == "displacement":
            # velocity integrated over time, by the trapezoidal rule
            steps = np.diff(levels) * (traction[1:] + traction[:-1]) / 2
            traction = np.concatenate([[0.0], np.cumsum(steps)])
        value = np.interp(time - slowness * depth, levels, traction, left=0.0)
        rows = np.zeros((len(self._mirrored(quantity)), len(depth)))
        if quantity != "stress":
            # traction over impedance, 1 for S waves and c_l / c_t for P waves; a wave that runs
            # towards +y under tension moves particles towards -y
            rows[{"I": 1, "II": 0, "III": 2}[mode]] = -slowness * value
        elif mode == "I":
            # sigma_xx / sigma_yy = lambda / (lambda + 2 mu) = 1 - 2 (c_t / c_l)^2
            rows[:2] = (1 - 2 * slowness**2) * value, value
        else:
            rows[-1] = value
        return rows

    @property
    def _ratio(self) -> float:
        """The ratio c_t / c_l of wave speeds."""
        return self._solid.shear_speed / self._solid.longitudinal_speed

    def _check_reach(self, x: Array, y: Array, t: Array) -> None:
        """Raise SceneError for times and places that the recorded interface does not determine."""
        check_times(t, self.interface.t)
        end = float(self.interface.x[-1] + self.interface.x[0])
        # beyond the recorded contact something happens from the first wave on
        arrival = (end + np.hypot(x - end, y)) / self.scene.fastest_speed
        if np.any(t > arrival * (1 + ROUNDING)):
            raise SceneError(
                f"this answer knows the contact to x = {end:.6g} only, and waves from beyond have "
                "come; ask for earlier times, or march on a greater length (docs/limits.md)."
            )


def _of_steps(
    solid: Material, slot: SlotLoad, quantity: Quantity, x: Array, y: Array, t: Array
) -> Array:
    """Return the rows (n, p) of the fields that load jumps cause with a stuck interface."""
    step = getattr(stuck_step(solid, slot.mode), quantity)
    return np.sum([height * step(x, y, t - start) for start, height in slot.jumps], axis=0)


def _seen_by_bodies(
    spectrum: Spectrum, inside: Flags, below: Flags
) -> Iterator[tuple[Spectrum, Flags]]:
    """Return the spectrum as each body sees it, with the points (p,) that lie in that body."""
    # without pressure both bodies see the same, up to the signs of `_mirrored`
    if spectrum.normal is None:
        parts = [(spectrum, inside)]
    else:
        parts = [(spectrum, inside & ~below), (spectrum.mirrored, inside & below)]
    return (part for part in parts if part[1].any())
