"""Where sums of squares are least, of all places and not only near the first guess.

chi2 rises where the edge of a slip zone passes a sample, so it has minima of its own, some standard
errors apart, in a basin that may lie anywhere.  So a scan of the plausible ranges finds basins, least
squares go down in the best of them, and from the lowest point on scans of its surroundings, as wide
as the errors, find what is lower still.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from semianalytic.halfplane.rayleigh import Array
from semianalytic.inversion.trials import Trials
from semianalytic.scene.errors import ComputationError, SceneError
from semianalytic.selfsimilar.derivative import PARAMETERS

SCENES = (1, 32, 96, 144)
"""Scenes of a scan for no, one, two and more unknowns that take a solution."""
FIELD_SHARE = 3
"""As many times fewer where gauges are in the bodies, whose fields cost more."""
SETUPS = (1, 7, 16)
"""Trial values of the other unknowns in each of these scenes, by their number."""
SCAN_RTOL = 1e-4
STARTS = 3
ROUNDS = 4
WORTH = 0.3
"""By how much chi2 must fall for one more round: a tenth of what parameters cost it."""
NEARBY = 20
"""Points of a scan of surroundings, by unknown."""
REACH = 6.0
"""Of it, in standard errors."""
APART = 0.5
"""Distance of minima that count as two, in standard errors."""
SETTLED = 1e-5
"""Change of chi2, relative, that ends a search: a hundredth of what noise does."""


@dataclass(frozen=True, eq=False)
class Minimum:
    """Where least squares ended.

    Attributes
    ----------
    scaled : (p,) array, values over sizes
    chi2 : float
    jacobian : (n, p) array
    converged : bool
    """

    scaled: Array
    chi2: float
    jacobian: Array
    converged: bool

    def distance(self, scaled: Array) -> float:
        """Of other values, in standard errors as they are without noise from other parameters."""
        return float(np.linalg.norm(self.jacobian @ (scaled - self.scaled)))


def spread(count: int, dimensions: int) -> Array:
    """(count, dimensions) points that fill the unit cube evenly, for any count: multiples of the
    roots of x^(d+1) = x + 1, less whole numbers."""
    root = 2.0
    for _ in range(60):
        root = (1 + root) ** (1 / (dimensions + 1))
    steps = root ** -np.arange(1.0, dimensions + 1)
    return np.asarray((0.5 + np.arange(1, count + 1)[:, None] * steps) % 1)


def minima(trials: Trials) -> list[Minimum]:
    """All that were come to, the lowest first."""
    ends: list[Minimum] = []
    starts = scan(trials)
    for _ in range(1 + ROUNDS):
        lowest = ends[0].chi2 if ends else np.inf
        for start in starts:
            _add(ends, descend(trials, start))
        if ends[0].chi2 > lowest - WORTH:
            break
        starts = surroundings(trials, ends[0])
    return ends


def _add(ends: list[Minimum], end: Minimum) -> None:
    """Of minima that are one, the lowest stays."""
    near = [one for one in ends if one.distance(end.scaled) < APART]
    if not near or end.chi2 < min(one.chi2 for one in near):
        ends[:] = [one for one in ends if one not in near]
        ends.append(end)
    ends.sort(key=lambda one: one.chi2)


def descend(trials: Trials, start: Array) -> Minimum:
    """Least squares from a start."""
    from scipy.optimize import least_squares  # here, for `import semianalytic` is to be quick

    low, high = trials.bounds
    found = least_squares(
        trials.misfit,
        np.clip(start, low + 1e-9, high - 1e-9),
        jac=trials.jacobian,
        bounds=(low, high),
        xtol=1e-9,
        ftol=SETTLED,
        gtol=SETTLED,
    )
    return Minimum(found.x, float(2 * found.cost), found.jac, bool(found.success))


def scan(trials: Trials) -> list[Array]:
    """The best starts, of the plausible ranges and the first guess."""
    low, high = trials.ranges
    count, setups = _counts(trials)
    if count * setups == 1:
        return [trials.start]
    points = low + (high - low) * spread(count * setups, len(low))
    is_setup = np.array([name not in PARAMETERS for name in trials.unknowns.names])
    trial: list[Array] = [trials.start]
    for first in range(0, count * setups, setups):
        some = points[first : first + setups]
        some[:, ~is_setup] = some[0, ~is_setup]
        trial += list(some)
    squares = [np.sum(trials.misfit(one) ** 2) for one in trial]
    return _best(trial, squares)


def _counts(trials: Trials) -> tuple[int, int]:
    solved = sum(name in PARAMETERS for name in trials.unknowns.names)
    other = len(trials.unknowns.names) - solved
    count = SCENES[min(solved, len(SCENES) - 1)]
    if not trials.samples.on_interface.all():
        count = max(count // FIELD_SHARE, 1)
    return count, SETUPS[min(other, len(SETUPS) - 1)]


def surroundings(trials: Trials, end: Minimum) -> list[Array]:
    """The best starts around a minimum, within `REACH` standard errors."""
    p = len(end.scaled)
    _, values, rows = np.linalg.svd(end.jacobian, full_matrices=False)
    widths = 1 / np.maximum(values, values.max() * 1e-6)
    widths = np.minimum(widths, 0.1)
    wide = REACH * max(1.0, np.sqrt(end.chi2 / max(len(end.jacobian) - p, 1)))
    points = (2 * spread(NEARBY * p, p) - 1) * wide
    trial = np.clip(end.scaled + (points * widths) @ rows, *trials.bounds)
    squares = [np.sum(trials.misfit(one) ** 2) for one in trial]
    return _best(list(trial), squares)


def _best(trial: list[Array], squares: list[float]) -> list[Array]:
    order = [i for i in np.argsort(squares, kind="stable") if np.isfinite(squares[i])]
    return [trial[i] for i in order[:STARTS]] or [trial[0]]
