"""Answers of two different bodies with a slot as plain dictionaries, with units, for JSON."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from compare.comparison.documents import (
    END_DIMENSIONS,
    SCENE_DIMENSIONS,
    SOLUTION_DIMENSIONS,
    WAVES,
    motion_document,
)
from compare.comparison.documents import units_document as units_of
from compare.comparison.scales import wave_speeds
from semianalytic import PairSolution
from semianalytic.dissimilar.described import pair_document

_DIMENSIONS = {
    **SOLUTION_DIMENSIONS,
    "pair": SCENE_DIMENSIONS,
    "wave_speeds": {
        body: dict.fromkeys(("rayleigh", "shear", "longitudinal"), "length / time")
        for body in ("upper", "lower")
    },
    "openings": {"inner": "length / time", "outer": "length / time"},
    "edge_slip_rate": "length / time",
}


def pair_answer_document(answer: PairSolution, end_time: float | None = None) -> dict[str, Any]:
    """An answer as plain dictionaries, lists, strings and numbers, with their units.

    With an end time [time], the document includes zones, slip and work until then.
    """
    pair = answer.pair
    document: dict[str, Any] = {
        "pair": pair_document(pair),
        "wave_speeds": {
            name: {WAVES[wave]: speed for wave, speed in wave_speeds(body).items()}
            for name, body in (("upper", pair.upper), ("lower", pair.lower))
        },
        "zones": [asdict(zone) for zone in answer.zones],
        "openings": [asdict(part) for part in answer.openings],
        "edge_slip_rate": answer.edge_slip_rate,
        "status": answer.status,
        "error_estimate": answer.error_estimate,
        "statistics": asdict(answer.statistics),
    }
    if end_time is not None:
        document["until_end_time"] = motion_document(answer, end_time)
    dimensions = {**_DIMENSIONS, "until_end_time": END_DIMENSIONS}
    document["units"] = units_of(document, dimensions, pair)
    return document
