"""Studies of the space-time solver: accuracy, cost, memory, ramps, resolution, edge, error, fields,
and moving fronts.

``python -m docs.studies.accuracy.spacetime accuracy`` prints a table; `STUDIES` lists the others.
With ``--csv docs/data``, the data of docs/spacetime.md are written.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from compare.comparison.measures import relative_error
from compare.studies.tables import Study, run_studies
from docs.studies.accuracy.march_error import error, weakening
from docs.studies.accuracy.march_fields import fields
from docs.studies.accuracy.march_fronts import fronts
from docs.studies.profiles import LENGTH, last_march, step_error
from semianalytic import Harmonic, Marched, Material, Ramp, Scene, Tractions, march
from semianalytic.halfplane.stuck_histories import stuck_shear
from semianalytic.reference import static_zone
from semianalytic.scene.given.named import NAMED_SCENES
from semianalytic.scene.loads import Step
from semianalytic.spacetime.grid.resolution import zone_at_edge
from semianalytic.spacetime.march_memory import state_bytes

Array = NDArray[np.float64]

GRIDS = (128, 256, 512, 1024, 2048, 4096)
COST_GRIDS = (256, 512, 1024, 2048, 4096, 8192)
TOLERANCES = (1e-3, 1e-4, 1e-5, 1e-6, 1e-8, 1e-10)
MEMORY_NODES = 1024
RISE_TIMES = (0.25, 1.0, 4.0, 16.0, 64.0)
STEPS_PER_PERIOD = (16, 32)
NODES_IN_ZONE = (1, 2, 4, 8)
FINEST = 4096
"""Nodes of the reference marches in the study of resolution."""


@dataclass(frozen=True)
class AccuracyRow:
    """L1 error of a scene on one grid, the observed order since the grid before, and time [s]."""

    scene: str
    nodes: int
    error: float
    order: float
    seconds: float


def accuracy() -> list[AccuracyRow]:
    """Measure errors against the self-similar solver, by nodes."""
    rows = []
    for name in ("preloaded", "remote-shock", "auxetic"):
        scene, before = NAMED_SCENES[name].scene, math.nan
        for nodes in GRIDS:
            seconds, marched = _timed(partial(last_march, scene, nodes))
            error = step_error(scene, marched)
            rows.append(AccuracyRow(name, nodes, error, math.log2(before / error), seconds))
            before = error
    return rows


def _timed(run: Callable[[], Marched], repeats: int = 3) -> tuple[float, Marched]:
    """Return the median time of several runs [s], and the last result."""
    seconds = []
    for _ in range(repeats):
        started = time.perf_counter()
        marched = run()
        seconds.append(time.perf_counter() - started)
    return float(np.median(seconds)), marched


@dataclass(frozen=True)
class CostRow:
    """Time [s] and peak memory [MB] of a march, and memory of the history for a direct sum [MB]."""

    nodes: int
    steps: int
    grid: int
    seconds: float
    state: float
    past: float


def cost() -> list[CostRow]:
    """Measure time and memory of `preloaded` by nodes."""
    scene, rows = NAMED_SCENES["preloaded"].scene, []
    for nodes in COST_GRIDS:
        seconds, marched = _timed(partial(last_march, scene, nodes), 3 if nodes < 4096 else 1)
        used = marched.statistics
        state, past = state_bytes(used.nodes, used.poles), 8 * used.steps * used.nodes
        rows.append(CostRow(nodes, used.steps, used.nodes, seconds, state / 1e6, past / 1e6))
    return rows


@dataclass(frozen=True)
class MemoryRow:
    """Poles of a memory of given tolerance, error of their transform, L1 error of the slip rate."""

    tolerance: float
    poles: int
    transform_error: float
    error: float
    seconds: float


def memory() -> list[MemoryRow]:
    """Measure how many exponentials suffice for a thousand nodes."""
    scene, rows = NAMED_SCENES["preloaded"].scene, []
    for tolerance in TOLERANCES:
        seconds, marched = _timed(partial(last_march, scene, MEMORY_NODES, tolerance=tolerance))
        used, error = marched.statistics, step_error(scene, marched)
        rows.append(MemoryRow(tolerance, used.poles, used.memory_error, error, seconds))
    return rows


@dataclass(frozen=True)
class RampRow:
    """Length of the static zone over c_t T, and relative differences of a march from it."""

    rise_time: float
    static_length: float
    length: float
    slip: float


def ramp_errors(rise_time: float, nodes: int = 1500) -> RampRow:
    """March `ramp` with another rise time to t = 1; compare length of the slip zone and slip (L1).

    Both differences are relative to the static zone.
    """
    scene = replace(NAMED_SCENES["ramp"].scene, shear_history=Ramp(rise_time))
    static = static_zone(scene, 1.0)
    length = float(np.clip(4 * static.length, 0.4, 2.0))
    marched = march(scene, 1.0, nodes, length=length, every=10**9, companion=False)
    x, slip = marched.grid.x, marched.interface.slip[-1]
    end = x[slip > 1e-4 * slip.max()].max() + marched.grid.spacing / 2
    return RampRow(
        rise_time,
        static.length,
        float(end / static.length - 1),
        relative_error(slip, static.slip(x), x, 1),
    )


@dataclass(frozen=True)
class ResolutionRow:
    """Relative error of frictional work until T on a coarse grid, by the measure of coarseness."""

    study: str
    resolution: int
    error: float


def resolution() -> list[ResolutionRow]:
    """Measure loads with few steps per period (ten cycles), and zones of few nodes (f = 5)."""
    preloaded = NAMED_SCENES["preloaded"].scene
    wave = replace(preloaded, friction=0.1, shear_history=Harmonic(10.0))
    strong = replace(preloaded, friction=5.0)
    zone = zone_at_edge(strong, 1.0)
    return [
        *(_work_row("steps a period", wave, n, round(10 * n)) for n in STEPS_PER_PERIOD),
        *(_work_row("nodes in the zone", strong, n, round(2 * n / zone)) for n in NODES_IN_ZONE),
    ]


def _work_row(study: str, scene: Scene, parameter: int, nodes: int) -> ResolutionRow:
    error = abs(_work(scene, nodes) / _work(scene, FINEST) - 1)
    return ResolutionRow(study, parameter, error)


def _work(scene: Scene, nodes: int) -> float:
    """Return the frictional work until T = 1 on a length of 2, per unit thickness."""
    marched = march(scene, 1.0, nodes, length=LENGTH, every=10**9, companion=False)
    return float(marched.final_work_density.sum() * marched.grid.spacing)


@dataclass(frozen=True)
class EdgeRow:
    """L1 error of stuck traction at the first 60 nodes, by the assumed position of the first."""

    first_node: str
    error: float


def edge() -> list[EdgeRow]:
    """Compare stuck traction at the first nodes with the exact one, by the position of the edge."""
    from semianalytic.halfplane.edge_factors import edge_offset_and_factors

    scene = Scene(Material(1.0, 1.0, 1 / 3), 1e6, Tractions(1.0, 0.0), Tractions(0.0, 1.0))
    marched = last_march(scene, 1024)
    offset, factors = edge_offset_and_factors()
    rows = []
    for name, first, seen in (
        (f"{offset:.4f} h, with its factors", offset, factors[:60]),
        (f"{offset:.4f} h", offset, np.ones(60)),
        ("0.5 h", 0.5, np.ones(60)),
        ("0.25 h", 0.25, np.ones(60)),
    ):
        x = (np.arange(60) + first) * marched.grid.spacing
        exact = 1 + stuck_shear(Step(), 1.0, scene.material, x, 1.0).value
        shear = (1 + marched.interface.shear_traction[-1, :60]) / seen
        rows.append(EdgeRow(name, relative_error(shear, exact, np.asarray(x), 1)))
    return rows


STUDIES: Mapping[str, Study] = {
    "accuracy": accuracy,
    "cost": cost,
    "memory": memory,
    "ramps": lambda: [ramp_errors(rise_time) for rise_time in RISE_TIMES],
    "resolution": resolution,
    "edge": edge,
    "error": error,
    "weakening": weakening,
    "fields": fields,
    "fronts": fronts,
}


if __name__ == "__main__":
    raise SystemExit(run_studies("docs.studies.accuracy.spacetime", "march", STUDIES))
