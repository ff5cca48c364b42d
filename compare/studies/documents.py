"""Results of the chart as a plain dictionary with units, for JSON."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from compare.studies.chart.points import Point

_ERRORS = ("error", "edge_error", "reference_error", "reference_edge_error")


def chart_document(points: Sequence[Point]) -> dict[str, Any]:
    """Return all points, and the power of time by which errors fall, by scene and method."""
    from compare.studies.chart.figure import slopes

    return {
        "points": [asdict(point) for point in points],
        "slopes": slopes(points),
        "units": {
            "points": {"setup": "s", "solving": "s", "memory": "MB", **dict.fromkeys(_ERRORS, "1")},
            "slopes": "1",
        },
    }
