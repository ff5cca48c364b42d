"""The state of an interface at one time, and what a run goes on from."""

from __future__ import annotations

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
class RunCheckpoint:
    """Everything from which a run goes on.

    Attributes
    ----------
    state : State
        Where it goes on from: its end, or the state before a last step that was cut to end there.
    end : State
        The state at its end.
    past, opening : Past
        Memories of slip, and of opening where the interface may open, at the time of `state`.
    horizon : float
        Largest q c_t t of these memories.
    fingerprint : str
        Digest of what the run depends on until `latest`.
    every, count : int
        Steps per stored level, and steps until the time of `state`.
    slipping : float
        |slip rate| beyond which slip has begun [length / time].
    latest : float
        Time up to which the run may go on [time].
    """

    state: State
    end: State
    past: Past
    opening: Past | None
    horizon: float
    fingerprint: str
    every: int
    count: int
    slipping: float
    latest: float
