"""Exact answers for two different bodies: against finite elements, and against what they state."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from compare.comparison.bars import LARGEST_ORDER, LEAST_ORDER, error_bar
from compare.comparison.fields.changes import PARTS
from compare.comparison.fields.errors import FieldErrors, field_errors
from compare.comparison.judgement import judge
from compare.comparison.rows import AGREES, DIFFERS, UNRESOLVED
from docs.studies.dissimilar.pairs import SCENES, random_pair
from docs.studies.runner import Point, Row
from fem import Simulation, simulate, with_companions
from semianalytic import Pair, PairSolution, SceneError, find, solve
from semianalytic.halfplane.rayleigh import Array
from semianalytic.scene.given.named import NAMED_PAIRS

RESOLUTION, FIELDS_RESOLUTION = 100, 64
"""Elements over the way of a shear wave of the upper body, of verdicts, as `slipfront compare`
takes by default, and of fields; companions have half and a quarter."""
DRAWN, SEED = 20, 31
"""Random pairs that are judged, and the first number of their seeds."""
OFF, STIFFER, WRONG = 1.03, 1.1, 1.03
"""Wrong answers over right ones: friction and lower shear modulus of verdicts; that of fields."""
REFUSED = "refused"
EXACT, TOLERANCES = 1e-10, (1e-4, 1e-6, 1e-8)
"""The rtol of the answers that count as exact, and of those that are compared with them."""
BESIDE = 0.03
"""Distance from zone edges, over the slowest wave speed, from which `error_estimate` speaks."""
STATED, STATED_SEED = 346, 2
"""Random pairs that are drawn for the errors of estimates, and the first number of their seeds."""


def judged_points(quick: bool) -> list[Point]:
    """Return the named pairs, and the scenes that between them have all kinds of zones."""
    return [(name, 24 if quick else RESOLUTION) for name in (*NAMED_PAIRS, *SCENES)]


def drawn_points(quick: bool) -> list[Point]:
    """Return the first random pairs that friction does not leave without an answer."""
    points: list[Point] = []
    number = 0
    while len(points) < (2 if quick else DRAWN):
        if verdict_on(drawn_pair(number), None) != REFUSED:
            points.append((f"random {number}", 24 if quick else RESOLUTION))
        number += 1
    return points


def drawn_pair(number: int) -> Pair:
    """Return the random pair of a number."""
    return random_pair(np.random.default_rng([SEED, number]))


def wrong_ones(pair: Pair) -> Mapping[str, Pair]:
    """Return pairs whose answers are wrong for a pair, by the name of what is wrong."""
    lower = replace(pair.lower, shear_modulus=STIFFER * pair.lower.shear_modulus)
    return {
        "friction": replace(pair, friction=OFF * pair.friction),
        "exchanged": replace(pair, upper=pair.lower, lower=pair.upper),
        "stiffer": replace(pair, lower=lower),
    }


def verdict_on(pair: Pair, run: Simulation | None) -> str:
    """Return the verdict on the answer for a pair, or whether it is refused; "" without a run."""
    try:
        answer = solve(pair)
    except SceneError:
        return REFUSED
    return "" if run is None else judge(answer, run).verdict


def judged_row(name: str, resolution: int) -> Row:
    """Simulate a pair until a shear wave of the upper body has come a length of 1, and judge.

    The row has the numbers of rows that agree, differ and are unresolved, the largest difference of
    what agrees in error bars and where it is, and the verdicts on wrong answers.
    """
    if name.startswith("random"):
        pair = drawn_pair(int(name.split()[1]))
    else:
        pair = SCENES[name] if name in SCENES else find(name)
    time = 1 / pair.upper.shear_speed
    run = simulate(pair.alike, time, resolution=resolution, lower_material=pair.lower)
    run = with_companions(run)
    judgement = judge(solve(pair), run)
    over_bar, what = max((row.over_bar, row.name) for row in judgement.having(AGREES))
    return {
        "scene": name,
        "verdict": judgement.verdict,
        "agree": judgement.counts[AGREES],
        "differ": judgement.counts[DIFFERS],
        "unresolved": judgement.counts[UNRESOLVED],
        "over_bar": over_bar,
        "what": what,
        **{which: verdict_on(other, run) for which, other in wrong_ones(pair).items()},
    }


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
