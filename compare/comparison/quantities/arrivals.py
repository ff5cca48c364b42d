"""Speed of a signal, from its recorded waveform aligned with the predicted one."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
import scipy

from compare.comparison.measures import within
from semianalytic.scene.arrays import Array

Waveform = Callable[[Array], Array]
Table = tuple[Array, Array]

TREND_DEGREE = 2
TRIALS = 61
TABLE = 801
LARGEST_MISFIT = 0.5
LEAST_SAMPLES = TREND_DEGREE + 4


@dataclass(frozen=True)
class FrontWindow:
    """Range of similarity velocities [length / time] around a front."""

    lower: float
    front: float
    upper: float

    def samples(self) -> Array:
        """Evenly spaced velocities across the window, (201,) array [length / time]."""
        return np.linspace(self.lower, self.upper, 201)


def front_window(front: float, others: Iterable[float], reach: float = 0.2) -> FrontWindow:
    """Window around a front that ends half-way to the nearest other front or zone edge.

    All are speeds [length / time]; the reach is its largest half-width over that of the front.
    """
    others = list(others)
    lower = max([(1 - reach) * front, *(0.5 * (front + c) for c in others if c < front)])
    upper = min([(1 + reach) * front, *(0.5 * (front + c) for c in others if c > front)])
    return FrontWindow(lower, front, upper)


def tabulated(prediction: Waveform, window: FrontWindow) -> Table:
    """Return velocities from 0.8 times the lower to 1.25 times the upper end of a window, and the
    predicted waveform there before smearing, (801,) each."""
    velocity = np.linspace(0.8 * window.lower, 1.25 * window.upper, TABLE)
    return velocity, prediction(velocity)


def smeared(table: Table, width: float) -> Waveform:
    """Waveform at evenly spaced velocities [length / time] after damping smears it by a Gaussian.

    The width is its standard deviation [length / time], 0 for none.
    """
    velocity, expected = table
    if width > 0:
        spacing = velocity[1] - velocity[0]
        expected = scipy.ndimage.gaussian_filter1d(expected, width / spacing, mode="nearest")
    return lambda at: np.interp(at, velocity, expected)


def roughness(values: Array, velocity: Array) -> float:
    """Root mean square of a waveform less its best parabola: how strong a front it contains."""
    return _rough(values, _trends(velocity))


def aligned_speed(
    velocity: Array,
    values: Array,
    prediction: Waveform,
    window: FrontWindow,
    misfit: float = LARGEST_MISFIT,
) -> float | None:
    """Speed at which a record shows the front that a prediction has in a window.

    The prediction, stretched to ``prediction(velocity / s)``, is laid over the record, (n,) at
    increasing similarity velocities |x|/t [length / time], in the window around the predicted
    speed; the stretch s that leaves the smallest difference, smooth trends aside, gives the speed,
    s times the predicted one.  It is None if fewer samples than can be aligned lie in the window,
    no stretch within it fits better than its neighbours, or the best one leaves more unexplained
    than the misfit, a part of the record's roughness.
    """
    inside = within(velocity, window.lower, window.upper)
    if np.count_nonzero(inside) < LEAST_SAMPLES:
        return None
    seen_at, seen = velocity[inside], values[inside]
    trends = _trends(seen_at)

    def unexplained(stretch: float) -> float:
        return _rough(seen - prediction(seen_at / stretch), trends)

    reach = 0.5 * min(window.front - window.lower, window.upper - window.front) / window.front
    trials = np.linspace(1 - reach, 1 + reach, TRIALS)
    best = int(np.argmin([unexplained(s) for s in trials]))
    if best in (0, TRIALS - 1):
        return None
    bounds = trials[best - 1], trials[best + 1]
    found = scipy.optimize.minimize_scalar(unexplained, bounds=bounds, method="bounded")
    if found.fun > misfit * roughness(seen, seen_at):
        return None
    return float(found.x) * window.front


def left_over(
    velocity: Array, values: Array, prediction: Waveform, window: FrontWindow, speed: float
) -> tuple[Array, Array]:
    """Velocities in the window [length / time] and what an aligned prediction leaves there, (n,).

    The speed is the one that `aligned_speed` found [length / time].
    """
    inside = within(velocity, window.lower, window.upper)
    seen_at = velocity[inside]
    return seen_at, values[inside] - prediction(seen_at * window.front / speed)


def alignment_bar(
    velocity: Array, left: Array, prediction: Waveform, window: FrontWindow, speed: float
) -> float:
    """How far an aligned front moves [length / time] until it changes the record by its error.

    The part of the error that looks like a shift of the front is in the speed, and about as large
    as the whole.  It moves a weak signal farther than a strong one.  The error is what is left at
    velocities in the window (n,) [length / time], and the speed the one that `aligned_speed` found.
    """
    stretch = speed / window.front
    step = (window.upper - window.lower) / window.front / TRIALS
    moved = prediction(velocity / (stretch + step)) - prediction(velocity / (stretch - step))
    per_stretch = roughness(moved, velocity) / (2 * step)
    return roughness(left, velocity) / per_stretch * window.front if per_stretch else np.inf


def _trends(velocity: Array) -> Array:
    """Orthonormal smooth trends over velocities (n,), (n, `TREND_DEGREE` + 1)."""
    centred = (velocity - velocity.mean()) / np.ptp(velocity)
    return np.asarray(np.linalg.qr(np.vander(centred, TREND_DEGREE + 1))[0])


def _rough(values: Array, trends: Array) -> float:
    """Root mean square of values (n,) less their trends."""
    return float(np.sqrt(np.mean((values - trends @ (trends.T @ values)) ** 2)))
