"""Keys that benchmarks and studies print with ``--json``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from compare.benchmarks.classes import Tolerance
from compare.benchmarks.scores import Score
from compare.benchmarks.sheet import Sheet
from compare.studies.chart.points import Point
from docs.studies.schema.parts import (
    MATERIAL,
    PROBLEM,
)
from docs.studies.schema.vocabulary import (
    NUMBER,
    TEXT,
    TRUTH,
    Key,
    list_of,
    named,
    or_null,
    row_of,
)
from semianalytic import SlidingWave

STUDIES: Mapping[str, Sequence[Mapping[str, Key]]] = {
    "benchmark": (
        {"sheets": Key("all problem sheets", list_of(row_of(Sheet, marched=TRUTH, scene=PROBLEM)))},
    ),
    "benchmark show": (
        {
            "sheet": Key("name of the sheet", TEXT),
            "title": Key("title of the sheet", TEXT),
            "system": Key("system of units", TEXT),
            "scene": Key("the scene, pair or whole line, or the file of the interface", PROBLEM),
            "si_scene": Key("the same scene in SI units; null for interfaces", or_null(PROBLEM)),
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
            "slopes": Key("slope of error against time, by scene and method", named(named(NUMBER))),
        },
    ),
}
"""Keys that each of these commands adds to the `ENVELOPE`."""
