"""When something begins at nodes and between them, and where samples lie about a place."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeVar

import numpy as np

from semianalytic.results.answer import OpenInterval, SlipInterval
from semianalytic.results.interface_history import between
from semianalytic.results.intervals import finite_times
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import SceneError

Interval = TypeVar("Interval", SlipInterval, OpenInterval)
Finder = Callable[[Array, Array], tuple[Interval, ...]]
"""Function that finds intervals of x (n,) from values (n,) at these places."""

ROUNDING = 1e-9
"""Relative amount by which a time or position may exceed the last one."""
ONSET_SHARE = 0.01
"""Share of the largest slip rate that is slip; a tenth would let it begin ahead of the waves."""
NO_SLIP = 1e-6
"""Fraction of the largest recorded slip rate that counts as none; it is exactly 0 in stick."""


def added_up(seen: Any) -> tuple[Array, Array]:
    """Return |slip| and work of friction that add up from one level to the next, (m, n) each."""
    slip, shear = seen.slip, np.abs(seen.shear_traction)
    steps, none = np.abs(np.diff(slip, axis=0)), np.zeros((1, slip.shape[1]))
    work = np.vstack([none, steps * (shear[1:] + shear[:-1]) / 2])
    path = np.abs(slip[:1]) + np.cumsum(np.vstack([none, steps]), axis=0)
    return path, np.cumsum(work, axis=0)


def onsets(seen: Any, of: str, share: float = ONSET_SHARE) -> Array:
    """Return the times at which something begins at the nodes, (n,), from fields at x and t (m, n).

    A share of the largest slip rate so far counts as slip.
    """
    if of == "opening":
        opened = seen.gap > 0
        return np.where(opened.any(axis=0), seen.t[opened.argmax(axis=0)], np.inf)
    # The wanted sense counts positive; the other one must not pass for slip.
    rate = {"forward": 1.0, "reverse": -1.0}.get(of, 0.0) * seen.slip_rate
    rate = np.maximum(rate, 0.0) if of != "slip" else np.abs(seen.slip_rate)
    # Measured by what was until then, so that later and larger slip does not delay an onset.
    largest = np.maximum.accumulate(np.abs(seen.slip_rate).max(axis=1, initial=0.0))
    # rounding moves nodes of elements before any slip, when nothing larger was there
    threshold = np.maximum(share * largest, NO_SLIP * largest[-1])
    # at the first level there is no earlier value to interpolate from
    t, speeds = (np.concatenate([values[:1], values]) for values in (seen.t, rate))
    return onsets_until(np.full(len(seen.x), np.inf), t, speeds, threshold)


def onsets_until(
    onset: Array, times: Sequence[float] | Array, speeds: Array, threshold: Array
) -> Array:
    """Return the times at which slip has begun at the nodes, (n,), with k more levels.

    `onset` (n,) has the times known so far [time], not finite where slip has not begun; `times`
    (k + 1,) are those of the levels and of the one before them [time], a jump being two levels at
    one time; `speeds` (k + 1, n) are |slip rate| at these, linear between them, and `threshold`
    (k,) that beyond which slip has begun, at each of the k levels [length / time].
    """
    # most nodes slip already, or not yet: the few others are looked at level by level
    waiting = ~np.isfinite(onset)
    waiting = np.flatnonzero(waiting & (speeds[1:].max(axis=0) > threshold.min()))
    if not len(waiting):
        return onset
    begins = speeds[1:, waiting] > threshold[:, None]
    first = np.argmax(begins, axis=0)
    began = np.flatnonzero(begins[first, np.arange(len(waiting))])
    if not len(began):
        return onset
    level, node, t = first[began], waiting[began], np.asarray(times)
    old, new = speeds[level, node], speeds[level + 1, node]
    rises = new > old
    share = np.where(rises, (threshold[level] - old) / np.where(rises, new - old, 1.0), 0.0)
    onset = onset.copy()
    onset[node] = t[level] + (t[level + 1] - t[level]) * np.clip(share, 0.0, 1.0)
    return onset


def onset_between(nodes: Array, x: Array, onset: Array) -> Array:
    """Interpolate onsets (n,) at nodes (n,), some of which may be inf, at positions x [time]."""
    left, right, along = between(nodes, x)
    # A node that never begins has inf, which a mean would pass on: the nearer node decides
    # then.
    nearest = np.where(along < 0.5, onset[left], onset[right])
    both = np.isfinite(onset[left]) & np.isfinite(onset[right])
    first, second = (np.where(both, onset[side], 0.0) for side in (left, right))
    return np.where(both, (1 - along) * first + along * second, nearest)


def check_times(t: Array, recorded: Array) -> None:
    """Raise SceneError for times that are not finite or later than what was recorded."""
    if np.any(finite_times(t) > recorded[-1] * (1 + ROUNDING)):
        raise SceneError(
            f"this answer ends at t = {recorded[-1]:.6g}; ask for earlier times, or compute it to "
            "a later end time."
        )
