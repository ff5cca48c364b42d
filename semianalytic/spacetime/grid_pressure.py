"""Pressure at the nodes of a grid under any load history, by (3.10) and (3.20).

Slip between identical bodies does not change the pressure, so that of the stuck interface holds
(docs/theory.md, "Stuck tractions").
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from semianalytic.halfplane.edge_factors import edge_offset_and_factors
from semianalytic.halfplane.primitives import stuck_primitive
from semianalytic.halfplane.stuck import stuck_traction
from semianalytic.scene.friction import CoulombFriction, ViscousFriction
from semianalytic.scene.loads import Pieces
from semianalytic.scene.scene import Scene
from semianalytic.spacetime.tuning import (
    BLOCK_VALUES,
    EXACT_KINKS,
    FAR_SLOWNESS,
    SLIPPING_EDGE,
    TABLE_BYTES,
    TABLE_ROWS,
    TABLE_SAMPLES,
)

Array = NDArray[np.float64]


def table_bytes(scene: Scene, count: int, steps: float) -> float:
    """Return the size of the table of `GridPressure` for `count` nodes and time steps [bytes]."""
    return TABLE_SAMPLES * steps * count * TABLE_BYTES if _needs_table(scene) else 0.0


def _needs_table(scene: Scene) -> bool:
    """Return whether the pressure history has waves, or too many kinks to treat each exactly."""
    pieces = scene.pressure_history.pieces
    load = scene.superposition.taken_off
    return bool(load.pressure and (pieces.waves or len(pieces.kinks) > EXACT_KINKS))


def knows_slipping_edge(scene: Scene) -> bool:
    """Return whether the pressure beside an edge that slips has its own form in a march.

    It has if the pressure jumps and is constant in between, and friction is the pressure times a
    constant but for a viscous part.
    """
    pieces = scene.pressure_history.pieces
    jumps_only = bool(pieces.jumps) and not pieces.kinks and not pieces.waves
    dry = isinstance(scene.friction_law, CoulombFriction | ViscousFriction)
    return bool(scene.superposition.taken_off.pressure) and jumps_only and dry


def spilled_pressure(scene: Scene, spacing: float, times: Array) -> Array:
    """Return the pressure that an edge which slips leaves on the last nodes of the slot, (l, m).

    It belongs to the pressure of `GridPressure.block` with `slipping`.

    Parameters
    ----------
    scene : Scene
        One that `knows_slipping_edge`.
    spacing : float
        Node distance [length].
    times : (l,) array
        Times [time].
    """
    # p* + 1 = intensity sqrt(u) at the edge, where u = c_t t / x is large
    far = stuck_traction(scene.material.poisson_ratio, "I")(np.array([FAR_SLOWNESS]))[0] + 1
    per = spacing / scene.material.shear_speed * FAR_SLOWNESS
    root = np.zeros(len(times))
    for start, height in scene.pressure_history.pieces.jumps:
        root += height * np.sqrt(np.maximum(times - start, 0.0) / per)
    load = scene.superposition.taken_off.pressure
    return np.asarray(load * float(far) * np.multiply.outer(root, SLIPPING_EDGE[0]))


class PressureRows:
    """The pressure at the nodes at some times, computed a few times at once when asked for.

    Parameters
    ----------
    pressure : GridPressure
        What computes it.
    times : (m,) array
        The times [time].
    """

    def __init__(self, pressure: GridPressure, times: Array) -> None:
        self._pressure, self._times = pressure, times
        self._first, self._slipping, self._block = 0, False, np.zeros((0, 0))

    def __call__(self, row: int, slipping: bool = False) -> Array:
        """Return the pressure at a time by its index, (n,) [stress], positive in compression.

        `slipping` says whether the edge slips, if a scene `knows_slipping_edge`.
        """
        within = self._first <= row < self._first + len(self._block)
        if not within or slipping != self._slipping:
            rows = max(1, BLOCK_VALUES // self._pressure.count)
            self._first, self._slipping = row, slipping
            self._block = self._pressure.block(self._times[row : row + rows], slipping)
        return self._block[row - self._first]


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
        self.spacing, self.count = spacing, count
        held, self._load = (part.pressure for part in scene.superposition)
        self._history = scene.pressure_history
        self._factor = np.ones(count)
        self._factor[: len(factors)] = factors[:count]
        # The grid sees the inverse square root as if its first node were 0.310 h from the edge
        # (docs/theory.md, "The edge on a grid"); the pressure has to be seen in the same way.
        self._x = (np.arange(count) + offset) * spacing
        self._arrival = self._x / scene.material.longitudinal_speed
        self._per = self._x / scene.material.shear_speed
        self._unit = spacing / scene.material.shear_speed
        near = np.array(SLIPPING_EDGE[1])[:count]
        self._slipping_factor = np.ones(count)
        self._slipping_factor[: len(near)] = near * np.sqrt(np.arange(len(near)) + 0.5)
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
        return self.over(np.array([t]))(0)

    def over(self, times: Array) -> PressureRows:
        """Return the pressure at all of these times, computed some rows at a time."""
        return PressureRows(self, times)

    def block(self, times: Array, slipping: bool) -> Array:
        """Return the pressure at a few times, (m, n) [stress].

        Beside an edge that sticks the grid sees the singular pressure at its own edge.  Friction at
        one that slips is a traction that is given: it has to have the resultant and moment of the
        exact one, and the slip rate that this one causes (`SLIPPING_EDGE`).
        """
        if self._load == 0:
            return np.broadcast_to(self._held, (len(times), len(self._held)))
        response = np.zeros((len(times), len(self._x)))
        if slipping:
            per = self._per + (0.5 - self._per[0] / self._unit) * self._unit
            arrival = per * self._arrival[0] / self._per[0]
        else:
            per, arrival = self._per, self._arrival
        self._add(response, times, self._pieces.jumps, lambda u, per: self._stuck(u), per, arrival)
        self._add(
            response, times, self._kinks, lambda u, per: per * self._primitive(u), per, arrival
        )
        if len(self._table):
            at = times / self._interval
            low = np.minimum(at.astype(int), self._rows - 1)
            step = self._table[low + 1] - self._table[low]
            response += self._table[low] + (at - low)[:, None] * step
        # Singular at the edge is the response together with the load: that sum vanishes on the
        # slot faces.  Only it is multiplied by the factors of the grid's first nodes.
        load = self._history.value(times)[:, None]
        factor = self._slipping_factor if slipping else self._factor
        return np.asarray(self._held + self._load * ((response + load) * factor - load))

    def _add(
        self,
        response: Array,
        times: Array,
        pieces: tuple[tuple[float, float], ...],
        unit: Callable[[Array, Array], Array],
        per_speed: Array,
        arrival: Array,
    ) -> None:
        """Add to (m, n) responses those to jumps or kinks, of which `unit` is one of height 1."""
        for start, amplitude in pieces:
            lag = times - start
            reached = lag[:, None] > arrival
            if reached.any():
                per = np.broadcast_to(per_speed, reached.shape)[reached]
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
