"""Slip under any load history: the interface alone, marched in time on a spectral grid.

On the whole line y = 0, slot included, the shear traction is (4.40), with the sign of section 6,

    tau = Q_b - (rho c_t / 2) [V + int h(q c_t (t - s)) q c_t V ds]   for each wavenumber q,

with V the relative slip rate and h from `exponentials`.  On the slot tau is prescribed, which
gives V; on the contact V is what Coulomb's law leaves of the traction that would stop the point.
V is linear in time over a step; the memory of its end value is small and iterated twice, which
converges while that of the shortest wave stays below the local term (`feedback` < 1).  Short waves
are damped by raising their feedback: by (q/q_max)^4, so that what is resolved is left alone.

Cosines about both ends of the grid mirror the scene: nothing that starts at x = 0 comes back from
the mirrors to the observed length before the latest time.  Jumps of the loads fall on time levels;
between them a level takes the load at its time, or the exact mean over a step that holds several
samples of a table.  What turns faster than the grid follows is refused (`resolution`).
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.scene.checks import LARGEST, checked_count, checked_number, checked_size
from semianalytic.scene.errors import ComputationError, SceneError, TensionError
from semianalytic.scene.friction import CoulombFriction, RateWeakening, SlipWeakening
from semianalytic.scene.scene import Scene
from semianalytic.spacetime.exponentials import fit_memory
from semianalytic.spacetime.grid_pressure import GridPressure, table_bytes
from semianalytic.spacetime.march_memory import Stored, affordable_every, check_size
from semianalytic.spacetime.marched import Extremes, Grid, Marched, MarchState, MarchStatistics
from semianalytic.spacetime.recursion import LARGEST_FEEDBACK, Recursion, exerted
from semianalytic.spacetime.resolution import MOST_NODES, check_loads, nodes_for_zone

Array = NDArray[np.float64]

_SWEEPS = 2
_LARGEST_STEP_RATIO = 2.0
_MARGIN = 8
_NODES = 1000
_SEVERAL = 2
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
    nodes: int | None = None,
    *,
    length: float | None = None,
    latest: float | None = None,
    step_ratio: float = 0.5,
    damping: float = 0.7,
    every: int = 1,
    tolerance: float = 1e-6,
    memory: float | None = None,
    progress: Callable[[int, int], object] | None = None,
) -> Marched:
    """March the interface of a scene in time, under any load history and friction law.

    Memory is 80 bytes per pole (about 25) and grid node (about 1.5 per contact node), and 32
    bytes per stored node and level (see `GridPressure` for pressure that oscillates); time grows
    like nodes^2.

    Parameters
    ----------
    scene : Scene
    end_time : float, optional
        T [time]; by default the time a shear wave takes over a length of 1.
    nodes : int, optional
        Contact nodes on 0 < x < length, at least 16.  1000 unless given, or up to 8000 where that
        lets the grid follow the loads, or resolve the slip zone at the edge.
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
        Store every n-th time level; the last is always stored.  Raised if all that is stored does
        not fit into the memory: see `Marched.every`.
    tolerance : float
        Relative error of the memory's transform, above 1e-11 and up to 1e-2.
    memory : float, optional
        What the march may take [bytes]; 70 % of what the machine has available unless given.
    progress : callable, optional
        Called with (step, steps) after each step; if it returns True the march ends there, and
        can go on with `march_on`.

    Raises
    ------
    SceneError
        If an option is out of range, the step is beyond the stable range, rate weakening is ill
        posed at a pressure that arises, the grid does not resolve the loads or slip weakening, or
        the march would take more memory than it may.
    TensionError
        If the pressure turns tensile at a node.
    ComputationError
        If the memory cannot be fitted or values are no longer finite.
    """
    material = scene.material
    end_time = 1 / material.shear_speed if end_time is None else end_time
    end_time = checked_size("march: end_time", end_time, "be above 0")
    length = material.longitudinal_speed * end_time if length is None else length
    length = checked_size("march: length", length, "be above 0")
    latest = end_time if latest is None else latest
    latest = _check_range("latest", latest, math.nextafter(end_time, 0.0))
    step_ratio = _check_range("step_ratio", step_ratio, 0.0, _LARGEST_STEP_RATIO)
    damping = checked_number(
        "march: damping",
        damping,
        "lie between 0 and 0.95",
        lambda given: 0 <= given <= LARGEST_FEEDBACK,
    )
    tolerance = _check_range("tolerance", tolerance, 1e-11, 1e-2)
    if nodes is not None:
        nodes = _check_count("nodes", nodes, 16)
    every = _check_count("every", every, 1)
    started = time.perf_counter()
    check_size(scene, latest, length, nodes or _NODES, memory)
    most = MOST_NODES if nodes is None else nodes
    if nodes is None:
        zone = nodes_for_zone(scene, end_time, length)
        nodes = max(_NODES, zone if zone <= MOST_NODES else 0)
    nodes = check_loads(scene, latest, length, nodes, most, step_ratio)
    grid = causal_grid(scene, latest, length, nodes)
    check_size(scene, latest, length, nodes, memory)
    _check_resolved(scene, grid.spacing)
    horizon = grid.wavenumbers[-1] * material.shear_speed * latest
    past = fit_memory(material.shear_speed / material.longitudinal_speed, horizon, tolerance)
    empty = np.zeros((0, grid.observed))
    at_rest = Marched(
        scene=scene,
        interface=InterfaceHistory(grid.x, np.zeros(0), empty, empty, empty, empty),
        latest=latest,
        step_ratio=step_ratio,
        damping=damping,
        every=every,
        statistics=MarchStatistics(
            0, grid.size, len(past.poles), past.error, {"setup": 0.0, "steps": 0.0}
        ),
        grid=grid,
        memory=past,
        state=MarchState.at_rest(len(past.poles), grid),
        seen=Extremes.at_rest(grid.observed),
    )
    return _advance(at_rest, end_time, memory, time.perf_counter() - started, progress)


def march_on(
    marched: Marched,
    end_time: float,
    progress: Callable[[int, int], object] | None = None,
    *,
    memory: float | None = None,
) -> Marched:
    """Continue a march to a later time, without recomputing anything; `memory` as in `march`.

    Raises
    ------
    SceneError
        If the end time is not later, or beyond the `latest` of the first run, or the march would
        take more memory than it may.
    TensionError, ComputationError
        As `march`.
    """
    end_time = _check_range("end_time", end_time, marched.end_time)
    if end_time > marched.latest:
        raise SceneError(
            f"march: this run can go on to {marched.latest:.6g}; for more, start again with a "
            "later `latest`."
        )
    return _advance(marched, end_time, memory, 0.0, progress)


def _advance(
    marched: Marched,
    end_time: float,
    memory: float | None,
    setup: float,
    progress: Callable[[int, int], object] | None,
) -> Marched:
    """From the state reached to the end time, in segments between jumps of the loads."""
    from scipy.fft import dct, idct

    scene, grid, start = marched.scene, marched.grid, marched.state
    shear_speed = scene.material.shear_speed
    impedance = scene.material.shear_impedance / 2
    contact = slice(grid.slot, grid.size)
    observed = slice(grid.slot, grid.slot + grid.observed)
    interface = _Interface(scene, grid.slot, impedance)
    segments = _segments(scene, start.time, end_time, marched.step_ratio * grid.spacing)
    steps = sum(count for _, _, count in segments)
    finest = min((end - begin) / count for begin, end, count in segments)
    contact_nodes = grid.size - grid.slot
    every = affordable_every(
        marched, memory, steps, table_bytes(scene, contact_nodes, end_time / finest)
    )
    pressure_at = GridPressure(scene, contact_nodes, grid.spacing, end_time, finest)
    stored = Stored(marched.interface, grid, marched.statistics.steps, steps, every)
    modes, lasting = start.modes.copy(), start.lasting.copy()
    rate, traction = start.rate, start.traction
    slip, path, work = start.slip, start.path, start.work
    seen, breaks = marched.seen, np.array(scene.shear_history.pieces.breaks)
    recursion: Recursion | None = None
    began, done, stopped = time.perf_counter(), 0, False

    def stopping(past: Array) -> Array:
        """Traction that would stop every node, (size,) [stress]."""
        return np.asarray(scene.base.shear - impedance * idct(past, type=2))

    for begin, end, count in segments:
        if stopped:
            break
        dt, recursion = (end - begin) / count, None  # two of them would take twice the memory
        recursion = Recursion(marched.memory, grid.wavenumbers * shear_speed * dt, marched.damping)
        levels = np.append(begin + dt * np.arange(count), end)
        loads, pressures = _shear_loads(scene, levels, breaks), pressure_at.over(levels)
        pressure = next(pressures)
        if begin == 0 or begin in _jumps(scene):
            # a jump of the loads acts at once
            stop = stopping(exerted(modes, lasting))
            load = scene.load.shear * float(
                scene.shear_history.value(math.nextafter(begin, math.inf))
            )
            rate = interface.slip_rate(stop, load, pressure, path)
            traction = stop[contact] - impedance * rate[contact]
            seen = seen.with_level(begin, begin, *(rate[observed],) * 2, slip[: grid.observed])
        transform = dct(rate, type=2)
        recursion.enter(modes, lasting, transform)
        if begin == 0:
            stored.add(0.0, slip, rate[contact], traction, pressure)
        reached = begin
        for now, load, pressure in zip(levels[1:].tolist(), loads[1:], pressures, strict=True):
            _check_pressure(scene, pressure, grid.spacing, now)
            recursion.step(modes, lasting, transform)
            past = exerted(modes, lasting)
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
                    f"the march lost its finite values at t = {now:.4g}; lower `step_ratio`."
                )
            seen = seen.with_level(
                reached, now, before[: grid.observed], rate[observed], slip[: grid.observed]
            )
            reached, done = now, done + 1
            stopped = progress is not None and progress(done, steps) is True
            if (marched.statistics.steps + done) % every == 0 or done == steps or stopped:
                stored.add(now, slip, rate[contact], traction, pressure)
            if stopped:
                break
        recursion.leave(modes, lasting, transform)
    return replace(
        marched,
        interface=stored.history(),
        every=every,
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
        seen=seen,
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
    histories = scene.acting_histories.values()
    return sorted({at for history in histories for at, _ in history.pieces.jumps})


def _shear_loads(scene: Scene, levels: Array, breaks: Array) -> Array:
    """Q_0 f at evenly spaced levels [stress], at a jump the value before it.

    Where several of the breaks of the history lie within the step around a level, its exact mean.
    """
    history = scene.shear_history
    loads = history.value(levels)
    half = (levels[-1] - levels[0]) / (2 * (len(levels) - 1))
    inner = levels[1:-1]
    held = np.searchsorted(breaks, inner + half) - np.searchsorted(breaks, inner - half)
    means = history.mean(inner - half, inner + half)
    loads[1:-1] = np.where(held >= _SEVERAL, means, loads[1:-1])
    return np.asarray(scene.load.shear * loads)


def _check_pressure(scene: Scene, pressure: Array, spacing: float, t: float) -> None:
    if scene.load.pressure == 0:
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
            "apart do not resolve; raise `nodes` "
            f"{_CELLS_PER_WEAKENING * spacing / zone:.2g} times."
        )


def _check_range(name: str, value: float, low: float, high: float = LARGEST) -> float:
    """A number low < value <= high as float; SceneError if it is not."""
    limit = f" and at most {high:g}" if high < LARGEST else ""
    return checked_number(
        f"march: {name}", value, f"be above {low:g}{limit}", lambda given: low < given <= high
    )


def _check_count(name: str, value: int, least: int) -> int:
    return checked_count(f"march: {name}", value, least, "a whole number from")
