"""Specimens by name and from TOML files."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from typing import Any

from fem.lines.specimen import Block, Specimen
from semianalytic.scene.checks import check_keys, checked_table, made
from semianalytic.scene.errors import SceneError
from semianalytic.scene.given.documents import history_from_table
from semianalytic.scene.given.files import read_document
from semianalytic.scene.given.finding import is_file
from semianalytic.scene.given.solids import find_material
from semianalytic.scene.line.contact import Contact
from semianalytic.scene.loading import Tractions
from semianalytic.scene.material import Material

SPECIMENS: Mapping[str, str] = {
    "pmma-specimen": """
friction = 0.3
gauges = [[0.02, 0.0035], [0.04, 0.0035], [0.06, 0.0035]]
base = {pressure = 5e6, shear = 0.8e6}
load = {pressure = 0.0, shear = 0.8e6}
contact = {intervals = [[0.0, 0.11]]}
run = {end_time = 150e-6, size = 1e-3}
[upper]
material = "pmma"
height = 0.1
left = -0.1
right = 0.1
far_side = "clamped"
[lower]
material = "pmma"
height = 0.1
left = -0.1
right = 0.1
far_side = "clamped"
"""
}
"""Specimens by name: plates of PMMA, 200 x 100 mm, whose left half of the joint loses its shear."""


def find_specimen(source: str) -> tuple[Specimen, dict[str, Any]] | None:
    """Return the specimen of a name or TOML file, and the arguments of its run; None if a scene.

    A file has tables `[upper]` and `[lower]` with the fields of `Block`, and the fields of
    `Specimen` and `run = {end_time = ..., size = ...}` before them.

    Raises
    ------
    SceneError
        If a key is unknown, missing or out of range.
    """
    if source not in SPECIMENS and not is_file(source):
        return None
    named = SPECIMENS.get(source)
    document = tomllib.loads(named) if named else read_document(source)
    if "upper" not in document:
        return None
    try:
        run = checked_table("run", document.pop("run", {}))
        check_keys("run.", run, ("end_time", "size"), ("samples", "damping", "step_ratio"))
        parts: dict[str, Any] = {
            name: _block(name, value) if name in ("upper", "lower") else value
            for name, value in document.items()
        }
        parts |= {
            name: made(name, Tractions, checked_table(name, parts[name]))
            for name in ("base", "load")
            if name in parts
        }
        if "contact" in parts:
            parts["contact"] = made("contact", Contact, parts["contact"])
        if "history" in parts:
            parts["history"] = history_from_table("history", parts["history"])
        return made("specimen", Specimen, parts), run
    except SceneError as error:
        raise SceneError(f"{source}: {error}") from error


def _block(name: str, table: Any) -> Block:
    """Return the block that a table of a file describes."""
    parts = checked_table(name, table)
    solid = parts.get("material")
    if solid is not None:
        known = isinstance(solid, str)
        parts["material"] = find_material(solid) if known else made("material", Material, solid)
    for key in ("preload", "load"):
        sides = checked_table(f"{name}.{key}", parts.get(key, {}))
        parts[key] = {side: made(side, Tractions, one) for side, one in sides.items()}
    if "history" in parts:
        parts["history"] = history_from_table(f"{name}.history", parts["history"])
    block: Block = made(name, Block, parts)
    return block
