"""Parts of the contact that slip or are open at a time, and places and times that are asked for."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from semianalytic.results.answer import OpenInterval, SlipInterval
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import SceneError

EDGE_STEPS = 2
"""Largest distance of an edge beyond the last sample that slips, in steps of the samples."""


def slip_intervals(x: Array, slip_rate: Array, least: float) -> tuple[SlipInterval, ...]:
    """Find the intervals that slip from a slip rate sampled at increasing x > 0, both (n,).

    An interval is a run of two or more samples of one sign whose size exceeds `least`.  Its ends
    are placed between samples by the square-root law of slip rate at an edge: a straight line
    through the squares of the two samples next to the end is followed down to zero, but no further
    than `EDGE_STEPS` steps.  Intervals go from the contact edge outward; one that holds the first
    sample starts at 0, one that holds the last ends at infinity.  Velocities x/t do as well as x.
    """
    sense = np.where(np.abs(slip_rate) > least, np.sign(slip_rate), 0.0)
    return tuple(
        SlipInterval(*_ends(x, slip_rate**2, run), int(sense[run[0]])) for run in _runs(sense)
    )


def open_intervals(x: Array, gap: Array, least: float = 0.0) -> tuple[OpenInterval, ...]:
    """Find the open intervals from a sampled gap >= 0, like `slip_intervals`.

    At a smooth end the gap grows like the distance to the power 3/2, so the line goes through its
    powers 2/3.
    """
    return tuple(OpenInterval(*_ends(x, gap ** (2 / 3), run)) for run in _runs(gap > least))


def _runs(kind: NDArray[Any]) -> Iterator[NDArray[np.intp]]:
    """Yield the indices of each run of two or more neighbouring samples of one non-zero kind."""
    for run in np.split(np.arange(len(kind)), np.flatnonzero(kind[1:] != kind[:-1]) + 1):
        # A single sample has no line through it, and so no ends that could be placed.
        if len(run) > 1 and kind[run[0]]:
            yield run


def _ends(x: Array, straight: Array, run: NDArray[np.intp]) -> tuple[float, float]:
    """Return the ends of a run of samples whose values fall to zero along straight lines."""
    # `_edge` looks from an edge inward; for the right end that is backwards.
    inward = run[::-1]
    start = _edge(x[run], straight[run]) if run[0] else 0.0
    end = _edge(x[inward], straight[inward]) if run[-1] < len(x) - 1 else math.inf
    return start, end


def beside_openings(
    zone: SlipInterval, openings: Iterable[OpenInterval], near: float
) -> SlipInterval:
    """Let a zone end where an opening begins, if its end lies within `near` of it.

    Slip has its full speed there, so the law of an edge does not apply.
    """
    start, end = zone.start, zone.end
    for opening in openings:
        if opening.start < start < opening.end + near:
            start = opening.end
        if opening.start - near < end < opening.end:
            end = opening.start
    return SlipInterval(start, end, zone.sense)


def _edge(x: Array, straight: Array) -> float:
    """Return where a line through the first two samples, from the edge inward, falls to zero."""
    first, second = straight[:2].tolist()
    step = float(x[1] - x[0])
    steps = first / (second - first) if second > first else 0.0
    # Samples that hardly fall say little about the end, which the next sample in stick bounds.
    return float(x[0]) - min(steps, EDGE_STEPS) * step


FRONT_NODES = 17
"""Nodes over which the speed of a front is taken.  Onsets are those of steps under laws that stick:
from node to node the speed of `supershear` (1,536 nodes) jumps by 13, 5, 1.4 and 0.6 % at most with
5, 9, 17 and 33 nodes."""


def front_speeds(onset: Array, spacing: float) -> Array:
    """Return the speed of a front at nodes (n,) from the times at which it comes to them.

    It is the inverse slope of the times by least squares over `FRONT_NODES` nodes; nan where the
    front has not come to all of them, and inf where it comes at once.
    """
    reach = FRONT_NODES // 2
    at = np.arange(-reach, reach + 1)
    speeds = np.full(len(onset), np.nan)
    if len(onset) < FRONT_NODES:
        return speeds
    seen = np.lib.stride_tricks.sliding_window_view(onset, FRONT_NODES)
    slope = seen @ at / (at @ at) / spacing
    with np.errstate(divide="ignore"):
        speeds[reach : len(onset) - reach] = 1 / np.abs(slope)
    return speeds


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
