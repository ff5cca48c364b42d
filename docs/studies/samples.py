"""Make records like those of a laboratory: ``python -m docs.studies.samples [FOLDER]``.

The scene has strain gauges 3.5 mm off the interface and a line of image correlation in PMMA, as
around the ruptures of Svetlizky & Fineberg (Nature 509, 205, 2014), and slip across the interface
as image correlation sees it.  It is marched, so that it shares no zone or edge with the solver that
fits it.  The records have noise, and a clock that runs ahead of the load.  The program writes
pmma_gauges.csv, pmma_line.csv and pmma_slip.csv to FOLDER, which is docs/data by default.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import slipfront as sf
from compare.output.places import write_text

FOLDER = Path(__file__).resolve().parents[2] / "docs" / "data"
COMMAND = "python -m docs.studies.samples docs/data"
PMMA = sf.Material(shear_modulus=2.12e9, density=1170.0, poisson_ratio=0.336)
TRUTH = sf.Scene(PMMA, 0.35, sf.Tractions(5e6, 0.0), sf.Tractions(0.0, 4e6), units="SI")
TRIGGER = 3e-6
"""Time of the load on the clock of the records [s]."""
GAUGES, HEIGHT = (0.02, 0.04, 0.06), 3.5e-3
"""Positions of the gauges along the interface, and their height above it [m]."""
STRAIN_NOISE, MOTION_NOISE, SLIP_NOISE = 30e-6, 2e-6, 1e-6
"""Standard deviations of strain [1], motion [m] and slip [m]."""
END, NODES = 80e-6, 1600


def main(folder: Path = FOLDER) -> None:
    """March the scene, record it with noise, and write the files."""
    march = sf.solve(TRUTH, method="space-time", end_time=END, nodes=NODES)
    random = np.random.default_rng(11)
    rows = ["t [us],x [mm],y [mm],exx [ustrain],eyy [ustrain],exy [ustrain]"]
    t = np.arange(0.0, 71.0) * 1e-6
    for place in GAUGES:
        stress = march.stress(place, HEIGHT, np.maximum(t - TRIGGER, 0.0))
        strain = sf.strain(stress - march.stress(place, HEIGHT, np.zeros(1)), PMMA)
        strain += random.normal(scale=STRAIN_NOISE, size=strain.shape)
        for number, time in enumerate(t):
            values = ",".join(f"{value * 1e6:.0f}" for value in strain[:, number])
            rows.append(f"{time * 1e6:g},{place * 1e3:g},{HEIGHT * 1e3:g},{values}")
    _write(folder / "pmma_gauges.csv", rows)
    rows = ["t [us],x [mm],y [mm],ux [um]"]
    x = np.arange(-20.0, 81.0, 4.0) * 1e-3
    for time in (20e-6, 40e-6, 60e-6):
        motion = march.displacement(x, HEIGHT, time - TRIGGER)[0]
        motion = motion + random.normal(scale=MOTION_NOISE, size=len(x))
        for at, value in zip(x.tolist(), motion.tolist(), strict=True):
            rows.append(f"{time * 1e6:g},{at * 1e3:g},{HEIGHT * 1e3:g},{value * 1e6:.2f}")
    _write(folder / "pmma_line.csv", rows)
    rows = ["t [us],x [mm],slip [um],noise [um]"]
    t = np.arange(0.0, 71.0, 2.0) * 1e-6
    for place in GAUGES:
        slip = march.slip(place, np.maximum(t - TRIGGER, 0.0))
        slip = slip + random.normal(scale=SLIP_NOISE, size=len(t))
        for time, value in zip(t.tolist(), slip.tolist(), strict=True):
            rows.append(f"{time * 1e6:g},{place * 1e3:g},{value * 1e6:.2f},{SLIP_NOISE * 1e6:g}")
    _write(folder / "pmma_slip.csv", rows)


def _write(path: Path, rows: list[str]) -> None:
    write_text(path, "\n".join([f"# {COMMAND}", *rows, ""]))


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:2]))
