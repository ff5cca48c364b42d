"""Pressure of the stuck interface at the nodes of a grid, for any load history, (3.10), (3.20)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from semianalytic.edge_factors import edge_offset_and_factors
from semianalytic.loads import Pieces
from semianalytic.primitives import stuck_primitive
from semianalytic.scene import Scene
from semianalytic.stuck import stuck_traction

Array = NDArray[np.float64]

_ROWS = 64
_WAVE_SAMPLES = 2


class GridPressure:
    """Pressure at grid nodes, with the grid's own edge (see `edge_factors`).

    Jumps and kinks of the history are exact: p* and its primitive in slowness.  Waves are replaced
    by their interpolant on half time steps, and convolved with the primitive by FFT; that table
    takes 16 bytes per node and step.

    Parameters
    ----------
    scene : Scene
    count : int
        Contact nodes, the first half a node distance from the edge.
    spacing : float
        Node distance [length].
    end_time, time_step : float
        What a table of waves has to cover, and how finely [time].
    """

    def __init__(
        self, scene: Scene, count: int, spacing: float, end_time: float, time_step: float
    ) -> None:
        offset, factors = edge_offset_and_factors()
        self._scene = scene
        self._factor = np.ones(count)
        self._factor[: len(factors)] = factors[:count]
        self._x = (np.arange(count) + offset) * spacing
        self._arrival = self._x / scene.material.longitudinal_speed
        self._per = self._x / scene.material.shear_speed
        self._pieces = scene.pressure_history.pieces if scene.step.pressure else Pieces()
        nu = scene.material.poisson_ratio
        self._stuck, self._primitive = stuck_traction(nu, "I"), stuck_primitive(nu, "I")
        self._base = np.full(count, float(scene.base.pressure))
        self._table = np.zeros((0, count))
        if self._pieces.waves:
            self._rows = _WAVE_SAMPLES * int(np.ceil(end_time / time_step))
            self._interval = end_time / self._rows
            self._table = self._wave_table(count)

    def __call__(self, t: float) -> Array:
        """Pressure at time t, (n,) [stress], compressive positive."""
        scene = self._scene
        if scene.step.pressure == 0:
            return self._base
        response = np.zeros(len(self._x))
        for start, height in self._pieces.jumps:
            reached = self._reached(t - start)
            response[reached] += height * self._stuck((t - start) / self._per[reached])
        for start, slope in self._pieces.kinks:
            reached = self._reached(t - start)
            per = self._per[reached]
            response[reached] += slope * per * self._primitive((t - start) / per)
        if len(self._table):
            at = t / self._interval
            low = min(int(at), self._rows - 1)
            response += self._table[low] + (at - low) * (self._table[low + 1] - self._table[low])
        # what is singular at the edge is the response together with the load itself
        load = float(scene.pressure_history.value(t))
        return self._base + scene.step.pressure * ((response + load) * self._factor - load)

    def _reached(self, lag: float) -> slice:
        return slice(0, int(np.searchsorted(self._arrival, lag)))

    def _wave_table(self, count: int) -> Array:
        """Response to the waves, (rows + 1, n): kinks of their interpolant times the primitive."""
        from scipy.fft import irfft, next_fast_len, rfft

        t = self._interval * np.arange(self._rows + 1)
        samples = np.sum([wave.value(t) for wave in self._pieces.waves], axis=0)
        kinks = np.diff(samples, prepend=0.0, append=samples[-1])[1:] / self._interval
        kinks[1:] -= kinks[:-1].copy()
        size = next_fast_len(2 * len(t), real=True)
        transform = rfft(kinks, size)
        table = np.empty((len(t), count))
        for first in range(0, count, _ROWS):
            per = self._per[first : first + _ROWS, None]
            ramps = per * self._primitive(t / per)
            full = irfft(transform * rfft(ramps, size, axis=1), size, axis=1)
            table[:, first : first + _ROWS] = full[:, : len(t)].T
        return table
