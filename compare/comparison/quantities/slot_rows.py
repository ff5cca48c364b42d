"""Rows of the velocity of the upper slot face at the end of a run, predicted and simulated."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from compare.comparison.case import EDGE_CELLS, Case
from compare.comparison.judging import Comparison, field_bar, judged
from compare.comparison.measures import NOTHING, norm, within
from compare.comparison.rows import Row

if TYPE_CHECKING:
    from fem import Simulation

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

    def moved(run: Simulation) -> tuple[Array, Array]:
        """Distances from the edge (n,) and the simulated velocities there over V0 (2, n)."""
        slot = run.slot
        shown = within(-slot.x, start, reach)
        velocity = np.stack([slot.velocity_x[-1, shown], slot.velocity_y[-1, shown]])
        return -slot.x[shown][::-1], velocity[:, ::-1] / case.rate

    def expected(distance: Array) -> Array:
        distance = _beside_front(case, distance)
        return np.stack(predict(-distance, case.end_time)) / case.rate

    recorded = [moved(run) for run in case.runs]
    distance, simulated = recorded[0]
    predicted = expected(distance)
    for part, name in enumerate(names):
        changes = [
            norm(fine[part] - np.interp(x, y, coarse[part]), x / case.length, 1)
            for (x, fine), (y, coarse) in pairwise(recorded)
        ]
        whole = norm(predicted[part], distance / case.length, 1)
        if whole <= NOTHING:
            continue

        def before(part: int = part, whole: float = whole) -> float:
            x, coarse = recorded[1]
            return norm(coarse[part] - expected(x)[part], x / case.length, 1) / whole

        row = Row(
            f"{name} of the slot face, L1",
            "slot",
            whole,
            whole,
            norm(simulated[part], distance / case.length, 1),
            norm(simulated[part] - predicted[part], distance / case.length, 1) / whole,
            None,
            "V₀ c_t T",
            relative=True,
        )
        error = field_bar(case, changes, whole, nothing=False)
        yield judged(case, row, Comparison(error, before))


def _beside_front(case: Case, distance: Array) -> Array:
    """Return places moved off the front of a moving load, where a velocity may be infinite, by a
    quarter of an element."""
    slowness, away = -case.scene.front_slowness, case.simulation.element_size / 4
    if slowness <= 0:
        return distance
    off = distance - case.end_time / slowness
    return np.where(np.abs(off) < away, distance - off + away, distance)
