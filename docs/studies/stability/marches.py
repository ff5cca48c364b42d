"""Failures of the two marches, finite elements and space-time: where, and what the program does."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from compare.comparison.measures import relative_error
from docs.studies.accuracy.fem import PROFILE, profile
from docs.studies.accuracy.march import last_march, step_error
from docs.studies.runner import Point, Row
from fem import Simulation, simulate
from semianalytic import Material, Scene, Tractions, solve
from semianalytic.scene.errors import ComputationError, SlipfrontError
from semianalytic.scene.given.named import NAMED_SCENES

_SOLID = NAMED_SCENES["preloaded"].scene.material
SCENES: Mapping[str, Scene] = {
    "preloaded": NAMED_SCENES["preloaded"].scene,
    "remote-shock": NAMED_SCENES["remote-shock"].scene,
    "unloaded": Scene(_SOLID, 0.5, Tractions(1.0, 0.0), Tractions(-1.0, 0.5)),
    "reclosing": Scene(_SOLID, 0.5, Tractions(0.02, 0.0), Tractions(1.0, 0.5)),
}

MESHES = ("squares", "triangles")
STEP_RATIOS = (0.5, 0.7, 0.9, 0.95, 1.0, 1.01, 1.02, 1.05)
DAMPINGS = (0.0, 0.02, 0.1, 0.2)
POISSON_RATIOS = (0.3, 0.4, 0.45, 0.49, 0.499)

RAN = "ran"
MARCHED_RATIOS = (0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.65, 0.7, 0.75, 0.8)
MARCHED_POISSON_RATIOS = (-0.99, -0.9, -0.7, -0.5, -0.2, 0.0, 0.2, 0.4, 0.45, 0.49, 0.499, 0.4999)
FRICTIONS = {
    "preloaded": (0.02, 0.05, 0.1, 0.2, 0.3, 0.45, 0.6, 1.0, 2.0, 5.0),
    "remote-shock": (0.3, 0.8, 0.99, 1.01, 1.1, 1.2, 1.25, 1.3, 1.38, 1.41),
}
END_TIMES = (1.0, 2.0, 4.0, 8.0, 16.0)


def fem_points(quick: bool) -> list[Point]:
    """Return study, scene, Poisson ratio and options of all simulations."""
    resolution, nu = (40 if quick else 100), _SOLID.poisson_ratio
    points: list[Point] = []

    def add(study: str, scene: str = "preloaded", ratio: float = nu, **options: Any) -> None:
        given: Row = {"step_ratio": 0.95, "damping": 0.02, "resolution": resolution}
        points.append((study, scene, ratio, given | {"mesh": "squares"} | options))

    for mesh in MESHES[:1] if quick else MESHES:
        for damping in DAMPINGS[1:2] if quick else DAMPINGS:
            for ratio in STEP_RATIOS[3:] if quick else STEP_RATIOS:
                add("step", mesh=mesh, damping=damping, step_ratio=ratio)
    for mesh in MESHES[:1] if quick else MESHES:
        for ratio in POISSON_RATIOS[:2] if quick else POISSON_RATIOS:
            add("locking", ratio=ratio, resolution=20 if quick else 40, mesh=mesh)
    for scene in ("unloaded", "reclosing"):
        for damping in DAMPINGS[:2]:
            for mesh in MESHES[:1] if quick else MESHES:
                add("chatter", scene, damping=damping, mesh=mesh)
    return points


def fem_row(study: str, scene_name: str, poisson_ratio: float, options: Mapping[str, Any]) -> Row:
    """Simulate a scene; return how far it came, its errors, and the sentence that stopped it.

    The step ratio is the requested one, `error` the relative L1 error of the final slip rate,
    `switches` how often a node opened or closed at most, `energy_gained` what friction or closing
    gaps returned in a step, over the work.
    """
    scene = SCENES[scene_name]
    scene = replace(scene, material=replace(scene.material, poisson_ratio=poisson_ratio))
    reached, run, message = [0, 0], None, ""

    def note(step: int, steps: int) -> None:
        reached[:] = step, steps

    try:
        run = simulate(scene, **options, progress=note)
    except ComputationError as error:
        message = str(error)
    gained = math.nan
    if run:
        taken = np.array([run.energy.friction, run.energy.impact])
        least = float(np.diff(taken, prepend=0.0).min())
        gained = max(0.0, -least) / float(np.abs(run.energy.external).max())
    return {
        "study": study,
        "scene": scene_name,
        "poisson_ratio": poisson_ratio,
        **options,
        "outcome": "completed" if run else "stopped",
        "step": reached[0],
        "steps": reached[1],
        "error": _error(run) if run else math.nan,
        "energy_residual": run.energy.residual if run else math.nan,
        "switches": int(np.diff(run.is_open, axis=0).sum(0).max()) if run else 0,
        "energy_gained": gained,
        "message": message,
    }


def _error(run: Simulation) -> float:
    """Return the relative L1 error of the final profile; nan if there is no exact solution."""
    try:
        exact = solve(run.scene).slip_rate(PROFILE * run.scene.material.shear_speed, 1.0)
        return relative_error(profile(run), exact, PROFILE, 1)
    except SlipfrontError:
        return math.nan


def march_points(quick: bool) -> list[Point]:
    """Return study, case, value of the varied parameter, scene and number of nodes of all marches.

    If `quick`, they are on coarse grids and over shorter times.
    """
    nodes, times = (128, END_TIMES[:3]) if quick else (512, END_TIMES)
    varied = (("step ratio", MARCHED_RATIOS), ("Poisson ratio", MARCHED_POISSON_RATIOS))
    points: list[Point] = [
        (study, f"damping {damping:g}", value, "preloaded", nodes, damping)
        for study, values in varied
        for damping in (0.0, 0.7)
        for value in values
    ]
    points += [
        ("friction", name, chi, name, nodes, 0.7)
        for name, values in FRICTIONS.items()
        for chi in values
    ]
    return points + [
        ("end time", "preloaded", end, "preloaded", int(nodes * end / 4), 0.7) for end in times
    ]


def march_row(
    study: str, case: str, value: float, scene_name: str, nodes: int, damping: float
) -> Row:
    """March a scene; the status of a march that is refused is the sentence of the refusal."""
    scene, ratio = SCENES[scene_name], value if study == "step ratio" else 0.5
    if study == "Poisson ratio":
        scene = replace(scene, material=Material(1.0, 1.0, value))
    elif study == "friction":
        scene = replace(scene, friction=value)
    try:
        if study == "end time":
            run = solve(scene, method="space-time", end_time=value, nodes=nodes, every=10**9)
        else:
            run = last_march(scene, nodes, step_ratio=ratio, damping=damping)
        error, status = step_error(scene, run), RAN
    except SlipfrontError as refusal:
        error, status = math.nan, str(refusal)
    return {"study": study, "case": case, "parameter": value, "error": error, "status": status}
