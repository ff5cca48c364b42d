"""Intervals of fitted values: how far each may move before chi2 is one above its least."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from semianalytic.inversion.search import WORTH, Minimum
from semianalytic.inversion.trials import Trials
from semianalytic.inversion.verdict import LARGEST_CONDITION
from semianalytic.scene.arrays import Array

RISE = 1.0
"""Rise of chi2 at the ends of an interval: that at one standard error, if chi2 is a parabola."""
NEAR = 0.1
"""Difference from `RISE` at which an end is found: within a twentieth of its distance."""
FARTHEST = 20.0
"""Standard errors at which the search for an end stops; there is none to this side then."""


def intervals(best: Minimum, covariance: Array, trials: Trials) -> tuple[Array, Array | None]:
    """Return the interval of each value, and values of lower chi2 if the search meets any.

    An interval ends where chi2, with all other values fitted anew, is `RISE` above its least (the
    profile likelihood).  If chi2 is a parabola, that is one standard error to either side.  It
    rises faster to one side than to the other where a front or an edge of slip passes samples.

    The covariance (p, p) is that of the values over their sizes, infinite where data do not
    constrain them.  The ends (p, 2) are over the sizes too: infinite where chi2 stays below, or the
    bound of the value if that comes first.  Values of lower chi2 (p,) are where to search again.
    """
    errors = np.sqrt(np.diag(covariance))
    ends = best.scaled[:, None] + errors[:, None] * np.array([-1.0, 1.0])
    for place in np.flatnonzero(np.isfinite(errors)).tolist():
        # By the covariance, the other values move along with this one so that chi2 rises least.
        path = np.where(np.isfinite(covariance[place]), covariance[place], 0.0) / errors[place]
        for side, sign in ((0, -1.0), (1, 1.0)):
            bound = float(trials.bounds[side, place])
            room = min(abs(bound - best.scaled[place]) / errors[place], FARTHEST)
            profile = _Profile(best, place, sign * path, trials)
            far = _crossing(profile.rise, room)
            if profile.lower is not None:
                return ends, profile.lower
            if far is not None:
                ends[place, side] = best.scaled[place] + sign * far * errors[place]
            else:
                ends[place, side] = bound if room < FARTHEST else sign * np.inf
    return ends, None


@dataclass
class _Profile:
    """The least chi2 as a function of the value at `place`.

    `path` (p,) is the change of all over one standard error of it, as the last trial had it;
    `lower` are values whose chi2 is below that of the minimum, if a trial met any.
    """

    best: Minimum
    place: int
    path: Array
    trials: Trials
    lower: Array | None = None

    def rise(self, far: float) -> float:
        """Return by how much chi2 is above its least, so many standard errors away."""
        best = self.best
        start = np.clip(best.scaled + far * self.path, *self.trials.bounds)
        values, chi2 = _refitted(self.trials, best, start, self.place)
        if chi2 < best.chi2 - WORTH:
            self.lower = values
            return np.inf  # which ends the search for a crossing soonest
        if np.isfinite(chi2):
            self.path = (values - best.scaled) / far
        return chi2 - best.chi2


def _crossing(rise: Callable[[float], float], room: float) -> float | None:
    """Return where a rise from 0 at 0 reaches `RISE`, None if it does not within the room."""
    near, below, far = 0.0, 0.0, min(1.0, room)
    above = rise(far)
    # Then chi2 is a parabola: the standard error is right within an eighth.
    if far == 1.0 and abs(above - RISE) <= 0.25:
        return far
    while above < RISE - NEAR:
        if far == room:
            return None
        near, below, far = far, above, min(2 * far, room)
        above = rise(far)
    for _ in range(12):  # three are mostly enough
        if abs(above - RISE) <= NEAR:
            break
        # The root of chi2 is straight where chi2 is a parabola; a tenth from either end, since
        # chi2 may jump where a front passes a sample.
        low, high = np.sqrt(max(below, 0.0)), np.sqrt(above)
        share = float(np.clip((np.sqrt(RISE) - low) / (high - low), 0.1, 0.9))
        between = near + share * (far - near)
        middle = rise(between)
        if middle < RISE - NEAR:
            near, below = between, middle
        else:
            far, above = between, middle
    return far


def _refitted(trials: Trials, best: Minimum, start: Array, place: int) -> tuple[Array, float]:
    """Return the values (p,) with one of them held and the others fitted anew, and their chi2."""
    from scipy.optimize import least_squares  # here, for `import semianalytic` is to be quick

    sizes = np.linalg.norm(best.jacobian, axis=0)
    # A value that changes nothing, but for rounding, cannot be fitted anew.
    others = (np.arange(len(start)) != place) & (sizes > sizes.max() / LARGEST_CONDITION)
    first = trials.misfit(start)
    if not others.any() or not np.all(np.isfinite(first)):
        return start, float(first @ first)
    low, high = trials.bounds[:, others]

    def whole(part: Array) -> Array:
        values = start.copy()
        values[others] = part
        return values

    steps = 1e-3 / sizes[others]
    # Chi2 and derivatives where these were formed last: those at the minimum say where to, and are
    # all that slow trials are given.
    formed = [(np.inf, best.jacobian[:, others])]

    def jacobian(part: Array) -> Array:
        here = misfit(part)
        chi2, (before, last) = float(here @ here), formed[-1]
        # `least_squares` asks once more where `ftol` ends it, for nothing.
        if trials.is_slow or before - chi2 < 1e-3 * before < np.inf:
            return last
        # Differences, since the derivatives of `trials` are those a little off the edges of slip
        # (`Samples.clear`), where chi2 has its kinks.
        beside = [whole(part + step) for step in np.diag(steps)]
        formed.append((chi2, (trials.misfits(beside, exact=True) - here).T / steps))
        return formed[-1][1]

    def misfit(part: Array) -> Array:
        return trials.misfit(whole(part))

    # Fits start where a parabola or the last trial is: the third is mostly the last.
    found = least_squares(
        misfit,
        np.clip(start[others], low + 1e-9, high - 1e-9),
        jac=jacobian,
        bounds=(low, high),
        xtol=1e-9,
        ftol=1e-3,
        gtol=1e-3,
        max_nfev=6,
    )
    return whole(found.x), 2 * float(found.cost)
