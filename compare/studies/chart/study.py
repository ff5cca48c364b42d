"""Speed against accuracy: every method on the scenes of the chart, measured on one machine.

A point is one method at one setting.  It is measured in its own process (`methods`), judged against
the reference of its scene, and kept in a CSV file from which figures and text (`figure`) are made.
Slip rates are compared by the relative L1 difference at fixed velocities x/(c_t T), zone edges by
the worst one, over c_t.
"""

from __future__ import annotations

import json
import math
import os
import platform
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from datetime import date
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from compare.comparison.measures import relative_error
from compare.output.tables import read_rows, write_rows
from compare.studies.chart.methods import METHODS, PLACES, scaled_zones
from compare.tasks.cluster import check_workers
from compare.tasks.workers import LIFELINE, ONE_THREAD, Progress, lifeline, run_tasks
from semianalytic import Scene, SlipZone, solve
from semianalytic.reference.known_answers import closed_form
from semianalytic.scene.errors import ComputationError, DataFileError, SceneError
from semianalytic.scene.given.named import NAMED_SCENES

Array = NDArray[np.float64]

SCENES = ("preloaded", "remote-shock", "auxetic", "ramp")
FILE_NAME = "data/chart.csv"
COMMAND = "slipfront chart --output docs"
CLOSED_FORM_FRICTION = {"preloaded": 0.8, "remote-shock": 0.9, "auxetic": 0.8}
"""Friction at which a scene of the chart has one slip zone and a closed form."""
VERSIONS = ("python", "numpy", "scipy", "slipfront")
FINEST = 1e-12
"""Tolerance of the self-similar reference."""

_QUICK_RUNS = 3
_START = 0.6
_REFERENCE_GRIDS = {
    False: {"space-time": (8192, 16384), "fem": (200, 400)},
    True: {"space-time": (1024, 2048), "fem": (50, 100)},
}


@dataclass(frozen=True)
class Point:
    """One measured point, a row of the CSV file; for `reference_*` see `Reference`.

    Attributes
    ----------
    setup, solving : float
        Median times [s]; the chart shows their sum.
    memory : float
        Peak memory of the process [MB].
    error, edge_error : float
        Relative L1 error of the slip rate, and worst error of a zone edge over c_t, which is inf
        if a zone is missed.
    status : str
        "measured", or what to distrust.
    """

    scene_name: str
    method: str
    setting: float
    setup: float
    solving: float
    runs: int
    memory: float
    error: float
    edge_error: float
    status: str
    reference: str
    reference_error: float
    reference_edge_error: float
    python: str
    numpy: str
    scipy: str
    slipfront: str
    machine: str
    cores: int
    date: str

    @property
    def seconds(self) -> float:
        """Time of set-up and solving [s]."""
        return self.setup + self.solving

    @property
    def name(self) -> str:
        """The setting with its name, as in "rtol 1e-08"."""
        return f"{METHODS[self.method].parameter} {self.setting:g}"


@dataclass(frozen=True, eq=False)
class Reference:
    """Reference answer of a scene, against which the methods are measured.

    Attributes
    ----------
    slip_rate : (400,) array
        Slip rate at `PLACES` [length / time].
    zones : tuple of SlipZone
        Slip zones, edges over c_t.
    error, edge_error : float
        Uncertainty of the reference, measured like the errors of a `Point`.
    """

    name: str
    slip_rate: Array
    zones: tuple[SlipZone, ...]
    error: float
    edge_error: float


@dataclass(frozen=True)
class Task:
    """A point to measure."""

    scene_name: str
    method: str
    setting: float


def tasks(scene_names: Sequence[str], quick: bool) -> list[Task]:
    """Return all points of a chart that the methods can reach.

    Raises
    ------
    SceneError
        If a scene is not one of the chart.
    """
    for scene_name in scene_names:
        if scene_name not in SCENES:
            raise SceneError(f"there is no chart of {scene_name!r}; choose {', '.join(SCENES)}.")
    return [
        Task(scene_name, name, float(setting))
        for scene_name in scene_names
        for name, method in METHODS.items()
        if not method.obstacle(NAMED_SCENES[scene_name].scene)
        for setting in (method.quick if quick else method.full)
    ]


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


def reference_of(scene_name: str, quick: bool) -> Reference:
    """Return the self-similar solution at rtol 1e-12, or one extrapolated by two methods."""
    scene = NAMED_SCENES[scene_name].scene
    if not scene.is_self_similar:
        return _extrapolated(scene_name, quick)
    solution, speed = solve(scene, rtol=FINEST), scene.material.shear_speed
    slip_rate = solution.slip_rate(PLACES * speed, 1.0)
    friction = CLOSED_FORM_FRICTION[scene_name]
    checked = closed_form_errors(replace(scene, friction=friction))
    return Reference(reference_name(scene_name, quick), slip_rate, scaled_zones(solution), *checked)


def reference_name(scene_name: str, quick: bool) -> str:
    """Describe the reference of a scene in words."""
    if not NAMED_SCENES[scene_name].scene.is_self_similar:
        return "extrapolated from " + " and ".join(
            f"{METHODS[method].label} {coarse}, {fine}"
            for method, (coarse, fine) in _REFERENCE_GRIDS[quick].items()
        )
    friction = CLOSED_FORM_FRICTION[scene_name]
    return f"self-similar solver, rtol 1e-12; checked by the closed form at friction {friction:g}"


def closed_form_errors(scene: Scene) -> tuple[float, float]:
    """Return the errors of slip rate (relative L1) and edge (over c_t) against closed forms.

    They are those of the solver at rtol 1e-12.  The edge error is nan if all of the contact slips.

    Parameters
    ----------
    scene : Scene
        Scene with one slow slip zone under a shear step, or with a remote shock under which the
        whole contact slips.
    """
    solution, speed = solve(scene, rtol=FINEST), scene.material.shear_speed
    slip_rate = solution.slip_rate(PLACES * speed, 1.0)
    known = closed_form(scene)
    error = relative_error(slip_rate, known.slip_rate(PLACES * speed), PLACES, 1)
    if known.edge_speed is None:
        return error, math.nan
    return error, abs(solution.zones[-1].outer - known.edge_speed) / speed


def _extrapolated(scene_name: str, quick: bool) -> Reference:
    """Extrapolate the space-time solver; its difference from finite elements is the uncertainty."""
    (slip_rate, zones), (other, other_zones) = (
        _limit(*(run_task(Task(scene_name, method, float(size)), 1) for size in sizes))
        for method, sizes in _REFERENCE_GRIDS[quick].items()
    )
    apart = relative_error(other, slip_rate, PLACES, 1)
    edge = worst_edge_error(other_zones, zones)
    return Reference(reference_name(scene_name, quick), slip_rate, zones, apart, edge)


def _limit(coarse: dict[str, Any], fine: dict[str, Any]) -> tuple[Array, tuple[SlipZone, ...]]:
    """Extrapolate slip rate and zones from the results of `run_task` on two grids.

    Errors at fixed positions are assumed to be of second order, those of edges of first.  If the
    grids differ in their zones, those of the finer grid are returned.
    """
    slip_rate = richardson(np.array(coarse["slip_rate"]), np.array(fine["slip_rate"]), 2)
    if [zone[2] for zone in coarse["zones"]] != [zone[2] for zone in fine["zones"]]:
        return slip_rate, tuple(SlipZone(*zone) for zone in fine["zones"])
    edges = richardson(np.array(coarse["zones"]), np.array(fine["zones"]), 1)
    return slip_rate, tuple(
        SlipZone(float(inner), float(outer), int(sense)) for inner, outer, sense in edges
    )


def richardson(coarse: Any, fine: Any, order: int) -> Any:
    """Extrapolate answers on grids of spacing 2 h and h, whose errors have an order in h."""
    return fine + (fine - coarse) / (2**order - 1)


def worst_edge_error(zones: Sequence[SlipZone], expected: Sequence[SlipZone]) -> float:
    """Return the largest error of a zone edge; inf if a zone is missed.

    Each expected zone is compared with the zone of its sense that overlaps it most.
    """
    worst = 0.0
    for zone in expected:
        overlaps = [
            (min(zone.outer, one.outer) - max(zone.inner, one.inner), one)
            for one in zones
            if one.sense == zone.sense
        ]
        shared, closest = max(overlaps, key=lambda pair: pair[0], default=(0.0, zone))
        if shared <= 0:
            return math.inf
        for edge in ("inner", "outer"):
            here, there = getattr(closest, edge), getattr(zone, edge)
            if here != there:
                worst = max(worst, abs(here - there))
    return worst


def measure(task: Task, reference: Reference, quick: bool) -> Point:
    """Measure one point and compare it with the reference."""
    answer = run_task(task, _QUICK_RUNS if quick else 0)
    slip_rate = np.array(answer["slip_rate"])
    zones = [SlipZone(*zone) for zone in answer["zones"]]
    known = np.isfinite(slip_rate).all()
    return Point(
        **asdict(task),
        **{key: answer[key] for key in ("setup", "solving", "runs", "memory", "status")},
        error=relative_error(slip_rate, reference.slip_rate, PLACES, 1),
        edge_error=worst_edge_error(zones, reference.zones) if known else math.nan,
        reference=reference.name,
        reference_error=reference.error,
        reference_edge_error=reference.edge_error,
        **stamp(),
        date=date.today().isoformat(),
    )


def stamp() -> dict[str, Any]:
    """Return versions and machine of a measurement."""
    versions = {name: version(name) for name in VERSIONS[1:]}
    cores = os.cpu_count() or 1
    return {"python": platform.python_version(), **versions, "machine": _machine(), "cores": cores}


def _machine() -> str:
    """Return the model of the processor, as far as the system reports it."""
    known = Path("/proc/cpuinfo")
    lines = known.read_text(encoding="utf-8").splitlines() if known.exists() else []
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return models[0] if models else platform.processor() or platform.machine()


def read_points(path: Path) -> list[Point]:
    """Return the points of an earlier run; none if there is no file.

    Raises
    ------
    DataFileError
        If the file is damaged or not a chart.
    """
    points = read_rows(path, Point, "a chart", COMMAND)
    for point in points:
        if point.method not in METHODS or point.scene_name not in SCENES:
            raise DataFileError(
                f"{path} cannot be read as a chart (unknown {point.method} on {point.scene_name}); "
                "move it away to measure again."
            )
    return points


def same_machine(point: Point, machine: Mapping[str, Any] | None = None) -> bool:
    """Return whether a point was measured on this machine with its versions, or on a given one."""
    return all(getattr(point, name) == value for name, value in (machine or stamp()).items())


def missing(
    planned: Sequence[Task], points: Sequence[Point], machine: Mapping[str, Any] | None = None
) -> list[Task]:
    """Return the planned points that have not been measured on this machine, or on a given one."""
    done = {_task(point) for point in points if same_machine(point, machine)}
    return [task for task in planned if task not in done]


def _task(point: Point) -> Task:
    return Task(point.scene_name, point.method, point.setting)


def estimated_seconds(todo: Sequence[Task], points: Sequence[Point], quick: bool) -> float:
    """Estimate the time of all measurements [s] from earlier ones or rough costs."""
    stored = {_task(point): point.seconds for point in points if math.isfinite(point.seconds)}
    total = 0.0
    for task in todo:
        run = stored.get(task, METHODS[task.method].seconds(task.setting))
        runs = (_QUICK_RUNS if quick else 5) + 1 if run < 1 else 3
        total += _START + runs * run
    for scene_name in {task.scene_name for task in todo}:
        if not NAMED_SCENES[scene_name].scene.is_self_similar:
            for method, sizes in _REFERENCE_GRIDS[quick].items():
                total += sum(METHODS[method].seconds(size) for size in sizes)
    return total


def measure_all(
    path: Path,
    scene_names: Sequence[str],
    *,
    quick: bool = False,
    fresh: bool = False,
    progress: Progress | None = None,
    tell: Callable[[str], None] | None = None,
    client: Any = None,
) -> list[Point]:
    """Measure missing points and append each to a CSV file as soon as it is done.

    Points are few and cheap if `quick`; `fresh` repeats existing ones.  `tell` is called with a
    line about the expected time.  With a `client` of a Dask cluster, each worker measures one point
    at a time.  All points of the file are returned in order.

    Raises
    ------
    SceneError
        If a scene is not one of the chart.
    DataFileError
        If the file is damaged or cannot be written.
    ComputationError
        If a measurement fails; the points measured so far are kept.
    """
    planned, points = tasks(scene_names, quick), read_points(path)
    stored = points
    if fresh:
        points = [point for point in points if point.scene_name not in scene_names]
    _check_references(path, points, scene_names, quick)
    machine = stamp() if client is None else _stamp_of(client)
    todo = missing(planned, points, machine)
    if not todo:
        return points
    if tell is not None:
        seconds, there = estimated_seconds(todo, stored, quick), len(planned) - len(todo)
        tell(f"{len(todo)} points to measure, {there} are there: about {_spoken(seconds)}.")
    points = [point for point in points if same_machine(point, machine)]
    for done, point in enumerate(
        _measured(todo, quick, client), start=len(planned) - len(todo) + 1
    ):
        points = _ordered([*points, point])
        write_rows(path, points, checked=True, command=COMMAND)
        if progress is not None:
            progress(done, len(planned))
    return points


def _check_references(
    path: Path, points: Sequence[Point], scene_names: Sequence[str], quick: bool
) -> None:
    """Raise SceneError if a file holds a quick chart but a full one is wanted, or vice versa."""
    for point in points:
        name = point.scene_name
        if name in scene_names and point.reference != reference_name(name, quick):
            raise SceneError(
                f"{path} measures {name} against another reference ({point.reference}); "
                "give another --output, or --fresh to measure again."
            )


def _measured(todo: Sequence[Task], quick: bool, client: Any) -> Iterator[Point]:
    """Yield points as they are done, scene by scene; on this machine they run one at a time."""
    for scene_name in dict.fromkeys(task.scene_name for task in todo):
        reference = reference_of(scene_name, quick)
        some = [task for task in todo if task.scene_name == scene_name]
        tasks = [(measure, (task, reference, quick)) for task in some]
        yield from (point for _, point in run_tasks(tasks, 1, client=client))


def _stamp_of(client: Any) -> dict[str, Any]:
    """Return the stamp that all workers of a cluster share.

    Raises
    ------
    ComputationError
        If the workers differ in versions or machines.
    """
    check_workers(client)
    stamps = list(client.run(stamp).values())
    if any(one != stamps[0] for one in stamps):
        raise ComputationError(
            "The workers of the cluster run on machines or versions of several kinds, and a chart "
            "is of one; start it with workers of one kind."
        )
    return dict(stamps[0])


def _ordered(points: Sequence[Point]) -> list[Point]:
    """Sort points by scene and method, and from coarse to fine."""
    methods = list(METHODS)
    return sorted(
        points,
        key=lambda point: (
            SCENES.index(point.scene_name),
            methods.index(point.method),
            abs(math.log(point.setting)),
        ),
    )


def _spoken(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 100 else f"{seconds / 60:.0f} min"
