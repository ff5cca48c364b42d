"""Measure where the goals of speed stand: processor times of this checkout, with the errors.

``python -m docs.studies.goals --csv docs/data`` measures the rows of `GOALS` in a process of one
thread, and writes speed-goals.csv.  Rows that ``--rows`` does not name are kept as they were.
Ratios within a row survive other load on the machine; seconds and the survey on two processes need
a quiet one.

The goals in seconds were set on another machine.  ``--pace COMMIT`` takes jobs whose seconds there
are known from the same time, runs them here with the code of that commit, and writes
speed-pace.csv; goals are met or missed after multiplication by the median of these ratios.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import redirect_stdout
from dataclasses import dataclass, replace
from functools import cache, partial
from io import StringIO
from pathlib import Path

import numpy as np

import slipfront as sf
from compare.output.tables import write_rows
from docs.studies import ratios
from docs.studies.accuracy.march_error import rate_error
from docs.studies.pages import DATA, read_data

FILE, PACE = "speed-goals", "speed-pace"
SECONDS_THEN: Mapping[str, float] = {
    "`solve` of `preloaded` to 1e-9": 0.0066,
    "`solve` of `viscous` to 1e-10": 0.056,
    "`march` with 256 nodes": 0.049,
    "`march` with 1,024 nodes": 0.42,
}
"""Seconds of jobs of `ratios` on the machine on which the goals were set, with the code of then."""
Found = ratios.Found

FIRST = """import numpy, slipfront as sf; from time import process_time as now
scene = sf.find_scene('preloaded'); sf.solve; began = now()
sf.solve(scene); print(now() - began)"""
KINKED: Mapping[str, sf.Scene] = {
    "a pulse": sf.find_scene("pulse"),
    "a harmonic": sf.find_scene("harmonic"),
    "a reversal": sf.find_scene("unload"),
    "slip weakening": replace(sf.find_scene("preloaded"), friction_law=sf.SlipWeakening(0.5, 0.1)),
}
"""Scenes whose loads or laws have kinks or jumps."""


def _least(run: Callable[[], Found], times: int) -> Found:
    """Return the best of several runs."""
    return min(run() for _ in range(times))


def _spent(run: Callable[[], object]) -> float:
    began = time.process_time()
    run()
    return time.process_time() - began


@cache
def _comparison() -> tuple[float, float]:
    """Return the seconds of `compare preloaded`, and the ratio of those announced and taken."""
    from compare.comparison.comparing import planned
    from slipfront.cli.commands import main

    announced = planned(sf.find_scene("preloaded"), snapshots=True)[1].seconds
    began = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder, redirect_stdout(StringIO()):
        took = _spent(lambda: main(["compare", "preloaded", "--output", f"{folder}/it", "--quiet"]))
    ratio = (time.perf_counter() - began) / announced
    return took, max(ratio, 1 / ratio)


def _marched(nodes: int) -> Found:
    return _least(partial(ratios.STEP, "march", nodes=nodes), 3)


def _cheapest() -> Found:
    """Return the cheapest march of a step whose true error is below 1e-4."""
    for nodes in (768, 896, 1024, 1152, 1280, 1408, 1536, 2048):
        if ratios.STEP("march", nodes=nodes)[1] <= 1e-4:
            return _marched(nodes)
    raise AssertionError("2,048 nodes miss 1e-4")


def _whole_error(marched: sf.Marched) -> float:
    """Return the L1 error of the slip rate over all time and the contact, as `rtol` means it."""
    return rate_error(marched, sf.solve(marched.scene, rtol=1e-10))


def _by_tolerance() -> Found:
    """Return the time of a march to 1e-4 over that of the cheapest one by nodes, and its error.

    Both errors are those of the whole history, which the estimate bounds.
    """
    scene = sf.find_scene("preloaded")
    for nodes in (1664, 1920, 2176, 2432, 2816):
        if _whole_error(sf.march(scene, nodes=nodes)) <= 1e-4:
            cheapest = _least(partial(ratios.STEP, "march", nodes=nodes), 2)[0]
            took, error = ratios.timed(lambda _: sf.march(scene, rtol=1e-4), _whole_error)
            return took / cheapest, error
    raise AssertionError("2,816 nodes miss 1e-4")


def _kinked(scene: sf.Scene) -> Found:
    return ratios.timed(lambda _: sf.march(scene, rtol=1e-3), ratios.estimate)


def _grown(many: int = 4096, few: int = 1024) -> Found:
    """Return the exponent by which the time of a march grows with its nodes."""
    scene = sf.find_scene("preloaded")
    least = min(_spent(lambda: sf.march(scene, nodes=few)) for _ in range(3))
    return math.log(_spent(lambda: sf.march(scene, nodes=many)) / least) / math.log(
        many / few
    ), math.nan


def _swept(name: str, side: int = 100) -> Found:
    """Return the milliseconds per scene of a sweep of a plane to 1e-6."""
    low, high = {"preloaded": (0.05, 1.0), "remote-shock": (1.05, 1.5)}[name]  # across thresholds
    friction = np.tile(np.linspace(low, high, side), side)
    ratio = np.repeat(np.linspace(0.0, 0.45, side), side)
    took, error = ratios.timed(
        lambda _: sf.sweep(sf.find_scene(name), friction, 1e-6, poisson_ratio=ratio),
        ratios.estimate,
    )
    return 1e3 * took / side**2, error


def _surveyed() -> Found:
    """Return how many times faster a survey on two processes is, by the clock."""
    spent: dict[int, float] = {}
    for workers in (1, 2, 1, 2):
        began = time.perf_counter()
        friction, ratio = np.linspace(0.1, 0.9, 60), np.linspace(0.1, 0.45, 60)
        scene = sf.find_scene("preloaded")
        sf.survey(scene, workers=workers, friction=friction, poisson_ratio=ratio)
        took = time.perf_counter() - began
        spent[workers] = min(took, spent.get(workers, math.inf))
    return spent[1] / spent[2], math.nan


def _fields(points: int = 200_000) -> Found:
    """Return the points per second of stress to 1e-9, tables of a first call included."""
    took, error = ratios.fields(points)
    return points / took, error


def _moved() -> Found:
    """Return the milliseconds of the coarse field that `explore` draws at a move of a slider."""
    return _least(lambda: (1e3 * ratios.picture()[0], math.nan), 10)


def _products() -> Found:
    """Return the share of matrix products in a simulation."""
    import cProfile
    import pstats

    profile = cProfile.Profile()
    profile.runcall(sf.simulate, sf.find_scene("preloaded"), resolution=100)
    stats = pstats.Stats(profile).get_stats_profile()
    products = sum(one.tottime for name, one in stats.func_profiles.items() if "csr_matvec" in name)
    return products / stats.total_tt, math.nan


@cache
def _fit() -> tuple[float, int]:
    """Return the seconds of a fit of three unknowns, and the number of its solutions."""
    from docs.examples.fit_gauges import fitted

    began = time.process_time()
    fit = fitted()
    return time.process_time() - began, fit.solutions


@dataclass(frozen=True)
class Goal:
    """A goal of speed.

    Attributes
    ----------
    unit : str
        Unit of the numbers, or what they are the ratio of.
    then, goal : float
        Value when the goal was set (on another machine), and the goal.
    run : callable
        Measures the value now, and the error reached.
    more : bool
        Whether more is better.
    """

    unit: str
    then: float
    goal: float
    run: Callable[[], Found]
    more: bool = False

    def here(self, pace: float) -> float:
        """Return the goal on a machine that takes `pace` times as long for the same work."""
        if self.unit == "points/s":
            return self.goal / pace
        return self.goal * pace if self.unit in ("s", "ms", "ms/scene") else self.goal


GOALS: Mapping[str, Goal] = {
    "first `solve` of a process, without imports": Goal(
        "s", 0.114, 0.03, lambda: _least(partial(ratios.process, FIRST), 8)
    ),
    "`slipfront solve preloaded`": Goal(
        "s", 0.57, 0.3, lambda: _least(partial(ratios.process, ratios.COMMAND), 8)
    ),
    "`solve` of `viscous` to 1e-10": Goal(
        "s", 0.056, 0.02, lambda: _least(partial(ratios.SOLVE, "viscous", rtol=1e-10), 12)
    ),
    "stress at 200,000 points to 1e-9": Goal("points/s", 2.5e5, 1e6, _fields, more=True),
    "`explore`: coarse field at a move": Goal("ms", 87, 40, _moved),
    "`sweep` of 10,000 scenes from `preloaded`": Goal(
        "ms/scene", 0.55, 0.3, partial(_swept, "preloaded")
    ),
    "`sweep` of 10,000 scenes from `remote-shock`": Goal(
        "ms/scene", 1.41, 0.7, partial(_swept, "remote-shock")
    ),
    "survey on two processes": Goal("times faster", 1.44, 1.8, _surveyed, more=True),
    "`march` with 256 nodes": Goal("s", 0.049, 0.02, partial(_marched, 256)),
    "`march` with 1,024 nodes": Goal("s", 0.42, 0.17, partial(_marched, 1024)),
    "cheapest `march` of a step with a true error of 1e-4": Goal("s", 0.40, 0.15, _cheapest),
    "`march` of a step to `rtol=1e-4` over the cheapest": Goal("times", 57, 3, _by_tolerance),
    **{
        f"`march` of {name} to `rtol=1e-3`": Goal("s", math.nan, 1, partial(_kinked, scene))
        for name, scene in KINKED.items()
    },
    "growth of a march from 1,024 to 4,096 nodes": Goal("exponent", 1.88, 1.6, _grown),
    "`compare preloaded`, snapshots kept": Goal("s", 20.4, 6, lambda: (_comparison()[0], math.nan)),
    "`compare preloaded`: announced and taken, ratio": Goal(
        "times", 2.1, 1.2, lambda: (_comparison()[1], math.nan)
    ),
    "share of matrix products in `simulate`": Goal("of its time", 0.40, 0.18, _products),
    "`fit` of three unknowns to three gauges": Goal("s", 2.0, 1, lambda: (_fit()[0], math.nan)),
    "solutions of that fit": Goal("solutions", 206, 100, lambda: (_fit()[1], math.nan)),
}
"""Goals by job."""


@dataclass(frozen=True)
class GoalRow:
    """A goal, where it stands now with the error reached, and whether it is met.

    `here` is the goal on this machine.
    """

    job: str
    unit: str
    then: float
    goal: float
    here: float
    now: float
    error: float
    met: str


@dataclass(frozen=True)
class PaceRow:
    """Seconds of a job with the code of then, on the machine of then and on this one."""

    job: str
    then: float
    here: float
    ratio: float


def paced(commit: str, times: int = 6) -> list[PaceRow]:
    """Run the jobs of `SECONDS_THEN` with the code of a commit."""
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        ratios.unpacked(commit, Path(folder))
        with ratios.serving(Path(folder)) as process:
            for job, then in SECONDS_THEN.items():
                here = min(ratios.run_job(process, job)[0] for _ in range(times))
                rows.append(PaceRow(job, then, here, here / then))
    return rows


def pace_of(folder: Path) -> float:
    """Return the median ratio of speed-pace.csv of a folder, or 1 without one."""
    if not (folder / f"{PACE}.csv").exists():
        return 1.0
    return float(np.median([float(row["ratio"]) for row in read_data(PACE, folder)[1]]))


def judged(job: str, now: float, error: float, pace: float) -> GoalRow:
    """Return the row of a job that was measured."""
    goal = GOALS[job]
    here = goal.here(pace)
    met = "yes" if (now >= here if goal.more else now <= here) else "no"
    return GoalRow(job, goal.unit, goal.then, goal.goal, here, now, error, met)


def kept(folder: Path, pace: float) -> dict[str, GoalRow]:
    """Return the rows that are in a folder already."""
    if not (folder / f"{FILE}.csv").exists():
        return {}
    known = [row for row in read_data(FILE, folder)[1] if row["job"] in GOALS]
    return {
        row["job"]: judged(row["job"], float(row["now"]), float(row["error"]), pace)
        for row in known
    }


def main(arguments: Sequence[str] | None = None) -> None:
    """Measure rows, and write them after each."""
    parser = argparse.ArgumentParser(prog="python -m docs.studies.goals", description=__doc__)
    parser.add_argument("--serve", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("--rows", nargs="+", choices=GOALS, default=list(GOALS), metavar="JOB")
    parser.add_argument("--csv", type=Path, metavar="FOLDER", default=DATA, help="docs/data")
    parser.add_argument("--pace", metavar="COMMIT", help="measure the pace of this machine alone")
    options = parser.parse_args(arguments)
    if options.serve:
        for line in sys.stdin:
            print(json.dumps(GOALS[line.rstrip("\n")].run()), flush=True)
        return
    if options.pace is not None:
        made = f"python -m docs.studies.goals --pace {options.pace} --csv docs/data"
        write_rows(options.csv / f"{PACE}.csv", paced(options.pace), command=made)
        options.rows = []
    pace, made = pace_of(options.csv), "python -m docs.studies.goals --csv docs/data"
    rows = kept(options.csv, pace)
    command = [sys.executable, "-m", "docs.studies.goals", "--serve"]
    environment = os.environ | dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
    with subprocess.Popen(command, stdin=-1, stdout=-1, text=True, env=environment) as process:
        for job in options.rows:
            now, error = ratios.run_job(process, job)
            rows[job] = row = judged(job, now, error, pace)
            print(f"{job:60} {row.now:9.4g} {row.unit}, goal {row.here:.2g}", file=sys.stderr)
            _write(options.csv, rows, made)
    _write(options.csv, rows, made)


def _write(folder: Path, rows: Mapping[str, GoalRow], made: str) -> None:
    there = [rows[one] for one in GOALS if one in rows]
    write_rows(folder / f"{FILE}.csv", there, command=made)


if __name__ == "__main__":
    main()
