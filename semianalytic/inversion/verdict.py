"""Covariance of the values of a fit, and objections of the data to them."""

from __future__ import annotations

import numpy as np

from semianalytic.inversion.search import Minimum
from semianalytic.inversion.trials import Trials
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import ComputationError
from semianalytic.selfsimilar.solution import Solution

LARGEST_CONDITION = 1e8
"""Condition number of the weighted Jacobian beyond which some direction counts as free."""
FAR = 3.0
"""Standard errors between two minima that are as good, from which on the status says so."""
OUT_OF_REACH = 20.0
"""Standard errors where chi2 is 9 above its least: 10 finds the same 8 of 14 silent fits."""


def verdict(
    ends: list[Minimum],
    solution: Solution,
    unconstrained: tuple[str, ...],
    covariance: Array,
    trials: Trials,
) -> str:
    """Return the status: "converged", or what to distrust of the lowest minimum."""
    # The order is that of gravity: without a covariance no other statement would mean anything.
    if unconstrained:
        together = " apart" if len(unconstrained) > 1 else ""
        return f"the data do not constrain {' and '.join(unconstrained)}{together}"
    if solution.status != "converged":
        return solution.status
    if not ends[0].converged:
        return "the least squares did not converge"
    best = ends[0]
    if contradiction := _contradiction(trials, best, covariance):
        return contradiction
    for other in ends[1:]:
        away = other.scaled - best.scaled
        # Mahalanobis distance: in standard errors along the direction between the two minima.
        apart = float(np.sqrt(away @ np.linalg.solve(covariance, away)))
        if other.chi2 - best.chi2 < 4.0 and apart > FAR:  # two standard deviations of chi2
            return (
                f"another minimum, {apart:.1f} standard errors away, fits as well "
                f"(chi2 {other.chi2 - best.chi2:.2g} above)"
            )
    return _one_sided(best, covariance, trials) or "converged"


def _one_sided(best: Minimum, covariance: Array, trials: Trials) -> str:
    """Say which value is hardly determined though it is `OUT_OF_REACH` away; "" if none is.

    Noise makes a shallow minimum near values that fit as well; others go along by covariance.
    """
    low, high = trials.bounds
    told = []
    for place, name in enumerate(trials.unknowns.names):
        along = covariance[:, place] / np.sqrt(covariance[place, place])
        for sign, side in ((1, "above"), (-1, "below")):
            with np.errstate(divide="ignore", invalid="ignore"):
                room = np.where(sign * along > 0, high - best.scaled, best.scaled - low)
                errors = min(OUT_OF_REACH, 0.99 * float(np.nanmin(room / np.abs(along))))
            if errors > 2 * FAR:
                told.append((name, side, errors, best.scaled + sign * errors * along, place))
    if not told:
        return ""
    misfits = trials.misfits([there for *_, there, _ in told])
    for (name, side, errors, there, place), misfit in zip(told, misfits, strict=True):
        above = float(misfit @ misfit) - best.chi2
        if above < FAR**2 * (errors / OUT_OF_REACH) ** 2:
            value = there[place] * trials.sizes[place]
            return (
                f"{name} is poorly bounded from {side}: {value:.4g}, {errors:.2g} standard errors "
                f"away, fits almost as well (chi2 {max(above, 0.0):.2g} above)"
            )
    return ""


def _contradiction(trials: Trials, best: Minimum, covariance: Array) -> str:
    """Say what misfits, or distances from priors, hold against the scene; "" if nothing.

    Estimates are drawn towards their priors, the more the less the data constrain them: the
    distances z, in standard deviations of the priors, have the covariance 1 - P C P^T, with the
    rows P of the priors in the Jacobian and the covariance C of the estimates.
    """
    freedom = trials.rows - len(best.scaled)
    if _is_rare(best.chi2, freedom):
        # Misfits over noise in the root mean square, as freedom counts it.
        share = float(np.sqrt(best.chi2 / freedom))
        return (
            f"misfits are {share:.2g} times what the noise allows (chi2 {best.chi2:.4g} of "
            f"{freedom}): a fixed parameter is wrong, or the noise is larger than stated"
        )
    pulls = trials.pulls(best.scaled)
    if not pulls:
        return ""
    # Rows of priors follow those of samples.
    rows = best.jacobian[len(trials.samples.t) :]
    left, axes = np.linalg.eigh(np.eye(len(rows)) - rows @ covariance @ rows.T)
    # Directions in which the data say nothing leave a prior where it is: its distance is 0 over 0
    # there.  Rounding leaves 1e-14 of the variance of a prior.
    told = left > 1e-6
    along = (axes.T @ list(pulls.values()))[told] / np.sqrt(left[told])
    if _is_rare(float(along @ along), int(told.sum())):
        names = " and ".join(pulls)
        return (
            f"records and priors contradict each other: they are {np.sqrt(along @ along):.2g} "
            f"standard deviations apart in {names}"
        )
    return ""


def _is_rare(square: float, freedom: int) -> bool:
    """Return whether so large a sum of squares of normal numbers occurs once in a million."""
    from scipy.special import chdtrc  # here, for `import semianalytic` is to be quick

    # With 100 samples it is reached when the noise is 1.35 times as large as stated; 1e-3 at 1.22
    # times.
    return freedom > 0 and float(chdtrc(freedom, square)) < 1e-6


def covariance_of(jacobian: Array, known: np.ndarray) -> tuple[Array, np.ndarray]:
    """Return the inverse (p, p) of the weighted normal matrix, and which parameters are free (p,).

    Parameters are divided by their sizes.  Those `known` (p,) by a normal or lognormal prior have
    its error at most, however wide it is.
    """
    # By singular values, not by inverting J^T J, which would square the condition number.
    _, values, rows = np.linalg.svd(jacobian, full_matrices=False)
    if not np.all(np.isfinite(values)):
        raise ComputationError("fit: the derivatives at the best values are not finite.")
    # Directions in which the data change nothing have no inverse; parameters that take part in one
    # are free.
    lost = values <= values.max(initial=0.0) / LARGEST_CONDITION
    inverse = np.where(lost, 0.0, 1 / np.where(lost, 1.0, values))
    covariance = (rows.T * inverse**2) @ rows
    # A share of 1e-3 of a lost direction is above what rounding mixes into it, and below what would
    # be seen in a standard error.
    within = np.abs(rows[lost]).max(axis=0, initial=0.0) > 1e-3
    # The standard error exceeds the size of the parameter.
    free = within | (~known & (np.diag(covariance) > 1.0))
    covariance[free, :] = covariance[:, free] = 0.0
    covariance[free, free] = np.inf
    return covariance, free
