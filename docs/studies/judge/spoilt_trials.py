"""Trials of spoilt answers: what a judge says of mistakes whose effect is known beforehand."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from compare.comparison.judgement import Judgement, judge
from compare.comparison.rows import DIFFERS, UNRESOLVED, Row
from docs.studies.judge.faults import FAULTS, Fault
from docs.studies.judge.right_trials import simulated, window_of
from docs.studies.judge.rows import SpoiltRow
from docs.studies.judge.scenes import (
    power_scenes,
)
from docs.studies.judge.spoils import SPOILS, Spoil, Window, effect, spoilt
from semianalytic import Answer, DataFileError

if TYPE_CHECKING:
    from fem import Simulation

SHARES = (0.25, 0.35, 0.5, 0.7, 1.0, 1.4, 2.0, 2.8, 4.0, 5.6, 8.0)
"""Sizes of a spoil that are tried, over the usual one."""
MIDDLE = 2.0
"""Effect, over the bar, about which the sizes of a spoil are chosen; the verdict has no part in it,
so that what is caught decides nothing about what is tried."""
TRUTH = "none"
"""Name of the right answer among the spoils."""
LAW = "law"
"""Kind of the rows for laws that a simulation has to satisfy by itself."""
REFUSED = "refused"
"""Verdict on a simulation that the judge refuses."""


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
