"""Measures of sampled fields: norms, relative errors, zone edges and onset times."""

from __future__ import annotations

import math

import numpy as np

from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.scene.arrays import Array, Mask

NOTHING = 1e-6
"""Part of its unit up to which a value counts as nothing."""
ROUNDING = 1e-9
"""Relative amount by which a position or time may miss a limit on which it lies.  Rounding is
about 1e-16, and the distance of nodes and levels is at least 1e-5 of the largest."""
NARROW = 8
"""Least width, in elements, of a zone, an opening or a gap between zones whose ends are judged; the
mesh at 2h, from which error bars come, has half as many.  Among 60 gaps measured all but one of
those of up to 4.0 elements were bridged by slip, and none of those of 5.7 or more; zones of 5.0
elements were not seen, and those of 5.4 were.  From 8 on, all were seen at 2h as well.  With 4, two
of the 50 scenes of the maps were said to differ; with 16, the default mesh resolves nothing of
`preloaded`'s second zone."""
EARLY = 0.2
"""Initial part of the run, over the end time, that is left out because little is resolved in it."""
SENSE_THRESHOLD = 0.01
"""Part of the largest slip rate above which slip has a sense."""
PROBES = (0.04, 0.25, 0.5, 0.75)
"""Places at which histories are read, over c_t T."""


def within(values: Array, low: float, high: float) -> Mask:
    """Mask of the values between two limits that are not negative, both included.

    A value that differs from a limit by rounding alone is included, so that the choice does not
    depend on the units of length and time.
    """
    return np.asarray((values >= (1 - ROUNDING) * low) & (values <= (1 + ROUNDING) * high))


def nearest(values: Array, place: float) -> int:
    """Index of the value nearest to a place; of two that are equally near but for rounding, the
    first, whatever the unit."""
    distances = np.abs(values - place)
    return int(np.flatnonzero(distances <= distances.min() + ROUNDING * abs(place))[0])


def norm(values: Array, position: Array, order: int, time: Array | None = None) -> float:
    """Norm (∫ |values|^order d position)^(1/order) by the trapezoidal rule, of order 1 or 2.

    Values are (n,) at increasing positions (n,), or (m, n) if they are at times (m,), which are
    integrated over as well.
    """
    integral = np.trapezoid(np.abs(values) ** order, position)
    if time is not None:
        integral = np.trapezoid(integral, time)
    return float(integral ** (1 / order))


def relative_error(
    values: Array, prediction: Array, position: Array, order: int, time: Array | None = None
) -> float:
    """Norm of the difference over the norm of the prediction; infinite where that is zero.

    Both have the form of `norm`.
    """
    size = norm(prediction, position, order, time)
    return norm(values - prediction, position, order, time) / size if size > 0 else math.inf


def is_nothing(values: Array, unit: float) -> bool:
    """Whether a whole field is within 1e-6 of its unit, so that relative errors mean nothing.

    An empty array is nothing.
    """
    return bool(np.abs(values).max(initial=0.0) <= NOTHING * unit)


def first_above(time: Array, values: Array, level: float) -> float | None:
    """First time at which values (m,) are above a level, linear between samples; None if never."""
    late = np.flatnonzero(values > level)
    if not len(late):
        return None
    first = late[0]
    if first == 0:
        return float(time[0])
    pair = slice(first - 1, first + 1)
    return float(np.interp(level, values[pair], time[pair]))


def worn(history: InterfaceHistory) -> tuple[Array, Array]:
    """Accumulated |slip| [length] and frictional work per area [stress length] until the end.

    Both are integrated by the trapezoidal rule over the stored levels, (n,) each.
    """
    rate, traction = history.slip_rate, history.shear_traction
    return (
        np.asarray(np.trapezoid(np.abs(rate), history.t, axis=0)),
        np.asarray(np.trapezoid(rate * traction, history.t, axis=0)),
    )
