"""Judge interfaces by finite elements: named ones, and thirty random pairs of bodies.

``python -m docs.studies.interfaces`` writes docs/data/interfaces-named.csv and
docs/data/interfaces-pairs.csv in about a quarter of an hour; ``named`` or ``pairs`` alone writes
one of them.  Each pair is written to docs/data/interfaces-drawn.csv when it is judged, and a run
that was stopped goes on after the last one.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

import semianalytic as sf
from compare.comparison.rows import AGREES, DIFFERS, UNRESOLVED, Row
from compare.interfaces import InterfaceJudgement, compare_interface
from compare.interfaces.judging import judge_interface
from compare.output.tables import read_rows, write_rows
from semianalytic.dissimilar.kernels import BodyPair
from semianalytic.engine.window import least_delay, threshold_of
from semianalytic.scene.errors import SceneError

DATA = Path(__file__).resolve().parents[2] / "data"
COMMAND = "python -m docs.studies.interfaces"
NODES, MESH, END = 512, 256, 2.0
WINDOWS = (("no wave grows", 20, True), ("waves grow, with a delay", 10, False))
"""What is drawn, how many pairs, and whether friction is in the window."""
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


@dataclass(frozen=True)
class Named:
    """One quantity of a named interface, or why there is none."""

    interface: str
    mesh: int | None
    quantity: str
    difference: float | None
    bar: float | None
    order: float | None
    verdict: str
    whole: str


def named() -> Iterator[Named]:
    """Yield the judged quantities of named interfaces."""
    for name in JUDGED:
        found = sf.find(name)
        try:
            judged = compare_interface(found.interface, found.end_time, **found.options)
        except SceneError:
            yield Named(name, None, "", None, None, None, "", "refused")
            continue
        print(name, judged.verdict, flush=True)
        for row in judged.rows:
            yield Named(
                name,
                judged.simulations[0].nodes,
                row.kind,
                row.difference,
                row.bar,
                row.order,
                row.verdict,
                judged.verdict,
            )


def drawn(rng: np.random.Generator, inside: bool) -> sf.Interface:
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
        return sf.Interface(law=law, shear=0.7 * sense * friction, loads=[load], **common)
    load = sf.InterfaceLoad(sense * float(rng.uniform(0.5, 1.5)), on="slot")
    slot = sf.Contact([(-6.0, -1.0), (1.0, 6.0)])
    return sf.Interface(law=law, loads=[load], contact=slot, **common)


@dataclass(frozen=True)
class Pairs:
    """Verdicts on a set of random pairs."""

    pairs: str
    answer: str
    drawn: int
    agree: int
    unresolved: int
    differ: int
    farthest: float
    slip: float
    slip_bar: float


def exchanged(one: sf.Interface) -> sf.Interface:
    """Return an interface whose bodies have changed places."""
    return replace(one, material=one.lower_material or one.material, lower_material=one.material)


def rougher(one: sf.Interface) -> sf.Interface:
    """Return an interface with more friction."""
    law = one.law
    assert isinstance(law, sf.Coulomb)
    return replace(one, law=replace(law, friction=1.1 * law.friction))


SPOILS: dict[str, Callable[[sf.Interface], sf.Interface]] = {
    "bodies exchanged": exchanged,
    "friction a tenth too high": rougher,
    "identical bodies": lambda one: replace(one, lower_material=None),
}
"""Wrong answers: runs of another interface than the one that is simulated."""


@dataclass(frozen=True)
class Judged:
    """The verdict on one answer about one random pair."""

    pairs: str
    number: int
    answer: str
    verdict: str
    farthest: float
    slip: float
    slip_bar: float


def judged_row(pairs: str, number: int, answer: str, judged: InterfaceJudgement) -> Judged:
    """Return the verdict on an answer, its farthest row in bars, and how far its slip is off."""
    slip = next(row for row in judged.rows if row.kind == "slip")
    rows: list[Row] = [row for row in judged.rows if row.converges]
    return Judged(
        pairs,
        number,
        answer,
        judged.verdict,
        max((row.over_bar for row in rows), default=0.0),
        abs(slip.difference or 0.0),
        slip.bar or 0.0,
    )


def answers(label: str, number: int, interface: sf.Interface) -> Iterator[Judged]:
    """Simulate a pair once; yield the verdicts on its run, and on those of other interfaces."""
    judged = compare_interface(interface, END, NODES, mesh_nodes=MESH)
    yield judged_row(label, number, "right", judged)
    for name, spoil in SPOILS.items():
        try:
            other = sf.solve(spoil(interface), end_time=END, nodes=NODES, times=list(judged.run.t))
        except SceneError:  # the other interface may be ill-posed
            continue
        yield judged_row(label, number, name, judge_interface(other, list(judged.simulations)))


def all_judged() -> list[Judged]:
    """Judge the pairs that the table of single verdicts lacks, and return all verdicts."""
    path = DATA / "interfaces-drawn.csv"
    command = f"{COMMAND} pairs"
    rows = read_rows(path, Judged, "verdicts on pairs", command)
    for label, count, inside in WINDOWS:
        rng = np.random.default_rng(31 if inside else 13)
        for number, interface in enumerate([drawn(rng, inside) for _ in range(count)]):
            if any((row.pairs, row.number) == (label, number) for row in rows):
                continue
            found = list(answers(label, number, interface))
            print(*found, sep="\n", flush=True)
            rows += found
            write_rows(path, rows, checked=True, command=command)
    return rows


def pairs() -> Iterator[Pairs]:
    """Yield the verdicts inside and outside of the window, on right answers and on wrong ones."""
    rows = all_judged()
    for label, _, _ in WINDOWS:
        for answer in ("right", *SPOILS):
            of = [row for row in rows if (row.pairs, row.answer) == (label, answer)]
            verdicts = [row.verdict for row in of]
            yield Pairs(
                label,
                answer,
                len(of),
                verdicts.count(AGREES),
                verdicts.count(UNRESOLVED),
                verdicts.count(DIFFERS),
                max(row.farthest for row in of),
                median(row.slip for row in of),
                median(row.slip_bar for row in of),
            )


def main(parts: list[str]) -> None:
    """Write the tables, line by line."""
    for name, rows in (("named", named), ("pairs", pairs)):
        if not parts or name in parts:
            written: list[Named | Pairs] = []
            for row in rows():
                written.append(row)
                write_rows(DATA / f"interfaces-{name}.csv", written, command=COMMAND)


main(sys.argv[1:])
