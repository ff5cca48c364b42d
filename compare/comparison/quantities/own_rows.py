"""What a simulation has to hold by itself, whatever is predicted: numbers, Coulomb's law, slip."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from compare.comparison.bars import ErrorBar
from compare.comparison.case import Case
from compare.comparison.judging import Comparison, judged
from compare.comparison.measures import NOTHING
from compare.comparison.rows import Row
from semianalytic.scene.errors import DataFileError

if TYPE_CHECKING:
    from fem import Simulation, SlotHistory
    from semianalytic import InterfaceHistory

Array = NDArray[np.float64]

FIELDS = ("slip", "slip_rate", "shear_traction", "pressure", "gap")
WHOLE_STEPS = 1e-6
"""Part of a step by which half a window may miss a whole number of them, for rounding."""


def check_finite(simulation: Simulation) -> None:
    """Refuse a simulation with values that are not finite numbers; its coarser meshes count too.

    Raises
    ------
    DataFileError
        It says which field, where and when.
    """
    run: Simulation | None = simulation
    while run is not None:
        parts: list[tuple[InterfaceHistory | SlotHistory, str]] = [
            *((run.interface, name) for name in FIELDS),
            *((run.slot, name) for name in ("velocity_x", "velocity_y")),
        ]
        for history, name in parts:
            wrong = ~np.isfinite(getattr(history, name))
            if wrong.any():
                level, node = np.argwhere(wrong)[0]
                raise _refusal(run, name, f"x = {history.x[node]:.6g}, t = {history.t[level]:.6g}")
        for name in ("final_path", "final_work_density"):
            wrong = ~np.isfinite(getattr(run, name))
            if wrong.any():
                raise _refusal(run, name, f"x = {run.interface.x[np.flatnonzero(wrong)[0]]:.6g}")
        run = run.companion


def _refusal(run: Simulation, name: str, place: str) -> DataFileError:
    return DataFileError(
        f"the simulation of resolution {run.resolution} holds a {name.replace('_', ' ')} that is "
        f"not a finite number, at {place}; simulate again."
    )


def own_rows(case: Case) -> Iterator[Row]:
    """By how much a simulation breaks the law of friction, and its slip is not that of its slip
    rate: by rounding, if nothing is at fault."""
    yield _own_row(case, "traction beyond friction", _beyond_friction(case) / case.stress, "τ₀")
    mismatch, bar = _mismatch(case)
    yield _own_row(case, "slip rate against slip", mismatch / case.rate, "V₀", bar / case.rate)


def _own_row(case: Case, name: str, value: float, unit: str, bar: float = 0.0) -> Row:
    row = Row(name, "law", None, 0.0, value, value, None, unit)
    return judged(case, row, Comparison(ErrorBar(NOTHING + bar, None, 0.0, converges=True)))


def _beyond_friction(case: Case) -> float:
    """Largest excess of shear traction over strength [stress], 0 at least.

    Strength is taken before any slip has weakened it; where it rises with slip rate, at the largest
    rate of the steps on either side of a level.
    """
    seen, scene = case.seen, case.scene
    frictional = scene.friction * seen.pressure
    levels = slice(None)
    speed = np.zeros(frictional.shape)
    if np.any(scene.friction_law.strength(1.0, case.rate, 0.0) > 1.0):
        steps = np.abs(np.diff(seen.slip, axis=0)) / np.diff(seen.t)[:, None]
        speed = np.maximum(steps[:-1], steps[1:])
        levels = slice(1, -1)
    allowed = scene.friction_law.strength(frictional[levels], speed, 0.0)
    return float(np.max(np.abs(seen.shear_traction[levels]) - allowed, initial=0.0))


def _mismatch(case: Case) -> tuple[float, float]:
    """Largest difference between a slip rate and the slip it stands for [length / time], and what
    the times between stored levels leave open of it.

    The slip rate of a level is the mean over a window about it.  Where slip is stored at both ends
    of the window, it is held against that; else the slip at the end is held against
    the sum of all slip rates.
    """
    simulation, seen = case.simulation, case.seen
    step = float(seen.t[1] - seen.t[0])
    half = simulation.rate_window / (2 * step)
    whole = round(half)
    if whole and abs(half - whole) < WHOLE_STEPS and len(seen.t) > 2 * whole:
        inner = slice(whole, len(seen.t) - whole)
        mean = (seen.slip[2 * whole :] - seen.slip[: -2 * whole]) / simulation.rate_window
        return float(np.max(np.abs(mean - seen.slip_rate[inner]), initial=0.0)), 0.0
    slip = np.trapezoid(seen.slip_rate, seen.t, axis=0)
    off = np.abs(seen.slip[-1] - slip) / case.end_time
    open_ = (simulation.rate_window / 2 + step) / case.end_time * np.ptp(seen.slip_rate, axis=0)
    worst = int(np.argmax(off - open_))
    return float(off[worst]), float(open_[worst])
