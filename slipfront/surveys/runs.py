"""The quantities of one interface of a survey."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from semianalytic.engine.result import Run
from semianalytic.engine.run import run
from semianalytic.interface.files import InterfaceFile
from semianalytic.results.intervals import front_speeds
from semianalytic.scene.errors import SceneError
from slipfront.surveys.plan import Question

RUN = "interface"
"""Method of interfaces."""


def interface_row(described: InterfaceFile, question: Question) -> dict[str, Any]:
    """Run an interface and return its quantities by name.

    Raises
    ------
    SceneError, ComputationError
        As `run` does, or if there is no end time.
    """
    options: dict[str, Any] = dict(described.options)
    for name in ("nodes", "rtol"):
        if getattr(question, name) is not None:
            options[name] = getattr(question, name)
    end = described.end_time if question.end_time is None else question.end_time
    if question.t and not math.isfinite(end):
        end = max(question.t)
    if not math.isfinite(end):
        raise SceneError("survey: end_time is missing; say until when the interface is computed.")
    if question.t:
        options["times"] = question.t
    done = run(described.interface, end, **options)
    begun = np.isfinite(done.onset)
    touching = done.interface.touching
    row: dict[str, Any] = {
        "end_time": done.end_time,
        "largest_slip": float(np.abs(done.checkpoint.end.slip[touching]).max(initial=0.0)),
        "largest_slip_rate": float(done.peak_rates.max()),
        "time_of_largest_slip_rate": float(done.step_times[done.peak_rates.argmax()]),
        "onset": float(done.onset[begun].min()) if begun.any() else np.nan,
        "reach_of_slip": float(np.abs(done.interface.x[begun]).max(initial=0.0)),
        "rupture_speed": done.rupture_speed,
        "slipped_length": done.slipped_length,
        "frictional_work": done.work["friction"],
        "error_estimate": done.error_estimates["slip"],
        "slip_rate_error": done.error_estimates["slip_rate"],
        "status": done.status,
        "origin": "run",
        "method": RUN,
    }
    if described.interface.may_open:
        row["largest_gap"] = float(done.interface.gap[:, touching].max(initial=0.0))
    return row | _along(done, question)


def _along(done: Run, question: Question) -> dict[str, Any]:
    """Return onset and speed of the front at positions, and fields there at times."""
    if not question.x:
        return {}
    x = np.array(question.x)
    row = {
        "arrival": done.at(done.onset, x),
        "front_speed": done.at(front_speeds(done.onset, done.scene.length / done.nodes), x),
    }
    if question.t:
        for name in question.fields:
            row[name] = done.at(getattr(done.interface, name), x)
    return row
