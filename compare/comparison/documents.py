"""Solutions and marches as plain dictionaries, each number with its unit, for JSON."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path
from types import NoneType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from compare.comparison.measures import PROBES, SENSE_THRESHOLD, nearest
from compare.comparison.scales import reference_values, scene_fronts, speed_regime, wave_speeds
from semianalytic import Scene
from semianalytic.halfplane.rayleigh import Mode
from semianalytic.halfplane.stuck import front_share
from semianalytic.halfplane.stuck_histories import intensity_history
from semianalytic.results.answer import FIELDS
from semianalytic.results.datasets import QUANTITIES
from semianalytic.scene.given.documents import scene_document
from semianalytic.scene.given.parameters import (
    MATERIAL,
    TRACTIONS,
    load_parameters,
    part_parameters,
)
from semianalytic.scene.tabulated import HISTORY_FIELDS
from semianalytic.scene.units import PARAMETERS, unit

if TYPE_CHECKING:  # a solution is printed without what marches
    from semianalytic import Marched, Reading, Solution
    from semianalytic.dissimilar_slot.solution import PairSolution
    from semianalytic.results.reading import Measured

WAVES = {"Rayleigh": "rayleigh", "S": "shear", "P": "longitudinal"}

Dimensions = Mapping[str, Any]
"""Dimension of each number of a document, under the same names; a single one applies to all
numbers below it."""


def _dimensions(parameters: Mapping[str, Any]) -> Dimensions:
    """Return the dimensions of the parameters that have one."""
    return {name: entry.dimension for name, entry in parameters.items() if entry.dimension}


def _dimensions_of(field: str) -> Callable[[Scene], Dimensions]:
    """Return a function that gives the dimensions of a history, or the law, of a scene."""
    return lambda scene: _dimensions(part_parameters(type(getattr(scene, field))))


SCENE_DIMENSIONS: Dimensions = {
    "friction": "1",
    "material": _dimensions(MATERIAL),
    "lower_material": _dimensions(MATERIAL),
    "base": _dimensions(TRACTIONS),
    "load": lambda scene: _dimensions(load_parameters(scene.load)),
    **{name: _dimensions_of(name) for name in HISTORY_FIELDS},
    "friction_law": _dimensions_of("law"),
    "contact": {"intervals": "length"},
    **{name: PARAMETERS[name] for name in ("period", "rate", "plate_rate", "held")},
    "adhesion": {"strength": "stress", "length": "length"},
    "run": {"end_time": "time"},
}
END_DIMENSIONS: Dimensions = {
    "time": "time",
    "zones": {"start": "length", "end": "length", "sense": "sign of slip"},
    "openings": {"start": "length", "end": "length"},
    "largest_slip": "length",
    "accumulated_slip": "length^2",
    "frictional_work": "stress length^2",
    "stress_intensity": "stress sqrt(length)",
}
SOLUTION_DIMENSIONS: Dimensions = {
    "scene": SCENE_DIMENSIONS,
    "wave_speeds": "length / time",
    "zones": {"inner": "length / time", "outer": "length / time", "sense": "sign of slip"},
    "openings": "length / time",
    "edge": {
        "slip_rate": "length / time",
        "stress_intensity_at_unit_time": "stress sqrt(length)",
    },
    "far_slip_rate": "length / time",
    "error_estimate": "1",
    "statistics": {"seconds": "s", "residual": "1", "smallest_singular_value": "1"},
    "until_end_time": END_DIMENSIONS,
}
POINT_DIMENSIONS: Dimensions = {
    "x": "length",
    "t": "time",
    "arrivals": "time",
    **{name: QUANTITIES[name][0] for name in FIELDS},
}
MARCH_DIMENSIONS: Dimensions = {
    "scene": SCENE_DIMENSIONS,
    "error_estimate": "1",
    "error_estimates": "1",
    **dict.fromkeys(("end_time", "shortest_step", "longest_step"), "time"),
    "largest_slip_rate": "length / time",
    **dict.fromkeys(("largest_slip", "largest_gap"), "length"),
    "slipping": "1",
    "reach_of_slip": "length",
    "reach_of_reverse_slip": "length",
    "onset": {"x": "length", "time": "time"},
    "accumulated_slip": "length^2",
    "frictional_work": "stress length^2",
    "stress_intensity_of_a_stuck_edge": "stress sqrt(length)",
    "statistics": {"memory_error": "1", "seconds": "s"},
}


def units_document(document: Any, dimensions: Any, scene: Any) -> Any:
    """Return the unit of each number of a document, under the same names; counts have none.

    A callable in the place of dimensions returns them for the scene, whose units are used.
    """
    if callable(dimensions):
        dimensions = dimensions(scene)
    if isinstance(dimensions, str):
        return unit(dimensions, scene.units)
    if document is None:
        return {}
    if isinstance(document, list):
        return units_document(document[0], dimensions, scene) if document else {}
    if isinstance(document, str):  # a word, or an expression
        return ""
    return {
        name: units_document(document[name], below, scene)
        for name, below in dimensions.items()
        if name in document
    }


def row_units(scene: Scene, end_time: float) -> dict[str, str]:
    """Return the values and units of the symbols in which rows of a comparison are given."""
    return {
        symbol: f"{value:.10g} {unit}"
        for symbol, (value, unit) in reference_values(scene, end_time).items()
    }


def solution_document(answer: Any, end_time: float | None = None) -> dict[str, Any]:
    """An exact answer of any class as plain dictionaries, lists, strings and finite numbers.

    An outer edge at infinity (the whole interface slips) is null.  With an end time [time], the
    document includes zones, slip and work until then.
    """
    scene = answer.scene
    # without a slot all waves run along the contact, whatever the mode
    fronts = scene_fronts(scene) if scene.has_slot else wave_speeds(scene.material)
    document: dict[str, Any] = {
        "wave_speeds": _by_wave(fronts),
        "zones": [
            {**asdict(zone), "outer": zone.outer if math.isfinite(zone.outer) else None}
            for zone in answer.zones
        ],
        "openings": [asdict(part) for part in answer.openings],
        "status": answer.status,
        "error_estimate": float(answer.error_estimate),
    }
    document["scene"], dimensions = scene_document(scene), SOLUTION_DIMENSIONS
    if hasattr(answer, "edge_speed"):  # no slot, or a load that grows: what moves has one edge
        document["edge"] = {"speed": answer.edge_speed, "amplitude": answer.edge_amplitude}
        # rates of a load that grows as t^n do so too
        power = getattr(scene.load, "power", 0)
        amplitude = f"length / time{f'^{power + 1}' if power else ''}"
        edge = {"speed": "length / time", "amplitude": amplitude}
        dimensions = {**SOLUTION_DIMENSIONS, "edge": edge}
    else:
        document["edge"] = {"state": edge_state(answer), "slip_rate": float(answer.edge_slip_rate)}
        # one body has no equations of densities, and so no residual: nan is left out
        cost = asdict(answer.statistics).items()
        document["statistics"] = {name: value for name, value in cost if value == value}
        if scene.lower_material is not None:
            bodies = zip(("upper", "lower"), scene.bodies, strict=True)
            document["wave_speeds"] = {name: _by_wave(wave_speeds(body)) for name, body in bodies}
        else:
            document["far_slip_rate"] = scene.far_slip_rate
            intensities = _by_mode(scene, answer.stress_intensity(1.0))
            document["edge"]["stress_intensity_at_unit_time"] = intensities
            for shown, zone in zip(document["zones"], answer.zones, strict=True):
                shown["inner_regime"] = speed_regime(zone.inner, scene)
                shown["outer_regime"] = speed_regime(zone.outer, scene)
    if end_time is not None:
        document["until_end_time"] = end_document(answer, end_time)
    document["units"] = units_document(document, dimensions, scene)
    return document


def _by_wave(speeds: Mapping[str, float]) -> dict[str, float]:
    return {WAVES[name]: speed for name, speed in speeds.items()}


def end_document(answer: Any, end_time: float) -> dict[str, Any]:
    """Zones and openings in positions, slip and work of an exact answer until an end time [time].

    Slip ahead of all waves ends at infinity, and its totals are infinite.
    """
    document: dict[str, Any] = {
        "time": end_time,
        "zones": [asdict(zone) for zone in answer.zones_at(end_time)],
        "openings": [asdict(part) for part in answer.openings_at(end_time)],
        "largest_slip": float(answer.max_slip(end_time)),
        "accumulated_slip": float(answer.accumulated_slip(end_time)),
        "frictional_work": float(answer.frictional_work(end_time)),
    }
    if hasattr(answer, "stress_intensity"):
        intensities = answer.stress_intensity(end_time)
        document["stress_intensity"] = _by_mode(answer.scene, intensities)
    return document


def points_document(reading: Reading, at: bool = True) -> list[dict[str, Any]]:
    """Return arrivals and fields at points, each a value and the bar of its error.

    A time or bar that is infinite becomes null in JSON: nothing arrives, or no bar is known.
    Without times (`at`), arrivals are all there is.
    """
    points = []
    for place in np.ndindex(reading.x.shape):
        point: dict[str, Any] = {"x": float(reading.x[place])}
        if at:
            point["t"] = float(reading.t[place])
        point["arrivals"] = {
            name: _measured(measured, place) for name, measured in reading.arrivals.items()
        }
        for name in FIELDS if at else ():
            point[name] = _measured(getattr(reading, name), place)
        points.append(point)
    return points


def _measured(measured: Measured, place: tuple[int, ...]) -> dict[str, float]:
    value, error = (float(part[place]) for part in measured)
    return {"value": value, "error": error}


def _by_mode(scene: Scene, values: Sequence[ArrayLike]) -> dict[str, float]:
    """Stress intensities by name; that of shear is named after its mode."""
    names = ("K_I", f"K_{scene.shear_mode}")
    return {name: float(np.asarray(value)) for name, value in zip(names, values, strict=True)}


def march_document(marched: Marched) -> dict[str, Any]:
    """A march as plain dictionaries, lists, strings and finite numbers, for JSON."""
    scene, seen, known = marched.scene, marched.seen, marched.interface
    place, on, steps = np.abs(known.x), known.touching, np.diff(marched.totals.t)
    largest = float(seen.slip_rate.max())
    threshold = SENSE_THRESHOLD * largest
    document = {
        "scene": scene_document(scene),
        "method": marched.method,
        "status": marched.status,
        "caution": marched.caution,
        "error_estimate": marched.error_estimate,
        "error_estimates": dict(marched.error_estimates),
        "end_time": marched.end_time,
        "nodes": marched.nodes,
        "steps": marched.steps,
        "shortest_step": float(steps.min()),
        "longest_step": float(steps.max()),
        "stored_levels": len(known.t),
        "largest_slip_rate": largest,
        "largest_slip": float(marched.totals.max_slip.max()),
        "largest_gap": float(known.gap[:, on].max()),
        "slipping": float(np.mean(np.abs(known.slip_rate[-1][on]) > 0)),
        "reach_of_slip": float(place[seen.slip_rate > threshold].max(initial=0.0)),
        "reach_of_reverse_slip": float(place[-seen.reverse > threshold].max(initial=0.0)),
        "accumulated_slip": float(marched.accumulated_slip(marched.end_time)),
        "frictional_work": float(marched.frictional_work(marched.end_time)),
    }
    if not scene.on_line:
        document |= _beside_slot(marched)
    document["units"] = units_document(document, MARCH_DIMENSIONS, scene)
    return document


def _beside_slot(marched: Marched) -> dict[str, Any]:
    """Return what a march next to a slot says next tos: onsets, a stuck edge, and its cost."""
    scene, onset, x = marched.scene, marched.seen.onset, marched.interface.x
    known: Any = marched.checkpoint
    length, load = scene.material.shear_speed * marched.end_time, scene.superposition.taken_off
    histories = scene.pressure_history, scene.shear_history
    modes: tuple[Mode, Mode] = ("I", scene.shear_mode)
    intensities = [
        intensity_history(history, load, scene.material, marched.end_time, scene.shear_mode)[number]
        * (
            math.nan
            if scene.front_too_slow
            else front_share(scene.material, scene.front_slowness, of)
        )
        for number, (history, of) in enumerate(zip(histories, modes, strict=True))
    ]
    nodes = [nearest(x, probe * length) for probe in PROBES]
    times = (float(time) if math.isfinite(time) else None for time in onset[nodes])
    return {
        "onset": [
            {"x": float(x[node]), "time": time} for node, time in zip(nodes, times, strict=True)
        ],
        # a load that comes along the slot slower than its waves has one that depends on its start
        "stress_intensity_of_a_stuck_edge": {
            name: value for name, value in _by_mode(scene, intensities).items() if value == value
        },
        "statistics": {
            "nodes": known.grid.size,
            "steps": known.count,
            "poles": len(known.layout.kernel.poles),
            "memory_error": known.layout.kernel.error,
            "seconds": known.seconds,
        },
    }


def edge_state(solution: Solution | PairSolution) -> str:
    """ "open", "slipping" or "stuck": what the interface does at the edge of the slot, x = 0+."""
    if solution.openings and solution.openings[0].inner == 0:
        return "open"
    return "slipping" if solution.zones and solution.zones[0].inner == 0 else "stuck"


def envelope(
    command: str, document: Mapping[str, Any], status: str = "done", files: Iterable[Path] = ()
) -> dict[str, Any]:
    """Return the JSON document of a command: its own keys and those that all commands have.

    The keys of the document go in unchanged; its "status" and "units" replace the common ones.  The
    status is how the command ended: "done", or the verdict; files are those that were written.
    """
    return {
        "command": command,
        "version": version("slipfront"),
        "status": status,
        **document,
        "units": document.get("units", {}),
        "files": [str(path) for path in files],
    }


def json_text(document: Mapping[str, Any]) -> str:
    """JSON of a document, NumPy numbers included; null replaces numbers that are not finite."""
    return json.dumps(_finite(document), indent=2, allow_nan=False) + "\n"


def _finite(part: Any) -> Any:
    """Part of a document with None in place of infinities and NaN."""
    if isinstance(part, Mapping):
        return {key: _finite(value) for key, value in part.items()}
    if isinstance(part, (list, tuple)):
        return [_finite(value) for value in part]
    if isinstance(part, (str, int, NoneType)):
        return part
    return float(part) if math.isfinite(part) else None
