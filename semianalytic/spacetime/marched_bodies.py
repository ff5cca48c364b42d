"""Velocity, stress and displacement in both bodies after a march.

Three parts add up.  Jumps of the loads on an interface that sticks have their exact fields
(`field.stuck_steps`).  Slip ahead of all waves sends plane waves, and loads the slot by minus its
traction.  What is left on y = 0 is continuous: what slip does to the contact, and kinks and waves
of the loads (`remainder`); it is summed over wavenumbers and frequencies (`wavefield`).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from semianalytic.field.stuck_steps import stuck_step
from semianalytic.halfplane.rayleigh import Mode
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.scene.errors import SceneError
from semianalytic.scene.loading import traction_ahead
from semianalytic.scene.scene import Material, Scene
from semianalytic.spacetime.remainder import Remainder, SlotLoad, far_traction
from semianalytic.spacetime.tuning import EDGE_SHARE
from semianalytic.spacetime.wavefield import Quantity, Spectrum, evaluated

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

_ROUNDING = 1e-9
"""By which the last time or position may be missed, relative to it."""


@dataclass(frozen=True, eq=False)
class MarchedBodies:
    """Fields in both bodies of a marched scene; what its `Marched` is asked for.

    Attributes
    ----------
    scene : Scene
    interface : InterfaceHistory
        Observed nodes, from half a node distance on, and stored levels.
    """

    scene: Scene
    interface: InterfaceHistory

    def velocity(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> Array:
        """See `Marched.velocity`."""
        return self._change("velocity", x, y, t)

    def stress(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> Array:
        """See `Marched.stress`."""
        rows = self._change("stress", x, y, t)
        rows[1] -= traction_ahead(self.scene, "pressure", t)
        rows[-1] += traction_ahead(self.scene, "shear", t)
        return rows

    def displacement(self, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> Array:
        """See `Marched.displacement`."""
        return self._change("displacement", x, y, t)

    def _change(self, quantity: Quantity, x: ArrayLike, y: ArrayLike, t: ArrayLike) -> Array:
        """Rows (n, ...) of a quantity since t = 0, base left out."""
        points = [np.asarray(one, dtype=float) for one in (x, y, t)]
        if not all(np.all(np.isfinite(one)) for one in points):
            raise SceneError("positions and times must be finite numbers.")
        x, y, t = np.broadcast_arrays(*points)
        self._check_reach(x, y, t)
        begun = t > 0
        at = x[begun], y[begun], t[begun]
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
        """Rows of what jumps do to a stuck interface, at points (p,).

        Beside an edge that slips, the intensity that slip takes away is followed no further than
        the sum over wavenumbers does that takes it away.
        """
        least = EDGE_SHARE / self._spectra[0].wavenumbers[-1]
        distance = np.hypot(x, y)
        near = (distance < least) & (quantity == "stress" and slot.mode != "I")
        total = _of_steps(self._solid, slot, quantity, x, y, t)
        if near.any():
            share = np.interp(t[near], self.interface.t, self._remainder.singular_share)
            followed = share * np.where(share == 0, 0.0, total[:, near])
            r = distance[near]
            out = least / np.where(r > 0, r, 1.0)
            at = np.where(r > 0, out * x[near], least), out * y[near], t[near]
            total[:, near] = followed + (1 - share) * _of_steps(self._solid, slot, quantity, *at)
        return total

    @property
    def _solid(self) -> Material:
        return self.scene.material

    @cached_property
    def _remainder(self) -> Remainder:
        scene, times = self.scene, self.interface.t
        load, far = scene.superposition.taken_off, far_traction(scene, times)
        normal = SlotLoad.of("I", load.pressure, scene.pressure_history, times)
        shear = SlotLoad.of(scene.shear_mode, load.shear, scene.shear_history, times)
        if np.any(far):
            jumps = (*shear.jumps, (0.0, float(far[0])))
            shear = replace(shear, jumps=jumps, rest=shear.rest + (far - far[0]))
        return Remainder(scene, self.interface, far, normal, shear)

    @cached_property
    def _spectra(self) -> tuple[Spectrum, ...]:
        return self._remainder.spectra()

    def _rows(self, quantity: Quantity, mode: Mode) -> slice:
        """Rows of a quantity that a mode has to do with: those of z or the others."""
        plane = 3 if quantity == "stress" else 2
        return slice(plane, None) if mode == "III" else slice(0, plane)

    def _mirrored(self, quantity: Quantity) -> Array:
        """Signs in the lower body of what shear does at the mirrored place in the upper one."""
        count = 3 - (not self.scene.antiplane)
        if quantity == "stress":
            return np.array([-1.0, -1.0, 1.0, -1.0, 1.0])[: 2 * count - 1]
        return np.array([-1.0, 1.0, -1.0])[:count]

    def _unit(self, quantity: Quantity) -> float:
        """Of a quantity where stress is in its own and c_t = mu = 1."""
        material = self.scene.material
        inverse = {"stress": 1.0, "velocity": material.shear_impedance}
        return 1 / inverse.get(quantity, material.shear_modulus)

    def _waves(self, quantity: Quantity, x: Array, y: Array, t: Array) -> Array:
        """What is summed over wavenumbers, in the upper body or mirrored into it, (n, p)."""
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
        """Those of slip ahead of all waves, and of the slot beyond what is summed, likewise."""
        left, result = self._remainder, np.zeros((len(self._mirrored(quantity)), len(x)))
        depth, time = np.abs(y), self._solid.shear_speed * t
        if np.any(left.far):
            result += self._plane_wave(quantity, left.shear.mode, left.far, depth, time)
        behind = x <= -left.reach
        for slot in (left.normal, left.shear):
            if slot.varies and behind.any():
                wave = self._plane_wave(quantity, slot.mode, slot.rest, depth[behind], time[behind])
                pressed = np.where(np.signbit(y[behind]), -1.0, 1.0)
                result[:, behind] += (pressed if slot.mode == "I" else -1.0) * wave
        return result

    def _plane_wave(
        self, quantity: Quantity, mode: Mode, traction: Array, depth: Array, time: Array
    ) -> Array:
        """Rows (n, p) of what a uniform traction at the stored levels sends upwards."""
        slowness = self._ratio if mode == "I" else 1.0
        levels = self._solid.shear_speed * self.interface.t
        if quantity == "displacement":
            steps = np.diff(levels) * (traction[1:] + traction[:-1]) / 2
            traction = np.concatenate([[0.0], np.cumsum(steps)])
        value = np.interp(time - slowness * depth, levels, traction, left=0.0)
        rows = np.zeros((len(self._mirrored(quantity)), len(depth)))
        if quantity != "stress":
            rows[{"I": 1, "II": 0, "III": 2}[mode]] = -slowness * value
        elif mode == "I":
            rows[:2] = (1 - 2 * slowness**2) * value, value
        else:
            rows[-1] = value
        return rows

    @property
    def _ratio(self) -> float:
        """c_t / c_l."""
        return self._solid.shear_speed / self._solid.longitudinal_speed

    def _check_reach(self, x: Array, y: Array, t: Array) -> None:
        """Raise SceneError for times and places that the recorded interface does not determine."""
        last = self.interface.t[-1]
        if np.any(t > last * (1 + _ROUNDING)):
            raise SceneError(
                f"this answer ends at t = {last:.6g}; ask for earlier times, or compute it to a "
                "later end time."
            )
        end = float(self.interface.x[-1] + self.interface.x[0])
        # beyond the recorded contact something happens from the first wave on
        arrival = (end + np.hypot(x - end, y)) / self.scene.fastest_speed
        if np.any(t > arrival * (1 + _ROUNDING)):
            raise SceneError(
                f"this answer knows the contact to x = {end:.6g} only, and waves from beyond have "
                "come; ask for earlier times, or march on a greater length (docs/limits.md)."
            )


def _of_steps(
    solid: Material, slot: SlotLoad, quantity: Quantity, x: Array, y: Array, t: Array
) -> Array:
    """Rows (n, p) of what jumps of the load do to a stuck interface."""
    step = getattr(stuck_step(solid, slot.mode), quantity)
    return np.sum([height * step(x, y, t - start) for start, height in slot.jumps], axis=0)


def _seen_by_bodies(
    spectrum: Spectrum, inside: Flags, below: Flags
) -> Iterator[tuple[Spectrum, Flags]]:
    """What either body sees of a spectrum, and which points (p,) lie in it."""
    if spectrum.normal is None:
        parts = [(spectrum, inside)]
    else:
        parts = [(spectrum, inside & ~below), (spectrum.mirrored, inside & below)]
    return (part for part in parts if part[1].any())
