"""Read scenes from TOML files, whose keys and tables are checked by name."""

from __future__ import annotations

import re
import tomllib
from collections import Counter
from collections.abc import Collection, Mapping
from os import PathLike
from pathlib import Path
from typing import Any

from semianalytic.scene.checks import check_keys, check_numbers, checked_table
from semianalytic.scene.errors import DataFileError, SceneError
from semianalytic.scene.given.documents import scene_from_document
from semianalytic.scene.given.load_tables import with_tables
from semianalytic.scene.scene import Scene
from semianalytic.scene.tables.bounds import LARGEST_DESCRIPTION
from semianalytic.scene.tables.text import text_of

TABLES = {
    "material": ("shear_modulus", "density", "poisson_ratio"),
    "base": ("pressure", "shear"),
    "load": ("pressure", "shear"),
}
LOWER_MATERIAL = "lower_material"
OPTIONAL_TABLES = ("pressure_history", "shear_history", "friction_law", LOWER_MATERIAL)
INTERFACE_KEY = "law"
"""Key by which files of interfaces are known."""
INTERFACE_HINT = (
    "has contacts or fields along x, which the engine alone knows: slipfront solve, or `solve` in "
    "Python (docs/engine.md)."
)
WORDS = ("mode", "load_on", "units", "contact")
"""Optional keys whose values are words; the scene checks them."""


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

    Raises
    ------
    SceneError
        If the file cannot be read, or if a key is missing, unknown, of the wrong type or out of
        range; the message names file and key.
    """
    document = read_document(path)
    if INTERFACE_KEY in document:
        raise SceneError(f"{path} {INTERFACE_HINT}")
    try:
        # Whatever is unknown or out of range raises here, and gets the name of the file in front.
        needed = TABLES if "friction_law" in document else ("friction", *TABLES)
        check_tables(document, needed, ("friction", *OPTIONAL_TABLES, *WORDS))
        return scene_from_document(with_tables(path, document))
    except SceneError as error:
        raise SceneError(f"{path}: {error}") from error


def check_tables(
    document: Mapping[str, Any], needed: Collection[str], optional: Collection[str]
) -> None:
    """Raise SceneError for keys of a document and its tables that are unknown, missing or no
    numbers; parts with a kind are checked where they are made."""
    check_keys("", document, needed, optional)
    tables = {*TABLES, *OPTIONAL_TABLES}
    check_numbers("", document, (*WORDS, *tables))
    for name in (one for one in document if one in tables):
        table = checked_table(name, document[name])
        keys = TABLES.get("material" if name == LOWER_MATERIAL else name)
        if keys and "kind" not in table:
            check_keys(f"{name}.", table, keys)
            check_numbers(f"{name}.", table)


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
