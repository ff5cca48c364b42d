"""Pressure at the nodes of a grid under any load history, by (3.10) and (3.20).

Slip between identical bodies does not change the pressure, so that of the stuck interface holds
(docs/theory.md, "Stuck tractions").
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from semianalytic.halfplane.edge_factors import edge_offset_and_factors
from semianalytic.halfplane.primitives import stuck_primitive
from semianalytic.halfplane.stuck import stuck_traction
from semianalytic.scene.loads import Pieces
from semianalytic.scene.scene import Scene
from semianalytic.spacetime.tuning import (
    BLOCK_VALUES,
    EXACT_KINKS,
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
        rows = max(1, BLOCK_VALUES // len(self._x))
        for first in range(0, len(times), rows):
            yield from self._block(times[first : first + rows])

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
