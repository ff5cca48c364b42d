"""Velocity, stress and displacement in both bodies after a march.

The tractions of y = 0 are split into parts.  Jumps of the loads on an interface that sticks have
their exact fields (`field.stuck_steps`); so has what slips ahead of all waves, which sends plane
waves and loads the slot by minus that.  What is left is continuous: what slip does to the contact,
and kinks and waves of the loads.  It is taken from the march and summed over wavenumbers and
frequencies (`wavefield`), the slot being long enough that its other end is not seen.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from semianalytic.field.stuck_steps import stuck_step
from semianalytic.halfplane.edge_factors import edge_offset_and_factors
from semianalytic.halfplane.stuck import stuck_traction
from semianalytic.halfplane.rayleigh import Mode
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.scene.errors import SceneError
from semianalytic.scene.loads import Pieces
from semianalytic.scene.scene import Scene
from semianalytic.spacetime.tuning import FIELD_MARGIN, FIELD_VALUES
from semianalytic.spacetime.wavefield import (
    Complex,
    Quantity,
    Spectrum,
    Window,
    along_line,
    evaluated,
    kept_wavenumbers,
    tapered,
)

Array = NDArray[np.float64]
Step = Callable[[Array], Array]

_ROUNDING = 1e-9


@dataclass(frozen=True, eq=False)
class SlotLoad:
    """Traction that is taken off the slot, as a sum of jumps and a continuous rest.

    Attributes
    ----------
    mode : Mode
        "I" of pressure, "II" or "III" of shear.
    jumps : tuple of (time, height) [time], [stress]
    rest : (m,) array
        At the stored levels [stress].
    """

    mode: Mode
    jumps: tuple[tuple[float, float], ...]
    rest: Array

    @property
    def varies(self) -> bool:
        """Whether there is a rest."""
        return bool(np.any(self.rest))

    def on_grid(self, nodes: int, spacing: float, speed: float, step: Step, t: Array) -> Array:
        """What the jumps exert on a stuck contact at times (m,), as its grid sees it, (m, nodes).

        Parameters
        ----------
        nodes, spacing : int, float
            Of the contact; node distance [length].
        speed : float
            c_t [length / time].
        step : callable
            Stuck traction of a step over t c_t / x.
        t : (m,) array
            [time].
        """
        offset, near = edge_offset_and_factors()
        factors = np.ones(nodes)
        factors[: len(near)] = near[:nodes]
        x = (np.arange(nodes) + offset) * spacing
        total = np.zeros((len(t), nodes))
        for start, height in self.jumps:
            after = t > start
            u = np.multiply.outer(speed * (t[after] - start), 1 / x)
            total[after] += height * ((step(u) + 1) * factors - 1)
        return total


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
        rows[1] -= self.scene.base.pressure
        rows[-1] += self.scene.base.shear
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
        planes = 3 if quantity == "stress" else 2
        across = (planes - 1) * self.scene.antiplane
        rows, begun = np.zeros((planes + across, *x.shape)), t > 0
        at = x[begun], y[begun], t[begun]
        changes = np.zeros((planes + across, len(at[0])))
        for slot in self._slots:
            own = slice(planes, None) if slot.mode == "III" else slice(0, planes)
            step = stuck_step(self.scene.material, slot.mode)
            for start, height in slot.jumps:
                of_step = getattr(step, quantity)(at[0], at[1], at[2] - start)
                changes[own] += height * of_step[own]
        changes += self._unit(quantity) * self._rest(quantity, planes, *at)
        rows[:, begun] = changes
        return rows

    def _unit(self, quantity: Quantity) -> float:
        """Of a quantity over that of stress, with c_t times time for time."""
        material = self.scene.material
        inverse = {"stress": 1.0, "velocity": material.shear_impedance}
        return 1 / inverse.get(quantity, material.shear_modulus)

    def _rest(self, quantity: Quantity, planes: int, x: Array, y: Array, t: Array) -> Array:
        """What is not exact, and plane waves, at points (p,), in units of stress and c_t t."""
        scene = self.scene
        result = np.zeros((planes + (planes - 1) * scene.antiplane, len(x)))
        depth, ct = np.abs(y), scene.material.shear_speed * t
        signs = np.where(np.signbit(y), _mirrored(quantity, scene.antiplane)[:, None], 1.0)
        inside = np.abs(x) < self._reach
        for spectrum in self._spectra:
            across = scene.antiplane and spectrum.shear is not None
            own = slice(planes, None) if across else slice(0, planes)
            for body, here in self._bodies_of(spectrum, inside, np.signbit(y)):
                at = x[here], depth[here], ct[here]
                result[own, here] += evaluated(body, quantity, self._ratio, across, *at)
        result += self._plane_wave(quantity, self._slots[-1].mode, self._far, depth, ct)
        behind = x <= -self._reach
        for slot in self._slots:
            wave = self._plane_wave(quantity, slot.mode, slot.rest, depth[behind], ct[behind])
            pressed = np.where(np.signbit(y[behind]), -1.0, 1.0) if slot.mode == "I" else -1.0
            result[:, behind] += pressed * wave
        return signs * result

    @staticmethod
    def _bodies_of(
        spectrum: Spectrum, inside: NDArray[np.bool_], below: NDArray[np.bool_]
    ) -> Iterator[tuple[Spectrum, NDArray[np.bool_]]]:
        """What either body sees of a spectrum, and which points (p,) are in it."""
        bodies = {spectrum: inside} if spectrum.normal is None else {
            spectrum: inside & ~below, spectrum.mirrored: inside & below
        }
        return ((body, here) for body, here in bodies.items() if here.any())

    def _plane_wave(
        self, quantity: Quantity, mode: Mode, traction: Array, depth: Array, ct: Array
    ) -> Array:
        """Rows (n, p) of what a uniform traction on y = 0, at the stored levels, sends upwards."""
        a, antiplane = self._ratio, self.scene.antiplane
        slowness = a if mode == "I" else 1.0
        levels = self.scene.material.shear_speed * self.interface.t
        if quantity == "displacement":
            steps = np.diff(levels) * (traction[1:] + traction[:-1]) / 2
            traction = np.concatenate([[0.0], np.cumsum(steps)])
        value = np.interp(ct - slowness * depth, levels, traction, left=0.0)
        none = np.zeros_like(value)
        if quantity == "stress":
            rows = [none, none, none, none, none][: 5 if antiplane else 3]
            if mode == "I":
                rows[0], rows[1] = (1 - 2 * a * a) * value, value
            else:
                rows[-1] = value
        else:
            rows = [none, none, none][: 3 if antiplane else 2]
            rows[{"I": 1, "II": 0, "III": -1}[mode]] = -slowness * value
        return np.stack(rows)

    @property
    def _ratio(self) -> float:
        """c_t / c_l."""
        return self.scene.material.shear_speed / self.scene.material.longitudinal_speed

    @cached_property
    def _reach(self) -> float:
        """How far waves have come at the last level [length]."""
        return float(self.scene.fastest_speed * self.interface.t[-1])

    def _check_reach(self, x: Array, y: Array, t: Array) -> None:
        """Raise SceneError for times and places that the recorded interface does not determine."""
        last = self.interface.t[-1]
        if np.any(t > last * (1 + _ROUNDING)):
            raise SceneError(
                f"this answer ends at t = {last:.6g}; ask for earlier times, or compute it to a "
                "later end time."
            )
        end = float(self.interface.x[-1] + self.interface.x[0])
        # what happens beyond the recorded contact begins with the first wave and goes on from there
        arrival = (end + np.hypot(x - end, y)) / self.scene.fastest_speed
        if np.any(t > arrival * (1 + _ROUNDING)):
            raise SceneError(
                f"this answer knows the contact to x = {end:.6g} only, and waves from beyond have "
                "come; ask for earlier times, or compute it on a greater length."
            )

    @cached_property
    def _far(self) -> Array:
        """Change of shear traction ahead of all waves at the stored levels [stress]."""
        scene, times = self.scene, self.interface.t
        impedance, base = scene.material.shear_impedance / 2, abs(scene.base.shear)
        stopping, frictional = np.array([base]), np.array([scene.friction * scene.base.pressure])
        path, rates = np.zeros(1), np.zeros(len(times))
        for level in range(len(times)):
            rates[level] = scene.friction_law.slip_speed(stopping, frictional, impedance, path)[0]
            if level + 1 < len(times):
                path = path + rates[level] * (times[level + 1] - times[level])
        return -math.copysign(1.0, scene.base.shear) * impedance * rates

    @cached_property
    def _slots(self) -> tuple[SlotLoad, ...]:
        """What is taken off the slot, pressure first."""
        scene, times = self.scene, self.interface.t
        loads = {"pressure": scene.load.pressure, "shear": scene.load.shear}
        slots = []
        for name, history in (
            ("pressure", scene.pressure_history), ("shear", scene.shear_history)
        ):
            pieces, load = history.pieces, loads[name]
            jumps = [(start, load * height) for start, height in pieces.jumps]
            of_jumps = Pieces(jumps=pieces.jumps).value(times)
            rest = load * (history.value(times) - of_jumps)
            if not (pieces.kinks or pieces.waves):
                rest = np.zeros(len(times))
            if name == "shear":
                jumps.append((0.0, float(self._far[0])))
                rest = rest + self._far - self._far[0]
            mode = "I" if name == "pressure" else scene.shear_mode
            slots.append(SlotLoad(mode, tuple(one for one in jumps if one[1]), rest))
        return tuple(slots)

    @cached_property
    def _spectra(self) -> tuple[Spectrum, ...]:
        """Of what is left of shear, and of pressure if its load does not only jump."""
        normal, shear = self._slots
        material, seen = self.scene.material, self.interface
        spacing = 2 * float(seen.x[0])
        speed = material.shear_speed
        window = Window(speed * float(seen.t[-1]), len(seen.t) - 1)
        reached = math.ceil(self._reach / spacing) + FIELD_MARGIN
        contact = min(len(seen.x), reached)
        loaded = 2 * reached if normal.varies or shear.varies else 0
        from scipy.fft import next_fast_len

        nodes = next_fast_len(2 * (reached + loaded // 2), real=True)
        q = kept_wavenumbers(nodes * spacing, self._reach, nodes)
        omega = window.frequencies(self.scene.fastest_speed / speed * q[-1])
        taper = tapered(q, omega)

        def amplitudes(slot: SlotLoad, recorded: Array, sign: float) -> Complex:
            step = stuck_traction(material.poisson_ratio, slot.mode)
            lines = np.empty((len(seen.t), len(q)), dtype=complex)
            block = max(1, FIELD_VALUES // nodes)
            for first in range(0, len(lines), block):
                part = slice(first, first + block)
                values = np.zeros((len(lines[part]), nodes))
                values[:, :contact] = recorded[part, :contact] 
                values[:, :contact] -= slot.on_grid(contact, spacing, speed, step, seen.t[part])
                if loaded:
                    values[:, nodes - loaded:] = -slot.rest[part, None]
                lines[part] = along_line(sign * values, spacing, q)
            even = window.times / speed
            return taper * window.transformed(_resampled(lines, seen.t, even), omega)

        of_shear = amplitudes(shear, seen.shear_traction - self.scene.base.shear - self._far[:, None], 1.0)
        of_normal = None
        if normal.varies:
            of_normal = amplitudes(normal, seen.pressure - self.scene.base.pressure, -1.0)
        if self.scene.antiplane and of_normal is not None:
            return Spectrum(q, omega, None, of_normal), Spectrum(q, omega, of_shear, None)
        return (Spectrum(q, omega, of_shear, of_normal),)


def _mirrored(quantity: Quantity, antiplane: bool) -> Array:
    """Signs in the lower body of what shear does at the mirrored place in the upper one."""
    if quantity == "stress":
        return np.array([-1.0, -1.0, 1.0, -1.0, 1.0][: 5 if antiplane else 3])
    return np.array([-1.0, 1.0, -1.0][: 3 if antiplane else 2])


def _resampled(lines, times, even):
    after = np.clip(np.searchsorted(times, even), 1, len(times) - 1)
    width = times[after] - times[after - 1]
    share = np.clip((even - times[after - 1]) / width, 0.0, 1.0)[:, None]
    return (1 - share) * lines[after - 1] + share * lines[after]
