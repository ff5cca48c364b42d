"""Whether a simulation and its coarser runs are the same run on other meshes.

Under self-similar loads a coarser run is the finer one until a half of its end time, in units of
length and time twice as long, to rounding.  Else the slip of three meshes can only be held against
what discretisation does: errors fall from mesh to mesh, and lie at fronts and edges, so that they
are not all of the slip times one factor, or late by one delay.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from compare.comparison.case import FIELDS, LEAST_PEAK, WHOLE_STEPS, Case
from compare.comparison.judging import least_error
from compare.comparison.measures import ROUNDING
from compare.comparison.rows import UNLIKE, Row
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.results.sampled import interpolated

if TYPE_CHECKING:
    from fem import Simulation

Array = NDArray[np.float64]

LIKENESS = "coarser runs against this one"
SAME = 1e-4
"""Largest difference of runs of self-similar scenes, over the largest value of a field.  Rounding
makes it 1e-12, and up to 2e-7 where short waves grow, in 40 drawn scenes."""
LEAST_FALL, COMMON, OF_CHANGE = 0.4, 0.75, 3.9
"""Least order with which errors of slip fall from 4h to 2h, and largest part of the change that is
one factor and one delay, over the error at 4h and over the change from 2h to h.  They were 0.45 to
2.4, at most 0.67 and at most 3.5 in 54 right interfaces and histories."""
NOTABLE = 0.01
"""Part of the largest slip from which on places count."""
EARLY = 0.2
"""Initial part of the run, over the end time, that is left out."""
SMOOTH, PASSES = 1e-3, 15
"""Part of the largest change below which deviations count by their squares, and number of weighted
fits after which the sum of all larger ones is smallest."""


def likeness_rows(case: Case) -> Iterator[Row]:
    """Row of how far the coarser runs are from this one, if there are two."""
    if len(case.runs) < 3 or case.rests:
        return
    if case.scales:
        off, bar = max(_apart(case, *pair) for pair in pairwise(case.runs)), SAME
    else:
        off, bar = _excess(case), 1.0
    row = Row(LIKENESS, "law", None, 0.0, off, off, bar)
    yield replace(row, obstacle=UNLIKE) if off > bar else row


def _apart(case: Case, fine: Simulation, coarse: Simulation) -> float:
    """Return the largest difference of a run from the next finer one until a half of its end time,
    over the largest value of a field, at levels that both store.

    Waves from the sides of a mesh appear in means over windows that end after the last level:
    by 1e-3 with a Poisson ratio of 0.495.
    """
    longer, shorter, rounding = fine.interface, coarse.interface, WHOLE_STEPS * coarse.time_step
    nodes = min(longer.x.size, shorter.x.size)
    level = np.searchsorted(longer.t, (shorter.t - rounding) / 2)
    both = np.abs(2 * longer.t[level] - shorter.t) <= rounding
    both &= shorter.t <= shorter.t[-1] - coarse.rate_window
    shares = []
    for name in FIELDS:
        scale = 2.0 if name in ("slip", "gap") else 1.0
        other = getattr(shorter, name)[both, :nodes]
        off = np.abs(scale * getattr(longer, name)[level[both], :nodes] - other).max(initial=0.0)
        shares.append(off / (np.abs(other).max(initial=0.0) + LEAST_PEAK * case.unit(name)[0]))
    return float(max(shares))


def _excess(case: Case) -> float:
    """Return how far slip over space and time is from what meshes do, over what they may."""
    coarsest = case.runs[2].interface
    nodes = case.compared("slip", 2) & (coarsest.x <= (1 + ROUNDING) * case.seen.x[-1])
    late = coarsest.t[coarsest.t > (1 + ROUNDING) * EARLY * case.end_time]
    x, t = np.broadcast_arrays(coarsest.x[nodes], late[:, None])

    def slip(history: InterfaceHistory) -> Array:
        return interpolated(history, "slip", x, t)

    known = slip(case.at_nodes)
    before = interpolated(case.at_nodes, "slip", x, np.maximum(t - case.window, case.seen.t[0]))
    slips = np.abs(known) > NOTABLE * np.abs(known).max(initial=0.0)
    size = float(np.abs(known[slips]).sum())
    if not size:
        return 0.0
    fine, half, coarse = (slip(run.interface) for run in case.runs)
    doubt = 0.0 if case.doubted is None else np.abs(slip(case.doubted) - known)[slips].sum() / size
    unsure = least_error(case) + float(doubt)

    def norm(values: Array) -> float:
        return float(np.abs(values[slips]).sum()) / size

    common = norm(_common(coarse - half, known, known - before, slips))
    error = norm(coarse - known)
    return max(
        2**LEAST_FALL * norm(half - known) / (error + unsure),
        common / (COMMON * error + unsure),
        common / (OF_CHANGE * norm(half - fine) + unsure),
    )


def _common(change: Array, slip: Array, moved: Array, slips: NDArray[np.bool_]) -> Array:
    """Return the part of a change that is the slip times a factor and its motion times another."""
    known = np.stack([slip[slips], moved[slips]], axis=1) / np.abs(slip[slips]).max()
    found, weight = change[slips], np.ones_like(change[slips])
    least = SMOOTH * float(np.abs(found).max()) + np.finfo(float).tiny
    factors = np.zeros(2)
    for _ in range(PASSES):
        factors = np.linalg.lstsq(known * weight[:, None], found * weight, rcond=None)[0]
        weight = 1 / np.sqrt(np.maximum(np.abs(found - known @ factors), least))
    common = np.zeros_like(change)
    common[slips] = known @ factors
    return common
