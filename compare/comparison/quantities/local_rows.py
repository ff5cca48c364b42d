"""Rows of single places and times: the largest difference over its own error bar."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import scipy
from numpy.typing import NDArray

from compare.comparison.bars import ErrorBar
from compare.comparison.case import Case
from compare.comparison.fields.fronts import jump_times
from compare.comparison.judging import Comparison, judged
from compare.comparison.measures import NOTHING, ROUNDING
from compare.comparison.rows import Row
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.results.sampled import interpolated

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

BAND = 2
"""Number of elements of the coarsest mesh on either side of fronts and edges that are left out; the
length is the same on all meshes."""
EARLY = 0.2
"""Initial part of the run, over the end time, that is left out because little is resolved in it."""
LOCAL = 1.0
"""Error that the mesh of h may have at a place, over the largest change from 4h to 2h within a band
around it.  Of all places of 204 scenes, none was off by more than 1.5 times this and `LOCAL_FLOOR`;
with half of it, 11 scenes would have had one."""
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
    if len(case.runs) < 3:
        return
    shown = ~_beside_fronts(case)
    if not shown.any():
        return
    slip = case.rate * case.end_time
    fields = [
        ("slip_rate", case.rate, "V₀"),
        ("slip", slip, "V₀ T"),
        ("shear_traction", case.stress, "τ₀"),
        ("pressure", case.stress, "τ₀"),
    ]
    for name, unit, symbol in [*fields, ("gap", slip, "V₀ T")] if case.opens else fields:
        yield _local_row(case, name, unit, symbol, shown)


def _local_row(case: Case, name: str, unit: float, symbol: str, shown: Mask) -> Row:
    seen, (middle, coarse) = case.seen, (run.interface for run in case.runs[1:3])
    predicted, simulated = (getattr(one, name) / unit for one in (case.at_nodes, seen))
    x, t = np.broadcast_arrays(seen.x, seen.t[:, None])
    change = np.abs(interpolated(middle, name, x, t) - interpolated(coarse, name, x, t)) / unit
    change += _driven(case, name)
    largest = float(np.abs(getattr(middle, name)).max()) / unit
    bar = LOCAL * scipy.ndimage.maximum_filter(change, _band(case)) + LOCAL_FLOOR * largest
    bar += NOTHING + case.error_estimate * largest
    if case.doubted is not None:
        doubt = np.abs(getattr(case.doubted, name) / unit - predicted)
        bar += scipy.ndimage.maximum_filter(doubt, _band(case))
    row, at = place_row(name, symbol, (predicted, simulated), np.where(shown, bar, np.inf))
    x, when = seen.x[at[1]] / case.length, seen.t[at[0]] / case.end_time
    row = replace(row, place=f"x = {x:.3f} c_t T, t = {when:.3f} T")
    if case.opens and not all(run.interface.gap.any() for run in case.runs):
        finer = 2 * case.simulation.resolution
        row = replace(row, bar=float(bar[at]), resolution=finer)
        return replace(row, obstacle="one mesh opens, another does not: no place has a bar")
    return judged(case, row, Comparison(ErrorBar(float(bar[at]), None, np.inf, converges=True)))


def place_row(
    name: str, symbol: str, fields: tuple[Array, Array], bar: Array
) -> tuple[Row, tuple[np.intp, ...]]:
    """Return the row of the place at which a field is off by the most error bars, still without its
    bar, and the indices of that place.

    Parameters
    ----------
    name, symbol : str
        The field and its unit.
    fields : pair of (m, n) arrays
        As predicted and as simulated.
    bar : (m, n) array
        Error bar of each place, infinite where it is left out.
    """
    predicted, simulated = fields
    off = np.abs(simulated - predicted) / np.maximum(bar, np.finfo(float).tiny)
    at = np.unravel_index(np.argmax(off), off.shape)
    before, after = float(predicted[at]), float(simulated[at])
    words = f"{name.replace('_', ' ')}, place by place"
    return Row(words, "local", None, before, after, after - before, None, symbol), at


def _driven(case: Case, name: str) -> Array:
    """Change of slip rate over V₀, or of slip over V₀ T, due to the change of strength from the
    mesh at 4h to that at 2h, (m, n) at the nodes of the simulation; 0 for other fields."""
    seen, run, change = case.seen, case.runs[1].interface, case.strength_changes[1]
    if name == "slip":
        change = scipy.integrate.cumulative_trapezoid(change, run.t, axis=0, initial=0)
        change /= case.end_time
    elif name != "slip_rate":
        return np.zeros((len(seen.t), len(seen.x)))
    table = scipy.interpolate.RegularGridInterpolator(
        (run.t, run.x), change, bounds_error=False, fill_value=None
    )
    x, t = np.broadcast_arrays(
        np.clip(seen.x, run.x[0], run.x[-1]), np.clip(seen.t, run.t[0], run.t[-1])[:, None]
    )
    return np.asarray(table((t, x)))


def _beside_fronts(case: Case) -> Mask:
    """Mask of the nodes and times, (m, n), before `EARLY` or in the bands around the edge, around
    fronts sent out by the loads, and around ends of slip or openings in the prediction or on a
    coarser mesh."""
    seen, scene = case.seen, case.scene
    width = BAND * case.runs[2].element_size + ASIDE * case.simulation.element_size
    beside = np.zeros((len(seen.t), len(seen.x)), dtype=bool)
    flank = width / scene.material.shear_speed
    for start in {0.0, *jump_times(scene, flank)}:  # t = 0 has fronts even without a jump
        for speed in case.fronts.values():
            beside |= np.abs(seen.x - speed * (seen.t[:, None] - start)) < width
    motions = [_motion(case, case.at_nodes)]
    for run in case.runs[1:]:
        history = run.interface
        x = np.searchsorted(history.x, seen.x - ASIDE * case.simulation.element_size)
        t = np.searchsorted(history.t, (1 - ROUNDING) * seen.t)
        x, t = (np.minimum(at, size - 1) for at, size in ((x, len(history.x)), (t, len(history.t))))
        motions.append(_motion(case, history)[np.ix_(t, x)])
    changes = np.zeros(beside.shape, dtype=bool)
    for motion in motions:
        changes[:-1] |= np.diff(motion, axis=0) != 0
        changes[:, :-1] |= np.diff(motion, axis=1) != 0
    beside |= scipy.ndimage.maximum_filter(changes, _band(case))
    return beside | (seen.x < width) | (seen.t < (1 - ROUNDING) * EARLY * case.end_time)[:, None]


def _band(case: Case) -> tuple[int, int]:
    """Numbers of levels and of nodes in the band around a place, on both sides together."""
    width = BAND * case.runs[2].element_size
    step = float(case.seen.t[1] - case.seen.t[0]) * case.scene.material.shear_speed
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
