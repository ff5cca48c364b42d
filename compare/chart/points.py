"""Points of a chart and their references: measured, kept in a file, and taken up again.

A point is one method at one setting.  Its error is the relative L1 difference from the reference of
its scene, in the slip rate at the places and the end time of `Problem`.
"""

from __future__ import annotations

import math
import os
import platform
import shlex
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from datetime import date
from functools import cache
from importlib.metadata import version
from pathlib import Path
from time import monotonic

from compare.chart.methods import QUANTITIES, Problem, exact, marched, run_point
from compare.comparison.measures import is_nothing, relative_error
from compare.comparison.scales import slip_rate_scale
from compare.output.tables import read_rows, write_rows
from compare.tasks.workers import Progress
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import ComputationError, SceneError
from semianalytic.scene.given.finding import scene_label

FILE = "data/chart.csv"
COMMAND = "slipfront chart"
REFERENCE_NODES = 4096
"""Nodes of a marched reference."""
GROWTH = 4.0
"""Time of a point over that of the one before it of its method: a grid of twice the nodes."""
Key = tuple[str, str, float]  # label of a scene, method and setting


@dataclass(frozen=True)
class Point:
    """One measured point, a row of the file.

    The scene is its name or file as it was given.  Where a method refuses it, `status` says why,
    and `seconds` of processor time and `error` are nan.  A point counts as finished for the same
    `fingerprint` and `reference`, and on the same `machine` with the same versions.
    """

    scene: str
    fingerprint: str
    end_time: float
    quantity: str
    method: str
    setting: float
    seconds: float
    runs: int
    error: float
    status: str
    reference: str
    reference_error: float
    machine: str
    date: str

    @property
    def key(self) -> Key:
        """Label of the scene, method and setting."""
        return scene_label(self.scene), self.method, self.setting


def reference_name(problem: Problem) -> str:
    """Describe the reference of a problem in words."""
    of = f"exact solver, rtol {problem.finest:g}", f"march, {REFERENCE_NODES} nodes"
    return of[0] if problem.is_exact else of[1]


def reference_of(problem: Problem) -> tuple[str, Array, float]:
    """Return the quantity that is compared, its values (400,), and their relative L1 error.

    They are those of the exact solver for a self-similar problem, of a fine march for others.  A
    problem is refused if nothing slips, so that relative errors have no meaning.
    """
    is_exact = problem.is_exact
    answer = exact(problem, problem.finest) if is_exact else marched(problem, REFERENCE_NODES, True)
    if is_exact and answer.status != "converged":
        raise ComputationError(f"The exact solver gives no reference: {answer.status}")
    scale = slip_rate_scale(problem.scene)
    for quantity, unit in zip(QUANTITIES, (scale, scale * problem.end_time), strict=True):
        values = problem.reading(answer, quantity)
        if is_nothing(values, unit):
            continue
        if is_exact:
            return quantity, values, max(problem.finest, float(answer.error_estimate))
        bars = answer.error_of(lambda own, name=quantity: problem.reading(own, name))
        return quantity, values, relative_error(values + bars, values, problem.places, 1)
    raise SceneError(
        f"Nothing of {problem.label} slips until t = {problem.end_time:g}, so that slip has no "
        "relative error to chart; choose another scene or a later --end-time."
    )


def this_machine() -> str:
    """Return the processor, as far as the system says it, and the versions of a measurement."""
    known = Path("/proc/cpuinfo")
    lines = known.read_text(encoding="utf-8").splitlines() if known.exists() else []
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    processor = (models or [platform.processor() or platform.machine()])[0]
    versions = [f"{name} {version(name)}" for name in ("numpy", "scipy", "slipfront")]
    python = f"Python {platform.python_version()}"
    return ", ".join([processor, f"{os.cpu_count()} cores", python, *versions])


def made_by(path: Path) -> str:
    """Return the command in the first line of a chart; the bare command for any other file."""
    first = b""
    with suppress(OSError):
        first = path.read_bytes().partition(b"\n")[0]
    command = first.decode("utf-8", "replace").removeprefix("# ")
    return command if command.startswith(f"{COMMAND} ") else COMMAND


def read_points(path: Path) -> list[Point]:
    """Return the points of an earlier run, none without a file; a damaged one is refused."""
    return read_rows(path, Point, "a chart", made_by(path))


def measure_all(
    directory: Path,
    problems: Sequence[Problem],
    until: float | None = None,
    fresh: bool = False,
    progress: Progress | None = None,
    tell: Callable[[str], None] | None = None,
    budget: float = math.inf,
) -> list[Point]:
    """Measure the missing points of problems; the file of a folder is written after each.

    Return all points of the folder, those of other scenes first.  `until` is the end time that was
    asked for, `fresh` repeats finished points, and `tell` is called with a sentence on how many are
    missing.  A point is not begun where one that is `GROWTH` times as long as the last of its
    method does not fit into what is left of the budget [s] of a problem; the first is measured.
    """
    labels = {problem.label for problem in problems}
    if len(labels) < len(problems):
        raise SceneError("Two scenes have the same name; give each its own --output folder.")
    planned: dict[Key, Problem] = {(p.label, *at): p for p in problems for at in p.tasks}
    here, stored = this_machine(), read_points(directory / FILE)
    others = [point for point in stored if point.key[0] not in labels]
    done = {point.key: point for point in stored if not fresh and _counts(point, planned, here)}
    scenes = [*dict.fromkeys(point.scene for point in others), *(task.source for task in problems)]
    options = ["--output", str(directory), *(["--end-time", str(until)] if until else [])]
    command = f"{COMMAND} {shlex.join([*scenes, *options])}"
    reference = cache(reference_of)
    missing = [key for key in planned if key not in done]
    ends, longest = dict[str, float](), dict[tuple[str, str], float]()
    for key in missing:
        label, method, _ = key
        started = monotonic()
        first = ends.setdefault(label, started + budget) == started + budget
        if not first and started + longest.get((label, method), 0.0) > ends[label]:
            continue
        truth = reference(planned[key])
        if tell is not None and key == missing[0]:
            tell(f"{len(missing)} points to measure, {len(done)} are there.")
        done[key] = _measured(planned[key], key, truth, here)
        longest[label, method] = GROWTH * (monotonic() - started)
        points = [*others, *(done[key] for key in planned if key in done)]
        write_rows(directory / FILE, points, checked=True, command=command)
        if progress is not None:
            progress(len(done), len(planned))
    return [*others, *(done[key] for key in planned if key in done)]


def not_measured(problems: Sequence[Problem], points: Sequence[Point]) -> list[Key]:
    """Return the points of problems that a budget kept from being measured."""
    known = {point.key for point in points}
    tasks = [(problem.label, *task) for problem in problems for task in problem.tasks]
    return [task for task in tasks if task not in known]


def _counts(point: Point, planned: Mapping[Key, Problem], here: str) -> bool:
    """Return whether a point is of a planned problem and its reference, on this machine."""
    problem = planned.get(point.key)
    given = point.fingerprint, point.reference, point.machine
    return problem is not None and given == (problem.fingerprint, reference_name(problem), here)


def _measured(problem: Problem, key: Key, truth: tuple[str, Array, float], here: str) -> Point:
    """Measure one point and compare it with a reference."""
    (_, method, setting), (quantity, values, bar) = key, truth
    answer = run_point(problem, method, setting)
    error = relative_error(answer[quantity], values, problem.places, 1)
    return Point(
        *(problem.source, problem.fingerprint, problem.end_time, quantity, method, setting),
        *(answer["seconds"], answer["runs"], error, answer["status"]),
        *(reference_name(problem), bar, here, date.today().isoformat()),
    )
