"""Records at stations of an interface, whoever made them, and what the user says of their files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from semianalytic.arrays import Array, Mask

QUANTITIES = ("slip_rate", "slip", "shear_traction", "pressure")
"""Recorded quantities.  Motion is that of the upper body relative to the lower one, and pressure is
positive in compression."""
BEFORE, AFTER = "before", "after"
"""A slip rate may be the mean over the step before or after its time."""


@dataclass(frozen=True, eq=False)
class Record:
    """Time series recorded at one point of the interface.

    Attributes
    ----------
    x : float
        Position along the contact [length], 0 at its edge.
    t : (n,) array
        Times [time], increasing.
    values : mapping of names among `QUANTITIES` to (n,) arrays
        NaN where nothing was recorded; in units of the file until `validate` has scaled them.
        Inside the bodies the names are those of `semianalytic.inversion.gauges.FIELDS`.
    y : float or None
        Distance above the interface [length] of a point inside the bodies.
    noise : mapping from names to (n,) arrays
        Standard deviations, where columns give them.
    name : str
        Name of the gauge, where it has one.
    """

    x: float
    t: Array
    values: Mapping[str, Array]
    y: float | None = None
    noise: Mapping[str, Array] = field(default_factory=dict)
    name: str = ""

    def taken(self, samples: slice | Mask) -> Record:
        """Return position, times and values of some samples."""
        values = {name: value[samples] for name, value in self.values.items()}
        return Record(self.x, self.t[samples], values)


@dataclass(frozen=True)
class Unit:
    """A unit that a file names.

    Attributes
    ----------
    name : str
        As the file has it.
    size : float
        In that of the SI.
    """

    name: str
    size: float


@dataclass(frozen=True)
class Stated:
    """Units and conventions that a file itself names, which nothing may overrule.

    Attributes
    ----------
    units : mapping from "x", "t" and `QUANTITIES` to Unit
        Units of the columns that name one.  Their numbers in `Records` are converted to SI units.
    faces : frozenset of str
        Quantities that are the motion of one face alone.
    changes : frozenset of str
        Tractions that are changes since t = 0, by the name of their column.
    mean : str
        `BEFORE` or `AFTER` where slip rates are means over a step; "" where nothing is said.
    step : float or None
        The duration of that step [time, in the unit of t]; None for the distance of samples.
    """

    units: Mapping[str, Unit] = field(default_factory=dict)
    faces: frozenset[str] = frozenset()
    changes: frozenset[str] = frozenset()
    mean: str = ""
    step: float | None = None

    def size(self, name: str) -> float:
        """Return the factor to SI units of a column; 1 where it names no unit."""
        return self.units[name].size if name in self.units else 1.0


@dataclass(frozen=True, eq=False)
class Records:
    """All records of one code on one grid.

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
        Corrections made in reading, a sentence each.
    spacing : float or None
        Between the points of that code's grid [length, in the unit of x], where its file says so.
    stated : Stated
        Units and conventions that the file itself names.
    points : tuple of Record
        Records of points inside the bodies, which only `slipfront fit` takes.
    unread : tuple of str
        Names of the columns, arrays or fields of which nothing is known.
    """

    stations: tuple[Record, ...]
    arrivals: tuple[Array, Array] | None = None
    source: str = ""
    notes: tuple[str, ...] = field(default=())
    spacing: float | None = None
    stated: Stated = field(default_factory=Stated)
    points: tuple[Record, ...] = ()
    unread: tuple[str, ...] = ()


class Placed(NamedTuple):
    """Quantity and place [unit of scene] of a column in a table with one column for each gauge."""

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
        Quantity and place of each column in a table with one column for each gauge, by name.
    """

    at: tuple[float, ...] = ()
    origin: float = 0.0
    columns: Mapping[str, str] = field(default_factory=dict)
    gauges: Mapping[str, Placed] = field(default_factory=dict)
