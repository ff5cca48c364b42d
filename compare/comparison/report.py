"""All rows of a comparison with what they came from, as an object and as JSON."""

from __future__ import annotations

import json
import math
from dataclasses import asdict, dataclass
from pathlib import Path
from types import NoneType
from typing import TYPE_CHECKING, Any

import numpy as np

from compare.comparison.history_rows import (
    PROBES,
    SENSE_THRESHOLD,
    event_rows,
    rate_rows,
    sense_rows,
    slips,
    wear_rows,
)
from compare.comparison.predictions import Prediction, predict
from compare.comparison.rows import (
    Row,
    arrival_rows,
    onset_rows,
    slip_rate_rows,
    snapshot_rows,
    traction_rows,
    zone_rows,
)
from compare.comparison.scales import speed_regime
from compare.comparison.snapshots import SlipRateProfile
from compare.output.files import write_text
from semianalytic import Marched, Solution
from semianalytic.halfplane.stuck_histories import intensity_history
from semianalytic.scene.named import NAMED_SCENES
from semianalytic.scene.scene import scene_document

if TYPE_CHECKING:
    from fem import Simulation


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
            *wear_rows(prediction, simulation),
        ]
    return Report(label, prediction, simulation, tuple(rows))


def default_report(name: str) -> Report:
    """What `slipfront compare NAME` finds of a named scene with default options."""
    from fem import simulate

    simulation = simulate(NAMED_SCENES[name].scene)
    return build_report(name, predict(simulation), simulation)


def report_document(report: Report) -> dict[str, Any]:
    """The report as plain dictionaries, lists, strings and finite numbers, for JSON."""
    simulation, solution = report.simulation, report.prediction.solution
    return {
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
            "seconds": dict(simulation.seconds),
        },
        "rows": [
            {**asdict(row), "present": row.present, "passed": row.passed} for row in report.rows
        ],
    }


def solution_document(solution: Solution) -> dict[str, Any]:
    """A solution as plain dictionaries, lists, strings and finite numbers, for JSON.

    An outer edge at infinity (the whole interface slips) is null.
    """
    material = solution.scene.material
    mode_one, mode_two = solution.stress_intensity(1.0)
    return {
        "scene": scene_document(solution.scene),
        "wave_speeds": {
            "rayleigh": material.rayleigh_speed,
            "shear": material.shear_speed,
            "longitudinal": material.longitudinal_speed,
        },
        "zones": [
            {
                "inner": zone.inner,
                "outer": zone.outer if math.isfinite(zone.outer) else None,
                "sense": zone.sense,
                "inner_regime": speed_regime(zone.inner, material),
                "outer_regime": speed_regime(zone.outer, material),
            }
            for zone in solution.zones
        ],
        "edge": {
            "state": edge_state(solution),
            "slip_rate": float(solution.edge_slip_rate),
            "stress_intensity_at_unit_time": {"K_I": float(mode_one), "K_II": float(mode_two)},
        },
        "far_slip_rate": solution.scene.far_slip_rate,
        "status": solution.status,
        "error_estimate": float(solution.error_estimate),
        "statistics": asdict(solution.statistics),
    }


def march_document(marched: Marched) -> dict[str, Any]:
    """A march as plain dictionaries, lists, strings and finite numbers, for JSON."""
    scene, seen, x, spacing = marched.scene, marched.seen, marched.grid.x, marched.grid.spacing
    largest = float(seen.slip_rate.max())
    length = scene.material.shear_speed * marched.end_time
    threshold = SENSE_THRESHOLD * largest
    mode_one, mode_two = (
        intensity_history(history, scene.load, scene.material, marched.end_time)[mode]
        for mode, history in enumerate((scene.pressure_history, scene.shear_history))
    )
    return {
        "scene": scene_document(scene),
        "method": "space-time",
        "status": marched.status,
        "caution": marched.caution,
        "end_time": marched.end_time,
        "largest_slip_rate": largest,
        "largest_slip": float(seen.slip.max()),
        "reach_of_slip": float(x[seen.slip_rate > threshold].max(initial=0.0)),
        "reach_of_reverse_slip": float(x[-seen.reverse > threshold].max(initial=0.0)),
        "onset": [
            {
                "x": float(x[node]),
                "time": float(seen.onset[node]) if math.isfinite(seen.onset[node]) else None,
            }
            for node in (int(np.argmin(np.abs(x - probe * length))) for probe in PROBES)
        ],
        "accumulated_slip": float(marched.final_path.sum() * spacing),
        "friction_work": float(marched.final_work_density.sum() * spacing),
        "stress_intensity_of_a_stuck_edge": {"K_I": float(mode_one), "K_II": float(mode_two)},
        "stored_levels": len(marched.interface.t),
        "statistics": {
            name: getattr(marched.statistics, name)
            for name in ("nodes", "steps", "poles", "memory_error", "seconds")
        },
    }


def edge_state(solution: Solution) -> str:
    """ "slipping" or "stuck": what the interface does at the edge of the slot, x = 0+."""
    return "slipping" if solution.zones and solution.zones[0].inner == 0 else "stuck"


def json_text(document: dict[str, Any]) -> str:
    """JSON of a document, numbers of numpy included; null for what is not a finite number."""
    return json.dumps(_finite(document), indent=2, allow_nan=False) + "\n"


def _finite(part: Any) -> Any:
    """Part of a document with None in place of infinities and what is not a number."""
    if isinstance(part, dict):
        return {key: _finite(value) for key, value in part.items()}
    if isinstance(part, (list, tuple)):
        return [_finite(value) for value in part]
    if isinstance(part, (str, int, NoneType)):
        return part
    return float(part) if math.isfinite(part) else None


def write_report(report: Report, path: Path) -> None:
    """Write the report as JSON, whole or not at all.

    Raises
    ------
    DataFileError
        If the file cannot be written.
    """
    write_text(path, json_text(report_document(report)))
