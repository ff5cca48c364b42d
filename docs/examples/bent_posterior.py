"""Fit two gains of which data constrain only the product: the posterior is no ellipse.

``python -m docs.examples.bent_posterior [FOLDER]`` writes bent_posterior.png.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import slipfront as sf
from slipfront.fits.figures import fit_figure

SCENE = sf.find("preloaded")
NAMES, NOISE = ("gain", "gain:left"), 0.1


def main(folder: Path = Path(".")) -> sf.Posterior:
    """Fit the gains of an amplifier and of its gauge, sample the posterior, and return it."""
    t = np.linspace(0.5, 2.0, 10)
    clean = 1.1 * sf.solve(SCENE).slip_rate(0.4, t)
    record = clean + np.random.default_rng(1).normal(0, NOISE, len(t))
    gauge = sf.Gauge(0.4, t, record, NOISE, name="left")
    known = dict.fromkeys(NAMES, sf.LogNormal(median=1.0, factor=1.4))
    fit = sf.fit([gauge], SCENE, NAMES, priors=known)
    posterior = sf.posterior(fit, steps=1500, seed=1)
    fit_figure(fit, posterior).savefig(folder / "bent_posterior.png", dpi=60)
    low, high = posterior.quantiles(0.05, 0.95)[:, 0]
    farther = "above" if low + high > 2 * fit.values[0] else "below"
    print(
        f"gain {fit.values[0]:.2f} ± {fit.standard_errors[0]:.2f}; "
        f"its posterior, {posterior.status}, reaches farther {farther} than its ellipse"
    )
    return posterior


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:2]))
