"""Read scenes from TOML files, whose keys and tables are checked by name.

Load histories may be in files of their own: tables of times and values, with units in their header.
"""

from __future__ import annotations

import re
import tomllib
from collections import Counter
from collections.abc import Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Any

from semianalytic.scene.checks import check_keys, finite, shown
from semianalytic.scene.errors import DataFileError, SceneError
from semianalytic.scene.given.documents import scene_from_document
from semianalytic.scene.scene import Scene
from semianalytic.scene.tables.bounds import LARGEST_DESCRIPTION
from semianalytic.scene.tables.columns import read_columns
from semianalytic.scene.tables.text import text_of
from semianalytic.scene.tables.units import names_no_unit
from semianalytic.scene.units import ARGUMENTS, PARAMETERS, SI, InSI, measure

_WITH_UNIT = re.compile(r"\s*[-+]?[\d.]+([eE][-+]?\d+)?\s*[A-Za-zµ°%][^(),*]*")
"""A number and a unit, which no expression is."""
NEEDED = ("material", "base")
TABLES = (
    *("load", "pressure_history", "shear_history", "friction_law", "lower_material"),
    *("adhesion", "numbers", "run"),
)
KEYS = (
    *("friction", "mode", "load_on", "units", "contact", "summary"),
    *("period", "rate", "plate_rate", "held", "even"),
)
FINITE = (
    "this is a specimen of finite size; simulate or compare it, or solve it as half-planes "
    "until waves from its sides arrive (docs/specimens.md)."
)
FILE = "file"
"""The key of a history of kind "tabulated" that names a table in place of its numbers."""
_LOADS: Mapping[str, tuple[str, ...]] = {
    "shear_history": ("shear", "shear_traction", "traction"),
    "pressure_history": ("pressure", "traction"),
}


def read_scene(path: str | Path) -> Scene:
    """Read the scene that a TOML file describes.

    The file holds ``friction``, ``[material]`` with shear_modulus, density and poisson_ratio, and
    ``[base]`` and ``[load]`` with pressure and shear, in any consistent set of units.  ``[load]``
    may hold ``kind = "incident-wave"`` with wave ("P", "SV" or "SH"), angle, velocity or stress,
    and from ("below" or "above"), ``kind = "moving"`` with speed, pressure and shear, ``kind =
    "growing"`` with power, or, of bodies that touch along the whole line, "patch" with speed,
    "point-force" or "half-line"; ``contact = "whole line"`` may say so.
    It may hold ``[pressure_history]``, ``[shear_history]`` (``kind = "ramp"``, ``rise_time =
    0.5``) and ``[friction_law]`` (``kind = "slip-weakening"``, ``dynamic = 0.2``, ``distance =
    1e-5``; in place of ``dynamic``, ``reduction`` is the part of ``friction`` that is lost).  A
    history of kind "tabulated" may name a table, ``file = "pulse.csv"``, whose header has units.
    Before the tables, ``mode = "antiplane"`` turns shear and slip along z, ``load_on = "remote"``
    lets the load arrive from far away, and ``units = "SI"`` makes all output say m, s and Pa.  A
    table ``[lower_material]`` has the keys of ``[material]``, for the lower body.

    A scene on a line has further keys (docs/engine.md): ``contact = {intervals = [[-1, 1]]}``,
    ``period``, ``rate``, ``plate_rate``, ``held``, ``even``, several ``[[load]]`` with ``history``
    and ``on``, ``[adhesion]``, ``[numbers]`` and ``[run]``; tractions, loads and parameters of laws
    may be expressions of x or tables.  A number may have a unit, as in ``pressure = "5 MPa"``; all
    numbers are then those of the SI.

    Raises SceneError if the file cannot be read, or if a key is missing, unknown, of the wrong type
    or out of range; the message names file and key.
    """
    return scene_of_file(read_document(path), path)


def scene_of_file(document: Mapping[str, Any], path: str | Path) -> Scene:
    """Return the scene of a document as `read_scene` does; the path is that of its file."""
    try:
        if "upper" in document:
            raise SceneError(FINITE)
        # Whatever is unknown or out of range raises here, and gets the name of the file in front.
        whole = "load" in document or any(key in document for key in ("period", "run", "rate"))
        friction = () if "friction_law" in document else ("friction",)
        needed = (*friction, *NEEDED, *(() if whole else ("load",)))
        check_keys("", document, needed, [key for key in (*KEYS, *TABLES) if key not in needed])
        document = with_units(document)
        return scene_from_document(with_tables(path, document), Path(path).parent)
    except SceneError as error:
        raise SceneError(f"{path}: {error}") from error


def with_units(document: Mapping[str, Any]) -> dict[str, Any]:
    """Return a document whose numbers with units, as "5 MPa", are numbers of the SI.

    Raises SceneError if a unit is unknown, or of another dimension.
    """
    known: dict[str, str] = {**ARGUMENTS, **PARAMETERS, "strength": "stress", "intervals": "length"}
    found = False

    def converted(name: str, key: str, value: Any) -> Any:
        nonlocal found
        # tractions that grow, and forces at a point, are of other dimensions
        if isinstance(value, Mapping) and value.get("kind") not in ("growing", "point-force"):
            return {own: converted(f"{name}.{own}", own, item) for own, item in value.items()}
        if isinstance(value, list) and key not in ("x", "values"):
            return [converted(name, key, item) for item in value]
        if not isinstance(value, str) or not _WITH_UNIT.fullmatch(value) or key not in known:
            return value
        try:
            number = measure(value, known[key])
        except SceneError as error:
            raise SceneError(f"{name} {error}") from error
        found = found or isinstance(number, InSI)
        return float(number)

    result = {key: converted(key, key, value) for key, value in document.items()}
    return {"units": SI, **result} if found else result


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
        times, values = _read_history(
            table, loads, finite(load) or 0.0, str(document.get("units", ""))
        )
        result[part] = {"kind": "tabulated", "t": times, "value_at_t": values}
    return result


def _read_history(
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


def read_document(path: str | PathLike[str]) -> dict[str, Any]:
    """Read a TOML file; raise SceneError if it cannot be read, or is none."""
    text = ""
    try:
        text = text_of(Path(path), LARGEST_DESCRIPTION)
        return tomllib.loads(text)
    except DataFileError as error:
        raise SceneError(str(error)) from error
    except ValueError as error:
        # The parser names a line and column; that a table was appended to a file that has it
        # already is the usual reason, and easier to mend by name.
        twice = [head for head, count in Counter(_headings(text)).items() if count > 1]
        if twice:
            raise SceneError(
                f"{path} has the table {twice[0]} twice; delete or replace the first one."
            ) from error
        raise SceneError(f"{path} is not a valid TOML file: {error}.") from error
    except RecursionError as error:
        raise SceneError(f"{path} nests brackets too deeply; give a scene file.") from error


def _headings(text: str) -> list[str]:
    """Return the headings of a TOML text that may stand once: [name], not [[name]] or values."""
    lines = (line.partition("#")[0].strip() for line in text.splitlines())
    return [line for line in lines if re.fullmatch(r"\[[A-Za-z_][\w.-]*\]", line)]
