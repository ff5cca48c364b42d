"""Speed against accuracy: every method on the scenes of the chart, measured on one machine.

A point is one method at one setting.  It is measured in its own process (`tasks`, `methods`),
judged against the reference of its scene (`reference`), and kept in a CSV file (`points`) from
which figures and text (`figure`) are made.
Slip rates are compared by the relative L1 difference at fixed velocities x/(c_t T), zone edges by
the worst one, over c_t.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict
from datetime import date
from pathlib import Path
from typing import Any

import numpy as np

from compare.comparison.measures import relative_error
from compare.output.tables import write_rows
from compare.studies.chart.methods import METHODS, PLACES
from compare.studies.chart.points import COMMAND, SCENES, Point, read_points, same_machine, stamp
from compare.studies.chart.reference import (
    REFERENCE_GRIDS,
    Reference,
    reference_name,
    reference_of,
    worst_edge_error,
)
from compare.studies.chart.tasks import Task, run_task
from compare.tasks.cluster import check_workers
from compare.tasks.workers import Progress, run_tasks
from semianalytic import SlipZone
from semianalytic.scene.errors import ComputationError, SceneError
from semianalytic.scene.given.named import NAMED_SCENES

_QUICK_RUNS = 3
"""Runs of one point of a quick chart; a full one repeats a point as often as its time allows."""
_START = 0.6
"""Time that a process takes until it begins to solve [s], for the estimate of the whole alone."""


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
            for method, sizes in REFERENCE_GRIDS[quick].items():
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
