"""Reference answers of the scenes of the chart, and distances from them.

A scene with a self-similar answer is solved to the last digits; others are extrapolated from two
grids of two methods, whose difference is the uncertainty.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from compare.comparison.measures import relative_error
from compare.studies.chart.methods import METHODS, PLACES, scaled_zones
from compare.studies.chart.tasks import Task, run_task
from semianalytic import Scene, SlipZone, solve
from semianalytic.reference.known_answers import closed_form
from semianalytic.scene.given.named import NAMED_SCENES

Array = NDArray[np.float64]

CLOSED_FORM_FRICTION = {"preloaded": 0.8, "remote-shock": 0.9, "auxetic": 0.8}
"""Friction at which a scene of the chart has one slip zone and a closed form."""
FINEST = 1e-12
"""Tolerance of the self-similar reference."""
REFERENCE_GRIDS = {
    False: {"space-time": (8192, 16384), "fem": (200, 400)},
    True: {"space-time": (1024, 2048), "fem": (50, 100)},
}
"""Coarser and finer grid of each method, for full charts and for quick ones."""


@dataclass(frozen=True, eq=False)
class Reference:
    """Reference answer of a scene, against which the methods are measured.

    Attributes
    ----------
    slip_rate : (400,) array
        Slip rate at `PLACES` [length / time].
    zones : tuple of SlipZone
        Slip zones, edges over c_t.
    error, edge_error : float
        Uncertainty of the reference, measured like the errors of a `Point`.
    """

    name: str
    slip_rate: Array
    zones: tuple[SlipZone, ...]
    error: float
    edge_error: float


def reference_of(scene_name: str, quick: bool) -> Reference:
    """Return the self-similar solution at rtol 1e-12, or one extrapolated by two methods."""
    scene = NAMED_SCENES[scene_name].scene
    if not scene.is_self_similar:
        return _extrapolated(scene_name, quick)
    solution, speed = solve(scene, rtol=FINEST), scene.material.shear_speed
    slip_rate = solution.slip_rate(PLACES * speed, 1.0)
    friction = CLOSED_FORM_FRICTION[scene_name]
    checked = closed_form_errors(replace(scene, friction=friction))
    return Reference(reference_name(scene_name, quick), slip_rate, scaled_zones(solution), *checked)


def reference_name(scene_name: str, quick: bool) -> str:
    """Describe the reference of a scene in words."""
    if not NAMED_SCENES[scene_name].scene.is_self_similar:
        return "extrapolated from " + " and ".join(
            f"{METHODS[method].label} {coarse}, {fine}"
            for method, (coarse, fine) in REFERENCE_GRIDS[quick].items()
        )
    friction = CLOSED_FORM_FRICTION[scene_name]
    return f"self-similar solver, rtol 1e-12; checked by the closed form at friction {friction:g}"


def closed_form_errors(scene: Scene) -> tuple[float, float]:
    """Return the errors of slip rate (relative L1) and edge (over c_t) against closed forms.

    They are those of the solver at rtol 1e-12.  The edge error is nan if all of the contact slips.

    Parameters
    ----------
    scene : Scene
        Scene with one slow slip zone under a shear step, or with a remote shock under which the
        whole contact slips.
    """
    solution, speed = solve(scene, rtol=FINEST), scene.material.shear_speed
    slip_rate = solution.slip_rate(PLACES * speed, 1.0)
    known = closed_form(scene)
    error = relative_error(slip_rate, known.slip_rate(PLACES * speed), PLACES, 1)
    if known.edge_speed is None:
        return error, math.nan
    return error, abs(solution.zones[-1].outer - known.edge_speed) / speed


def _extrapolated(scene_name: str, quick: bool) -> Reference:
    """Extrapolate the space-time solver; its difference from finite elements is the uncertainty."""
    (slip_rate, zones), (other, other_zones) = (
        _limit(*(run_task(Task(scene_name, method, float(size)), 1) for size in sizes))
        for method, sizes in REFERENCE_GRIDS[quick].items()
    )
    apart = relative_error(other, slip_rate, PLACES, 1)
    edge = worst_edge_error(other_zones, zones)
    return Reference(reference_name(scene_name, quick), slip_rate, zones, apart, edge)


def _limit(coarse: dict[str, Any], fine: dict[str, Any]) -> tuple[Array, tuple[SlipZone, ...]]:
    """Extrapolate slip rate and zones from the results of `run_task` on two grids.

    Errors at fixed positions are assumed to be of second order, those of edges of first.  If the
    grids differ in their zones, those of the finer grid are returned.
    """
    slip_rate = richardson(np.array(coarse["slip_rate"]), np.array(fine["slip_rate"]), 2)
    if [zone[2] for zone in coarse["zones"]] != [zone[2] for zone in fine["zones"]]:
        return slip_rate, tuple(SlipZone(*zone) for zone in fine["zones"])
    edges = richardson(np.array(coarse["zones"]), np.array(fine["zones"]), 1)
    return slip_rate, tuple(
        SlipZone(float(inner), float(outer), int(sense)) for inner, outer, sense in edges
    )


def richardson(coarse: Any, fine: Any, order: int) -> Any:
    """Extrapolate answers on grids of spacing 2 h and h, whose errors have an order in h."""
    return fine + (fine - coarse) / (2**order - 1)


def worst_edge_error(zones: Sequence[SlipZone], expected: Sequence[SlipZone]) -> float:
    """Return the largest error of a zone edge; inf if a zone is missed.

    Each expected zone is compared with the zone of its sense that overlaps it most.
    """
    worst = 0.0
    for zone in expected:
        overlaps = [
            (min(zone.outer, one.outer) - max(zone.inner, one.inner), one)
            for one in zones
            if one.sense == zone.sense
        ]
        shared, closest = max(overlaps, key=lambda pair: pair[0], default=(0.0, zone))
        if shared <= 0:
            return math.inf
        for edge in ("inner", "outer"):
            here, there = getattr(closest, edge), getattr(zone, edge)
            if here != there:
                worst = max(worst, abs(here - there))
    return worst
