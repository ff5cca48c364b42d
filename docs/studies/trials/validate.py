"""How far `validate` can be trusted: right records, and records with a mistake.

Our finite elements and our marcher take the part of another code, on 50 and 100 cells over c_t T,
with one file of records at five stations, or two, and the spacing alone to go by.  Scenes are
random ones: the bars were set on those of one seed, and are tried on those of another
(``python -m docs.studies.trials.validate validate-alarms validate-power --workers 2``).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from statistics import median
from typing import Any

import numpy as np

from compare.comparison.rows import DIFFERS, UNRESOLVED
from compare.records.record import QUANTITIES
from compare.validation.rows import PLACES
from compare.validation.validation import Validation, validate
from docs.studies.runner import Point, Row, Study, main
from docs.studies.trials.draws import HISTORIES, OPENINGS, STEPS, judged_scene
from fem import simulate
from semianalytic import (
    ComputationError,
    InterfaceHistory,
    Material,
    Scene,
    SceneError,
    Solution,
    solve,
)

Arrays = dict[str, Any]

CELLS = (50, 100)
USES: Mapping[str, int] = {"set": 101, "tried": 303}
"""Seeds of the scenes that bars were set on, and of those that they are tried on."""
COUNTS: Mapping[str, int] = {STEPS: 16, OPENINGS: 8, HISTORIES: 4}
"""Scenes of each kind."""


def history_arrays(history: InterfaceHistory, end_time: float) -> Arrays:
    """A history at `PLACES` until an end time [time], as a file of another code would hold it."""
    kept = history.t <= end_time * (1 + 1e-9)
    x = np.array(PLACES) * end_time
    values = {
        name: np.stack([np.interp(x, history.x, row) for row in getattr(history, name)[kept]])
        for name in QUANTITIES
    }
    return {"t": history.t[kept], "x": x, **values}


def _simulated(scene: Scene, cells: int) -> Arrays:
    return history_arrays(simulate(scene, 1.0, resolution=cells).interface, 1.0)


def _marched(scene: Scene, cells: int) -> Arrays:
    marched = solve(
        scene,
        method="space-time",
        end_time=1.0,
        nodes=math.ceil(cells * scene.fastest_speed),
        companion=False,
    )
    t, x = marched.interface.t, np.array(PLACES)
    values = {name: getattr(marched, name)(x, t[:, None]) for name in QUANTITIES}
    return {"t": t, "x": x, **values}


CODES: Mapping[str, Callable[[Scene, int], Arrays]] = {"fem": _simulated, "march": _marched}


def _scene(use: str, kind: str, index: int) -> Scene:
    return judged_scene(kind, np.random.default_rng([USES[use], index]))


def _judged(data: Sequence[Arrays], scene: Scene, cells: Sequence[int]) -> Validation:
    return validate(list(data), scene, spacing=[1 / one for one in cells])


def right_rows(use: str, kind: str, index: int, code: str) -> list[Row]:
    """Judge right records of one resolution and of both; none if a code refuses the scene."""
    scene = _scene(use, kind, index)
    try:
        data = [CODES[code](scene, cells) for cells in CELLS]
        ways = [(data[:1], CELLS[:1]), (data[1:], CELLS[1:]), (data, CELLS)]
        found = [(cells, _judged(part, scene, cells)) for part, cells in ways]
    except (SceneError, ComputationError):
        return []
    return [
        {
            "kind": kind,
            "use": use,
            "code": code,
            "cells": " and ".join(map(str, cells)),
            "runs": 1,
            "rows": len(one.rows),
            "differs": one.counts[DIFFERS],
            "unresolved": one.counts[UNRESOLVED],
            "most": max((row.over_bar for row in one.rows if not row.obstacle), default=0.0),
            "rate_bar": _bar_of(one, "slip rate all stations"),
            "slip_bar": _bar_of(one, "slip all stations"),
        }
        for cells, one in found
    ]


def _bar_of(found: Validation, name: str) -> float:
    bar = next((row.bar for row in found.rows if row.name == name), None)
    return math.nan if bar is None else bar


def alarms(rows: list[Row]) -> list[Row]:
    """Return sums of counts, the largest difference over its bar, and medians of bars, by group."""
    groups: dict[tuple[str, ...], list[Row]] = {}
    for row in rows:
        groups.setdefault(tuple(row[name] for name in ("use", "kind", "code", "cells")), []).append(
            row
        )
    found = []
    for _, group in sorted(groups.items()):
        line = dict(group[0])
        for name in ("runs", "rows", "differs", "unresolved"):
            line[name] = sum(row[name] for row in group)
        line["most"] = max(row["most"] for row in group)
        for name in ("rate_bar", "slip_bar"):
            bars = [row[name] for row in group if not math.isnan(row[name])]
            line[name] = median(bars or [math.nan])
        found.append(line)
    return found


Spoil = Callable[[Arrays, Scene], tuple[Arrays, Scene] | None]
"""Records and the scene they are held against, spoilt; None where the mistake changes nothing."""


def _friction(factor: float) -> Spoil:
    def spoil(data: Arrays, scene: Scene) -> tuple[Arrays, Scene] | None:
        return (data, replace(scene, friction=factor * scene.friction)) if scene.friction else None

    return spoil


def _poisson(change: float) -> Spoil:
    def spoil(data: Arrays, scene: Scene) -> tuple[Arrays, Scene]:
        solid = scene.material
        ratio = solid.poisson_ratio + change
        return data, replace(scene, material=Material(solid.shear_modulus, solid.density, ratio))

    return spoil


def _times(**factors: float) -> Spoil:
    def spoil(data: Arrays, scene: Scene) -> tuple[Arrays, Scene] | None:
        changed = {name: factor * data[name] for name, factor in factors.items()}
        if all(np.array_equal(data[name], value) for name, value in changed.items()):
            return None
        return {**data, **changed}, scene

    return spoil


def _no_second_zone(data: Arrays, scene: Scene) -> tuple[Arrays, Scene] | None:
    """Slip ahead of the gap between two zones left out."""
    answer: Solution | None = solve(scene) if scene.is_self_similar else None
    if answer is None or len(answer.zones) < 2 or answer.zones[0].inner > 0:
        return None
    ahead = data["x"] > 0.5 * (answer.zones[0].outer + answer.zones[1].inner) * data["t"][:, None]
    return {**data, **{n: np.where(ahead, 0.0, data[n]) for n in ("slip_rate", "slip")}}, scene


SPOILS: Mapping[str, Spoil] = {
    "friction +3 %": _friction(1.03),
    "friction −3 %": _friction(0.97),
    "ν +0.01": _poisson(0.01),
    "ν −0.01": _poisson(-0.01),
    "tractions times 1.1": _times(shear_traction=1.1, pressure=1.1),
    "slip times 1.1": _times(slip_rate=1.1, slip=1.1),
    "times times 1.02": _times(t=1.02),
    "no second zone": _no_second_zone,
}


def wrong_rows(kind: str, index: int) -> list[Row]:
    """Judge records of finite elements on the finer mesh, with every mistake."""
    scene, rows = _scene("tried", kind, index), []
    try:
        data = _simulated(scene, CELLS[-1])
    except (SceneError, ComputationError):
        return []
    for mistake, spoil in SPOILS.items():
        try:
            changed = spoil(data, scene)
            if changed is not None:
                found = _judged(changed[:1], changed[1], CELLS[-1:])
                rows.append({"mistake": mistake, "verdict": found.verdict})
        except SceneError:  # the scene that it is held against is none
            continue
    return rows


def power(rows: list[Row]) -> list[Row]:
    """Return how often each mistake is caught."""
    found = []
    for mistake in SPOILS:
        verdicts = [row["verdict"] for row in rows if row["mistake"] == mistake]
        counts = {"caught": verdicts.count(DIFFERS), "unresolved": verdicts.count(UNRESOLVED)}
        found.append({"mistake": mistake, "scenes": len(verdicts), **counts})
    return found


def _draws(quick: bool) -> list[tuple[str, int]]:
    return [
        (kind, index) for kind, count in COUNTS.items() for index in range(1 if quick else count)
    ]


def right_points(quick: bool) -> list[Point]:
    """Return seeds, kinds and numbers of scenes, and codes."""
    return [(use, *draw, code) for use in USES for draw in _draws(quick) for code in CODES]


STUDIES = [
    Study("validate-alarms", right_points, right_rows, alarms),
    Study("validate-power", _draws, wrong_rows, power),
]

if __name__ == "__main__":
    raise SystemExit(main("docs.studies.trials.validate", STUDIES))
