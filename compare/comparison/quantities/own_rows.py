"""Checks of a simulation by itself, whatever is predicted: finite values, state of rest, friction
law, slip."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy
from numpy.typing import NDArray

from compare.comparison.bars import ErrorBar
from compare.comparison.case import FIELDS, WHOLE_STEPS, Case, companions_of
from compare.comparison.judging import judged
from compare.comparison.measures import NOTHING
from compare.comparison.rows import TELLING, Row
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import DataFileError

if TYPE_CHECKING:
    from fem import Simulation


WORN = ("final_path", "final_work_density")
BEYOND, MISMATCH = "traction beyond friction", "slip rate against slip"
AT_REST = "traction before the waves"
SPARSE = (
    "only some steps of the simulation are stored, which do not determine {}; store all of them"
)


def check_finite(simulation: Simulation) -> None:
    """Refuse a simulation with values that are not finite numbers; its coarser meshes count too."""
    for run in (simulation, *companions_of(simulation)):
        whose = f"the simulation of resolution {run.resolution}"
        contact, slot, end = run.interface, run.slot, run.interface.t[-1:]
        refuse_unfinite(whose, contact.x, contact.t, fields_of(contact, FIELDS))
        refuse_unfinite(whose, slot.x, slot.t, fields_of(slot, ("velocity_x", "velocity_y")))
        worn = {name: values[None] for name, values in fields_of(run, WORN).items()}
        refuse_unfinite(whose, contact.x, end, worn)


def fields_of(history: Any, names: Iterable[str]) -> dict[str, Array]:
    """Return fields of a history by name."""
    return {name: getattr(history, name) for name in names}


def refuse_unfinite(whose: str, x: Array, t: Array, fields: Mapping[str, Array]) -> None:
    """Refuse fields, (m, n) at times t (m,) and places x (n,), that are not finite numbers."""
    for name, values in fields.items():
        wrong = np.argwhere(~np.isfinite(values))
        if len(wrong):
            level, node = wrong[0]
            raise DataFileError(
                f"{whose} has a {name.replace('_', ' ')} that is not a finite number, at "
                f"x = {x[node]:.6g}, t = {t[level]:.6g}; compute it again."
            )


def own_rows(case: Case) -> Iterator[Row]:
    """Rows of the tractions before any wave, of the excess of traction over the law of friction and
    of the mismatch between slip and slip rate, all of the size of rounding errors in a correct
    simulation."""
    changed = _changed_at_rest(case)
    if changed is not None:
        yield own_row(case, AT_REST, changed / case.stress, "τ₀")
    excess = _beyond_friction(case)
    if excess is None:
        yield own_row(case, BEYOND, None, "τ₀", obstacle=SPARSE.format("a rate of each step"))
    else:
        yield own_row(case, BEYOND, excess / case.stress, "τ₀")
    off, bar = _mismatch(case)
    obstacle = ""
    if bar > TELLING * float(np.abs(case.seen.slip).max()) / case.end_time:
        obstacle = SPARSE.format("what slips between two levels")
    yield own_row(case, MISMATCH, off / case.rate, "V₀", bar / case.rate, obstacle)


def own_row(
    case: Case, name: str, value: float | None, unit: str, bar: float = 0.0, obstacle: str = ""
) -> Row:
    """Return the row of something that is 0 in a correct simulation but for rounding."""
    row = Row(name, "law", None, 0.0, value, value, None, unit)
    row = judged(case, row, ErrorBar(NOTHING + bar, None, 0.0, converges=True))
    return replace(row, obstacle=obstacle) if obstacle else row


def _changed_at_rest(case: Case) -> float | None:
    """Largest difference of the tractions at t = 0 from those in place [stress]; None if that level
    is not stored, or if a wave rises while it arrives, so that the contact has had a part of it.

    Where nothing slips no other law detects a pressure that is wrong in proportion.
    """
    seen, scene = case.seen, case.scene
    if seen.t[0] > 0 or (scene.arrives and not scene.is_step):
        return None
    rest = scene.superposition.in_place
    changes = [seen.pressure[0] - rest.pressure]
    # Where the load exceeds friction, the contact slips at once and takes off the rest.
    if scene.far_slip_rate == 0:
        changes.append(seen.shear_traction[0] - rest.shear)
    return float(np.abs(changes).max(initial=0.0))


def _beyond_friction(case: Case) -> float | None:
    """Largest excess of shear traction over strength [stress], at least 0; None if the stored
    levels do not show it.

    The strength is that before any weakening by slip.  Where it rises with slip rate, the larger
    rate of the steps before and after a level counts, so that all steps have to be stored.  Slip
    rates that are not means over a window are taken at the level itself.
    """
    simulation, seen, scene = case.simulation, case.seen, case.scene
    levels, speed = slice(None), np.zeros(seen.pressure.shape)
    pressure = scene.superposition.in_place.pressure
    if np.any(scene.strength(pressure, case.rate) > scene.strength(pressure)):
        passed = np.diff(seen.t)
        if not simulation.rate_window:
            speed = np.abs(seen.slip_rate)
        elif passed.max() > (1 + WHOLE_STEPS) * simulation.time_step:
            return None
        else:
            steps = np.abs(np.diff(seen.slip, axis=0)) / passed[:, None]
            speed, levels = np.maximum(steps[:-1], steps[1:]), slice(1, -1)
    allowed = scene.strength(seen.pressure[levels], speed)
    return float(np.max(np.abs(seen.shear_traction[levels]) - allowed, initial=0.0))


def _mismatch(case: Case) -> tuple[float, float]:
    """Largest mismatch between slip rate and slip [length / time], and its uncertainty due to the
    times between stored levels.

    The slip rate of a level is the mean over a window around it.  Where slip is stored at both ends
    of the windows of most levels, each slip rate is compared with the slip gained in its window.
    Else the slip at the end is compared with the time integral of the slip rates.
    """
    seen, simulation = case.seen, case.simulation
    later = simulation.time_step * np.arange(1, len(simulation.slip_after) + 1)
    t = np.concatenate([seen.t, seen.t[-1] + later])
    slip = np.concatenate([seen.slip, simulation.slip_after])
    half = np.minimum(simulation.rate_window / 2, seen.t)
    begin, end = (_stored_at(case, t, seen.t + side * half) for side in (-1, 1))
    whole = (half > 0) & (begin >= 0) & (end >= 0)
    if 2 * np.count_nonzero(whole) > len(seen.t):
        mean = (slip[end[whole]] - slip[begin[whole]]) / (2 * half[whole, None])
        return float(np.max(np.abs(mean - seen.slip_rate[whole]), initial=0.0)), 0.0
    gained = np.trapezoid(seen.slip_rate, seen.t, axis=0)
    off = np.abs(seen.slip[-1] - gained) / case.end_time
    open_ = _between_levels(case) / case.end_time
    worst = int(np.argmax(off - open_))
    return float(off[worst]), float(open_[worst])


def _stored_at(case: Case, t: Array, times: Array) -> NDArray[np.intp]:
    """Indices of the levels, at times t (n,), at times (m,); -1 where none is stored."""
    rounding = WHOLE_STEPS * case.simulation.time_step
    level = np.minimum(np.searchsorted(t, times - rounding), t.size - 1)
    return np.where(np.abs(t[level] - times) <= rounding, level, -1)


def _between_levels(case: Case) -> Array:
    """Largest difference between slip and the integral of the slip rates at stored levels [length],
    (n,), that the times between levels allow.

    A feature that passes a node between two levels is seen at one of the two at a node no farther
    away than the fastest wave travels meanwhile.  The mean over the step therefore lies within the
    range of the rates there.  At both ends of the run half a window is missing or in excess.
    """
    simulation, seen = case.simulation, case.seen
    passed = np.diff(seen.t)
    nodes = math.ceil(case.fastest_speed * float(passed.max()) / simulation.element_size)
    most, least = (
        find(seen.slip_rate, 2 * nodes + 1, axis=1, mode="nearest")
        for find in (scipy.ndimage.maximum_filter1d, scipy.ndimage.minimum_filter1d)
    )
    ranges = np.maximum(most[1:], most[:-1]) - np.minimum(least[1:], least[:-1])
    ends = simulation.rate_window / 2 * (ranges[0] + ranges[-1])
    return np.asarray(passed @ ranges + ends)
