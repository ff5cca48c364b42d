"""Records at stations of an interface, whoever made them, and what the user says of their files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from semianalytic.scene.arrays import Array, Mask

QUANTITIES = ("slip_rate", "slip", "shear_traction", "pressure")
"""Recorded quantities.  Motion is that of the upper body relative to the lower one, and pressure is
positive in compression."""
BEFORE, AFTER = "before", "after"
"""A slip rate may be the mean over the step before or after its time."""


@dataclass(frozen=True, eq=False)
class Record:
    """Time series recorded at one point of the interface."""

    x: float  # position along the contact [length], 0 at its edge
    t: Array  # (n,) array: times [time], increasing
    # mapping of names among `QUANTITIES` to (n,) arrays: NaN where nothing was recorded; in units
    # of the file until `validate` has scaled them. Inside the bodies the names are those of
    # `semianalytic.inversion.gauges.FIELDS`.
    values: Mapping[str, Array]
    y: float | None = None  # distance above the interface [length] of a point inside the bodies
    # mapping from names to (n,) arrays: standard deviations, where columns give them
    noise: Mapping[str, Array] = field(default_factory=dict)
    name: str = ""  # name of the gauge, where it has one

    def taken(self, samples: slice | Mask) -> Record:
        """Return position, times and values of some samples."""
        values = {name: value[samples] for name, value in self.values.items()}
        return Record(self.x, self.t[samples], values)


@dataclass(frozen=True)
class Unit:
    """A unit that a file names."""

    name: str  # as the file has it
    size: float  # in that of the SI


@dataclass(frozen=True)
class Stated:
    """Units and conventions that a file itself names, which nothing may overrule."""

    # mapping from "x", "t" and `QUANTITIES` to Unit: units of the columns that name one. Their
    # numbers in `Records` are converted to SI units.
    units: Mapping[str, Unit] = field(default_factory=dict)
    faces: frozenset[str] = frozenset()  # quantities that are the motion of one face alone
    # tractions that are changes since t = 0, by the name of their column
    changes: frozenset[str] = frozenset()
    # `BEFORE` or `AFTER` where slip rates are means over a step; "" where nothing is said
    mean: str = ""
    # the duration of that step [time, in the unit of t]; None for the distance of samples
    step: float | None = None

    def size(self, name: str) -> float:
        """Return the factor to SI units of a column; 1 where it names no unit."""
        return self.units[name].size if name in self.units else 1.0


@dataclass(frozen=True, eq=False)
class Records:
    """All records of one code on one grid."""

    stations: tuple[Record, ...]  # by position
    # pair of (k,) arrays or None: positions [length] and the times [time] at which slip began
    # there, infinite where it never did: a file of rupture times
    arrivals: tuple[Array, Array] | None = None
    source: str = ""  # the file or files
    notes: tuple[str, ...] = field(default=())  # corrections made in reading, a sentence each
    # between the points of that code's grid [length, in the unit of x], where its file says so
    spacing: float | None = None
    # units and conventions that the file itself names
    stated: Stated = field(default_factory=Stated)
    # records of points inside the bodies, which only `slipfront fit` takes
    points: tuple[Record, ...] = ()
    unread: tuple[str, ...] = ()  # names of the columns, arrays or fields of which nothing is known


class Placed(NamedTuple):
    """Quantity and place [unit of scene] of a column in a table with one column for each gauge."""

    quantity: str
    x: float
    y: float | None = None


@dataclass(frozen=True)
class ReadingOptions:
    """Information that the user gives about files of other codes."""

    # positions of files that hold one station each, in their order [unit of the file]
    at: tuple[float, ...] = ()
    origin: float = 0.0  # where the edge of the contact lies in the coordinates of the file
    # name of a column, array or field by what it holds: "t", "x", one of `QUANTITIES`, or
    # "velocity_upper", "velocity_lower", "displacement_upper", "displacement_lower"; for meshes
    # "velocity" and "displacement"
    columns: Mapping[str, str] = field(default_factory=dict)
    # quantity and place of each column in a table with one column for each gauge, by name
    gauges: Mapping[str, Placed] = field(default_factory=dict)
