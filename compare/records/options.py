"""Information that a reader cannot obtain from a file itself."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple


class Placed(NamedTuple):
    """What a column of a table with a column for each gauge records, and where [unit of scene]."""

    quantity: str
    x: float
    y: float | None = None


@dataclass(frozen=True)
class ReadingOptions:
    """Information that the user gives about files of other codes.

    Attributes
    ----------
    at : tuple of float
        Positions of files that hold one station each, in their order [unit of the file].
    origin : float
        Where the edge of the contact lies in the coordinates of the file.
    columns : mapping
        Name of a column, array or field by what it holds: "t", "x", one of `QUANTITIES`,
        or "velocity_upper", "velocity_lower", "displacement_upper", "displacement_lower"; for
        meshes "velocity" and "displacement".
    gauges : mapping
        What each column of a table with a column for each gauge records, by its name.
    """

    at: tuple[float, ...] = ()
    origin: float = 0.0
    columns: Mapping[str, str] = field(default_factory=dict)
    gauges: Mapping[str, Placed] = field(default_factory=dict)
