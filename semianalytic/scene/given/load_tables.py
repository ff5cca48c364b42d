"""Load histories in files of their own: tables of times and values, with units in their header."""

from __future__ import annotations

import csv
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from semianalytic.scene.checks import finite, shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.given.text_files import text_of
from semianalytic.scene.units import SI, size_of, units_shown

FILE = "file"
"""The key of a history of kind "tabulated" that names a table in place of its numbers."""
_LOADS: Mapping[str, tuple[str, ...]] = {
    "shear_history": ("shear", "shear_traction", "traction"),
    "pressure_history": ("pressure", "traction"),
}
_HEADING = re.compile(r"\s*(.*?)\s*(?:[\[(]\s*(.*?)\s*[\])])?\s*\Z")


def with_tables(path: str | Path, document: Mapping[str, Any]) -> dict[str, Any]:
    """Return the document of a scene file with the tables that its histories name read in.

    ``[shear_history]`` may have ``file = "pulse.csv"`` in place of t and value_at_t; the name is
    relative to the folder of the scene file.  The table has a header, a column t, and either a
    column value, which multiplies the load, or a column shear (pressure for ``[pressure_history]``)
    with the load itself, which is divided by that of ``[load]``.  Units in brackets, as in
    ``t [us],shear [MPa]``, need a scene in SI units.

    Parameters
    ----------
    path : path
        The scene file.
    document : mapping
        Its content.

    Raises
    ------
    SceneError
        If a table cannot be read, lacks columns, or has others, a unit is unknown, or the load that
        a column is divided by is zero.
    """
    result = dict(document)
    for part, loads in _LOADS.items():
        given = result.get(part)
        if not isinstance(given, Mapping) or FILE not in given:
            continue
        # Numbers beside a file would leave open which of them count.
        if given.get("kind") != "tabulated" or len(given) > 2:
            raise SceneError(
                f'{part}: {FILE} goes with kind = "tabulated" alone, in place of t and value_at_t.'
            )
        if not isinstance(given[FILE], str):
            raise SceneError(
                f"{part}: {FILE} must be the name of a table, got {shown(given[FILE])}."
            )
        table = Path(path).parent / given[FILE]
        load = document["load"][part.removesuffix("_history")]
        times, values = _read(table, loads, finite(load) or 0.0, str(document.get("units", "")))
        result[part] = {"kind": "tabulated", "t": times, "value_at_t": values}
    return result


def _read(
    table: Path, loads: Sequence[str], load: float, units: str
) -> tuple[list[float], list[float]]:
    """Return the times and the values of a table, in the units of the scene."""
    headings, rows = _rows(table)
    # Instruments write Time as well as time.
    names = [name.lower() for name, _ in headings]
    time = [place for place, name in enumerate(names) if name in ("t", "time")]
    values = ("value", "value_at_t", "f", *loads)
    value = [place for place, name in enumerate(names) if name in values]
    if len(headings) != 2 or len(time) != 1 or len(value) != 1:
        raise SceneError(
            f"{table} must have two columns, t and value, or t and {loads[0]}; it has "
            f"{', '.join(name or 'one without a name' for name, _ in headings)}."
        )
    (at,), (of,) = time, value
    is_load = names[of] in loads
    size = _size(table, headings[of], "stress" if is_load else "1", units)
    if is_load and not load:
        raise SceneError(
            f"{table} gives the {loads[0]} of the load, which is divided by that of [load]; set "
            f"{loads[0]} there to its largest value, not 0, or name the column value."
        )
    lengths = _size(table, headings[at], "time", units)
    return (
        # Fifteen digits: 10 us are 1e-05 s, and a time given twice stays the same number twice.
        [float(f"{lengths * row[at]:.15g}") for row in rows],
        [size * row[of] / (load if is_load else 1.0) for row in rows],
    )


def _size(table: Path, heading: tuple[str, str], dimension: str, units: str) -> float:
    """Return the factor from the unit of a column to that of the scene."""
    name, given = heading
    # No unit, in the ways in which tables write that.
    if given in ("", "-", "1"):
        return 1.0
    size = size_of(given, dimension)
    if size is None:
        raise SceneError(
            f"{table}: {name} must be in {units_shown(dimension)}, or have no unit, got "
            f"{shown(given)}."
        )
    if units != SI and dimension != "1":
        raise SceneError(
            f"{table}: {name} has a unit, but the scene does not say which units its own numbers "
            f'have; write units = "{SI}" into its file, or take the unit out of the header.'
        )
    return size


def _rows(table: Path) -> tuple[list[tuple[str, str]], list[list[float]]]:
    """Return the headings of a table, each a name and a unit, and its numbers."""
    try:
        text = text_of(table)
    except OSError as error:
        raise SceneError(f"Cannot read the table {table}: {error.strerror or error}.") from error
    except ValueError as error:
        raise SceneError(f"{table} is not a text file in UTF-8.") from error
    lines = [
        (number, line)
        for number, line in enumerate(text.splitlines(), start=1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    if not lines:
        raise SceneError(
            f"{table} is empty; it needs a header, as t [us],value, and rows of numbers."
        )
    # The comma comes last: beside semicolons or tabs it is a decimal mark.
    separator = next((one for one in ";\t," if one in lines[0][1]), ",")
    cells = list(csv.reader([line for _, line in lines], delimiter=separator))
    headings = [_HEADING.match(cell) for cell in cells[0]]
    named = [(one[1], one[2] or "") if one else ("", "") for one in headings]
    # A first row of numbers is data: without a header nothing says which column is the time.
    if all(_number(cell, separator) is not None for cell in cells[0]):
        raise SceneError(f"{table} has no header; begin it with t and value, as t [us],value.")
    rows = []
    for (number, _), row in zip(lines[1:], cells[1:], strict=True):
        numbers = [_number(cell, separator) for cell in row]
        if len(numbers) != len(named) or None in numbers:
            raise SceneError(f"{table}, line {number}: there must be {len(named)} numbers.")
        rows.append([one for one in numbers if one is not None])
    return named, rows


def _number(cell: str, separator: str) -> float | None:
    """Return a number, with a decimal comma where columns are separated otherwise; else None."""
    text = cell.strip() if separator == "," else cell.strip().replace(",", ".")
    try:
        return finite(float(text))
    except ValueError:
        return None
