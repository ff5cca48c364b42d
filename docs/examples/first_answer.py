"""Find which parts of a steel interface slip, how fast, and when slip arrives at a point.

``python -m docs.examples.first_answer [FOLDER]`` writes first_answer.png.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import slipfront as sf
from compare.figures.style import describe, look

STEEL = sf.Material(shear_modulus=80e9, density=7800.0, poisson_ratio=0.29)  # Pa, kg/m3
SCENE = sf.Scene(
    STEEL,
    friction=0.25,
    base=sf.Tractions(pressure=5e6, shear=0.0),  # Pa, before the load
    load=sf.Tractions(pressure=0.0, shear=5e6),  # Pa, released on the slot at t = 0
    units="SI",
)
TIME = 1e-4  # [s]


@look()
def main(folder: Path = Path(".")) -> sf.Solution:
    """Solve the scene and draw its slip rate after 0.1 ms; return the solution."""
    solution = sf.solve(SCENE)
    x = np.linspace(1e-3, 1.25 * STEEL.shear_speed * TIME, 2000)  # [m]
    figure = describe(Figure(figsize=(6, 3.4), layout="constrained"), SCENE)
    axes = figure.subplots()
    axes.plot(1e3 * x, solution.slip_rate(x, TIME))
    for zone in solution.zones:
        axes.axvspan(1e3 * zone.inner * TIME, 1e3 * zone.outer * TIME, alpha=0.15)
    for name, speed in (("$c_R t$", STEEL.rayleigh_speed), ("$c_t t$", STEEL.shear_speed)):
        axes.axvline(1e3 * speed * TIME, color="0.5", linestyle=":", linewidth=1)
        axes.text(1e3 * speed * TIME - 2, 0.19, name, rotation=90, va="top", ha="right")
    axes.set(xlabel="distance from the edge of the slot [mm]", ylabel="slip rate [m/s]")
    axes.set(xlim=(0, 1e3 * x[-1]), ylim=(0, 0.2))
    figure.savefig(folder / "first_answer.png", dpi=100)
    edges = ", ".join(f"{zone.inner:.0f} to {zone.outer:.0f} m/s" for zone in solution.zones)
    print(f"slip from {edges}; {solution.slip_rate(0.1, TIME):.3f} m/s at 100 mm after 0.1 ms")
    return solution


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:2]))
