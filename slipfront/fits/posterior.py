"""Posterior of the parameters of a fit, sampled by emcee."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from compare.records.record import Array
from semianalytic.inversion.fitting import Fit
from semianalytic.inversion.trials import Trials
from semianalytic.scene.checks import checked_count
from semianalytic.scene.errors import SceneError
from semianalytic.scene.extras import BAYES, require

AUTOCORRELATION_TIMES = 50
"""Length of a sufficient chain in autocorrelation times (the rule of emcee's authors)."""
BURN_IN = 3
"""Length of the discarded start of a chain, in autocorrelation times."""
FEWEST_WALKERS, WALKERS = 12, 6
"""Least number of walkers, and default number per parameter."""
CHECKED = 100
"""Number of steps between estimates of the autocorrelation time."""
STEPS = 2000
"""Default limit of the number of steps."""
RTOL = 1e-6
"""Relative accuracy of solutions; their error is far below any noise."""


@dataclass(frozen=True, eq=False)
class Posterior:
    """Samples of the posterior probability of the parameters of a fit.

    Attributes
    ----------
    parameters : tuple of str
    samples : (n, p) array
        Samples of all walkers after the burn-in, one every half autocorrelation time, in the units
        of the scene.  The priors multiply a density that is flat in these parameters.
    log_probability : (n,) array
        Logarithm of the posterior density of the samples, up to a constant.
    autocorrelation_time : (p,) array
        Autocorrelation time of each parameter [steps].
    steps, walkers, seed : int
    acceptance : float
        Fraction of proposals that were accepted.
    status : str
        "converged", or "unresolved: ..." if chains are shorter than `AUTOCORRELATION_TIMES`.
    """

    parameters: tuple[str, ...]
    samples: Array
    log_probability: Array
    autocorrelation_time: Array
    steps: int
    walkers: int
    seed: int
    acceptance: float
    status: str

    def __repr__(self) -> str:
        rows = zip(self.parameters, self.mean, self.standard_deviations, strict=True)
        values = ", ".join(f"{name} {mean:.5g} ± {sd:.2g}" for name, mean, sd in rows)
        return f"<Posterior: {values}; {len(self.samples)} samples; {self.status}>"

    @property
    def mean(self) -> Array:
        """Mean of each parameter, (p,), in the units of the scene."""
        return np.asarray(self.samples.mean(axis=0))

    @property
    def covariance(self) -> Array:
        """Covariance of the samples, (p, p)."""
        return np.atleast_2d(np.cov(self.samples.T))

    @property
    def standard_deviations(self) -> Array:
        """Standard deviation of each parameter, (p,)."""
        return np.sqrt(np.diag(self.covariance))

    def quantiles(self, *shares: float) -> Array:
        """Return quantiles of each parameter, (len(shares), p).

        Parameters
        ----------
        *shares : float
            Fractions of the samples that lie below the quantiles, from 0 to 1.
        """
        return np.asarray(np.quantile(self.samples, shares, axis=0))


def posterior(
    fit: Fit,
    *,
    steps: int = STEPS,
    walkers: int | None = None,
    seed: int = 0,
    pool: Any = None,
    progress: Callable[[int, int], object] | None = None,
) -> Posterior:
    """Sample the posterior of a fit; every sample is a full solution, nothing is interpolated.

    Sampling ends when chains are 50 autocorrelation times long, or after `steps`.

    Parameters
    ----------
    fit : Fit
        Fit that supplies gauges and priors; without a prior, the density of an unknown is flat.
    steps : int
        Largest number of steps.
    walkers : int, optional
        Number of walkers; the larger of 12 and 6 per parameter by default.
    seed : int
        The same seed gives the same samples.
    pool : optional
        Pool with a method `map` that calls a function in several processes, such as
        `multiprocessing.Pool`.
    progress : callable, optional
        Called with (step, steps) after each step.

    Returns
    -------
    Posterior

    Raises
    ------
    SceneError
        If a number is out of range, or data and priors leave a parameter unconstrained.
    MissingLibraryError
        If emcee is not installed.
    """
    require("posterior", *BAYES)
    import emcee

    p = len(fit.parameters)
    steps = checked_count("posterior: steps", steps, 2, "a whole number of at least")
    walkers = walkers or max(FEWEST_WALKERS, WALKERS * p)
    walkers = checked_count("posterior: walkers", walkers, 2 * p, "a whole number of at least")
    seed = checked_count("posterior: seed", seed, 0, "a whole number of at least")
    if fit.unconstrained:
        raise SceneError(
            f"posterior: the data do not constrain {' and '.join(fit.unconstrained)}; give "
            f"{'it' if len(fit.unconstrained) == 1 else 'them'} a prior, or fit fewer parameters."
        )
    known = fit.trials
    density = _Density(type(known)(known.samples, known.unknowns, known.priors, RTOL))
    moves = [(emcee.moves.DEMove(), 0.8), (emcee.moves.DESnookerMove(), 0.2)]
    sampler = emcee.EnsembleSampler(walkers, p, density, moves=moves, pool=pool)
    random = np.random.RandomState(seed)
    start = emcee.State(_start(fit, density, walkers, random), random_state=random.get_state())
    times = np.full(p, np.inf)
    for step, _ in enumerate(sampler.sample(start, iterations=steps), 1):
        if progress is not None:
            progress(step, steps)
        if step % CHECKED == 0:
            times = sampler.get_autocorr_time(tol=0)
            if step > (AUTOCORRELATION_TIMES + BURN_IN) * times.max():
                break
    times = sampler.get_autocorr_time(tol=0)
    longest = float(times.max()) if np.all(np.isfinite(times)) else float(step)
    forgotten = min(int(BURN_IN * longest), step // 2)
    thin = max(int(longest / 2), 1)
    status = "converged"
    if not step - forgotten >= AUTOCORRELATION_TIMES * longest:
        status = (
            f"unresolved: chains of {step} steps are shorter than {AUTOCORRELATION_TIMES} "
            f"autocorrelation times of about {longest:.0f}; take more `steps`"
        )
    return Posterior(
        parameters=fit.parameters,
        samples=sampler.get_chain(discard=forgotten, thin=thin, flat=True) * fit.trials.sizes,
        log_probability=sampler.get_log_prob(discard=forgotten, thin=thin, flat=True),
        autocorrelation_time=np.asarray(times),
        steps=step,
        walkers=walkers,
        seed=seed,
        acceptance=float(np.mean(sampler.acceptance_fraction)),
        status=status,
    )


@dataclass
class _Density:
    """Logarithm of the posterior density as a function of scaled parameters."""

    trials: Trials

    def __call__(self, scaled: Array) -> float:
        trials = self.trials
        low, high = trials.bounds
        if not np.all((scaled > low) & (scaled < high)):
            return -np.inf
        misfit = trials.misfit(scaled)[: len(trials.samples.t)]
        result = -float(np.sum(misfit**2)) / 2
        for name, value in zip(trials.unknowns.names, scaled * trials.sizes, strict=True):
            if name in trials.priors:
                result += trials.priors[name].log_density(float(value))
        return result if np.isfinite(result) else -np.inf


def _start(fit: Fit, density: _Density, walkers: int, random: np.random.RandomState) -> Array:
    """Draw starting positions (walkers, p) around the fit by its covariance.

    All have a finite density; the spread is halved while too many draws are impossible scenes.
    """
    size = fit.trials.sizes
    spread = np.linalg.cholesky(fit.covariance / np.outer(size, size))
    starts: list[Array] = []
    for trial in range(100 * walkers):
        shrunk = 0.5 ** (trial // (10 * walkers))
        one = fit.values / size + shrunk * spread @ random.standard_normal(len(size))
        if np.isfinite(density(one)):
            starts.append(one)
        if len(starts) == walkers:
            return np.array(starts)
    raise SceneError(
        "posterior: there are hardly any scenes around the fit; widen the priors or change scene."
    )
