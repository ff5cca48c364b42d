"""Keys that benchmarks and studies print with ``--json``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from compare.benchmarks.scores import Score
from compare.benchmarks.sheets import Sheet
from compare.chart.figure import Found
from compare.chart.points import Point
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
    row_of,
)
from semianalytic import SlidingWave

_SHEET = row_of(Sheet, scene=PROBLEM)

STUDIES: Mapping[str, Sequence[Mapping[str, Key]]] = {
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
"""Keys that each of these commands adds to the `ENVELOPE`."""
