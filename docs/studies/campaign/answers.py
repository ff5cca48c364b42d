"""Random scenes of every law, mode and opening: all that an answer says against a better answer.

Run as ``python -m docs.studies.campaign.answers --csv docs/data``.  Bases are 1e-6 to 1e6 times
the step.  Each scene is solved to 1e-5, 1e-6 or 1e-8, and edges, slip rate, slip, tractions, gap,
power, stress intensities, fields in the bodies and derivatives are held against an answer to 1e-12
(1e-9 where strength depends on slip rate);
derivatives also against what doubling all tractions does.  An error is counted over the sum of
what both answers say that it may be.  Scenes are shared among ``--processes``, and an interrupted
run goes on where it was.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from compare.output.progress import progress_bar
from compare.output.tables import append_rows, started_rows, write_rows
from compare.studies.tables import shown_rows
from compare.tasks.workers import run_tasks
from docs.studies.campaign.study import SummaryRow, error_between
from docs.studies.trials.draws import drawn, random_wide_scene
from semianalytic import RateWeakening, Scene, SceneError, Solution, TensionError, solve

Array = NDArray[np.float64]

SCENES, SEED = 5000, 3
FINE = {"CoulombFriction": 1e-12, "ViscousFriction": 1e-9, "RateWeakening": 1e-9}
"""Accuracies of better answers: films that open take minutes to 1e-12, and friction that falls with
slip rate does not come further."""
ROUGH = (1e-5, 1e-6, 1e-8)
_TRACTIONS = ("base_pressure", "base_shear", "load_pressure", "load_shear")
_CLEAR = 0.03
"""Distance from edges and from c_R, over c_t, beyond which errors hold at points."""
_POINTS, _BODY_POINTS = 60, 8
_MOST_NODES = 3000
"""Nodes of an answer up to which its derivatives are asked for: those of more take minutes."""
_ROUNDING = 4e-16
"""Rounding of tractions over the base that is part of them."""


@dataclass(frozen=True)
class AnswerRow:
    """A scene and the errors of its answer over what it says that they may be.

    Attributes
    ----------
    index : int, which seeds its draw
    law, mode : str
    opens : bool
    ratio : base pressure over the step
    rtol : float
    outcome : "converged", "refused", "unresolved" (either answer says so) or what was raised
    seconds : processor time of all of it [s]
    edges ... derivatives : errors over estimates, nan where not asked or where there is no answer
    """

    index: int
    law: str
    mode: str
    opens: bool
    ratio: float
    rtol: float
    outcome: str
    seconds: float = 0.0
    edges: float = math.nan
    slip_rate: float = math.nan
    slip: float = math.nan
    traction: float = math.nan
    pressure: float = math.nan
    gap: float = math.nan
    power: float = math.nan
    intensity: float = math.nan
    velocity: float = math.nan
    stress: float = math.nan
    displacement: float = math.nan
    derivatives: float = math.nan
    homogeneity: float = math.nan


QUANTITIES = tuple(AnswerRow.__dataclass_fields__)[8:]


def answer_row(seed: int, index: int) -> AnswerRow:
    """Solve a scene twice and hold all that the rougher answer says against the better one."""
    scene, random = drawn(seed, index, random_wide_scene)
    rtol, began = float(random.choice(ROUGH)), process_time()
    load = _largest_load(scene)
    row = AnswerRow(
        index=index,
        law=type(scene.friction_law).__name__,
        mode=scene.mode,
        opens=False,
        ratio=scene.superposition.in_place.pressure / load,
        rtol=rtol,
        outcome="refused",
    )
    try:
        rough = solve(scene, rtol=rtol)
        row = replace(row, opens=bool(rough.openings), outcome="unresolved")
        # a better answer than one that has said that it is none takes minutes, in vain
        fine = solve(scene, rtol=FINE[row.law]) if rough.status == "converged" else None
        if fine is not None and fine.error_estimate <= rtol:
            row = replace(row, outcome="converged")
            found: dict[str, Any] = dict(errors(rough, fine, random, index))
            row = replace(row, **found)
    except (SceneError, TensionError):
        pass
    except Exception as error:  # what a campaign is for
        row = replace(row, outcome=f"raised {type(error).__name__}")
    return replace(row, seconds=process_time() - began)


def errors(
    rough: Solution, fine: Solution, random: np.random.Generator, index: int
) -> dict[str, float]:
    """Errors over estimates by quantity; fields in the bodies of one scene in three, derivatives of
    another."""
    found = {"edges": error_between(rough, fine) / _bound(rough, fine)}
    found |= _on_the_interface(rough, fine, random)
    found |= _totals(rough, fine)
    if index % 3 == 0:
        found |= _in_the_bodies(rough, fine, random)
    rated = isinstance(rough.scene.friction_law, RateWeakening)
    if index % 3 == 1 and not rated and fine.statistics.nodes <= _MOST_NODES:
        with suppress(SceneError):  # there is none, as in its own words
            found |= _derivatives(rough, fine, random)
    return found


def _bound(rough: Solution, fine: Solution) -> float:
    return rough.error_estimate + fine.error_estimate


def _largest_load(scene: Scene) -> float:
    load = scene.superposition.taken_off
    return max(abs(load.shear), abs(load.pressure))


def _clear(solution: Solution, random: np.random.Generator) -> Array:
    """Positions at unit time off edges and c_R, close to the edge too."""
    material = solution.scene.material
    fastest, speed = material.longitudinal_speed, material.shear_speed
    x = np.concatenate(
        [random.uniform(0, 1.1 * fastest, _POINTS), fastest * 10 ** random.uniform(-6, -1, 10)]
    )
    ends = [(one.inner, one.outer) for one in solution.zones]
    ends += [(one.inner, one.outer) for one in solution.openings]
    edges = np.ravel(ends)
    marks = np.array([edge for edge in edges if 0 < edge < math.inf] + [material.rayleigh_speed])
    return x[np.abs(x[:, None] - marks).min(axis=1) > _CLEAR * speed]


def _over(change: Array, scale: Array | float, bound: float) -> float:
    """The largest change over a scale and a bound; 0 where nothing is and nothing changes."""
    change, scale = np.broadcast_arrays(np.abs(change), scale)
    share = np.divide(change, scale, out=np.where(change > 0, np.inf, 0.0), where=scale > 0)
    return float(share.max(initial=0.0)) / bound


def _on_the_interface(
    rough: Solution, fine: Solution, random: np.random.Generator
) -> dict[str, float]:
    bound, scene = _bound(rough, fine), rough.scene
    clear, fastest = _clear(fine, random), scene.material.longitudinal_speed
    anywhere = random.uniform(0, 1.05 * fastest, _POINTS)
    rates = [one.slip_rate(clear, 1.0) for one in (rough, fine)]
    slips = [one.slip(anywhere, 1.0) for one in (rough, fine)]
    shears = [one.shear_traction(clear, 1.0) for one in (rough, fine)]
    pressures = [one.pressure(clear, 1.0) for one in (rough, fine)]
    load, base = _largest_load(scene), scene.superposition.in_place.pressure
    rounding = _ROUNDING * max(base * max(scene.friction, 1.0), load) / bound
    found = {
        # a zone that slips less than the estimate may be missing
        "slip_rate": _over(
            rates[0] - rates[1], max(np.abs(rates[1]).max(initial=0.0), _fastest(fine)), bound
        ),
        "slip": _over(slips[0] - slips[1], fine.max_slip(1.0), bound),
        # close to a stuck contact edge a large change may take off a large base
        "traction": _over(
            shears[0] - shears[1],
            np.abs(shears[1]) + np.abs(shears[1] - scene.base.shear) + load + rounding,
            bound,
        ),
        "pressure": _over(
            pressures[0] - pressures[1], base + abs(scene.superposition.taken_off.pressure), bound
        ),
    }
    if fine.openings:
        ends = max(zone.outer for zone in fine.openings)
        x = ends * (np.arange(_POINTS) + 0.5) / _POINTS
        gaps = [one.gap(x, 1.0) for one in (rough, fine)]
        found["gap"] = _over(np.abs(gaps[0] - gaps[1]).mean(), float(gaps[1].max()), bound)
    return found


def _fastest(solution: Solution) -> float:
    """About the largest slip rate of all zones at unit time."""
    rates = [0.0]
    for zone in solution.zones:
        outer = min(zone.outer, solution.scene.material.longitudinal_speed)
        x = zone.inner + (outer - zone.inner) * (np.arange(20) + 0.5) / 20
        rates.append(float(np.abs(solution.slip_rate(x, 1.0)).max()))
    return max(rates)


def _totals(rough: Solution, fine: Solution) -> dict[str, float]:
    bound = _bound(rough, fine)
    powers = [float(one.frictional_power(1.0)) for one in (rough, fine)]
    found = {"power": _over(np.array(powers[0] - powers[1]), abs(powers[1]), bound)}
    pairs = zip(rough.stress_intensity(1.0), fine.stress_intensity(1.0), strict=True)
    found["intensity"] = max(_over(np.asarray(a - b), np.abs(b), bound) for a, b in pairs)
    return found


def _in_the_bodies(
    rough: Solution, fine: Solution, random: np.random.Generator
) -> dict[str, float]:
    """Compare the fields at points of both bodies away from the fronts of waves from the edge."""
    scene = rough.scene
    material, load = scene.material, _largest_load(scene)
    fastest, speed = material.longitudinal_speed, material.shear_speed
    x, y = fastest * random.uniform(-1, 1, (2, _BODY_POINTS))
    off = np.abs(np.hypot(x, y)[:, None] - np.array([fastest, speed])).min(axis=1) > _CLEAR * speed
    x, y = x[off], y[off]
    bound = rough.field_error + fine.field_error
    rate = load / material.shear_impedance
    base = scene.superposition.in_place.pressure + abs(scene.superposition.in_place.shear)
    scales = {
        "velocity": rate,
        "stress": load + _ROUNDING * base / bound,
        "displacement": rate,
    }
    found = {}
    for name, scale in scales.items():
        one, other = (getattr(answer, name)(x, y, 1.0) for answer in (rough, fine))
        found[name] = _over(one - other, np.abs(other) + scale, bound)
    return found


def _value(scene: Scene, name: str) -> float:
    part, kind = name.split("_")
    return float(getattr(getattr(scene, part), kind))


def _derivatives(rough: Solution, fine: Solution, random: np.random.Generator) -> dict[str, float]:
    """Compare derivatives of slip rate and slip with those of the better answer, and their weighted
    sum with the fields themselves, since doubling all tractions doubles the fields."""
    scene, x = rough.scene, _clear(fine, random)
    fronts = (scene.material.shear_speed, scene.material.longitudinal_speed)
    x = x[np.abs(x[:, None] - np.array(fronts)).min(axis=1) > _CLEAR * scene.material.shear_speed]
    names = [name for name in _TRACTIONS if _value(scene, name)]
    pairs = {name: (rough.derivative(name), fine.derivative(name)) for name in names}
    worst, sums = 0.0, {"slip_rate": (0.0, 0.0), "slip": (0.0, 0.0)}
    for name, (one, other) in pairs.items():
        value = abs(_value(scene, name))
        for field in sums:
            own, better = getattr(one, field)(x, 1.0), getattr(other, field)(x, 1.0)
            exact = np.abs(getattr(fine, field)(x, 1.0)).max(initial=0.0)
            scale = max(np.abs(better).max(initial=0.0), exact / value)
            bound = one.error_estimate + other.error_estimate
            worst = max(worst, _over(own - better, scale, bound))
            total, allowed = sums[field]
            sums[field] = (
                total + _value(scene, name) * own,
                allowed + one.error_estimate * value * scale,
            )
    left = [
        _over(total - getattr(rough, field)(x, 1.0), allowed, 1.0)
        for field, (total, allowed) in sums.items()
    ]
    return {"derivatives": worst, "homogeneity": max(left)}


def summary(rows: Sequence[AnswerRow]) -> list[SummaryRow]:
    """Count outcomes, and for each quantity the checks and the errors beyond their estimates."""
    outcomes = [row.outcome for row in rows]
    answered = [row for row in rows if row.outcome == "converged"]
    lines = [
        ("scenes drawn", f"{len(rows)}"),
        ("answered", f"{len(answered)}"),
        ("refused with a sentence", f"{outcomes.count('refused')}"),
        ("told as unresolved", f"{outcomes.count('unresolved')}"),
        ("raised anything else", f"{sum(one.startswith('raised') for one in outcomes)}"),
        ("of a law that depends on slip rate",
         f"{sum(row.law != 'CoulombFriction' for row in answered)}"),
        ("in antiplane shear", f"{sum(row.mode == 'antiplane' for row in answered)}"),
        ("where the contact opens", f"{sum(row.opens for row in answered)}"),
        ("base beyond 1000 times the step or below 1/1000",
         f"{sum(not 1e-3 < row.ratio < 1e3 for row in answered)}"),
    ]  # fmt: skip
    for name in QUANTITIES:
        ratios = np.array([getattr(row, name) for row in answered])
        ratios = ratios[~np.isnan(ratios)]
        if len(ratios):
            beyond = int((ratios > 1).sum())
            what = f"{name.replace('_', ' ')}: asked, beyond the estimate, largest over it"
            lines.append((what, f"{len(ratios)}, {beyond}, {ratios.max():.2g}"))
    return [SummaryRow(*line) for line in lines]


def run_answers(
    directory: Path, scenes: int, seed: int, processes: int | None = 1
) -> list[AnswerRow]:
    """All rows in order, those of an earlier run with the same seed included; one process runs
    here, None is one per core.

    Raises
    ------
    DataFileError
        If the table cannot be written.
    """
    from rich.console import Console

    directory.mkdir(parents=True, exist_ok=True)
    table = directory / f"answerrows-{seed}.csv"
    known = {row.index: row for row in started_rows(table, AnswerRow)}
    left = [index for index in range(scenes) if index not in known]
    tasks = [(answer_row, (seed, index)) for index in left]
    with progress_bar(Console(stderr=True), False, "answers") as progress:
        for _, row in run_tasks(tasks, processes, progress):
            append_rows(table, [row])
            known[row.index] = row
    return [known[index] for index in sorted(known) if index < scenes]


def known_answers(directory: Path, seed: int) -> list[AnswerRow]:
    """All rows of earlier runs with a seed, in order, of whatever draws they are."""
    rows = started_rows(directory / f"answerrows-{seed}.csv", AnswerRow)
    return sorted(rows, key=lambda row: row.index)


def main() -> None:
    """Run the campaign and print its table."""
    from rich.console import Console

    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--scenes", type=int, default=SCENES)
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--processes", type=int, metavar="N", help="default: one per core")
    parser.add_argument(
        "--known", action="store_true", help="solve nothing: sum up all rows that there are"
    )
    parser.add_argument("--output", type=Path, default=Path("results", "campaign"))
    parser.add_argument("--csv", type=Path, metavar="DIR", help="folder for answers.csv; docs/data")
    chosen = parser.parse_args()
    if chosen.processes is not None and chosen.processes < 1:
        parser.error("--processes must be 1 or more.")
    if chosen.known:
        rows, asked = known_answers(chosen.output, chosen.seed), "--known"
    else:
        rows = run_answers(chosen.output, chosen.scenes, chosen.seed, chosen.processes)
        asked = f"--scenes {chosen.scenes}"
    lines = summary(rows)
    Console().print(shown_rows("what answers say of themselves", lines))
    if chosen.csv is not None:
        command = f"python -m docs.studies.campaign.answers {asked} --csv docs/data"
        write_rows(chosen.csv / "campaign-answers.csv", lines, command=command)


if __name__ == "__main__":
    main()
