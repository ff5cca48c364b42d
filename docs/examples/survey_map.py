"""Survey a plane of friction and Poisson ratio, 100 × 100 scenes, as NetCDF, and draw it.

``python -m docs.examples.survey_map [FOLDER]`` writes survey_map.nc and survey_map.png.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import slipfront as sf
from compare.figures.style import describe, look, outline

SCENE = sf.find("preloaded")  # constant pressure, sudden shear


@look()
def main(folder: Path = Path("."), *, side: int = 100) -> float:
    """Survey the plane and draw it; return the largest error estimate."""
    data = sf.survey(
        SCENE,
        friction=np.linspace(0.1, 0.9, side),
        poisson_ratio=np.linspace(0.1, 0.45, side),
        rtol=1e-6,
        path=folder / "survey_map.nc",  # an interrupted survey resumes from here
    )
    speed = data.edges.sel(zone=0, edge="outer") / data.rayleigh_speed  # edge of the first zone
    two = (data.sense != 0).sum("zone") > 1
    figure = Figure(figsize=(6, 3.6), layout="constrained")
    axes = figure.subplots()
    plane = data.friction, data.poisson_ratio
    drawn = axes.pcolormesh(*plane, speed.T, cmap="cividis", shading="nearest")
    axes.contour(*plane, two.T, [0.5], colors="k", linewidths=1.5)
    for x, y, words in ((0.13, 0.4, "two zones"), (0.6, 0.3, "one zone")):
        axes.text(x, y, words, path_effects=outline())
    axes.set(xlabel="friction $f P_b / Q_0$", ylabel="Poisson ratio ν")
    figure.colorbar(drawn, label="edge of the first zone over $c_R$")
    describe(figure, "ν = 0.1 to 0.45, f = 0.1 to 0.9, shear step on constant pressure")
    figure.savefig(folder / "survey_map.png", dpi=100)
    low, high = float(speed.min()), float(speed.max())
    sound = "all" if (data.status == "converged").all() else "not all"
    print(f"{sound} converged; the first zone ends at {low:.4f} to {high:.4f} c_R")
    return float(data.error_estimate.max())


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:2]))
