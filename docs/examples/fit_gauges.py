"""Fit friction, pressure and trigger time to slip at three positions, with a prior.

``python -m docs.examples.fit_gauges [FOLDER]`` writes fit_gauges.png.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

import slipfront as sf
from slipfront.fits.figures import fit_figure

STEEL = sf.Material(shear_modulus=80e9, density=7800.0, poisson_ratio=0.29)
BASE, LOAD = sf.Tractions(5e6, 0.0), sf.Tractions(0.0, 5e6)
TRUTH = sf.Scene(STEEL, 0.2, BASE, LOAD, units="SI")
TRIGGER, NOISE = 4e-6, 0.1e-6  # [s], [m]
NAMES = ("friction", "base_pressure", "t0")


def fitted() -> sf.Fit:
    """Record slip with noise, and fit it."""
    solution, t = sf.solve(TRUTH), np.linspace(0.0, 1e-4, 51)
    random = np.random.default_rng(2)
    gauges = []
    for x in (0.03, 0.06, 0.12):  # [m]
        slip = solution.slip(x, t - TRIGGER) + random.normal(0, NOISE, len(t))
        gauges.append(sf.Gauge(x, t, slip, NOISE, quantity="slip"))
    guess = replace(TRUTH, friction=0.4)
    known = {"base_pressure": sf.Normal(5.2e6, 0.3e6)}  # reading of the load cell [Pa]
    return sf.fit(gauges, guess, NAMES, priors=known, rtol=1e-6)


def main(folder: Path = Path(".")) -> sf.Fit:
    """Fit slip, draw the fit, and return it."""
    fit = fitted()
    fit_figure(fit).savefig(folder / "fit_gauges.png", dpi=90)
    (f, p, t0), (df, dp, dt) = fit.values, fit.standard_errors
    print(
        f"friction {f:.3f} ± {df:.3f}, pressure {p / 1e6:.2f} ± {dp / 1e6:.2f} MPa, "
        f"trigger {t0 * 1e6:.2f} ± {dt * 1e6:.2f} µs; correlation {fit.correlation[0, 1]:.2f}"
    )
    return fit


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:2]))
