"""Parts that the documents of several commands share: scenes, materials, tractions, verdicts."""

from __future__ import annotations

from collections.abc import Mapping

from docs.studies.schema.vocabulary import (
    NUMBER,
    SCENE,
    TEXT,
    UNITS,
    WHOLE,
    Key,
    Schema,
    named,
    object_of,
    shape,
)

MATERIAL, TRACTIONS = shape("shear_modulus density poisson_ratio"), shape("pressure shear")
KIND: Schema = {"type": "object", "properties": {"kind": TEXT}, "required": ["kind"]}
_WORDS = dict.fromkeys(("mode", "units"), TEXT)
_LAWS = dict.fromkeys(("pressure_history", "shear_history", "friction_law"), KIND)
_GIVEN: Mapping[str, Schema] = {"friction": NUMBER, "material": MATERIAL, "base": TRACTIONS}
_ANY_LOAD = {"anyOf": [TRACTIONS, KIND]}
DEFINITIONS: Schema = {
    "scene": object_of(
        (*_LAWS, *_WORDS, "load_on"), **_GIVEN, load=_ANY_LOAD, **_LAWS, **_WORDS, load_on=TEXT
    ),
    "units": named({"anyOf": [TEXT, UNITS]}),
}
LINE = object_of(tuple(_WORDS), contact=TEXT, **_GIVEN, load=KIND, **_WORDS)
_PAIRED = {"lower_material": MATERIAL, "load": TRACTIONS, "friction_law": KIND, "units": TEXT}
PAIR = object_of(("friction_law", "units"), **_GIVEN, **_PAIRED)
SCENES: Schema = {"anyOf": [SCENE, PAIR]}
PROBLEM: Schema = {"anyOf": [SCENE, LINE, PAIR, object_of(interface=TEXT)]}
COUNTS = Key("rows by verdict", named(WHOLE))
VERDICT = Key("agrees, differs or unresolved", TEXT)
