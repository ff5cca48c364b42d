"""A prediction sampled where a simulation was recorded, by the solver its scene calls for."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from semianalytic import InterfaceHistory, Marched, Scene, Solution, march, solve
from semianalytic.prediction import chosen_method
from semianalytic.selfsimilar.load import check_pressure
from semianalytic.spacetime.resolution import check_loads
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
    path : (n,) array
        Accumulated |slip| at the end [length].
    friction_work : (n,) array
        Work per area taken by friction until the end [stress length].
    seconds : float
        What it took to compute.
    caution : str
        What a march was too coarse for; "" if nothing is known.
    """

    method: str
    answer: Solution | Marched
    interface: InterfaceHistory
    path: Array
    friction_work: Array
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
        own = self.answer.interface
        level = int(np.clip(np.searchsorted(own.t, time), 1, len(own.t) - 1))
        before, after = own.t[level - 1 : level + 1]
        share = (time - before) / (after - before)
        return own.x, (1 - share) * own.slip_rate[level - 1] + share * own.slip_rate[level]


def check_predictable(scene: Scene, method: str = "auto") -> None:
    """Raise what `predict` would for a scene, as far as that is known without solving it.

    Raises
    ------
    SceneError
        If the method does not apply to the scene.
    TensionError
        If the pressure of a self-similar scene turns tensile.
    """
    if chosen_method(scene, method) == "self-similar":
        check_pressure(scene)


def predict(
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
    history = simulation.interface
    x, t = history.x[history.x > 0], history.t
    chosen = chosen_method(simulation.scene, method)
    if chosen == "self-similar":
        solution = solve(simulation.scene)
        whole = solution.history(x, t)
        seconds = sum(solution.statistics.seconds.values())
        worn = solution.path(x, t[-1]), solution.work_density(x, t[-1])
        return Prediction(chosen, solution, whole, *worn, seconds)
    spacing = simulation.element_size / FINER
    nodes = int(np.ceil(x[-1] / spacing)) + 1
    length = nodes * spacing
    nodes = check_loads(simulation.scene, float(t[-1]), length, nodes, max(nodes, MOST_NODES))
    marched = march(simulation.scene, float(t[-1]), nodes, length=length, progress=progress)
    own = marched.interface
    return Prediction(
        chosen,
        marched,
        marched.history(x, t),
        np.interp(x, own.x, marched.final_path),
        np.interp(x, own.x, marched.final_work_density),
        sum(marched.statistics.seconds.values()),
        marched.caution,
    )


def contact_nodes(simulation: Simulation) -> InterfaceHistory:
    """The history of a simulation on x > 0, without the node at the edge."""
    history = simulation.interface
    inside = history.x > 0
    return InterfaceHistory(
        history.x[inside],
        history.t,
        history.slip[:, inside],
        history.slip_rate[:, inside],
        history.shear_traction[:, inside],
        history.pressure[:, inside],
    )
