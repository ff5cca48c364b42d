"""How far answers for different bodies are off, against what they say themselves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from compare.studies.dissimilar.pairs import random_pair
from semianalytic import PairSolution, SceneError, solve
from semianalytic.halfplane.rayleigh import Array

EXACT = 1e-10
"""The rtol of the reference answers that the others are compared with."""
TOLERANCES = (1e-4, 1e-6, 1e-8)
BESIDE = 0.03
"""Distance from zone edges, over the slowest wave speed, from which `error_estimate` speaks."""
PAIRS = 200
_SEED = 2


@dataclass(frozen=True)
class HonestyRow:
    """Random pairs solved to one rtol: errors over their estimates."""

    rtol: float
    drawn: int
    refused: int
    solved: int
    unconverged: int
    other_zones: int
    compared: int
    below: int
    worst_ratio: float
    median_ratio: float
    worst_error: float


def error_of(answer: PairSolution, exact: PairSolution) -> float | None:
    """Largest error of an answer as its estimate counts them; None if its zones are others."""
    pair = answer.pair
    slow = min(pair.upper.shear_speed, pair.lower.shear_speed)
    fast = max(pair.upper.longitudinal_speed, pair.lower.longitudinal_speed)
    ends = [_ends(one) for one in (answer, exact)]
    if ends[0].shape != ends[1].shape:
        return None
    moves = ends[1] > 0
    shifts = np.abs(ends[0] - ends[1])[moves] / np.minimum(ends[1][moves], slow)
    x = np.linspace(BESIDE * slow, fast)
    x = x[np.abs(x[:, None] - np.append(ends[1], np.inf)).min(axis=1) > BESIDE * slow]
    found = [float(shifts.max(initial=0.0))]
    for name in ("slip_rate", "gap_rate", "slip", "gap"):
        one, other = (getattr(each, name)(x, 1.0) for each in (answer, exact))
        found.append(float(np.abs(one - other).max() / (np.abs(other).max() or 1.0)))
    held = pair.base.pressure + abs(pair.load.pressure) + abs(pair.load.shear)
    for name in ("pressure", "shear_traction"):
        one, other = (getattr(each, name)(x, 1.0) for each in (answer, exact))
        found.append(float((np.abs(one - other) / (np.abs(other) + held)).max()))
    return max(found)


def _ends(answer: PairSolution) -> Array:
    slips = [end for zone in answer.zones for end in (zone.inner, zone.outer)]
    return np.array(slips + [end for part in answer.openings for end in (part.inner, part.outer)])


def honesty_rows(pairs: int = PAIRS, first: int = 0) -> list[HonestyRow]:
    """Draw pairs until so many were solved, and hold each rtol's errors against its estimates.

    The exact answer is that of the same method at rtol 1e-10: this measures discretisation alone.
    """
    ratios: dict[float, list[float]] = {rtol: [] for rtol in TOLERANCES}
    errors: dict[float, list[float]] = {rtol: [] for rtol in TOLERANCES}
    others, unconverged = dict.fromkeys(TOLERANCES, 0), dict.fromkeys(TOLERANCES, 0)
    seed, solved, refused = first, 0, 0
    while solved < pairs:
        pair = random_pair(np.random.default_rng([_SEED, seed]))
        seed += 1
        try:
            exact = solve(pair, rtol=EXACT)
        except SceneError:
            refused += 1
            continue
        solved += 1
        for rtol in TOLERANCES:
            answer = solve(pair, rtol=rtol)
            unconverged[rtol] += answer.status != "converged"
            error = error_of(answer, exact)
            if error is None or not np.isfinite(answer.error_estimate):
                others[rtol] += 1
                continue
            errors[rtol].append(error)
            ratios[rtol].append(error / answer.error_estimate)
    return [
        HonestyRow(
            rtol,
            seed - first,
            refused,
            solved,
            unconverged[rtol],
            others[rtol],
            len(ratios[rtol]),
            sum(ratio <= 1 for ratio in ratios[rtol]),
            max(ratios[rtol], default=np.nan),
            float(np.median(ratios[rtol])) if ratios[rtol] else np.nan,
            max(errors[rtol], default=np.nan),
        )
        for rtol in TOLERANCES
    ]
