"""Rows of single places and times: the largest difference over its own error bar."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import scipy
from numpy.typing import NDArray

from compare.comparison.bars import ErrorBar
from compare.comparison.case import Case
from compare.comparison.judging import judged
from compare.comparison.measures import ROUNDING
from compare.comparison.rows import Row
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.results.sampled import interpolated
from semianalytic.scene.arrays import Array, Mask

BAND = 2
"""Number of elements of the coarsest mesh on either side of fronts and edges that are left out; the
length is the same on all meshes."""
LOCAL = 1.0
"""Error that the mesh of h may have at a place, over the largest change from 4h to 2h within a band
around it.  Among all places of 204 scenes none was off by more than 1.5 times this and
`LOCAL_FLOOR`; with half of it, 11 scenes would have had one."""
LOCAL_FLOOR = 1e-3
"""Least uncertainty everywhere, over the largest value of the field, measured likewise."""
ASIDE = 0.25
"""Part of an element by which bands are widened, so that no nodes lie at their ends, where rounding
would decide."""
STILL = 1e-3
"""Part of the largest slip rate, and of the largest gap, above which a place counts as moving."""


def local_rows(case: Case) -> Iterator[Row]:
    """Row of each field at the place and time at which it is off by the most error bars.

    The bar of a place comes from the two coarser meshes alone, so that a single wrong value of the
    simulation does not widen it.  There are no rows without two coarser meshes.
    """
    for name, at, (before, after, own) in worst_places(case):
        words, symbol = f"{name.replace('_', ' ')}, place by place", case.unit(name)[1]
        row = Row(words, "local", None, before, after, after - before, own, symbol)
        row = replace(row, place=case.place(*at))
        if case.opens and not all(run.interface.gap.any() for run in case.runs):
            reason = "one mesh opens, another does not: no place has a bar"
            yield replace(row, obstacle=reason, resolution=2 * case.simulation.resolution)
        else:
            yield judged(case, row, ErrorBar(own, None, np.inf, converges=True))


def worst_places(case: Case) -> Iterator[tuple[str, tuple[int, int], tuple[float, float, float]]]:
    """Yield each field with the level and node at which it is off by the most error bars, and with
    the predicted value there, the simulated one and the bar, over the unit of the field."""
    if len(case.runs) < 3:
        return
    left_out, moving = case.beside_fronts(_width(case)), _beside_motion(case)
    left_out |= (case.seen.t < (1 - ROUNDING) * case.early * case.end_time)[:, None]
    if not (left_out | moving).all():
        for name in case.fields:
            yield name, *_worst(case, name, left_out, moving)


def _worst(
    case: Case, name: str, left_out: Mask, moving: Mask
) -> tuple[tuple[int, int], tuple[float, float, float]]:
    unit = case.unit(name)[0]
    seen, (middle, coarse) = case.seen, (run.interface for run in case.runs[1:3])
    predicted, simulated = (getattr(history, name) / unit for history in (case.at_nodes, seen))
    x, t = np.broadcast_arrays(seen.x, seen.t[:, None])
    rough = interpolated(coarse, name, x, t) / unit
    change = np.abs(interpolated(middle, name, x, t) / unit - rough)
    # Where the curves of both meshes cross, a place is not known better than all of the field.
    whole = change.sum() / max(np.abs(rough).sum(), np.finfo(float).tiny)
    change = np.maximum(change, whole * np.abs(predicted)) + _driven(case, name)
    largest = float(np.abs(getattr(middle, name)).max()) / unit
    bar = LOCAL * scipy.ndimage.maximum_filter(change, _band(case)) + LOCAL_FLOOR * largest
    bar = case.local * bar + case.nothing(name) + case.error_estimate * largest
    if case.doubted is not None:
        doubt = np.abs(getattr(case.doubted, name) / unit - predicted)
        bar += scipy.ndimage.maximum_filter(doubt, _band(case))
    bar[moving] *= case.beside_motion
    off = np.abs(simulated - predicted) / np.maximum(bar, np.finfo(float).tiny)
    off[left_out | np.isinf(bar)] = -1.0
    level, node = (int(at) for at in np.unravel_index(np.argmax(off), off.shape))
    at = level, node
    return at, (float(predicted[at]), float(simulated[at]), float(bar[at]))


def _driven(case: Case, name: str) -> Array:
    """Change of slip rate over V₀, or of slip over V₀ T, due to the change of strength from the
    mesh at 4h to that at 2h, (m, n) at the nodes of the simulation; 0 for other fields."""
    seen, run = case.seen, case.runs[2].interface
    if name not in ("slip", "slip_rate") or not case.strength_changes:
        return np.zeros((len(seen.t), len(seen.x)))
    change = case.strength_changes[1]
    if name == "slip":
        change = scipy.integrate.cumulative_trapezoid(change, run.t, axis=0, initial=0)
        change /= case.end_time
    places = np.broadcast_arrays(seen.x, seen.t[:, None])
    return interpolated(replace(run, slip=change), "slip", *places)


def _beside_motion(case: Case) -> Mask:
    """Mask of the nodes and times, (m, n), in the bands around ends of slip or openings in the
    prediction or on a coarser mesh, and where one stopped, whose kink tractions keep."""
    seen, changes = case.seen, np.zeros(case.seen.slip.shape, dtype=bool)
    motions = [_motion(case, case.at_nodes)]
    for run in case.runs[1:]:
        history = run.interface
        x = np.searchsorted(history.x, seen.x - ASIDE * case.simulation.element_size)
        t = np.searchsorted(history.t, (1 - ROUNDING) * seen.t)
        x, t = (np.minimum(at, size - 1) for at, size in ((x, len(history.x)), (t, len(history.t))))
        motions.append(_motion(case, history)[np.ix_(t, x)])
    for motion in motions:
        changes[:-1] |= np.diff(motion, axis=0) != 0
        changes[:, :-1] |= np.diff(motion, axis=1) != 0
        latest = np.maximum.accumulate(np.where(motion, seen.t[:, None], 0.0))
        changes[:, :-1] |= np.abs(np.diff(latest, axis=1)) > _width(case) / case.shear_speed
    return np.asarray(scipy.ndimage.maximum_filter(changes, _band(case)))


def _width(case: Case) -> float:
    """Half-width of bands around fronts and edges [length]."""
    return BAND * case.runs[2].element_size + ASIDE * case.simulation.element_size


def _band(case: Case) -> tuple[int, int]:
    """Numbers of levels and of nodes in the band around a place, on both sides together."""
    width = BAND * case.runs[2].element_size
    step = float(case.seen.t[1] - case.seen.t[0]) * case.shear_speed
    return 2 * round(width / step) + 1, 2 * round(width / case.simulation.element_size) + 1


def _motion(case: Case, history: InterfaceHistory) -> NDArray[np.int8]:
    """Sense of slip of a history, or 2 where it is open, (m, n).  Thresholds come from the mesh at
    2h, so that a wrong value of the simulation does not change them."""
    usual = case.runs[1].interface
    rate, gap = (float(np.abs(values).max()) for values in (usual.slip_rate, usual.gap))
    slips = np.abs(history.slip_rate) > STILL * max(rate, STILL * case.rate)
    sense = np.where(slips, np.sign(history.slip_rate), 0.0)
    opens = history.gap > STILL * max(gap, STILL * case.rate * case.end_time)
    return np.where(opens, 2, sense).astype(np.int8)
