"""Loads at the nodes of a grid: pressure under any history, and fronts that move over the nodes.

Slip between identical bodies does not change the pressure, so that of the stuck interface holds,
(3.10) and (3.20) (docs/theory.md, "Stuck tractions").  Under a load that comes everywhere at once
it is evaluated (`GridPressure`), under a front that moves it is marched (`FrontPressure`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from semianalytic.engine.stepping.means import damped
from semianalytic.halfplane.edge_factors import edge_offset_and_factors
from semianalytic.halfplane.primitives import stuck_primitive
from semianalytic.halfplane.stuck import stuck_traction
from semianalytic.memory.cosines import cosines, from_cosines
from semianalytic.memory.exponentials import Memory
from semianalytic.memory.line_memory import LineMemory
from semianalytic.scene.loads import LoadHistory, Pieces
from semianalytic.scene.scene import Scene

SWEEPS = 2
"""Iterations of a step, even: with 1 or 3 marches grow; 4 change slip rates by up to 4e-5."""
EXACT_KINKS = 4
"""Kinks treated exactly: 4 take 2.6 s, 8 take 6.4 s (1,500 nodes), a table of any number 3 s."""
TABLE_SAMPLES = 2
"""Samples of the table per time step, so that a kink is spread over half a step."""
TABLE_ROWS = 64
"""Nodes whose responses are convolved at once, to stay in the cache."""

Array = NDArray[np.float64]


def table_bytes(scene: Scene, count: int, steps: float) -> float:
    """Return the size of the table of `GridPressure` for `count` nodes and time steps [bytes]."""
    return TABLE_SAMPLES * steps * count * 8 if _needs_table(scene) else 0.0  # bytes of a number


def _needs_table(scene: Scene) -> bool:
    """Return whether the pressure history has waves, or too many kinks to treat each exactly."""
    pieces = scene.pressure_history.pieces
    load = scene.superposition.taken_off
    return bool(load.pressure and (pieces.waves or len(pieces.kinks) > EXACT_KINKS))


class GridPressure:
    """The contact pressure at grid nodes, seen as the grid sees its own edge (`edge_factors`).

    Jumps of the history are treated exactly, with p*, and so are kinks if they are few, with the
    primitive of p* in slowness.  Waves and the kinks of tables are replaced by functions that are
    linear between half time steps: waves by their interpolant, each kink by two neighbouring ones
    of the same sum and first moment.  Their kinks are convolved with the primitive by FFT; the
    table takes 16 bytes per node and step.

    Parameters
    ----------
    scene : Scene
        Material, pressure history and tractions.
    count : int
        Contact nodes, the first half a node distance from the edge.
    spacing : float
        Node distance [length].
    end_time, time_step : float
        Last time and resolution of the table of waves [time].
    """

    def __init__(
        self, scene: Scene, count: int, spacing: float, end_time: float, time_step: float
    ) -> None:
        offset, factors = edge_offset_and_factors()
        self.spacing = spacing
        held, self._load = (part.pressure for part in scene.superposition)
        # a wave of normal incidence that is no step: the contact carries base and f times its load
        self._arriving = scene.arrives and not scene.is_step
        held = scene.before_load.pressure if self._arriving else held
        self._history = scene.pressure_history
        self._factor = np.ones(count)
        self._factor[: len(factors)] = factors[:count]
        # The grid sees the inverse square root as if its first node were 0.310 h from the edge
        # (docs/theory.md, "The edge on a grid"); the pressure has to be seen in the same way.
        self._x = (np.arange(count) + offset) * spacing
        self._arrival = self._x / scene.material.longitudinal_speed
        self._per = self._x / scene.material.shear_speed
        self._pieces = self._history.pieces if self._load else Pieces()
        nu = scene.material.poisson_ratio
        self._stuck, self._primitive = stuck_traction(nu, "I"), stuck_primitive(nu, "I")
        self._held = np.full(count, held)
        self._table = np.zeros((0, count))
        self._kinks = self._pieces.kinks
        if _needs_table(scene):
            self._kinks = self._kinks if len(self._kinks) <= EXACT_KINKS else ()
            self._rows = TABLE_SAMPLES * int(np.ceil(end_time / time_step))
            self._interval = end_time / self._rows
            self._table = self._response_table(count)

    def __call__(self, t: float) -> Array:
        """Return the pressure at time t, (n,) [stress], positive in compression."""
        return next(self.over(np.array([t])))

    def over(self, times: Array) -> Iterator[Array]:
        """Yield the pressure at one time after the other, (n,) each [stress]."""
        rows = max(1, (1 << 16) // len(self._x))  # pressures that stay in the cache
        arrived = self._load * self._history.value(times)
        # after a jump at the first time
        arrived[0] = self._load * self._history.value(math.nextafter(times[0], math.inf))
        for first in range(0, len(times), rows):
            part = slice(first, first + rows)
            for pressure, more in zip(self._block(times[part]), arrived[part], strict=True):
                yield pressure + more if self._arriving else pressure

    def _block(self, times: Array) -> Iterator[Array]:
        """Yield the pressure at a few times, for which it is computed at once."""
        if self._load == 0:
            yield from (self._held for _ in times)
            return
        response = np.zeros((len(times), len(self._x)))
        self._add(response, times, self._pieces.jumps, lambda u, per: self._stuck(u))
        self._add(response, times, self._kinks, lambda u, per: per * self._primitive(u))
        if len(self._table):
            at = times / self._interval
            low = np.minimum(at.astype(int), self._rows - 1)
            step = self._table[low + 1] - self._table[low]
            response += self._table[low] + (at - low)[:, None] * step
        # Singular at the edge is the response together with the load: that sum vanishes on the
        # slot faces.  Only it is multiplied by the factors of the grid's first nodes.
        load = self._history.value(times)[:, None]
        yield from self._held + self._load * ((response + load) * self._factor - load)

    def _add(
        self,
        response: Array,
        times: Array,
        pieces: tuple[tuple[float, float], ...],
        unit: Callable[[Array, Array], Array],
    ) -> None:
        """Add to (m, n) responses those to jumps or kinks, of which `unit` is one of height 1."""
        for start, amplitude in pieces:
            lag = times - start
            reached = lag[:, None] > self._arrival
            if reached.any():
                per = np.broadcast_to(self._per, reached.shape)[reached]
                u = np.broadcast_to(lag[:, None], reached.shape)[reached] / per
                response[reached] += amplitude * unit(u, per)

    def _response_table(self, count: int) -> Array:
        """Return the response to waves and many kinks at even times, (rows + 1, n)."""
        from scipy.fft import irfft, next_fast_len, rfft

        t: Array = self._interval * np.arange(self._rows + 1, dtype=float)
        kinks = self._grid_kinks(t)
        size = next_fast_len(2 * len(t), real=True)
        transform = rfft(kinks, size)
        table = np.empty((len(t), count))
        for first in range(0, count, TABLE_ROWS):
            per = self._per[first : first + TABLE_ROWS, None]
            ramps = np.zeros((len(per), len(t)))
            reached = t > self._arrival[first : first + TABLE_ROWS, None]
            # a ramp of slope 1 from t = 0 on: x / c_t times the primitive of p* at u = c_t t / x
            u = (t / per)[reached]
            ramps[reached] = np.broadcast_to(per, reached.shape)[reached] * self._primitive(u)
            full = irfft(transform * rfft(ramps, size, axis=1), size, axis=1)
            table[:, first : first + TABLE_ROWS] = full[:, : len(t)].T
        return table

    def _grid_kinks(self, t: Array) -> Array:
        """Return the changes of slope at the table's times that stand for waves and kinks.

        The shape is (rows + 1,).
        """
        samples = np.sum([wave.value(t) for wave in self._pieces.waves], axis=0) + 0 * t
        kinks = np.diff(samples, prepend=0.0, append=samples[-1])[1:] / self._interval
        kinks[1:] -= kinks[:-1].copy()  # slopes to changes of slope
        if not self._kinks:
            at, slope = np.array(self._pieces.kinks).reshape(-1, 2).T
            at, slope = at[at < t[-1]] / self._interval, slope[at < t[-1]]
            low = np.minimum(at.astype(int), self._rows - 1)
            # a kink between two times is shared between them: same sum, same first moment
            np.add.at(kinks, low, slope * (low + 1 - at))
            np.add.at(kinks, low + 1, slope * (at - low))
        return kinks


@dataclass(frozen=True)
class GridFront:
    """A load whose front moves along the interface, at all nodes of a grid.

    The front is smeared over a cell, or over the distance that it runs in a step if that is longer:
    a node takes the mean of the history over the time in which the front crosses that distance.
    Then each node receives the whole of the load, whatever the step.

    Attributes
    ----------
    scene : Scene
        Its load is an `IncidentWave` or a `MovingLoad`.
    x : (size,) array
        Positions of all nodes, slot included [length].
    spacing : float
        Node distance [length].
    slot : int
        Number of nodes on the slot.
    entry : float
        Distance from the tip at which a load that comes along the slot begins [length].
    """

    scene: Scene
    x: Array
    spacing: float
    slot: int
    entry: float

    @cached_property
    def _loaded(self) -> Array:
        """The part of the cell of each node that the load reaches, (size,)."""
        if self.scene.front_slowness < 0:
            return np.ones(len(self.x))
        return np.clip((self.x + self.entry) / self.spacing + 0.5, 0.0, 1.0)

    def tractions(
        self, name: Literal["pressure", "shear"], t: float, step: float
    ) -> tuple[float | Array, float | Array]:
        """Return a traction of the uncut interface, and that which the slot faces keep [stress].

        Parameters
        ----------
        name : str
            "pressure" or "shear".
        t, step : float
            Time, and the length of the time steps [time].

        Returns
        -------
        (size,) array or float, (slot,) array or float
            An incident wave changes the first, a moving load the second.
        """
        base, scene = getattr(self.scene.before_load, name), self.scene
        history: LoadHistory = getattr(scene, f"{name}_history")
        slowness = scene.front_slowness
        lag, half = t - slowness * self.x, max(abs(slowness) * self.spacing, step) / 2
        load = getattr(scene.superposition.taken_off, name) * self._loaded
        load = load * history.mean(lag - half, lag + half)
        return (base + load, base) if scene.arrives else (base, base - load[: self.slot])


class FrontPressure:
    """The contact pressure at grid nodes under a front that moves, marched as shear is.

    The contact stays closed and the slot faces keep their pressure, so that what would open the
    slot is known at once.  The grid sees the edge of this problem as it sees that of shear.

    Parameters
    ----------
    front : GridFront
        The load at the nodes.
    memory : Memory
        That of an opening rate, `exponentials.Opening`.
    wavenumbers : (size,) array
        Those of the cosines of the grid [1 / length].
    damping : float
        Least feedback of the shortest wave.
    start, step : float
        Time at which the load begins, and the largest time step before the first time of `over`
        [time].
    """

    def __init__(
        self,
        front: GridFront,
        memory: Memory,
        wavenumbers: Array,
        damping: float,
        start: float,
        step: float,
    ) -> None:
        material, size = front.scene.material, len(wavenumbers)
        self.spacing = front.spacing
        self._front, self._damping, self._wavenumbers = front, damping, wavenumbers
        self._impedance = material.density * material.longitudinal_speed / 2
        self._speed = material.shear_speed
        self._time, self._step = start, step
        self._memory, self._transform = LineMemory(memory, wavenumbers), np.zeros((1, size))
        self._pressure = self._level(start, step, np.zeros(size), np.zeros(size), 1)

    def over(self, times: Array) -> Iterator[Array]:
        """Yield the pressure at evenly spaced times, (contact,) each [stress].

        They go on from those before; times between are stepped through.
        """
        if self._time < times[0]:
            steps = math.ceil((times[0] - self._time) / self._step)
            for _ in self._steps(np.linspace(self._time, times[0], steps + 1)):
                pass
        yield from self._steps(times)

    def _steps(self, times: Array) -> Iterator[Array]:
        """Yield the pressure at the time reached, and at one level after the other."""
        step = (times[-1] - times[0]) / (len(times) - 1)
        self._memory.settle(self._transform)
        length = self._speed * step
        feedback = damped(self._memory.table(length).feedback[0], self._wavenumbers, self._damping)
        yield self._pressure
        for t in times[1:].tolist():
            past = self._memory.advance(self._transform, length)[0, 0]
            self._pressure = self._level(t, step, past, feedback, SWEEPS)
            self._time = t
            yield self._pressure

    def _level(self, t: float, step: float, past: Array, feedback: Array, sweeps: int) -> Array:
        """Return the pressure at a level, (contact,), and note the opening rate of the slot."""
        slot, rate, whole = self._front.slot, np.zeros(len(past)), np.empty(len(past))
        uncut, kept = self._front.tractions("pressure", t, step)
        for _ in range(sweeps):
            from_cosines(past + feedback * self._transform[0], whole)
            closed = uncut - self._impedance * whole
            rate[:slot] = (closed[:slot] - kept) / self._impedance
            cosines(rate, self._transform[0])
        return np.asarray(closed[slot:])
