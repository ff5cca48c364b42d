"""Write field snapshots for ParaView, which opens snapshots/fields.pvd, and draw one of them.

``python -m docs.examples.paraview_snapshots [FOLDER]`` writes snapshots/ and
paraview_snapshots.png.
"""

from __future__ import annotations

import sys
from pathlib import Path

import meshio
import numpy as np
from matplotlib.figure import Figure
from matplotlib.tri import Triangulation

import slipfront as sf
from compare.figures.style import describe, look


@look()
def main(folder: Path = Path(".")) -> int:
    """Simulate a remote shock with ten snapshots; return the number of snapshots."""
    snapshots = folder / "snapshots"
    scene = sf.find("remote-shock")
    simulation = sf.simulate(scene, resolution=30, snapshots=snapshots, frames=10)
    pictures = sorted(snapshots.glob("*.vtu"))
    last = meshio.read(pictures[-1])
    speed = max(float(np.abs(field).max()) for field in last.point_data.values())

    squares = last.cells_dict["quad"]
    triangles = np.concatenate([squares[:, :3], squares[:, [0, 2, 3]]])
    figure = describe(Figure(figsize=(6, 3.4), layout="constrained"), scene)
    axes = figure.subplots()
    x, y, _ = last.points.T
    across = last.point_data["velocity"][:, 0]  # along the interface, per node
    drawn = axes.tripcolor(Triangulation(x, y, triangles), across, shading="gouraud")
    figure.colorbar(drawn, label="velocity $v_x$")
    axes.set(xlabel="$x / (c_t T)$", ylabel="$y / (c_t T)$", xlim=(-2.2, 2.2), ylim=(-1.2, 1.2))
    figure.savefig(folder / "paraview_snapshots.png", dpi=100)
    names = ", ".join([*last.point_data, *last.cell_data])
    print(
        f"{len(pictures)} pictures of {len(last.points)} nodes until t = {simulation.end_time:g} "
        f"in {snapshots / 'fields.pvd'}: {names} (largest nodal value {speed:.3g})"
    )
    return len(pictures)


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:2]))
