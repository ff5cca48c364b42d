"""A prediction sampled where a simulation was recorded, by the solver its scene calls for."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from semianalytic import InterfaceHistory, Marched, Scene, Solution, march, solve
from semianalytic.prediction import chosen_method
from semianalytic.scene.errors import SceneError
from semianalytic.selfsimilar.load import check_pressure
from semianalytic.spacetime.resolution import advice, nodes_for_loads
from semianalytic.spacetime.tuning import MOST_NODES

if TYPE_CHECKING:
    from fem import Simulation

Array = NDArray[np.float64]

FINER = 4
"""Nodes of a march per element of the simulation."""

CURVE_POINTS = 1500
"""Places at which a self-similar slip rate is drawn."""


@dataclass(frozen=True, eq=False)
class Prediction:
    """What a semi-analytic solver says of the contact nodes of a simulation, x > 0.

    Attributes
    ----------
    method : str
        "self-similar" or "space-time".
    answer : Solution or Marched
        What was computed.
    interface : InterfaceHistory
        At the nodes x > 0 and the times of the simulation.
    final_path : (n,) array
        Accumulated |slip| at the end [length].
    final_work_density : (n,) array
        Work per area taken by friction until the end [stress length].
    seconds : float
        What it took to compute.
    caution : str
        What a march was too coarse for; "" if nothing is known.
    """

    method: str
    answer: Solution | Marched
    interface: InterfaceHistory
    final_path: Array
    final_work_density: Array
    seconds: float
    caution: str = ""

    @property
    def solution(self) -> Solution | None:
        """The self-similar solution, where that is the method."""
        return self.answer if isinstance(self.answer, Solution) else None

    def curve(self, time: float) -> tuple[Array, Array]:
        """Positions and slip rates there (n,), as fine as the answer itself is known."""
        if isinstance(self.answer, Solution):
            end = self.interface.x[-1]
            x = np.linspace(end / CURVE_POINTS, end, CURVE_POINTS)
            return x, self.answer.slip_rate(x, time)
        x = self.answer.interface.x
        return x, self.answer.slip_rate(x, time)


def check_predictable(scene: Scene, method: str = "auto") -> None:
    """Raise what `prediction_at_nodes` would, as far as that is known without solving a scene.

    Raises
    ------
    SceneError
        If the method does not apply to the scene.
    TensionError
        If the pressure of a self-similar scene turns tensile.
    """
    if chosen_method(scene, method) == "self-similar":
        check_pressure(scene)


def prediction_at_nodes(
    simulation: Simulation,
    method: str = "auto",
    progress: Callable[[int, int], None] | None = None,
) -> Prediction:
    """Predict what a simulation recorded.

    Parameters
    ----------
    simulation : Simulation
        Its scene, end time, nodes and times are used, and none of its results.
    method : str
        "auto", "self-similar" or "space-time".
    progress : callable, optional
        Called with (step, steps) during a march.

    Raises
    ------
    SceneError
        If the method does not apply to the scene, or a march cannot follow its loads.
    TensionError
        If the pressure turns tensile, so that neither solver applies.
    ComputationError
        If a march fails.
    """
    x, t = simulation.contact.x, simulation.contact.t
    chosen = chosen_method(simulation.scene, method)
    if chosen == "self-similar":
        solution = solve(simulation.scene)
        whole = solution.history(x, t)
        seconds = sum(solution.statistics.seconds.values())
        worn = solution.path(x, t[-1]), solution.work_density(x, t[-1])
        return Prediction(chosen, solution, whole, *worn, seconds)
    marched = _marched(simulation, float(x[-1]), float(t[-1]), progress)
    own = marched.interface
    return Prediction(
        chosen,
        marched,
        marched.history(x, t),
        np.interp(x, own.x, marched.final_path),
        np.interp(x, own.x, marched.final_work_density),
        sum(marched.statistics.seconds.values()),
        advice(marched.shortfalls, "resolution"),
    )


def _marched(
    simulation: Simulation,
    reach: float,
    end_time: float,
    progress: Callable[[int, int], None] | None,
) -> Marched:
    """A march as far and as long as a simulation was recorded, on finer nodes."""
    scene, spacing = simulation.scene, simulation.element_size / FINER
    nodes = int(np.ceil(reach / spacing)) + 1
    length, most = nodes * spacing, max(nodes, MOST_NODES)
    needed, name = nodes_for_loads(scene, end_time, length, nodes)
    if needed > most:
        raise SceneError(
            f"march: the {name} history turns faster than {most} nodes follow; raise `resolution` "
            f"from {simulation.resolution} to {math.ceil(simulation.resolution * needed / nodes)} "
            "(docs/limits.md)."
        )
    return march(scene, end_time, needed, length=length, progress=progress)
