"""The plane wave of an incident load, which an interface that holds does not scatter."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from semianalytic.scene.incident import IncidentWave
from semianalytic.scene.loads import LoadHistory, Step
from semianalytic.scene.material import Material

Array = NDArray[np.float64]


def plane_wave(
    wave: IncidentWave,
    solid: Material,
    quantity: Literal["velocity", "stress", "displacement"],
    at: tuple[ArrayLike, ArrayLike, ArrayLike],
    history: LoadHistory | None = None,
) -> Array:
    """Return what a wave makes of a quantity, rows x, y, z or xx, yy, xy, xz, yz, (n, ...).

    Parameters
    ----------
    wave : IncidentWave
        Its front is at x = 0 of the interface at t = 0.
    solid : Material
    quantity : {"velocity", "stress", "displacement"}
    at : three arrays
        x, y [length] and t [time].
    history : LoadHistory, optional
        Factor over the time since the front; a step by default.
    """
    n_x, n_y = (component / wave.speed(solid) for component in wave.direction())
    x, y, t = (np.asarray(values, dtype=float) for values in at)
    lag, pieces = t - n_x * x - n_y * y, (history or Step()).pieces
    if quantity == "displacement":
        moved = wave.particle_velocity(solid) * pieces.integral(lag)
        return np.stack([part * moved for part in wave.polarisation()])
    arrived = pieces.value(np.nextafter(lag, np.inf))
    if quantity == "velocity":
        moved = wave.particle_velocity(solid) * arrived
        return np.stack([part * moved for part in wave.polarisation()])
    sigma = wave.stresses(solid)
    return np.stack([sigma[name] * arrived for name in ("xx", "yy", "xy", "xz", "yz")])
