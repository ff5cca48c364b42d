"""A cut that grows under tension against UGUCA: adhesion with its BarrasLaw, in mode I.

``python -m docs.studies.peers.adhesion PROGRAM`` writes rows of docs/data/peers.csv.  PROGRAM
`mode1 NODES STEP`, built with UGUCA's library, sets a cut |x| < 0.5 between two like half-planes
(mu = rho = 1, nu = 0.25, period 8) in its BimatInterface, whose BarrasLaw has the strength 1 beyond
the cut and lets it fall to 0 over a gap of 0.2.  From t = 0 until 3 a tension of 0.5 pulls; fields
are dumped 20 times, in folders mode1_NODES-DataFiles.  A folder `kernels` of UGUCA lies beside it.
It is no part of this package.
"""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import semianalytic as sf
from docs.studies.peers.rows import Array, Row, off, replace_rows, rounded, seconds_of

COMMAND = "python -m docs.studies.peers.adhesion PROGRAM"
GRIDS = (256, 512, 1024, 2048)
LENGTH, END, FRAMES = 8.0, 3.0, 21
TENSION, CUT, GAP = 0.5, 0.5, 0.2
QUANTITIES = ("gap", "pressure")


def theirs(program: Path, nodes: int) -> tuple[dict[str, Array], float]:
    """Run the program; return its fields (20, 256) after t = 0 and the seconds of the processor."""
    with tempfile.TemporaryDirectory() as scratch:
        here = Path(scratch)
        (here / "kernels").symlink_to(program.resolve().parent / "kernels")
        seconds = seconds_of([program.resolve(), str(nodes), "0.35"], here)

        def field(name: str) -> Array:
            file = here / f"mode1_{nodes}-DataFiles" / f"{name}.out"
            values = np.fromfile(file, dtype="<f4").reshape(FRAMES, nodes).astype(float)
            return np.asarray(values[1:, :: nodes // GRIDS[0]])

        fields = {
            "gap": field("top_disp_1") - field("bot_disp_1"),
            "pressure": -field("cohesion_1"),
        }
    return fields, seconds


def ours(nodes: int) -> tuple[dict[str, Array], float]:
    """Run the same problem; return its fields (20, 256) and the seconds of the processor."""
    bonds = sf.Adhesion(strength=lambda x: 1.0 * (np.abs(x) >= CUT), length=GAP)
    face = sf.Interface(
        sf.Material(1.0, 1.0, 0.25),
        sf.Coulomb(0.0),
        LENGTH,
        pressure=0.0,
        loads=[sf.InterfaceLoad(pressure=-TENSION)],
        adhesion=bonds,
    )
    times = np.linspace(0, END, FRAMES)[1:].tolist()
    began = time.process_time()
    done = sf.solve(face, end_time=END, nodes=nodes, times=times, estimate=False)
    seconds = time.process_time() - began
    return {name: getattr(done, name)[:, :: nodes // GRIDS[0]] for name in QUANTITIES}, seconds


def rows_of(
    known: dict[int, tuple[dict[str, Array], float]],
    found: dict[int, tuple[dict[str, Array], float]],
) -> list[Row]:
    """Return the rows of all grids from what both codes computed on them, by nodes."""
    rows, finest = [], GRIDS[-1]
    for name in QUANTITIES:
        for before, nodes in zip((None, *GRIDS), GRIDS, strict=False):
            their, our = known[nodes][0][name], found[nodes][0][name]
            rows.append(
                Row(
                    "UGUCA",
                    "a cut under tension",
                    name,
                    f"{nodes} nodes",
                    f"{nodes} nodes",
                    rounded(off(their, found[finest][0][name])),
                    rounded(off(our, known[finest][0][name])),
                    None if before is None else rounded(off(their, known[before][0][name])),
                    None if before is None else rounded(off(our, found[before][0][name])),
                    rounded(known[nodes][1], 2),
                    rounded(found[nodes][1], 2),
                    COMMAND,
                )
            )
    return rows


def main(program: Path) -> None:
    """Run both codes on all grids and write the rows."""
    known, found = {}, {}
    for nodes in GRIDS:
        known[nodes], found[nodes] = theirs(program, nodes), ours(nodes)
    rows = rows_of(known, found)
    for row in rows:
        print(row)
    replace_rows(rows)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
