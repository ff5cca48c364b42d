"""Sample the posterior of a fit by emcee: two gains of which data constrain only the product.

``python -m docs.examples.posterior [FOLDER]`` writes posterior.png.
"""

from __future__ import annotations

import sys
from pathlib import Path

import emcee
import numpy as np
from matplotlib.figure import Figure

import slipfront as sf
from compare.figures.style import describe, look
from semianalytic.scene.arrays import Array

SCENE = sf.find("preloaded")
NAMES, NOISE, WALKERS, STEPS = ("gain", "gain:left"), 0.1, 12, 1500


@look()
def main(folder: Path = Path(".")) -> Array:
    """Fit the gains of an amplifier and of its gauge, and return samples of their posterior."""
    t, random = np.linspace(0.5, 2.0, 10), np.random.RandomState(1)
    record = 1.1 * sf.solve(SCENE).slip_rate(0.4, t) + random.normal(0, NOISE, len(t))
    gauge = sf.Gauge(0.4, t, record, NOISE, name="left")
    known = dict.fromkeys(NAMES, sf.LogNormal(median=1.0, factor=1.4))
    fit = sf.fit([gauge], SCENE, NAMES, priors=known)

    start = random.multivariate_normal(fit.values, fit.covariance / 4, WALKERS)
    moves = [(emcee.moves.DEMove(), 0.8), (emcee.moves.DESnookerMove(), 0.2)]
    sampler = emcee.EnsembleSampler(WALKERS, 2, fit.log_density, moves=moves)
    sampler.run_mcmc(emcee.State(start, random_state=random.get_state()), STEPS)
    time = sampler.get_autocorr_time(tol=50).max()  # an error if chains are too short
    samples = np.asarray(sampler.get_chain(discard=int(3 * time), thin=int(time / 2), flat=True))

    words = "samples of the posterior of both gains, slip rate of preloaded: ν = 1/3, f = 0.25"
    figure = describe(Figure(figsize=(5, 4), layout="constrained"), words)
    axes = figure.subplots()
    axes.plot(*samples.T, ".", markersize=2, label="samples")
    (x, y), (dx, dy) = fit.values, fit.standard_errors
    axes.errorbar(x, y, dy, dx, "o", label="fit and standard errors")
    axes.set(xlabel="gain of the amplifier [1]", ylabel="gain of the gauge [1]")
    axes.legend()
    figure.savefig(folder / "posterior.png", dpi=100)
    low, high = np.quantile(samples[:, 0], (0.05, 0.95))
    print(f"gain {fit.values[0]:.2f} ± {fit.standard_errors[0]:.2f}; from {low:.2f} to {high:.2f}")
    return samples


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:2]))
