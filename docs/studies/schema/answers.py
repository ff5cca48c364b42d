"""Keys that commands print with ``--json``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from compare.benchmarks.scores import Score
from compare.benchmarks.sheets import Sheet
from compare.chart.figure import Found
from compare.chart.points import Point
from compare.comparison.fields.errors import FieldError
from compare.comparison.rows import Row
from compare.validation.bars import JudgedRow
from compare.validation.norms import Norm
from docs.studies.schema.vocabulary import (
    ANYTHING,
    COUNTS,
    MATERIAL,
    NUMBER,
    SCENE,
    SPECIMEN,
    TEXT,
    TRUTH,
    VERDICT,
    WHOLE,
    Key,
    list_of,
    named,
    object_of,
    or_null,
    row_of,
    shape,
)
from semianalytic.dissimilar.stability import SlidingWave
from semianalytic.inversion.quoted import QUOTED
from semianalytic.results.answer import ARRIVALS, FIELDS

_SCENE_KEY = Key("the scene, as its TOML file has it", SCENE)
_LABEL = Key("name of the scene", TEXT)
_ESTIMATE = Key("relative error estimate of the answer", NUMBER)
_METHOD = Key("self-similar or space-time", TEXT)
_WAVE_SPEEDS = Key("speeds of the waves that occur in the fields", named(NUMBER))
_STATISTICS = Key("cost of the computation", ANYTHING)
_UNTIL_END_TIME = Key("zones, slip and work until --end-time, if given", ANYTHING, False)
_EDGES = "velocities of the edges of slip zones"
_ZONES = Key(_EDGES, list_of(shape("inner outer", wholes="sense")))
_OPENINGS = Key("velocities of the edges of openings", list_of(shape("inner outer")))
_RUN = shape(
    "end_time resolution element_size damping time_step critical_step",
    "run model caution",
    "steps unknowns",
    companions=list_of(NUMBER),
    opened=or_null(ANYTHING),
    seconds=named(NUMBER),
)
_MEASURED, _MATRIX = shape("value error"), list_of(list_of(NUMBER))
_PROPAGATED = object_of(**dict.fromkeys(("value", "from", "to"), list_of(NUMBER)))
_POINT = object_of(
    ("t", *FIELDS),
    x=NUMBER,
    t=NUMBER,
    arrivals=object_of(**dict.fromkeys(ARRIVALS, _MEASURED)),
    **dict.fromkeys(FIELDS, _MEASURED),
)
_POINTS = Key(
    "arrivals and fields at --x and --t, if given, each a value and the bar of its error",
    list_of(_POINT),
    False,
)
_FIELD = {
    "method": _METHOD,
    "error_estimate": _ESTIMATE,
    "of": Key("quantity drawn", TEXT),
    "time": Key("time of the picture", NUMBER),
    "window": Key("region shown", shape("x0 x1 y0 y1")),
    "frames": Key("number of frames of the animation", WHOLE),
    "gauges": Key("gauges recorded, in the order of the files", list_of(shape("x y"))),
}

_MARCH = {
    "scene": _SCENE_KEY,
    "method": _METHOD,
    "caution": Key("what limits the accuracy and can be changed; often empty", TEXT),
    "error_estimate": _ESTIMATE,
    "error_estimates": Key(
        "relative L1 errors of the slip rate; along a line also of slip and the change of shear "
        "traction, and of gap and pressure where loads change the pressure; empty without a march "
        "on half the nodes",
        named(NUMBER),
    ),
    "end_time": Key("time that was reached", NUMBER),
    "nodes": Key("nodes of one period, or of the observed contact next to a slot", WHOLE),
    "steps": Key("number of steps", WHOLE),
    "shortest_step": Key("shortest step", NUMBER),
    "longest_step": Key("longest step", NUMBER),
    "stored_levels": Key("number of times at which fields were kept", WHOLE),
    "largest_slip_rate": Key("largest slip rate over contact and time", NUMBER),
    "largest_slip": Key("largest slip over contact and time", NUMBER),
    "largest_gap": Key("largest gap of the contact at the times that were kept", NUMBER),
    "slipping": Key("share of the contact that slips at the end", NUMBER),
    "reach_of_slip": Key("largest |x| that slips", NUMBER),
    "reach_of_reverse_slip": Key("largest |x| that slips backward", NUMBER),
    "accumulated_slip": Key("accumulated slip, integral over the contact", NUMBER),
    "frictional_work": Key("frictional work, integral over the contact", NUMBER),
}
"""Keys of a march."""
_SHEET = row_of(Sheet, scene=SCENE)
_JUDGED_ROWS = list_of(row_of(Row, verdict=TEXT, remedy=TEXT))
_QUOTED = Key("differences and error bars of slip, slip rate and edges, on one line", TEXT)

DOCUMENTS: Mapping[str, Sequence[Mapping[str, Key]]] = {
    "solve": (
        {
            "scene": _SCENE_KEY,
            "wave_speeds": _WAVE_SPEEDS,
            "zones": Key(
                _EDGES, list_of(shape("inner outer", "inner_regime outer_regime", "sense"))
            ),
            "openings": _OPENINGS,
            "edge": Key(
                "state of the interface at x = 0+",
                shape("slip_rate", "state", stress_intensity_at_unit_time=named(NUMBER)),
            ),
            "far_slip_rate": Key("slip rate ahead of all waves", NUMBER),
            "error_estimate": _ESTIMATE,
            "statistics": _STATISTICS,
            "until_end_time": _UNTIL_END_TIME,
            "points": _POINTS,
        },
        {
            **_MARCH,
            "method": Key("space-time: a march, which has all keys below", {"const": "space-time"}),
            "onset": Key("times at which slip starts at some x", list_of(shape("x time"))),
            "stress_intensity_of_a_stuck_edge": Key(
                "stress intensity factors of a stuck edge at T", named(NUMBER)
            ),
            "statistics": _STATISTICS,
            "points": _POINTS,
        },
        {
            "scene": Key("whole line or growing load, as its TOML file has it", ANYTHING),
            "wave_speeds": _WAVE_SPEEDS,
            "edge": Key(
                "speed of the edges of slip or opening, and rate over sqrt(1 - x/(speed t)) there",
                shape("speed amplitude"),
            ),
            "zones": _ZONES,
            "openings": _OPENINGS,
            "error_estimate": _ESTIMATE,
            "until_end_time": _UNTIL_END_TIME,
            "points": _POINTS,
        },
        {
            "scene": _SCENE_KEY,
            "wave_speeds": Key("speeds of the waves of both bodies", named(named(NUMBER))),
            "zones": _ZONES,
            "openings": _OPENINGS,
            "edge": Key("state of the interface at x = 0+", shape("slip_rate", "state")),
            "error_estimate": _ESTIMATE,
            "statistics": _STATISTICS,
            "until_end_time": _UNTIL_END_TIME,
            "points": _POINTS,
        },
        {**_MARCH, "points": _POINTS},
    ),
    "fit": (
        {
            "scene": Key("the scene as its TOML file has it", SCENE),
            "parameters": Key(
                "fitted values, standard errors, and the ends between which chi2 is at most one "
                "above its least, by name",
                named(shape("value standard_error from to")),
            ),
            "rupture": Key(
                "front speed, stress drop, fracture energy and S at places x, with the ends of one "
                "standard error",
                object_of(x=list_of(NUMBER), **dict.fromkeys(QUOTED, _PROPAGATED)),
            ),
            "covariance": Key("covariance, in the order of the parameters", _MATRIX),
            "correlation": Key("correlation, in the order of the parameters", _MATRIX),
            "chi2": Key("sum of squares of the misfits over the noise", NUMBER),
            "freedom": Key("degrees of freedom: samples minus parameters", WHOLE),
            "unconstrained": Key("parameters that the data leave free", list_of(TEXT)),
            "known_by_prior": Key("parameters known by their prior alone", list_of(TEXT)),
            "minima": Key("all minima found", list_of(shape("chi2", values=list_of(NUMBER)))),
            "gauges": Key(
                "records, each with its contribution to chi2",
                list_of(shape("x y chi2", "name quantity", "samples")),
            ),
            "derivative_error": Key("relative error of the derivatives", NUMBER),
            "solutions": Key("number of solutions computed", WHOLE),
            "misfit": Key("a sentence that compares the misfits with the noise", TEXT),
            "notes": Key("what was made of the records, and left out", list_of(TEXT)),
            "unread": Key("columns of the files that are not read", list_of(TEXT)),
        },
    ),
    "explore": (
        {
            "scene": Key("the scene or both bodies, as their TOML file has them", SCENE),
            "address": Key("address of the page, served until the command ends", TEXT),
        },
    ),
    "survey": (
        {
            "file": Key("file that contains all results", TEXT),
            "points": Key("number of scenes requested", WHOLE),
            "dimensions": Key("lengths of the dimensions", named(WHOLE)),
            "parameters": Key(
                "varied parameters and their ranges", named(shape("least largest", wholes="count"))
            ),
            "statuses": Key("number of scenes with each status", named(WHOLE)),
            "methods": Key("number of scenes solved by each method", named(WHOLE)),
            "largest_error_estimate": Key("largest error estimate of all scenes", NUMBER),
            "seconds": Key("processor time in seconds", NUMBER),
            "variables": Key("variables; their units are in units.variables", list_of(TEXT)),
        },
    ),
    "compare": (
        {
            "scene": _LABEL,
            "verdict": VERDICT,
            "counts": COUNTS,
            "quoted": _QUOTED,
            "parameters": Key("the scene itself, or both bodies", SCENE),
            "method": _METHOD,
            "caution": Key("reason why the prediction is unresolved", TEXT),
            "semianalytic": Key("result of solve; null for a march", or_null(ANYTHING)),
            "finite_elements": Key("settings and cost of the simulation", _RUN),
            "rows": Key("judged quantities", _JUDGED_ROWS),
            "fields": Key(
                "errors of snapshots", or_null(shape("band", frames=list_of(row_of(FieldError))))
            ),
        },
        _MARCH
        | {
            "comparison": Key(
                "verdict, meshes, and the judged quantities",
                shape(
                    texts="verdict quoted caution",
                    counts=named(WHOLE),
                    until=NUMBER,
                    meshes=list_of(shape("imbalance", wholes="nodes steps unknowns")),
                    rows=_JUDGED_ROWS,
                ),
            )
        },
    ),
    "simulate": (
        {
            "scene": _SCENE_KEY,
            "finite_elements": Key("settings and cost of the simulation", _RUN),
            "own_bars": Key("error bars from coarser meshes", list_of(shape("bar", "name unit"))),
        },
        {
            "scene": Key("the specimen, as its TOML file has it", SPECIMEN),
            "finite_elements": Key(
                "settings and cost of the simulation",
                shape("end_time element_size time_step imbalance seconds", wholes="steps unknowns"),
            ),
            **{
                f"largest_{name}": Key(f"largest {name.replace('_', ' ')} of the contact", NUMBER)
                for name in ("slip", "slip_rate", "gap")
            },
        },
    ),
    "field": (
        {"scene": Key("the scene or both bodies, as their TOML file has them", SCENE)} | _FIELD,
    ),
    "validate": (
        {
            "format": Key("format of report.json, which has the same contents", TEXT),
            "slipfront": Key("version of slipfront", TEXT),
            "source": Key("source of each file", list_of(TEXT)),
            "scene": _LABEL,
            "verdict": Key("agrees, agrees after conversion, differs or unresolved", TEXT),
            "counts": COUNTS,
            "reading": Key(
                "how the numbers of the file were read: what was inferred, the options that state "
                "it, factors, what is added to times, tractions that the base is added to, and "
                "the largest error that is left, and as given",
                shape(
                    "left as_given time_shift",
                    inferred=list_of(TEXT),
                    stated_by=list_of(list_of(TEXT)),
                    factors=named(NUMBER),
                    with_base=list_of(TEXT),
                ),
            ),
            "notes": Key("units and conventions that were given, and corrections", list_of(TEXT)),
            "unread": Key("columns of the files that are not read", list_of(TEXT)),
            "not_compared": Key("quantities that the files do not hold", list_of(TEXT)),
            "parameters": Key("the scene itself", SCENE),
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
                    shape(
                        texts="name what problem summary",
                        package=or_null(TEXT),
                        scene=or_null({"anyOf": [SCENE, SPECIMEN]}),
                    )
                ),
            ),
            "brought": Key(
                "laws, histories, figures and methods from other packages",
                list_of(shape(texts="name what package problem")),
            ),
        },
    ),
    "init": (
        {
            "scene": Key(
                "the scene, as its TOML file has it", or_null({"anyOf": [SCENE, SPECIMEN]})
            ),
            "text": Key("text of the TOML file", TEXT),
        },
    ),
    "docs": (
        {"pages": Key("titles of the installed pages, by name", named(TEXT))},
        {"page": Key("name of the page", TEXT), "text": Key("the page, in Markdown", TEXT)},
    ),
    "benchmark": ({"sheets": Key("all problem sheets", list_of(_SHEET))},),
    "benchmark show": (
        {
            "sheet": Key("the sheet; its scene is that, or the file of the interface", _SHEET),
            "times": Key("times; of scenes over T", list_of(NUMBER)),
            "answers": Key("answers by quantity", {"type": "object"}),
            "errors": Key("stated relative errors of marched answers", named(NUMBER)),
        },
    ),
    "benchmark export": ({"sheets": Key("names of the sheets", list_of(TEXT))},),
    "benchmark score": (
        {"scores": Key("scores of each run and quantity", list_of(row_of(Score)))},
    ),
    "sliding": (
        {
            "upper": Key("upper body", MATERIAL),
            "lower": Key("lower body", MATERIAL),
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
    "chart": (
        {
            "points": Key("points measured, as in data/chart.csv", list_of(row_of(Point))),
            "found": Key("what they say, as in data/chart-found.csv", list_of(row_of(Found))),
        },
    ),
}
"""Keys that each command adds to the `ENVELOPE` in each of its forms; solve has four."""
