"""Trials of the judge: right answers to random scenes, and spoilt answers to chosen ones."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from compare.comparison.comparing import held_against, planned
from compare.comparison.judgement import Judgement, judge
from compare.comparison.prediction import predict_like
from compare.comparison.rows import ALARM, DIFFERS, UNRESOLVED, Row
from compare.output.tables import append_rows, started_rows
from compare.tasks.workers import Progress, run_tasks
from compare.tasks.workers import Task as WorkerTask
from docs.studies.judge.faults import FAULTS, Fault
from docs.studies.judge.scenes import (
    HISTORIES,
    MAP_SIZE,
    MAPS,
    METRES,
    NEAR,
    OPENINGS,
    OUT_OF_PLANE,
    STEPS,
    VISCOUS,
    Draw,
    draw,
    map_scene,
    power_scenes,
)
from docs.studies.judge.spoils import SPOILS, Spoil, Window, effect, spoilt
from semianalytic import Answer, DataFileError, Marched, PairSolution, Scene, SceneError, Solution

if TYPE_CHECKING:
    from fem import Simulation

SEED = 25
COUNTS = {
    STEPS: 90,
    HISTORIES: 50,
    OPENINGS: 50,
    NEAR: 30,
    VISCOUS: 25,
    OUT_OF_PLANE: 30,
    METRES: 25,
    **dict.fromkeys(MAPS, MAP_SIZE**2),
}
QUICK_COUNTS = {
    STEPS: 6,
    HISTORIES: 2,
    OPENINGS: 3,
    NEAR: 2,
    VISCOUS: 1,
    OUT_OF_PLANE: 1,
    METRES: 1,
}
QUICK_RESOLUTION = 40
WHOLE = 8
"""Field snapshots, which take most of the time, are judged for one scene in this many."""
SHARES = (0.25, 0.35, 0.5, 0.7, 1.0, 1.4, 2.0, 2.8, 4.0, 5.6, 8.0)
"""Sizes of a spoil that are tried, over the usual one."""
MIDDLE = 2.0
"""Effect, over the bar, about which the sizes of a spoil are chosen; the verdict has no part in it,
so that what is caught decides nothing about what is tried."""
QUICK_POWER = 2
TRUTH = "none"
"""Name of the right answer among the spoils."""
LAW = "law"
"""Kind of the rows for laws that a simulation has to satisfy by itself."""
REFUSED = "refused"
"""Verdict on a simulation that the judge refuses."""


@dataclass(frozen=True)
class JudgedRow:
    """A row of a judgement of the right answer, of a random scene.

    Attributes
    ----------
    group : str, kind of the draw, or the named scene that a map is around
    index : int, which seeds the draw, or is the place on the map
    of : int, rows of the scene, all of which have to be there
    refusals : int, draws before it that had no answer
    resolution : int, of the mesh that was chosen
    whole : bool, whether field snapshots were judged too
    seconds : what the scene took [s]
    judgement : verdict on the scene
    name, kind, unit : as in the judgement
    exact, difference, bar : nan where there is none
    relative : bool, whether the last two are over the norm of the prediction
    verdict : "agrees", "differs" or "unresolved"
    """

    group: str
    index: int
    of: int
    refusals: int
    resolution: int
    whole: bool
    seconds: float
    judgement: str
    name: str
    kind: str
    unit: str
    exact: float
    difference: float
    bar: float
    relative: bool
    verdict: str

    @property
    def share(self) -> float:
        """The bar over what is compared; nan where that is nothing or has no value of its own."""
        if self.relative:
            return self.bar
        return self.bar / abs(self.exact) if self.exact else math.nan

    @property
    def tells(self) -> bool:
        """Whether the row is held against its bar: it has one, and no obstacle."""
        barred = math.isfinite(self.difference) and math.isfinite(self.bar)
        return barred and (self.verdict != UNRESOLVED or 1 < self.over_bar <= ALARM)

    @property
    def over_bar(self) -> float:
        """|difference| over the bar; 0 of nothing."""
        if not self.difference:
            return 0.0
        return abs(self.difference) / self.bar if self.bar else math.inf


@dataclass(frozen=True)
class SpoiltRow:
    """A judgement of a spoilt answer.

    Attributes
    ----------
    scene : str
    index : int
    of : int, rows of the scene
    spoil : str, or "none" for the right answer
    share : float, of the usual size of the mistake
    slip_rate, shear_traction : relative L1 effect on either, over x and t
    over_bar : float, effect read at the nodes over the bar of the row, where that is most
    verdict : str
    by : str, kinds of the rows that differ
    """

    scene: str
    index: int
    of: int
    spoil: str
    share: float
    slip_rate: float
    shear_traction: float
    over_bar: float
    verdict: str
    by: str


def simulated(
    scene: Scene, resolution: int | None = None, snapshots: Path | None = None
) -> tuple[Simulation, Solution | PairSolution | Marched]:
    """A simulation on the mesh that `slipfront compare` takes by itself, and the prediction.

    Parameters
    ----------
    scene : Scene
    resolution : int, optional
        Another mesh.
    snapshots : Path, optional
        Folder for field snapshots.  The mesh is that of a comparison with them in any case.

    Raises
    ------
    SlipfrontError
        As the command.
    """
    from fem import simulate, with_companions

    prediction, choice = planned(scene, snapshots=True, resolution=resolution)
    # what its mesh is too coarse for is left to the judge; of frames it looks at the last alone
    fineness = choice.resolution
    run = simulate(scene, resolution=fineness, frames=1, snapshots=snapshots, tell=_unheard)
    carrying = with_companions(run, snapshots=snapshots)
    return carrying, prediction or predict_like(carrying)


def _unheard(_: str) -> None:
    pass


def window_of(simulation: Simulation) -> Window:
    """Return the times and the reach on the contact over which a simulation is judged."""
    reach = float(simulation.interface.x[-1]) + simulation.element_size
    return Window(simulation.end_time, simulation.time_step, reach)


def judged_rows(
    group: str, seed: int, index: int, resolution: int | None = None
) -> list[JudgedRow]:
    """Judge the right answer to the first scene of a draw that can be simulated and predicted, or
    to a place on a map."""
    random, began = np.random.default_rng([seed, index, list(COUNTS).index(group)]), perf_counter()
    whole, refusals = index % WHOLE == 0, 0
    with TemporaryDirectory() as folder:
        snapshots = Path(folder) if whole else None
        while True:
            drawn = Draw(map_scene(group, index), 0) if group in MAPS else draw(group, random)
            refusals += drawn.refusals
            try:
                simulation, right = simulated(drawn.scene, resolution, snapshots)
                break
            except SceneError:
                if group in MAPS:
                    raise
                refusals += 1
        judgement = held_against(simulation, right, snapshots)
    seconds = perf_counter() - began
    return [
        JudgedRow(
            group=group,
            index=index,
            of=len(judgement.rows),
            refusals=refusals,
            resolution=simulation.resolution,
            whole=whole,
            seconds=seconds,
            judgement=judgement.verdict,
            name=row.name,
            kind=row.kind,
            unit=row.unit,
            exact=_number(row.at_nodes if row.exact is None else row.exact),
            difference=_number(row.difference),
            bar=_number(row.bar),
            relative=row.relative,
            verdict=row.verdict,
        )
        for row in judgement.rows
    ]


def _number(value: float | None) -> float:
    return math.nan if value is None else float(value)


def spoilt_rows(
    scene_name: str, index: int, resolution: int | None, bisect: bool
) -> list[SpoiltRow]:
    """Judge the right answer to a scene, all that can be made wrong of it, and the simulation with
    faults in it.

    A spoil that has a size is made larger or smaller until two neighbours in `SHARES` have effects
    on either side of `MIDDLE`, if `bisect`.
    """
    trial = _Trial.of(*simulated(power_scenes()[scene_name], resolution))
    tried: list[tuple[str, float, _Outcome]] = [(TRUTH, 0.0, trial.outcome(trial.right))]
    for spoil in SPOILS:
        outcomes = trial.searched(spoil, SHARES if bisect and spoil.size else (1.0,))
        tried += [(spoil.name, share, outcome) for share, outcome in outcomes.items()]
    for fault in FAULTS:
        at_fault = trial.at_fault(fault)
        tried += [] if at_fault is None else [(fault.name, 1.0, at_fault)]
    return [
        SpoiltRow(scene_name, index, len(tried), name, share, *outcome)
        for name, share, outcome in tried
    ]


class _Outcome(NamedTuple):
    """Effect and verdict of one trial; the fields are those of `SpoiltRow`."""

    slip_rate: float
    shear_traction: float
    over_bar: float
    verdict: str
    by: str


@dataclass(frozen=True, eq=False)
class _Trial:
    """A simulation, the right answer to it, and what the judge says where nothing is simulated.

    Attributes
    ----------
    simulation, right, window
    flawless : Simulation
        The right answer in the place of what was simulated.
    bars : dict
        Of the judgement of the right answer, by the name of the row; of rows that tell.
    """

    simulation: Simulation
    right: Answer
    window: Window
    flawless: Simulation
    bars: Mapping[str, float | None]

    @classmethod
    def of(cls, simulation: Simulation, right: Answer) -> _Trial:
        judgement = judge(right, simulation)
        bars = {row.name: row.bar for row in judgement.rows if row.verdict != UNRESOLVED}
        return cls(simulation, right, window_of(simulation), flawless(judgement), bars)

    def outcome(self, answer: Answer) -> _Outcome:
        """Judge an answer against the simulation and measure how far it is from the right one."""
        judgement = judge(answer, self.simulation)
        x, t = self.simulation.interface.x, self.window.end_time * np.linspace(0.2, 1.0, 9)
        return _Outcome(
            slip_rate=effect("slip_rate", answer, self.right, x, t),
            shear_traction=effect("shear_traction", answer, self.right, x, t),
            over_bar=self.over_bar(answer),
            verdict=judgement.verdict,
            by=_differing(judgement),
        )

    def over_bar(self, answer: Answer) -> float:
        """How far an answer is from the right one, over the bar, in the row where that is most."""
        return self._most(judge(answer, self.flawless).rows)

    def _most(self, rows: Sequence[Row]) -> float:
        """Return the largest difference over the bar of the right answer, or over the row's own bar
        if the row has a place.  Laws that a simulation has to satisfy by itself are left out, since
        a prediction at its nodes need not satisfy them."""
        shares = (
            abs(row.difference) / bar
            for row in rows
            if row.difference is not None
            and row.kind != LAW
            and (bar := self.bars.get(row.name))
            and (bar := row.bar if row.place and row.bar else bar)
        )
        return max(shares, default=0.0)

    def at_fault(self, fault: Fault) -> _Outcome | None:
        """Judge the right answer on the simulation with a fault; None if it changes nothing."""
        spoilt_one = fault.make(self.simulation)
        if spoilt_one is None:
            return None
        try:
            judgement = judge(self.right, spoilt_one)
        except DataFileError:
            return _Outcome(0.0, 0.0, math.inf, REFUSED, "")
        flawless_one = fault.make(self.flawless)
        over_bar = self._most(judge(self.right, flawless_one or self.flawless).rows)
        laws = [row.over_bar for row in judgement.rows if row.kind == LAW]
        return _Outcome(0.0, 0.0, max(over_bar, *laws), judgement.verdict, _differing(judgement))

    def searched(self, spoil: Spoil, shares: Sequence[float]) -> dict[float, _Outcome]:
        """Outcomes by share, of the usual one and those that bisect for an effect of `MIDDLE`."""
        outcomes: dict[float, _Outcome] = {}
        least, most, middle = 0, len(shares), shares.index(1.0)
        while least < most:
            answer = spoilt(spoil, self.right, self.window, shares[middle])
            if answer is None:
                most = middle
            else:
                outcomes[shares[middle]] = outcome = self.outcome(answer)
                if outcome.over_bar > MIDDLE:
                    most = middle
                else:
                    least = middle + 1
            middle = (least + most) // 2
        return outcomes


def _differing(judgement: Judgement) -> str:
    """Kinds of the rows that differ."""
    return "; ".join(dict.fromkeys(row.kind for row in judgement.having(DIFFERS)))


def flawless(judgement: Judgement) -> Simulation:
    """A simulation that shows the prediction at its nodes and levels, its companions left."""
    case = judgement.case
    path, work = case.worn_at_nodes
    run = replace(
        case.simulation, interface=case.at_nodes, final_path=path, final_work_density=work
    )
    predict = getattr(case.prediction, "slot_velocity", None)
    if predict is None:
        return run
    along, across = predict(run.slot.x, run.slot.t[:, None])
    return replace(run, slot=replace(run.slot, velocity_x=along, velocity_y=across))


_JUDGED, _SPOILT = "judged", "spoilt"
_Key = tuple[str, str, int]
"""Kind, group or scene, and index of a trial: two scenes have the name of a map each."""


def run_trials(
    directory: Path, quick: bool = False, progress: Progress | None = None, client: Any = None
) -> tuple[list[JudgedRow], list[SpoiltRow]]:
    """All rows, those of an earlier run included; two tables in a folder.

    Raises
    ------
    DataFileError
        If a table cannot be written.
    """
    directory.mkdir(parents=True, exist_ok=True)
    counts = QUICK_COUNTS if quick else COUNTS
    names = list(power_scenes())[: QUICK_POWER if quick else None]
    resolution = QUICK_RESOLUTION if quick else None
    wanted: dict[_Key, WorkerTask] = {
        (_SPOILT, name, index): (spoilt_rows, (name, index, resolution, not quick))
        for index, name in enumerate(names)
    }
    wanted |= {
        (_JUDGED, group, index): (judged_rows, (group, SEED, index, resolution))
        for group, count in counts.items()
        for index in range(count)
    }
    # by index: whatever part of them is done is one of all groups
    tasks = dict(sorted(wanted.items(), key=lambda task: task[0][2]))
    part = "-quick" if quick else ""
    tables = {
        SpoiltRow: directory / f"judge-spoilt{part}.csv",
        JudgedRow: directory / f"judge-rows{part}.csv",
    }
    kept = {kind: _whole(started_rows(table, kind)) for kind, table in tables.items()}
    known = {_trial_of(row) for rows in kept.values() for row in rows}
    left = [key for key in tasks if key not in known]
    for _, rows in run_tasks([tasks[key] for key in left], None, progress, client):
        append_rows(tables[type(rows[0])], rows)
        kept[type(rows[0])] += rows
    judged, spoiled = (
        sorted((row for row in kept[kind] if _trial_of(row) in tasks), key=_trial_of)
        for kind in (JudgedRow, SpoiltRow)
    )
    return judged, spoiled


def _trial_of(row: JudgedRow | SpoiltRow) -> _Key:
    """Return the trial that a row belongs to: its kind, its group or scene, and its index."""
    if isinstance(row, JudgedRow):
        return _JUDGED, row.group, row.index
    return _SPOILT, row.scene, row.index


def _whole(rows: list[Any]) -> list[Any]:
    """Rows of those trials of which all are there."""
    counts = Counter(map(_trial_of, rows))
    return [row for row in rows if counts[_trial_of(row)] == row.of]
