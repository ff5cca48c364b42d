"""Error bars of the finite elements under waves at an angle and moving loads, on random scenes.

``python -m docs.studies.judge.fronts`` judges 40 scenes against their exact answers.  Rows are
appended to results/fronts/trials.csv as they come, so that the study goes on where it ended;
docs/data/judge-fronts.csv is their summary.  Each scene has its own random numbers.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from compare.comparison.comparing import held_against
from compare.output.tables import append_rows, sound_rows, started_rows, write_rows
from fem import simulate, with_companions
from semianalytic import (
    IncidentWave,
    Material,
    MovingLoad,
    Scene,
    SceneError,
    Solution,
    Tractions,
    solve,
)

COUNT, SEED, RESOLUTION = 40, 29, 60
LOADS = ("P", "SV", "SH", "moving")
TRIALS = Path("results", "fronts", "trials.csv")
BARS = Path("docs", "data", "judge-fronts.csv")
COMMAND = "python -m docs.studies.judge.fronts"


@dataclass(frozen=True)
class TrialRow:
    """One quantity of one scene.

    Attributes
    ----------
    trial : int
        Number of the scene.
    load : str
        One of `LOADS`.
    slowness : float
        Slowness of the front along x, times c_t.
    scene : str
        The scene in one line.
    kind, row : str
        Kind of the quantity as in `compare.comparison.rows.Row`, and its name.
    bars : float
        |difference| over the error bar; nan without a bar.
    verdict : str
        "agrees", "differs" or "unresolved".
    undecided : bool
        Whether the judge says that this mesh cannot decide the row, whatever its difference.
    """

    trial: int
    load: str
    slowness: float
    scene: str
    kind: str
    row: str
    bars: float
    verdict: str
    undecided: bool


@dataclass(frozen=True)
class BarRow:
    """The rows of all scenes of one load.

    Attributes
    ----------
    load : str
        One of `LOADS`, or "all".
    scenes, rows, undecided : int
        Scenes; their rows that the mesh can decide, and those that it cannot.
    within : float
        Share of the former whose difference lies within the bar.
    most : float
        Largest |difference| over its bar among them.
    differing : int
        Scenes on which the judge says "differs".
    """

    load: str
    scenes: int
    rows: int
    undecided: int
    within: float
    most: float
    differing: int


def drawn(trial: int) -> tuple[Scene, Solution]:
    """Return the scene of a number, in which something slips, and its exact answer."""
    rng, kind = np.random.default_rng([SEED, trial]), LOADS[trial % len(LOADS)]
    while True:
        solid = Material(1.0, 1.0, float(rng.uniform(0.0, 0.45)))
        friction = float(rng.uniform(0.2, 0.9))
        base = Tractions(1.0, float(rng.uniform(-0.5, 0.5)) * friction)
        sign, amount = float(rng.choice([-1.0, 1.0])), float(rng.uniform(0.1, 1.2))
        load: IncidentWave | MovingLoad
        if kind == "moving":
            speed, pressure = float(np.exp(rng.uniform(-1.2, 1.4))), float(rng.uniform(-0.3, 0.5))
            load = MovingLoad(speed, pressure, sign * amount)
        else:
            side = str(rng.choice(["below", "above"]))
            angle = float(rng.uniform(-80.0, -5.0))
            load = IncidentWave(kind, angle, stress=sign * amount, from_=side)
        mode = "antiplane" if kind == "SH" else "in-plane"
        try:
            scene = Scene(solid, friction, base, load, mode=mode)
            answer = solve(scene)
        except SceneError:  # it slips behind the front, or the wave alone opens the contact
            continue
        if answer.zones and max(zone.outer for zone in answer.zones) > 0.1:
            return scene, answer


def judged(trial: int) -> Iterator[TrialRow]:
    """Yield the judged quantities of the scene of a number."""
    scene, answer = drawn(trial)
    judgement = held_against(with_companions(simulate(scene, resolution=RESOLUTION)), answer)
    kind, slowness = LOADS[trial % len(LOADS)], scene.front_slowness * scene.material.shear_speed
    for row in judgement.rows:
        bars = np.nan
        if row.bar and row.difference is not None:
            bars = abs(row.difference) / row.bar
        names = repr(scene), row.kind, row.name
        yield TrialRow(trial, kind, slowness, *names, float(bars), row.verdict, bool(row.obstacle))


def summary(rows: Sequence[TrialRow]) -> list[BarRow]:
    """Return the summary of rows by load, and of all."""
    found = []
    for load in (*LOADS, "all"):
        part = [row for row in rows if load in (row.load, "all")]
        known = np.array([row.bars for row in part if not row.undecided])
        known = known[np.isfinite(known)]
        differing = {row.trial for row in part if row.verdict == "differs"}
        scenes = len({row.trial for row in part})
        within = float(np.mean(known <= 1)) if len(known) else np.nan
        most = float(known.max()) if len(known) else np.nan
        found.append(
            BarRow(load, scenes, len(known), len(part) - len(known), within, most, len(differing))
        )
    return found


def main(trials: Path = TRIALS, bars: Path = BARS, count: int = COUNT) -> list[BarRow]:
    """Judge the scenes that are missing in a file of trials; return and write the summary."""
    trials.parent.mkdir(parents=True, exist_ok=True)
    done = {row.trial for row in started_rows(trials, TrialRow)}
    for trial in range(count):
        if trial not in done:
            rows = list(judged(trial))
            append_rows(trials, rows)
            most = max((row.bars for row in rows if np.isfinite(row.bars)), default=np.nan)
            print(
                f"{trial}: {rows[0].load}, p = {rows[0].slowness:.3f}, {most:.2f} bars", flush=True
            )
    found = summary(sound_rows(trials, TrialRow))
    write_rows(bars, found, command=COMMAND)
    return found


if __name__ == "__main__":
    print(*main(), sep="\n")
