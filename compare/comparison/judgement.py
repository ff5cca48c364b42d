"""Whether a prediction and a simulation agree, quantity by quantity."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from compare.comparison.case import Case
from compare.comparison.fields.errors import FieldErrors, field_errors
from compare.comparison.quantities.arrival_rows import arrival_rows
from compare.comparison.quantities.edge_rows import opening_rows, zone_rows
from compare.comparison.quantities.field_rows import field_rows, slot_rows
from compare.comparison.quantities.history_rows import cycle_rows, event_rows, map_rows, sense_rows
from compare.comparison.quantities.likeness_rows import likeness_rows
from compare.comparison.quantities.local_rows import local_rows
from compare.comparison.quantities.own_rows import check_finite, own_rows
from compare.comparison.quantities.profile_rows import (
    gap_rows,
    slip_rate_rows,
    traction_rows,
    wear_rows,
)
from compare.comparison.rows import DIFFERS, UNRESOLVED, HasRows, Row, shown_number
from semianalytic import Marched, Solution
from semianalytic.results.answer import Answer
from semianalytic.results.in_words import html_table
from semianalytic.scene.errors import SceneError

if TYPE_CHECKING:
    from fem import Simulation


@dataclass(frozen=True, eq=False, repr=False)
class Judgement(HasRows[Row]):
    """All rows of one comparison.

    Attributes
    ----------
    case : Case
        Prediction and simulation, side by side.
    rows : tuple of Row
    fields : FieldErrors or None
        Errors of the field snapshots against the prediction; `rows` has those of the last one.
    """

    case: Case
    rows: tuple[Row, ...]
    fields: FieldErrors | None = None

    def __post_init__(self) -> None:
        logging.getLogger(__name__).info("%r", self)

    def _repr_html_(self) -> str:
        columns = ("quantity", "exact", "at nodes", "simulated", "difference", "bar", "verdict")
        rows = [
            (
                row.label,
                *map(shown_number, (row.exact, row.at_nodes, row.simulated)),
                *row.shown_shares(row.difference, row.bar),
                f"{row.said}: {row.obstacle}" if row.obstacle else row.said,
            )
            for row in self.rows
        ]
        caption = f"Judgement: {self.said} (rows {self.shown_counts}): {self.quoted}"
        return html_table(caption, columns, rows)

    @property
    def prediction(self) -> Answer:
        """Prediction that is compared."""
        return self.case.prediction

    @property
    def simulation(self) -> Simulation:
        """Simulation that is compared, with its companions."""
        return self.case.simulation

    @property
    def rests(self) -> bool:
        """Whether nothing moves, neither predicted nor simulated."""
        return self.case.rests

    def remedy(self, row: Row) -> str:
        """Return which mesh may resolve a row, in words; "" where none is known."""
        if row.verdict != UNRESOLVED or row.resolution is None:
            return ""
        return self.case.remedy(row.resolution)


def judge(
    prediction: Answer,
    simulation: Simulation,
    frames: Path | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Judgement:
    """Compare a prediction with a simulation.

    The prediction may be of another scene; the judge is tested in this way.

    Parameters
    ----------
    prediction : Answer
        A `Solution`, a `PairSolution`, a `Marched`, or another object with the same methods, on the
        nodes of the simulation and until its last time.
    simulation : Simulation
        Its companions, from which error bars come, are simulated unless it already has them.
    frames : Path, optional
        Folder of its field snapshots, the last of which is judged too.
    progress : callable, optional
        Called with (frame, frames) after each frame.

    Returns
    -------
    Judgement

    Raises
    ------
    SceneError
        If the simulation has blocks of two materials, and the prediction is for identical ones, or
        does not reach as far.
    DataFileError
        As `field_errors`.
    """
    from fem import with_companions

    if simulation.scene.lower_material is not None and isinstance(prediction, Solution | Marched):
        raise SceneError(
            "judge: this simulation has blocks of two materials, to which the theory of identical "
            "bodies does not apply; give the answer to its scene (docs/dissimilar.md)."
        )
    case = side_by_side(prediction, with_companions(simulation))
    fields = None
    if frames is not None:
        fields = field_errors(prediction, case.simulation, frames, progress)
    whole = () if fields is None else field_rows(case, fields.changes)
    return Judgement(case, (*_rows(case), *whole), fields)


def own_bars(simulation: Simulation) -> tuple[Row, ...]:
    """Slip rate and slip of a simulation with their error bars, from its companions alone."""
    check_finite(simulation)
    seen = simulation.interface
    return tuple(slip_rate_rows(Case(simulation, simulation, seen, None)))


def side_by_side(prediction: Answer, simulation: Simulation) -> Case:
    """Return the case of a prediction at the nodes and times of a simulation."""
    check_finite(simulation)
    x, t = simulation.interface.x, simulation.interface.t
    companion = getattr(prediction, "companion", None)
    return Case(
        prediction,
        simulation,
        prediction.history(x, t),
        None if companion is None else companion.history(x, t),
    )


def _rows(case: Case) -> Iterator[Row]:
    if case.scene.is_self_similar:
        yield from arrival_rows(case)
        yield from zone_rows(case)
        yield from opening_rows(case)
    yield from slot_rows(case)
    yield from slip_rate_rows(case)
    yield from gap_rows(case)
    yield from traction_rows(case)
    yield from map_rows(case)
    yield from local_rows(case)
    yield from own_rows(case)
    yield from likeness_rows(case)
    if case.rests:
        return
    yield from sense_rows(case)
    yield from event_rows(case)
    worn = tuple(wear_rows(case))
    yield from worn
    for row in cycle_rows(case):  # a part is not known better than the whole
        whole = worn[-1]
        unknown = whole.verdict == UNRESOLVED and row.verdict == DIFFERS
        yield replace(row, obstacle=whole.obstacle) if unknown else row
