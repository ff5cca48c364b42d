"""Scenes as plain dictionaries, for TOML and JSON, and scenes made of such dictionaries."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from semianalytic.scene.checks import checked_table, made, shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.friction import FrictionLaw
from semianalytic.scene.incident import load_document, load_from_document
from semianalytic.scene.kinds import PARTS, Part
from semianalytic.scene.loading import SLOT, WITHOUT_SLOT, Tractions
from semianalytic.scene.material import Material
from semianalytic.scene.plugins import kind_of, known_class, plugin_names
from semianalytic.scene.scene import IN_PLANE, Scene

WHOLE_LINE = "whole line"
"""Contact of scenes without a slot, as files have it."""


def scene_document(scene: Scene) -> dict[str, Any]:
    """Return a scene as plain dictionaries, lists, strings and numbers, for TOML or JSON.

    Histories and friction law are named by `kind`.  These, the mode, the place of the load and the
    units are left out if they are the default.
    """
    document: dict[str, Any] = {} if scene.has_slot else {"contact": WHOLE_LINE}
    document |= {
        "friction": scene.friction,
        "material": asdict(scene.material),
        "base": asdict(scene.base),
        "load": load_document(scene.load),
    }
    for name, known in PARTS.items():
        part = getattr(scene, name)
        # Defaults are left out, so that files stay short and old files stay what they were.
        if part != known.default:
            document[name] = part_document(part)
    if scene.antiplane:
        document["mode"] = scene.mode
    if scene.load_on != SLOT:
        document["load_on"] = scene.load_on
    if scene.units:
        document["units"] = scene.units
    if scene.lower_material is not None:
        document["lower_material"] = asdict(scene.lower_material)
    return document


def part_document(part: Any) -> dict[str, Any]:
    """Return a history or friction law as a dictionary of its kind and parameters."""
    known = PARTS["friction_law" if isinstance(part, FrictionLaw) else "shear_history"]
    return {"kind": kind_of(*known[:3], type(part)), **asdict(part)}


def scene_from_document(document: Mapping[str, Any]) -> Scene:
    """Make the scene that a dictionary of `scene_document`, or of a TOML file, describes.

    Raises
    ------
    SceneError
        If a kind or parameter of a history or friction law is unknown or missing, or a value is
        out of range.
    """
    contact = document.get("contact")
    if contact not in (None, WHOLE_LINE):
        raise SceneError(
            f'contact must be "{WHOLE_LINE}", or left out for a scene with a slot, got '
            f"{shown(contact)}."
        )
    load = load_from_document(document["load"])
    if contact and not isinstance(load, WITHOUT_SLOT):
        raise SceneError(
            "load: kind must be one of patch, point-force, half-line where the contact is the "
            "whole line; other loads belong to a scene with a slot, without contact."
        )
    parts = {
        name: _named(name, part, document[name]) for name, part in PARTS.items() if name in document
    }
    return Scene(
        material=Material(**document["material"]),
        friction=document["friction"],
        base=Tractions(**document["base"]),
        load=load,
        mode=document.get("mode", IN_PLANE),
        load_on=document.get("load_on", SLOT),
        units=document.get("units", ""),
        lower_material=Material(**lower) if (lower := document.get("lower_material")) else None,
        **parts,
    )


def _named(name: str, part: Part, table: Any) -> Any:
    """Make the history or friction law that a table with a kind and parameters describes."""
    kind = checked_table(name, table).get("kind")
    described = known_class(*part[:3], kind) if isinstance(kind, str) else None
    if described is None:
        kinds = ", ".join((*part.own, *plugin_names(part.group, part.own)))
        raise SceneError(
            f"{name}: kind must be one of {kinds}, got {shown(kind)} (docs/not_here.md)."
        )
    return made(name, described, table)


def toml_text(document: Mapping[str, Any], heading: str = "") -> str:
    """Return a document as a TOML file: numbers, words and lists first, then tables."""
    tables = {name: one for name, one in document.items() if isinstance(one, Mapping)}
    rows = (
        f"{name} = {json.dumps(one)}"
        for name, one in document.items()
        if one is not None and name not in tables
    )
    text = "\n".join([heading, *rows] if heading else rows) + "\n"
    return "\n".join([text, *(toml_text(one, f"[{name}]") for name, one in tables.items())])
