"""Rows of the velocity of the upper slot face at the end of a run, predicted and simulated."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from compare.comparison.case import EDGE_CELLS, Case
from compare.comparison.judging import Compared, field_row
from compare.comparison.measures import NOTHING, norm, within
from compare.comparison.rows import Row

Array = NDArray[np.float64]


def slot_rows(case: Case) -> Iterator[Row]:
    """Rows of relative L1 errors of the velocity of the upper slot face at the end, by component.

    They include all fronts on the face, above all that of the Rayleigh wave, and the front of a
    load that moves over it.  There are no rows for predictions that do not know the slot, nor for a
    component that vanishes.
    """
    predict = getattr(case.prediction, "slot_velocity", None)
    if predict is None:
        return
    start = (EDGE_CELLS + 0.5) * case.simulation.element_size
    reach = min(case.scene.fastest_speed * case.end_time, *(-run.slot.x[0] for run in case.runs))
    names = ("v_z" if case.scene.antiplane else "v_x", "v_y")

    places = []
    for run in case.runs:
        shown = within(-run.slot.x, start, reach)
        places.append((-run.slot.x[shown][::-1], shown))

    def size(values: Array, of: int) -> float:
        return norm(values, places[of][0] / case.length, 1)

    for part, (name, field) in enumerate(zip(names, ("velocity_x", "velocity_y"), strict=True)):

        def simulated(number: int, of: int, field: str = field) -> Array:
            x, shown = places[number]
            velocity = getattr(case.runs[number].slot, field)[-1, shown][::-1]
            return np.interp(places[of][0], x, velocity) / case.rate

        def predicted(of: int, part: int = part) -> Array:
            distance = _beside_front(case, places[of][0])
            return np.asarray(predict(-distance, case.end_time)[part]) / case.rate

        whole = size(predicted(0), 0)
        if whole > NOTHING:
            row = f"{name} of the slot face", "slot"
            both = Compared(simulated, predicted, size)
            yield field_row(case, *row, both, ("V₀", "V₀ c_t T"), exact=whole)


def _beside_front(case: Case, distance: Array) -> Array:
    """Return places moved off the front of a moving load, where a velocity may be infinite, by a
    quarter of an element."""
    slowness, away = -case.scene.front_slowness, case.simulation.element_size / 4
    if slowness <= 0:
        return distance
    off = distance - case.end_time / slowness
    return np.where(np.abs(off) < away, distance - off + away, distance)
