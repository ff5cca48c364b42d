"""Positions and times at which an answer is asked for, checked in one way for all answers."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from semianalytic.scene.errors import SceneError

Array = NDArray[np.float64]


def finite_times(t: ArrayLike) -> Array:
    """Return times as an array; raise SceneError if one is not finite."""
    return _finite("times", t)


def line_positions(x: ArrayLike) -> Array:
    """Return positions of either sign as an array; raise SceneError if one is not finite."""
    return _finite("positions", x)


def contact_positions(x: ArrayLike) -> Array:
    """Return positions as an array; raise SceneError if one is not positive and finite."""
    x = line_positions(x)
    if np.any(x <= 0):
        raise SceneError("the contact is x > 0; ask for positive positions.")
    return x


def contact_points(x: ArrayLike, t: ArrayLike) -> tuple[Array, Array]:
    """Return positions x > 0 and times as arrays of one shape; raise SceneError for others."""
    x, t = np.broadcast_arrays(contact_positions(x), finite_times(t))
    return x, t


def line_points(x: ArrayLike, t: ArrayLike) -> tuple[Array, Array]:
    """Return positions and times as arrays of one shape; raise SceneError if not finite."""
    x, t = np.broadcast_arrays(line_positions(x), finite_times(t))
    return x, t


def _finite(what: str, values: ArrayLike) -> Array:
    values = np.asarray(values, dtype=float)
    if not np.all(np.isfinite(values)):
        raise SceneError(f"{what} must be finite numbers.")
    return values
