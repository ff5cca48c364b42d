"""All rows of a comparison with what they came from, as an object and as JSON."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from compare.comparison.arrival_rows import arrival_rows
from compare.comparison.documents import (
    SCENE_DIMENSIONS,
    Dimensions,
    json_text,
    solution_document,
    units_document,
)
from compare.comparison.edge_rows import onset_rows, zone_rows
from compare.comparison.history_rows import (
    event_rows,
    rate_rows,
    sense_rows,
    slip_and_work_rows,
    slips,
)
from compare.comparison.prediction import Prediction
from compare.comparison.profile_rows import slip_rate_rows, snapshot_rows, traction_rows
from compare.comparison.rows import Row
from compare.comparison.scales import reference_values
from compare.comparison.snapshots import SlipRateProfile
from compare.output.files import write_text
from semianalytic.scene.scene import scene_document

if TYPE_CHECKING:
    from fem import Simulation


REPORT_DIMENSIONS: Dimensions = {
    "parameters": SCENE_DIMENSIONS,
    "finite_elements": {
        "end_time": "time",
        "element_size": "length",
        "damping": "element_size / c_t",
        "time_step": "time",
        "critical_step": "time",
        "opened": {"time": "time", "x": "length", "gap": "length", "length": "length"},
        "seconds": "s",
    },
}


@dataclass(frozen=True, eq=False)
class Report:
    """All rows of one comparison."""

    label: str
    prediction: Prediction
    simulation: Simulation
    rows: tuple[Row, ...]

    @property
    def passed(self) -> bool:
        """Whether every row is within its tolerance."""
        return all(row.passed for row in self.rows)


def build_report(
    label: str,
    prediction: Prediction,
    simulation: Simulation,
    snapshot: SlipRateProfile | None = None,
) -> Report:
    """Compare a prediction and a simulation of the same scene, quantity by quantity.

    Fronts, zones and tractions at the end are compared where the prediction is self-similar; the
    slip rate over space and time always is, and what slip does where any is predicted.

    Parameters
    ----------
    label : str
        Name of the scene, for titles.
    prediction : Prediction
        At the nodes and times of the simulation.
    simulation : Simulation
        The finite-element answer; its last recorded time is the final time.
    snapshot : SlipRateProfile, optional
        What the last field snapshot holds, to be compared as well.
    """
    rows: list[Row] = []
    solution = prediction.solution
    if solution is not None:
        rows += [
            *arrival_rows(solution, simulation),
            *zone_rows(solution, simulation),
            *slip_rate_rows(solution, simulation),
            *onset_rows(solution, simulation),
            *traction_rows(solution, simulation),
        ]
        if snapshot is not None:
            rows += snapshot_rows(solution, simulation, snapshot)
    rows += rate_rows(prediction, simulation)
    if slips(prediction, simulation):
        rows += [
            *sense_rows(prediction, simulation),
            *event_rows(prediction, simulation),
            *slip_and_work_rows(prediction, simulation),
        ]
    return Report(label, prediction, simulation, tuple(rows))


def report_document(report: Report) -> dict[str, Any]:
    """The report as plain dictionaries, lists, strings and finite numbers, for JSON.

    "units" mirrors it; what rows call their unit is in units/rows, or a unit by itself.
    """
    simulation, solution = report.simulation, report.prediction.solution
    document: dict[str, Any] = {
        "scene": report.label,
        "passed": report.passed,
        "parameters": scene_document(simulation.scene),
        "method": report.prediction.method,
        "caution": report.prediction.caution,
        "semianalytic": None if solution is None else solution_document(solution),
        "finite_elements": {
            "run": simulation.run,
            "end_time": simulation.end_time,
            "resolution": simulation.resolution,
            "element_size": simulation.element_size,
            "model": simulation.model,
            "damping": simulation.damping,
            "time_step": simulation.time_step,
            "critical_step": simulation.critical_step,
            "steps": simulation.steps,
            "unknowns": simulation.unknowns,
            "caution": simulation.caution,
            "opened": simulation.opened and asdict(simulation.opened),
            "seconds": dict(simulation.seconds),
        },
        "rows": [
            {**asdict(row), "present": row.present, "passed": row.passed} for row in report.rows
        ],
    }
    references = reference_values(simulation.scene, simulation.end_time)
    document["units"] = units_document(document, REPORT_DIMENSIONS, simulation.scene)
    document["units"]["rows"] = {
        symbol: f"{value:.10g} {unit}" for symbol, (value, unit) in references.items()
    }
    return document


def write_report(report: Report, path: Path) -> None:
    """Write the report as JSON, whole or not at all.

    Raises
    ------
    DataFileError
        If the file cannot be written.
    """
    write_text(path, json_text(report_document(report)))
