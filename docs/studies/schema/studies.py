"""Keys that benchmarks and studies print with ``--json``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from compare.benchmarks.scores import Score
from compare.benchmarks.sheets import Sheet
from compare.chart.figure import Found
from compare.chart.points import Point
from compare.studies.article.claims import Verdict
from compare.studies.dissimilar.points import NamedPoint, ThresholdPoint
from compare.studies.regimes.points import BoundaryPoint
from compare.studies.supershear.points import TransitionPoint
from docs.studies.schema.parts import (
    MATERIAL,
    PROBLEM,
)
from docs.studies.schema.vocabulary import (
    NUMBER,
    TEXT,
    TRUTH,
    WHOLE,
    Key,
    list_of,
    named,
    object_of,
    row_of,
)
from semianalytic import SlidingWave

_CLAIMS = Key(
    "claims of the article, with the verdict of each method",
    list_of(object_of(section=TEXT, claim=TEXT, base=TEXT, verdicts=named(row_of(Verdict)))),
)
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
            "found": Key("what they say, as in data/chart-found.csv", list_of(row_of(Found))),
        },
    ),
}
"""Keys that each of these commands adds to the `ENVELOPE`."""
