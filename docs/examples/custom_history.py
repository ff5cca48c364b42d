"""March a scene in time under a measured load signal, save the march, and continue it.

``python -m docs.examples.custom_history [FOLDER]`` writes custom_history.h5 and .png.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import slipfront as sf
from compare.figures.style import describe, look

ALUMINIUM = sf.Material(shear_modulus=26e9, density=2700.0, poisson_ratio=0.34)


@look()
def main(folder: Path = Path(".")) -> float:
    """March under a signal, save, continue; return the slip near the edge [m]."""
    t = np.linspace(0, 60e-6, 121)  # [s]; for a file: np.loadtxt("signal.csv").T
    signal = np.exp(-t / 30e-6) * np.sin(2 * np.pi * t / 40e-6)
    scene = sf.Scene(
        ALUMINIUM,
        friction=0.2,
        base=sf.Tractions(pressure=4e6, shear=0.0),
        load=sf.Tractions(pressure=0.0, shear=3e6),
        shear_history=sf.Tabulated(tuple(t), tuple(signal / signal.max())),
        units="SI",
    )
    first = sf.solve(
        scene, method="space-time", end_time=30e-6, nodes=300, length=0.15, latest=60e-6
    )
    first.save(folder / "custom_history.h5")
    whole = sf.solve(scene, go_on=sf.Marched.load(folder / "custom_history.h5"), end_time=60e-6)
    history = whole.interface
    x, slip = float(history.x[0]), float(history.slip[-1, 0])
    part = float((history.slip_rate < 0).mean())

    figure = describe(Figure(figsize=(6, 3.4), layout="constrained"), scene)
    axes = figure.subplots()
    largest = float(np.quantile(np.abs(history.slip_rate), 0.995))
    shown = axes.pcolormesh(
        1e3 * history.x, 1e6 * history.t, history.slip_rate, cmap="RdBu_r", rasterized=True
    )
    shown.set_clim(-largest, largest)
    figure.colorbar(shown, label="slip rate [m/s]")
    axes.set(xlabel="distance from the edge of the slot [mm]", ylabel="time [µs]")
    figure.savefig(folder / "custom_history.png", dpi=100)
    print(
        f"slip {1e6 * slip:.3f} µm, accumulated slip {1e6 * whole.final_path[0]:.3f} µm "
        f"at x = {1e3 * x:.2f} mm; "
        f"work at most {whole.final_work_density.max():.3g} J/m²; {part:.1%} of the map reversed"
    )
    return slip


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:2]))
