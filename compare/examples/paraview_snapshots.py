"""Field snapshots for ParaView: open snapshots/fields.pvd there.

``python -m compare.examples.paraview_snapshots [FOLDER]`` writes the folder snapshots.
"""

from __future__ import annotations

import sys
from pathlib import Path

import meshio
import numpy as np

from fem import simulate
from semianalytic.scene.named import find_scene


def main(folder: Path = Path(".")) -> int:
    """Simulate a remote shock with ten pictures; return the number of pictures."""
    snapshots = folder / "snapshots"
    simulation = simulate(find_scene("remote-shock"), resolution=30, snapshots=snapshots, frames=10)
    pictures = sorted(snapshots.glob("*.vtu"))
    last = meshio.read(pictures[-1])
    speed = max(float(np.abs(field).max()) for field in last.point_data.values())
    names = ", ".join([*last.point_data, *last.cell_data])
    print(
        f"{len(pictures)} pictures of {len(last.points)} nodes until t = {simulation.end_time:g} "
        f"in {snapshots / 'fields.pvd'}: {names} (largest nodal value {speed:.3g})"
    )
    return len(pictures)


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:2]))
