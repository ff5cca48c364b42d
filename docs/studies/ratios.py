"""Measure how the time of common jobs has changed since another commit, as ratios in one run.

``python -m docs.studies.ratios --against 085d239 --csv docs/data`` runs each job of `JOBS` in this
checkout and in that commit, in turn, in two processes of one thread each, and keeps the best of
several processor times: other load on the machine slows both.  It prints the ratios, writes
speed-ratios.csv and, with ``--json FILE``, the same in the form of pytest-benchmark.  The exit
code is 1 if a job takes more than ``--most`` times (1.25) its time before.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import subprocess
import sys
import tarfile
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from io import BytesIO
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
SEEN = (0.7, 0.8, 0.9, 1.0)
"""Times over T at whose nearest levels the error of the slip rate is measured."""
GOAL = 1e-4
"""Error that a step has to reach by `nodes` or by `rtol`."""
KINKED_GOAL = 1e-3
REFERENCE_NODES = 4000

Found = tuple[float, float, float]
"""Processor seconds of a job, the true relative L1 error of its slip rate, and its nodes."""


# The jobs run in either checkout, so that they import what both have, and only when they run.


def _timed(run: Callable[[], Any]) -> tuple[float, Any]:
    started = time.process_time()
    result = run()
    return time.process_time() - started, result


def _scene(name: str) -> Any:
    from dataclasses import replace

    from semianalytic import Pulse, Ramp, SlipWeakening
    from semianalytic.scene.named import find_scene

    if name == "weakening":
        return replace(find_scene("preloaded"), friction_law=SlipWeakening(0.5, 0.2))
    if name == "triangle":
        return replace(find_scene("preloaded"), shear_history=Pulse(0.8, "triangle"))
    if name == "short-ramp":
        return replace(find_scene("preloaded"), shear_history=Ramp(0.2))
    return find_scene(name)


def _error(marched: Any, truth: Any, least: float, most: float) -> float:
    """Return the L1 error of the slip rate at nodes with least < x / (c_t t) < most."""
    import numpy as np

    own, speed = marched.interface, marched.scene.material.shear_speed
    off = size = 0.0
    for share in SEEN:
        level = int(np.argmin(np.abs(own.t - share * own.t[-1])))
        x = own.x / (speed * own.t[level])
        seen = (x > least) & (x < most)
        exact = truth.slip_rate(own.x[seen], own.t[level])
        off += float(np.abs(own.slip_rate[level, seen] - exact).sum())
        size += float(np.abs(exact).sum())
    return off / size


def _step_error(marched: Any) -> float:
    from semianalytic import solve

    return _error(marched, solve(marched.scene, rtol=1e-10), 0.02, 1.9)


def _kinked_error(marched: Any) -> float:
    from semianalytic import march

    levels = max(1, REFERENCE_NODES // 400)
    truth = march(marched.scene, nodes=REFERENCE_NODES, companion=False, every=levels)
    return _error(marched, truth, 0.0, math.inf)


def _march(name: str, nodes: int, judge: bool) -> Found:
    from semianalytic import march

    seconds, marched = _timed(lambda: march(_scene(name), nodes=nodes))
    return seconds, _step_error(marched) if judge else math.nan, float(nodes)


def _fewest(judge: bool, found: dict[str, int] = {}) -> Found:  # noqa: B006  the cache is meant
    from semianalytic import march

    scene = _scene("preloaded")
    if "nodes" not in found:
        nodes = 512
        while _step_error(march(scene, nodes=nodes, companion=False)) > GOAL:
            nodes = math.ceil(1.08 * nodes)
        found["nodes"] = nodes
    seconds, marched = _timed(lambda: march(scene, nodes=found["nodes"], companion=False))
    return seconds, _step_error(marched) if judge else math.nan, float(found["nodes"])


def _within(name: str, rtol: float, judge: bool) -> Found:
    from semianalytic import march

    seconds, marched = _timed(lambda: march(_scene(name), rtol=rtol))
    error = _step_error if name == "preloaded" else _kinked_error
    return seconds, error(marched) if judge else math.nan, float(marched.grid.observed)


def _batch(name: str) -> Found:
    import numpy as np

    from semianalytic import sweep

    friction = np.linspace(0.12, 0.6, 200)
    seconds, _ = _timed(lambda: sweep(_scene(name), friction))
    return seconds / len(friction), math.nan, math.nan


def _solution(name: str, rtol: float) -> Found:
    from semianalytic import solve

    seconds, _ = _timed(lambda: solve(_scene(name), rtol=rtol))
    return seconds, math.nan, math.nan


JOBS: Mapping[str, tuple[int, Callable[[bool], Found]]] = {
    "march preloaded, 256 nodes": (25, lambda judge: _march("preloaded", 256, judge)),
    "march preloaded, 1024 nodes": (12, lambda judge: _march("preloaded", 1024, judge)),
    "march preloaded, 4096 nodes": (3, lambda judge: _march("preloaded", 4096, judge)),
    "march remote-shock, 1024 nodes": (8, lambda judge: _march("remote-shock", 1024, judge)),
    "march antiplane, 1024 nodes": (8, lambda judge: _march("antiplane", 1024, judge)),
    "step to 1e-4 by nodes": (4, _fewest),
    "step to 1e-4 by rtol": (1, lambda judge: _within("preloaded", GOAL, judge)),
    "pulse to 1e-3 by rtol": (1, lambda judge: _within("pulse", KINKED_GOAL, judge)),
    "harmonic to 1e-3 by rtol": (1, lambda judge: _within("harmonic", KINKED_GOAL, judge)),
    "weakening to 1e-3 by rtol": (1, lambda judge: _within("weakening", KINKED_GOAL, judge)),
    "ramp to 1e-3 by rtol": (1, lambda judge: _within("ramp", KINKED_GOAL, judge)),
    "sweep of 200, preloaded": (5, lambda judge: _batch("preloaded")),
    "sweep of 200, remote-shock": (5, lambda judge: _batch("remote-shock")),
    "solve viscous to 1e-10": (12, lambda judge: _solution("viscous", 1e-10)),
}
"""Jobs: how often each is run, and what runs it and, if asked, measures its true error."""


@dataclass(frozen=True)
class RatioRow:
    """Best processor times of a job before and now [s], their ratio, errors and nodes."""

    job: str
    before: float
    now: float
    ratio: float
    error_before: float
    error_now: float
    nodes_before: float
    nodes_now: float


class _Checkout:
    """A process that runs jobs with the packages of one checkout."""

    def __init__(self, folder: Path) -> None:
        environment = {**os.environ, "PYTHONPATH": str(folder)}
        environment |= dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
        command = [sys.executable, str(Path(__file__).resolve()), "--serve"]
        self._process = subprocess.Popen(
            command, cwd=folder, env=environment, stdin=-1, stdout=-1, text=True
        )

    def run(self, job: str, judge: bool) -> Found:
        """Run a job once."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        print(json.dumps([job, judge]), file=self._process.stdin, flush=True)
        answer = self._process.stdout.readline()
        if not answer:
            raise SystemExit(f"{job} failed; see above.")
        return tuple(json.loads(answer))

    def close(self) -> None:
        """End the process."""
        assert self._process.stdin is not None
        self._process.stdin.close()
        self._process.wait()


def _serve() -> None:
    """Run the jobs named on standard input."""
    for line in sys.stdin:
        job, judge = json.loads(line)
        print(json.dumps(JOBS[job][1](judge)), flush=True)


def compared(jobs: Sequence[str], before: Path, now: Path, times: float = 1.0) -> list[RatioRow]:
    """Run jobs in two checkouts, in turn.

    Parameters
    ----------
    jobs : sequence of str
        Keys of `JOBS`.
    before, now : Path
        Folders of the checkouts.
    times : float
        Factor on the number of runs of each job.
    """
    both, rows = [_Checkout(before), _Checkout(now)], []
    for job in jobs:
        runs: list[list[Found]] = [[], []]
        for turn in range(max(1, round(times * JOBS[job][0]))):
            for one, checkout in zip(runs, both, strict=True):
                one.append(checkout.run(job, turn == 0))
        (old, new) = (min(run[0] for run in one) for one in runs)
        errors, nodes = ([one[0][at] for one in runs] for at in (1, 2))
        rows.append(RatioRow(job, old, new, new / old, *errors, *nodes))
        print(f"{job:34} {old:9.4f} s {new:9.4f} s   x {new / old:.2f}", file=sys.stderr)
    for checkout in both:
        checkout.close()
    return rows


def as_benchmarks(rows: Sequence[RatioRow], against: str) -> dict[str, Any]:
    """Return rows in the form that pytest-benchmark writes, with the ratios as extra information."""
    return {
        "against": against,
        "benchmarks": [
            {"name": row.job, "stats": {"min": row.now}, "extra_info": asdict(row)} for row in rows
        ],
    }


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure the ratios; return 1 if one is above the limit."""
    parser = argparse.ArgumentParser(prog="python -m docs.studies.ratios", description=__doc__)
    parser.add_argument("--serve", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("--against", default="HEAD~1", help="commit to compare with")
    parser.add_argument("--jobs", nargs="+", choices=JOBS, default=list(JOBS), metavar="JOB")
    parser.add_argument("--times", type=float, default=1.0, help="factor on the number of runs")
    parser.add_argument("--most", type=float, default=1.25, help="largest ratio that passes")
    parser.add_argument("--csv", type=Path, metavar="DIR", help="folder to write to; docs/data")
    parser.add_argument("--json", type=Path, metavar="FILE")
    options = parser.parse_args(arguments)
    if options.serve:
        _serve()
        return 0
    from compare.output.tables import write_rows

    command = ["git", "-C", str(ROOT), "archive", options.against]
    packed = subprocess.run(command, check=True, capture_output=True).stdout
    with tempfile.TemporaryDirectory() as folder:
        with tarfile.open(fileobj=BytesIO(packed)) as archive:
            archive.extractall(folder, filter="data")
        rows = compared(options.jobs, Path(folder), ROOT, options.times)
    if options.csv is not None:
        made = f"python -m docs.studies.ratios --against {options.against} --csv docs/data"
        write_rows(options.csv / "speed-ratios.csv", rows, command=made)
    if options.json is not None:
        options.json.write_text(json.dumps(as_benchmarks(rows, options.against), indent=1))
    return int(any(row.ratio > options.most for row in rows))


if __name__ == "__main__":
    raise SystemExit(main())
