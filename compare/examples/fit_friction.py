"""Recover the friction coefficient from a noisy record of slip rate.

``python -m compare.examples.fit_friction [FOLDER]`` writes fit_friction.csv.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

from semianalytic import Material, Scene, Tractions, solve

STEEL = Material(shear_modulus=80e9, density=7800.0, poisson_ratio=0.29)
SCENE = Scene(STEEL, 0.5, base=Tractions(5e6, 0.0), load=Tractions(0.0, 5e6))
PLACE, TRUE, NOISE = 0.05, 0.43, 0.05  # [m], friction to be found, part of the largest slip rate


def main(folder: Path = Path(".")) -> float:
    """Make a record, fit friction to it, and return what was found."""
    t = np.linspace(2e-6, 8e-5, 120)  # [s]
    clean = solve(replace(SCENE, friction=TRUE), rtol=1e-6).slip_rate(PLACE, t)
    noise = np.random.default_rng(7).standard_normal(len(t))
    record = clean + NOISE * clean.max() * noise

    def misfit(friction: np.ndarray) -> np.ndarray:
        trial = solve(replace(SCENE, friction=float(friction[0])), rtol=1e-6)
        return np.asarray(trial.slip_rate(PLACE, t) - record) / clean.max()

    fit = least_squares(misfit, x0=[0.8], bounds=(0.05, 1.5), diff_step=[1e-4])
    error = NOISE / float(
        np.linalg.norm(np.asarray(fit.jac))
    )  # standard deviation of the coefficient
    columns = np.column_stack([t, record, fit.fun * clean.max() + record])
    head = "time [s],recorded slip rate [m/s],fitted slip rate [m/s]"
    np.savetxt(folder / "fit_friction.csv", columns, delimiter=",", header=head, comments="")
    print(f"friction {fit.x[0]:.4f} ± {error:.4f}, true {TRUE}")
    return float(fit.x[0])


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:2]))
