"""Exact answers for two different bodies: against finite elements, and against what they state."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from compare.comparison.bars import LARGEST_ORDER, LEAST_ORDER, error_bar
from compare.comparison.fields.changes import PARTS
from compare.comparison.fields.errors import FieldErrors, field_errors
from docs.studies.dissimilar.pairs import SCENES, random_pair
from docs.studies.runner import Row
from fem import Simulation, simulate, with_companions
from semianalytic import Pair, PairSolution, SceneError, solve
from semianalytic.halfplane.rayleigh import Array

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


def fields_rows(name: str, resolution: int) -> list[Row]:
    """Compare the last frame of a scene with exact fields, a row for each component.

    The relative L1 differences are everywhere and away from fronts, with error bars of the finite
    elements; the last is that away from fronts of an answer whose lower body is 3 % stiffer.
    """
    pair = SCENES[name]
    lower = replace(pair.lower, shear_modulus=WRONG * pair.lower.shear_modulus)
    with TemporaryDirectory() as place:
        folder, time = Path(place), 1 / pair.upper.shear_speed
        options: Row = {"snapshots": folder, "resolution": resolution, "frames": 1}
        run = simulate(pair.alike, time, lower_material=pair.lower, **options)
        run = with_companions(run, snapshots=folder)
        errors, wrong = (
            _field_errors(one, run, folder) for one in (pair, replace(pair, lower=lower))
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


def _field_errors(pair: Pair, run: Simulation, folder: Path) -> FieldErrors:
    errors = field_errors(solve(pair), run, folder)
    assert errors is not None  # a solved pair has fields in its bodies
    return errors


def error_of(answer: PairSolution, exact: PairSolution) -> float | None:
    """Largest error of an answer as its estimate counts them; None if its zones are others."""
    pair = answer.pair
    slow = min(pair.upper.shear_speed, pair.lower.shear_speed)
    fast = max(pair.upper.longitudinal_speed, pair.lower.longitudinal_speed)
    ends = [_ends(one) for one in (answer, exact)]
    if ends[0].shape != ends[1].shape:
        return None
    moves = ends[1] > 0
    shifts = np.abs(ends[0] - ends[1])[moves] / np.minimum(ends[1][moves], slow)
    x = np.linspace(BESIDE * slow, fast)
    x = x[np.abs(x[:, None] - np.append(ends[1], np.inf)).min(axis=1) > BESIDE * slow]
    found = [float(shifts.max(initial=0.0))]
    for name in ("slip_rate", "gap_rate", "slip", "gap"):
        one, other = (getattr(each, name)(x, 1.0) for each in (answer, exact))
        found.append(float(np.abs(one - other).max() / (np.abs(other).max() or 1.0)))
    carried = pair.base.pressure + abs(pair.load.pressure) + abs(pair.load.shear)
    for name in ("pressure", "shear_traction"):
        one, other = (getattr(each, name)(x, 1.0) for each in (answer, exact))
        found.append(float((np.abs(one - other) / (np.abs(other) + carried)).max()))
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
        exact = solve(pair, rtol=EXACT)
    except SceneError:
        return [{"rtol": rtol, "status": ""} for rtol in TOLERANCES]
    for rtol in TOLERANCES:
        answer = solve(pair, rtol=rtol)
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
        row["unconverged"] = sum(one["status"] != "converged" for one in solved)
        row |= {"other_zones": len(solved) - len(ratios), "compared": len(ratios)}
        row["below"] = sum(ratio <= 1 for ratio in ratios)
        row["worst_ratio"] = max(ratios, default=np.nan)
        row["median_ratio"] = float(np.median(ratios)) if ratios else np.nan
        table.append(row | {"worst_error": max(errors, default=np.nan)})
    return table
