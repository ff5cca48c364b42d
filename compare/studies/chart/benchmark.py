"""Benchmarks of solutions, sweeps and the import, as ratios of times measured in the same run.

Run as ``python -m compare.studies.chart.benchmark solve sweep batch import``; ``--csv docs/data``
writes the data of docs/solver.md.

- solve: a solution against a dense 400 x 400 solve, with its error (relative L1 of the slip rate
  against rtol = 1e-12).
- sweep: 100 and 1,000 frictions against solving them one by one (for 1,000: every tenth, times
  ten), with the largest difference of edges and the origins of the solutions.
- batch: 10,000 points of friction and Poisson ratio, in a grid and scattered, against solving every
  hundredth.
- import: ``semianalytic`` against numpy and scipy.linalg.

Times are processor times on one thread and medians of interleaved repetitions, so that other work
on the machine disturbs both sides alike.  A batch is timed only once.
"""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from time import process_time

import numpy as np

from compare.comparison.measures import relative_error
from compare.studies.tables import Study, run_studies
from semianalytic import Scene, Solution, solve
from semianalytic.halfplane.rayleigh import rayleigh_factors
from semianalytic.halfplane.stuck import stuck_traction
from semianalytic.scene.given.finding import find_scene
from semianalytic.selfsimilar.zones.collocation import slip_grid
from semianalytic.sweeps.continuation import COMPUTED, FROM_SCRATCH, INTERPOLATED
from semianalytic.sweeps.sweep import Sweep, sweep

SWEEPS = {"preloaded": (0.05, 1.0), "remote-shock": (1.05, 1.5)}  # each range crosses thresholds
_FRICTIONS = 100
_MANY_FRICTIONS = 1000
_SWEEP_TOLERANCES = (1e-3, 1e-6, 1e-8)
_ORIGINS = (FROM_SCRATCH, COMPUTED, INTERPOLATED)
_GAP = 1e-13  # relative to c_t; zones this close to each other count as one
SCENES = ("preloaded", "remote-shock")
RATIOS = (0.0, 0.45)
TOLERANCES = (1e-3, 1e-8, 1e-11)


@dataclass(frozen=True)
class Timing:
    """Ratio to the dense solve with warm and cold tables, and the error of the solution."""

    scene_name: str
    rtol: float
    warm: float
    cold: float
    error: float


def forget_tables() -> None:
    """Clear all tables that are cached per Poisson ratio."""
    for table in (rayleigh_factors, stuck_traction, slip_grid):
        table.cache_clear()


def median_times(tasks: list[Callable[[], object]], repetitions: int) -> list[float]:
    """Return the median processor time of each task [s]; the tasks run in turns."""
    times: list[list[float]] = [[] for _ in tasks]
    for _ in range(repetitions):
        for task, collected in zip(tasks, times, strict=True):
            start = process_time()
            task()
            collected.append(process_time() - start)
    return [statistics.median(collected) for collected in times]


def slip_rate_error(scene: Scene, rtol: float) -> float:
    """Return the relative L1 error of the slip rate over 0.02 < x/(c_t t) < 1.9.

    The reference is a solution with rtol = 1e-12.
    """
    x = np.linspace(0.02, 1.9, 2000) * scene.material.shear_speed
    exact, rough = (solve(scene, rtol=tolerance).slip_rate(x, 1.0) for tolerance in (1e-12, rtol))
    return relative_error(rough, exact, x, 1)


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


@dataclass(frozen=True)
class SweepTiming:
    """Timing of one sweep over a number of frictions.

    It holds the ratio of the time one by one to that of the sweep; numbers of solutions from
    scratch, computed and interpolated; and the largest difference of zone edges over c_t, among
    frictions at which both ways give the same number of zones.
    """

    scene_name: str
    frictions: int
    rtol: float
    ratio: float
    scratch: int
    computed: int
    interpolated: int
    difference: float
    other_zones: int


def edge_difference(one: Solution, other: Solution) -> float | None:
    """Return the largest difference of zone edges over c_t; None if the zones differ in number."""
    speed = one.scene.material.shear_speed
    mine, theirs = (_joined(solution.edge_speeds / speed) for solution in (one, other))
    if len(mine) != len(theirs):
        return None
    apart = [abs(p - q) for p, q in zip(mine, theirs, strict=True) if p != q]
    return max(apart, default=0.0)


def _joined(fronts: np.ndarray) -> list[float]:
    """Return the edges of zones, without gaps too narrow to matter."""
    edges = fronts.ravel().tolist()
    gaps = [i for i in range(1, len(edges) - 1, 2) if edges[i + 1] - edges[i] < _GAP]
    return [edge for i, edge in enumerate(edges) if i not in gaps and i - 1 not in gaps]


def _checked(
    done: Sweep, chosen: Sequence[int], singles: Sequence[Solution]
) -> tuple[int, int, int, float, int]:
    """Compare a sweep with scenes solved alone.

    Return the numbers of solutions from scratch, computed and interpolated, the largest difference
    of edges, and the number of scenes whose zones differ in number.
    """
    differences = [edge_difference(done[i], one) for i, one in zip(chosen, singles, strict=True)]
    known = [one for one in differences if one is not None]
    scratch, computed, interpolated = map(done.origin.count, _ORIGINS)
    return scratch, computed, interpolated, max(known), len(differences) - len(known)


def measure_sweep(
    name: str, rtol: float, repetitions: int = 3, count: int = _FRICTIONS
) -> SweepTiming:
    """Time a sweep over `count` frictions, a multiple of 100, against solving them one by one."""
    scene, friction = find_scene(name), np.linspace(*SWEEPS[name], count)
    chosen = range(0, count, count // _FRICTIONS)
    results: dict[str, Sweep] = {}
    singles: list[Solution] = []

    def swept() -> None:
        results["sweep"] = sweep(scene, friction, rtol)

    def one_by_one() -> None:
        singles[:] = [solve(replace(scene, friction=float(friction[i])), rtol=rtol) for i in chosen]

    quick, slow = median_times([swept, one_by_one], repetitions)
    ratio = slow / quick * count / len(chosen)
    return SweepTiming(name, count, rtol, ratio, *_checked(results["sweep"], chosen, singles))


@dataclass(frozen=True)
class BatchTiming:
    """Timing of a batch over friction and Poisson ratio.

    It holds milliseconds per point, the ratio of the time one by one to that of the batch, and the
    comparison of solutions as in `SweepTiming`.
    """

    scene_name: str
    places: str
    points: int
    rtol: float
    milliseconds: float
    ratio: float
    scratch: int
    computed: int
    interpolated: int
    difference: float
    other_zones: int


def batch_points(name: str, places: str, side: int) -> tuple[np.ndarray, np.ndarray]:
    """Return frictions and Poisson ratios of side^2 points, in a "grid" or "scattered"."""
    if places == "grid":
        friction, ratio = np.linspace(*SWEEPS[name], side), np.linspace(*RATIOS, side)
        return np.tile(friction, side), np.repeat(ratio, side)
    random = np.random.default_rng(0)
    return random.uniform(*SWEEPS[name], side**2), random.uniform(*RATIOS, side**2)


def measure_batch(name: str, places: str, rtol: float = 1e-6, side: int = 100) -> BatchTiming:
    """Time a batch, and after it the separate solution of every hundredth point."""
    friction, ratio = batch_points(name, places, side)
    start = process_time()
    done = sweep(find_scene(name), friction, rtol, poisson_ratio=ratio)
    quick = (process_time() - start) / len(done)
    chosen = range(0, len(done), max(1, len(done) // 100))
    start = process_time()
    singles = [solve(done[i].scene, rtol=rtol) for i in chosen]
    slow = (process_time() - start) / len(chosen)
    checked = _checked(done, chosen, singles)
    return BatchTiming(name, places, len(done), rtol, 1e3 * quick, slow / quick, *checked)


def import_ratio(repetitions: int = 9) -> float:
    """Time starting Python and importing semianalytic, over importing numpy and scipy.linalg."""
    codes = ("import numpy, scipy.linalg", "import semianalytic")
    times: list[list[float]] = [[], []]
    for _ in range(repetitions):
        for code, collected in zip(codes, times, strict=True):
            begin = os.times()
            subprocess.run([sys.executable, "-c", code], check=True)
            end = os.times()
            collected.append(end.children_user + end.children_system)
            collected[-1] -= begin.children_user + begin.children_system
    base, own = (statistics.median(collected) for collected in times)
    return own / base


@dataclass(frozen=True)
class ImportRow:
    """Time to start Python and import semianalytic, over that for numpy and scipy.linalg."""

    ratio: float


def sweeps() -> list[SweepTiming]:
    """Time sweeps over a hundred and over a thousand frictions."""
    counts = (_FRICTIONS, _MANY_FRICTIONS)
    return [
        measure_sweep(name, rtol, count=count)
        for count, name, rtol in product(counts, SWEEPS, _SWEEP_TOLERANCES)
    ]


STUDIES: dict[str, Study] = {
    "solve": measure,
    "sweep": sweeps,
    "batch": lambda: [
        measure_batch(name, places) for name, places in product(SWEEPS, ("grid", "scattered"))
    ],
    "import": lambda: [ImportRow(import_ratio())],
}


if __name__ == "__main__":
    if os.environ.get("OPENBLAS_NUM_THREADS") != "1":
        print("note: set OPENBLAS_NUM_THREADS=1 to compare on one thread")
    raise SystemExit(run_studies("compare.studies.chart.benchmark", "benchmark", STUDIES))
