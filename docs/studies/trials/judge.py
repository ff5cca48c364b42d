"""How far the judge of comparisons can be trusted: right answers, and answers that are wrong.

``python -m docs.studies.trials.judge judge-right --workers 2`` simulates random scenes on the mesh
that `slipfront compare` chooses, and judges their right answers: what differs is a false alarm.
`judge-wrong` judges what can be made wrong of the answers to some scenes, and of the simulations.
How far a mistake moves a row is known without the simulation: the right answer at the nodes is put
in its place.  Beyond 1.5 bars a mistake ought to be caught, beyond 2.5 it has to be.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import scipy

import semianalytic as sf
from compare.comparison.judgement import Judgement, judge
from compare.comparison.prediction import planned, predict_like
from compare.comparison.rows import ALARM, DIFFERS, UNRESOLVED
from compare.comparison.rows import Row as JudgedRow
from docs.studies.runner import Point, Row, Study, grouped, main
from docs.studies.trials.draws import KINDS, STEPS, judged_scene
from docs.studies.trials.wrong_answers import FAULTS, MISTAKES, spoilt
from fem import Simulation, simulate, with_companions
from semianalytic.dissimilar_slot.solution import PairSolution
from semianalytic.results.answer import Answer

COUNTS: Mapping[str, int] = {**dict.fromkeys(KINDS, 40), STEPS: 90}
"""Scenes of each kind."""
SEED, POWER_SEED = 25, 15
NAMED = "remote-shock preloaded auxetic pressure-drop lift-off lift-off-shear tap ramp unload pulse"
DRAWN = (0, 1, 3, 5, 9, 10)
CATCHABLE, SURE = 1.5, 2.5
LAW = "law"
"""Kind of the rows for laws that a simulation has to satisfy by itself."""
TRUTH = "none"
QUICK_RESOLUTION = 40
CONFIDENCE = 0.95


def simulated(
    scene: sf.Scene, resolution: int | None
) -> tuple[Simulation, sf.Solution | PairSolution | sf.Marched]:
    """Return a simulation with its companions as `slipfront compare` has it, and the prediction."""
    prediction, choice = planned(scene, snapshots=True, resolution=resolution)
    run = with_companions(simulate(scene, resolution=choice.resolution, tell=lambda _: None))
    return run, prediction or predict_like(run)


def right_rows(group: str, index: int, resolution: int | None) -> list[Row]:
    """Judge the right answer to the first scene of a draw that can be simulated and predicted."""
    random = np.random.default_rng([SEED, index, list(KINDS).index(group)])
    while True:
        try:
            run, prediction = simulated(judged_scene(group, random), resolution)
            judgement = judge(prediction, run)
            break
        except sf.SceneError:
            continue
    rows: list[Row] = []
    for row in judgement.rows:
        # a row is held against its bar if it has one, and no obstacle
        barred = row.difference is not None and row.bar is not None
        held = barred and (row.verdict != UNRESOLVED or 1 < row.over_bar <= ALARM)
        line: Row = {"group": group, "index": index, "judgement": judgement.verdict}
        line |= {"kind": row.kind, "name": row.name, "verdict": row.verdict}
        rows.append(line | {"bars": row.over_bar if held else math.nan})
    return rows


def alarms(rows: list[Row]) -> list[Row]:
    """Return false alarms and how many rows lie within their bars, by group and of all.

    `rate` is the upper 95 % limit of the share of scenes that are said to differ.
    """
    found = []
    for group in (*dict.fromkeys(row["group"] for row in rows), "all"):
        part = [row for row in rows if group in (row["group"], "all")]
        scenes = {(row["group"], row["index"]): row["judgement"] for row in part}
        false = sum(verdict == DIFFERS for verdict in scenes.values())
        bars = np.array([row["bars"] for row in part if not math.isnan(row["bars"])])
        agree = sum(verdict == "agrees" for verdict in scenes.values())
        verdicts = [row["verdict"] for row in part]
        line: Row = {"group": group, "scenes": len(scenes), "rows": len(part)}
        line |= {"false_rows": verdicts.count(DIFFERS), "false_scenes": false}
        line |= {"rate": upper_limit(false, len(scenes)), "agreeing_scenes": agree / len(scenes)}
        line |= {"unresolved_rows": verdicts.count(UNRESOLVED) / len(part)}
        line |= {"within": float(np.mean(bars <= 1)), "within_half": float(np.mean(bars <= 0.5))}
        found.append(line)
    return found


def upper_limit(count: int, trials: int) -> float:
    """Largest rate at which so few of the trials, or fewer, come about in one case out of twenty
    (Clopper and Pearson)."""
    if count >= trials:
        return 1.0
    return float(scipy.stats.beta.ppf(CONFIDENCE, count + 1, trials - count))


def wrong_rows(name: str, resolution: int | None) -> list[Row]:
    """Judge the right answer to a scene, all that is made wrong of it, and simulations at fault."""
    kind, _, number = name.partition(" ")
    random = np.random.default_rng([POWER_SEED, int(number or 0)])
    scene = judged_scene(STEPS, random) if kind == "drawn" else sf.find(name)
    run, right = simulated(scene, resolution)
    truth = judge(right, run)
    exact = _flawless(truth)
    bars = {row.name: row.bar for row in truth.rows if row.verdict != UNRESOLVED}
    rows: list[Row] = [
        {"scene": name, "mistake": TRUTH, "bars": 0.0, "verdict": truth.verdict, "by": ""}
    ]
    for mistake in MISTAKES:
        wrong: Answer | None = spoilt(mistake, right, run.time_step)
        if wrong is not None:
            effect = _effect(judge(wrong, exact).rows, bars)
            rows.append(_row(name, mistake, effect, judge(wrong, run)))
    for fault, make in FAULTS.items():
        broken = make(run)
        if broken is None:
            continue
        try:
            judgement = judge(right, broken)
        except sf.DataFileError:
            rows.append(rows[0] | {"mistake": fault, "bars": math.inf, "verdict": "refused"})
            continue
        effect = _effect(judge(right, make(exact) or exact).rows, bars)
        laws = [row.over_bar for row in judgement.rows if row.kind == LAW]
        rows.append(_row(name, fault, max(effect, *laws), judgement))
    return rows


def _row(scene: str, mistake: str, effect: float, judgement: Judgement) -> Row:
    by = "; ".join(dict.fromkeys(row.kind for row in judgement.having(DIFFERS)))
    row = {"scene": scene, "mistake": mistake, "bars": effect}
    return {**row, "verdict": judgement.verdict, "by": by}


def _effect(rows: Sequence[JudgedRow], bars: Mapping[str, float | None]) -> float:
    """Return the largest difference over the bar of the right answer, or the row's own if it has a
    place.  A prediction at the nodes need not satisfy the laws of a simulation."""
    shares = (
        abs(row.difference) / bar
        for row in rows
        if row.difference is not None
        and row.kind != LAW
        and (bar := bars.get(row.name))
        and (bar := row.bar if row.place and row.bar else bar)
    )
    return max(shares, default=0.0)


def _flawless(truth: Judgement) -> Simulation:
    """Return a simulation that shows the prediction at its nodes and levels."""
    case = truth.case
    path, work = case.worn_at_nodes
    run = replace(
        case.simulation, interface=case.at_nodes, final_path=path, final_work_density=work
    )
    predict = getattr(case.prediction, "slot_velocity", None)
    if predict is None:
        return run
    along, across = predict(run.slot.x, run.slot.t[:, None])
    return replace(run, slot=replace(run.slot, velocity_x=along, velocity_y=across))


def power(rows: list[Row]) -> list[Row]:
    """Return how often each mistake is caught: of all, beyond 1.5 bars, and beyond 2.5 bars.

    Scenes in which the right answer is said to differ are left out.
    """
    false = {row["scene"] for row in rows if (row["mistake"], row["verdict"]) == (TRUTH, DIFFERS)}
    found = []
    for (mistake,), group in grouped([row for row in rows if row["mistake"] != TRUTH], "mistake"):
        tried = [row for row in group if row["scene"] not in false]
        line: Row = {"mistake": mistake}
        for name, least in (("", -1.0), ("_beyond", CATCHABLE), ("_sure", SURE)):
            part = [row for row in tried if row["bars"] > least]
            caught = [row["verdict"] in (DIFFERS, "refused") for row in part]
            share = float(np.mean(caught)) if part else math.nan
            line |= {f"scenes{name}": len(part), f"caught{name}": share}
        found.append(line)
    return found


def right_points(quick: bool) -> list[Point]:
    """Return the numbers of all draws; the first two of each kind for a quick look."""
    resolution = QUICK_RESOLUTION if quick else None
    return [
        (group, index, resolution)
        for group, count in COUNTS.items()
        for index in range(2 if quick else count)
    ]


def wrong_points(quick: bool) -> list[Point]:
    """Return the names of all scenes; the first two for a quick look."""
    names = [*NAMED.split(), "harmonic", *(f"drawn {index}" for index in DRAWN)]
    return [(name, QUICK_RESOLUTION if quick else None) for name in names[: 2 if quick else None]]


STUDIES = [
    Study("judge-right", right_points, right_rows, alarms),
    Study("judge-wrong", wrong_points, wrong_rows, power),
]

if __name__ == "__main__":
    raise SystemExit(main("docs.studies.trials.judge", STUDIES))
