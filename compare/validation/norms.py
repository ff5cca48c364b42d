"""Norms of what was recorded against what is exact, gaps left out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from compare.comparison.measures import NOTHING
from compare.records.record import Record
from compare.validation.exact import AT_TIME, Exact, Sampling
from semianalytic.scene.arrays import Array


@dataclass(frozen=True)
class Norm:
    """Errors of one quantity at one station, or of all together, over the time recorded."""

    quantity: str
    x: float | None  # position of the station [length]; None for all together
    exact: float  # mean of the exact |quantity|, in its unit
    simulated: float  # the same of what was recorded
    # norm of the difference over that of the exact record; over its unit where that is 0
    L1: float
    L2: float
    samples: int


def weights(t: Array, values: Array) -> Array:
    """Trapezoidal weights of samples (n,) [time]; none for gaps, which nothing bridges."""
    steps = np.diff(t) * (np.isfinite(values[1:]) & np.isfinite(values[:-1]))
    return 0.5 * (np.append(steps, 0.0) + np.append(0.0, steps))


def station_size(exact: Array, weight: Array, unit: float) -> float:
    """Integral of |exact| [quantity time], that of its unit where the answer is nothing."""
    size = float(weight @ np.abs(exact))
    return size if size > NOTHING * unit * weight.sum() else unit * float(weight.sum())


def station_norm(
    record: Record, name: str, exact: Exact, sampling: Sampling = AT_TIME
) -> Norm | None:
    """Errors of one quantity at one station; None where it was not recorded."""
    values = record.values.get(name)
    if values is None or not (weight := weights(record.t, values)).any():
        return None
    expected, unit = exact.record(name, record.x, record.t, sampling), exact.unit(name)
    seen = np.where(weight > 0, values, expected)
    total, size = float(weight.sum()), station_size(expected, weight, unit)
    square = float(weight @ expected**2)
    if square <= (NOTHING * unit) ** 2 * total:
        square = unit**2 * total
    return Norm(
        name,
        record.x,
        float(weight @ np.abs(expected)) / (total * unit),
        float(weight @ np.abs(seen)) / (total * unit),
        float(weight @ np.abs(seen - expected)) / size,
        float(np.sqrt(weight @ (seen - expected) ** 2 / square)),
        int(np.count_nonzero(weight)),
    )


def pooled(norms: list[Norm]) -> Norm:
    """All stations together, each of the same weight."""
    exact = float(np.mean([norm.exact for norm in norms]))
    simulated = float(np.mean([norm.simulated for norm in norms]))
    sizes = np.array([norm.exact if norm.exact > NOTHING else 1.0 for norm in norms])
    size = exact if exact > NOTHING else 1.0
    errors = [np.array([getattr(norm, kind) for norm in norms]) * sizes for kind in ("L1", "L2")]
    samples = sum(norm.samples for norm in norms)
    parts = float(errors[0].mean() / size), float(np.sqrt((errors[1] ** 2).mean()) / size)
    return Norm(norms[0].quantity, None, exact, simulated, *parts, samples)
