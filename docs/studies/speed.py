"""Times of common jobs in this checkout and in a commit: ``python -m docs.studies.speed COMMIT``.

Each job runs in both checkouts in turn, in one process of one thread each, and the least processor
times are compared: other load on the machine slows both.
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


def commanded(*arguments: str) -> float:
    """Run a command in this process."""
    from slipfront.cli.commands import main

    with tempfile.TemporaryDirectory() as folder:
        every = [*arguments, "--output", f"{folder}/it", "--quiet"]
        return timed(lambda: main(every))


MARCH: Mapping[str, Any] = {"method": "space-time"}
JOBS: Mapping[str, tuple[int, Callable[[], float]]] = {
    "`sweep` of 2,500 from `remote-shock` [ms a scene]": (4, partial(swept, "remote-shock", 50)),
    "`sweep` of 2,500 from `preloaded` [ms a scene]": (4, partial(swept, "preloaded", 50)),
    "`sweep` of 10,000 from `remote-shock` [ms a scene]": (1, partial(swept, "remote-shock", 100)),
    "`sweep` of 10,000 from `preloaded` [ms a scene]": (1, partial(swept, "preloaded", 100)),
    "`compare preloaded`, snapshots kept": (2, partial(commanded, "compare", "preloaded")),
    "`compare preloaded` without": (
        3,
        partial(commanded, "compare", "preloaded", "--no-snapshots"),
    ),
    "stress at 200,000 points": (6, partial(stress, 200_000)),
    "`fit` of three unknowns to three gauges": (5, fitted),
    "`solve` of `pair-slip` to 1e-8": (20, partial(solved, "pair-slip")),
    "`solve` of `pair-opening` to 1e-8": (20, partial(solved, "pair-opening")),
    "`explore`: a move, `preloaded`": (20, partial(picture, "preloaded")),
    "`explore`: a move, `pair-slip`": (20, partial(picture, "pair-slip")),
    "`explore`: a move, `pair-opening`": (20, partial(picture, "pair-opening")),
    "`solve` of `preloaded` to 1e-8": (30, partial(solved, "preloaded")),
    "`solve` of `viscous` to 1e-10": (20, partial(solved, "viscous", rtol=1e-10)),
    "march of `preloaded`, 256 nodes": (15, partial(solved, "preloaded", nodes=256, **MARCH)),
    "march of `preloaded`, 1,024 nodes": (6, partial(solved, "preloaded", nodes=1024, **MARCH)),
    "march of `preloaded`, 4,096 nodes": (1, partial(solved, "preloaded", nodes=4096, **MARCH)),
    "march of `pulse` to 1e-2": (4, partial(solved, "pulse", rtol=1e-2)),
    "march of `tpv205`, 512 nodes": (3, partial(solved, "tpv205", nodes=512)),
}
"""Jobs: how often each runs in both checkouts, and what returns its seconds."""


def serving(folder: Path) -> subprocess.Popen[str]:
    """Return a process that runs jobs with the packages of a folder."""
    threads = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
    environment = {**os.environ, "PYTHONPATH": str(folder), **threads}
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
    parser.add_argument("--serve", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.serve:
        for line in sys.stdin:
            print("\nseconds", json.dumps(JOBS[line.rstrip("\n")][1]()), flush=True)
        return
    with tempfile.TemporaryDirectory() as folder:
        packed = subprocess.check_output(["git", "-C", str(ROOT), "archive", options.commit])
        with tarfile.open(fileobj=io.BytesIO(packed)) as archive:
            archive.extractall(folder, filter="data")
        with serving(Path(folder)) as server, serving(ROOT) as other:
            for job in (name for name in JOBS if options.jobs in name):
                pairs = [(run_job(server, job), run_job(other, job)) for _ in range(JOBS[job][0])]
                before, now = map(min, zip(*pairs, strict=True))
                print(f"| {job} | {before:.2g} | {now:.2g} | {now / before:.2f} |", flush=True)


if __name__ == "__main__":
    main()
