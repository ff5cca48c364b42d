"""Rows of whole fields in both bodies in the last frame of snapshots, with their error bars."""

from __future__ import annotations

from collections.abc import Iterator

from compare.comparison.bars import LARGEST_ORDER, LEAST_ORDER, error_bar
from compare.comparison.case import Case
from compare.comparison.fields.changes import PARTS, FieldChange
from compare.comparison.judging import judged, least_error
from compare.comparison.rows import Row


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
