"""A cut that grows under tension against UGUCA: adhesion with its BarrasLaw, in mode I.

``python -m docs.studies.peers.adhesion PROGRAM`` writes rows of docs/data/peers.csv.  PROGRAM
`mode1 NODES STEP`, built with UGUCA's library, sets a cut |x| < 0.5 between two like half-planes
(mu = rho = 1, nu = 0.25, period 8) in its BimatInterface, whose BarrasLaw has the strength 1 beyond
the cut and lets it fall to 0 over a gap of 0.2.  From t = 0 until 3 a tension of 0.5 pulls; fields
are dumped 20 times, in folders mode1_NODES-DataFiles.  A folder `kernels` of UGUCA lies beside it.
It is no part of this package.
"""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

import numpy as np

import semianalytic as sf
from docs.studies.peers.rows import Array, GridRun, compared, places, replace_rows, seconds_of

COMMAND = "python -m docs.studies.peers.adhesion PROGRAM"
GRIDS = (256, 512, 1024, 2048)
LENGTH, END, FRAMES = 8.0, 3.0, 21
TENSION, CUT, GAP = 0.5, 0.5, 0.2


def theirs(program: Path, nodes: int) -> GridRun:
    """Run the program; its fields are those at the 20 times after t = 0, on 256 nodes."""
    with tempfile.TemporaryDirectory() as scratch:
        here = Path(scratch)
        (here / "kernels").symlink_to(program.resolve().parent / "kernels")
        seconds = seconds_of([program.resolve(), str(nodes), "0.35"], here)

        def field(name: str) -> Array:
            file = here / f"mode1_{nodes}-DataFiles" / f"{name}.out"
            values = np.fromfile(file, dtype="<f4").reshape(FRAMES, nodes).astype(float)
            return np.asarray(values[1:, :: nodes // GRIDS[0]])

        gap = field("top_disp_1") - field("bot_disp_1")
        return GridRun(f"{nodes} nodes", {"gap": gap, "pressure": -field("cohesion_1")}, seconds)


def ours(nodes: int) -> GridRun:
    """Run the same problem."""
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
    seconds, every = time.process_time() - began, nodes // GRIDS[0]
    fields = {"gap": done.gap[:, ::every], "pressure": done.pressure[:, ::every]}
    return GridRun(f"{nodes} nodes", fields, seconds)


def main() -> None:
    """Run both codes on all grids and write the rows."""
    (program,) = places(__doc__, "PROGRAM")
    pairs = [(theirs(program, nodes), ours(nodes)) for nodes in GRIDS]
    replace_rows(compared("UGUCA", "a cut under tension", COMMAND, pairs))


if __name__ == "__main__":
    main()
