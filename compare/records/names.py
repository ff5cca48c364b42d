"""Recognise the columns of other codes and their units by name."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from compare.records.record import QUANTITIES, Unit
from compare.records.units import DIMENSIONS, EXAMPLES, names_no_unit, si_size
from semianalytic.scene.errors import DataFileError

FACES = {
    "slip_rate": ("velocity_upper", "velocity_lower"),
    "slip": ("displacement_upper", "displacement_lower"),
}
"""Quantities that are the difference of two columns, upper less lower face."""

ALIASES: Mapping[str, str] = {
    "t": "t time times",
    "x": "x position pos distance coordinate x1",
    "slip_rate": "slip_rate sliprate slip_velocity slipvelocity h_slip_rate v rate delta_dot srs",
    "slip": "slip h_slip delta displacement_jump jump sls",
    "shear_traction": "shear_traction shear_stress h_shear_stress traction tau shear sigma_xy s_xy "
    "ts0",
    "pressure": "pressure normal_pressure contact_pressure p n_stress normal_stress sigma_n "
    "sigma_yy normal_traction pn0",
    "velocity_upper": "velocity_upper upper_velocity velocity_top top_velocity v_upper v_top "
    "vx_top",
    "velocity_lower": "velocity_lower lower_velocity velocity_bottom bottom_velocity v_lower "
    "v_bottom vx_bottom",
    "displacement_upper": "displacement_upper upper_displacement displacement_top "
    "top_displacement u_upper u_top ux_top",
    "displacement_lower": "displacement_lower lower_displacement displacement_bottom "
    "bottom_displacement u_lower u_bottom ux_bottom",
}
"""Names in lower case with _ for what separates words, by what they stand for."""

SEISSOL: Mapping[str, tuple[str, str]] = {
    "T_s": ("shear_traction", "Ts0"),
    "P_n": ("pressure", "Pn0"),
}
"""Changes of tractions since t = 0 by the names of SeisSol, which look like units, and its names of
the tractions themselves, which are taken where a file has both."""

LONGEST = 200
"""Number of characters of a header that are examined."""

_KINDS = {name: kind for kind, names in ALIASES.items() for name in names.split()}
_OF_FACES = {face: kind for kind, faces in FACES.items() for face in faces}
_TENSION = {"n_stress", "normal_stress", "sigma_n", "sigma_yy", "normal_traction", "pn0"}
_BRACKETED = re.compile(r"([^\[(]*)[\[(]([^\[\]()]*(?:\([^()]*\)[^\[\]()]*)?)[\])]\s*\Z")
_ENDINGS: Mapping[str, str] = {
    "length": "m km cm mm um µm",
    "time": "s ms us µs",
    "length / time": "m/s km/s cm/s mm/s um/s µm/s",
    "stress": "Pa kPa MPa GPa",
}
"""Units that may end a name behind _, as in x_mm."""


@dataclass(frozen=True)
class Columns:
    """Which column holds what.

    Attributes
    ----------
    places : mapping from str to int
        Column of each of `ALIASES` that there is.
    units : mapping from str to Unit
        Of those that name one.
    changes : frozenset of str
        Tractions that are changes since t = 0, by their names.
    notes : tuple of str
        What was taken for granted, a sentence each.
    """

    places: Mapping[str, int]
    units: Mapping[str, Unit] = field(default_factory=dict)
    changes: frozenset[str] = frozenset()
    notes: tuple[str, ...] = ()

    def scale(self, kind: str) -> float:
        """Factor of a column: to SI units where it names a unit."""
        return self.units[kind].size if kind in self.units else 1.0


def dimension_of(kind: str) -> str:
    """Dimension of a column by what it holds."""
    return DIMENSIONS[_OF_FACES.get(kind, kind)]


def known_columns(
    path: Path,
    names: Sequence[str],
    told: Mapping[str, str],
    line: int = 0,
    units: Mapping[str, str] | None = None,
) -> Columns:
    """Which column holds what, and in which unit.

    Columns of unknown names are left out.

    Parameters
    ----------
    path : Path
        For messages, with the line of the names, 0 where there is none.
    names : sequence of str
        Of the columns, with or without units: "t [ms]", "slip_rate (mm/s)", "x_mm".
    told : mapping
        Names of columns by what they hold, for those that are told.
    units : mapping, optional
        Units by name of column where a file has them apart from names.

    Raises
    ------
    DataFileError
        If a column that is told is not there, two hold the same, or a unit is not known.
    """
    apart = units or {}
    places: dict[str, int] = {}
    named: dict[str, Unit] = {}
    notes = []
    split = [_split(name) for name in names]
    for kind, column in told.items():
        if kind not in ALIASES:
            raise DataFileError(f"A column cannot be {kind!r}; choose among {', '.join(ALIASES)}.")
        if column not in names:
            raise DataFileError(
                f"{path} has no column {column!r}; choose among {', '.join(names) or 'none'}."
            )
        places[kind] = list(names).index(column)
    times = "t" in told or any(_KINDS.get(pure) == "t" for pure, unit in split if unit != "s")
    if times:  # what SeisSol calls T_s is then no time in seconds
        split = [(n, "") if n in SEISSOL else pair for n, pair in zip(names, split, strict=True)]
    changes = {
        kind
        for name, (kind, total) in SEISSOL.items()
        if times and name in names and total not in names and kind not in told
    }
    for place, (pure, _) in enumerate(split):
        kind = _seissol(names, place, changes) or _KINDS.get(pure, "")
        if not kind or kind in told or place in places.values():
            continue
        if kind in places:
            raise DataFileError(
                f"{path}{_at(line)}: columns {names[places[kind]]!r} and {names[place]!r} are both "
                f"{kind}; say which one is, as {kind}=NAME."
            )
        places[kind] = place
        if pure in _TENSION:
            notes.append(f"{names[place]} is read as pressure")
    for kind, place in places.items():
        text = apart.get(names[place], split[place][1])
        unit = _unit(path, line, names[place], text, dimension_of(kind))
        if unit is not None:
            named[kind] = unit
            if unit.size != 1:
                notes.append(f"{names[place]} is converted to SI units")
    return Columns(places, named, frozenset(changes), tuple(notes))


def _seissol(names: Sequence[str], place: int, changes: set[str]) -> str:
    """The quantity that a column of SeisSol stands for; "" for any other column."""
    kind = SEISSOL.get(names[place], ("", ""))[0]
    return kind if kind in changes else ""


def _unit(path: Path, line: int, name: str, text: str, dimension: str) -> Unit | None:
    """The unit that a column names; None if it has none."""
    if names_no_unit(text, dimension):
        return None
    size = si_size(text, dimension)
    if size is None:
        shown = text if len(text) <= LONGEST // 4 else text[: LONGEST // 4] + "..."
        raise DataFileError(
            f"{path}{_at(line)}: {shown!r} in the name of {name[:LONGEST]!r} is no known unit of "
            f"{dimension}; write one, such as {EXAMPLES[dimension]}, or none."
        )
    return Unit(text.strip(), size)


def named_unit(path: Path, name: str, kind: str) -> Unit | None:
    """The unit that the name of a column or field ends in; None if it has none."""
    return _unit(path, 0, name, _split(name)[1], dimension_of(kind))


def _at(line: int) -> str:
    return f", line {line}" if line else ""


def _split(name: str) -> tuple[str, str]:
    """A column's name in the words of `ALIASES`, and the unit it says, or ""."""
    name = name[:LONGEST].strip()
    bracketed = _BRACKETED.match(name)
    whole, unit = bracketed.groups() if bracketed else (name, "")
    pure = _words(whole)
    if pure not in _KINDS and not unit and "_" in whole:
        stem, _, last = whole.rpartition("_")
        kind = _KINDS.get(_words(stem))
        if kind is not None and last in _ENDINGS[dimension_of(kind)].split():
            return _words(stem), last
    return pure, unit


def _words(name: str) -> str:
    return re.sub(r"[\s\-.:]+", "_", name.strip().lower())


def no_columns(path: Path, names: Sequence[str], line: int = 0) -> DataFileError:
    """Return the error for a file in which no name stands for a quantity to compare."""
    shown = ", ".join(repr(name[:LONGEST]) for name in names[:8]) or "nothing"
    return DataFileError(
        f"{path}{_at(line)} names {shown}: none of it is {', '.join(QUANTITIES)} of the interface; "
        "say which column is, as slip_rate=NAME.  Records of points inside the bodies are for "
        "slipfront fit."
    )
