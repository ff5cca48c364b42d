"""The search for the lowest minimum of the sum of squares, not only near the first guess.

chi2 rises where the edge of a slip zone passes a sample, so it has minima some standard errors
apart, in a basin that may lie anywhere.  A scan of the plausible ranges therefore finds basins,
least squares descend in the best of them, and from the lowest point on scans of its surroundings,
as wide as the errors, find lower minima.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from semianalytic.inversion.trials import Trials
from semianalytic.inversion.unknowns import is_of_setup
from semianalytic.scene.arrays import Array

SETUPS = (1, 7, 16)
"""Trial values of the other unknowns in each of these scenes, by their number."""
STARTS, NEAR_STARTS = 3, 2
"""Number of starts of least squares after a scan, and after one of surroundings."""
ROUNDS = 4
WORTH = 0.3
"""Fall of chi2 that calls for one more round: a tenth of what parameters cost it."""
SHORT = 9
"""Solutions of least squares that need not end: the lowest are taken further."""
ARRIVED = 0.1
"""Standard errors from a known minimum at which a search ends: a fifth of where they are alike."""
SETTLED = 1e-5
"""Relative change of chi2 that ends a search: a hundredth of that of noise."""


@dataclass(frozen=True, eq=False)
class Minimum:
    """A minimum at which least squares ended, at values over sizes, with its Jacobian (n, p)."""

    scaled: Array
    chi2: float
    jacobian: Array
    converged: bool

    def distance(self, scaled: Array) -> float:
        """Return the distance of other values, in standard errors with all other values fixed."""
        return float(np.linalg.norm(self.jacobian @ (scaled - self.scaled)))


def spread(count: int, dimensions: int) -> Array:
    """Return points (count, dimensions) that fill the unit cube evenly, for any count.

    They are multiples of the powers of the root of x^(d+1) = x + 1, less whole numbers.
    """
    # The iteration contracts to the root for every dimension; the start only has to be above 1.
    root = 2.0
    for _ in range(60):
        root = (1 + root) ** (1 / (dimensions + 1))
    steps = root ** -np.arange(1.0, dimensions + 1)
    return np.asarray((0.5 + np.arange(1, count + 1)[:, None] * steps) % 1)


def minima(trials: Trials) -> list[Minimum]:
    """Return all minima that were found, the lowest first."""
    ends: list[Minimum] = []
    count, setups = _counts(trials)
    # Each step of least squares takes one misfit and one Jacobian.
    descent = SHORT * (1 + trials.of_jacobian)
    around = _nearby(trials) + NEAR_STARTS * descent
    trials.expect(count * setups + STARTS * descent + around)
    starts = scan(trials)
    # Cut short: most starts lead to minima that are not the lowest, and these need no digits.
    for number, start in enumerate(starts):
        trials.expect((len(starts) - number) * descent + around)
        refine(trials, ends, start, SHORT)
    for _ in range(ROUNDS):
        trials.expect(around)  # one round is expected to do, as it mostly does
        lowest = ends[0].chi2
        for start in surroundings(trials, ends[0]):
            refine(trials, ends, start, SHORT)
        if ends[0].chi2 > lowest - WORTH:
            break
    if not ends[0].converged:
        ends[0] = descend(trials, ends[0].scaled)
    return ends


def refine(trials: Trials, ends: list[Minimum], start: Array, most: int | None = None) -> None:
    """Add the minimum below a start to a list, the lowest first; of those alike, the lowest stays.

    So many solutions are computed at most.
    """
    try:
        end = descend(trials, start, most, ends)
    except StopIteration:
        return
    # A new minimum replaces those that it is the better end of.
    near = [fit for fit in ends if fit.distance(end.scaled) < 0.5]  # nearer minima count as one
    if not near or end.chi2 < min(fit.chi2 for fit in near):
        ends[:] = [fit for fit in ends if fit not in near]
        ends.append(end)
    ends.sort(key=lambda end: end.chi2)


def descend(
    trials: Trials, start: Array, most: int | None = None, known: Sequence[Minimum] = ()
) -> Minimum:
    """Run least squares, for so many solutions at most; StopIteration at a known minimum."""
    from scipy.optimize import least_squares  # here, for `import semianalytic` is to be quick

    low, high = trials.bounds

    def jacobian(scaled: Array) -> Array:
        if any(end.distance(scaled) < ARRIVED for end in known):
            raise StopIteration
        return trials.jacobian(scaled)

    found = least_squares(
        trials.misfit,
        # Strictly inside, as `least_squares` asks for; unknowns are of order 1.
        np.clip(start, low + 1e-9, high - 1e-9),
        jac=jacobian,
        bounds=(low, high),
        xtol=1e-9,
        ftol=SETTLED,
        gtol=SETTLED,
        max_nfev=most,
    )
    # scipy's cost is half the sum of squares.
    return Minimum(found.x, float(2 * found.cost), np.asarray(found.jac), bool(found.success))


def scan(trials: Trials) -> list[Array]:
    """Return the best starts, from the plausible ranges and the first guess."""
    low, high = trials.ranges
    count, setups = _counts(trials)
    if count * setups == 1:
        return [trials.start]
    points = low + (high - low) * spread(count * setups, len(low))
    is_setup = np.array([is_of_setup(name) for name in trials.unknowns.names])
    # Trials of the set-up share one scene, whose solution is kept: they cost evaluations only.
    for first in range(0, count * setups, setups):
        points[first : first + setups, ~is_setup] = points[first, ~is_setup]
    return _best(trials, [trials.start, *points], STARTS)


def _counts(trials: Trials) -> tuple[int, int]:
    """Return the number of scenes of a scan, and of trial values of other unknowns in each."""
    other = sum(map(is_of_setup, trials.unknowns.names))
    count = (1, 32, 96, 144)[min(_acting(trials) - other, 3)]
    return max(count // _share(trials), 1), SETUPS[min(other, len(SETUPS) - 1)]


def _acting(trials: Trials) -> int:
    """Return the number of unknowns; friction and a pressure that act through f p alone are one."""
    return len(trials.unknowns.names) - ({"friction", "base_pressure"} <= trials.swept)


def _share(trials: Trials) -> int:
    """Return the factor by which scans have fewer scenes."""
    return 3 if trials.is_slow else 1  # fields in the bodies and runs of interfaces cost more


def _nearby(trials: Trials) -> int:
    """Return the number of points of a scan of surroundings."""
    return 20 * _acting(trials) // _share(trials)


def surroundings(trials: Trials, end: Minimum) -> list[Array]:
    """Return the best starts around a minimum, within six standard errors."""
    p = len(end.scaled)
    # The principal axes of the ellipsoid of errors, with half-axes 1 / singular value;
    # unconstrained axes are cut off at a tenth of the parameter's size.
    _, values, rows = np.linalg.svd(end.jacobian, full_matrices=False)
    widths = 1 / np.maximum(values, 10.0)
    # If misfits exceed the noise, the real errors are as much larger, and minima as much further
    # apart.
    reach = 6.0 * max(1.0, np.sqrt(end.chi2 / max(len(end.jacobian) - p, 1)))
    points = reach * (2 * spread(_nearby(trials), p) - 1)
    around = np.clip(end.scaled + (points * widths) @ rows, *trials.bounds)
    return _best(trials, list(around), NEAR_STARTS)


def _best(trials: Trials, points: list[Array], count: int) -> list[Array]:
    """Return the lowest of some starts, so many."""
    squares = np.sum(np.square(trials.misfits(points)), axis=1)
    # Stable, so that equal trials are taken in the order of the list and fits repeat to the bit.
    order = [i for i in np.argsort(squares, kind="stable") if np.isfinite(squares[i])]
    return [points[i] for i in order[:count]] or points[:1]
