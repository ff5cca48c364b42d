"""Parts that the documents of several commands share: scenes, materials, tractions, verdicts."""

from __future__ import annotations

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
_OPTIONAL = ("pressure_history", "shear_history", "friction_law", "mode", "load_on", "units")
DEFINITIONS: Schema = {
    "scene": object_of(
        _OPTIONAL,
        friction=NUMBER,
        material=MATERIAL,
        base=TRACTIONS,
        load={"anyOf": [TRACTIONS, KIND]},
        pressure_history=KIND,
        shear_history=KIND,
        friction_law=KIND,
        mode=TEXT,
        load_on=TEXT,
        units=TEXT,
    ),
    "units": named({"anyOf": [TEXT, UNITS]}),
}
LINE = object_of(
    ("mode", "units"),
    contact=TEXT,
    friction=NUMBER,
    material=MATERIAL,
    base=TRACTIONS,
    load=KIND,
    mode=TEXT,
    units=TEXT,
)
PAIR = object_of(
    ("friction_law", "units"),
    friction=NUMBER,
    material=MATERIAL,
    lower_material=MATERIAL,
    base=TRACTIONS,
    load=TRACTIONS,
    friction_law=KIND,
    units=TEXT,
)
SCENES: Schema = {"anyOf": [SCENE, PAIR]}
PROBLEM: Schema = {"anyOf": [SCENE, LINE, PAIR, object_of(interface=TEXT)]}
COUNTS = Key("rows by verdict", named(WHOLE))
VERDICT = Key("agrees, differs or unresolved", TEXT)
