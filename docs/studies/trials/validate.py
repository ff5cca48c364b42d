"""How far `validate` can be trusted: right records, and records with a mistake.

Our finite elements and our marcher take the part of another code, on 50 and 100 cells over c_t T,
with one file of records at five stations, or two, and the spacing alone to go by.  Scenes are
random ones: the bars were set on those of one seed, and are tried on those of another
(``python -m docs.studies.trials.validate validate-alarms validate-power --workers 2``).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import partial
from statistics import median
from typing import Any

import numpy as np

import semianalytic as sf
from compare.comparison.rows import DIFFERS, UNRESOLVED
from compare.records.record import QUANTITIES
from compare.validation.rows import PLACES
from compare.validation.validation import Validation, validate
from docs.studies.accuracy.march import reference
from docs.studies.runner import Point, Row, Study, grouped, main, number
from docs.studies.trials.draws import HISTORIES, OPENINGS, STEPS, judged_scene
from docs.studies.trials.wrong_answers import MISTAKEN_SCENES
from fem import simulate
from semianalytic.results.interface_history import InterfaceHistory

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


def _simulated(scene: sf.Scene, cells: int) -> Arrays:
    return history_arrays(simulate(scene, 1.0, resolution=cells).interface, 1.0)


def _marched(scene: sf.Scene, cells: int) -> Arrays:
    marched = reference(scene, 1.0, math.ceil(cells * scene.fastest_speed))
    t, x = marched.interface.t, np.array(PLACES)
    values = {name: getattr(marched, name)(x, t[:, None]) for name in QUANTITIES}
    return {"t": t, "x": x, **values}


CODES: Mapping[str, Callable[[sf.Scene, int], Arrays]] = {"fem": _simulated, "march": _marched}


def right_rows(use: str, kind: str, index: int, code: str) -> list[Row]:
    """Judge right records of one resolution and of both; none if a code refuses the scene."""
    scene = judged_scene(kind, np.random.default_rng([USES[use], index]))
    try:
        data = [CODES[code](scene, cells) for cells in CELLS]
        found = [
            (cells, validate(part, scene, spacing=[1 / cell for cell in cells]))
            for part, cells in ((data[:1], CELLS[:1]), (data[1:], CELLS[1:]), (data, CELLS))
        ]
    except (sf.SceneError, sf.ComputationError):
        return []
    rows: list[Row] = []
    for cells, answer in found:
        row: Row = {"kind": kind, "use": use, "code": code, "cells": " and ".join(map(str, cells))}
        row |= {"runs": 1, "rows": len(answer.rows)}
        row |= {"differs": answer.counts[DIFFERS], "unresolved": answer.counts[UNRESOLVED]}
        row["most"] = max((line.over_bar for line in answer.rows if not line.obstacle), default=0.0)
        row["rate_bar"] = _bar_of(answer, "slip rate all stations")
        rows.append(row | {"slip_bar": _bar_of(answer, "slip all stations")})
    return rows


def _bar_of(found: Validation, name: str) -> float:
    return number(next((row.bar for row in found.rows if row.name == name), None))


def alarms(rows: list[Row]) -> list[Row]:
    """Return sums of counts, the largest difference over its bar, and medians of bars, by group."""
    found = []
    for _, group in sorted(grouped(rows, "use", "kind", "code", "cells")):
        line = dict(group[0])
        for name in ("runs", "rows", "differs", "unresolved"):
            line[name] = sum(row[name] for row in group)
        line["most"] = max(row["most"] for row in group)
        for name in ("rate_bar", "slip_bar"):
            bars = [row[name] for row in group if not math.isnan(row[name])]
            line[name] = median(bars or [math.nan])
        found.append(line)
    return found


Spoil = Callable[[Arrays, sf.Scene], tuple[Arrays, sf.Scene] | None]
"""Records and the scene they are held against, spoilt; None where the mistake changes nothing."""


def _of_scene(mistake: str, data: Arrays, scene: sf.Scene) -> tuple[Arrays, sf.Scene] | None:
    other = MISTAKEN_SCENES[mistake](scene)
    return None if other == scene else (data, other)


def _times(factors: Arrays, data: Arrays, scene: sf.Scene) -> tuple[Arrays, sf.Scene] | None:
    changed = {name: factor * data[name] for name, factor in factors.items()}
    if all(np.array_equal(data[name], value) for name, value in changed.items()):
        return None
    return {**data, **changed}, scene


def _no_second_zone(data: Arrays, scene: sf.Scene) -> tuple[Arrays, sf.Scene] | None:
    """Slip ahead of the gap between two zones left out."""
    answer: sf.Solution | None = sf.solve(scene) if scene.is_self_similar else None
    if answer is None or len(answer.zones) < 2 or answer.zones[0].inner > 0:
        return None
    ahead = data["x"] > 0.5 * (answer.zones[0].outer + answer.zones[1].inner) * data["t"][:, None]
    return {**data, **{n: np.where(ahead, 0.0, data[n]) for n in ("slip_rate", "slip")}}, scene


SPOILS: Mapping[str, Spoil] = {
    "friction +3 %": partial(_of_scene, "friction +3 %"),
    "friction −3 %": partial(_of_scene, "friction -3 %"),
    "ν +0.01": partial(_of_scene, "ν +0.01"),
    "ν −0.01": partial(_of_scene, "ν -0.01"),
    "tractions times 1.1": partial(_times, {"shear_traction": 1.1, "pressure": 1.1}),
    "slip times 1.1": partial(_times, {"slip_rate": 1.1, "slip": 1.1}),
    "times times 1.02": partial(_times, {"t": 1.02}),
    "no second zone": _no_second_zone,
}


def wrong_rows(kind: str, index: int) -> list[Row]:
    """Judge records of finite elements on the finer mesh, with every mistake."""
    scene, rows = judged_scene(kind, np.random.default_rng([USES["tried"], index])), []
    try:
        data = _simulated(scene, CELLS[-1])
    except (sf.SceneError, sf.ComputationError):
        return []
    for mistake, spoil in SPOILS.items():
        try:
            changed = spoil(data, scene)
            if changed is not None:
                found = validate([changed[0]], changed[1], spacing=[1 / CELLS[-1]])
                rows.append({"mistake": mistake, "verdict": found.verdict})
        except sf.SceneError:  # the scene that it is held against is none
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
