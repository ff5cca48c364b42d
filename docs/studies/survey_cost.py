"""Measure the cost of surveys by point, chunk and cluster task, and plan a survey of 10⁸ points.

``python -m docs.studies.survey_cost points cluster plan --csv docs/data`` measures and writes
the tables of docs/survey.md.
"""

from __future__ import annotations

import os
import resource
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from time import perf_counter, process_time
from typing import Any

import numpy as np

from compare.studies.tables import Study, run_studies
from compare.tasks.cluster import on_cluster
from compare.tasks.workers import run_tasks
from semianalytic.scene.given.named import NAMED_SCENES
from slipfront.surveys.dataset import dataset_of, netcdf_bytes
from slipfront.surveys.plan import SWEPT, Plan, Question, planned
from slipfront.surveys.points import solved_chunk

SIDE = 100
RTOL = 1e-6
_RATIOS = (0.1, 0.45)
_PLANES: Mapping[str, tuple[float, float]] = {"preloaded": (0.1, 0.9), "remote-shock": (1.05, 1.45)}
"""Range of frictions of the plane of each scene."""
WHOLE = SIDE * SIDE
_TASKS = 2000
POINTS, CORES = 10**8, 1000
_MEGABYTE = 1e6


@dataclass(frozen=True)
class PointCost:
    """Cost of the points of a survey.

    Attributes
    ----------
    survey : str
        Name of the survey.
    points, chunk, tasks : int
        Number of points, of points per chunk, and of chunks.
    solving : float
        Processor time per point [ms].
    longest : float
        Processor time of the longest task [s].
    starting : float
        Processor time of a process until its first point [s].
    writing : float
        Processor time to write a point as NetCDF [µs].
    raw, packed, netcdf : float
        Size of a point in memory, of a packed result, and on the disk [B].
    memory : float
        Largest resident memory of a process that solves [MB].
    wall : float
        Wall-clock time of the survey on two processes [s].
    load : float
        Average load of the machine per core meanwhile.
    """

    survey: str
    points: int
    chunk: int
    tasks: int
    solving: float
    longest: float
    starting: float
    writing: float
    raw: float
    packed: float
    netcdf: float
    memory: float
    wall: float
    load: float


@dataclass(frozen=True)
class TaskCost:
    """Cost of a task of a Dask cluster that computes nothing.

    Attributes
    ----------
    tasks : int
        Number of tasks.
    size : float
        Size of a result [kB].
    scheduling : float
        Processor time of scheduler and client per task [ms].
    working : float
        Processor time of a worker per task [ms].
    per_second : float
        Number of tasks per second.
    load : float
        Average load of the machine per core meanwhile.
    """

    tasks: int
    size: float
    scheduling: float
    working: float
    per_second: float
    load: float


@dataclass(frozen=True)
class PlanRow:
    """One line of the plan."""

    what: str
    value: str
    follows: str


def plane_plan(name: str, chunk: int, side: int = SIDE) -> Plan:
    """Plan the survey of a plane of a named scene."""
    values = {
        "friction": np.linspace(*_PLANES[name], side),
        "poisson_ratio": np.linspace(*_RATIOS, side),
    }
    return planned(NAMED_SCENES[name].scene, values, Question(RTOL), chunk=chunk)


def _plans() -> dict[str, Plan]:
    loads = {"base_shear": np.linspace(0, 0.25, 20), "load_shear": np.linspace(0.3, 1, 20)}
    ramp = {"friction": np.linspace(0.1, 0.6, 8)}
    return {
        "preloaded, chunks": plane_plan("preloaded", SWEPT),
        "preloaded, one chunk": plane_plan("preloaded", WHOLE),
        "remote-shock, chunks": plane_plan("remote-shock", SWEPT),
        "preloaded, base and load": planned(NAMED_SCENES["preloaded"].scene, loads, Question(RTOL)),
        "ramp, marched": planned(NAMED_SCENES["ramp"].scene, ramp, Question()),
    }


def _measured_chunk(*arguments: Any) -> tuple[bytes, float, float, float]:
    """Solve a chunk; return it, the processor time before and during it [s], and memory [MB]."""
    before = process_time()
    data = solved_chunk(*arguments)
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return data, before, process_time() - before, usage.ru_maxrss / 1024


def cost_of(name: str, plan: Plan) -> PointCost:
    """Solve and write a survey on two processes, and measure its costs."""
    tasks = [
        (_measured_chunk, (plan.scene, plan.region_values(region), plan.fixed, plan.question))
        for region in plan.regions
    ]
    began = perf_counter()
    found = dict(run_tasks([*tasks, (_measured_chunk, tasks[0][1])][: max(len(tasks), 2)], 2))
    parts = [found[index] for index in range(len(tasks))]

    def chunks() -> list[tuple[int, bytes]]:
        return [(index, part[0]) for index, part in enumerate(parts)]

    start = process_time()
    data = dataset_of(plan, chunks, plan.call)
    netcdf = len(netcdf_bytes(data))
    writing, wall = process_time() - start, perf_counter() - began
    count = plan.count
    return PointCost(
        survey=name,
        points=count,
        chunk=max(len(next(iter(plan.region_values(one).values()))) for one in plan.regions),
        tasks=len(tasks),
        solving=1e3 * sum(part[2] for part in parts) / count,
        longest=max(part[2] for part in parts),
        starting=min(part[1] for part in parts),
        writing=1e6 * writing / count,
        raw=data.nbytes / count,
        packed=sum(len(part[0]) for part in parts) / count,
        netcdf=netcdf / count,
        memory=max(part[3] for part in parts),
        wall=wall,
        load=_load(),
    )


def _load() -> float:
    return os.getloadavg()[0] / (os.cpu_count() or 1)


@cache
def points() -> list[PointCost]:
    """Measure the costs of points of all kinds."""
    return [cost_of(name, plan) for name, plan in _plans().items()]


def _result(size: int) -> bytes:
    """Return a result of a given size [B]."""
    return os.urandom(size)


@cache
def cluster() -> list[TaskCost]:
    """Measure the costs of tasks by the size of their results."""
    from distributed import Client, LocalCluster

    rows = []
    options = {"threads_per_worker": 1, "host": "127.0.0.1", "dashboard_address": "127.0.0.1:0"}
    with LocalCluster(n_workers=2, **options) as local, Client(local) as client:
        for size in (0, 250_000, 1_000_000):
            tasks = [(_result, (size,))] * _TASKS
            own, worked, began = process_time(), _worked(client), perf_counter()
            assert sum(1 for _ in on_cluster(tasks, client)) == _TASKS
            rows.append(
                TaskCost(
                    tasks=_TASKS,
                    size=size / 1e3,
                    scheduling=1e3 * (process_time() - own) / _TASKS,
                    working=1e3 * (_worked(client) - worked) / _TASKS,
                    per_second=_TASKS / (perf_counter() - began),
                    load=_load(),
                )
            )
    return rows


def _worked(client: Any) -> float:
    """Return the processor time of all workers so far [s]."""
    return float(sum(client.run(process_time).values()))


def plan() -> list[PlanRow]:
    """Plan how 1,000 cores would solve 10⁸ points of the plane, from the measured costs."""
    cost = next(row for row in points() if row.survey == "preloaded, one chunk")
    task = min(cluster(), key=lambda row: abs(row.size * 1e3 - cost.packed * cost.chunk))
    tasks = POINTS // cost.chunk
    core_hours = POINTS * cost.solving / 3.6e6
    wall = POINTS * cost.solving / 1e3 / CORES
    scheduling = tasks * task.scheduling / 1e3
    traffic = POINTS * cost.packed / _MEGABYTE
    writing = POINTS * cost.writing / 1e6
    slowest = cost.longest
    rows = (
        ("points", "10⁸", "10,000 frictions × 10,000 Poisson ratios"),
        ("cores", f"{CORES:,}", "one thread each, `dask worker --nthreads 1`"),
        ("chunk", f"{cost.chunk:,} points", "`chunk=10000`, 100 × 100 or the like"),
        ("tasks", f"{tasks:,}", f"{tasks // CORES} for each core"),
        ("processor time of a point", f"{cost.solving:.2f} ms", "measured, chunk of that size"),
        ("processor time of a task", f"{slowest:.0f} s", "measured"),
        ("processor time in all", f"{core_hours:.0f} core hours", "points × that of a point"),
        ("solving", f"{wall:.0f} s", "over the cores, all of them busy"),
        ("last tasks", f"{slowest:.0f} s more", "one task: the cores end at different times"),
        ("scheduler and client", f"{scheduling:.0f} s", f"{task.scheduling:.1f} ms a task"),
        (
            "share of the scheduler",
            f"{100 * scheduling / wall:.0f} %",
            "of its own core, while solving",
        ),
        ("results", f"{cost.packed * cost.chunk / 1e3:.0f} kB a task", "measured, packed"),
        ("traffic to the client", f"{traffic / 1e3:.1f} GB", f"{traffic / wall:.0f} MB/s"),
        ("chunks on the disk", f"{tasks:,} files", "beside the path, until the end"),
        ("NetCDF file", f"{POINTS * cost.netcdf / 1e9:.1f} GB", f"{cost.netcdf:.0f} B a point"),
        (
            "in memory",
            f"{POINTS * cost.raw / 1e9:.0f} GB",
            "of the client; twice as much while it writes",
        ),
        ("writing the file", f"{writing:.0f} s", "in one process, at the end"),
        ("memory of a worker", f"{cost.memory:.0f} MB", "measured, largest"),
        ("lost with a worker", f"{slowest:.0f} s of one core", "its task goes to another"),
        ("lost with scheduler or client", f"at most {CORES:,} tasks", "those under way"),
    )
    return [PlanRow(*row) for row in rows]


STUDIES: dict[str, Study] = {"points": points, "cluster": cluster, "plan": plan}

if __name__ == "__main__":
    raise SystemExit(run_studies("docs.studies.survey_cost", "survey", STUDIES))
