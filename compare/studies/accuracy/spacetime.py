"""Studies of the space-time solver: accuracy, cost, memory, slow ramps, the edge of its grid.

``python -m compare.studies.accuracy.spacetime accuracy`` prints a table; `STUDIES` lists more.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import lru_cache, partial

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from compare.comparison.measures import in_profile, relative_error
from semianalytic import Marched, Material, Ramp, Scene, Solution, Tractions, march, solve
from semianalytic.halfplane.stuck_histories import stuck_shear
from semianalytic.reference.static_zone import static_zone
from semianalytic.scene.loads import Step
from semianalytic.scene.named import NAMED_SCENES
from semianalytic.spacetime.march_memory import state_bytes

Array = NDArray[np.float64]

LENGTH = 2.0
"""Observed contact [length] until t = 1/c_t = 1."""
GRIDS = (128, 256, 512, 1024, 2048, 4096)
TOLERANCES = (1e-3, 1e-4, 1e-5, 1e-6, 1e-8, 1e-10)
RISE_TIMES = (0.25, 1.0, 4.0, 16.0, 64.0)


def step_error(scene: Scene, marched: Marched) -> float:
    """Relative L1 error of the slip rate at the end on 0.02 < x/(c_t t) < 1.9, a step load."""
    x, end = marched.grid.x, marched.end_time
    seen = in_profile(x / (end * scene.material.shear_speed))
    exact = _exact(scene).slip_rate(x[seen], end)
    return relative_error(marched.interface.slip_rate[-1, seen], exact, x[seen], 1)


@lru_cache(maxsize=4)
def _exact(scene: Scene) -> Solution:
    return solve(scene, rtol=1e-9)


def last_march(
    scene: Scene,
    nodes: int,
    *,
    step_ratio: float = 0.5,
    damping: float = 0.7,
    tolerance: float = 1e-6,
) -> Marched:
    """A march of which only the end is kept."""
    return march(
        scene,
        nodes=nodes,
        length=LENGTH,
        step_ratio=step_ratio,
        damping=damping,
        tolerance=tolerance,
        every=10**9,
    )


def accuracy() -> Table:
    """Errors against the self-similar solver, observed orders, seconds, by nodes."""
    table = Table("scene", "nodes", "L1 error [%]", "order", "seconds", title="Accuracy")
    for name in ("preloaded", "remote-shock", "auxetic"):
        scene, before = NAMED_SCENES[name].scene, None
        for nodes in GRIDS:
            seconds, marched = _timed(partial(last_march, scene, nodes))
            error = step_error(scene, marched)
            order = "" if before is None else f"{np.log2(before / error):.2f}"
            table.add_row(name, str(nodes), f"{100 * error:.4f}", order, f"{seconds:.3g}")
            before = error
    return table


def _timed(run: Callable[[], Marched], repeats: int = 3) -> tuple[float, Marched]:
    """Median of some runs [s], and the last result."""
    seconds = []
    for _ in range(repeats):
        started = time.perf_counter()
        marched = run()
        seconds.append(time.perf_counter() - started)
    return float(np.median(seconds)), marched


def cost() -> Table:
    """Seconds and memory of preloaded against nodes, and what direct convolution would take."""
    table = Table(
        "nodes", "steps", "grid", "seconds", "growth", "state [MB]", "past of a direct sum [MB]"
    )
    scene, before = NAMED_SCENES["preloaded"].scene, None
    for nodes in (256, 512, 1024, 2048, 4096, 8192):
        seconds, marched = _timed(partial(last_march, scene, nodes), 3 if nodes < 4096 else 1)
        used = marched.statistics
        growth = "" if before is None else f"{seconds / before:.2f}"
        state = state_bytes(used.nodes, used.poles) / 1e6
        past = 8 * used.steps * used.nodes / 1e6
        table.add_row(
            str(nodes),
            str(used.steps),
            str(used.nodes),
            f"{seconds:.3g}",
            growth,
            f"{state:.1f}",
            f"{past:.0f}",
        )
        before = seconds
    return table


def memory() -> Table:
    """Poles, error of their transform and of the slip rate, by tolerance, 1024 nodes."""
    table = Table("tolerance", "poles", "transform", "L1 error [%]", "seconds", title="Memory")
    scene = NAMED_SCENES["preloaded"].scene
    for tolerance in TOLERANCES:
        seconds, marched = _timed(partial(last_march, scene, 1024, tolerance=tolerance))
        used = marched.statistics
        table.add_row(
            f"{tolerance:.0e}",
            str(used.poles),
            f"{used.memory_error:.1e}",
            f"{100 * step_error(scene, marched):.4f}",
            f"{seconds:.3g}",
        )
    return table


def ramp_errors(rise_time: float, nodes: int = 1500) -> tuple[float, float, float]:
    """Static zone length over c_t T, and relative differences of a march in length and slip (L1).

    Scene `ramp` at t = 1, with another rise time.
    """
    scene = replace(NAMED_SCENES["ramp"].scene, shear_history=Ramp(rise_time))
    static = static_zone(scene, 1.0)
    length = float(np.clip(4 * static.length, 0.4, 2.0))
    marched = march(scene, 1.0, nodes, length=length, every=10**9)
    x, slip = marched.grid.x, marched.interface.slip[-1]
    end = x[slip > 1e-4 * slip.max()].max() + marched.grid.spacing / 2
    return (
        static.length,
        float(end / static.length - 1),
        relative_error(slip, static.slip(x), x, 1),
    )


def ramps() -> Table:
    """How the slip under slower and slower ramps approaches the static near field."""
    table = Table("rise time", "static zone / c_t T", "length off [%]", "slip off, L1 [%]")
    for rise_time in RISE_TIMES:
        length, longer, slip = ramp_errors(rise_time)
        table.add_row(f"{rise_time:g}", f"{length:.4f}", f"{100 * longer:.1f}", f"{100 * slip:.1f}")
    return table


def edge() -> Table:
    """Stuck traction at the first nodes by the grid over the exact one, by where the edge is."""
    from semianalytic.halfplane.edge_factors import edge_offset_and_factors

    scene = Scene(Material(1.0, 1.0, 1 / 3), 1e6, Tractions(1.0, 0.0), Tractions(0.0, 1.0))
    marched = last_march(scene, 1024)
    offset, factors = edge_offset_and_factors()
    table = Table("first node at", "L1 error over 60 nodes [%]", title="Edge of the grid")
    for name, first, seen in (
        (f"{offset:.4f} h, with its factors", offset, factors[:60]),
        (f"{offset:.4f} h", offset, np.ones(60)),
        ("0.5 h", 0.5, np.ones(60)),
        ("0.25 h", 0.25, np.ones(60)),
    ):
        x = (np.arange(60) + first) * marched.grid.spacing
        exact = 1 + stuck_shear(Step(), 1.0, scene.material, x, 1.0).value
        shear = (1 + marched.interface.shear_traction[-1, :60]) / seen
        table.add_row(name, f"{100 * relative_error(shear, exact, np.asarray(x), 1):.3f}")
    return table


STUDIES: Mapping[str, Callable[[], Table]] = {
    "accuracy": accuracy,
    "cost": cost,
    "memory": memory,
    "ramps": ramps,
    "edge": edge,
}


def main(names: list[str]) -> None:
    """Print the studies named, or say which there are."""
    unknown = [name for name in names if name not in STUDIES]
    if unknown or not names:
        sys.exit(f"Name studies: {', '.join(STUDIES)}.")
    for name in names:
        Console(width=100).print(STUDIES[name]())


if __name__ == "__main__":
    main(sys.argv[1:])
