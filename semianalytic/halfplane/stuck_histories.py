"""Stress intensity of the stuck interface under any load history, (3.16), (3.20).

Jumps and straight pieces of a history are exact, and so are its waves, by Fresnel integrals.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.halfplane.stuck import stress_intensity
from semianalytic.scene.arrays import Array
from semianalytic.scene.loads import LoadHistory
from semianalytic.scene.scene import Material, Tractions

Response = Callable[[Array], Array]


def superposed(pieces: tuple[tuple[float, float], ...], response: Response, t: Array) -> Array:
    """Return the sum of amplitude * response(t - start) over pieces, in blocks of memory."""
    start, amplitude = np.array(pieces).reshape(-1, 2).T
    total = np.zeros(t.shape)
    # Tables of thousands of samples meet grids of thousands of points: not all at once.
    block = max(1, 500_000 // max(1, t.size))
    for first in range(0, len(start), block):
        part = slice(first, first + block)
        shape = (-1,) + (1,) * t.ndim
        total += np.tensordot(amplitude[part], response(t - start[part].reshape(shape)), 1)
    return total


def _root_response(history: LoadHistory, t: Array) -> Array:
    """Return int f'(s) sqrt(t - s) ds [time^(1/2)]."""
    from scipy.special import fresnel

    pieces = history.pieces
    total = superposed(pieces.jumps, lambda lag: np.sqrt(np.maximum(lag, 0.0)), t)
    # K of a step grows as sqrt(lag); of a ramp it is the integral of that.
    total += superposed(pieces.kinks, lambda lag: 2 / 3 * np.maximum(lag, 0.0) ** 1.5, t)
    for wave in pieces.waves:
        # by parts: int_0^sqrt(lag) wave(lag - r^2) dr
        lag = np.maximum(t - wave.start, 0.0)
        sine, cosine = fresnel(np.sqrt(4 * wave.frequency * lag))
        angle, scale = 2 * np.pi * wave.frequency * lag, np.sqrt(4 * wave.frequency)
        if wave.cosine:
            mixed = np.sqrt(lag) - (np.cos(angle) * cosine + np.sin(angle) * sine) / scale
        else:
            mixed = (np.sin(angle) * cosine - np.cos(angle) * sine) / scale
        total += wave.amplitude * mixed
    return total


def intensity_history(
    history: LoadHistory,
    load: Tractions,
    material: Material,
    t: ArrayLike,
    shear_mode: Literal["II", "III"] = "II",
) -> tuple[Array, Array]:
    """Return (K_I, K_II) under P_0 f(t), Q_0 f(t) of a stuck interface [stress sqrt(length)].

    By (3.13), (3.16), (3.20), exact for every history; K_I > 0 is compression, "III" gives K_III.
    """
    response = _root_response(history, np.asarray(t, dtype=float))
    mode_one, sheared = stress_intensity(material, load, 1.0, shear_mode)
    return mode_one * response, sheared * response
