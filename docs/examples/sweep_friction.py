"""Draw front speeds against friction, with the closed form of a single zone.

``python -m docs.examples.sweep_friction [FOLDER]`` writes sweep_friction.png.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import slipfront as sf
from compare.figures.style import describe, look
from semianalytic.reference import edge_speed_under_shear_step

MATERIAL = sf.Material(1.0, 1.0, 1 / 3)
SCENE = sf.Scene(MATERIAL, 0.3, base=sf.Tractions(1.0, 0.0), load=sf.Tractions(0.0, 1.0))


@look()
def main(folder: Path = Path(".")) -> float:
    """Draw the edges of all zones; return the largest difference from the closed form."""
    friction = np.linspace(0.1, 1.0, 91)
    swept = sf.sweep(SCENE, friction, rtol=1e-8)
    edges = swept.edges  # (frictions, zones, 2), NaN where there are fewer zones
    closed = np.array([edge_speed_under_shear_step(MATERIAL, f) for f in friction])
    alone = np.array([len(solution.zones) == 1 for solution in swept.solutions])
    difference = float(np.abs(edges[alone, 0, 1] / closed[alone] - 1).max())

    figure = describe(
        Figure(figsize=(6, 3.4), layout="constrained"),
        "ν = 1/3, a step of shear $Q_0$ on pressure $P_b$",
    )
    axes = figure.subplots()
    axes.plot(friction, edges.reshape(len(friction), -1), ".", color="C0", markersize=3)
    axes.plot(friction[alone], closed[alone], "k--", linewidth=1, label="closed form, one zone")
    axes.set(xlabel="$f P_b / Q_0$", ylabel="speed of zone edges $/ c_t$", ylim=(0, 2.05))
    axes.legend()
    figure.savefig(folder / "sweep_friction.png", dpi=100)
    scratch = int(swept.from_scratch.sum())
    print(
        f"{len(friction)} frictions, {scratch} of them solved without a neighbour; "
        f"largest difference from the closed form {difference:.1e}"
    )
    return difference


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:2]))
