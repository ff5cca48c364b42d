"""Marches against exact answers and finer marches: the tables of docs/how_we_know.md.

``python -m docs.studies.accuracy.march march-accuracy --output docs`` measures slip rates by nodes,
`march-fields` the fields in the bodies, and `march-weakening` slip that weakens.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

import semianalytic as sf
from compare.comparison.measures import relative_error
from docs.studies.runner import Point, Row, Study, main
from semianalytic.results.answer import Answer
from semianalytic.scene.arrays import Array
from semianalytic.scene.contact import process_zone

SELF_SIMILAR = ("preloaded", "remote-shock", "auxetic", "antiplane")
IN_PROCESS_ZONE, FINEST_IN_PROCESS_ZONE = (2, 3, 4, 6, 8, 12, 16, 24), 64
"""Nodes in the process zone of slip weakening, and of the references."""
POINTS = 300
"""Points on 12 depths in both bodies, random in x within 1.1 times the reach of the waves."""
ROUNDING = 1e-12
LEVELS = 100
"""Largest number of levels at which slip rates are compared."""

_SOLID = sf.find("preloaded").material
_QUARTER = replace(_SOLID, poisson_ratio=0.25)


def _weakening(base: float, shear: float, law: sf.SlipWeakening) -> sf.Scene:
    loads = sf.Tractions(1.0, base), sf.Tractions(0.0, shear)
    return sf.Scene(_QUARTER, law, *loads)


_HALVED = sf.SlipWeakening(0.6, 0.3, 0.05)
WEAKENING: Mapping[str, tuple[sf.Scene, float]] = {
    "step": (_weakening(0.4, 0.4, sf.SlipWeakening(0.6, 0.2, 0.05)), 2.0),
    "heavy": (
        replace(_weakening(0.1, 0.5, sf.SlipWeakening(0.6, 0.06, 0.05)), material=_SOLID),
        1.0,
    ),
    "ramp": (replace(_weakening(0.3, 0.4, _HALVED), shear_history=sf.Ramp(0.4)), 1.0),
}
"""Scenes that weaken with slip, and their end times."""


def accuracy(name: str, grids: Sequence[int]) -> list[Row]:
    """Return the L1 errors of the slip rate by nodes, with orders and seconds."""
    rows, before = [], math.nan
    for nodes in grids:
        began = time.perf_counter()
        marched = last_march(sf.find(name), nodes)
        seconds = time.perf_counter() - began
        error = step_error(sf.find(name), marched)
        row: Row = {"scene": name, "nodes": nodes, "error": error}
        rows.append({**row, "order": math.log2(before / error), "seconds": seconds})
        before = error
    return rows


def step_error(scene: sf.Scene, marched: sf.Marched) -> float:
    """Return the relative L1 error of the final slip rate on 0.02 < x/(c_t t) < 1.9."""
    x, end = marched.interface.x, marched.end_time
    velocity = x / (end * scene.material.shear_speed)
    seen = (velocity > 0.02) & (velocity < 1.9)
    exact = _exact(scene).slip_rate(x[seen], end)
    return relative_error(marched.interface.slip_rate[-1, seen], exact, x[seen], 1)


@lru_cache(maxsize=4)
def _exact(scene: sf.Scene) -> sf.Solution:
    return sf.solve(scene, rtol=1e-9)


def last_march(scene: sf.Scene, nodes: int, **options: float) -> sf.Marched:
    """March a scene and keep only the last level; like all marches here, it has no companion."""
    given: Row = {"length": 2.0, "every": 10**9, "estimate": False, **options}
    return sf.solve(scene, method="space-time", nodes=nodes, **given)


def fields(name: str, grids: Sequence[int]) -> list[Row]:
    """Return the L1 errors of fields in the bodies at T over their change, and orders of stress."""
    rows, before = list[Row](), math.nan
    for nodes in grids:
        row: Row = {"scene": name, "nodes": nodes, **field_errors(sf.find(name), nodes)}
        rows.append({**row, "order": math.log2(before / row["stress"])})
        before = row["stress"]
    return rows


def field_errors(scene: sf.Scene, nodes: int) -> Row:
    """Return errors of velocity, stress and displacement where the exact fields are finite."""
    end = 1 / scene.material.shear_speed
    marched, exact = reference(scene, end, nodes), sf.solve(scene)
    reach = 1.1 * scene.fastest_speed * end
    x = np.random.default_rng(1).uniform(-reach, reach, (POINTS // 12, 12))
    # clear of plane fronts, which a march smears over four steps on either side
    depths = reach * np.linspace(0.08, 0.84, 6)
    at = x, np.concatenate([depths, -depths]), end
    errors: Row = {}
    for name in ("velocity", "stress", "displacement"):
        true, rest = getattr(exact, name)(*at), getattr(exact, name)(*at[:2], 0.0)
        off, change = np.abs(getattr(marched, name)(*at) - true), np.abs(true - rest)
        known = np.isfinite(change).all(axis=0)
        errors[name] = float(off[:, known].sum() / change[:, known].sum())
    return errors


def judged(name: str, marched: sf.Marched, truth: Answer) -> list[Row]:
    """Compare the relative errors of a march with its estimates; no rows if nothing happens.

    The errors are those of slip rate in L1 over space and time, of final fields in L1 over space,
    and of totals at the end.
    """
    x, end = marched.interface.x, marched.end_time
    errors = {"slip rate": (rate_error(marched, truth), marched.error_estimate)}
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
        errors[quantity] = true, float(marched.error_of(reading).sum()) / scale
    return [
        {"scenes": name, "quantity": quantity, "true": true, "estimate": estimate}
        for quantity, (true, estimate) in errors.items()
        if true > ROUNDING
    ]


def reference(scene: sf.Scene, end: float, nodes: int, length: float | None = None) -> sf.Marched:
    """Return a march without a companion, which would only estimate its error."""
    options: Row = {"method": "space-time", "nodes": nodes, "length": length}
    return sf.solve(scene, end_time=end, estimate=False, **options)


def rate_error(marched: sf.Marched, truth: Answer) -> float:
    """Return the relative L1 error of the slip rate of a march over nodes and stored levels."""
    own = marched.interface
    seen = np.arange(len(own.t) - 1, 0, -max(1, len(own.t) // LEVELS))
    exact = truth.slip_rate(own.x, own.t[seen, None])
    size = float(np.abs(exact).sum())
    return float(np.abs(own.slip_rate[seen] - exact).sum()) / size if size else 0.0


def weakening(name: str, counts: Sequence[int]) -> list[Row]:
    """Return errors by nodes in the process zone, relative to marches with many more there."""
    scene, end = WEAKENING[name]
    length = scene.material.longitudinal_speed * end
    share = length / process_zone(scene)
    finest = round(FINEST_IN_PROCESS_ZONE * share)
    truth, rows = reference(scene, end, finest, length), []
    for count in counts:
        marched = sf.solve(
            scene, method="space-time", end_time=end, nodes=math.ceil(count * share), length=length
        )
        found = {row["quantity"]: row["true"] for row in judged(name, marched, truth)}
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
    Study("march-fields", _by_scene(SELF_SIMILAR, (64, 128, 256)), fields),
    Study("march-weakening", _by_scene(tuple(WEAKENING), IN_PROCESS_ZONE), weakening),
]

if __name__ == "__main__":
    raise SystemExit(main("docs.studies.accuracy.march", STUDIES))
