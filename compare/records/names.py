"""What columns of other codes are called, and in which units they say they are."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

from compare.records.record import QUANTITIES
from semianalytic.scene.errors import DataFileError

FACES = {
    "slip_rate": ("velocity_upper", "velocity_lower"),
    "slip": ("displacement_upper", "displacement_lower"),
}
"""Quantities that are the difference of two columns, upper less lower face."""

ALIASES: Mapping[str, str] = {
    "t": "t time times",
    "x": "x position pos distance coordinate x1",
    "slip_rate": "slip_rate sliprate slip_velocity slipvelocity h_slip_rate v rate delta_dot",
    "slip": "slip h_slip delta displacement_jump jump",
    "shear_traction": "shear_traction shear_stress h_shear_stress traction tau shear sigma_xy s_xy",
    "pressure": "pressure normal_pressure contact_pressure p n_stress normal_stress sigma_n "
    "sigma_yy normal_traction",
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

UNITS: Mapping[str, float] = {
    **{"m": 1.0, "km": 1e3, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "µm": 1e-6},
    **{"s": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6},
    **{"pa": 1.0, "kpa": 1e3, "mpa": 1e6, "gpa": 1e9},
    **{"m/s": 1.0, "km/s": 1e3, "cm/s": 1e-2, "mm/s": 1e-3, "um/s": 1e-6, "µm/s": 1e-6},
}
"""In those of the SI, by their names in lower case."""

_KINDS = {name: kind for kind, names in ALIASES.items() for name in names.split()}
_TENSION = {"n_stress", "normal_stress", "sigma_n", "sigma_yy", "normal_traction"}
_BRACKETED = re.compile(r"^(.*?)\s*[\[(]\s*([^\])]*?)\s*[\])]$")


def known_columns(
    path: Path, names: Sequence[str], told: Mapping[str, str], line: int = 0
) -> tuple[dict[str, int], dict[str, float], list[str]]:
    """Which column holds what, in which unit of the SI, and what of that was guessed.

    Columns of unknown names are left out.

    Raises
    ------
    DataFileError
        If a column that is told is not there, or two hold the same.
    """
    places: dict[str, int] = {}
    scales: dict[str, float] = {}
    notes = []
    pure = [_unit_of(name) for name in names]
    for kind, column in told.items():
        if kind not in ALIASES:
            raise DataFileError(f"A column cannot be {kind!r}; choose among {', '.join(ALIASES)}.")
        if column not in names:
            raise DataFileError(
                f"{path} has no column {column!r}; choose among {', '.join(names) or 'none'}."
            )
        places[kind] = list(names).index(column)
    for place, (name, _) in enumerate(pure):
        kind = _KINDS.get(name, "")
        if not kind or kind in told or place in places.values():
            continue
        if kind in places:
            raise DataFileError(
                f"{path}{_at(line)}: columns {names[places[kind]]!r} and {names[place]!r} are both "
                f"{kind}; say which one is, as {kind}=NAME."
            )
        places[kind] = place
        if name in _TENSION:
            notes.append(f"{names[place]} is read as pressure, with its sign as it is")
    for kind, place in places.items():
        scale = UNITS.get(pure[place][1].lower())
        if scale is not None:
            scales[kind] = scale
            if scale != 1:
                notes.append(f"{names[place]} is converted to SI units")
    return places, scales, notes


def _at(line: int) -> str:
    return f", line {line}" if line else ""


def _unit_of(name: str) -> tuple[str, str]:
    """A column's name in the words of `ALIASES`, and the unit it says, or ""."""
    bracketed = _BRACKETED.match(name.strip())
    pure, unit = bracketed.groups() if bracketed else (name, "")
    pure = re.sub(r"[\s\-.:]+", "_", pure.strip().lower())
    if pure not in _KINDS and not unit and "_" in pure:
        stem, _, last = pure.rpartition("_")
        if last in UNITS and stem in _KINDS:
            return stem, last
    return pure, unit


def no_columns(path: Path, names: Sequence[str], line: int = 0) -> DataFileError:
    """That none of the names stands for anything to compare."""
    shown = ", ".join(map(repr, names[:8])) or "nothing"
    return DataFileError(
        f"{path}{_at(line)} names {shown}: none of it is {', '.join(QUANTITIES)} of the interface; "
        "say which column is, as slip_rate=NAME."
    )
