"""Recover the friction coefficient from a noisy record of slip rate.

``python -m docs.examples.fit_friction [FOLDER]`` writes fit_friction.csv and .png.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from scipy.optimize import least_squares

import slipfront as sf
from compare.figures.style import describe, look

STEEL = sf.Material(shear_modulus=80e9, density=7800.0, poisson_ratio=0.29)
SCENE = sf.Scene(STEEL, 0.5, base=sf.Tractions(5e6, 0.0), load=sf.Tractions(0.0, 5e6))
PLACE, TRUE, NOISE = 0.05, 0.43, 0.05  # [m], friction to be found, share of the largest slip rate


@look()
def main(folder: Path = Path(".")) -> float:
    """Make a record, fit friction to it, and return the fitted friction."""
    t = np.linspace(2e-6, 8e-5, 120)  # [s]
    clean = sf.solve(replace(SCENE, friction=TRUE), rtol=1e-6).slip_rate(PLACE, t)
    noise = np.random.default_rng(7).standard_normal(len(t))
    record = clean + NOISE * clean.max() * noise

    def misfit(friction: np.ndarray) -> np.ndarray:
        trial = sf.solve(replace(SCENE, friction=float(friction[0])), rtol=1e-6)
        return np.asarray(trial.slip_rate(PLACE, t) - record) / clean.max()

    fit = least_squares(misfit, x0=[0.8], bounds=(0.05, 1.5), diff_step=[1e-4])
    # standard deviation of the fitted friction
    error = NOISE / float(np.linalg.norm(np.asarray(fit.jac)))
    fitted = fit.fun * clean.max() + record
    head = "time [s],recorded slip rate [m/s],fitted slip rate [m/s]"
    columns = np.column_stack([t, record, fitted])
    np.savetxt(folder / "fit_friction.csv", columns, delimiter=",", header=head, comments="")
    figure = describe(
        Figure(figsize=(6, 3.4), layout="constrained"), f"ν = 0.29, f = {TRUE:g}, steel"
    )
    axes = figure.subplots()
    axes.plot(1e6 * t, record, ".", color="0.5", label="record at 50 mm")
    axes.plot(1e6 * t, fitted, label=f"fit, friction {fit.x[0]:.3f} ± {error:.3f}")
    axes.set(xlabel="time [µs]", ylabel="slip rate [m/s]")
    axes.legend()
    figure.savefig(folder / "fit_friction.png", dpi=100)
    print(f"friction {fit.x[0]:.4f} ± {error:.4f}, true {TRUE}")
    return float(fit.x[0])


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:2]))
