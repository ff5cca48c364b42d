"""Read scenes from TOML files, whose keys and tables are checked by name."""

from __future__ import annotations

import re
import tomllib
from collections import Counter
from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import Any

from semianalytic.scene.checks import check_keys
from semianalytic.scene.errors import DataFileError, SceneError
from semianalytic.scene.given.documents import scene_from_document
from semianalytic.scene.given.load_tables import with_tables
from semianalytic.scene.scene import Scene
from semianalytic.scene.tables.bounds import LARGEST_DESCRIPTION
from semianalytic.scene.tables.text import text_of
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
