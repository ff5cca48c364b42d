"""One point to measure, and its run in a process of its own."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import dataclass
from typing import Any

from compare.studies.chart.methods import METHODS
from compare.tasks.workers import LIFELINE, ONE_THREAD, lifeline
from semianalytic.scene.errors import ComputationError


@dataclass(frozen=True)
class Task:
    """A point to measure."""

    scene_name: str
    method: str
    setting: float


def run_task(task: Task, runs: int) -> dict[str, Any]:
    """Run `methods.measured` in a fresh process with one linear-algebra thread.

    Raises
    ------
    ComputationError
        If the process fails, for instance because memory runs out.
    """
    command = [sys.executable, "-m", "compare.studies.chart.methods", task.scene_name, task.method]
    with lifeline() as stdin:
        process = subprocess.run(
            [*command, repr(task.setting), str(runs), LIFELINE],
            env={**os.environ, **ONE_THREAD},
            stdin=stdin,
            capture_output=True,
            text=True,
        )
    if process.returncode:
        last = (process.stderr.strip().splitlines() or ["no message"])[-1]
        raise ComputationError(
            f"{METHODS[task.method].label} on {task.scene_name} at {task.setting:g} ended with "
            f"code {process.returncode} ({last}); start again to go on with the other points."
        )
    return dict(json.loads(process.stdout))
