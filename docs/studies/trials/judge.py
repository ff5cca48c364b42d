"""How far the judge of comparisons can be trusted: right answers, and answers that are wrong.

``python -m docs.studies.trials.judge --output docs`` compares random scenes and interfaces on the
road that users take, `sf.compare` with the mesh that it chooses, and writes what it says of right
answers (judge-right.csv).  On the stored runs, predictions and simulations are then made wrong, and
each of the three runs alone (judge-wrong.csv).  An interrupted trial is continued, and
``--count 20`` tries about so many cases of each.

How far a mistake moves a row is known without the simulation: the right answer at the nodes is put
in its place.  Beyond 1.5 bars a mistake ought to be caught, beyond 2.5 it has to be.  What
agrees although a bar of slip or slip rate is longer than a tenth more is counted by itself.
"""

from __future__ import annotations

import math
import pickle
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from statistics import median
from typing import Any

import numpy as np
import scipy

import semianalytic as sf
from compare.comparison.case import companions_of
from compare.comparison.comparing import compare
from compare.comparison.interfaces.comparing import judge_interface
from compare.comparison.judgement import Judgement, judge
from compare.comparison.mesh_choice import Prices
from compare.comparison.prediction import planned
from compare.comparison.rows import AGREES, ALARM, DIFFERS, MOTION, UNRESOLVED
from compare.comparison.rows import Row as JudgedRow
from docs.studies.runner import JOURNALS, Point, Row, Study, grouped, main
from docs.studies.trials import wrong_answers as bad
from docs.studies.trials.draws import KINDS, judged_interface, judged_scene
from fem import Simulation, simulate, with_companions

SEED = 20461129
COUNTS: Mapping[str, int] = {
    **dict.fromkeys(("steps", "waves", "pairs", "viscous", "antiplane", "histories"), 30),
    **dict.fromkeys(("openings", "moving", "rate weakening"), 30),
    **dict.fromkeys(("SI", "flanks"), 15),
    **{"pair": 16, "slot": 10, "patch": 10, "weakening": 8, "rate-and-state": 6},
    **{"opening": 4, "antiplane interface": 6},
}
"""Scenes and interfaces of each kind: 300 and 60."""
FIRST: Mapping[str, int] = {"pairs": 30, "histories": 60, "moving": 30}
"""Number of the first case of a kind: constants of the judge were chosen on those before."""
LONGEST = 10.0
"""Longest announced time of a comparison [s], as `fem.Cost` counts it on all machines alike."""
CATCHABLE, SURE, MOST, WIDER = 1.5, 2.5, 4.0, 1.1
FOLDER = JOURNALS / "judge-runs"


@dataclass(frozen=True)
class Stored:
    """A prediction, the simulations from the finest mesh on, draws that were refused, and, where it
    is not read from a file, what was said of it."""

    prediction: Any
    simulations: list[Any]
    refused: int
    judgement: Judgement | None = None

    @property
    def is_scene(self) -> bool:
        """Whether it is a scene, not an interface."""
        return isinstance(self.simulations[0], Simulation)

    def judged(self, simulations: Sequence[Any] | None = None, prediction: Any = None) -> Judgement:
        """Judge it, or what is made of its simulations or its prediction."""
        runs, expected = simulations or self.simulations, prediction or self.prediction
        if not self.is_scene:
            return judge_interface(expected, runs)
        chained: Any = None
        for run in reversed(runs):
            chained = replace(run, companion=chained)
        return judge(expected, chained)


def stored(kind: str, index: int) -> Stored:
    """Return the case of a kind and a number, compared as users do unless it is stored already."""
    path = FOLDER / f"{kind.replace(' ', '-')}-{index}.pkl"
    if path.exists():
        return Stored(*pickle.loads(path.read_bytes()))
    random = np.random.default_rng([SEED, list(COUNTS).index(kind), index])
    of_scene, refused = kind in KINDS, 0
    while True:
        try:
            if of_scene:
                judgement = compare(short(judged_scene(kind, random)))
            else:
                given = judged_interface(kind.removesuffix(" interface"), random)
                judgement = compare(given, 2.0)
            break
        except (sf.SceneError, sf.TensionError):
            refused += 1
    case: Any = judgement.case
    runs = [replace(r, companion=None) for r in case.runs] if of_scene else [*case.simulations]
    FOLDER.mkdir(parents=True, exist_ok=True)
    part = path.with_suffix(".part")
    part.write_bytes(pickle.dumps((case.prediction, runs, refused)))
    part.rename(path)
    return Stored(case.prediction, runs, refused, judgement)


def short(scene: sf.Scene) -> sf.Scene:
    """Return a scene; SceneError if its comparison is announced to take longer than `LONGEST`."""
    prices, size = Prices(scene, None), planned(scene, snapshots=False)[1].resolution
    if prices.at(size)[0] + prices.comparing(size) > LONGEST:
        raise sf.SceneError("Its comparison takes too long for a trial.")
    return scene


def right_row(kind: str, index: int) -> Row:
    """Judge the right answer to a case."""
    case = stored(kind, index)
    judgement = case.judgement or case.judged()
    line: Row = {"kind": kind, "index": index, "refused": case.refused}
    line["verdict"] = judgement.verdict
    for name in ("slip", "slip rate"):
        bars = [row.bar for row in judgement.rows if row.kind == name and row.relative and row.bar]
        line[name] = bars[0] if bars else math.nan
    # a row is held against its bar if it has one, and no obstacle but that it is little beyond
    held = [
        row.over_bar
        for row in judgement.rows
        if row.bar and (row.verdict != UNRESOLVED or 1 < row.over_bar <= ALARM)
    ]
    line |= {"judged": len(held), "within": sum(bars <= 1 for bars in held)}
    line["said"] = "; ".join(
        f"{row.name} {row.over_bar:.2f} {row.verdict} {row.obstacle}"
        for row in judgement.rows
        if row.verdict != AGREES
    )
    return line


def alarms(rows: list[Row]) -> list[Row]:
    """Return what is said of right answers by kind, of scenes, of interfaces, and of all."""
    parts = {key: part for (key,), part in grouped(rows, "kind")}
    parts["scenes"] = [row for row in rows if row["kind"] in KINDS]
    parts["interfaces"] = [row for row in rows if row["kind"] not in KINDS]
    found = []
    for kind, part in (parts | {"all": rows}).items():
        if not part:
            continue
        verdicts = [row["verdict"] for row in part]
        false = verdicts.count(DIFFERS)
        line: Row = {"kind": kind, "cases": len(part), "refused": sum(r["refused"] for r in part)}
        line |= {verdict: verdicts.count(verdict) for verdict in (AGREES, UNRESOLVED, DIFFERS)}
        line["limit"] = upper_limit(false, len(part))
        line["within"] = sum(r["within"] for r in part) / max(1, sum(r["judged"] for r in part))
        for name in ("slip", "slip rate"):
            bars = [row[name] for row in part if not math.isnan(row[name])]
            line[f"bar_of_{name.replace(' ', '_')}"] = median(bars) if bars else math.nan
        found.append(line)
    return found


def upper_limit(count: int, trials: int) -> float:
    """Largest rate at which so few of the trials come about in one case of twenty."""
    if count >= trials:
        return 1.0
    return float(scipy.stats.beta.ppf(0.95, count + 1, trials - count))


def wrong_rows(kind: str, index: int) -> list[Row]:
    """Judge what is made wrong of a case whose right answer agrees.

    Sizes in bars of the right judgement are drawn evenly from the catchable ones, and from those
    beyond.
    """
    case, random = stored(kind, index), np.random.default_rng([SEED, index])
    truth = case.judged()
    if truth.verdict != AGREES or truth.rests:
        return []
    bars = {row.name: row.bar for row in truth.rows if row.verdict != UNRESOLVED}
    rows: list[Row] = []

    def row(mistake: str, place: str, effect: float, judgement: Judgement | None) -> None:
        line: Row = {"kind": kind, "index": index, "mistake": mistake, "place": place}
        line |= {"bars": effect, "verdict": "refused" if judgement is None else judgement.verdict}
        found = {r.name: r.bar for r in judgement.rows if r.kind in MOTION[:2]} if judgement else {}
        wider = (bar / known for name, bar in found.items() if bar and (known := bars.get(name)))
        rows.append(line | {"wider": max(wider, default=0.0)})

    exact = flawless(truth, case)
    makes, size = changes(case), 0.01
    for mistake, make in makes[0].items():
        effect = _effect(case.judged([make(exact, size), *case.simulations[1:]]).rows, bars)
        if not effect:
            continue
        for number, place in enumerate(("h", "2h", "4h")):
            for low, high in ((CATCHABLE, SURE), (SURE, MOST)):
                target = float(random.uniform(low, high))
                share = float(random.choice([-1, 1])) * size * target / effect
                runs = list(case.simulations)
                runs[number] = makes[number][mistake](runs[number], share)
                row(mistake, place, target, _caught(case, runs))
    run, coarser = case.simulations[0], case.simulations[1:]
    for mistake in random.permutation(np.array(bad.MISTAKES))[:6].tolist() if case.is_scene else ():
        other = bad.spoilt(mistake, case.prediction, run.time_step)
        if other is not None:
            effect = _effect(case.judged([exact, *coarser], other).rows, bars)
            row(mistake, "prediction", effect, case.judged(None, other))
    faults: Mapping[str, Callable[[Any], Any]] = bad.FAULTS if case.is_scene else bad.LINE_FAULTS
    for fault in random.permutation(np.array(list(faults)))[:3].tolist():
        broken, flawed = faults[fault](run), faults[fault](exact)
        if broken is None:
            continue
        judgement, effect = _caught(case, [broken, *coarser]), math.inf
        if judgement is not None:
            effect = _effect(case.judged([flawed or exact, *coarser]).rows, bars)
            laws = [line.over_bar for line in judgement.rows if line.kind == "law"]
            effect = max(effect, *laws)
        row(fault, "simulation", effect, judgement)
    return rows


def changes(case: Stored) -> list[dict[str, Callable[[Any, float], Any]]]:
    """Return what makes each of the runs wrong by a size, by name."""
    made = [dict(bad.RUNS[case.is_scene]) for _ in case.simulations]
    scene, run = bad.loaded(case.prediction.scene) if case.is_scene else None, case.simulations[0]
    if scene is not None:
        with suppress(sf.SceneError, sf.ComputationError):
            options = {"resolution": run.resolution, "damping": run.damping}
            more = with_companions(simulate(scene, run.end_time, **options))
            others = (more, *companions_of(more))
            for known, run, other in zip(made, case.simulations, others, strict=True):
                known["load"] = partial(bad.mixed, run, other)
    return made


def _caught(case: Stored, runs: list[Any]) -> Judgement | None:
    """Return what is said of runs; None if they are refused."""
    try:
        return case.judged(runs)
    except sf.DataFileError:
        return None


def _effect(rows: Sequence[JudgedRow], bars: Mapping[str, float | None]) -> float:
    """Return the largest difference over the bar of the right answer, or the row's own if it has a
    place.  A prediction at the nodes need not satisfy the laws of a simulation."""
    shares = (
        abs(row.difference) / bar
        for row in rows
        if row.difference is not None
        and row.kind != "law"
        and (bar := bars.get(row.name))
        and (bar := row.bar if row.place and row.bar else bar)
    )
    return max(shares, default=0.0)


def flawless(truth: Judgement, case: Stored) -> Any:
    """Return a simulation that shows the prediction at its nodes and levels."""
    run, prediction = case.simulations[0], case.prediction
    if not case.is_scene:
        names = ("slip", "slip_rate", "shear_traction", "pressure", "gap")
        known = {n: prediction.at(getattr(prediction.interface, n), run.x) for n in names}
        return replace(run, **{name: np.nan_to_num(now) for name, now in known.items()})
    path, work = truth.case.worn_at_nodes
    run = replace(run, interface=truth.case.at_nodes, final_path=path, final_work_density=work)
    predict = getattr(prediction, "slot_velocity", None)
    if predict is None:
        return run
    along, across = predict(run.slot.x, run.slot.t[:, None])
    return replace(run, slot=replace(run.slot, velocity_x=along, velocity_y=across))


def power(rows: list[Row]) -> list[Row]:
    """Return what is said of mistakes by what is wrong and by size in bars."""
    found = []
    for (place,), group in grouped(rows, "place"):
        for low in (CATCHABLE, SURE):
            sized = [row for row in group if row["bars"] >= low]
            part = [row for row in sized if (row["bars"] >= SURE) == (low == SURE)]
            if not part:
                continue
            said = [row["verdict"] for row in part]
            line: Row = {"wrong": place, "bars_from": low, "tried": len(part)}
            line |= {name: said.count(name) for name in (DIFFERS, UNRESOLVED, "refused", AGREES)}
            line["wider"] = sum(r["verdict"] == AGREES and r["wider"] > WIDER for r in part)
            found.append(line | {"caught": 1 - said.count(AGREES) / len(part)})
    return found


def points(quick: bool, every: int = 1) -> list[Point]:
    """Return all cases, or the second of every few; the first of each kind for a quick look."""
    counts = {kind: 1 if quick else count for kind, count in COUNTS.items()}
    first = 0 if quick or every == 1 else 1
    return [
        (kind, FIRST.get(kind, 0) + index)
        for kind, count in counts.items()
        for index in range(first, count, every)
    ]


STUDIES = [
    Study("judge-right", points, right_row, alarms),
    Study("judge-wrong", partial(points, every=5), wrong_rows, power),
]

if __name__ == "__main__":
    raise SystemExit(main("docs.studies.trials.judge", STUDIES))
