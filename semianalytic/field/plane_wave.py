"""The plane wave of an incident load, which an interface that holds does not scatter."""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.dissimilar.bonded import bonded_waves, stresses
from semianalytic.halfplane.hilbert import analytic
from semianalytic.scene.arrays import Array
from semianalytic.scene.incident import IncidentWave
from semianalytic.scene.loads import LoadHistory, Step
from semianalytic.scene.material import Material


def plane_wave(
    wave: IncidentWave,
    bodies: tuple[Material, ...],
    quantity: Literal["velocity", "stress", "displacement"],
    at: tuple[ArrayLike, ArrayLike, ArrayLike],
    history: LoadHistory | None = None,
) -> Array:
    """Return what a wave makes of a quantity, rows x, y, z or xx, yy, xy, xz, yz, (n, ...).

    Displacement is that since t = 0 where waves run ahead of the front, beyond a critical angle.

    The front of the wave is at x = 0 of the interface at t = 0; the bodies are the upper solid, and
    the lower one if it is another, to which it is bonded; the points are x, y [length] and t
    [time]; the history is the factor over the time since the front, a step by default.
    """
    x, y, t = np.broadcast_arrays(*(np.asarray(values, dtype=float) for values in at))
    history, still = history or Step(), quantity == "displacement"
    rows = np.zeros((5 if quantity == "stress" else 3, *x.shape))
    everywhere = np.ones(x.shape, dtype=bool)
    if len(bodies) == 1:
        n_x, n_y = (component / wave.speed(bodies[0]) for component in wave.direction())
        sizes = np.multiply(wave.particle_velocity(bodies[0]), wave.polarisation())
        if quantity == "stress":
            sizes = np.array([*wave.stresses(bodies[0]).values()])
        parts: list[Any] = [((n_x, n_y), sizes, everywhere)]
    else:
        parts = []
        for entry in bonded_waves(wave, bodies[0], bodies[1]):
            sizes = np.array([*entry.motion, 0.0])
            if quantity == "stress":
                sizes = np.array([*stresses(bodies[not entry.is_above], entry), 0.0, 0.0])
            parts.append((entry.slowness, sizes, np.signbit(y) != entry.is_above))
    decays = any(np.imag(slowness[1]) or np.imag(sizes).any() for slowness, sizes, _ in parts)
    for (p, q), sizes, here in parts:
        lag = (t - np.real(p) * x - np.real(q) * y)[here]
        if decays:
            late = 1j * np.abs(np.imag(q) * y[here])
            arrived = analytic(history, lag + late, int(still))
            if still:
                arrived -= analytic(history, lag - t[here] + late, 1)
        elif still:
            arrived = history.pieces.integral(lag)
        else:
            arrived = history.pieces.value(np.nextafter(lag, np.inf))
        rows[:, here] += (np.conj(sizes)[:, None] * arrived).real
    return rows
