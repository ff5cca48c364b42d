"""The state of an interface at one time, and when slip has begun until then."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from semianalytic.engine.stepping.unilateral import Faces
from semianalytic.memory.line_memory import Past

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class State(Faces):
    """The state of an interface at one time, from which the next step starts; arrays are (n,).

    Attributes
    ----------
    time : float
        Time [time].
    rate, slip, traction : array
        Slip rate [length / time], slip [length] and shear traction [stress].
    state : array
        State of friction at nodes of the contact, (contact,).
    felt : array
        Pressure that friction follows there, (contact,) [stress].
    work : array
        Work of friction so far [stress length].
    rung : int
        Rung of the ladder of the last step.
    pace : float
        Change of slip rate in the last step, over the largest rate and the step [1 / time].
    """

    time: float
    rate: Array
    slip: Array
    traction: Array
    state: Array
    felt: Array
    work: Array
    rung: int = 0
    pace: float = 0.0


@dataclass(frozen=True, eq=False)
class Checkpoint:
    """Everything from which a run goes on.

    Attributes
    ----------
    state : State
        The state at its end.
    past, opening : Past
        Memories of slip, and of opening where the interface may open.
    horizon : float
        Largest q c_t t of these memories.
    fingerprint : str
        Digest of what the run depends on until `latest`.
    every, count : int
        Steps per stored level, and steps so far.
    slipping : float
        |slip rate| beyond which slip has begun [length / time].
    latest : float
        Time up to which the run may go on [time].
    """

    state: State
    past: Past
    opening: Past | None
    horizon: float
    fingerprint: str
    every: int
    count: int
    slipping: float
    latest: float


def onsets_until(onset: Array, times: Sequence[float], speeds: Array, threshold: Array) -> Array:
    """Return the times at which slip has begun at the nodes, (n,), with k more levels.

    Parameters
    ----------
    onset : (n,) array
        Times known so far [time]; not finite where slip has not begun.
    times : (k + 1,) sequence
        Times of the levels and of the one before them [time]; a jump is two levels at one time.
    speeds : (k + 1, n) array
        |slip rate| at these [length / time], linear between them.
    threshold : (k,) array
        |slip rate| beyond which slip has begun, at each of the k levels [length / time].
    """
    waiting = np.flatnonzero(~np.isfinite(onset))
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
