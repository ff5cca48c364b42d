"""Specimens by name and from TOML files."""

from __future__ import annotations

from dataclasses import asdict
from os import PathLike, fspath
from typing import Any

from fem.lines.specimen import Block, Specimen
from semianalytic.scene.checks import check_keys, checked_table, made
from semianalytic.scene.errors import SceneError
from semianalytic.scene.given.documents import history_from_table, scene_from_document
from semianalytic.scene.given.files import read_document, with_units
from semianalytic.scene.given.finding import is_file
from semianalytic.scene.given.named import NAMED_SPECIMENS
from semianalytic.scene.given.solids import find_material
from semianalytic.scene.loading import Tractions
from semianalytic.scene.material import Material

KEYS = (
    *("friction", "friction_law", "contact", "base", "load", "history", "gauges", "run"),
    *("units", "summary"),
)
"""Keys of a file in addition to its blocks."""


def find_specimen(source: object) -> Specimen | None:
    """Return a specimen, or that of a name or TOML file; None if it is anything else.

    A file has tables `[upper]` and `[lower]` with the fields of `Block`, and before them, as in the
    file of a scene, friction or a law, base, load and contact, then `history` and `gauges`.

    Raises
    ------
    SceneError
        If a key is unknown, missing or out of range.

    Examples
    --------
    >>> from fem import find_specimen
    >>> find_specimen("pmma-specimen").upper.height, find_specimen("preloaded")
    (0.1, None)
    """
    if isinstance(source, Specimen) or not isinstance(source, str | PathLike):
        return source if isinstance(source, Specimen) else None
    source = fspath(source)
    named = NAMED_SPECIMENS.get(source)
    if named is None and not is_file(source):
        return None
    document = read_document(named or source)
    if "upper" not in document:
        return None
    try:
        parts = with_units(document)
        check_keys("", parts, ("upper", "lower"), KEYS)
        upper, lower = (_block(name, parts.pop(name)) for name in ("upper", "lower"))
        more = {
            "gauges": parts.pop("gauges", ()),
            "run": checked_table("run", parts.pop("run", {})),
        }
        if "history" in parts:
            more["history"] = history_from_table("history", parts.pop("history"))
        still = {"pressure": 0.0, "shear": 0.0}
        given = {"base": still, "load": still, "contact": "whole line", **parts}
        scene = scene_from_document({"material": asdict(upper.material), **given})
        base = scene.base if "base" in parts else None
        return Specimen(upper, lower, scene.law, scene.contact, base, scene.load, **more)
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
        parts[key] = {side: made(side, Tractions, own) for side, own in sides.items()}
    if "history" in parts:
        parts["history"] = history_from_table(f"{name}.history", parts["history"])
    block: Block = made(name, Block, parts)
    return block
