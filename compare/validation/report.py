"""A validation as JSON."""

from __future__ import annotations

from dataclasses import asdict
from importlib.metadata import version
from typing import Any

from compare.comparison.documents import SCENE_DIMENSIONS, row_units, units_document
from compare.validation.validation import Validation
from semianalytic.results.answer import method_of
from semianalytic.scene.given.documents import scene_document

FORMAT = "slipfront validation 1"


def validation_document(validation: Validation, label: str) -> dict[str, Any]:
    """A validation as plain dictionaries, lists, strings and numbers, for `json_text`.

    `label` names the scene.  Values of rows and norms are in what units/rows says; spacing and T
    are in units of the scene.
    """
    scene, exact, grids = validation.scene, validation.exact, validation.grids
    detection = validation.detection
    document: dict[str, Any] = {
        "format": FORMAT,
        "slipfront": version("slipfront"),
        "source": [run.source for run in grids.runs],
        "scene": label,
        "verdict": validation.verdict,
        "counts": validation.counts,
        "reading": {
            "inferred": list(detection.inferred),
            "stated_by": [list(pair) for pair in detection.stating.items()],
            "factors": dict(detection.reading.factors),
            "time_shift": detection.reading.shift,
            "with_base": list(detection.reading.bases),
            "left": detection.left,
            "as_given": detection.as_given,
        },
        "notes": list(validation.notes),
        "unread": list(validation.unread),
        "not_compared": list(validation.not_compared),
        "parameters": scene_document(scene),
        "method": method_of(exact.answer),
        "end_time": exact.end_time,
        "spacing": grids.spacing,
        "ratio": grids.ratio if len(grids.runs) > 1 else None,
        "slip_rate_is": grids.sampling.kind,
        "noise": dict(grids.noise),
        "rows": [{**asdict(row), "verdict": row.verdict} for row in validation.rows],
        "norms": [asdict(norm) for norm in validation.norms],
    }
    dimensions = {"parameters": SCENE_DIMENSIONS, "end_time": "time", "spacing": "length"}
    document["units"] = units_document(document, dimensions, scene)
    document["units"]["rows"] = row_units(scene, exact.end_time)
    return document
