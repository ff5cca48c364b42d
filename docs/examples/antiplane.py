"""Compare the closed form in antiplane shear with all three solvers (units c_t = mu = 1).

``python -m docs.examples.antiplane [FOLDER]`` writes antiplane.png.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import slipfront as sf
from compare.figures.style import describe, look
from fem import simulate
from semianalytic.reference import antiplane_traction

CHI = 0.5  # friction times pressure over the shear step
EDGE = 1 / (1 + CHI) ** 2
SOLID = sf.Material(shear_modulus=1.0, density=1.0, poisson_ratio=0.25)
PRELOAD, SHEAR = sf.Tractions(pressure=1.0, shear=0.0), sf.Tractions(pressure=0.0, shear=1.0)
SCENE = sf.Scene(SOLID, friction=CHI, base=PRELOAD, load=SHEAR, mode="antiplane")


def slip_rate(xi: np.ndarray) -> np.ndarray:
    """Return the relative slip rate at similarity velocities x/t."""
    return np.asarray(4 / np.pi * np.arctan(np.sqrt(np.maximum(EDGE - xi, 0) / (1 + xi))))


@look()
def main(folder: Path = Path(".")) -> sf.Solution:
    """Draw the closed form and the answers of the three solvers; return the exact solution."""
    solution, marched = (
        sf.solve(SCENE, rtol=1e-11),
        sf.solve(SCENE, method="space-time", nodes=400).interface,
    )
    simulated, xi = simulate(SCENE, resolution=100).interface, np.linspace(1e-3, 1.1, 2000)
    figure, points = describe(Figure(figsize=(6, 4.6), layout="constrained"), SCENE), xi[20::60]
    upper, lower = figure.subplots(2, 1, sharex=True)
    upper.plot(xi, slip_rate(xi), "k", linewidth=1, label="closed form")
    upper.plot(xi, antiplane_traction(SOLID, 1.0, CHI, xi), "k--", linewidth=1)
    upper.plot(points, solution.slip_rate(points, 1.0), "o", mfc="none", label="solve")
    upper.plot(points, solution.shear_traction(points, 1.0), "s", mfc="none", color="C0", ms=4)
    for seen, style, name in ((marched, "C1-", "march"), (simulated, "C2-", "finite elements")):
        lower.plot(seen.x, seen.slip_rate[-1] - slip_rate(seen.x), style, lw=1, label=name)
    upper.text(0.62, 0.3, "shear traction / load")
    upper.text(0.17, 0.66, "slip rate / (load / impedance)")
    upper.legend(frameon=False)
    lower.legend(frameon=False)
    lower.set(xlabel="$x / (c_t t)$", ylabel="slip rate minus closed form", xlim=(0, 1.1))
    figure.savefig(folder / "antiplane.png", dpi=100)
    error = np.abs(solution.slip_rate(xi, 1.0) - slip_rate(xi))[np.abs(xi - EDGE) > 0.03].max()
    front = solution.zones[0].outer
    print(f"front at {front:.6f} c_t, that is 4/9; largest error of slip rate {error:.1e}")
    return solution


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:2]))
