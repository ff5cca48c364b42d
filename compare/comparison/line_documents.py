"""Answers of whole lines and growing loads as plain dictionaries, with units, for JSON."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from compare.comparison.documents import END_DIMENSIONS, Dimensions, motion_document
from semianalytic import GrowingSlot, GrowingSolution, LineSolution, PointForce, WholeLine
from semianalytic.scene.given.parameters import MATERIAL, TRACTIONS
from semianalytic.scene.units import unit
from semianalytic.whole_line.named import line_document

Answered = LineSolution | GrowingSolution

_TRACTIONS: Dimensions = {name: one.dimension for name, one in TRACTIONS.items()}


def problem_of(answer: Answered) -> WholeLine | GrowingSlot:
    """Return the problem that an answer is of."""
    return answer.line if isinstance(answer, LineSolution) else answer.slot


def line_answer_document(answer: Answered, end_time: float | None = None) -> dict[str, Any]:
    """An answer as plain dictionaries, lists, strings and numbers, with their units.

    With an end time [time], the document includes zones, slip and work until then.
    """
    problem = problem_of(answer)
    material = problem.material
    document: dict[str, Any] = {
        "line": line_document(problem),
        "wave_speeds": {
            "rayleigh": material.rayleigh_speed,
            "shear": material.shear_speed,
            "longitudinal": material.longitudinal_speed,
        },
        "edge_speed": answer.edge_speed,
        "edge_amplitude": answer.edge_amplitude,
        "zones": [asdict(zone) for zone in answer.zones],
        "openings": [asdict(part) for part in answer.openings],
        "status": answer.status,
        "error_estimate": answer.error_estimate,
    }
    if end_time is not None:
        document["until_end_time"] = motion_document(answer, end_time)
    document["units"] = _units(document, _dimensions(answer), problem.units)
    return document


def rate_dimension(answer: Answered) -> str:
    """Dimension of `edge_amplitude`."""
    if isinstance(answer, LineSolution):
        return "length / time"
    return f"length / time^{answer.slot.power + 1}"


def load_dimension(problem: WholeLine | GrowingSlot) -> str:
    """Dimension of the load: a stress, a force over a time, or a stress over a power of time."""
    if isinstance(problem, GrowingSlot):
        return "stress / time" + ("" if problem.power == 1 else f"^{problem.power}")
    return "stress length / time" if isinstance(problem.load, PointForce) else "stress"


def _dimensions(answer: Answered) -> Dimensions:
    problem = problem_of(answer)
    load = dict.fromkeys(("pressure", "shear"), load_dimension(problem))
    return {
        "line": {
            "friction": "1",
            "material": {name: one.dimension for name, one in MATERIAL.items()},
            "base": _TRACTIONS,
            "load": {"speed": "length / time", **load},
        },
        "wave_speeds": dict.fromkeys(("rayleigh", "shear", "longitudinal"), "length / time"),
        "edge_speed": "length / time",
        "edge_amplitude": rate_dimension(answer),
        "zones": {"inner": "length / time", "outer": "length / time", "sense": "sign of slip"},
        "openings": {"inner": "length / time", "outer": "length / time"},
        "error_estimate": "1",
        "until_end_time": END_DIMENSIONS,
    }


def _units(document: Any, dimensions: Any, units: str) -> Any:
    """Return the unit of each number of a document, under the same names."""
    if isinstance(dimensions, str):
        return _unit(dimensions, units)
    if isinstance(document, list):
        return _units(document[0], dimensions, units) if document else {}
    return {
        name: _units(document[name], below, units)
        for name, below in dimensions.items()
        if name in document
    }


def _unit(dimension: str, units: str) -> str:
    """Return a unit; those of rates of stress and force follow from their parts."""
    whole = unit(dimension, units)
    if not units or whole != dimension.replace(" / ", "/"):
        return whole
    return _IN_SI.get(dimension, whole)


_IN_SI: Mapping[str, str] = {
    "stress / time": "Pa/s",
    "stress / time^2": "Pa/s^2",
    "stress length / time": "N/(m s)",
    "length / time^2": "m/s^2",
    "length / time^3": "m/s^3",
}
