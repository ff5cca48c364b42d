"""Keys that each command prints with ``--json``, their meanings, and the schema of their values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from compare.benchmarks.classes import Tolerance
from compare.benchmarks.scores import Score
from compare.benchmarks.sheet import Sheet
from compare.comparison.fields.errors import FieldError
from compare.comparison.rows import Row
from compare.studies.article.claims import Verdict
from compare.studies.chart.study import Point
from compare.studies.dissimilar.points import NamedPoint, ThresholdPoint
from compare.studies.evidence.study import ClosedForm
from compare.studies.regimes.points import BoundaryPoint
from compare.studies.supershear.points import TransitionPoint
from compare.studies.wear import MostRow, WearRow
from compare.validation.bars import JudgedRow
from compare.validation.norms import Norm
from docs.studies.schema.vocabulary import (
    NUMBER,
    SCENE,
    TEXT,
    TRUTH,
    UNITS,
    WHOLE,
    Key,
    Schema,
    list_of,
    named,
    object_of,
    or_null,
    row_of,
)
from semianalytic import SlidingWave
from semianalytic.results.answer import ARRIVALS, FIELDS

_MATERIAL = object_of(shear_modulus=NUMBER, density=NUMBER, poisson_ratio=NUMBER)
_TRACTIONS = object_of(pressure=NUMBER, shear=NUMBER)
_KIND: Schema = {"type": "object", "properties": {"kind": TEXT}, "required": ["kind"]}
_OPTIONAL = ("pressure_history", "shear_history", "friction_law", "mode", "load_on", "units")
DEFINITIONS: Schema = {
    "scene": object_of(
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
    "units": named({"anyOf": [TEXT, UNITS]}),
}
ENVELOPE: Mapping[str, Key] = {
    "command": Key("the command, as typed after slipfront", TEXT),
    "version": Key("version of slipfront", TEXT),
    "status": Key("done; converged, resolved or the reason why not; or the verdict", TEXT),
    "units": Key("units of all numbers, under the same names; one for a whole list", UNITS),
    "files": Key("files written", list_of(TEXT)),
}
_LINE = object_of(
    ("mode", "units"),
    contact=TEXT,
    friction=NUMBER,
    material=_MATERIAL,
    base=_TRACTIONS,
    load=_KIND,
    mode=TEXT,
    units=TEXT,
)
_PAIR = object_of(
    ("friction_law", "units"),
    friction=NUMBER,
    material=_MATERIAL,
    lower_material=_MATERIAL,
    base=_TRACTIONS,
    load=_TRACTIONS,
    friction_law=_KIND,
    units=TEXT,
)
_SCENES: Schema = {"anyOf": [SCENE, _PAIR]}
_PROBLEM: Schema = {"anyOf": [SCENE, _LINE, _PAIR, object_of(interface=TEXT)]}
_SCENE_KEY = Key("the scene, as its TOML file has it", SCENE)
_INTERFACE = object_of(
    interface={"type": "object"}, end_time=or_null(NUMBER), options={"type": "object"}
)
_SUBJECT: Schema = {"anyOf": [SCENE, _INTERFACE]}
_COUNTS = Key("rows by verdict", named(WHOLE))
_VERDICT = Key("agrees, differs or unresolved", TEXT)
_LABEL = Key("name of the scene", TEXT)
_PARAMETERS = Key("the scene itself", SCENE)
_ESTIMATE = Key("relative error estimate of the answer", NUMBER)
_METHOD = Key("self-similar or space-time", TEXT)
_RUN = object_of(
    run=TEXT,
    end_time=NUMBER,
    resolution=NUMBER,
    companions=list_of(NUMBER),
    element_size=NUMBER,
    model=TEXT,
    damping=NUMBER,
    time_step=NUMBER,
    critical_step=NUMBER,
    steps=WHOLE,
    unknowns=WHOLE,
    caution=TEXT,
    opened=or_null({"type": "object"}),
    seconds=named(NUMBER),
)
_CLAIMS = Key(
    "claims of the article, with the verdict of each method",
    list_of(object_of(section=TEXT, claim=TEXT, base=TEXT, verdicts=named(row_of(Verdict)))),
)
_PART = object_of(inner=NUMBER, outer=NUMBER, sense=WHOLE)
_MEASURED = object_of(value=NUMBER, error=NUMBER)
_POINT = object_of(
    ("t", *FIELDS),
    x=NUMBER,
    t=NUMBER,
    arrivals=object_of(**{name: _MEASURED for name in ARRIVALS}),
    **{name: _MEASURED for name in FIELDS},
)
_POINTS = Key(
    "arrivals and fields at --x and --t, if given, each a value and the bar of its error",
    list_of(_POINT),
    False,
)
_ZONE = object_of(inner=NUMBER, outer=NUMBER, sense=WHOLE, inner_regime=TEXT, outer_regime=TEXT)

_FIELD = {
    "method": _METHOD,
    "error_estimate": _ESTIMATE,
    "of": Key("quantity drawn", TEXT),
    "time": Key("time of the picture", NUMBER),
    "window": Key("region shown", object_of(x0=NUMBER, x1=NUMBER, y0=NUMBER, y1=NUMBER)),
    "frames": Key("number of frames of the animation", WHOLE),
    "gauges": Key(
        "gauges recorded, in the order of the files", list_of(object_of(x=NUMBER, y=NUMBER))
    ),
}
"""Keys of ``slipfront field`` for bodies alike and different."""

DOCUMENTS: Mapping[str, Sequence[Mapping[str, Key]]] = {
    "solve": (
        {
            "scene": _SCENE_KEY,
            "wave_speeds": Key("speeds of the waves that occur in the fields", named(NUMBER)),
            "zones": Key("velocities of the edges of slip zones", list_of(_ZONE)),
            "openings": Key(
                "velocities of the edges of openings",
                list_of(object_of(inner=NUMBER, outer=NUMBER)),
            ),
            "edge": Key(
                "state of the interface at x = 0+",
                object_of(
                    state=TEXT, slip_rate=NUMBER, stress_intensity_at_unit_time=named(NUMBER)
                ),
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
                "times at which slip starts at some x", list_of(object_of(x=NUMBER, time=NUMBER))
            ),
            "accumulated_slip": Key("accumulated slip, integral over the contact", NUMBER),
            "frictional_work": Key("frictional work, integral over the contact", NUMBER),
            "stress_intensity_of_a_stuck_edge": Key(
                "stress intensity factors of a stuck edge at T", named(NUMBER)
            ),
            "stored_levels": Key("number of stored time levels of the history", WHOLE),
            "statistics": Key("cost of the computation", {"type": "object"}),
            "points": _POINTS,
        },
        {
            "line": Key("whole line or growing load, as its TOML file has it", {"type": "object"}),
            "wave_speeds": Key("speeds of the waves that occur in the fields", named(NUMBER)),
            "edge_speed": Key("speed of the edges of slip or opening of a line", NUMBER),
            "edge_amplitude": Key("rate over sqrt(1 - x/(edge speed t)) beside an edge", NUMBER),
            "zones": Key("velocities of the edges of slip zones", list_of(_PART)),
            "openings": Key(
                "velocities of the edges of openings",
                list_of(object_of(inner=NUMBER, outer=NUMBER)),
            ),
            "error_estimate": _ESTIMATE,
            "until_end_time": Key(
                "zones, slip and work until --end-time, if given", {"type": "object"}, False
            ),
        },
        {
            "pair": Key("two different bodies, as their TOML file has them", _PAIR),
            "wave_speeds": Key("speeds of the waves of both bodies", named(named(NUMBER))),
            "zones": Key("velocities of the edges of slip zones", list_of(_PART)),
            "openings": Key(
                "velocities of the edges of openings",
                list_of(object_of(inner=NUMBER, outer=NUMBER)),
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
                named(object_of(value=NUMBER, standard_error=NUMBER)),
            ),
            "covariance": Key(
                "covariance of the parameters, in their order", list_of(list_of(NUMBER))
            ),
            "correlation": Key(
                "correlation of the parameters, in their order", list_of(list_of(NUMBER))
            ),
            "chi2": Key("sum of squares of the misfits over the noise", NUMBER),
            "freedom": Key("degrees of freedom: samples minus parameters", WHOLE),
            "unconstrained": Key("parameters that the data leave free", list_of(TEXT)),
            "known_by_prior": Key("parameters known by their prior alone", list_of(TEXT)),
            "minima": Key(
                "all minima found", list_of(object_of(values=list_of(NUMBER), chi2=NUMBER))
            ),
            "gauges": Key(
                "records, each with its contribution to chi2",
                list_of(
                    object_of(
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
            "scene": Key("the scene or both bodies, as their TOML file has them", _SCENES),
            "address": Key("address of the page, served until the command ends", TEXT),
        },
    ),
    "survey": (
        {
            "file": Key("file that contains all results", TEXT),
            "points": Key("number of scenes requested", WHOLE),
            "dimensions": Key("lengths of the dimensions", named(WHOLE)),
            "parameters": Key(
                "varied parameters and their ranges",
                named(object_of(least=NUMBER, largest=NUMBER, count=WHOLE)),
            ),
            "statuses": Key("number of scenes with each status", named(WHOLE)),
            "methods": Key("number of scenes solved by each method", named(WHOLE)),
            "largest_error_estimate": Key("largest error estimate of all scenes", NUMBER),
            "seconds": Key("processor time in seconds", NUMBER),
            "variables": Key(
                "variables in the file; their units are in units.variables", list_of(TEXT)
            ),
        },
    ),
    "compare": (
        {
            "scene": _LABEL,
            "verdict": _VERDICT,
            "counts": _COUNTS,
            "parameters": Key("the scene itself, or both bodies", _SCENES),
            "method": _METHOD,
            "caution": Key("reason why the prediction is unresolved", TEXT),
            "semianalytic": Key(
                "result as printed by solve; null for a march", or_null({"type": "object"})
            ),
            "finite_elements": Key("settings and cost of the simulation", _RUN),
            "rows": Key(
                "judged quantities", list_of(row_of(Row, verdict=TEXT, remedy=or_null(TEXT)))
            ),
            "fields": Key(
                "errors of snapshots",
                or_null(object_of(band=NUMBER, frames=list_of(row_of(FieldError)))),
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
                named(NUMBER),
            ),
            "caution": Key("what limits the accuracy and can be changed; often empty", TEXT),
            "comparison": Key(
                "with --compare: verdict, meshes, and the judged quantities",
                object_of(
                    verdict=TEXT,
                    counts=named(WHOLE),
                    meshes=list_of(
                        object_of(nodes=WHOLE, steps=WHOLE, unknowns=WHOLE, imbalance=NUMBER)
                    ),
                    rows=list_of(row_of(Row, verdict=TEXT)),
                ),
                always=False,
            ),
        },
    ),
    "simulate": (
        {
            "scene": _SCENE_KEY,
            "lower_material": Key("material of the lower body, if different", or_null(_MATERIAL)),
            "finite_elements": Key("settings and cost of the simulation", _RUN),
            "own_bars": Key(
                "error bars from coarser meshes",
                list_of(object_of(name=TEXT, bar=NUMBER, unit=TEXT)),
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
            "source": Key("source of each file", list_of(TEXT)),
            "scene": _LABEL,
            "verdict": Key("agrees, agrees after conversion, differs or unresolved", TEXT),
            "counts": _COUNTS,
            "reading": Key(
                "how the numbers of the file were read: what was inferred, the options that state "
                "it, factors and offsets, and the largest error that is left, and as given",
                object_of(
                    inferred=list_of(TEXT),
                    stated_by=list_of(list_of(TEXT)),
                    factors=named(NUMBER),
                    offsets=named(NUMBER),
                    left=NUMBER,
                    as_given=NUMBER,
                    runner_up=TEXT,
                ),
            ),
            "notes": Key("units and conventions that were given, and corrections", list_of(TEXT)),
            "parameters": _PARAMETERS,
            "method": _METHOD,
            "end_time": Key("end time T", NUMBER),
            "spacing": Key("grid spacing of the finest run", NUMBER),
            "ratio": Key("ratio of the spacings of two grids", NUMBER),
            "slip_rate_is": Key("time or time span to which the slip rate refers", TEXT),
            "noise": Key("standard deviation of the samples, by quantity", named(NUMBER)),
            "rows": Key("judged quantities", list_of(row_of(JudgedRow, verdict=TEXT))),
            "norms": Key("error norms at each station and over all", list_of(row_of(Norm))),
        },
    ),
    "scenes": (
        {
            "scenes": Key(
                "all named scenes",
                list_of(
                    object_of(
                        name=TEXT,
                        what=TEXT,
                        package=or_null(TEXT),
                        problem=TEXT,
                        summary=TEXT,
                        scene=or_null(_SCENES),
                    )
                ),
            ),
            "brought": Key(
                "laws, histories and figures from other packages",
                list_of(object_of(name=TEXT, what=TEXT, package=TEXT, problem=TEXT)),
            ),
        },
    ),
    "init": (
        {
            "scene": Key("the scene, as its TOML file has it", _SCENES),
            "text": Key("text of the TOML file", TEXT),
        },
    ),
    "docs": (
        {"pages": Key("titles of the installed pages, by name", named(TEXT))},
        {"page": Key("name of the page", TEXT), "text": Key("the page, in Markdown", TEXT)},
    ),
    "benchmark": (
        {
            "sheets": Key(
                "all problem sheets", list_of(row_of(Sheet, marched=TRUTH, scene=_PROBLEM))
            )
        },
    ),
    "benchmark show": (
        {
            "sheet": Key("name of the sheet", TEXT),
            "title": Key("title of the sheet", TEXT),
            "system": Key("system of units", TEXT),
            "scene": Key("the scene, pair or whole line, or the file of the interface", _PROBLEM),
            "si_scene": Key("the same scene in SI units; null for interfaces", or_null(_PROBLEM)),
            "si_scales": Key("factors that convert answers to SI units", named(NUMBER)),
            "stations": Key("positions of the stations; of scenes over c_t T", list_of(NUMBER)),
            "times": Key("times; of scenes over T", list_of(NUMBER)),
            "arrival": Key("event whose arrival time is asked for", TEXT),
            "sure": Key("how many digits are reliable, in words", TEXT),
            "answers": Key("answers by quantity", {"type": "object"}),
            "errors": Key("errors of marched answers, of interfaces relative", {"type": "object"}),
            "tolerances": Key("tolerances by class", list_of(row_of(Tolerance))),
        },
    ),
    "benchmark export": ({"sheets": Key("names of the sheets", list_of(TEXT))},),
    "benchmark score": (
        {"scores": Key("scores of each run and quantity", list_of(row_of(Score)))},
    ),
    "benchmark enter": (
        {
            "sheet": Key("name of the sheet", TEXT),
            "code": Key("code that was run", TEXT),
            "cells": Key("number of cells over c_t T", NUMBER),
            "stations": Key("stations recorded", list_of(NUMBER)),
            "seconds": Key("time taken in seconds", NUMBER),
        },
    ),
    "regimes": (
        {
            "regimes": Key("number of points of each map in each regime", named(named(WHOLE))),
            "boundaries": Key("curves between the regimes", list_of(row_of(BoundaryPoint))),
        },
        {
            "thresholds": Key(
                "with --dissimilar: friction above which waves grow",
                list_of(row_of(ThresholdPoint)),
            ),
            "named": Key("growth per wavelength of pairs of solids", list_of(row_of(NamedPoint))),
            "transitions": Key(
                "with --supershear: where ruptures overtake shear waves",
                list_of(row_of(TransitionPoint)),
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
            "waves": Key("waves that grow at this friction", list_of(row_of(SlidingWave))),
            "delayed_growth": Key("largest growth rate times t* under a delay t*", NUMBER),
            "generalised_rayleigh_speed": Key("null without such a wave", NUMBER),
            "stoneley_speed": Key("null without such a wave", NUMBER),
            "dundurs": Key("Dundurs' parameter beta", NUMBER),
        },
    ),
    "stability": (
        {
            "studies": Key(
                "tables of each study, as in its files", named(named(list_of({"type": "object"})))
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
            "points": Key("points measured, as in data/chart.csv", list_of(row_of(Point))),
            "slopes": Key("slope of error against time, by scene and method", named(named(NUMBER))),
        },
    ),
    "wear": (
        {
            "rows": Key("results of each transient", list_of(row_of(WearRow))),
            "most": Key(
                "friction at which the frictional work is largest", list_of(row_of(MostRow))
            ),
        },
    ),
    "evidence": (
        {
            "verdict": _VERDICT,
            "counts": _COUNTS,
            "scenes": Key(
                "results of all methods for each scene",
                list_of(
                    object_of(
                        scene=TEXT,
                        parameters=SCENE,
                        verdict=or_null(TEXT),
                        counts=named(WHOLE),
                        methods=list_of(TEXT),
                        obstacle=TEXT,
                    )
                ),
            ),
            "closed_forms": Key(
                "errors of all methods against closed forms", list_of(row_of(ClosedForm))
            ),
            "claims": _CLAIMS,
            "stamp": Key("versions, machine and date", named({"type": ["string", "number"]})),
            "seconds": Key("time taken in seconds", NUMBER),
        },
    ),
}
"""Keys that each command adds to the `ENVELOPE`; solve has three forms."""
