"""The variables of a survey: dimension, meaning, and dimensions other than those of the points."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from semianalytic.results.datasets import QUANTITIES as FIELD_QUANTITIES

TEXT = "text"
"""Kind of variables that hold text; packed chunks store it as codes with a table."""


@dataclass(frozen=True)
class SurveyVariable:
    """A variable of a survey."""

    dimension: str  # physical dimension, such as "length / time"
    meaning: str
    along: tuple[str, ...] = ()  # array dimensions in addition to those of the points
    kind: str = "f8"  # "f8", "i1" or `TEXT`

    @property
    def absent(self) -> Any:
        """Value that stands where a point has none."""
        return {"f8": np.nan, "i1": 0, TEXT: ""}[self.kind]


QUANTITIES: Mapping[str, SurveyVariable] = {
    "edges": SurveyVariable(
        "length / time",
        "velocity of zone edges from the contact edge outward, inf is ahead of all waves",
        ("zone", "edge"),
    ),
    "sense": SurveyVariable("1", "sense of slip in a zone, 0 where there is none", ("zone",), "i1"),
    "opening": SurveyVariable("length / time", "velocity of the ends of what is open", ("edge",)),
    "edge_slip_rate": SurveyVariable("length / time", "relative slip rate at the contact edge"),
    "stress_intensity": SurveyVariable(
        "stress sqrt(length)", "at the contact edge at unit time, like sqrt(t)", ("mode",)
    ),
    "end_time": SurveyVariable("time", "time until which totals are taken"),
    "largest_slip_rate": SurveyVariable("length / time", "largest |slip rate| until the end"),
    "largest_slip": SurveyVariable("length", "largest |slip| at the end, so far in a march"),
    "onset": SurveyVariable("time", "when slip begins, nan where nothing slips"),
    "reach_of_slip": SurveyVariable("length", "farthest position that has slipped until the end"),
    "time_of_largest_slip_rate": SurveyVariable("time", "when |slip rate| is largest"),
    "rupture_speed": SurveyVariable(
        "length / time", "mean speed from where slip begins first to last"
    ),
    "slipped_length": SurveyVariable("length", "length of the contact on which slip has begun"),
    "largest_gap": SurveyVariable("length", "largest gap at the times that a run stores"),
    "arrival": SurveyVariable("time", "when slip begins at a position", ("x",)),
    "front_speed": SurveyVariable(
        "length / time", "speed of the rupture front at a position", ("x",)
    ),
    "accumulated_slip": SurveyVariable("length^2", "integral of accumulated |slip| until the end"),
    "frictional_work": SurveyVariable("stress length^2", "energy turned to heat per unit depth"),
    **{
        name: SurveyVariable(*FIELD_QUANTITIES[name], ("t", "x"))
        for name in ("slip", "slip_rate", "shear_traction", "pressure", "gap")
    },
    "error_estimate": SurveyVariable("1", "error estimate of the answer, nan without one"),
    "slip_rate_error": SurveyVariable("1", "error estimate of the slip rate of a run"),
    "status": SurveyVariable(
        "1", "converged, resolved, or a sentence on what to distrust", (), TEXT
    ),
    "origin": SurveyVariable("1", "how the answer was found", (), TEXT),
    "method": SurveyVariable("1", "solver", (), TEXT),
    "seconds": SurveyVariable("s", "processor time of a point, or its share of that of a sweep"),
}
SPEEDS: Mapping[str, SurveyVariable] = {
    f"{name}_speed": SurveyVariable("length / time", f"speed of {waves} waves")
    for name, waves in (
        ("rayleigh", "Rayleigh"),
        ("shear", "shear"),
        ("longitudinal", "pressure"),
    )
}
