"""How long a solution takes, as a ratio to a dense 400 x 400 solve measured in the same run.

Run as ``python -m compare.solver_benchmark``.  Times are processor times on one thread, medians
of interleaved repetitions, so that other work on the machine disturbs both sides alike; each is
printed next to the error reached, relative L1 of the slip rate against rtol = 1e-12.
"""

from __future__ import annotations

import os
import statistics
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from time import process_time

import numpy as np

from compare.scenes import find_scene
from semianalytic import Scene, solve
from semianalytic.collocation import slip_grid
from semianalytic.rayleigh import rayleigh_factors
from semianalytic.stuck import stuck_traction

SCENES = ("preloaded", "remote-shock")
TOLERANCES = (1e-3, 1e-8, 1e-11)


@dataclass(frozen=True)
class Timing:
    """One row: ratio to the dense solve with warm and cold tables, and the error reached."""

    scene: str
    rtol: float
    warm: float
    cold: float
    error: float


def forget_tables() -> None:
    """Drop all that is kept per Poisson ratio."""
    for table in (rayleigh_factors, stuck_traction, slip_grid):
        table.cache_clear()


def median_times(tasks: list[Callable[[], object]], repetitions: int) -> list[float]:
    """Median processor time of each task [s], the tasks taking turns."""
    times: list[list[float]] = [[] for _ in tasks]
    for _ in range(repetitions):
        for task, collected in zip(tasks, times, strict=True):
            start = process_time()
            task()
            collected.append(process_time() - start)
    return [statistics.median(collected) for collected in times]


def slip_rate_error(scene: Scene, rtol: float) -> float:
    """Relative L1 error of the slip rate over 0.02 < x/(c_t t) < 1.9 against rtol = 1e-12."""
    x = np.linspace(0.02, 1.9, 2000) * scene.material.shear_speed
    exact = solve(scene, rtol=1e-12).slip_rate(x, 1.0)
    return float(np.abs(solve(scene, rtol=rtol).slip_rate(x, 1.0) - exact).sum() / exact.sum())


def measure(repetitions: int = 15) -> list[Timing]:
    """Time the solver on the named scenes at several tolerances."""
    random = np.random.default_rng(0)
    matrix, right = random.standard_normal((400, 400)), random.standard_normal(400)
    cases = [(name, find_scene(name), rtol) for name in SCENES for rtol in TOLERANCES]

    def cold(scene: Scene, rtol: float) -> None:
        forget_tables()
        solve(scene, rtol=rtol)

    tasks: list[Callable[[], object]] = [partial(np.linalg.solve, matrix, right)]
    tasks += [partial(solve, scene, rtol=rtol) for _, scene, rtol in cases]
    for task in tasks:
        task()
    dense, *warm = median_times(tasks, repetitions)
    cold_tasks = [partial(cold, scene, rtol) for _, scene, rtol in cases]
    cold_times = median_times([tasks[0], *cold_tasks], max(repetitions // 3, 3))
    return [
        Timing(name, rtol, hot / dense, chill / cold_times[0], slip_rate_error(scene, rtol))
        for (name, scene, rtol), hot, chill in zip(cases, warm, cold_times[1:], strict=True)
    ]


def main() -> None:
    """Print the table."""
    print(f"{'scene':14}{'rtol':>8}{'warm':>8}{'cold':>8}{'error':>10}   (dense 400 solves)")
    for row in measure():
        print(f"{row.scene:14}{row.rtol:8.0e}{row.warm:8.1f}{row.cold:8.1f}{row.error:10.1e}")


if __name__ == "__main__":
    if os.environ.get("OPENBLAS_NUM_THREADS") != "1":
        print("note: set OPENBLAS_NUM_THREADS=1 to compare on one thread")
    main()
