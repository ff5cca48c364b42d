"""Write the JSON Schema of the output of every command with ``--json``, and the table of keys.

``python -m docs.studies.schema --write`` writes docs/schema.json and docs/data/json-keys.csv, which
docs/json.md shows, from the definitions here and the fields of the rows.  ``--check`` tests whether
they are up to date.
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
from compare.benchmarks.sheet import Sheet
from compare.comparison.fields.errors import FieldError
from compare.comparison.rows import Row
from compare.output.files import write_text
from compare.output.tables import write_rows
from compare.studies.article.claims import Verdict
from compare.studies.chart.study import Point
from compare.studies.dissimilar.points import NamedPoint, ThresholdPoint
from compare.studies.evidence.study import ClosedForm
from compare.studies.regimes.points import BoundaryPoint
from compare.studies.supershear.points import TransitionPoint
from compare.studies.wear import MostRow, WearRow
from compare.validation.bars import JudgedRow
from compare.validation.norms import Norm
from semianalytic import SlidingWave
from semianalytic.results.answer import ARRIVALS, FIELDS

DOCS = Path(__file__).resolve().parents[2] / "docs"
COMMAND = "python -m docs.studies.schema --write"

Schema = Mapping[str, Any]


class Key(NamedTuple):
    """A key of a document: its meaning, its values, and whether it is always present."""

    meaning: str
    schema: Schema
    always: bool = True


TEXT: Schema = {"type": "string"}
WHOLE: Schema = {"type": "integer"}
TRUTH: Schema = {"type": "boolean"}
NUMBER: Schema = {"type": ["number", "null"]}
"""Schema of a number; null stands for infinite or absent values."""


def _of(schema: Schema) -> Schema:
    """Return the schema of an object with any names, each with a value of this schema."""
    return {"type": "object", "additionalProperties": schema}


def _list(schema: Schema) -> Schema:
    return {"type": "array", "items": schema}


def _object(optional: Sequence[str] = (), /, **properties: Schema) -> Schema:
    """Return the schema of an object with exactly these names."""
    return {
        "type": "object",
        "properties": properties,
        "required": [name for name in properties if name not in optional],
        "additionalProperties": False,
    }


def _or_null(schema: Schema) -> Schema:
    return {"anyOf": [schema, {"type": "null"}]}


def _row(kind: type, **more: Schema) -> Schema:
    """Return the schema of a dataclass by the annotations of its fields."""
    hints = typing.get_type_hints(kind)
    described = {one.name: _typed(hints[one.name]) for one in fields(kind)}
    return _object(**described, **more)


def _typed(hint: Any) -> Schema:
    """Return the schema of values with a type annotation."""
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
        load={"anyOf": [_TRACTIONS, _KIND]},
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
    "command": Key("the command, as typed after slipfront", TEXT),
    "version": Key("version of slipfront", TEXT),
    "status": Key("done; converged, resolved or the reason why not; or the verdict", TEXT),
    "units": Key("units of all numbers, under the same names; one for a whole list", UNITS),
    "files": Key("files written", _list(TEXT)),
}
_LINE = _object(
    ("mode", "units"),
    contact=TEXT,
    friction=NUMBER,
    material=_MATERIAL,
    base=_TRACTIONS,
    load=_KIND,
    mode=TEXT,
    units=TEXT,
)
_PAIR = _object(
    ("friction_law", "units"),
    friction=NUMBER,
    material=_MATERIAL,
    lower_material=_MATERIAL,
    base=_TRACTIONS,
    load=_TRACTIONS,
    friction_law=_KIND,
    units=TEXT,
)
_PROBLEM: Schema = {"anyOf": [SCENE, _LINE, _object(interface=TEXT)]}
_SCENE_KEY = Key("the scene, as its TOML file has it", SCENE)
_INTERFACE = _object(
    interface={"type": "object"}, end_time=_or_null(NUMBER), options={"type": "object"}
)
_SUBJECT: Schema = {"anyOf": [SCENE, _INTERFACE]}
_COUNTS = Key("rows by verdict", _of(WHOLE))
_VERDICT = Key("agrees, differs or unresolved", TEXT)
_LABEL = Key("name of the scene", TEXT)
_PARAMETERS = Key("the scene itself", SCENE)
_ESTIMATE = Key("relative error estimate of the answer", NUMBER)
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
    "claims of the article, with the verdict of each method",
    _list(_object(section=TEXT, claim=TEXT, base=TEXT, verdicts=_of(_row(Verdict)))),
)
_PART = _object(inner=NUMBER, outer=NUMBER, sense=WHOLE)
_MEASURED = _object(value=NUMBER, error=NUMBER)
_POINT = _object(
    ("t", *FIELDS),
    x=NUMBER,
    t=NUMBER,
    arrivals=_object(**{name: _MEASURED for name in ARRIVALS}),
    **{name: _MEASURED for name in FIELDS},
)
_POINTS = Key(
    "arrivals and fields at --x and --t, if given, each a value and the bar of its error",
    _list(_POINT),
    False,
)
_ZONE = _object(inner=NUMBER, outer=NUMBER, sense=WHOLE, inner_regime=TEXT, outer_regime=TEXT)

_FIELD = {
    "method": _METHOD,
    "error_estimate": _ESTIMATE,
    "of": Key("quantity drawn", TEXT),
    "time": Key("time of the picture", NUMBER),
    "window": Key("region shown", _object(x0=NUMBER, x1=NUMBER, y0=NUMBER, y1=NUMBER)),
    "frames": Key("number of frames of the animation", WHOLE),
    "gauges": Key("gauges recorded, in the order of the files", _list(_object(x=NUMBER, y=NUMBER))),
}
"""Keys of ``slipfront field`` for bodies alike and different."""

DOCUMENTS: Mapping[str, Sequence[Mapping[str, Key]]] = {
    "solve": (
        {
            "scene": _SCENE_KEY,
            "wave_speeds": Key("speeds of the waves that occur in the fields", _of(NUMBER)),
            "zones": Key("velocities of the edges of slip zones", _list(_ZONE)),
            "openings": Key(
                "velocities of the edges of openings", _list(_object(inner=NUMBER, outer=NUMBER))
            ),
            "edge": Key(
                "state of the interface at x = 0+",
                _object(state=TEXT, slip_rate=NUMBER, stress_intensity_at_unit_time=_of(NUMBER)),
            ),
            "far_slip_rate": Key("slip rate ahead of all waves", NUMBER),
            "error_estimate": _ESTIMATE,
            "statistics": Key("cost of the computation", {"type": "object"}),
            "until_end_time": Key(
                "zones, slip and work until --end-time, if given", {"type": "object"}, False
            ),
            "points": _POINTS,
        },
        {
            "scene": _SCENE_KEY,
            "method": Key("space-time: a march, which has all keys below", {"const": "space-time"}),
            "caution": Key("reason why the march is unresolved", TEXT),
            "error_estimate": _ESTIMATE,
            "end_time": Key("end time T", NUMBER),
            "largest_slip_rate": Key("largest slip rate over contact and time", NUMBER),
            "largest_slip": Key("largest slip over contact and time", NUMBER),
            "reach_of_slip": Key("largest x that slips forward", NUMBER),
            "reach_of_reverse_slip": Key("largest x that slips backward", NUMBER),
            "onset": Key(
                "times at which slip starts at some x", _list(_object(x=NUMBER, time=NUMBER))
            ),
            "accumulated_slip": Key("accumulated slip, integral over the contact", NUMBER),
            "frictional_work": Key("frictional work, integral over the contact", NUMBER),
            "stress_intensity_of_a_stuck_edge": Key(
                "stress intensity factors of a stuck edge at T", _of(NUMBER)
            ),
            "stored_levels": Key("number of stored time levels of the history", WHOLE),
            "statistics": Key("cost of the computation", {"type": "object"}),
            "points": _POINTS,
        },
        {
            "line": Key("whole line or growing load, as its TOML file has it", {"type": "object"}),
            "wave_speeds": Key("speeds of the waves that occur in the fields", _of(NUMBER)),
            "edge_speed": Key("speed of the edges of slip or opening of a line", NUMBER),
            "edge_amplitude": Key("rate over sqrt(1 - x/(edge speed t)) beside an edge", NUMBER),
            "zones": Key("velocities of the edges of slip zones", _list(_PART)),
            "openings": Key(
                "velocities of the edges of openings", _list(_object(inner=NUMBER, outer=NUMBER))
            ),
            "error_estimate": _ESTIMATE,
            "until_end_time": Key(
                "zones, slip and work until --end-time, if given", {"type": "object"}, False
            ),
        },
        {
            "pair": Key("two different bodies, as their TOML file has them", _PAIR),
            "wave_speeds": Key("speeds of the waves of both bodies", _of(_of(NUMBER))),
            "zones": Key("velocities of the edges of slip zones", _list(_PART)),
            "openings": Key(
                "velocities of the edges of openings", _list(_object(inner=NUMBER, outer=NUMBER))
            ),
            "edge_slip_rate": Key("slip rate of two different bodies at x = 0+", NUMBER),
            "error_estimate": _ESTIMATE,
            "statistics": Key("cost of the computation", {"type": "object"}),
            "until_end_time": Key(
                "zones, slip and work until --end-time, if given", {"type": "object"}, False
            ),
            "points": _POINTS,
        },
    ),
    "fit": (
        {
            "scene": Key("the scene as its TOML file has it, or the interface", _SUBJECT),
            "parameters": Key(
                "fitted values and standard errors by name",
                _of(_object(value=NUMBER, standard_error=NUMBER)),
            ),
            "covariance": Key("covariance of the parameters, in their order", _list(_list(NUMBER))),
            "correlation": Key(
                "correlation of the parameters, in their order", _list(_list(NUMBER))
            ),
            "chi2": Key("sum of squares of the misfits over the noise", NUMBER),
            "freedom": Key("degrees of freedom: samples minus parameters", WHOLE),
            "unconstrained": Key("parameters that the data leave free", _list(TEXT)),
            "known_by_prior": Key("parameters known by their prior alone", _list(TEXT)),
            "minima": Key("all minima found", _list(_object(values=_list(NUMBER), chi2=NUMBER))),
            "gauges": Key(
                "records, each with its contribution to chi2",
                _list(
                    _object(
                        name=TEXT, quantity=TEXT, x=NUMBER, y=NUMBER, samples=WHOLE, chi2=NUMBER
                    )
                ),
            ),
            "derivative_error": Key("relative error of the derivatives", NUMBER),
            "solutions": Key("number of solutions computed", WHOLE),
            "misfit": Key("a sentence that compares the misfits with the noise", TEXT),
            "posterior": Key("the samples of --posterior, if given", {"type": "object"}, False),
        },
    ),
    "explore": (
        {
            "scene": _SCENE_KEY,
            "address": Key("address of the page, served until the command ends", TEXT),
        },
    ),
    "survey": (
        {
            "file": Key("file that contains all results", TEXT),
            "points": Key("number of scenes requested", WHOLE),
            "dimensions": Key("lengths of the dimensions", _of(WHOLE)),
            "parameters": Key(
                "varied parameters and their ranges",
                _of(_object(least=NUMBER, largest=NUMBER, count=WHOLE)),
            ),
            "statuses": Key("number of scenes with each status", _of(WHOLE)),
            "methods": Key("number of scenes solved by each method", _of(WHOLE)),
            "largest_error_estimate": Key("largest error estimate of all scenes", NUMBER),
            "seconds": Key("processor time in seconds", NUMBER),
            "variables": Key(
                "variables in the file; their units are in units.variables", _list(TEXT)
            ),
        },
    ),
    "compare": (
        {
            "scene": _LABEL,
            "verdict": _VERDICT,
            "counts": _COUNTS,
            "parameters": _PARAMETERS,
            "method": _METHOD,
            "caution": Key("reason why the prediction is unresolved", TEXT),
            "semianalytic": Key(
                "result as printed by solve; null for a march", _or_null({"type": "object"})
            ),
            "finite_elements": Key("settings and cost of the simulation", _RUN),
            "rows": Key("judged quantities", _list(_row(Row, verdict=TEXT, remedy=_or_null(TEXT)))),
            "fields": Key(
                "errors of snapshots",
                _or_null(_object(band=NUMBER, frames=_list(_row(FieldError)))),
            ),
        },
    ),
    "run": (
        {
            "interface": Key("name or file of the interface", TEXT),
            "nodes": Key("nodes of one period", WHOLE),
            "end_time": Key("time that was reached", NUMBER),
            "steps": Key("number of steps", WHOLE),
            "shortest_step": Key("shortest step", NUMBER),
            "longest_step": Key("longest step", NUMBER),
            "frames": Key("number of times at which fields were kept", WHOLE),
            "largest_slip": Key("largest slip of the contact at the end", NUMBER),
            "largest_slip_rate": Key("largest slip rate of the contact at any time", NUMBER),
            "slipping": Key("share of the contact that slips at the end", NUMBER),
            "largest_gap": Key("largest gap of the contact at the times that were kept", NUMBER),
            "error_estimates": Key(
                "relative L1 errors of slip, slip rate and the change of shear traction, and of "
                "gap and pressure where loads change the pressure; empty without a second run",
                _of(NUMBER),
            ),
            "caution": Key("what limits the accuracy and can be changed; often empty", TEXT),
            "comparison": Key(
                "with --compare: verdict, meshes, and the judged quantities",
                _object(
                    verdict=TEXT,
                    counts=_of(WHOLE),
                    meshes=_list(
                        _object(nodes=WHOLE, steps=WHOLE, unknowns=WHOLE, imbalance=NUMBER)
                    ),
                    rows=_list(_row(Row, verdict=TEXT)),
                ),
                always=False,
            ),
        },
    ),
    "simulate": (
        {
            "scene": _SCENE_KEY,
            "lower_material": Key("material of the lower body, if different", _or_null(_MATERIAL)),
            "finite_elements": Key("settings and cost of the simulation", _RUN),
            "own_bars": Key(
                "error bars from coarser meshes",
                _list(_object(name=TEXT, bar=NUMBER, unit=TEXT)),
            ),
        },
    ),
    "field": (
        {"scene": _SCENE_KEY, **_FIELD},
        {"pair": Key("two different bodies, as their TOML file has them", _PAIR), **_FIELD},
    ),
    "validate": (
        {
            "format": Key("format of report.json, which has the same contents", TEXT),
            "slipfront": Key("version of slipfront", TEXT),
            "source": Key("source of each file", _list(TEXT)),
            "scene": _LABEL,
            "verdict": Key("agrees, agrees after conversion, differs or unresolved", TEXT),
            "counts": _COUNTS,
            "reading": Key(
                "how the numbers of the file were read: what was inferred, the options that state "
                "it, factors and offsets, and the largest error that is left, and as given",
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
            "notes": Key("units and conventions that were given, and corrections", _list(TEXT)),
            "parameters": _PARAMETERS,
            "method": _METHOD,
            "end_time": Key("end time T", NUMBER),
            "spacing": Key("grid spacing of the finest run", NUMBER),
            "ratio": Key("ratio of the spacings of two grids", NUMBER),
            "slip_rate_is": Key("time or time span to which the slip rate refers", TEXT),
            "noise": Key("standard deviation of the samples, by quantity", _of(NUMBER)),
            "rows": Key("judged quantities", _list(_row(JudgedRow, verdict=TEXT))),
            "norms": Key("error norms at each station and over all", _list(_row(Norm))),
        },
    ),
    "scenes": (
        {
            "scenes": Key(
                "all named scenes",
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
                "laws, histories and figures from other packages",
                _list(_object(name=TEXT, what=TEXT, package=TEXT, problem=TEXT)),
            ),
        },
    ),
    "init": ({"scene": _SCENE_KEY, "text": Key("text of the TOML file", TEXT)},),
    "docs": (
        {"pages": Key("titles of the installed pages, by name", _of(TEXT))},
        {"page": Key("name of the page", TEXT), "text": Key("the page, in Markdown", TEXT)},
    ),
    "benchmark": (
        {"sheets": Key("all problem sheets", _list(_row(Sheet, marched=TRUTH, scene=_PROBLEM)))},
    ),
    "benchmark show": (
        {
            "sheet": Key("name of the sheet", TEXT),
            "title": Key("title of the sheet", TEXT),
            "system": Key("system of units", TEXT),
            "scene": Key("the scene or whole line, or the file of the interface", _PROBLEM),
            "si_scene": Key("the same scene in SI units; null for interfaces", _or_null(_PROBLEM)),
            "si_scales": Key("factors that convert answers to SI units", _of(NUMBER)),
            "stations": Key("positions of the stations; of scenes over c_t T", _list(NUMBER)),
            "times": Key("times; of scenes over T", _list(NUMBER)),
            "arrival": Key("event whose arrival time is asked for", TEXT),
            "sure": Key("how many digits are reliable, in words", TEXT),
            "answers": Key("answers by quantity", {"type": "object"}),
            "errors": Key("errors of marched answers, of interfaces relative", {"type": "object"}),
            "tolerances": Key("tolerances by class", _list(_row(Tolerance))),
        },
    ),
    "benchmark export": ({"sheets": Key("names of the sheets", _list(TEXT))},),
    "benchmark score": ({"scores": Key("scores of each run and quantity", _list(_row(Score)))},),
    "benchmark enter": (
        {
            "sheet": Key("name of the sheet", TEXT),
            "code": Key("code that was run", TEXT),
            "cells": Key("number of cells over c_t T", NUMBER),
            "stations": Key("stations recorded", _list(NUMBER)),
            "seconds": Key("time taken in seconds", NUMBER),
        },
    ),
    "regimes": (
        {
            "regimes": Key("number of points of each map in each regime", _of(_of(WHOLE))),
            "boundaries": Key("curves between the regimes", _list(_row(BoundaryPoint))),
        },
        {
            "thresholds": Key(
                "with --dissimilar: friction above which waves grow", _list(_row(ThresholdPoint))
            ),
            "named": Key("growth per wavelength of pairs of solids", _list(_row(NamedPoint))),
            "transitions": Key(
                "with --supershear: where ruptures overtake shear waves",
                _list(_row(TransitionPoint)),
            ),
        },
    ),
    "sliding": (
        {
            "upper": Key("upper body", _MATERIAL),
            "lower": Key("lower body", _MATERIAL),
            "friction": Key("friction coefficient", NUMBER),
            "well_posed": Key("whether no wave grows", TRUTH),
            "verdict": Key("whether waves grow, and what would end that, in a sentence", TEXT),
            "threshold_with": Key("friction above which waves grow with the upper body", NUMBER),
            "threshold_against": Key("the same for waves against it", NUMBER),
            "waves": Key("waves that grow at this friction", _list(_row(SlidingWave))),
            "delayed_growth": Key("largest growth rate times t* under a delay t*", NUMBER),
            "generalised_rayleigh_speed": Key("null without such a wave", NUMBER),
            "stoneley_speed": Key("null without such a wave", NUMBER),
            "dundurs": Key("Dundurs' parameter beta", NUMBER),
        },
    ),
    "stability": (
        {
            "studies": Key(
                "tables of each study, as in its files", _of(_of(_list({"type": "object"})))
            )
        },
    ),
    "article": (
        {
            "claims": _CLAIMS,
            "disagreement": Key("mean difference between solver and simulation", NUMBER),
        },
    ),
    "chart": (
        {
            "points": Key("points measured, as in data/chart.csv", _list(_row(Point))),
            "slopes": Key("slope of error against time, by scene and method", _of(_of(NUMBER))),
        },
    ),
    "wear": (
        {
            "rows": Key("results of each transient", _list(_row(WearRow))),
            "most": Key("friction at which the frictional work is largest", _list(_row(MostRow))),
        },
    ),
    "evidence": (
        {
            "verdict": _VERDICT,
            "counts": _COUNTS,
            "scenes": Key(
                "results of all methods for each scene",
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
            "closed_forms": Key(
                "errors of all methods against closed forms", _list(_row(ClosedForm))
            ),
            "claims": _CLAIMS,
            "stamp": Key("versions, machine and date", _of({"type": ["string", "number"]})),
            "seconds": Key("time taken in seconds", NUMBER),
        },
    ),
}
"""Keys that each command adds to the `ENVELOPE`; solve has three forms."""


def schema() -> dict[str, Any]:
    """Return the schema of all documents."""
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
    """Return all keys, beginning with those that all commands share."""
    rows = [KeyRow("all", key, one.meaning) for key, one in ENVELOPE.items()]
    for name, ways in DOCUMENTS.items():
        merged = {key: one for keys in ways for key, one in keys.items()}
        rows += [KeyRow(name, key, one.meaning) for key, one in merged.items()]
    return rows


def schema_text() -> str:
    """Return the text of docs/schema.json."""
    return json.dumps(schema(), indent=1, ensure_ascii=False) + "\n"


def write(docs: Path = DOCS) -> None:
    """Write schema and table; raise DataFileError if that fails."""
    write_text(docs / "schema.json", schema_text())
    write_rows(docs / "data" / "json-keys.csv", key_rows(), command=COMMAND)


def main(arguments: Sequence[str] | None = None) -> int:
    """Write the schema, or check whether it is up to date; return 1 if it is not."""
    parser = argparse.ArgumentParser(prog="python -m docs.studies.schema", description=__doc__)
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
