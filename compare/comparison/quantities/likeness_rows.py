"""Whether a simulation and its coarser runs are the same run on other meshes.

Under self-similar loads a coarser run is the finer one until a half of its end time, in units of
length and time twice as long, to rounding.  Else what all slip of a mesh has in common, a factor
and a delay, is compared with the prediction and has to grow with the elements.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy

from compare.comparison.case import FIELDS, LEAST_PEAK, WHOLE_STEPS, Case, too_narrow
from compare.comparison.judging import least_error
from compare.comparison.measures import EARLY, NARROW, ROUNDING
from compare.comparison.rows import UNLIKE, Row
from semianalytic.results.sampled import interpolated
from semianalytic.scene.arrays import Array

if TYPE_CHECKING:
    from fem import Simulation


LIKENESS = "coarser runs against this one"
SAME = 1e-4
"""Largest difference of runs of self-similar scenes, over the largest value of a field.  Rounding
makes it 1e-12, and up to 2e-7 where short waves grow, in 40 drawn scenes."""
GROWTH = 2.0, 4.0
"""Least and most by which errors of slip grow from mesh to mesh: those of order 1 and 2."""
LARGEST, COARSE = 1.35, 4.0
"""Largest deviation of the common errors at 4h from those that the finer meshes let expect, in
changes from mesh to mesh, and how many times as large it may be where nowhere `NARROW` nodes in a
row slip on the mesh of 4h.  It was larger, up to 1.7, in three of 71 right interfaces, and up to
5.6 in four with 5 to 7 such nodes; mistakes of 1.5 bars at 4h deviate by 1 to 3."""
FORESEEN = 0.1
"""Largest change from mesh to mesh, over slip or slip rate, from which errors at 4h follow.  Right
scenes deviate by up to 31 changes with 0.13 and more, by at most 1.05 with 0.08 and less."""
NOTABLE = 0.01
"""Part of the largest slip from which on places count."""
SMOOTH = 1e-3
"""Part of the largest error below which deviations count by their squares."""
TINY = float(np.finfo(float).tiny)


def likeness_rows(case: Case) -> Iterator[Row]:
    """Row of how far the coarser runs are from this one, if there are two."""
    if len(case.runs) < 3 or case.rests:
        return
    if case.scales:
        off, bar = max(_apart(case, *pair) for pair in pairwise(case.runs)), SAME
    else:
        off, bar = _excess(case), 1.0
    yield Row(LIKENESS, "law", None, 0.0, off, off, bar, obstacle=UNLIKE if off > bar else "")


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
    """Return how far errors of slip over (x, t) are from growing with h, over what is right.

    The prediction is the limit of meshes for h → 0.  The errors of a mesh have in common a factor
    and a delay of all slip, e(h).  Either both grow from 2h to 4h as all errors do from h to 2h; or
    each lies between e(2h)^2 / e(h), if it is of one order, and 6 e(2h) - 8 e(h), if orders 1 and 2
    are mixed.  A deviation from that is measured by the slip or slip rate that it changes, in
    changes from mesh to mesh, and the smaller of the two deviations counts.
    """
    coarsest = case.runs[2].interface
    nodes = case.compared("slip", 2) & (coarsest.x <= (1 + ROUNDING) * case.seen.x[-1])
    late = coarsest.t[coarsest.t > (1 + ROUNDING) * EARLY * case.end_time]
    x, t = np.broadcast_arrays(coarsest.x[nodes], late[:, None])
    slip = np.abs(interpolated(case.at_nodes, "slip", x, t))
    slips = slip > NOTABLE * slip.max(initial=0.0)
    if not slips.any():
        return 0.0
    x, t = x[slips], t[slips]
    histories = case.at_nodes, case.doubted or case.at_nodes, *(run.interface for run in case.runs)
    earlier = np.maximum(t - case.window, case.seen.t[0])
    patterns, units = [], []
    for name in ("slip_rate", "slip"):
        known, *others = (interpolated(history, name, x, t) for history in histories)
        if size := _sum(known):
            before = interpolated(case.at_nodes, name, x, earlier)
            patterns.append(np.stack([known, known - before], axis=1) / size)
            doubt, fine, half, coarse = ((other - known) / size for other in others)
            changes = _sum(half - fine), _sum(coarse - half) / 2, _sum(coarse - fine) / 3
            units.append(min(changes) + least_error(case) + _sum(doubt))
    if max(units) > FORESEEN:
        return 0.0
    first, second, third = (_common(error, patterns[-1]) for error in (fine, half, coarse))
    alike = np.clip(_sum(half) / (_sum(fine) + TINY), *GROWTH) * second
    itself = np.clip(second * np.sign(first) / (np.abs(first) + TINY), *GROWTH) * second
    mixed = 6 * second - 8 * first
    between = np.clip(third, np.minimum(itself, mixed), np.maximum(itself, mixed))
    narrow = too_narrow(slips, NARROW)[slips].all()
    return min(
        max(_sum(pattern @ off) / unit for pattern, unit in zip(patterns, units, strict=True))
        for off in (third - alike, third - between)
    ) / (COARSE * LARGEST if narrow else LARGEST)


def _common(error: Array, patterns: Array) -> Array:
    """Factors of patterns, (n, 2), that leave the smallest sum of deviations of an error, (n,)."""
    size, most = (np.abs(part).max(axis=0) + TINY for part in (patterns, error))
    known = patterns / size

    def deviations(factors: Array) -> Array:
        return known @ factors - error / most

    usual: Any = {"jac": lambda _: known, "loss": "soft_l1", "f_scale": SMOOTH}
    return most / size * scipy.optimize.least_squares(deviations, np.zeros(2), **usual).x


def _sum(values: Array) -> float:
    return float(np.abs(values).sum())
