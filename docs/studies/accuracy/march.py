"""Marches against exact answers and finer marches: the tables of docs/spacetime.md.

``python -m docs.studies.accuracy.march march-accuracy --output docs`` measures slip rates by nodes,
`march-fields` the fields in the bodies, `march-weakening` slip that weakens, and `march-error` what
marches say of their own errors, on random scenes.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from docs.studies.profiles import last_march, step_error
from docs.studies.runner import Point, Row, Study, main
from docs.studies.trials.draws import drawn, random_history_scene, random_step_scene
from semianalytic import (
    Answer,
    Marched,
    Ramp,
    RateWeakening,
    Scene,
    SlipfrontError,
    SlipWeakening,
    Tractions,
    find,
    solve,
)
from semianalytic.scene.contact import process_zone
from semianalytic.scene.given.named import NAMED_SCENES

Array = NDArray[np.float64]

SELF_SIMILAR = ("preloaded", "remote-shock", "auxetic", "antiplane")
NODES, FINER = 256, 6
"""Nodes of the marches whose estimates are judged, and how many times finer their references are
where there is no exact answer."""
STEPS, HISTORIES, SEED = 30, 24, 14
"""Number of random scenes with step loads and with other load histories."""
IN_PROCESS_ZONE, FINEST_IN_PROCESS_ZONE = (2, 3, 4, 6, 8, 12, 16, 24), 64
"""Nodes in the process zone of slip weakening, and of the references."""
POINTS = 300
"""Random points in both bodies, within 1.1 times the reach of the waves."""
ROUNDING = 1e-12
LEVELS = 100
"""Largest number of levels at which slip rates are compared."""

_PRELOADED = find("preloaded")
_QUARTER = replace(_PRELOADED.material, poisson_ratio=0.25)


def _weakening(base: float, shear: float, law: SlipWeakening, **parts: object) -> Scene:
    loads = Tractions(1.0, base), Tractions(0.0, shear)
    return replace(Scene(_QUARTER, 0.6, *loads, friction_law=law), **parts)  # type: ignore[arg-type]


WEAKENING: Mapping[str, tuple[Scene, float]] = {
    "step": (_weakening(0.4, 0.4, SlipWeakening(2 / 3, 0.05)), 2.0),
    "heavy": (
        _weakening(0.1, 0.5, SlipWeakening(0.9, 0.05), material=_PRELOADED.material),
        1.0,
    ),
    "ramp": (_weakening(0.3, 0.4, SlipWeakening(0.5, 0.05), shear_history=Ramp(0.4)), 1.0),
}
"""Scenes that weaken with slip, and their end times."""


def accuracy(name: str, grids: Sequence[int]) -> list[Row]:
    """Return the L1 errors of the slip rate by nodes, with orders and seconds."""
    rows, before = [], math.nan
    for nodes in grids:
        began = time.perf_counter()
        marched = last_march(find(name), nodes)
        seconds = time.perf_counter() - began
        error = step_error(find(name), marched)
        order = math.log2(before / error)
        rows.append(
            {"scene": name, "nodes": nodes, "error": error, "order": order, "seconds": seconds}
        )
        before = error
    return rows


def fields(name: str, grids: Sequence[int]) -> list[Row]:
    """Return the L1 errors of fields in the bodies at T over their change, and orders of stress."""
    rows, before = [], math.nan
    for nodes in grids:
        velocity, stress, displacement = field_errors(find(name), nodes)
        row: Row = {"scene": name, "nodes": nodes, "velocity": velocity, "stress": stress}
        rows.append({**row, "displacement": displacement, "order": math.log2(before / stress)})
        before = stress
    return rows


def field_errors(scene: Scene, nodes: int, points: int = POINTS) -> list[float]:
    """Return errors of velocity, stress and displacement where the exact fields are finite."""
    end = 1 / scene.material.shear_speed
    marched, exact = (
        solve(scene, method="space-time", end_time=end, nodes=nodes, companion=False),
        solve(scene),
    )
    reach = 1.1 * scene.fastest_speed * end
    at = *np.random.default_rng(1).uniform(-reach, reach, (2, points)), end
    errors = []
    for name in ("velocity", "stress", "displacement"):
        true, rest = getattr(exact, name)(*at), getattr(exact, name)(*at[:2], 0.0)
        off, change = np.abs(getattr(marched, name)(*at) - true), np.abs(true - rest)
        known = np.isfinite(change).all(axis=0)
        errors.append(float(off[:, known].sum() / change[:, known].sum()))
    return errors


@dataclass(frozen=True)
class Judged:
    """True and estimated relative error of one result of a march."""

    scenes: str
    quantity: str
    true: float
    estimate: float


def judged(name: str, marched: Marched, truth: Answer) -> list[Judged]:
    """Compare the errors of a march with its estimates; return no rows if nothing happens.

    The errors are those of slip rate in L1 over space and time, of final fields in L1 over space,
    and of totals at the end.
    """
    x, end = marched.interface.x, marched.end_time
    rows = [Judged(name, "slip rate", rate_error(marched, truth), marched.error_estimate)]
    readings: Mapping[str, Callable[[Answer], Array]] = {
        "slip": lambda answer: answer.slip(x, end),
        "shear traction": lambda answer: answer.shear_traction(x, end),
        "largest slip": lambda answer: answer.max_slip(end),
        "accumulated slip": lambda answer: answer.accumulated_slip(end),
        "frictional work": lambda answer: answer.frictional_work(end),
    }
    for quantity, reading in readings.items():
        exact = reading(truth)
        scale = float(np.abs(exact).sum())
        if not 0 < scale < math.inf:
            continue
        true = float(np.abs(reading(marched) - exact).sum()) / scale
        estimate = float(marched.error_of(reading).sum()) / scale
        rows.append(Judged(name, quantity, true, estimate))
    return [row for row in rows if row.true > ROUNDING]


def rate_error(marched: Marched, truth: Answer) -> float:
    """Return the relative L1 error of the slip rate of a march over nodes and stored levels."""
    own = marched.interface
    seen = np.arange(len(own.t) - 1, 0, -max(1, len(own.t) // LEVELS))
    exact = truth.slip_rate(own.x, own.t[seen, None])
    size = float(np.abs(exact).sum())
    return float(np.abs(own.slip_rate[seen] - exact).sum()) / size if size else 0.0


def error_scene(kind: str, which: str | int) -> Scene:
    """Return a named scene, or a random one of a number."""
    if isinstance(which, str):
        return find(which)
    return drawn(SEED, which, random_step_scene if kind == "step" else random_history_scene)[0]


def error_points(quick: bool) -> list[Point]:
    """Return the scenes whose marches are judged."""
    shares = range(STEPS // 10 if quick else STEPS), range(HISTORIES // 8 if quick else HISTORIES)
    named = [("named", name) for name in NAMED_SCENES][:: 6 if quick else 1]
    return [*named, *(("step", i) for i in shares[0]), *(("history", i) for i in shares[1])]


def judged_march(kind: str, which: str | int, nodes: int = NODES) -> list[Judged]:
    """Judge the march of a scene; return no rows if it has none, or if the march is unresolved."""
    scene = error_scene(kind, which)
    if isinstance(scene.friction_law, RateWeakening):
        kind = "rate weakening"
    else:
        kind = "self-similar" if scene.is_self_similar else "histories and slip weakening"
    end = 1 / scene.material.shear_speed
    try:
        marched = solve(scene, method="space-time", end_time=end, nodes=nodes)
        if marched.status != "resolved":
            return []
        if scene.is_self_similar:
            return judged(kind, marched, solve(scene, method="self-similar"))
        length = nodes * marched.grid.spacing
        return judged(
            kind,
            marched,
            solve(
                scene,
                method="space-time",
                end_time=end,
                nodes=FINER * nodes,
                length=length,
                companion=False,
            ),
        )
    except SlipfrontError:
        return []


def ratios(rows: list[Row]) -> list[Row]:
    """Return how often and how far estimates exceed true errors, by kind of scene and quantity."""
    groups: dict[tuple[str, str], list[float]] = {}
    for row in rows:
        group = row["scenes"], row["quantity"]
        groups.setdefault(group, []).append(row["estimate"] / row["true"])
    return [
        {
            "scenes": kind,
            "quantity": quantity,
            "cases": len(found),
            "covered": float(np.mean(np.array(found) >= 1)),
            "least": min(found),
            "median": float(np.median(found)),
            "largest": max(found),
        }
        for (kind, quantity), found in sorted(groups.items(), reverse=True)
    ]


def weakening(name: str, counts: Sequence[int]) -> list[Row]:
    """Return errors by nodes in the process zone, relative to marches with many more there."""
    scene, end = WEAKENING[name]
    length = scene.material.longitudinal_speed * end
    share = length / process_zone(scene)
    finest = round(FINEST_IN_PROCESS_ZONE * share)
    truth = solve(
        scene, method="space-time", end_time=end, nodes=finest, length=length, companion=False
    )
    rows = []
    for count in counts:
        marched = solve(
            scene, method="space-time", end_time=end, nodes=math.ceil(count * share), length=length
        )
        found = {row.quantity: row.true for row in judged(name, marched, truth)}
        row: Row = {"scene": name, "nodes": count, "slip_rate": found["slip rate"]}
        row |= {"estimate": marched.error_estimate, "slip": found["slip"]}
        rows.append({**row, "work": found["frictional work"]})
    return rows


def _by_scene(names: Sequence[str], grids: Sequence[int]) -> Callable[[bool], list[Point]]:
    return lambda quick: [(name, list(grids[:2] if quick else grids)) for name in names]


STUDIES = [
    Study(
        "march-accuracy", _by_scene(SELF_SIMILAR[:3], (128, 256, 512, 1024, 2048, 4096)), accuracy
    ),
    Study("march-fields", _by_scene(SELF_SIMILAR, (64, 128, 256, 512, 1024)), fields),
    Study("march-weakening", _by_scene(tuple(WEAKENING), IN_PROCESS_ZONE), weakening),
    Study("march-error", error_points, judged_march, ratios),
]

if __name__ == "__main__":
    raise SystemExit(main("docs.studies.accuracy.march", STUDIES))
