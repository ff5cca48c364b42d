"""Recognise the columns of other codes and their units by name."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from compare.records.record import QUANTITIES, Unit
from semianalytic.inversion.gauges import FIELDS
from semianalytic.scene.errors import DataFileError
from semianalytic.scene.tables.columns import split_heading
from semianalytic.scene.tables.units import DIMENSIONS, EXAMPLES, known_size, names_no_unit

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
    "sxy tau_xy tau_12 s12 sigma_12 traction0 traction_0 traction_x ts0",
    "pressure": "pressure normal_pressure contact_pressure p n_stress normal_stress sigma_n "
    "sigma_yy normal_traction syy s22 sigma_22 traction1 traction_1 traction_y pn0",
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
_COMPRESSION = {"pressure", "normal_pressure", "contact_pressure", "p"}
_LONG = {
    "v": ("v", "v_", "velocity_"),
    "u": ("u", "u_", "displacement_"),
    "s": ("s", "s_", "sigma_", "stress_"),
    "e": ("e", "e_", "eps_", "epsilon_", "strain_"),
}
_BODIES = {stem + name[1:]: name for name in FIELDS for stem in _LONG[name[0]]}
"""Names of quantities inside the bodies, some of which mean a traction where there is no y."""
NOISE = "noise"
"""Name of a column of standard deviations, of all quantities or, as slip_noise, of one."""


@dataclass(frozen=True)
class Columns:
    """Columns of a table by their quantities."""

    places: Mapping[str, int]  # column of each of `ALIASES` that there is
    units: Mapping[str, Unit] = field(default_factory=dict)  # units of the columns that name one
    changes: frozenset[str] = frozenset()  # tractions that are changes since t = 0, by their names
    notes: tuple[str, ...] = ()  # assumptions that were made, a sentence each
    unread: tuple[str, ...] = ()  # names of all other columns

    def scale(self, kind: str) -> float:
        """Factor of a column: to SI units where it names a unit."""
        return self.units[kind].size if kind in self.units else 1.0


def dimensions_of(kind: str) -> tuple[str, ...]:
    """Dimension of a column by what it holds; noise of all quantities may have any."""
    kind = kind.removeprefix(f"{NOISE} ")
    if kind == NOISE:
        return tuple(EXAMPLES)
    return (FIELDS.get(kind) or DIMENSIONS[_OF_FACES.get(kind, "x" if kind == "y" else kind)],)


def known_columns(
    path: Path,
    names: Sequence[str],
    told: Mapping[str, str],
    line: int = 0,
    units: Mapping[str, str] | None = None,
    bodies: bool = False,
) -> Columns:
    """Return the columns of a table by their quantities, with their units.

    Names are those of the columns, with or without units: "t [ms]", "slip_rate (mm/s)", "x_mm";
    some may be told by quantity, and units by name where a file has them apart.  With `bodies` y,
    quantities inside the bodies and noise are known, besides those of `ALIASES`.  Path and the line
    of the names, 0 where there is none, are for messages: DataFileError if a stated column is
    absent, two contain the same quantity, or a unit is not known.
    """
    apart = units or {}
    places: dict[str, int] = {}
    named: dict[str, Unit] = {}
    notes = []
    kinds = _KINDS
    if bodies:  # with y, sigma_xy is a stress inside a body, else a traction
        with_y = any(_split(name, {"y": "y"})[0] == "y" for name in names)
        kinds = {"y": "y"} | (_KINDS | _BODIES if with_y else _BODIES | _KINDS)
        kinds |= {NOISE: NOISE} | {
            name: f"{NOISE} {kind}"
            for pure, kind in kinds.items()
            for name in (f"{pure}_{NOISE}", f"{NOISE}_{pure}")
            if kind in (*QUANTITIES, *FIELDS)
        }
    split = [_split(name, kinds) for name in names]
    for kind, column in told.items():
        if kind not in ALIASES:
            raise DataFileError(f"A column cannot be {kind!r}; choose among {', '.join(ALIASES)}.")
        if column not in names:
            raise DataFileError(
                f"{path} has no column {column!r}; choose among {', '.join(names) or 'none'}."
            )
        places[kind] = list(names).index(column)
    others = (pure for name, (pure, _) in zip(names, split, strict=True) if name not in SEISSOL)
    times = "t" in told or any(kinds.get(pure) == "t" for pure in others)
    if times:  # what SeisSol calls T_s is then no time in seconds
        split = [(n, "") if n in SEISSOL else pair for n, pair in zip(names, split, strict=True)]
    changes = {
        kind
        for name, (kind, total) in SEISSOL.items()
        if times and name in names and total not in names and kind not in told
    }
    for place, (pure, _) in enumerate(split):
        seissol, _ = SEISSOL.get(names[place], ("", ""))
        kind = seissol if seissol in changes else kinds.get(pure, "")
        if not kind or kind in told or place in places.values():
            continue
        if kind in places:
            raise DataFileError(
                f"{path}{_at(line)}: columns {names[places[kind]]!r} and {names[place]!r} are both "
                f"{kind}; rename one, or say slipfront validate --column {kind}=NAME."
            )
        places[kind] = place
        if kinds.get(pure) == "pressure" and pure not in _COMPRESSION:
            notes.append(f"{names[place]} is read as pressure")
    for kind, place in places.items():
        text = apart.get(names[place], split[place][1])
        unit = unit_of(path, line, f"the name of {names[place][:LONGEST]!r}", text, kind)
        if unit is not None:
            named[kind] = unit
            if unit.size != 1:
                notes.append(f"{names[place]} is converted to SI units")
    named |= {  # noise is in the unit of its quantity unless it has its own
        kind: named[kind.removeprefix(f"{NOISE} ")]
        for kind in places
        if kind not in named and kind.removeprefix(f"{NOISE} ") in named
    }
    unread = tuple(name for place, name in enumerate(names) if place not in places.values())
    return Columns(places, named, frozenset(changes), tuple(notes), unread)


def unit_of(path: Path, line: int, where: str, text: str, kind: str) -> Unit | None:
    """The unit of a quantity in a column's name or a comment; None if it has none."""
    dimensions = dimensions_of(kind)
    if any(names_no_unit(text, dimension) for dimension in dimensions):
        return None
    size = known_size(text, dimensions)
    if size is None:
        shown = text if len(text) <= LONGEST // 4 else text[: LONGEST // 4] + "..."
        raise DataFileError(
            f"{path}{_at(line)}: {shown!r} in {where} is no known unit of "
            f"{' or '.join(dimensions).replace('1', 'strain')}; write one, such as "
            f"{EXAMPLES[dimensions[0]]}, or none."
        )
    return Unit(text.strip(), size)


def named_unit(path: Path, name: str, kind: str) -> Unit | None:
    """The unit that the name of a column or field ends in; None if it has none."""
    return unit_of(path, 0, f"the name of {name[:LONGEST]!r}", _split(name, _KINDS)[1], kind)


def _at(line: int) -> str:
    return f", line {line}" if line else ""


def _split(name: str, kinds: Mapping[str, str]) -> tuple[str, str]:
    """A column's name in the words of kinds, and the unit in brackets or behind _, or ""."""
    name = name[:LONGEST].strip()

    def dimensions(stem: str) -> tuple[str, ...]:
        kind = kinds.get(_words(stem))
        return dimensions_of(kind) if kind and _words(name) not in kinds else ()

    whole, unit = split_heading(name, dimensions)
    return _words(whole), unit


def _words(name: str) -> str:
    return re.sub(r"[\s\-.:]+", "_", name.strip().lower())


def not_read(unread: Sequence[str]) -> tuple[str, ...]:
    """Return the note on columns of unknown names; empty if there are none."""
    return (
        (f"columns without a known name: {', '.join(name[:LONGEST] for name in unread)}",)
        if unread
        else ()
    )


def no_columns(path: Path, names: Sequence[str], line: int = 0) -> DataFileError:
    """Return the error for a file in which no name stands for a quantity to compare."""
    shown = ", ".join(repr(name[:LONGEST]) for name in names[:8]) or "nothing"
    return DataFileError(
        f"{path}{_at(line)} names {shown}: none of it is {', '.join(QUANTITIES)} of the interface; "
        "rename what is, or say slipfront validate --column slip_rate=NAME, or slipfront fit "
        "--gauge NAME=exx@X,Y for the column of a gauge."
    )
