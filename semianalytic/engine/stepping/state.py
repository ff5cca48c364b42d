"""The state of an interface at one time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from semianalytic.engine.stepping.unilateral import Faces

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
