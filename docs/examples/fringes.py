"""Draw isochromatic fringes in PMMA after a shock, as seen in a photoelastic experiment.

``python -m docs.examples.fringes [FOLDER]`` writes fringes.png.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import slipfront as sf
from compare.figures.style import describe, look, outline

# Fast: c_t 1345, c_l 2705 m/s, E = 5.7 GPa (Svetlizky & Fineberg, Nature 509, 205, 2014)
PMMA = sf.Material(shear_modulus=2.12e9, density=1170.0, poisson_ratio=0.336)
BASE, SHOCK = sf.Tractions(5e6, 0.0), sf.Tractions(0.0, 8e6)  # Pa
THICKNESS, FRINGE_CONSTANT = 0.03, 130e3  # m, N/m (Dally & Riley, Experimental Stress Analysis)
HEIGHT, TIME = 2e-3, 20e-6  # m, s


@look()
def main(folder: Path = Path(".")) -> np.ndarray:
    """Draw the fringes after 20 us and the fringe order at y = 2 mm; return the fringe order."""
    solution = sf.solve(sf.Scene(PMMA, 0.4, BASE, SHOCK, units="SI"))
    x = np.linspace(-0.06, 0.06, 400)  # [m]
    y = np.linspace(-0.03, 0.03, 200)[:, None]
    light = sf.fringes(solution.stress(x, y, TIME), THICKNESS, FRINGE_CONSTANT)
    order = sf.fringe_order(solution.stress(x, HEIGHT, TIME), THICKNESS, FRINGE_CONSTANT)
    figure = describe(Figure(figsize=(6, 5.2), layout="constrained"), solution.scene)
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
    above.imshow(light, cmap="gray", extent=(-60, 60, -30, 30), origin="lower", aspect="auto")
    above.axhline(1e3 * HEIGHT, color="C1", linewidth=1, path_effects=outline())
    below.plot(1e3 * x, order, color="C1")
    above.set(ylabel="y [mm]")
    below.set(xlabel="x [mm]", ylabel="fringe order at y = 2 mm", ylim=(0, None))
    figure.savefig(folder / "fringes.png", dpi=80)
    print(f"fringe order {order.min():.3f} to {order.max():.3f} along y = 2 mm")
    return order


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:2]))
