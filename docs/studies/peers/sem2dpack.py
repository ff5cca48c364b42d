"""SCEC TPV3 in two dimensions, in plane and antiplane, against SEM2DPACK's own examples.

``python -m docs.studies.peers.sem2dpack PROGRAM FOLDER`` writes rows of docs/data/peers.csv.
PROGRAM is SEM2DPACK's solver, FOLDER a checkout of github.com/jpampuero/sem2dpack, whose examples
EXAMPLES/TestFlt2D_SCEC_TPV3_inplane and _antiplane are run on three grids; neither is part of this
package.
"""

from __future__ import annotations

import re
import shutil
import tempfile
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.interpolate import RegularGridInterpolator

import semianalytic as sf
from docs.studies.peers.rows import (
    Array,
    GridRun,
    fields_of,
    places,
    record,
    seconds_of,
    timed_run,
)

COMMAND = "python -m docs.studies.peers.sem2dpack PROGRAM FOLDER"
FIELDS = {"Slip": "slip", "Slip_Rate": "slip rate", "Shear_Stress": "shear traction"}
PLACES = np.arange(250.0, 14.8e3, 250.0)
"""Points [m] of their fault and ours at which both are compared.  Those at the ends of a patch show
in tractions: there one code starts from the shear of one side, the other from the mean of both."""
RECORD_MARK = 4
"""Bytes before and after each record of a sequential file of Fortran."""


@dataclass(frozen=True)
class Problem:
    """An example of theirs, its grids, and when [s] a wave may be back from its boundaries.

    `edit` makes their input that of a grid; `depth` is whether their fault is along their depth.
    """

    example: str
    grids: Mapping[int, str]
    edit: Callable[[str, int], str]
    until: float
    depth: bool


@dataclass(frozen=True)
class Fields:
    """Fields (m, n) by quantity, at times (m,) and positions (n,)."""

    t: Array
    x: Array
    values: dict[str, Array]

    def at(self, quantity: str, t: Array, x: Array) -> Array:
        """Return a field between its times and positions, linearly."""
        spline = RegularGridInterpolator((self.t, self.x), self.values[quantity])
        return np.asarray(spline(tuple(np.meshgrid(t, x, indexing="ij"))))


def _elements(text: str, count: int) -> str:
    return re.sub(r"nelem *= *\d+ *, *\d+", f"nelem={count},{count * 4 // 7}", text)


def _points(text: str, count: int) -> str:
    return re.sub(r"ngll *= *\d+", f"ngll={count}", text)


PROBLEMS = (
    Problem("inplane", {35: "200 m", 70: "100 m", 105: "67 m"}, _elements, 6.6, False),
    Problem("antiplane", {4: "167 m", 6: "100 m", 8: "71 m"}, _points, 8.6, True),
)
NODES, END = (960, 1920, 3840), 12.0


def plain_input(folder: Path) -> str:
    """Return the input of an example without what is commented out, and without its plots.

    The namelists of gfortran begin at & wherever it stands, also behind a #.
    """
    lines = (folder / "Par.inp").read_text().splitlines()
    kept = [line for line in lines if not re.match(r" *(#|&SNAP|&REC)", line)]
    text = re.sub(r"/ *#.*", "/", "\n".join(kept) + "\n")
    return re.sub(r"ItInfo *= *\d+", "ItInfo=100000", text)


def their_input(folder: Path, problem: Problem, count: int) -> str:
    """Return the input of an example on one grid."""
    text = problem.edit(plain_input(folder), count)
    text = re.sub(r"(TtH='PWCONR' *),[^/]*/", r"\1, otd=0.02d0 /", text)
    return re.sub(r"TotalTime *= *[\d.d]+", f"TotalTime={END}d0", text)


def their_run(
    program: Path, text: str, depth: bool = False, meshes: Iterable[Path] = ()
) -> tuple[Fields, float]:
    """Run an input next to its meshes; return its fields and the seconds of the processor."""
    with tempfile.TemporaryDirectory() as scratch:
        here = Path(scratch)
        for mesh in meshes:
            shutil.copy(mesh, here)
        (here / "Par.inp").write_text(text)
        seconds = seconds_of([program.resolve()], here)
        return read_fault(next(here.glob("Flt*_sem2d.hdr")), depth), seconds


def read_fault(header: Path, depth: bool) -> Fields:
    """Return times, positions, and fields (m, n) of their fault; tractions are changes."""
    lines = header.read_text().splitlines()
    points, count, _, step = (float(word) for word in lines[1].split())
    names = lines[2].strip().split(":")
    places = np.array([[float(word) for word in line.split()] for line in lines[4:]])
    x: Array = -places[:, 1] if depth else places[:, 0]
    raw = np.fromfile(str(header)[:-3] + "dat", dtype=np.uint8)
    marked = raw.reshape(-1, 4 * int(points) + 2 * RECORD_MARK)[:, RECORD_MARK:-RECORD_MARK]
    data = np.ascontiguousarray(marked).view("<f4").astype(float)
    data = data.reshape(-1, int(count), int(points))
    order = np.argsort(x)
    fields = {quantity: data[:, names.index(name)][:, order] for name, quantity in FIELDS.items()}
    return Fields(step * np.arange(float(len(data))), x[order], fields)


def patch(x: Array, half: float) -> Array:
    """Return 2 within a patch |x| < half [m], 0 beyond it, and the mean at its ends."""
    away = np.abs(x)
    return np.asarray((away < half - 1e-6) + 1.0 * (away < half + 1e-6))


def our_run(problem: Problem, nodes: int, times: Array) -> tuple[Fields, float]:
    """Run the same problem; return its fields and the seconds of the processor."""
    given = sf.find("tpv205")
    centre = 7.5e3 if problem.depth else 0.0

    def shear(x: Array) -> Array:
        return 70e6 + 5.8e6 * patch(np.abs(x) - centre, 1.5e3)

    mode = "antiplane" if problem.depth else "in-plane"
    fault = replace(given, base=replace(given.base, shear=shear), even=True, mode=mode)
    done, seconds = timed_run(fault, float(times[-1]), nodes, times)
    fields = fields_of(done, *FIELDS.values())
    fields["shear traction"] = fields["shear traction"] - fields["shear traction"][0]
    return Fields(done.interface.t, done.interface.x, fields), seconds


def at_points(problem: Problem, fields: Fields, grid: str, seconds: float) -> GridRun:
    """Return the fields that are compared: all until waves return, slip also until the end."""
    t = np.arange(0.05, END - 0.05, 0.02)
    spans = [*((name, problem.until) for name in FIELDS.values()), ("slip", END)]
    values = {
        f"{name}, until {until:g} s": fields.at(name, t[t < until], PLACES) for name, until in spans
    }
    return GridRun(grid, values, seconds)


def main() -> None:
    """Run both codes in turn on three grids, and write the rows."""
    program, folder = places(__doc__, "PROGRAM", "FOLDER")
    for problem in PROBLEMS:
        source = folder / "EXAMPLES" / f"TestFlt2D_SCEC_TPV3_{problem.example}"
        times, pairs = np.arange(0.0, END, 0.02), []
        for (count, spacing), nodes in zip(problem.grids.items(), NODES, strict=True):
            text, meshes = their_input(source, problem, count), source.glob("*.mesh2d")
            theirs, their_seconds = their_run(program, text, problem.depth, meshes)
            ours, our_seconds = our_run(problem, nodes, times)
            row = at_points(problem, theirs, spacing, their_seconds)
            pairs.append((row, at_points(problem, ours, f"{96e3 / nodes:g} m", our_seconds)))
        case = f"TPV3, {'antiplane' if problem.depth else 'in plane'}"
        record("SEM2DPACK", case, COMMAND, pairs)


if __name__ == "__main__":
    main()
