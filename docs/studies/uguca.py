"""TPV101 in two dimensions against the fields that UGUCA's authors' fork published.

``python -m docs.studies.uguca FOLDER`` writes docs/data/engine-uguca.csv.  FOLDER is a checkout of
github.com/chunhuizhao478/uguca_scec at commit 1db9efb; its fields are not part of this package.
"""

from __future__ import annotations

import csv
import math
import sys
import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import semianalytic as sf

DATA = Path(__file__).resolve().parents[1] / "data" / "engine-uguca.csv"
FIELDS = {"slip": ("top_disp_0", 2.0), "slip_rate": ("top_velo_0", 2.0), "state": ("theta", 1.0)}
"""Files of the fields, and what to multiply them by: displacements are those of one side."""
FRAMES = 149


def theirs(folder: Path, nodes: int, name: str) -> NDArray[np.float64]:
    """Return a field at x >= 0 on the nodes of 1,440, (frames, 721)."""
    file, factor = FIELDS[name]
    place = folder / "build/benchmarks/TPV101" / f"TPV101_Nx{nodes}_s2.00_tf0.35_npc1-DataFiles"
    whole = np.fromfile(place / f"{file}.out", dtype="<f4").reshape(-1, nodes)[:FRAMES]
    # their last node is one before the end of the period, where ours is one more
    return factor * whole[:, nodes // 2 :: nodes // 1440].astype(float)


def off(one: NDArray[np.float64], other: NDArray[np.float64]) -> float:
    """Return the L1 difference over all frames and nodes, relative to the other."""
    count = min(one.shape[1], other.shape[1])
    return float(np.abs(one[:, :count] - other[:, :count]).sum() / np.abs(other[:, :count]).sum())


def main(folder: Path) -> None:
    """Write the table of differences."""
    found = sf.find("tpv101")
    every = 20 * 0.35 * 50 / found.interface.material.shear_speed
    times = [every * k for k in range(FRAMES)]
    ours, seconds = {}, {}
    for nodes in (360, 720, 1440, 2880):
        began = time.process_time()
        ours[nodes] = sf.solve(
            found.interface,
            end_time=times[-1],
            nodes=nodes,
            step_ratio=0.35,
            times=times,
            estimate=False,
        )
        seconds[nodes] = time.process_time() - began
        print(nodes, f"{seconds[nodes]:.1f} s of the processor", flush=True)
    with DATA.open("w", newline="", encoding="utf-8") as stream:
        stream.write("# python -m docs.studies.uguca FOLDER\n")
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(["nodes", "quantity", "next", "order", "extrapolated", "finer", "own"])
        for name in FIELDS:
            quantity = name.replace("_", " ")
            coarse, fine = theirs(folder, 1440, name), theirs(folder, 2880, name)
            limit = 2 * fine - coarse
            before = math.nan
            for nodes, run in ours.items():
                field = getattr(run, name)
                thin = field[:, :: max(1, nodes // 1440)]
                common = slice(None, None, max(1, 1440 // nodes))
                change = math.nan
                if 2 * nodes in ours:
                    step = 2
                    change = off(field, getattr(ours[2 * nodes], name)[:, ::step])
                row = (
                    nodes,
                    quantity,
                    f"{change:.2e}",
                    f"{math.log2(before / change):.2f}" if before > 0 and change > 0 else "nan",
                    f"{off(thin, limit[:, common]):.2e}",
                    f"{off(thin, fine[:, common]):.2e}",
                    f"{off(fine, coarse):.2e}",
                )
                before = change
                print(*row, flush=True)
                writer.writerow(row)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
