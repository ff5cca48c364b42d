"""JSON report of a judgement, with the prediction and the simulation that it compares."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from compare.comparison.case import Case
from compare.comparison.documents import (
    SCENE_DIMENSIONS,
    Dimensions,
    json_text,
    row_units,
    solution_document,
    units_document,
)
from compare.comparison.fields.errors import BAND
from compare.comparison.judgement import Judgement, own_bars, side_by_side
from compare.output.places import write_text
from semianalytic.results.answer import Answer, method_of
from semianalytic.scene.given.documents import scene_document

if TYPE_CHECKING:
    from fem import Simulation

_RUN_DIMENSIONS: Dimensions = {
    "end_time": "time",
    "element_size": "length",
    "damping": "element_size / c_t",
    "time_step": "time",
    "critical_step": "time",
    "opened": {"time": "time", "x": "length", "gap": "length", "length": "length"},
    "seconds": "s",
}
REPORT_DIMENSIONS: Dimensions = {
    "parameters": SCENE_DIMENSIONS,
    "fields": {"band": "element_size", "frames": {"time": "time"}},
    "finite_elements": _RUN_DIMENSIONS,
}
SIMULATION_DIMENSIONS: Dimensions = {
    "scene": SCENE_DIMENSIONS,
    "finite_elements": _RUN_DIMENSIONS,
}


def judged_document(judgement: Judgement) -> dict[str, Any]:
    """The verdict and all rows of a judgement, of a scene or of an interface."""
    return {
        "verdict": judgement.verdict,
        "counts": judgement.counts,
        "quoted": judgement.quoted,
        "caution": judgement.case.caution,
        "rows": [
            {**asdict(row), "verdict": row.verdict, "remedy": judgement.remedy(row)}
            for row in judgement.rows
        ],
    }


def report_document(judgement: Judgement, label: str) -> dict[str, Any]:
    """A judgement as plain dictionaries, lists, strings and finite numbers, for JSON.

    `label` names the scene.  "units" mirrors the document.  The unit of a row is a symbol that is
    explained in units/rows, or a unit by itself.
    """
    simulation, prediction = judgement.simulation, judgement.prediction
    document: dict[str, Any] = {
        "scene": label,
        **judged_document(judgement),
        "parameters": scene_document(simulation.scene),
        "method": method_of(prediction),
        "semianalytic": _exact(prediction),
        "finite_elements": _run(judgement.case),
        "fields": judgement.fields
        and {"band": BAND, "frames": [asdict(error) for error in judgement.fields.rows]},
    }
    document["units"] = units_document(document, REPORT_DIMENSIONS, simulation.scene)
    document["units"]["rows"] = row_units(simulation.scene, simulation.end_time)
    return document


def simulation_document(simulation: Simulation) -> dict[str, Any]:
    """A simulation as plain dictionaries, lists, strings and finite numbers, for JSON.

    "own_bars" are its error bars from its coarser meshes, relative or in "unit".
    """
    bars = () if simulation.companion is None else own_bars(simulation)
    document: dict[str, Any] = {
        "scene": scene_document(simulation.scene),
        "finite_elements": _run(side_by_side(simulation, simulation)),
        "own_bars": [
            {"name": row.name, "bar": row.bar, "unit": "relative" if row.relative else row.unit}
            for row in bars
        ],
    }
    document["units"] = units_document(document, SIMULATION_DIMENSIONS, simulation.scene)
    document["units"]["own_bars"] = row_units(simulation.scene, simulation.end_time)
    return document


def _exact(prediction: Answer) -> dict[str, Any] | None:
    """Return an exact answer as a document; None for other predictions."""
    exact = method_of(prediction) == "self-similar"
    return solution_document(prediction) if exact else None


def _run(case: Case) -> dict[str, Any]:
    """Settings of a simulation and the time that it took."""
    simulation = case.simulation
    return {
        "run": simulation.run,
        "end_time": simulation.end_time,
        "resolution": simulation.resolution,
        "companions": [run.resolution for run in case.coarser],
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
    }


def write_report(judgement: Judgement, label: str, path: Path) -> None:
    """Write a judgement as JSON; the file is complete or not written at all.

    Raises
    ------
    DataFileError
        If the file cannot be written.
    """
    write_text(path, json_text(report_document(judgement, label)))
