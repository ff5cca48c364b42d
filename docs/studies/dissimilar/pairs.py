"""Pairs of solids, named and drawn, scenes of a slot between them, and errors of their answers:
against finite elements, and against what they state."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

import semianalytic as sf
from compare.comparison.bars import LARGEST_ORDER, LEAST_ORDER, error_bar
from compare.comparison.fields.changes import PARTS
from compare.comparison.fields.errors import FieldErrors, field_errors
from docs.studies.runner import Row
from fem import Simulation, simulate, with_companions
from semianalytic import Coulomb, Material, Scene, Tractions
from semianalytic.dissimilar_slot.solution import PairSolution
from semianalytic.scene.arrays import Array

FIELDS_RESOLUTION = 64
"""Elements over the way of a shear wave of the upper body; companions have half and a quarter."""
WRONG = 1.03
"""Lower shear modulus of a wrong answer over the right one."""
EXACT, TOLERANCES = 1e-10, (1e-4, 1e-6, 1e-8)
"""The rtol of the answers that count as exact, and of those that are compared with them."""
BESIDE = 0.03
"""Distance from zone edges, over the slowest wave speed, from which `error_estimate` speaks."""
STATED, STATED_SEED = 346, 2
"""Random pairs that are drawn for the errors of estimates, and the first number of their seeds."""

NAMED: Mapping[str, tuple[Material, Material]] = {
    "gouge on rock": (Material(12e9, 2300.0, 0.25), Material(30e9, 2700.0, 0.25)),
    "aluminium on steel": (
        Material(70e9 / 2.66, 2700.0, 0.33),
        Material(210e9 / 2.6, 7800.0, 0.30),
    ),
    "PMMA on aluminium": (Material(3.2e9 / 2.7, 1180.0, 0.35), Material(70e9 / 2.66, 2700.0, 0.33)),
    "brake pad on cast iron": (Material(1.2e9, 2500.0, 0.25), Material(45e9, 7200.0, 0.26)),
    "rubber on steel": (Material(0.01e9 / 2.98, 1100.0, 0.49), Material(210e9 / 2.6, 7800.0, 0.30)),
}
"""Upper and lower body [Pa, kg/m^3]; the slower one is the upper."""


def of_contrast(ratio: float, poisson_ratio: float = 0.25) -> tuple[Material, Material]:
    """Two bodies of one density and Poisson ratio, the lower one faster by a ratio."""
    return Material(1.0, 1.0, poisson_ratio), Material(ratio**2, 1.0, poisson_ratio)


def random_pair(rng: np.random.Generator) -> Scene:
    """Two solids with speeds within a factor of 2.5 and a load that makes them slip or part."""
    upper, lower = rng.uniform(-0.1, 0.45, 2)
    ratio, density = np.exp(rng.uniform(-0.9, 0.9)), np.exp(rng.uniform(-0.7, 0.7))
    friction = rng.uniform(0.05, 0.6)
    base = rng.uniform(-0.8, 0.8) * friction * (rng.random() < 0.4)
    kind, shear = rng.integers(0, 5), rng.normal() * rng.choice([0.3, 1.0])
    pressures = [0.0, rng.uniform(0, 1.5), -rng.uniform(0, 1.5), rng.normal(), 0.0]
    film = rng.random() < 0.15
    law = Coulomb(friction, viscosity=rng.uniform(0, 2) if film else 0.0)
    return Scene(
        Material(1.0, 1.0, upper),
        law,
        Tractions(1.0, base),
        Tractions(pressures[kind], shear),
        lower_material=Material(ratio**2 * density, density, lower),
    )


_SLOW, _STIFF = Material(1.0, 1.0, 0.25), Material(2.25, 1.0, 0.30)
_A = (Material(1.0, 1.0, 0.3), Material(1.7, 1.1, 0.2))
_C = (Material(1.0, 1.0, 0.25), Material(1.21, 1.0, 0.25))


def _scene(
    bodies: tuple[Material, Material],
    friction: float,
    base: float,
    load: tuple[float, float],
    film: float = 0.0,
) -> Scene:
    law = Coulomb(friction, viscosity=film)
    upper, lower = bodies
    before, after = Tractions(base, 0.0), Tractions(*load)
    return Scene(upper, law, before, after, lower_material=lower)


SCENES: Mapping[str, Scene] = {
    "slip from the slot": _scene(_C, 0.2, 4.0, (0.5, -1.0)),
    "two zones": _scene(_C, 0.2, 1.1, (0.0, -1.0)),
    "slip and opening": _scene((_SLOW, _STIFF), 0.3, 1.5, (-1.0, 0.5)),
    "slip and opening, reversed": _scene((_SLOW, _STIFF), 0.3, 1.5, (-1.0, -0.5)),
    "film": _scene((_SLOW, _STIFF), 0.2, 1.0, (0.2, 1.0), 0.3),
    "detached slip": _scene((_SLOW, _STIFF), 0.4, 0.7, (5.5, -1.0)),
    "both senses": _scene((_SLOW, _STIFF), 0.3, 0.05, (1.0, 0.0)),
    "detached opening": _scene(_A, 0.1, 0.05, (1.0, -0.5)),
}
"""Scenes of a slot that between them have all kinds of zones."""


def fields_rows(name: str, resolution: int) -> list[Row]:
    """Compare the last frame of a scene with exact fields, a row for each component.

    The relative L1 differences are everywhere and away from fronts, with error bars of the finite
    elements; the last is that away from fronts of an answer whose lower body is 3 % stiffer.
    """
    scene = SCENES[name]
    lower = scene.bodies[1]
    lower = replace(lower, shear_modulus=WRONG * lower.shear_modulus)
    with TemporaryDirectory() as place:
        folder, time = Path(place), 1 / scene.material.shear_speed
        options: Row = {"snapshots": folder, "resolution": resolution, "frames": 1}
        run = simulate(scene, time, **options)
        run = with_companions(run, snapshots=folder)
        errors, wrong = (
            _field_errors(job, run, folder) for job in (scene, replace(scene, lower_material=lower))
        )
    found = {(change.component, change.part): change for change in errors.changes}
    off = {(change.component, change.part): change for change in wrong.changes}
    rows: list[Row] = []
    for component in errors.last:
        whole, away = (found[component, part] for part in PARTS)
        row: Row = {"scene": name, "component": component, "whole": whole.difference}
        row["whole_bar"] = error_bar(whole.changes, most=LEAST_ORDER).size
        row |= {"away": away.difference}
        row["away_bar"] = error_bar(away.changes, most=LARGEST_ORDER).size
        rows.append(row | {"spoilt": off[component, PARTS[1]].difference})
    return rows


def _field_errors(scene: Scene, run: Simulation, folder: Path) -> FieldErrors:
    errors = field_errors(sf.solve(scene), run, folder)
    assert errors is not None  # a solved pair has fields in its bodies
    return errors


def error_of(answer: PairSolution, exact: PairSolution) -> float | None:
    """Largest error of an answer as its estimate counts them; None if its zones are others."""
    scene, load = answer.scene, answer.scene.superposition.taken_off
    slow = min(body.shear_speed for body in scene.bodies)
    fast = scene.fastest_speed
    ends = [_ends(result) for result in (answer, exact)]
    if ends[0].shape != ends[1].shape:
        return None
    moves = ends[1] > 0
    shifts = np.abs(ends[0] - ends[1])[moves] / np.minimum(ends[1][moves], slow)
    x = np.linspace(BESIDE * slow, fast)
    x = x[np.abs(x[:, None] - np.append(ends[1], np.inf)).min(axis=1) > BESIDE * slow]
    found = [float(shifts.max(initial=0.0))]
    for name in ("slip_rate", "gap_rate", "slip", "gap"):
        values, other = (getattr(each, name)(x, 1.0) for each in (answer, exact))
        found.append(float(np.abs(values - other).max() / (np.abs(other).max() or 1.0)))
    carried = scene.base.pressure + abs(load.pressure) + abs(load.shear)
    for name in ("pressure", "shear_traction"):
        values, other = (getattr(each, name)(x, 1.0) for each in (answer, exact))
        found.append(float((np.abs(values - other) / (np.abs(other) + carried)).max()))
    return max(found)


def _ends(answer: PairSolution) -> Array:
    slips = [end for zone in answer.zones for end in (zone.inner, zone.outer)]
    return np.array(slips + [end for part in answer.openings for end in (part.inner, part.outer)])


def stated_rows(number: int) -> list[Row]:
    """Solve a random pair to each rtol; return errors against the same method at rtol 1e-10.

    The error is nan where the zones are others or nothing is stated; a refused pair has no status.
    """
    pair = random_pair(np.random.default_rng([STATED_SEED, number]))
    rows: list[Row] = []
    try:
        exact = sf.solve(pair, rtol=EXACT)
    except sf.SceneError:
        return [{"rtol": rtol, "status": ""} for rtol in TOLERANCES]
    for rtol in TOLERANCES:
        answer = sf.solve(pair, rtol=rtol)
        error, stated = error_of(answer, exact), float(answer.error_estimate)
        known = error is not None and np.isfinite(stated)
        rows.append({"rtol": rtol, "status": answer.status, "error": error if known else np.nan})
        rows[-1]["ratio"] = error / stated if error is not None and known else np.nan
    return rows


def honesty(rows: list[Row]) -> list[Row]:
    """Return how many answers at each rtol have errors below their estimates, and the worst."""
    table: list[Row] = []
    for rtol in TOLERANCES:
        own = [row for row in rows if row["rtol"] == rtol]
        solved = [row for row in own if row["status"]]
        ratios = [row["ratio"] for row in solved if row["ratio"] == row["ratio"]]
        errors = [row["error"] for row in solved if row["ratio"] == row["ratio"]]
        row: Row = {"rtol": rtol, "drawn": len(own), "refused": len(own) - len(solved)}
        row |= {"solved": len(solved)}
        row["unconverged"] = sum(answer["status"] != "converged" for answer in solved)
        row |= {"other_zones": len(solved) - len(ratios), "compared": len(ratios)}
        row["below"] = sum(ratio <= 1 for ratio in ratios)
        row["worst_ratio"] = max(ratios, default=np.nan)
        row["median_ratio"] = float(np.median(ratios)) if ratios else np.nan
        table.append(row | {"worst_error": max(errors, default=np.nan)})
    return table
