"""Rows of fields off the contact at the end: both bodies, and the velocity of the slot face."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from compare.comparison.bars import LARGEST_ORDER, LEAST_ORDER, error_bar
from compare.comparison.case import EDGE_CELLS, Case
from compare.comparison.fields.changes import PARTS, FieldChange
from compare.comparison.judging import Compared, field_row, judged, least_error
from compare.comparison.measures import within
from compare.comparison.rows import Row
from semianalytic.scene.arrays import Array


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

    shown = [within(-run.slot.x, start, reach) for run in case.runs]
    x = [-run.slot.x[here][::-1] for run, here in zip(case.runs, shown, strict=True)]
    # coarse meshes may have no nodes between edge and reach
    most = next((n for n, places in enumerate(x) if not len(places)), len(x)) - 1
    if most < 0:
        return
    every = [np.ones(len(places), dtype=bool) for places in x]
    moved = [_beside_front(case, places) for places in x[:2]]
    expected = [predict(-places, case.end_time) for places in moved]
    for part, (name, field) in enumerate(zip(names, ("velocity_x", "velocity_y"), strict=True)):
        recorded = [getattr(run.slot, field)[-1] for run in case.runs]
        faces = [rows[here][::-1] for rows, here in zip(recorded, shown, strict=True)]
        known = [np.asarray(fields[part]) for fields in expected]
        both = Compared(x, every, _of_run(faces), known.__getitem__)
        how: Any = {"scale": (case.rate, "V₀", "V₀ c_t T"), "meshes": most, "jumps": True}
        row = field_row(case, f"{name} of the slot face", "slot", both, **how)
        if row.relative:
            yield replace(row, exact=row.at_nodes)


def _of_run(fields: list[Array]) -> Callable[[int, int], Array]:
    """Return the function that gives the field of a run at the end, whatever the second number."""
    return lambda number, of: fields[number]


def _beside_front(case: Case, distance: Array) -> Array:
    """Return places moved off the front of a moving load, where a velocity may be infinite, by a
    quarter of an element."""
    slowness, away = -case.scene.front_slowness, case.simulation.element_size / 4
    if slowness <= 0:
        return distance
    off = distance - case.end_time / slowness
    return np.where(np.abs(off) < away, distance - off + away, distance)


def field_rows(case: Case, changes: tuple[FieldChange, ...]) -> Iterator[Row]:
    """Rows of relative L1 errors of all components of the last frame, whole and outside the band.

    Whole fields jump at fronts, which every mesh smears over some elements, so that no order of
    convergence above 1/2 is believed for them.
    """
    for change in changes:
        value, unit = _scale(case, change.component)
        row = Row(
            f"{change.component}, {change.part}",
            "field",
            None,
            change.norms.predicted / value,
            change.norms.simulated / value,
            change.difference,
            None,
            unit,
            relative=True,
        )
        most = LEAST_ORDER if change.part == PARTS[0] else LARGEST_ORDER
        error = error_bar(change.changes, least_error(case), most=most) if change.changes else None
        yield judged(case, row, error, change.before)


def _scale(case: Case, component: str) -> tuple[float, str]:
    """Return the unit of norms of a component over the area: value and name."""
    area = case.length**2
    if component.startswith("sigma"):
        return case.stress * area, "τ₀ c_t² T²"
    if component.startswith("v"):
        return case.rate * area, "V₀ c_t² T²"
    return case.rate * case.end_time * area, "V₀ c_t² T³"
