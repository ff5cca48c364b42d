"""Times of common jobs in this checkout and in a commit: ``python -m docs.studies.speed COMMIT``.

Each job runs in both checkouts in turn, in one process of one thread each, and the least processor
times are compared: other load on the machine slows both.  ``--output docs`` writes the jobs with a
goal into data/speed.csv.
"""

from __future__ import annotations

import argparse
import io
import json
import os
import subprocess
import sys
import tarfile
import tempfile
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np

import slipfront as sf

ROOT = Path(__file__).resolve().parents[2]
# Jobs run in either checkout: they use public names, and import others when they run.


def timed(run: Callable[[], object]) -> float:
    """Return the processor seconds of a call."""
    began = time.process_time()
    run()
    return time.process_time() - began


def solved(name: str, **options: Any) -> float:
    """Solve a scene by its name."""
    return timed(lambda: sf.solve(name, **options))


@cache
def _warm(name: str) -> None:
    swept(name, 20)


def swept(name: str, side: int) -> float:
    """Return milliseconds a scene of a sweep of a plane to 1e-6, after a small one."""
    if side > 20:
        _warm(name)
    friction = np.linspace(*((0.9, 1.3) if name == "remote-shock" else (0.2, 0.6)), side)
    ratio = np.linspace(0.1, 0.45, side)[:, None]
    return timed(lambda: sf.sweep(name, friction, 1e-6, poisson_ratio=ratio)) * 1e3 / side**2


def stress(points: int) -> float:
    """Return seconds of stress at points, with the cells that a first call forms."""
    solution = sf.solve("preloaded", rtol=1e-9)
    x, y = np.random.default_rng(1).uniform(-1, 1, (2, points))
    return timed(lambda: solution.stress(x, y, 1.0))


def picture(name: str) -> float:
    """Solve a scene and draw its coarse field, as `explore` does at a move of a slider."""
    from slipfront.explore.jobs import Moment, solved_field

    return timed(lambda: solved_field(sf.find(name), 24, 1e-4, Moment(), lambda *_: None))


def fitted() -> float:
    """Fit three unknowns to three gauges."""
    from docs.examples.fit_gauges import fitted

    return timed(fitted)


def timed_with_children(run: Callable[[], object]) -> float:
    """Return the processor seconds of a call and of the processes that it starts."""
    import resource  # not on Windows, where nothing else here lacks

    def seconds() -> float:
        of = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
        return sum(sum(resource.getrusage(who)[:2]) for who in of)

    began = seconds()
    run()
    return seconds() - began


def commanded(*arguments: str) -> float:
    """Run a command as a user does, in a process of its own that imports what it needs."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "slipfront", *arguments, "--output", f"{folder}/it"]
        run = partial(subprocess.run, [*command, "--quiet"], stdout=subprocess.DEVNULL, check=True)
        return timed_with_children(run)


def least_ratio(run: Callable[[], float], other: Callable[[], float]) -> float:
    """Return the least time of one run over that of another, of four in turn."""
    times = [(run(), other()) for _ in range(4)]
    least, of_other = map(min, zip(*times, strict=True))
    return least / of_other


def snapshots() -> float:
    """Return the time of a comparison that keeps snapshots over that of one without."""
    kept = partial(commanded, "compare", "preloaded")
    return least_ratio(kept, partial(kept, "--no-snapshots"))


def surveyed(workers: int) -> float:
    """Return the processor seconds of a survey of 10,000 scenes and its processes, after a small
    one, whose imports one process needs as well as two."""
    sf.survey("preloaded", rtol=1e-6, friction=[0.2, 0.6], workers=1)
    friction, ratio = np.linspace(0.2, 0.6, 100), np.linspace(0.1, 0.45, 100)
    axes: Mapping[str, Any] = {"friction": friction, "poisson_ratio": ratio}
    return timed_with_children(lambda: sf.survey("preloaded", rtol=1e-6, workers=workers, **axes))


@dataclass(frozen=True)
class Job:
    """A timed job: the function that returns its seconds, repeats in both checkouts, and goal.

    The goal is one of the job itself, or a share of its time before; `limit` is the profile that
    shows what a job that misses it is at.
    """

    run: Callable[[], float]
    repeats: int
    goal: float | None = None
    of_before: bool = False
    limit: str = ""


MARCH: Mapping[str, Any] = {"method": "space-time"}
SWEEPS: Mapping[str, str] = {
    "remote-shock": "Cauchy sums 23 %, panels 9 %, M_+ 7 %, stencils 6 %; nothing else above 5 %",
    "preloaded": "Newton's method 22 %, chord steps 14 %",
}
"""Scenes that are swept, and where their time goes."""
PAIRS = "equations 54 %, tractions off the zones 27 %"
MOVES = "cells of the field 25 to 55 %"
JOBS: Mapping[str, Job] = {
    **{
        f"`sweep` of {side**2:,} from `{name}` [ms a scene]": Job(
            partial(swept, name, side), repeats, 0.55, of_before=True, limit=SWEEPS[name]
        )
        for side, repeats in ((50, 4), (100, 3))
        for name in SWEEPS
    },
    "`survey` of 10,000: work of two processes over one": Job(
        lambda: least_ratio(partial(surveyed, 2), partial(surveyed, 1)),
        1,
        1.11,
        limit="imports and tables of each process",
    ),
    "`compare preloaded`: with snapshots over without": Job(
        snapshots,
        1,
        1.8,
        limit="of the difference: writing 29 %, reading 18 %, exact fields 11 %, pictures 10 %",
    ),
    "stress at 200,000 points": Job(
        partial(stress, 200_000), 4, 0.2, limit="44 % forms cells, which later calls share"
    ),
    "`fit` of three unknowns to three gauges": Job(
        fitted, 5, 1.0, limit="solutions 36 %, slip at gauges 25 %, derivatives 17 %"
    ),
    **{
        f"`solve` of `{name}` to 1e-8": Job(partial(solved, name), 8, 0.05, limit=PAIRS)
        for name in ("pair-slip", "pair-opening")
    },
    **{
        f"`explore`: a move, `{name}`": Job(partial(picture, name), 8, 0.05, limit=MOVES)
        for name in ("preloaded", "pair-slip", "pair-opening")
    },
    "`solve` of `preloaded` to 1e-8": Job(partial(solved, "preloaded"), 10),
    "`solve` of `viscous` to 1e-10": Job(partial(solved, "viscous", rtol=1e-10), 8),
    **{
        f"march of `preloaded`, {nodes:,} nodes": Job(
            partial(solved, "preloaded", nodes=nodes, **MARCH), repeats
        )
        for nodes, repeats in ((256, 6), (1024, 3), (4096, 1))
    },
    "march of `pulse` to 1e-2": Job(partial(solved, "pulse", rtol=1e-2), 5),
    "march of `tpv205`, 512 nodes": Job(partial(solved, "tpv205", nodes=512), 4),
}


def row(name: str, before: float, now: float) -> dict[str, str]:
    """Return the line of a job in the table; of a goal that is missed, what limits it."""
    job = JOBS[name]
    goal = job.goal and job.goal * (before if job.of_before else 1.0)
    numbers = {"before": before, "now": now, "ratio": now / before, "goal": goal}
    texts = {key: "" if value is None else f"{value:.3g}" for key, value in numbers.items()}
    return {"job": name, **texts, "met": "" if not goal else "yes" if now <= goal else job.limit}


def serving(folder: Path) -> subprocess.Popen[str]:
    """Return a process that runs jobs with the packages of a folder."""
    threads = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
    environment = {**os.environ, "PYTHONPATH": str(folder), **threads}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)  # users' commands compile files once only
    command = [sys.executable, "-P", str(Path(__file__).resolve()), "--serve"]
    return subprocess.Popen(command, cwd=folder, env=environment, stdin=-1, stdout=-1, text=True)


def run_job(process: subprocess.Popen[str], job: str) -> float:
    """Have a job run once in a checkout."""
    assert process.stdin is not None
    assert process.stdout is not None
    print(job, file=process.stdin, flush=True)
    for line in process.stdout:
        if line.startswith("seconds "):  # commands print lines of their own
            return float(json.loads(line.removeprefix("seconds ")))
    raise SystemExit(f"{job} failed; see above.")


def main() -> None:
    """Measure the jobs in both checkouts, or serve one."""
    parser = argparse.ArgumentParser(prog="python -m docs.studies.speed", description=__doc__)
    parser.add_argument("commit", nargs="?", default="HEAD~1", help="commit to compare with")
    parser.add_argument("--jobs", default="", help="only jobs whose names hold this")
    parser.add_argument("--output", type=Path, help="folder with data/speed.csv, to be written")
    parser.add_argument("--serve", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.serve:
        for line in sys.stdin:
            print("\nseconds", json.dumps(JOBS[line.rstrip("\n")].run()), flush=True)
        return
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        packed = subprocess.check_output(["git", "-C", str(ROOT), "archive", options.commit])
        with tarfile.open(fileobj=io.BytesIO(packed)) as archive:
            archive.extractall(folder, filter="data")
        with serving(Path(folder)) as server, serving(ROOT) as other:
            for name in (name for name in JOBS if options.jobs in name):
                times = range(JOBS[name].repeats)
                pairs = [(run_job(server, name), run_job(other, name)) for _ in times]
                before, now = map(min, zip(*pairs, strict=True))
                rows.append(row(name, before, now))
                print("|", " | ".join(rows[-1].values()), "|", flush=True)
    if options.output:
        from docs.studies.runner import write_table

        command = f"python -m docs.studies.speed {options.commit}"
        aimed = [line for line in rows if line["goal"]]
        write_table(options.output / "data" / "speed.csv", aimed, command)


if __name__ == "__main__":
    main()
