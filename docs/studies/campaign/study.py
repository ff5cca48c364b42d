"""Thousands of random scenes, solved and marched, each answer held against the laws it must keep.

Run as ``python -m docs.studies.campaign.study``: writes two tables of rows, each with what
reproduces its scene, and prints a summary; ``--csv docs/data`` writes that of the docs.  An
interrupted campaign goes on where it was when started again with the same options.

Self-similar scenes have any Poisson ratio, friction from 1e-9 to 10, any base that stands and any
step.  They are solved to 1e-8 and to 1e-11; the better answer judges
the estimate of the other, and Coulomb's law is looked at where no node lies.  Histories are ramps,
pulses, waves and tables of shear and pressure under every friction law, marched on two grids.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from compare.output.progress import progress_bar
from compare.output.tables import append_rows, started_rows, write_rows
from compare.studies.tables import shown_rows
from compare.tasks.cluster import connected
from compare.tasks.workers import Progress, run_tasks
from docs.studies.trials.draws import drawn, random_history_scene, random_step_scene
from semianalytic import (
    Marched,
    Scene,
    SlipfrontError,
    SlipZone,
    Solution,
    TensionError,
    march,
    solve,
)

Array = NDArray[np.float64]

ROUGH, FINE = 1e-8, 1e-11
SCENES, HISTORIES, SEED = 5000, 300, 1
NODES = 200
_PER_TASK = 25
_LAW_POINTS, _PER_STRETCH = 200, 60
_BETWEEN = 8
"""Points between two places of an edge, at which slip is looked for."""
_AT_EDGE = 1e-12
"""Velocity over c_t that stands for the contact edge itself."""
_CHANGED = 0.01
"""Slip over its scale that a finer grid may find before the answer "no slip" counts as wrong."""


@dataclass(frozen=True)
class SolvedRow:
    """A self-similar scene and what became of it.

    Attributes
    ----------
    index : int, which seeds its draw
    poisson_ratio ... load_shear : the scene, with shear modulus and density 1
    outcome : "converged", "refused" (nothing holds the contact) or the status to rtol 1e-11 or 1e-8
    seconds, fine_seconds : processor time at either rtol, tables of the Poisson ratio included [s]
    estimate, error : of zone edges over c_t and slip rate in L1 at rtol 1e-8
    excess : largest |tau| - f p at random points over the largest load
    against : largest slip rate against the sense of its traction, over the largest slip rate
    """

    index: int
    poisson_ratio: float
    friction: float
    base_pressure: float
    base_shear: float
    load_pressure: float
    load_shear: float
    outcome: str
    seconds: float = 0.0
    fine_seconds: float = 0.0
    estimate: float = 0.0
    error: float = 0.0
    excess: float = 0.0
    against: float = 0.0


@dataclass(frozen=True)
class MarchedRow:
    """A random history and what became of it on 200 nodes, and on 400.

    Attributes
    ----------
    index : int, which seeds its draw
    loads, law : str
    outcome : "marched", "refused" (with a sentence) or "unresolved"
    seconds : processor time on 200 nodes [s]
    change : of slip at the end in L1 from 200 to 400 nodes, over that on 400
    excess : largest |tau| - strength over the largest traction
    least_work : least work of friction of a node over the largest, 0 or more if nothing is gained
    silent : whether 200 nodes answer "no slip" without a word and 400 do not
    """

    index: int
    loads: str
    law: str
    outcome: str
    seconds: float = 0.0
    change: float = 0.0
    excess: float = 0.0
    least_work: float = 0.0
    silent: bool = False


def solved_row(seed: int, index: int) -> SolvedRow:
    """Solve a scene to both tolerances, and hold the answers against each other and the law."""
    scene, random = drawn(seed, index, random_step_scene)
    held, load = scene.superposition
    row = partial(
        SolvedRow,
        index,
        scene.material.poisson_ratio,
        scene.friction,
        held.pressure,
        held.shear,
        load.pressure,
        load.shear,
    )
    try:
        times = [process_time()]
        solutions = []
        for rtol in (FINE, ROUGH):
            solutions.append(solve(scene, rtol=rtol))
            times.append(process_time())
    except TensionError:
        return row("refused")
    fine, rough = solutions
    problems = [solution.status for solution in solutions if solution.status != "converged"]
    excess, against = _broken_law(rough, random)
    return row(
        problems[0] if problems else "converged",
        times[2] - times[1],
        times[1] - times[0],
        min(rough.error_estimate, 1.0),
        error_between(rough, fine),
        excess,
        against,
    )


def error_between(one: Solution, other: Solution) -> float:
    """Largest shift of a zone edge over c_t, or relative L1 difference of slip rates if larger.

    Inf if zones differ that slip at more than the estimate of the first, over the largest rate. A
    shift past what slips less than that is not counted: `Solution.error_estimate` says so.
    """
    speed = one.scene.material.shear_speed
    edges = []
    everywhere = SlipZone(0.0, one.scene.material.longitudinal_speed, 1)  # what is open slips too
    seen = one.error_estimate * _peak(other, everywhere)
    for solution in (one, other):
        peaks = np.array([_peak(solution, zone) for zone in solution.zones])
        certain = peaks > one.error_estimate * peaks.max(initial=0.0)
        zones = [zone for zone, kept in zip(solution.zones, certain, strict=True) if kept]
        pairs = [(zone.inner, zone.outer) for zone in zones]
        edges.append(np.array(pairs).ravel() / speed)
    if len(edges[0]) != len(edges[1]):
        return math.inf
    finite = np.isfinite(edges[1])
    between = np.linspace(edges[0][finite], edges[1][finite], 2 + _BETWEEN, axis=-1)[:, 1:-1]
    between = speed * np.maximum(between, _AT_EDGE)
    beside = np.abs([solution.slip_rate(between, 1.0) for solution in (one, other)])
    counts = (beside > seen).any(axis=(0, -1))
    shift = float(np.abs(edges[0][finite] - edges[1][finite])[counts].max(initial=0.0))
    # between edges and fronts, closer and closer towards both ends
    share = (1 - np.cos(np.pi * (np.arange(_PER_STRETCH) + 0.5) / _PER_STRETCH)) / 2
    weight = np.sin(np.pi * (np.arange(_PER_STRETCH) + 0.5) / _PER_STRETCH)
    ahead = one.scene.material.longitudinal_speed / speed
    ends = np.unique([*edges[1][finite], 0.0, one.scene.material.rayleigh_speed / speed, ahead])
    width = np.diff(ends)[:, None]
    xi = speed * (ends[:-1, None] + width * share)
    rates = [solution.slip_rate(xi, 1.0) for solution in (one, other)]
    size, change = (np.sum(width * weight * np.abs(v)) for v in (rates[1], rates[0] - rates[1]))
    return max(shift, float(change / size) if size else 0.0)


def _peak(solution: Solution, zone: SlipZone) -> float:
    """About the largest slip rate of a zone, at unit time."""
    outer = min(zone.outer, solution.scene.material.longitudinal_speed)
    inside = zone.inner + (outer - zone.inner) * (np.arange(20) + 0.5) / 20
    return float(np.abs(solution.slip_rate(inside, 1.0)).max())


def _broken_law(solution: Solution, random: np.random.Generator) -> tuple[float, float]:
    """By how much Coulomb's law fails at random points: of traction, of slip where closed."""
    scene = solution.scene
    x = scene.material.longitudinal_speed * random.uniform(1e-3, 1.0, _LAW_POINTS)
    shear, rate = solution.shear_traction(x, 1.0), solution.slip_rate(x, 1.0)
    pressure = solution.pressure(x, 1.0)
    strength, closed = scene.friction * pressure, pressure > 0
    held, load = scene.superposition
    loads = (held.shear, load.shear, scene.friction * load.pressure)
    largest = max(float(strength.max()), *(abs(one) for one in loads))
    fastest = float(np.abs(rate).max()) or 1.0
    excess = float((np.abs(shear) - strength).max()) / largest
    return max(excess, 0.0), max(float((-rate * np.sign(shear) * closed).max()) / fastest, 0.0)


def marched_row(seed: int, index: int) -> MarchedRow:
    """March a history on two grids, and hold the answer against the other and the law."""
    scene, _ = drawn(seed, index, random_history_scene)
    loads = " and ".join(
        f"{name} {type(history).__name__.lower()}"
        for name, history in scene.acting_histories.items()
    )
    row = partial(MarchedRow, index, loads, type(scene.friction_law).__name__)
    try:
        began = process_time()
        coarse = march(scene, 1.0, NODES, companion=False)
        seconds = process_time() - began
        fine = march(scene, 1.0, 2 * NODES, companion=False)
    except SlipfrontError:
        return row("refused")
    slip = np.abs(fine.interface.slip[-1])
    paired = (fine.interface.slip[-1, ::2] + fine.interface.slip[-1, 1::2]) / 2
    size = float(np.abs(paired).sum())
    change = float(np.abs(coarse.interface.slip[-1] - paired).sum()) / size if size else 0.0
    missed = not coarse.seen.slip_rate.any() and slip.max() > _CHANGED * _scale(scene)
    work = coarse.final_work_density
    return row(
        "marched" if coarse.status == "resolved" else "unresolved",
        seconds,
        change,
        _excess(coarse),
        float(work.min() / work.max()) if work.any() else 0.0,
        missed and coarse.status == "resolved",
    )


def _scale(scene: Scene) -> float:
    """Slip that the loads could drive at most [length]."""
    return sum(abs(part.shear) for part in scene.superposition) / scene.material.shear_impedance


def _excess(marched: Marched) -> float:
    """Largest |tau| - strength at the end over the largest traction."""
    scene, end = marched.scene, marched.interface
    shear = np.abs(end.shear_traction[-1])
    strength = scene.friction_law.strength(
        scene.friction * end.pressure[-1], end.slip_rate[-1], marched.final_path
    )
    return max(float((shear - strength).max()) / (float(shear.max()) or 1.0), 0.0)


def _several(function: Any, seed: int, indices: Sequence[int]) -> list[Any]:
    return [function(seed, index) for index in indices]


def run_campaign(
    directory: Path,
    scenes: int = SCENES,
    histories: int = HISTORIES,
    seed: int = SEED,
    progress: Progress | None = None,
    client: Any = None,
) -> tuple[list[SolvedRow], list[MarchedRow]]:
    """All rows, those of an earlier run with the same seed included; tables in a folder.

    A `client` of a Dask cluster lets that do it.

    Raises
    ------
    DataFileError
        If a table cannot be written.
    """
    directory.mkdir(parents=True, exist_ok=True)
    plan: tuple[tuple[type[Any], Callable[[int, int], Any], int], ...] = (
        (SolvedRow, solved_row, scenes),
        (MarchedRow, marched_row, histories),
    )
    tables = [directory / f"{kind.__name__.lower()}s-{seed}.csv" for kind, _, _ in plan]
    results: list[dict[int, Any]] = []
    tasks, owners = [], []
    for owner, ((kind, function, count), table) in enumerate(zip(plan, tables, strict=True)):
        known: dict[int, Any] = {row.index: row for row in started_rows(table, kind)}
        results.append({index: row for index, row in known.items() if index < count})
        left = [index for index in range(count) if index not in known]
        for start in range(0, len(left), _PER_TASK):
            tasks.append((_several, (function, seed, left[start : start + _PER_TASK])))
            owners.append(owner)
    for task, rows in run_tasks(tasks, None, progress, client):
        owner = owners[task]
        append_rows(tables[owner], rows)
        results[owner].update({row.index: row for row in rows})
    solved, marched = (sorted(rows.values(), key=lambda row: row.index) for rows in results)
    return solved, marched


def summary(solved: Sequence[SolvedRow], marched: Sequence[MarchedRow]) -> list[tuple[str, str]]:
    """Summarise the campaign as pairs of a description and a value."""
    answered = [row for row in solved if row.outcome != "refused"]
    whole = [row for row in answered if row.outcome == "converged"]
    runs = [row for row in marched if row.outcome != "refused"]

    def ratio(values: Array) -> str:
        middle = np.median(values)
        return f"{np.quantile(values, 0.99) / middle:.0f} and {values.max() / middle:.0f}"

    lines = [
        ("self-similar scenes solved", f"{len(answered)}"),
        ("refused: nothing holds the contact", f"{len(solved) - len(answered)}"),
        ("not converged to 1e-8 or 1e-11", f"{len(answered) - len(whole)}"),
    ]
    if whole:
        error, estimate = (
            np.array([getattr(row, name) for row in whole]) for name in ("error", "estimate")
        )
        worst = np.max(error / np.maximum(estimate, FINE))
        lines += [
            ("error at 1e-8 over its estimate, largest", f"{worst:.2g}"),
            ("error at 1e-8, median and largest", f"{np.median(error):.1e}, {error.max():.1e}"),
            ("traction above friction, largest", f"{max(row.excess for row in whole):.1e}"),
            ("slip against its traction, largest", f"{max(row.against for row in whole):.1e}"),
            ("time at 1e-8 over its median, 99th percentile and largest",
             ratio(np.array([row.seconds for row in whole]))),
            ("time at 1e-11 over its median, 99th percentile and largest",
             ratio(np.array([row.fine_seconds for row in whole]))),
        ]  # fmt: skip
    lines += [
        (f"histories marched on {NODES} nodes", f"{len(runs)}"),
        ("refused with a sentence", f"{len(marched) - len(runs)}"),
        ("told as unresolved", f"{sum(row.outcome == 'unresolved' for row in runs)}"),
        ('"no slip" without a word where there is some', f"{sum(row.silent for row in runs)}"),
    ]
    if runs:
        change = np.array([row.change for row in runs if row.outcome == "marched"])
        lines += [
            ("change of slip on doubling, median and largest",
             f"{np.median(change):.1e}, {change.max():.1e}"),
            ("strength exceeded, largest", f"{max(row.excess for row in runs):.1e}"),
            ("work gained from friction, largest over the work done",
             f"{max(max(-row.least_work, 0.0) for row in runs) + 0.0:.1e}"),
        ]  # fmt: skip
    return lines


@dataclass(frozen=True)
class SummaryRow:
    """A line of docs/campaign.md."""

    what: str
    result: str


def main() -> None:
    """Run the campaign and print its table."""
    from rich.console import Console

    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--scenes", type=int, default=SCENES)
    parser.add_argument("--histories", type=int, default=HISTORIES)
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--output", type=Path, default=Path("results", "campaign"))
    parser.add_argument(
        "--csv", type=Path, metavar="DIR", help="folder for campaign.csv; docs/data"
    )
    parser.add_argument("--scheduler", metavar="ADDRESS", help="of a Dask cluster that is to work")
    chosen = parser.parse_args()
    asked = chosen.output, chosen.scenes, chosen.histories, chosen.seed
    bar = progress_bar(Console(stderr=True), False, "campaign")
    with connected(chosen.scheduler) as client, bar as progress:
        rows = run_campaign(*asked, progress, client)
    lines = [SummaryRow(*line) for line in summary(*rows)]
    Console().print(shown_rows(f"{len(rows[0])} scenes, {len(rows[1])} histories", lines))
    if chosen.csv is not None:
        command = "python -m docs.studies.campaign.study --csv docs/data"
        write_rows(chosen.csv / "campaign.csv", lines, command=command)


if __name__ == "__main__":
    main()
