"""Trials of right answers: random scenes are simulated, predicted and judged."""

from __future__ import annotations

import math
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np

from compare.comparison.comparing import held_against, planned
from compare.comparison.prediction import predict_like
from docs.studies.judge.rows import JudgedRow
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
)
from docs.studies.judge.spoils import Window
from semianalytic import Marched, PairSolution, Scene, SceneError, Solution

if TYPE_CHECKING:
    from fem import Simulation

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
WHOLE = 8
"""Field snapshots, which take most of the time, are judged for one scene in this many."""


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
