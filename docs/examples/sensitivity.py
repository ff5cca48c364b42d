"""Draw how slip rate depends on friction and load, and fit both with an error ellipse.

``python -m docs.examples.sensitivity [FOLDER]`` writes sensitivity.png.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import slipfront as sf
from compare.figures.style import describe, look

STEEL = sf.Material(shear_modulus=80e9, density=7800.0, poisson_ratio=0.29)
TRUTH = sf.Scene(STEEL, 0.2, base=sf.Tractions(5e6, 0.0), load=sf.Tractions(0.0, 5e6), units="SI")
NAMES, PLACES, NOISE = ("friction", "load_shear"), (0.05, 0.1), 0.004  # [m], [m/s]


@look()
def main(folder: Path = Path(".")) -> sf.Fit:
    """Draw derivatives of slip rate, fit two noisy records, and return the fit."""
    solution, t = sf.solve(TRUTH), np.linspace(1e-6, 1.2e-4, 100)  # [s]
    random = np.random.default_rng(5)
    records = [(x, solution.slip_rate(x, t) + random.normal(0, NOISE, 100)) for x in PLACES]
    gauges = [sf.Gauge(x, t, rate, NOISE) for x, rate in records]
    start = replace(TRUTH, friction=0.3, load=sf.Tractions(0.0, 6e6))
    fit = sf.fit(gauges, start, NAMES, rtol=1e-6)

    figure = describe(Figure(figsize=(8, 3.4), layout="constrained"), TRUTH)
    left, right = figure.subplots(1, 2)
    xi = np.linspace(0.01, 1.6, 1500)
    for name, size in (("friction", 0.2), ("poisson_ratio", 0.29), ("load_shear", 5e6)):
        derivative = solution.derivative(name)
        change = size * derivative.slip_rate(xi * STEEL.shear_speed, 1.0)
        left.plot(xi, change, label=name.replace("_", " "))
    left.set(xlabel="$x / (c_t t)$", ylabel="derivative of slip rate × value [m/s]")
    left.set(ylim=(-0.8, 0.8))
    left.legend()
    values, vectors = np.linalg.eigh(fit.covariance * np.outer([1, 1e-6], [1, 1e-6]))
    angle = np.linspace(0, 2 * np.pi, 200)
    circle = np.sqrt(5.99 * values)[:, None] * np.stack([np.cos(angle), np.sin(angle)])
    right.plot(*(fit.values * [1, 1e-6] + (vectors @ circle).T).T, label="95 % of fits")
    right.plot(0.2, 5.0, "k+", label="truth")
    right.set(xlabel="friction", ylabel="step of shear [MPa]")
    right.locator_params(axis="x", nbins=4)
    right.legend()
    figure.savefig(folder / "sensitivity.png", dpi=100)
    (f, q), (df, dq) = fit.values, fit.standard_errors
    print(f"friction {f:.4f} ± {df:.4f}, shear {q / 1e6:.3f} ± {dq / 1e6:.3f} MPa")
    return fit


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:2]))
