"""Time and memory of a run of a named interface, over the number of nodes.

``python -m docs.studies.engine_cost`` writes docs/data/engine-cost.csv in some minutes.  Times are
those of the processor, for one thread of linear algebra.
"""

from __future__ import annotations

import csv
import math
import tracemalloc
from pathlib import Path
from time import process_time
from typing import Any

import semianalytic as sf
from semianalytic.engine.steps import Stepper
from semianalytic.engine.tuning import STEP_RATIO
from semianalytic.interface.files import InterfaceFile

DATA = Path(__file__).resolve().parents[1] / "data" / "engine-cost.csv"
COMMAND = "python -m docs.studies.engine_cost"
NAMES = ("supershear", "tpv101", "two-slots", "tap", "rock-on-gouge")
NODES = (256, 512, 1024, 2048, 4096, 8192, 16384)
COUNTED = 512  # nodes of the run whose steps are counted: the lowest rung grows with 1 / nodes
BATCHES, LEAST_SECONDS = 3, 0.3
FIELDS = ("interface", "nodes", "memory", "step", "steps", "seconds", "exponent")


def main() -> None:
    """Measure all interfaces, then write the table."""
    rows = []
    for name in NAMES:
        found = sf.find(name)
        counted = sf.solve(
            found.interface, end_time=found.end_time, nodes=COUNTED, estimate=False, **ratio(found)
        )
        before = math.nan
        for nodes in NODES:
            step, memory = cost_of_step(found, nodes)
            steps = round(counted.steps * nodes / COUNTED)
            seconds = step * steps
            exponent = math.log2(seconds / before) if before > 0 else math.nan
            row = [name, nodes, f"{memory:.3g}", f"{step * 1e3:.3g}", steps, f"{seconds:.3g}"]
            row.append(f"{exponent:.2f}" if math.isfinite(exponent) else "")
            print(*row, sep=" | ", flush=True)
            rows.append(row)
            before = seconds
    with DATA.open("w", newline="", encoding="utf-8") as stream:
        stream.write(f"# {COMMAND}\n")
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(FIELDS)
        writer.writerows(rows)


def ratio(found: InterfaceFile) -> dict[str, Any]:
    """Return the shortest step of an interface as an option of `run`."""
    return {"step_ratio": found.options.get("step_ratio", STEP_RATIO)}


def cost_of_step(found: InterfaceFile, nodes: int) -> tuple[float, float]:
    """Return processor time of a step [s] and memory of a run without its frames [MB].

    The time is the least of some batches of steps of the lowest rung, in which ruptures run.
    """
    options: dict[str, Any] = {**ratio(found), "end_time": found.end_time}
    Stepper(found.interface, nodes, **options)  # fits the memory, which later runs find in a cache
    tracemalloc.start()
    stepper = Stepper(found.interface, nodes, **options)
    now = stepper.begin()
    for _ in range(3):
        now = stepper.step(now, stepper.shortest, 0)
    memory = tracemalloc.get_traced_memory()[1] / 1e6
    tracemalloc.stop()
    times = []
    for _ in range(BATCHES):
        start, count = process_time(), 0
        while process_time() - start < LEAST_SECONDS:
            now = stepper.step(now, min(stepper.length(now)[0], stepper.shortest), 0)
            count += 1
        times.append((process_time() - start) / count)
    return min(times), memory


if __name__ == "__main__":
    main()
