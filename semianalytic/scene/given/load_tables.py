"""Load histories in files of their own: tables of times and values, with units in their header."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from semianalytic.scene.checks import finite, shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.tables.columns import read_columns
from semianalytic.scene.tables.units import names_no_unit
from semianalytic.scene.units import SI

FILE = "file"
"""The key of a history of kind "tabulated" that names a table in place of its numbers."""
_LOADS: Mapping[str, tuple[str, ...]] = {
    "shear_history": ("shear", "shear_traction", "traction"),
    "pressure_history": ("pressure", "traction"),
}


def with_tables(path: str | Path, document: Mapping[str, Any]) -> dict[str, Any]:
    """Return the document of a scene file with the tables that its histories name read in.

    ``[shear_history]`` may have ``file = "pulse.csv"`` in place of t and value_at_t; the name is
    relative to the folder of the scene file.  The table has a header, a column t, and either a
    column value, which multiplies the load, or a column shear (pressure for ``[pressure_history]``)
    with the load itself, which is divided by that of ``[load]``.  Units in brackets, as in
    ``t [us],shear [MPa]``, need a scene in SI units.

    Raises SceneError if a table cannot be read, lacks columns, or has others, a unit is unknown, or
    the load that a column is divided by is zero.
    """
    result = dict(document)
    for part, loads in _LOADS.items():
        given = result.get(part)
        if not isinstance(given, Mapping) or FILE not in given:
            continue
        # Numbers with a file would leave open which of them count.
        if given.get("kind") != "tabulated" or len(given) > 2:
            raise SceneError(
                f'{part}: {FILE} goes with kind = "tabulated" alone, in place of t and value_at_t.'
            )
        if not isinstance(given[FILE], str):
            raise SceneError(
                f"{part}: {FILE} must be the name of a table, got {shown(given[FILE])}."
            )
        table = Path(path).parent / given[FILE]
        load = document["load"]
        load = load.get(part.removesuffix("_history")) if isinstance(load, Mapping) else None
        times, values = _read(table, loads, finite(load) or 0.0, str(document.get("units", "")))
        result[part] = {"kind": "tabulated", "t": times, "value_at_t": values}
    return result


def _read(
    table: Path, loads: Sequence[str], load: float, units: str
) -> tuple[list[float], list[float]]:
    """Return the times and the values of a table, in the units of the scene."""
    columns = read_columns(table)
    # Instruments write Time as well as time.
    names = [column.name.lower() for column in columns]
    time = [place for place, name in enumerate(names) if name in ("t", "time")]
    values = ("value", "value_at_t", "f", *loads)
    value = [place for place, name in enumerate(names) if name in values]
    if len(columns) != 2 or len(time) != 1 or len(value) != 1:
        raise SceneError(
            f"{table} must have two columns, t and value, or t and {loads[0]}; it has "
            f"{', '.join(column.name or 'one without a name' for column in columns)}."
        )
    (at,), (of,) = time, value
    is_load = names[of] in loads
    if units != SI:
        for row, dimension in ((columns[at], "time"), (columns[of], "stress" if is_load else "1")):
            if dimension != "1" and not names_no_unit(row.unit, dimension):
                raise SceneError(
                    f"{table}: {row.name} has a unit, but the scene does not say which units its "
                    f'own numbers have; write units = "{SI}" into its file, or take the unit out '
                    "of the header."
                )
    numbers = columns[of].numbers(table, ("stress" if is_load else "1",))
    if is_load and not load:
        raise SceneError(
            f"{table} gives the {loads[0]} of the load, which is divided by that of [load]; set "
            f"{loads[0]} there to its largest value, not 0, or name the column value."
        )
    # Fifteen digits: 10 us are 1e-05 s, and a time given twice stays the same number twice.
    times = [float(f"{number:.15g}") for number in columns[at].numbers(table, ("time",)).tolist()]
    return times, (numbers / (load if is_load else 1.0)).tolist()
