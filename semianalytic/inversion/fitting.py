"""Fits of unknown parameters to gauge records, by least squares with a search for all minima."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping, Sequence
from os import PathLike
from typing import Any

import numpy as np

from semianalytic.inversion.fitted import Fit
from semianalytic.inversion.gauges import Gauge, check_gauge
from semianalytic.inversion.intervals import intervals
from semianalytic.inversion.priors import LogNormal, Normal, Prior, Uniform
from semianalytic.inversion.samples import Samples
from semianalytic.inversion.search import ROUNDS, minima, refine
from semianalytic.inversion.trials import Trials
from semianalytic.inversion.unknowns import (
    Setup,
    Unknowns,
    check_exact,
    check_names,
    is_fitted_on_line,
    number_name,
    plain_name,
)
from semianalytic.inversion.verdict import covariance_of, verdict
from semianalytic.scene.arguments import checking
from semianalytic.scene.arrays import Array
from semianalytic.scene.checks import checked_number, checked_size, shown
from semianalytic.scene.errors import ComputationError, SceneError
from semianalytic.scene.given.finding import find, scene_of_one_solid
from semianalytic.scene.scene import Scene


@checking
def fit(
    gauges: Sequence[Gauge],
    scene: Scene | str | PathLike[str],
    parameters: str | Sequence[str],
    *,
    priors: Mapping[str, Prior] | None = None,
    setup: Setup | None = None,
    rtol: float = 1e-8,
    nodes: int | None = None,
    progress: Callable[[int, int], object] | None = None,
) -> Fit:
    """Fit parameters of a scene, and of the set-up, to records by least squares.

    Parameters
    ----------
    gauges : sequence of Gauge
        Records, each with its noise.
    scene : Scene, str or path
        Values of all parameters that are not fitted, and a first guess of those that are; or the
        name or file of a scene as for `find`.
    parameters : str, or sequence of str
        Any of "friction", "poisson_ratio", "base_pressure", "base_shear", "load_pressure",
        "load_shear", "viscosity", "shear_modulus", "density" of the scene; "angle", "wave_stress",
        "wave_velocity" and "load_speed" of a wave or a moving load; "t0", "x0" and "gain" of the
        set-up (`Setup`), and "gain:NAME" of the gauges of that name.  For a scene on a line,
        any number of the scene is named by its key in a scene file, such as "friction_law.distance"
        (docs/engine.md).
    priors : mapping from names to Normal, LogNormal or Uniform, optional
        Prior knowledge of parameters; it also limits the search.
    setup : Setup, optional
        Set-up of the gauges, for its parameters that are not fitted.
    rtol : float
        Accuracy of the solutions, as in `solve`; scenes on a line take `nodes` instead.
    nodes : int, optional
        Number of nodes of a scene on a line; by default that of the scene, or 512.
    progress : callable, optional
        Called as ``progress(done, total)``, where done is the number of times that the records of
        the gauges were computed and total the largest number that the search will need, which is
        revised on the way.

    Returns
    -------
    Fit
        The lowest of the minima that a scan of the plausible ranges leads to, with the covariance
        from the derivatives there, and a `status` that names what the data do not constrain.  With
        priors it is the most probable set of values (of the logarithm under `LogNormal`).

    Raises
    ------
    SceneError
        If there are no gauges, fewer samples than parameters, an unknown or repeated parameter, a
        prior for a name that is not among the parameters, or no solution or derivative at the first
        guess.

    Examples
    --------
    >>> import numpy as np
    >>> from semianalytic import Gauge, Normal, find, fit, solve
    >>> scene, t = find("antiplane"), np.linspace(0.3, 1.5, 5)
    >>> record = Gauge(x=0.2, t=t, values=solve(scene).slip(0.2, t), noise=1e-3, quantity="slip")
    >>> found = fit([record], scene, "friction", priors={"friction": Normal(0.5, 0.1)})
    >>> found.values.round(3).tolist()
    [0.5]
    """
    gauges = tuple(gauges) if np.iterable(gauges) else ()
    listed = tuple(parameters) if np.iterable(parameters) else ()
    names = (parameters,) if isinstance(parameters, str) else listed
    priors, setup = dict(priors or {}), setup or Setup()
    trials = _trials(gauges, scene, names, priors, setup, rtol, nodes)
    names = trials.unknowns.names
    trials.progress = progress
    trials.jacobian(trials.start)  # refuses what has no solution or derivative
    ends = minima(trials)
    # `minima` returns the lowest first.
    if not np.isfinite(ends[0].chi2):
        raise ComputationError("fit: no values within the ranges make a scene that can be solved.")
    size = trials.sizes
    known = np.array([isinstance(trials.priors.get(name), Normal | LogNormal) for name in names])
    lower: Array | None = None
    for _ in range(ROUNDS):
        if lower is not None:  # the search for an interval has met a lower minimum
            refine(trials, ends, lower)
        best = ends[0]
        covariance, free = covariance_of(best.jacobian, known)
        interval, lower = intervals(best, covariance, trials)
        if lower is None:
            break
    unconstrained = tuple(name for name, is_free in zip(names, free, strict=True) if is_free)
    derivative_error = trials.difference_error(best.scaled)
    trials.progress = None  # later misfits, as of `Fit.log_density`, are no part of this search
    scene, fitted = trials.at(best.scaled)
    solution = trials.final(best.scaled)
    # Doubts of the values come before doubts of their errors alone.
    status = verdict(ends, solution, unconstrained, covariance, trials)
    if status == "converged" and derivative_error > 0.2:
        status = (
            f"derivatives by differences are off by {derivative_error:.0%}, and the errors as much"
        )
    trials.followed = None  # nor do they depend on what came before
    # how far the values would move with records that were off by the error of the grid
    noise_alone = np.where(np.isfinite(covariance), covariance, 0.0)
    shift = noise_alone @ best.jacobian.T @ trials.grid_error(best.scaled, solution)
    errors, sides = np.sqrt(np.diag(covariance)), interval - best.scaled[:, None]
    large = np.abs(shift) > errors
    coarse = [name for name, is_coarse in zip(names, large, strict=True) if is_coarse]
    if status == "converged" and coarse:
        status = f"the grid adds more than noise to the error of {coarse[0]}; raise `nodes`"
    interval = best.scaled[:, None] + np.sign(sides) * np.hypot(sides, shift[:, None])
    interval = np.clip(interval.T, *trials.bounds).T
    fit = Fit(
        parameters=names,
        values=best.scaled * size,
        # Unknowns of the search are over their sizes; covariances go like the square.
        covariance=(covariance + np.outer(shift, shift)) * np.outer(size, size),
        interval=interval * size[:, None],
        chi2=best.chi2,
        freedom=trials.rows - len(names),
        unconstrained=unconstrained,
        status=status,
        solution=solution,
        setup=fitted,
        gauges=gauges,
        minima=np.array([end.scaled * size for end in ends]),
        chi2_of_minima=np.array([end.chi2 for end in ends]),
        derivative_error=derivative_error,
        solutions=trials.count,
        trials=trials,
    )
    logging.getLogger(__name__).info("%d solutions, the last %r: %r", trials.count, solution, fit)
    return fit


def _trials(
    gauges: tuple[Gauge, ...],
    given: object,
    names: tuple[str, ...],
    priors: Mapping[str, Prior],
    setup: Setup,
    rtol: float,
    nodes: int | None,
) -> Trials:
    """Return the trials of a fit, after checking what was asked."""
    if not gauges or not all(isinstance(given, Gauge) for given in gauges):
        raise SceneError("fit: gauges must be a sequence of at least one Gauge.")
    found = find(given) if isinstance(given, str | PathLike) else given
    on_line = isinstance(found, Scene) and is_fitted_on_line(found)
    if nodes is not None and not on_line:
        raise SceneError("fit: nodes have no effect on a scene, which has rtol; leave them out.")
    scene: Any = found if on_line else scene_of_one_solid("fit", found)
    # All that can be refused is refused before the first solution is computed.
    names = tuple(number_name(scene, name) for name in names)
    priors = {plain_name(name): prior for name, prior in priors.items()}
    check_names(names, gauges)
    for gauge in gauges:
        check_gauge(gauge, scene)
    _check_priors(gauges, names, priors)
    if on_line:
        # here, for fits of scenes are to be quick to import
        from semianalytic.inversion.on_line import line_trials

        return line_trials(gauges, scene, names, priors, setup, nodes)
    for gauge in gauges:
        if gauge.on_interface:
            checked_size(f"gauge {gauge.label}: x", gauge.x)
    check_exact(names, scene)
    samples = Samples(gauges)
    return Trials(samples, Unknowns(names, scene, setup, samples.duration), priors, rtol)


def _check_priors(
    gauges: tuple[Gauge, ...], names: tuple[str, ...], priors: Mapping[str, Prior]
) -> None:
    """Raise SceneError for priors of no unknown, and for fewer samples than unknowns."""
    for name, prior in priors.items():
        if name not in names:
            raise SceneError(f"fit: there is a prior of {shown(name)}, which is not fitted.")
        if not isinstance(prior, Normal | LogNormal | Uniform):
            raise SceneError(
                f"fit: the prior of {name} must be Normal, LogNormal or Uniform, got "
                f"{shown(prior)}."
            )
    samples = sum(len(gauge.t) for gauge in gauges)
    least = f"be at least that of parameters, {len(names)}"
    checked_number("fit: the number of samples", samples, least, lambda n: n >= len(names))
