"""Words of which the JSON Schema of the command line is made, and what its documents share."""

from __future__ import annotations

import types
import typing
from collections.abc import Mapping, Sequence
from dataclasses import fields
from typing import Any, NamedTuple

Schema = Mapping[str, Any]


class Key(NamedTuple):
    """A key of a document: its meaning, its values, and whether it is always present."""

    meaning: str
    schema: Schema
    always: bool = True


ANYTHING: Schema = {"type": "object"}
TEXT: Schema = {"type": "string"}
WHOLE: Schema = {"type": "integer"}
TRUTH: Schema = {"type": "boolean"}
NUMBER: Schema = {"type": ["number", "null"]}
"""Schema of a number; null stands for infinite or absent values."""


def named(schema: Schema) -> Schema:
    """Return the schema of an object with any names, each with a value of this schema."""
    return {"type": "object", "additionalProperties": schema}


def list_of(schema: Schema) -> Schema:
    return {"type": "array", "items": schema}


def object_of(optional: Sequence[str] = (), /, **properties: Schema) -> Schema:
    """Return the schema of an object with exactly these names."""
    return {
        "type": "object",
        "properties": properties,
        "required": [name for name in properties if name not in optional],
        "additionalProperties": False,
    }


def shape(numbers: str = "", texts: str = "", wholes: str = "", **others: Schema) -> Schema:
    """Return the schema of an object with names of numbers, texts and whole numbers, and others."""
    kinds = ((numbers, NUMBER), (texts, TEXT), (wholes, WHOLE))
    return object_of(**{name: kind for names, kind in kinds for name in names.split()}, **others)


def or_null(schema: Schema) -> Schema:
    return {"anyOf": [schema, {"type": "null"}]}


def row_of(kind: type, **more: Schema) -> Schema:
    """Return the schema of a dataclass by the annotations of its fields."""
    hints = typing.get_type_hints(kind)
    described = {field.name: typed_as(hints[field.name]) for field in fields(kind)}
    return object_of(**described, **more)


def typed_as(hint: Any) -> Schema:
    """Return the schema of values with a type annotation."""
    plain = {str: TEXT, int: WHOLE, bool: TRUTH, float: NUMBER}
    if hint in plain:
        return plain[hint]
    inner = typing.get_args(hint)
    if isinstance(hint, types.UnionType):
        (kind,) = (entry for entry in inner if entry is not types.NoneType)
        return or_null(typed_as(kind))
    return (
        list_of(typed_as(inner[0]))
        if len(inner) == 2 and inner[1] is ...
        else named(typed_as(inner[-1]))
    )


SCENE, UNITS = {"$ref": "#/$defs/scene"}, {"$ref": "#/$defs/units"}
SPECIMEN: Schema = {"$ref": "#/$defs/specimen"}
MATERIAL, TRACTIONS = shape("shear_modulus density poisson_ratio"), shape("pressure shear")
KIND: Schema = {"type": "object", "properties": {"kind": TEXT}, "required": ["kind"]}
FIELD: Schema = {"anyOf": [NUMBER, TEXT, ANYTHING]}
"""A number, an expression of x, or a table."""
_ALONG: Schema = object_of(
    ("shear", "pressure", "history", "on"), shear=FIELD, pressure=FIELD, history=FIELD, on=TEXT
)
_LOAD: Schema = {"anyOf": [TRACTIONS, KIND, _ALONG]}
_WORDS = dict.fromkeys(("mode", "units", "load_on"), TEXT)
_LAWS = dict.fromkeys(("pressure_history", "shear_history", "friction_law"), KIND)
_BASE: Schema = object_of(pressure=FIELD, shear=FIELD)
_LINE = {
    **dict.fromkeys(("friction", "period", "rate", "plate_rate", "held"), FIELD),
    **{key: {"anyOf": [TEXT, TRUTH, ANYTHING]} for key in ("contact", "even")},
    **dict.fromkeys(("adhesion", "numbers", "run"), ANYTHING),
}
_OPTIONAL = {**_LAWS, **_WORDS, **_LINE, "lower_material": MATERIAL}
ANY: Schema = {}
_SPECIMEN = (
    *("friction_law", "friction", "base", "load", "contact", "history", "gauges", "run"),
    *("summary", "units"),
)
DEFINITIONS: Schema = {
    "scene": object_of(
        tuple(_OPTIONAL),
        material=MATERIAL,
        base=_BASE,
        load={"anyOf": [_LOAD, list_of(_LOAD)]},
        **_OPTIONAL,
    ),
    "specimen": object_of(
        _SPECIMEN, upper=ANYTHING, lower=ANYTHING, **dict.fromkeys(_SPECIMEN, ANY)
    ),
    "units": named({"anyOf": [TEXT, UNITS]}),
}
COUNTS = Key("rows by verdict", named(WHOLE))
VERDICT = Key("agrees, differs or unresolved", TEXT)
