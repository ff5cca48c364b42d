"""Measure how the time of common jobs has changed since another commit, as ratios in one run.

``python -m docs.studies.ratios --against b6ca9fe --output docs`` runs each job of `JOBS` in that
commit and in this checkout, in turn, in processes of one thread each, and compares the best
processor times: other load on the machine slows both.  It prints the ratios and writes
speed-ratios.csv.  The exit code is 1 if a job takes more than ``--most`` times (1.25) its time
before.
"""

from __future__ import annotations

import argparse
import io
import json
import math
import os
import subprocess
import sys
import tarfile
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
FIRST = """from time import process_time as now; began = now()
import slipfront as sf; sf.solve('preloaded'); print(now() - began)"""
COMMAND = """import atexit, sys, time; atexit.register(lambda: print('', time.process_time()))
from slipfront.cli.entry import main; sys.argv[1:] = ['solve', 'preloaded']; main()"""

Found = tuple[float, float]
"""Processor seconds of a job, and the relative error that it reached, nan where it has none."""


# Jobs run in either checkout, so they use public names only and import them when they run.


def timed(run: Callable[[Any], Any], error: Callable[[Any], float] = lambda _: math.nan) -> Found:
    import slipfront as sf

    started = time.process_time()
    result = run(sf)
    return time.process_time() - started, error(result)


def estimate(answer: Any) -> float:
    """Return the error estimate of an answer, of a sweep the largest."""
    return max(one.error_estimate for one in getattr(answer, "solutions", (answer,)))


def _rate_error(answer: Any) -> float:
    """Return the L1 error of the slip rate of a step load at nodes with 0.02 < x/(c_t t) < 1.9."""
    import numpy as np

    import slipfront as sf

    own, truth = answer.interface, sf.solve(answer.scene, rtol=1e-10)
    levels = np.round(np.array([0.7, 0.8, 0.9, 1.0]) * (len(own.t) - 1)).astype(int)
    t = own.t[levels, None]
    ratio = own.x / (answer.scene.material.shear_speed * t)
    seen, exact = (ratio > 0.02) & (ratio < 1.9), truth.slip_rate(own.x, t)
    return float(np.abs(own.slip_rate[levels] - exact)[seen].sum() / np.abs(exact)[seen].sum())


def _call(function: str, name: str, error: Callable[[Any], float], **options: Any) -> Found:
    def run(sf: Any) -> Any:
        # marches were a function of their own before `solve` had methods
        march = partial(sf.solve, method="space-time")
        return getattr(sf, function, march)(sf.find(name), **options)

    return timed(run, error)


def fields(points: int) -> Found:
    import numpy as np

    import slipfront as sf

    solution = sf.solve(sf.find("preloaded"), rtol=1e-9)
    x, y = np.random.default_rng(1).uniform(-1, 1, (2, points))
    return timed(lambda _: solution.stress(x, y, 1.0), lambda _: solution.field_error)


def picture() -> Found:
    from slipfront.explore.jobs import Moment, solved_field

    def draw(sf: Any) -> Any:
        return solved_field(sf.find("preloaded"), 24, 1e-4, Moment(), lambda *_: None)

    return timed(draw)


def _fit() -> Found:
    from contextlib import redirect_stdout

    from docs.examples.fit_gauges import main

    with tempfile.TemporaryDirectory() as folder, redirect_stdout(io.StringIO()):
        return timed(lambda _: main(Path(folder)))


def process(program: str) -> Found:
    command = [sys.executable, "-c", program]
    # An installed program finds its bytecode; without it the modules are compiled in every run.
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    done = subprocess.run(command, check=True, capture_output=True, text=True, env=environment)
    return float(done.stdout.split()[-1]), math.nan


SOLVE = partial(_call, "solve", error=estimate)
_SWEEP = partial(_call, "sweep", error=estimate, friction=[n / 200 for n in range(24, 124)])
STEP = partial(_call, name="preloaded", error=_rate_error)
JOBS: Mapping[str, tuple[int, Callable[[], Found]]] = {
    "first `solve` of a process, with imports": (8, partial(process, FIRST)),
    "`slipfront solve preloaded`": (8, partial(process, COMMAND)),
    "`solve` of `preloaded` to 1e-9": (20, partial(SOLVE, "preloaded", rtol=1e-9)),
    "`solve` of `viscous` to 1e-10": (12, partial(SOLVE, "viscous", rtol=1e-10)),
    "`solve` of `tap` to 1e-9": (20, partial(SOLVE, "tap", rtol=1e-9)),
    "`sweep` of 100 scenes from `preloaded`": (6, partial(_SWEEP, "preloaded")),
    "`sweep` of 100 scenes from `remote-shock`": (6, partial(_SWEEP, "remote-shock")),
    "stress at 20,000 points": (6, partial(fields, 20_000)),
    "stress at 200,000 points": (4, partial(fields, 200_000)),
    "`explore`: coarse field at a move": (12, picture),
    "`march` with 256 nodes": (20, partial(STEP, "march", nodes=256)),
    "`march` with 1,024 nodes": (10, partial(STEP, "march", nodes=1024)),
    "`march` with 4,096 nodes": (3, partial(STEP, "march", nodes=4096)),
    "`march` of a step to 1e-3": (4, partial(STEP, "march", rtol=1e-3)),
    "`march` of a pulse to 1e-2": (4, partial(_call, "march", "pulse", estimate, rtol=1e-2)),
    "`simulate` with 100 node distances": (3, partial(STEP, "simulate", resolution=100)),
    "`fit` of three unknowns to three gauges": (3, _fit),
}
"""Jobs: how often each is run in both commits, and what runs it."""


def serving(folder: Path) -> subprocess.Popen[str]:
    """Return a process that runs jobs with the packages of a folder."""
    environment = {**os.environ, "PYTHONPATH": str(folder)}
    environment |= dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
    command = [sys.executable, "-P", str(Path(__file__).resolve()), "--serve"]
    return subprocess.Popen(command, cwd=folder, env=environment, stdin=-1, stdout=-1, text=True)


def run_job(checkout: subprocess.Popen[str], job: str) -> list[float]:
    """Have a job run once in a checkout."""
    assert checkout.stdin is not None
    assert checkout.stdout is not None
    print(job, file=checkout.stdin, flush=True)
    answer = checkout.stdout.readline()
    if not answer:
        raise SystemExit(f"{job} failed; see above.")
    return list(json.loads(answer))


def compared(jobs: Sequence[str], before: Path, now: Path) -> list[dict[str, Any]]:
    """Run jobs in two checkouts in turn, as often as `JOBS` says.

    Return best processor times before and now [s], their ratio, and the errors reached.
    """
    rows = []
    with serving(before) as one, serving(now) as other:
        for job in jobs:
            runs = [(run_job(one, job), run_job(other, job)) for _ in range(JOBS[job][0])]
            (old, was), (new, error) = map(min, zip(*runs, strict=True))
            row = {"job": job, "before": old, "now": new, "ratio": new / old}
            rows.append(row | {"error_before": was, "error_now": error})
            print(f"{job:42} {old:9.4f} s {new:9.4f} s   x {new / old:.2f}", file=sys.stderr)
    return rows


def unpacked(commit: str, folder: Path) -> None:
    """Write the files of a commit to a folder."""
    command = ["git", "-C", str(ROOT), "archive", commit]
    packed = subprocess.run(command, check=True, capture_output=True).stdout
    with tarfile.open(fileobj=io.BytesIO(packed)) as archive:
        archive.extractall(folder, filter="data")


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure the ratios; return 1 if one is above the limit."""
    parser = argparse.ArgumentParser(prog="python -m docs.studies.ratios", description=__doc__)
    parser.add_argument("--serve", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("--against", default="HEAD~1", help="commit to compare with")
    parser.add_argument("--jobs", nargs="+", choices=JOBS, default=list(JOBS), metavar="JOB")
    parser.add_argument("--most", type=float, default=1.25, help="largest ratio that passes")
    parser.add_argument("--output", type=Path, metavar="FOLDER", help="where to write; docs")
    options = parser.parse_args(arguments)
    if options.serve:
        for line in sys.stdin:
            print(json.dumps(JOBS[line.rstrip("\n")][1]()), flush=True)
        return 0
    with tempfile.TemporaryDirectory() as folder:
        unpacked(options.against, Path(folder))
        rows = compared(options.jobs, Path(folder), ROOT)
    if options.output is not None:
        from docs.studies.runner import write_table

        made = f"python -m docs.studies.ratios --against {options.against} --output docs"
        write_table(options.output / "data" / "speed-ratios.csv", rows, made)
    return int(any(row["ratio"] > options.most for row in rows))


if __name__ == "__main__":
    raise SystemExit(main())
