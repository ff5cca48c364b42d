"""Slip under any load history: the interface alone, marched in time on a spectral grid.

On the whole line y = 0, slot included, the shear traction is (4.40), with the sign of section 6,

    tau = Q_b - (rho c_t / 2) [V + int h(q c_t (t - s)) q c_t V ds]   for each wavenumber q,

with V the relative slip rate and h from `exponentials`.  On the slot tau is prescribed, which
gives V; on the contact V is what Coulomb's law leaves of the traction that would stop the point.
V is linear in time over a step; the memory of its end value is small and iterated twice, which
converges while that of the shortest wave stays below the local term (`feedback` < 1).  Short waves
are damped by raising their feedback: by (q/q_max)^4, so that what is resolved is left alone.

Cosines about both ends of the grid mirror the scene: nothing that starts at x = 0 comes back from
the mirrors to the observed length before the latest time.  Jumps of the loads fall on time levels.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise
from numbers import Integral

import numpy as np
from numpy.typing import NDArray

from semianalytic.errors import ComputationError, SceneError, TensionError
from semianalytic.exponentials import Memory, fit_memory
from semianalytic.friction import CoulombFriction, RateWeakening, SlipWeakening
from semianalytic.grid_pressure import GridPressure
from semianalytic.history import InterfaceHistory
from semianalytic.marched import Grid, Marched, MarchState, MarchStatistics
from semianalytic.scene import Scene

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

_SWEEPS = 2
_LARGEST_STEP_RATIO = 2.0
_LARGEST_FEEDBACK = 0.95
_MARGIN = 8
_CELLS_PER_WEAKENING = 2.0


def causal_grid(scene: Scene, latest: float, length: float, nodes: int) -> Grid:
    """The smallest grid whose mirrors are out of reach of 0 < x < length until `latest`."""
    from scipy.fft import next_fast_len

    spacing = length / nodes
    reach = scene.material.longitudinal_speed * latest
    contact = math.ceil(max(length, (reach + length) / 2) / spacing) + _MARGIN
    slot = math.ceil(reach / 2 / spacing) + _MARGIN
    size = next_fast_len(contact + slot, real=True)
    return Grid(spacing, size - contact, nodes, size)


class _Recursion:
    """What the past exerts, carried over steps of one length by one number per pole and cosine.

    Between `enter` and `leave` the end value of the last step is left out of the numbers, so that
    a step costs one multiplication and one addition each.
    """

    def __init__(self, memory: Memory, phase: Array, damping: float) -> None:
        z = np.multiply.outer(memory.poles, phase)
        first, second = _phi(z)
        weight = memory.residues[:, None] * phase
        self._decay, self._end = np.exp(z), weight * second
        self._gain = weight * (first - second) + self._decay * self._end
        self._half = memory.static * phase / 2
        self._scratch = np.empty_like(z)
        feedback = self._end.real.sum(axis=0) + self._half
        shortest = float(feedback[-1])
        if shortest >= _LARGEST_FEEDBACK:
            raise SceneError(
                "march: step_ratio is beyond the stable range for this Poisson ratio; lower it by "
                f"{math.ceil(100 * (1 - math.sqrt(_LARGEST_FEEDBACK / shortest)))} %."
            )
        self.feedback = feedback + max(damping - shortest, 0.0) * (phase / phase[-1]) ** 4

    def enter(self, modes: Complex, lasting: Array, rate: Array) -> None:
        """Begin steps of this length at a rate (size,), in place."""
        modes -= self._end * rate
        lasting -= self._half * rate

    def step(self, modes: Complex, lasting: Array, rate: Array) -> None:
        """Step on in place, all but the end value; rate is that of the start, (size,)."""
        modes *= self._decay
        np.multiply(self._gain, rate, out=self._scratch)
        modes += self._scratch
        lasting += 2 * self._half * rate

    def leave(self, modes: Complex, lasting: Array, rate: Array) -> None:
        """Add the end value in place."""
        modes += self._end * rate
        lasting += self._half * rate


def _exerted(modes: Complex, lasting: Array) -> Array:
    """What the past exerts, per cosine (size,), over rho c_t / 2."""
    return np.asarray(modes.real.sum(axis=0) + lasting)


def _phi(z: Complex) -> tuple[Complex, Complex]:
    """(e^z - 1)/z and (e^z - 1 - z)/z^2."""
    small = np.abs(z) < 1e-2
    large = np.where(small, 1.0, z)
    first = (np.exp(large) - 1) / large
    second = (first - 1) / large
    series = 0.5 + z / 6 * (1 + z / 4 * (1 + z / 5))
    return np.where(small, 1 + z * series, first), np.where(small, series, second)


@dataclass(frozen=True)
class _Interface:
    """Which slip rate goes with the traction that would stop each node."""

    scene: Scene
    slot: int
    impedance: float

    def slip_rate(self, stopping: Array, load: float, pressure: Array, path: Array) -> Array:
        """Relative slip rate of all nodes (size,) [length / time].

        Parameters
        ----------
        stopping : (size,) array
            Shear traction at which a node would not move [stress].
        load : float
            Q_0 f(t) [stress].
        pressure : (contact,) array
            On the contact [stress].
        path : (contact,) array
            Accumulated |slip| [length].
        """
        rate = np.empty(len(stopping))
        slot = self.slot
        rate[:slot] = stopping[:slot] - (self.scene.base.shear - load)
        contact = stopping[slot:]
        law, strength = self.scene.friction_law, self.scene.friction * pressure
        if isinstance(law, CoulombFriction):
            rate[slot:] = contact - np.clip(contact, -strength, strength)
            return rate / self.impedance
        if isinstance(law, RateWeakening):
            # impedance V = |contact| - f p (1 - reduction V/(V + rate)), a quadratic
            excess = np.abs(contact) - strength
            lost = law.reduction * strength
            scale = self.impedance * law.rate
            middle = excess + lost - scale
            root = np.sqrt(np.maximum(middle**2 + 4 * scale * excess, 0.0))
            rate[slot:] = np.where(excess > 0, np.copysign((middle + root) / 2, contact), 0.0)
            return rate / self.impedance
        strength = strength * law.factor(0.0, path)
        rate[slot:] = contact - np.clip(contact, -strength, strength)
        return rate / self.impedance


def march(
    scene: Scene,
    end_time: float | None = None,
    nodes: int = 1000,
    *,
    length: float | None = None,
    latest: float | None = None,
    step_ratio: float = 0.5,
    damping: float = 0.7,
    every: int = 1,
    tolerance: float = 1e-6,
    progress: Callable[[int, int], object] | None = None,
) -> Marched:
    """March the interface of a scene in time, under any load history and friction law.

    Memory is 64 bytes per pole (about 25) and grid node (about 1.5 per contact node), and 32
    bytes per stored node and level (see `GridPressure` for pressure that oscillates); time grows
    like nodes^2.

    Parameters
    ----------
    scene : Scene
    end_time : float, optional
        T [time]; by default the time a shear wave takes over a length of 1.
    nodes : int
        Contact nodes on 0 < x < length, at least 16.
    length : float, optional
        Length of the contact that is observed [length]; c_l T unless given.
    latest : float, optional
        Time to which `march_on` may be asked to go on [time]; end_time unless given.  The grid is
        made for it.
    step_ratio : float
        Largest c_t dt / h; stable below about 0.57 (nu near 0.5) to 0.7 (nu = 1/3) and more.
    damping : float
        Least feedback of the shortest wave, 0 (none) ... 0.95.
    every : int
        Store every n-th time level; the last is always stored.
    tolerance : float
        Relative error of the memory's transform, above 1e-11 and up to 1e-2.
    progress : callable, optional
        Called with (step, steps) after each step; if it returns True the march ends there, and
        can go on with `march_on`.

    Raises
    ------
    SceneError
        If an option is out of range, the step is beyond the stable range, rate weakening is ill
        posed at a pressure that arises, or the grid does not resolve slip weakening.
    TensionError
        If the pressure turns tensile at a node.
    ComputationError
        If the memory cannot be fitted or values are no longer finite.
    """
    material = scene.material
    end_time = 1 / material.shear_speed if end_time is None else end_time
    _check_range("end_time", end_time, 0.0, math.inf)
    length = material.longitudinal_speed * end_time if length is None else length
    _check_range("length", length, 0.0, math.inf)
    latest = end_time if latest is None else latest
    _check_range("latest", latest, math.nextafter(end_time, 0.0), math.inf)
    _check_range("step_ratio", step_ratio, 0.0, _LARGEST_STEP_RATIO)
    if not (isinstance(damping, (int, float)) and 0 <= damping <= _LARGEST_FEEDBACK):
        raise SceneError(f"march: damping must lie between 0 and 0.95, got {damping!r}.")
    _check_range("tolerance", tolerance, 1e-11, 1e-2)
    _check_count("nodes", nodes, 16)
    _check_count("every", every, 1)
    started = time.perf_counter()
    grid = causal_grid(scene, latest, length, nodes)
    _check_resolved(scene, grid.spacing)
    horizon = grid.wavenumbers[-1] * material.shear_speed * latest
    memory = fit_memory(material.shear_speed / material.longitudinal_speed, horizon, tolerance)
    empty = np.zeros((0, grid.observed))
    at_rest = Marched(
        scene=scene,
        interface=InterfaceHistory(grid.x, np.zeros(0), empty, empty, empty, empty),
        latest=float(latest),
        step_ratio=float(step_ratio),
        damping=float(damping),
        every=int(every),
        statistics=MarchStatistics(
            0, grid.size, len(memory.poles), memory.error, {"setup": 0.0, "steps": 0.0}
        ),
        grid=grid,
        memory=memory,
        state=MarchState.at_rest(len(memory.poles), grid),
    )
    return _advance(at_rest, float(end_time), time.perf_counter() - started, progress)


def march_on(
    marched: Marched, end_time: float, progress: Callable[[int, int], object] | None = None
) -> Marched:
    """Continue a march to a later time, without recomputing anything.

    Raises
    ------
    SceneError
        If the end time is not later, or beyond the `latest` of the first run.
    TensionError, ComputationError
        As `march`.
    """
    _check_range("end_time", end_time, marched.end_time, math.inf)
    if end_time > marched.latest:
        raise SceneError(
            f"march: this run can go on to {marched.latest:.6g}; for more, start again with a "
            "later `latest`."
        )
    return _advance(marched, float(end_time), 0.0, progress)


def _advance(
    marched: Marched,
    end_time: float,
    setup: float,
    progress: Callable[[int, int], object] | None,
) -> Marched:
    """From the state reached to the end time, in segments between jumps of the loads."""
    from scipy.fft import dct, idct

    scene, grid, start = marched.scene, marched.grid, marched.state
    shear_speed = scene.material.shear_speed
    impedance = scene.material.shear_impedance / 2
    contact = slice(grid.slot, grid.size)
    interface = _Interface(scene, grid.slot, impedance)
    segments = _segments(scene, start.time, end_time, marched.step_ratio * grid.spacing)
    steps = sum(count for _, _, count in segments)
    finest = min((end - begin) / count for begin, end, count in segments)
    pressure_at = GridPressure(scene, grid.size - grid.slot, grid.spacing, end_time, finest)
    modes, lasting = start.modes.copy(), start.lasting.copy()
    rate, traction = start.rate, start.traction
    slip, path, work = start.slip, start.path, start.work
    levels: list[float] = []
    rows: list[list[Array]] = []
    began, done, stopped = time.perf_counter(), 0, False

    def stopping(past: Array) -> Array:
        """Traction that would stop every node, (size,) [stress]."""
        return np.asarray(scene.base.shear - impedance * idct(past, type=2))

    def store(now: float) -> None:
        fields = (slip, rate[contact], traction, pressure)
        levels.append(now)
        rows.append([field[: grid.observed].copy() for field in fields])

    for begin, end, count in segments:
        if stopped:
            break
        dt = (end - begin) / count
        recursion = _Recursion(marched.memory, grid.wavenumbers * shear_speed * dt, marched.damping)
        pressure = pressure_at(begin)
        if begin == 0 or begin in _jumps(scene):
            # a jump of the loads acts at once
            stop = stopping(_exerted(modes, lasting))
            rate = interface.slip_rate(stop, _shear_load(scene, begin, after=True), pressure, path)
            traction = stop[contact] - impedance * rate[contact]
        transform = dct(rate, type=2)
        recursion.enter(modes, lasting, transform)
        if begin == 0:
            store(0.0)
        for step in range(1, count + 1):
            now = begin + step * dt if step < count else end
            load, pressure = _shear_load(scene, now), pressure_at(now)
            _check_pressure(scene, pressure, grid.spacing, now)
            recursion.step(modes, lasting, transform)
            past = _exerted(modes, lasting)
            before, power, walked = rate[contact], traction * rate[contact], path
            for _ in range(_SWEEPS):
                stop = stopping(past + recursion.feedback * transform)
                rate = interface.slip_rate(stop, load, pressure, walked)
                walked = path + dt / 2 * (np.abs(before) + np.abs(rate[contact]))
                transform = dct(rate, type=2)
            traction = stop[contact] - impedance * rate[contact]
            path, slip = walked, slip + dt / 2 * (before + rate[contact])
            work = work + dt / 2 * (power + traction * rate[contact])
            if not math.isfinite(float(transform[0])):
                raise ComputationError(
                    f"the march lost its finite values at t = {now:.4g}; lower step_ratio."
                )
            done += 1
            stopped = progress is not None and progress(done, steps) is True
            if (marched.statistics.steps + done) % marched.every == 0 or done == steps or stopped:
                store(now)
            if stopped:
                break
        recursion.leave(modes, lasting, transform)
    earlier = marched.interface
    return replace(
        marched,
        interface=InterfaceHistory(
            grid.x,
            np.concatenate([earlier.t, levels]),
            *(
                np.concatenate([old, new])
                for old, new in zip(
                    (earlier.slip, earlier.slip_rate, earlier.shear_traction, earlier.pressure),
                    np.swapaxes(rows, 0, 1),
                    strict=True,
                )
            ),
        ),
        statistics=replace(
            marched.statistics,
            steps=marched.statistics.steps + done,
            nodes=grid.size,
            seconds={
                "setup": marched.statistics.seconds["setup"] + setup,
                "steps": marched.statistics.seconds["steps"] + time.perf_counter() - began,
            },
        ),
        state=MarchState(now, modes, lasting, rate, traction, slip, path, work),
    )


def _segments(
    scene: Scene, start: float, end: float, largest: float
) -> list[tuple[float, float, int]]:
    """Begin, end and number of steps of the spans between jumps of the loads.

    `largest` is the largest c_t dt [length].
    """
    ends = [start, *(at for at in _jumps(scene) if start < at < end), end]
    speed = scene.material.shear_speed
    return [
        (begin, until, max(1, math.ceil(speed * (until - begin) / largest)))
        for begin, until in pairwise(ends)
    ]


def _jumps(scene: Scene) -> list[float]:
    """Times at which a load jumps, in order [time]."""
    loads = (scene.step.pressure, scene.pressure_history), (scene.step.shear, scene.shear_history)
    return sorted({at for load, history in loads if load for at, _ in history.pieces.jumps})


def _shear_load(scene: Scene, t: float, *, after: bool = False) -> float:
    """Q_0 f(t) [stress], at a jump before or after it."""
    t = math.nextafter(t, math.inf) if after else t
    return scene.step.shear * float(scene.shear_history.value(t))


def _check_pressure(scene: Scene, pressure: Array, spacing: float, t: float) -> None:
    if scene.step.pressure == 0:
        return
    node = int(np.argmin(pressure))
    if pressure[node] < 0:
        raise TensionError(
            f"the pressure would turn tensile at x = {(node + 0.5) * spacing:.4g}, t = {t:.4g}; "
            "raise the base pressure, or simulate the scene with finite elements, which open."
        )
    scene.check_weakening(float(pressure.max()))


def _check_resolved(scene: Scene, spacing: float) -> None:
    """Raise if slip weakening is so sharp that the grid, not the law, would set its length."""
    law = scene.friction_law
    if not isinstance(law, SlipWeakening):
        return
    drop = scene.friction * scene.base.pressure * law.reduction
    if not drop:
        return
    material = scene.material
    zone = material.shear_modulus * law.distance / ((1 - material.poisson_ratio) * drop)
    if zone < _CELLS_PER_WEAKENING * spacing:
        raise SceneError(
            f"march: friction weakens within about {zone:.3g} of length, which nodes {spacing:.3g} "
            f"apart do not resolve; give {_CELLS_PER_WEAKENING * spacing / zone:.2g} times as many."
        )


def _check_range(name: str, value: float, low: float, high: float) -> None:
    """Raise SceneError unless low < value <= high, and finite."""
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if not (number and math.isfinite(value) and low < value <= high):
        limit = f" and at most {high:g}" if math.isfinite(high) else ""
        raise SceneError(f"march: {name} must be above {low:g}{limit}, got {value!r}.")


def _check_count(name: str, value: int, least: int) -> None:
    if isinstance(value, bool) or not isinstance(value, Integral) or value < least:
        raise SceneError(f"march: {name} must be a whole number from {least}, got {value!r}.")
