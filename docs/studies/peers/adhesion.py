"""A cut that grows under tension against UGUCA: adhesion with its BarrasLaw, in mode I.

``python -m docs.studies.peers.adhesion PROGRAM`` writes rows of docs/data/peers.csv.  PROGRAM
`mode1 NODES STEP`, built with UGUCA's library, sets a cut |x| < 0.5 between two like half-planes
(mu = rho = 1, nu = 0.25, period 8) in its BimatInterface, whose BarrasLaw has the strength 1 beyond
the cut and lets it fall to 0 over a gap of 0.2.  From t = 0 until 3 a tension of 0.5 pulls; fields
are dumped 20 times, in folders mode1_NODES-DataFiles.  A folder `kernels` of UGUCA lies next to it.
It is no part of this package.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

import semianalytic as sf
from docs.studies.lines import scene_along
from docs.studies.peers.rows import GridRun, fields_of, places, record, timed_run
from docs.studies.peers.uguca import dumped

COMMAND = "python -m docs.studies.peers.adhesion PROGRAM"
GRIDS = (256, 512, 1024, 2048)
LENGTH, END, FRAMES = 8.0, 3.0, 21
TENSION, CUT, GAP = 0.5, 0.5, 0.2


def theirs(program: Path, nodes: int) -> GridRun:
    """Run the program; its fields are those at the 20 times after t = 0, on 256 nodes."""
    found, seconds = dumped(program, nodes, "top_disp_1", "bot_disp_1", "cohesion_1")
    return GridRun(f"{nodes} nodes", {"gap": found[0] - found[1], "pressure": -found[2]}, seconds)


def ours(nodes: int) -> GridRun:
    """Run the same problem."""
    bonds = sf.Adhesion(strength=lambda x: 1.0 * (np.abs(x) >= CUT), length=GAP)
    face = scene_along(
        sf.Material(1.0, 1.0, 0.25),
        sf.Coulomb(0.0),
        LENGTH,
        pressure=0.0,
        loads=[sf.InterfaceLoad(pressure=-TENSION)],
        adhesion=bonds,
    )
    times = np.linspace(0, END, FRAMES)[1:].tolist()
    done, seconds = timed_run(face, END, nodes, times)
    every, fields = nodes // GRIDS[0], fields_of(done, "gap", "pressure")
    shown = {name: field[:, ::every] for name, field in fields.items()}
    return GridRun(f"{nodes} nodes", shown, seconds)


def main() -> None:
    """Run both codes on all grids and write the rows."""
    (program,) = places(__doc__, "PROGRAM")
    pairs = [(theirs(program, nodes), ours(nodes)) for nodes in GRIDS]
    record("UGUCA", "a cut under tension", COMMAND, pairs)


if __name__ == "__main__":
    main()
