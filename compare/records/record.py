"""Records at stations of an interface, whoever made them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

QUANTITIES = ("slip_rate", "slip", "shear_traction", "pressure")
"""What is recorded: relative, upper body less lower; pressure positive in compression."""


@dataclass(frozen=True, eq=False)
class Record:
    """What was recorded at one point of the interface.

    Attributes
    ----------
    x : float
        Position along the contact [length], 0 at its edge.
    t : (n,) array
        Times [time], increasing.
    values : mapping of names among `QUANTITIES` to (n,) arrays
        NaN where nothing was recorded; in units of the file until `validate` has scaled them.
    """

    x: float
    t: Array
    values: Mapping[str, Array]


@dataclass(frozen=True, eq=False)
class Records:
    """What one code recorded on one grid.

    Attributes
    ----------
    stations : tuple of Record
        By position.
    arrivals : pair of (k,) arrays or None
        Positions [length] and the times [time] at which slip began there, infinite where it never
        did: a file of rupture times.
    source : str
        The file or files.
    notes : tuple of str
        What was guessed or mended in reading, a sentence each.
    spacing : float or None
        Between the points of that code's grid [length], where its file says so.
    """

    stations: tuple[Record, ...]
    arrivals: tuple[Array, Array] | None = None
    source: str = ""
    notes: tuple[str, ...] = field(default=())
    spacing: float | None = None
