"""Scenes of a chart, the methods that answer them, and one measured point of a method.

Each point is measured in a process of its own with one linear-algebra thread: no point warms up
another, and a method that exhausts the memory ends nothing else.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from compare.tasks.workers import in_fresh_process
from semianalytic import Scene, solve
from semianalytic.methods import chosen
from semianalytic.results.files import row_checksum
from semianalytic.results.interruption import whole
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import ComputationError, SlipfrontError
from semianalytic.scene.given.documents import scene_document
from semianalytic.scene.given.finding import find_scene, scene_label

QUANTITIES = ("slip_rate", "slip")
"""Quantities that can be compared; slip serves where nothing slips any more at the end."""
_PLACES = 400
_LAST = 10**9  # stores the last level alone
_RUNS, _ENOUGH = 5, 1.0  # most runs of a point, and seconds of runs after which no more are made


@dataclass(frozen=True)
class Problem:
    """A scene by its name or file, and the end time [time]."""

    source: str
    scene: Scene
    end_time: float

    @property
    def label(self) -> str:
        """Name of the scene, or stem of its file."""
        return scene_label(self.source)

    @property
    def is_exact(self) -> bool:
        """Whether the exact solver answers."""
        return chosen(self.scene).name == "self-similar"

    @property
    def is_alike(self) -> bool:
        """Whether both bodies are equal; others are not marched."""
        return self.scene.lower_material is None

    @property
    def finest(self) -> float:
        """Smallest tolerance of the exact solver, that of an exact reference."""
        return 1e-12 if self.is_alike else 1e-10

    @property
    def places(self) -> Array:
        """Positions at which answers are compared (400,) [length].

        Slip rates may be singular at the edge, and have fronts where the first wave has come.
        """
        start = 0.02 * self.scene.material.shear_speed
        return np.linspace(start, 0.95 * self.scene.fastest_speed, _PLACES) * self.end_time

    @property
    def fingerprint(self) -> str:
        """Checksum of all that decides the answer: a file may change under its name."""
        return row_checksum([repr((scene_document(self.scene), self.end_time))])

    @property
    def tasks(self) -> list[tuple[str, float]]:
        """Names of the methods that apply, with their settings, the coarsest of each first."""
        return [
            (name, method.settings[level])
            for level in range(max(len(method.settings) for method in METHODS.values()))
            for name, method in METHODS.items()
            if level < len(method.settings) and method.applies(self)
            if method.settings[level] > self.finest
        ]

    def reading(self, answer: Any, quantity: str) -> Array:
        """Return a quantity of an answer at the places and the end time."""
        return np.asarray(getattr(answer, quantity)(self.places, self.end_time))


def find_problem(source: str, end_time: float | None = None) -> Problem:
    """Find a scene of one or two materials by its name or file, with T = 1 / c_t unless given."""
    scene = find_scene(source)
    end_time = 1 / scene.material.shear_speed if end_time is None else end_time
    return Problem(source, scene, end_time)


def exact(problem: Problem, rtol: float) -> Any:
    """Solve a self-similar problem of one or two materials."""
    return solve(problem.scene, rtol=rtol)


def marched(problem: Problem, nodes: float, estimate: bool = False) -> Any:
    """March a problem of one material."""
    given = {"end_time": problem.end_time, "nodes": int(nodes), "every": _LAST}
    return whole(solve(problem.scene, method="space-time", **given, estimate=estimate))


def _finite_elements(problem: Problem, resolution: float) -> Any:
    from fem import simulate

    return simulate(problem.scene, problem.end_time, resolution=int(resolution), every=_LAST)


@dataclass(frozen=True)
class ChartedMethod:
    """A method: its label, words around its settings, these from coarse to fine, and its run."""

    label: str
    words: str
    settings: tuple[float, ...]
    run: Callable[[Problem, float], Any]
    applies: Callable[[Problem], bool] = lambda problem: True


METHODS: Mapping[str, ChartedMethod] = {
    "exact": ChartedMethod(
        "exact solver", "rtol {}", (1e-2, 1e-4, 1e-6, 1e-8, 1e-10), exact, lambda p: p.is_exact
    ),
    "march": ChartedMethod(
        "march", "{} nodes", (128, 256, 512, 1024, 2048), marched, lambda p: p.is_alike
    ),
    "fem": ChartedMethod(
        "finite elements", "{} elements per $c_t T$", (25, 50, 100, 200), _finite_elements
    ),
}
"""All methods by their name in the table."""


def measured(problem: Problem, method: str, setting: float) -> dict[str, Any]:
    """Run a method in this process until a second is spent, at most six times.

    Keys of the result are the least seconds of processor time and the number of runs, of which the
    first one counts only if it is the only one; the status, which says why a method refuses the
    problem, with numbers that are nan; and lists of the `QUANTITIES`.
    """
    seconds: list[float] = []
    try:
        while len(seconds) <= _RUNS and sum(seconds) < _ENOUGH:
            started = time.process_time()
            answer = METHODS[method].run(problem, setting)
            problem.reading(answer, QUANTITIES[0])
            seconds.append(time.process_time() - started)
        values = {name: problem.reading(answer, name).tolist() for name in QUANTITIES}
    except SlipfrontError as error:
        nothing = dict.fromkeys(QUANTITIES, [math.nan] * _PLACES)
        return {"seconds": math.nan, "runs": 0, "status": str(error), **nothing}
    counted = seconds[1:] or seconds
    least = max(min(counted), time.get_clock_info("process_time").resolution)
    return {"seconds": least, "runs": len(counted), "status": answer.status, **values}


def run_point(problem: Problem, method: str, setting: float) -> dict[str, Any]:
    """Return `measured` of a fresh process, which may fail, for instance for lack of memory."""
    try:
        return dict(in_fresh_process(measured, problem, method, setting))
    except Exception as error:  # of any kind, or the process was killed
        raise ComputationError(
            f"{METHODS[method].label} on {problem.label} at {setting:g} failed ({error}); start "
            "again to continue with the other points."
        ) from error
