"""JSON Schema of what every command prints with ``--json``, and the table of docs/json.md.

``python -m compare.schema --write`` writes docs/schema.json and docs/data/json-keys.csv from what
stands here and from the fields of the rows; ``--check`` says whether they are up to date.
"""

from __future__ import annotations

import argparse
import json
import types
import typing
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, NamedTuple

from compare.benchmarks.classes import Tolerance
from compare.benchmarks.scores import Score
from compare.benchmarks.sheets import Sheet
from compare.comparison.fields.errors import FieldError
from compare.comparison.rows import Row
from compare.output.files import write_text
from compare.output.tables import write_rows
from compare.studies.article.claims import Verdict
from compare.studies.chart.study import Point
from compare.studies.evidence.study import ClosedForm
from compare.studies.regimes.points import BoundaryPoint
from compare.studies.wear import MostRow, WearRow
from compare.validation.bars import JudgedRow
from compare.validation.norms import Norm

DOCS = Path(__file__).resolve().parents[1] / "docs"
COMMAND = "python -m compare.schema --write"

Schema = Mapping[str, Any]


class Key(NamedTuple):
    """A key of a document: what it means, what may stand there, whether it always does."""

    meaning: str
    schema: Schema
    always: bool = True


TEXT: Schema = {"type": "string"}
WHOLE: Schema = {"type": "integer"}
TRUTH: Schema = {"type": "boolean"}
NUMBER: Schema = {"type": ["number", "null"]}
"""Null stands for what is infinite, or is not there."""


def _of(schema: Schema) -> Schema:
    """Any names, each with such a value."""
    return {"type": "object", "additionalProperties": schema}


def _list(schema: Schema) -> Schema:
    return {"type": "array", "items": schema}


def _object(optional: Sequence[str] = (), /, **properties: Schema) -> Schema:
    """Exactly these names."""
    return {
        "type": "object",
        "properties": properties,
        "required": [name for name in properties if name not in optional],
        "additionalProperties": False,
    }


def _or_null(schema: Schema) -> Schema:
    return {"anyOf": [schema, {"type": "null"}]}


def _row(kind: type, **more: Schema) -> Schema:
    """The fields of a dataclass, by their annotations."""
    hints = typing.get_type_hints(kind)
    described = {one.name: _typed(hints[one.name]) for one in fields(kind)}
    return _object(**described, **more)


def _typed(hint: Any) -> Schema:
    """What may stand in a field."""
    plain = {str: TEXT, int: WHOLE, bool: TRUTH, float: NUMBER}
    if hint in plain:
        return plain[hint]
    inner = typing.get_args(hint)
    if isinstance(hint, types.UnionType):
        (kind,) = (one for one in inner if one is not types.NoneType)
        return _or_null(_typed(kind))
    return (
        _list(_typed(inner[0])) if len(inner) == 2 and inner[1] is ... else _of(_typed(inner[-1]))
    )


SCENE, UNITS = {"$ref": "#/$defs/scene"}, {"$ref": "#/$defs/units"}
_MATERIAL = _object(shear_modulus=NUMBER, density=NUMBER, poisson_ratio=NUMBER)
_TRACTIONS = _object(pressure=NUMBER, shear=NUMBER)
_KIND: Schema = {"type": "object", "properties": {"kind": TEXT}, "required": ["kind"]}
_OPTIONAL = ("pressure_history", "shear_history", "friction_law", "mode", "load_on", "units")
_DEFINITIONS: Schema = {
    "scene": _object(
        _OPTIONAL,
        friction=NUMBER,
        material=_MATERIAL,
        base=_TRACTIONS,
        load=_TRACTIONS,
        pressure_history=_KIND,
        shear_history=_KIND,
        friction_law=_KIND,
        mode=TEXT,
        load_on=TEXT,
        units=TEXT,
    ),
    "units": _of({"anyOf": [TEXT, UNITS]}),
}
ENVELOPE: Mapping[str, Key] = {
    "command": Key("as it is typed behind slipfront", TEXT),
    "version": Key("of slipfront", TEXT),
    "status": Key("done; converged, resolved or why not; or the verdict", TEXT),
    "units": Key("of all numbers, under the same names; one for a whole list", UNITS),
    "files": Key("that were written", _list(TEXT)),
}
_SCENE_KEY = Key("the scene, as its TOML file has it", SCENE)
_COUNTS = Key("rows by verdict", _of(WHOLE))
_VERDICT = Key("agrees, differs or unresolved", TEXT)
_LABEL = Key("name of the scene", TEXT)
_PARAMETERS = Key("the scene itself", SCENE)
_ESTIMATE = Key("of the answer, relative", NUMBER)
_METHOD = Key("self-similar or space-time", TEXT)
_RUN = _object(
    run=TEXT,
    end_time=NUMBER,
    resolution=NUMBER,
    companions=_list(NUMBER),
    element_size=NUMBER,
    model=TEXT,
    damping=NUMBER,
    time_step=NUMBER,
    critical_step=NUMBER,
    steps=WHOLE,
    unknowns=WHOLE,
    caution=TEXT,
    opened=_or_null({"type": "object"}),
    seconds=_of(NUMBER),
)
_CLAIMS = Key(
    "of the article, with the verdict of each method",
    _list(_object(section=TEXT, claim=TEXT, base=TEXT, verdicts=_of(_row(Verdict)))),
)
_ZONE = _object(inner=NUMBER, outer=NUMBER, sense=WHOLE, inner_regime=TEXT, outer_regime=TEXT)

DOCUMENTS: Mapping[str, Sequence[Mapping[str, Key]]] = {
    "solve": (
        {
            "scene": _SCENE_KEY,
            "wave_speeds": Key("of the waves that the fields have", _of(NUMBER)),
            "zones": Key("velocities of the edges of slip zones", _list(_ZONE)),
            "openings": Key("the same of what opens", _list(_object(inner=NUMBER, outer=NUMBER))),
            "edge": Key(
                "what the interface does at x = 0+",
                _object(state=TEXT, slip_rate=NUMBER, stress_intensity_at_unit_time=_of(NUMBER)),
            ),
            "far_slip_rate": Key("ahead of all waves", NUMBER),
            "error_estimate": _ESTIMATE,
            "statistics": Key("what it took", {"type": "object"}),
            "until_end_time": Key("with --end-time: zones, slip, work", {"type": "object"}, False),
        },
        {
            "scene": _SCENE_KEY,
            "method": Key("space-time: a march, and all keys below", {"const": "space-time"}),
            "caution": Key("why it is unresolved", TEXT),
            "error_estimate": _ESTIMATE,
            "end_time": Key("T", NUMBER),
            "largest_slip_rate": Key("over contact and time", NUMBER),
            "largest_slip": Key("over contact and time", NUMBER),
            "reach_of_slip": Key("x up to which it slips forward", NUMBER),
            "reach_of_reverse_slip": Key("x up to which it slips backward", NUMBER),
            "onset": Key("when slip starts at some x", _list(_object(x=NUMBER, time=NUMBER))),
            "accumulated_slip": Key("over the contact", NUMBER),
            "frictional_work": Key("over the contact", NUMBER),
            "stress_intensity_of_a_stuck_edge": Key("at T", _of(NUMBER)),
            "stored_levels": Key("of the history", WHOLE),
            "statistics": Key("what it took", {"type": "object"}),
        },
    ),
    "fit": (
        {
            "scene": _SCENE_KEY,
            "parameters": Key("by name", _of(_object(value=NUMBER, standard_error=NUMBER))),
            "covariance": Key("of the parameters, in their order", _list(_list(NUMBER))),
            "correlation": Key("likewise", _list(_list(NUMBER))),
            "chi2": Key("sum of squares of the misfits over the noise", NUMBER),
            "freedom": Key("samples less parameters", WHOLE),
            "unconstrained": Key("parameters that the data leave free", _list(TEXT)),
            "known_by_prior": Key("parameters known by their prior alone", _list(TEXT)),
            "minima": Key("all that were found", _list(_object(values=_list(NUMBER), chi2=NUMBER))),
            "gauges": Key(
                "records, each with its part of chi2",
                _list(
                    _object(
                        name=TEXT, quantity=TEXT, x=NUMBER, y=NUMBER, samples=WHOLE, chi2=NUMBER
                    )
                ),
            ),
            "derivative_error": Key("of the derivatives, relative", NUMBER),
            "solutions": Key("that it took", WHOLE),
            "misfit": Key("how large misfits are for the noise, in a sentence", TEXT),
            "posterior": Key("with --posterior: what was sampled", {"type": "object"}, False),
        },
    ),
    "explore": (
        {
            "scene": _SCENE_KEY,
            "address": Key("of the page, served until the command is ended", TEXT),
        },
    ),
    "survey": (
        {
            "file": Key("that holds everything", TEXT),
            "points": Key("scenes that were asked for", WHOLE),
            "dimensions": Key("their lengths", _of(WHOLE)),
            "parameters": Key(
                "what varies, from where to where",
                _of(_object(least=NUMBER, largest=NUMBER, count=WHOLE)),
            ),
            "statuses": Key("how many scenes ended in each", _of(WHOLE)),
            "methods": Key("how many were solved by each", _of(WHOLE)),
            "largest_error_estimate": Key("of all scenes", NUMBER),
            "seconds": Key("of processor time", NUMBER),
            "variables": Key("in the file; their units are in units.variables", _list(TEXT)),
        },
    ),
    "compare": (
        {
            "scene": _LABEL,
            "verdict": _VERDICT,
            "counts": _COUNTS,
            "parameters": _PARAMETERS,
            "method": _METHOD,
            "caution": Key("why the prediction is unresolved", TEXT),
            "semianalytic": Key("as of solve; null of a march", _or_null({"type": "object"})),
            "finite_elements": Key("how they were run", _RUN),
            "rows": Key(
                "quantities, judged", _list(_row(Row, verdict=TEXT, remedy=_or_null(TEXT)))
            ),
            "fields": Key(
                "errors of snapshots",
                _or_null(_object(band=NUMBER, frames=_list(_row(FieldError)))),
            ),
        },
    ),
    "simulate": (
        {
            "scene": _SCENE_KEY,
            "lower_material": Key("where it is another one", _or_null(_MATERIAL)),
            "finite_elements": Key("how they were run", _RUN),
            "own_bars": Key(
                "how far it may be off, by coarser meshes",
                _list(_object(name=TEXT, bar=NUMBER, unit=TEXT)),
            ),
        },
    ),
    "field": (
        {
            "scene": _SCENE_KEY,
            "method": _METHOD,
            "error_estimate": _ESTIMATE,
            "of": Key("what is drawn", TEXT),
            "time": Key("of the picture", NUMBER),
            "window": Key("that is shown", _object(x0=NUMBER, x1=NUMBER, y0=NUMBER, y1=NUMBER)),
            "frames": Key("of the animation", WHOLE),
            "gauges": Key("recorded, in the order of files", _list(_object(x=NUMBER, y=NUMBER))),
        },
    ),
    "validate": (
        {
            "format": Key("of report.json, which is the same", TEXT),
            "slipfront": Key("version", TEXT),
            "source": Key("of each file", _list(TEXT)),
            "scene": _LABEL,
            "verdict": Key("agrees, agrees after conversion, differs or unresolved", TEXT),
            "counts": _COUNTS,
            "reading": Key(
                "how the numbers of the file were read: what was inferred, the options that state "
                "it, factors and offsets, largest error that is left, and as given",
                _object(
                    inferred=_list(TEXT),
                    stated_by=_list(_list(TEXT)),
                    factors=_of(NUMBER),
                    offsets=_of(NUMBER),
                    left=NUMBER,
                    as_given=NUMBER,
                    runner_up=TEXT,
                ),
            ),
            "notes": Key("what was given, and what was mended", _list(TEXT)),
            "parameters": _PARAMETERS,
            "method": _METHOD,
            "end_time": Key("T", NUMBER),
            "spacing": Key("of the finest grid", NUMBER),
            "ratio": Key("of two grids", NUMBER),
            "slip_rate_is": Key("at or over which times", TEXT),
            "noise": Key("standard deviation of samples, by quantity", _of(NUMBER)),
            "rows": Key("quantities, judged", _list(_row(JudgedRow, verdict=TEXT))),
            "norms": Key("errors at stations, and over all", _list(_row(Norm))),
        },
    ),
    "scenes": (
        {
            "scenes": Key(
                "all that have a name",
                _list(
                    _object(
                        name=TEXT,
                        what=TEXT,
                        package=_or_null(TEXT),
                        problem=TEXT,
                        summary=TEXT,
                        scene=_or_null(SCENE),
                    )
                ),
            ),
            "brought": Key(
                "laws, histories and figures of packages",
                _list(_object(name=TEXT, what=TEXT, package=TEXT, problem=TEXT)),
            ),
        },
    ),
    "init": ({"scene": _SCENE_KEY, "text": Key("of the TOML file", TEXT)},),
    "benchmark": ({"sheets": Key("all of them", _list(_row(Sheet, marched=TRUTH, scene=SCENE)))},),
    "benchmark show": (
        {
            "sheet": Key("its name", TEXT),
            "title": Key("its title", TEXT),
            "system": Key("of units", TEXT),
            "scene": _SCENE_KEY,
            "si_scene": Key("the same in SI units", SCENE),
            "si_scales": Key("what answers are multiplied by for SI", _of(NUMBER)),
            "stations": Key("over c_t T", _list(NUMBER)),
            "times": Key("over T", _list(NUMBER)),
            "arrival": Key("what is timed", TEXT),
            "sure": Key("how many digits", TEXT),
            "answers": Key("by quantity", {"type": "object"}),
            "errors": Key("of marched answers", {"type": "object"}),
            "tolerances": Key("by class", _list(_row(Tolerance))),
        },
    ),
    "benchmark export": ({"sheets": Key("names", _list(TEXT))},),
    "benchmark score": ({"scores": Key("of each run and quantity", _list(_row(Score)))},),
    "benchmark enter": (
        {
            "sheet": Key("its name", TEXT),
            "code": Key("that ran", TEXT),
            "cells": Key("over c_t T", NUMBER),
            "stations": Key("that were recorded", _list(NUMBER)),
            "seconds": Key("that it took", NUMBER),
        },
    ),
    "regimes": (
        {
            "regimes": Key("points of each map by regime", _of(_of(WHOLE))),
            "boundaries": Key("curves between them", _list(_row(BoundaryPoint))),
        },
    ),
    "stability": (
        {"studies": Key("tables of each, as in its files", _of(_of(_list({"type": "object"}))))},
    ),
    "article": (
        {"claims": _CLAIMS, "disagreement": Key("of solver and simulation, mean", NUMBER)},
    ),
    "chart": (
        {
            "points": Key("measured, as in data/chart.csv", _list(_row(Point))),
            "slopes": Key("error against time, by scene and method", _of(_of(NUMBER))),
        },
    ),
    "wear": (
        {
            "rows": Key("of each transient", _list(_row(WearRow))),
            "most": Key("friction of most frictional work", _list(_row(MostRow))),
        },
    ),
    "evidence": (
        {
            "verdict": _VERDICT,
            "counts": _COUNTS,
            "scenes": Key(
                "each by all methods",
                _list(
                    _object(
                        scene=TEXT,
                        parameters=SCENE,
                        verdict=_or_null(TEXT),
                        counts=_of(WHOLE),
                        methods=_list(TEXT),
                        obstacle=TEXT,
                    )
                ),
            ),
            "closed_forms": Key("errors of all methods", _list(_row(ClosedForm))),
            "claims": _CLAIMS,
            "stamp": Key("versions, machine, date", _of({"type": ["string", "number"]})),
            "seconds": Key("that it took", NUMBER),
        },
    ),
}
"""What each command adds to the `ENVELOPE`; solve has two ways."""


def schema() -> dict[str, Any]:
    """The schema of all documents."""
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "What slipfront prints with --json",
        "anyOf": [_command(name, keys) for name, ways in DOCUMENTS.items() for keys in ways],
        "$defs": _DEFINITIONS,
    }


def _command(name: str, keys: Mapping[str, Key]) -> Schema:
    whole = {**ENVELOPE, **keys}
    described = {key: {"description": one.meaning, **one.schema} for key, one in whole.items()}
    described["command"] = {"const": name}
    return _object([key for key, one in whole.items() if not one.always], **described)


@dataclass(frozen=True)
class KeyRow:
    """A key of the document of a command."""

    command: str
    key: str
    meaning: str


def key_rows() -> list[KeyRow]:
    """All keys, those of all commands first."""
    rows = [KeyRow("all", key, one.meaning) for key, one in ENVELOPE.items()]
    for name, ways in DOCUMENTS.items():
        merged = {key: one for keys in ways for key, one in keys.items()}
        rows += [KeyRow(name, key, one.meaning) for key, one in merged.items()]
    return rows


def schema_text() -> str:
    """As docs/schema.json holds it."""
    return json.dumps(schema(), indent=1, ensure_ascii=False) + "\n"


def write(docs: Path = DOCS) -> None:
    """Write schema and table; raises a DataFileError."""
    write_text(docs / "schema.json", schema_text())
    write_rows(docs / "data" / "json-keys.csv", key_rows(), command=COMMAND)


def main(arguments: Sequence[str] | None = None) -> int:
    """Write the schema, or say whether it is up to date; 1 if it is not."""
    parser = argparse.ArgumentParser(prog="python -m compare.schema", description=__doc__)
    what = parser.add_mutually_exclusive_group(required=True)
    what.add_argument("--check", action="store_true", help="say whether the files are up to date")
    what.add_argument("--write", action="store_true", help="write them")
    if parser.parse_args(arguments).write:
        write()
        return 0
    stale = (DOCS / "schema.json").read_text(encoding="utf-8") != schema_text()
    print("docs/schema.json: " + ("not up to date" if stale else "up to date"))
    return int(stale)


if __name__ == "__main__":
    raise SystemExit(main())
