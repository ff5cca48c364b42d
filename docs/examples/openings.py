"""Draw a weakly pressed contact after a tap: it opens at the Rayleigh wave and closes behind it.

``python -m docs.examples.openings [FOLDER]`` writes openings.png.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import slipfront as sf
from compare.figures.style import describe, look

SOLID = sf.Material(shear_modulus=1.0, density=1.0, poisson_ratio=1 / 3)  # c_t = 1
BASE, TAP = sf.Tractions(pressure=0.02, shear=0.0), sf.Tractions(pressure=1.0, shear=0.5)


@look()
def main(folder: Path = Path(".")) -> list[sf.Solution]:
    """Draw gap, pressure, shear traction and slip rate for weak to strong friction."""
    figure, xi = Figure(figsize=(6.4, 6.8), layout="constrained"), np.linspace(5e-3, 2.05, 1200)
    describe(figure, "ν = 1/3, f = 0.1 to 10; step of pressure P₀ = 1, slip rate over P₀ / ρcₜ")
    normal, shear, rate = figure.subplots(3, 1, sharex=True)
    solutions = [sf.solve(sf.Scene(SOLID, friction, BASE, TAP)) for friction in (0.1, 1.0, 10.0)]
    for solution in solutions:
        friction = solution.scene.friction
        (line,) = shear.plot(xi, solution.shear_traction(xi, 1.0), label=f"friction {friction:g}")
        strength = friction * solution.pressure(xi, 1.0)
        shear.plot(xi, strength, ":", color=line.get_color())
        rate.plot(xi, solution.slip_rate(xi, 1.0), color=line.get_color())
    normal.plot(xi, solution.pressure(xi, 1.0), "k", label="pressure")
    normal.plot(xi, solution.gap(xi, 1.0), "k--", label="gap")
    normal.set(ylim=(0, 0.06))
    shear.set(ylim=(0, 0.3), ylabel="shear (strength dotted)")
    rate.set(ylim=(0, 0.5), ylabel="slip rate", xlabel="$x / (c_t t)$", xlim=(0, 2.05))
    (opening,) = solution.openings
    for panel in (normal, shear, rate):
        panel.axvspan(opening.inner, opening.outer, color="0.95", zorder=0)
    normal.legend(frameon=False)
    shear.legend(frameon=False)
    figure.savefig(folder / "openings.png", dpi=90)
    slipping = len(solution.zones)
    print(f"open from {opening.inner:.4f} to {opening.outer:.4f} c_t; {slipping} zone slips at 10")
    return solutions


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:2]))
