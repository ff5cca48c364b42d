"""The quantities of one scene on a line of a survey."""

from __future__ import annotations

from typing import Any

import numpy as np

from semianalytic.engine.result import Run
from semianalytic.engine.run import run
from semianalytic.results.intervals import front_speeds
from semianalytic.scene.errors import SceneError
from semianalytic.scene.scene import Scene
from slipfront.surveys.plan import Question

RUN = "interface"
"""Method of scenes on a line."""


def line_row(scene: Scene, question: Question) -> dict[str, Any]:
    """March a scene and return its quantities by name; SceneError without an end time.

    All other errors are those of `run`.
    """
    options: dict[str, Any] = dict(scene.run)
    for name in ("nodes", "rtol", "end_time"):
        if getattr(question, name) is not None:
            options[name] = getattr(question, name)
    if question.t and "end_time" not in options:
        options["end_time"] = max(question.t)
    if "end_time" not in options:
        raise SceneError("survey: end_time is missing; say until when the scene is marched.")
    if question.t:
        options["times"] = question.t
    done = run(scene, **options)
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
    if scene.may_open:
        row["largest_gap"] = float(done.interface.gap[:, touching].max(initial=0.0))
    return row | _along(done, question)


def _along(done: Run, question: Question) -> dict[str, Any]:
    """Return onset and speed of the front at positions, and fields there at times."""
    if not question.x:
        return {}
    x = np.array(question.x)
    row = {
        "arrival": done.at(done.onset, x),
        "front_speed": done.at(front_speeds(done.onset, done.scene.period / done.nodes), x),
    }
    if question.t:
        for name in question.fields:
            row[name] = done.at(getattr(done.interface, name), x)
    return row
