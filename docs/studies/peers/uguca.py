"""TPV101 and a patch between rock and gouge against UGUCA, with set-up and stepping told apart.

``python -m docs.studies.peers.uguca FIELDS DEFAULT FAST [CASE]`` writes docs/data/peers-uguca.csv
and rows of docs/data/peers.csv, of both cases or of one.  FIELDS is a checkout of
github.com/chunhuizhao478/uguca_scec at commit 1db9efb, whose published fields are read; DEFAULT and
FAST are folders with two programs each, built with the flags that UGUCA gives and with those of the
machine: TPV101-2d of that checkout, and `bimat NODES STEP [once]`, which sets the named interface
`rock-on-gouge` in UGUCA's BimatInterface and dumps its fields 20 times.  None of this is part of
this package.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import semianalytic as sf
from compare.output.tables import write_rows
from docs.studies.peers.rows import (
    DATA,
    Array,
    Row,
    off,
    replace_rows,
    rounded,
    rows_in,
    seconds_of,
)
from docs.studies.uguca import FRAMES, theirs

COMMAND = "python -m docs.studies.peers.uguca FIELDS DEFAULT FAST"
COSTS = DATA / "peers-uguca.csv"
BUILDS = ("default", "fast")
OURS = "slipfront"
THEIRS = (1440, 2880)
OURS_NODES = (360, 720, 1440)
STEP_RATIO = 0.5
"""Our c_t dt / h.  On 720 and 1,440 nodes the slip rate is off by 5.2 and 1.7 % with 0.35, by 3.1
and 1.2 % with 0.5, and by 3.2 and 1.1 % with 0.6, from 0.068 and 0.012 to 0.17 and 0.033 % in slip.
Theirs is the 0.35 of the published fields."""
REPEATS = 3
"""Runs of each program, of which the least seconds count: other work may slow one by half."""
TPV101 = {"slip": "slip", "slip_rate": "slip rate"}
BIMAT = {"slip": 0.0, "slip rate": 0.0, "shear traction": 3e6, "pressure": 10e6}
"""Fields of `rock-on-gouge`, and what is there before the patch; it has begun at t = 0."""
SHORT = 1e-9
"""Share of a run after which ours is ended, to time what comes before the steps."""


@dataclass(frozen=True)
class Cost:
    """Seconds of the processor that one run takes before its steps and in them, and its errors.

    Errors are relative, in L1, to the limit that UGUCA's own two grids of TPV101 point to; those of
    `rock-on-gouge` are in docs/data/peers.csv.
    """

    case: str
    code: str
    nodes: int
    slip: float | None
    slip_rate: float | None
    setup: float
    stepping: float


def their_cost(program: Path, whole: list[str], once: list[str], here: Path) -> tuple[float, float]:
    """Return the seconds of a program before its steps and in them, from a run with one step."""
    setup, steps = (
        min(seconds_of([program.resolve(), *line], here) for _ in range(REPEATS))
        for line in (once, whole)
    )
    return setup, max(steps - setup, 0.0)


def our_cost(run: Callable[[float], sf.Run], end: float) -> tuple[sf.Run, float, float]:
    """Return a run, and its seconds before its steps and in them.

    The memory is fitted in the first run of a process alone, which is the set-up; the short run is
    repeated to take it off the whole one.
    """

    def seconds(until: float) -> float:
        began = time.process_time()
        run(until)
        return time.process_time() - began

    setup = seconds(SHORT * end)
    short, whole = (min(seconds(until) for _ in range(REPEATS)) for until in (SHORT * end, end))
    return run(end), setup, max(whole - short, 0.0)


def tpv101(fields: Path, builds: dict[str, Path]) -> Iterator[tuple[Cost, dict[str, Array]]]:
    """Yield what TPV101 costs, and the fields at x >= 0 on 721 nodes or fewer."""
    limit = {name: 2 * theirs(fields, 2880, name) - theirs(fields, 1440, name) for name in TPV101}
    found = sf.find("tpv101")
    every = 20 * 0.35 * 50 / found.interface.material.shear_speed
    times = [every * k for k in range(FRAMES)]

    def ours(nodes: int) -> tuple[sf.Run, float, float]:
        def run(end: float) -> sf.Run:
            stored = [one for one in times if one <= end]
            return sf.solve(
                found.interface,
                end_time=end,
                nodes=nodes,
                step_ratio=STEP_RATIO,
                times=stored,
                estimate=False,
            )

        return our_cost(run, times[-1])

    for nodes in THEIRS:
        values = {name: theirs(fields, nodes, name) for name in TPV101}
        errors = [_apart(values[name], limit[name]) for name in TPV101]
        for build, folder in builds.items():
            grid = ["-N", str(nodes)]
            with tempfile.TemporaryDirectory() as scratch:
                once = [*grid, "-T", "1e-3"]
                costs = their_cost(folder / "TPV101-2d", grid, once, Path(scratch))
            yield _cost("tpv101", f"UGUCA, {build} build", nodes, errors, costs), values
    for nodes in OURS_NODES:
        done, *seconds = ours(nodes)
        values = {name: getattr(done, name)[:, :: max(1, nodes // 1440)] for name in TPV101}
        errors = [_apart(values[name], limit[name]) for name in TPV101]
        yield _cost("tpv101", OURS, nodes, errors, seconds), values


def _apart(one: Array, other: Array) -> float:
    """Return the difference of two fields at x >= 0 on the nodes of the coarser grid.

    One of them may have the node at the end of the period, which is left out.
    """
    first, second = one.shape[1], other.shape[1]
    one, other = (
        one[:, :: max(1, round(first / second))],
        other[:, :: max(1, round(second / first))],
    )
    count = min(one.shape[1], other.shape[1])
    return off(one[:, :count], other[:, :count])


def bimat(builds: dict[str, Path]) -> Iterator[tuple[Cost, dict[str, Array]]]:
    """Yield what `rock-on-gouge` costs, and its fields on 256 nodes; tractions are changes."""
    found = sf.find("rock-on-gouge")
    fault, end = found.interface, found.end_time
    times = [end * k / 20 for k in range(21)]
    for nodes in (512, 1024):
        stride = nodes // 256
        for build, folder in builds.items():
            with tempfile.TemporaryDirectory() as scratch:
                here = Path(scratch)
                line = [str(nodes), "0.35"]
                costs = their_cost(folder / "bimat", line, [*line, "once"], here)
                values = _dumped(here / f"bimat_{nodes}-DataFiles", nodes)
            yield _cost("rock-on-gouge", f"UGUCA, {build} build", nodes, None, costs), values

        def run(until: float, nodes: int = nodes) -> sf.Run:
            stored = [one for one in times if one <= until]
            return sf.solve(fault, end_time=until, nodes=nodes, times=stored, estimate=False)

        done, *seconds = our_cost(run, end)
        fields = (done.slip, done.slip_rate, done.shear_traction, done.pressure)
        values = {
            name: (field - BIMAT[name])[1:, ::stride]
            for name, field in zip(BIMAT, fields, strict=True)
        }
        yield _cost("rock-on-gouge", OURS, nodes, None, seconds), values


def _dumped(folder: Path, nodes: int) -> dict[str, Array]:
    def read(name: str) -> Array:
        raw = np.fromfile(folder / f"{name}.out", dtype="<f4").reshape(-1, nodes)
        return raw[:, :: nodes // 256].astype(float)

    fields = {
        "slip": read("top_disp_0") - read("bot_disp_0"),
        "slip rate": read("top_velo_0") - read("bot_velo_0"),
        "shear traction": read("cohesion_0") - BIMAT["shear traction"],
        "pressure": -read("cohesion_1") - BIMAT["pressure"],
    }
    return {name: field[1:] for name, field in fields.items()}


def _cost(
    case: str, code: str, nodes: int, errors: list[float] | None, costs: Sequence[float]
) -> Cost:
    setup, stepping = (rounded(one, 2) for one in costs)
    slip, rate = (None, None) if errors is None else map(rounded, errors)
    cost = Cost(case, code, nodes, slip, rate, setup, stepping)
    print(cost, flush=True)
    return cost


def rows_of(
    runs: list[tuple[Cost, dict[str, Array]]], pairs: list[tuple[int, int]], spacing: float
) -> Iterator[Row]:
    """Yield rows of pairs of grids, theirs and ours, against the finest of the other code."""
    codes = {
        code: {cost.nodes: (cost, values) for cost, values in runs if cost.code == code}
        for code in (OURS, f"UGUCA, {BUILDS[0]} build")
    }
    our, their = codes[OURS], codes[f"UGUCA, {BUILDS[0]} build"]
    for name in next(iter(our.values()))[1]:
        for one, other in pairs:
            (their_cost_, theirs_), (our_cost_, ours_) = their[one], our[other]
            limit = their[max(their)][1][name]
            if their_cost_.case == "tpv101":
                limit = 2 * limit - their[max(their) // 2][1][name]
            yield Row(
                "UGUCA",
                their_cost_.case,
                TPV101.get(name, name),
                f"{spacing / one:.3g} m",
                f"{spacing / other:.3g} m",
                rounded(_apart(theirs_[name], our[max(our)][1][name])),
                rounded(_apart(ours_[name], limit)),
                _change(their, one, name),
                _change(our, other, name),
                rounded(their_cost_.setup + their_cost_.stepping, 2),
                rounded(our_cost_.setup + our_cost_.stepping, 2),
                COMMAND,
            )


def _change(runs: dict[int, tuple[Cost, dict[str, Array]]], nodes: int, name: str) -> float | None:
    if nodes // 2 not in runs:
        return None
    return rounded(_apart(runs[nodes // 2][1][name], runs[nodes][1][name]))


def main(fields: Path, default: Path, fast: Path, case: str = "") -> None:
    """Write both tables, or the part of them that belongs to one case."""
    builds = dict(zip(BUILDS, (default, fast), strict=True))
    costs: list[Cost] = []
    rows: list[Row] = []
    for name, runs, pairs, spacing in (
        ("tpv101", lambda: tpv101(fields, builds), [(1440, 720), (2880, 1440)], 72e3),
        ("rock-on-gouge", lambda: bimat(builds), [(512, 512), (1024, 1024)], 24.0),
    ):
        if case in ("", name):
            done = list(runs())
            rows += rows_of(done, pairs, spacing)
            costs += [cost for cost, _ in done]
        else:
            costs += [one for one in rows_in(COSTS, Cost) if one.case == name]
    for row in rows:
        print(row)
    replace_rows(rows)
    write_rows(COSTS, costs, command=COMMAND)


if __name__ == "__main__":
    fields, default, fast, *rest = sys.argv[1:]
    main(Path(fields), Path(default), Path(fast), *rest)
