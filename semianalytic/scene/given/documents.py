"""Scenes as plain dictionaries, for TOML and JSON, and scenes made of such dictionaries."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from semianalytic.scene.checks import checked_table, made, shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.incident import load_document, load_from_document
from semianalytic.scene.kinds import HISTORY_FIELDS, HISTORY_KINDS, history_kind
from semianalytic.scene.laws.kinds import law_from_table, law_table
from semianalytic.scene.laws.law import Law, coefficient_field
from semianalytic.scene.loading import SLOT, WITHOUT_SLOT, Tractions
from semianalytic.scene.loads import LoadHistory, Step
from semianalytic.scene.material import Material
from semianalytic.scene.plugins import HISTORIES, known_class
from semianalytic.scene.scene import IN_PLANE, Scene

WHOLE_LINE = "whole line"
"""Contact of scenes without a slot, as files have it."""


def scene_document(scene: Scene) -> dict[str, Any]:
    """Return a scene as plain dictionaries, lists, strings and numbers, for TOML or JSON.

    Histories and friction laws are named by `kind`; the coefficient at rest of a law stands outside
    its table.  Defaults are left out, so that files stay short.
    """
    document: dict[str, Any] = {} if scene.has_slot else {"contact": WHOLE_LINE}
    document |= {
        **({"friction": scene.coefficient} if coefficient_field(type(scene.law)) else {}),
        "material": asdict(scene.material),
        "base": asdict(scene.base),
        "load": load_document(scene.load),
    }
    for name in HISTORY_FIELDS:
        if (history := getattr(scene, name)) != Step():
            document[name] = history_document(history)
    if isinstance(scene.friction, Law):
        document["friction_law"] = law_table(scene.friction)
    if scene.antiplane:
        document["mode"] = scene.mode
    if scene.load_on != SLOT:
        document["load_on"] = scene.load_on
    if scene.units:
        document["units"] = scene.units
    if scene.lower_material is not None:
        document["lower_material"] = asdict(scene.lower_material)
    return document


def history_document(history: Any) -> dict[str, Any]:
    """Return a history as a dictionary of its kind and parameters."""
    return {"kind": history_kind(history), **asdict(history)}


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
        name: history_from_table(name, document[name])
        for name in HISTORY_FIELDS
        if name in document
    }
    friction: float | Law | None = document.get("friction")
    if "friction_law" in document:
        friction = law_from_table("friction_law", document["friction_law"], friction, scene=True)
    return Scene(
        material=Material(**document["material"]),
        friction=friction,  # type: ignore[arg-type]  # the scene refuses None
        base=Tractions(**document["base"]),
        load=load,
        mode=document.get("mode", IN_PLANE),
        load_on=document.get("load_on", SLOT),
        units=document.get("units", ""),
        lower_material=Material(**lower) if (lower := document.get("lower_material")) else None,
        **parts,
    )


def history_from_table(name: str, table: Any) -> Any:
    """Return the history that a table with a kind and parameters describes."""
    kind = checked_table(name, table).get("kind")
    return made(name, known_class(name, HISTORIES, LoadHistory, HISTORY_KINDS, kind), table)


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
