"""Slip weakening under a delayed pressure between two bodies, against SEM2DPACK's Bimaterial_fault.

``python -m docs.studies.peers.bimaterial PROGRAM FOLDER`` writes rows of docs/data/peers.csv.
PROGRAM is SEM2DPACK's solver, FOLDER a checkout of github.com/jpampuero/sem2dpack; neither is part
of this package.  The example has its fault at the middle of 128 rows of elements and its two bodies
joined after the 56th, so that its fault lies within one of them.  Here they join at the fault, as
in the larger mesh that the example has commented out.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

import semianalytic as sf
from docs.studies.lines import scene_along
from docs.studies.peers.rows import Array, GridRun, fields_of, places, record, timed_run
from docs.studies.peers.sem2dpack import Fields, patch, plain_input, their_run

COMMAND = "python -m docs.studies.peers.bimaterial PROGRAM FOLDER"
GRIDS = ((256, 1024), (512, 2048), (1024, 3072))
"""Elements along their fault, and nodes along ours.

The shear of the patch exceeds its strength by 1e-5.  On grids of which one node holds 0.7 to 0.8 of
the end of the patch, such as 1,536 and 4,096 nodes, slip differs by 3 %."""
LENGTH = 600.0
"""Length of the fault [m], which is periodic in both codes."""
END = 0.03
"""Time [s] until which they are compared: then waves return from their outer boundaries."""
TIMES = np.arange(0.002, END + 1e-9, 0.001)
PLACES = np.arange(-90.0, 90.5, 1.0)


def their_input(folder: Path, count: int) -> str:
    """Return the input with `count` elements along the fault, and its bodies on either side."""
    text = plain_input(folder / "EXAMPLES" / "Bimaterial_fault")
    rows = count // 8  # of each body, the two next to the fault with the example's damping
    text = re.sub(r"nelem *= *\d+ *, *\d+", f"nelem={count},{2 * rows}", text)
    text = re.sub(r"ex= *1 *, *\d+", f"ex=1,{count}", text)
    begins, ends = (1, rows - 1, rows + 1, rows + 3), (rows - 2, rows, rows + 2, 2 * rows)
    for tag, (begin, end) in enumerate(zip(begins, ends, strict=True), 1):
        text = re.sub(rf"(tag={tag} *,[^/]*ez=)[\d, ]+", rf"\g<1>{begin},{end} ", text)
    text = re.sub(r"TotalTime *= *[\d.d]+", f"TotalTime={END + 0.002}d0", text)
    return re.sub(r"TtH='PWCONR' */", "TtH='PWCONR', otd=0.0005d0 /", text)


def our_run(nodes: int) -> tuple[Fields, float]:
    """Run the same problem; return its fields and the seconds of the processor."""
    upper, lower = (
        sf.Material(density * speed**2, density, 0.25)
        for density, speed in ((2730.833867490239, 2620.0), (2745.739267606057, 3091.6))
    )
    law = sf.SlipWeakening(0.7, 0.6, 0.744e-3, delay=0.35e-3)

    def shear(x: Array) -> Array:
        return 82.81e6 + 4.0955e6 * patch(x, 4.0)

    fault = scene_along(upper, law, LENGTH, pressure=130e6, shear=shear, lower_material=lower)
    done, seconds = timed_run(fault, END, nodes, TIMES)
    fields = fields_of(done, "slip", "slip rate")
    return Fields(done.interface.t, done.interface.x, fields), seconds


def at_points(fields: Fields, seconds: float, count: int) -> GridRun:
    """Return the fields that are compared, of a run on so many nodes."""
    names = ("slip", "slip rate")
    values = {f"{name}, until {END:g} s": fields.at(name, TIMES, PLACES) for name in names}
    return GridRun(f"{LENGTH / count:.3g} m", values, seconds)


def main() -> None:
    """Run both codes in turn on three grids, and write the rows."""
    program, folder = places(__doc__, "PROGRAM", "FOLDER")
    pairs = []
    for count, nodes in GRIDS:
        theirs = at_points(*their_run(program, their_input(folder, count)), 2 * count)
        pairs.append((theirs, at_points(*our_run(nodes), nodes)))
    record("SEM2DPACK", "Bimaterial_fault, mended", COMMAND, pairs)


if __name__ == "__main__":
    main()
