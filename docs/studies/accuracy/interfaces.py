"""Judge interfaces by finite elements: named ones, and thirty random pairs of bodies.

``python -m docs.studies.accuracy.interfaces --output docs`` writes interfaces-named.csv,
interfaces-drawn.csv with a row for each answer to a pair, and interfaces-pairs.csv with their
counts, in about a quarter of an hour.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from statistics import median
from typing import Any

import numpy as np

import semianalytic as sf
from compare.comparison.interfaces.comparing import compare_interface, judge_interface
from compare.comparison.judgement import Judgement
from compare.comparison.rows import AGREES, DIFFERS, UNRESOLVED, Row
from docs.studies.lines import scene_along
from docs.studies.runner import Point, Study, grouped, main
from docs.studies.runner import Row as Line
from semianalytic.dissimilar.kernels import BodyPair
from semianalytic.engine.stepping.window import least_delay, threshold_of
from semianalytic.scene.errors import SceneError

NODES, MESH, END = 512, 256, 2.0
WINDOWS = {"no wave grows": (20, True, 31), "waves grow, with a delay": (10, False, 13)}
"""What is drawn, how many pairs, whether friction is in the window, and the seed."""
JUDGED = (
    "rock-on-gouge",
    "steel-on-rubber",
    "two-slots",
    "tap",
    "punch",
    "tpv205",
    "rate-and-state",
)
"""Named interfaces that are judged; `cattaneo`, `supershear` and `tpv101` take longest."""


def named(name: str) -> list[Line]:
    """Return the judged quantities of a named interface, or that it is refused."""
    found = sf.find(name)
    none = dict.fromkeys(("difference", "bar", "order"))
    try:
        judged = compare_interface(found, **found.run)
    except SceneError:
        row = {"interface": name, "mesh": None, "quantity": "", **none}
        return [{**row, "verdict": "", "whole": "refused"}]
    head = {"interface": name, "mesh": judged.simulation.resolution}
    return [
        head
        | {"quantity": row.kind, **{one: getattr(row, one) for one in (*none, "verdict")}}
        | {"whole": judged.verdict}
        for row in judged.rows
    ]


def drawn(rng: np.random.Generator, inside: bool) -> sf.Scene:
    """Return a random pair of bodies: a growing patch on the whole line, or a loaded slot.

    Inside, no wave grows under Coulomb friction; outside one does, and friction has a delay.
    """
    upper = sf.Material(1.0, 1.0, float(rng.uniform(0.15, 0.35)))
    while True:
        density = float(rng.uniform(0.7, 1.4))
        contrast = float(rng.uniform(1.1, 3.0))
        lower = sf.Material(density * contrast**2, density, float(rng.uniform(0.15, 0.35)))
        friction = float(rng.uniform(0.1, 0.7))
        bodies = (upper, lower) if rng.random() < 0.5 else (lower, upper)
        pair = BodyPair(*bodies)
        if (friction < threshold_of(pair.kernels)) == inside:
            break
    delay = 0.0 if inside else float(rng.uniform(2, 6)) * least_delay(pair, 12.0 / (NODES // 4))
    law = sf.Coulomb(friction, delay=delay)
    sense = 1.0 if rng.random() < 0.5 else -1.0
    common: dict[str, Any] = {"material": bodies[0], "lower_material": bodies[1], "length": 12.0}
    if rng.random() < 0.5:
        rate, excess = float(rng.uniform(0.15, 0.5)), float(rng.uniform(0.4, 1.0))

        def push(x: Any, t: float) -> Any:
            edge = np.clip((rate * t - np.abs(x)) / 0.2 + 0.5, 0.0, 1.0)
            return sense * friction * excess * edge

        load = sf.InterfaceLoad(push, history=None)
        return scene_along(law=law, shear=0.7 * sense * friction, loads=[load], **common)
    load = sf.InterfaceLoad(sense * float(rng.uniform(0.5, 1.5)), on="slot")
    slot = sf.Contact([(-6.0, -1.0), (1.0, 6.0)])
    return scene_along(law=law, loads=[load], contact=slot, **common)


SPOILS: dict[str, Callable[[Any], sf.Scene]] = {
    "bodies exchanged": lambda one: replace(
        one, material=one.lower_material or one.material, lower_material=one.material
    ),
    "friction a tenth too high": lambda one: replace(
        one, law=replace(one.law, friction=1.1 * one.law.friction)
    ),
    "identical bodies": lambda one: replace(one, lower_material=None),
}
"""Wrong answers: runs of another interface than the one that is simulated."""


def judged_row(pairs: str, number: int, answer: str, judged: Judgement) -> Line:
    """Return the verdict on an answer, its farthest row in bars, and how far its slip is off."""
    slip = next(row for row in judged.rows if row.kind == "slip")
    rows: list[Row] = [row for row in judged.rows if row.converges]
    return {
        "pairs": pairs,
        "number": number,
        "answer": answer,
        "verdict": judged.verdict,
        "farthest": max((row.over_bar for row in rows), default=0.0),
        "slip": abs(slip.difference or 0.0),
        "slip_bar": slip.bar or 0.0,
    }


@cache
def answers(label: str, number: int) -> list[Line]:
    """Simulate a pair once; return the verdicts on its run, and on those of other interfaces."""
    _, inside, seed = WINDOWS[label]
    rng = np.random.default_rng(seed)
    interface = [drawn(rng, inside) for _ in range(number + 1)][-1]
    judged = compare_interface(interface, END, NODES, mesh_nodes=MESH)
    case: Any = judged.case
    times = list(case.run.t)
    rows = [judged_row(label, number, "right", judged)]
    for name, spoil in SPOILS.items():
        try:
            other = sf.solve(spoil(interface), end_time=END, nodes=NODES, times=times)
        except SceneError:  # the other interface may be ill-posed
            continue
        found = judge_interface(other, case.simulations)
        rows.append(judged_row(label, number, name, found))
    return rows


def pairs(rows: list[Line]) -> list[Line]:
    """Return the verdicts inside and outside of the window, on right answers and on wrong ones."""
    found = []
    for (label, answer), group in grouped(rows, "pairs", "answer"):
        verdicts = [row["verdict"] for row in group]
        line: Line = {"pairs": label, "answer": answer, "drawn": len(group)}
        for name, verdict in (("agree", AGREES), ("unresolved", UNRESOLVED), ("differ", DIFFERS)):
            line[name] = verdicts.count(verdict)
        line["farthest"] = max(row["farthest"] for row in group)
        for name in ("slip", "slip_bar"):
            line[name] = median(row[name] for row in group)
        found.append(line)
    return found


def points(quick: bool) -> list[Point]:
    """Return the numbers of all pairs; the first of each kind for a quick look."""
    counts = {label: 1 if quick else count for label, (count, _, _) in WINDOWS.items()}
    return [(label, number) for label, count in counts.items() for number in range(count)]


STUDIES = [
    Study("interfaces-named", lambda quick: [(n,) for n in JUDGED[: 2 if quick else None]], named),
    Study("interfaces-drawn", points, answers),
    Study("interfaces-pairs", points, answers, pairs),
]

if __name__ == "__main__":
    raise SystemExit(main("docs.studies.accuracy.interfaces", STUDIES))
