"""Prediction of the scene of a simulation, by the solver that applies, and the mesh for both."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from compare.comparison.mesh_choice import MeshChoice, choose_mesh
from semianalytic import Marched, Scene, Solution, solve
from semianalytic.dissimilar_slot.solution import PairSolution
from semianalytic.engine.plan import MOST_NODES
from semianalytic.engine.resolution import nodes_for_loads
from semianalytic.methods import chosen
from semianalytic.results.interruption import whole
from semianalytic.scene.errors import SceneError

if TYPE_CHECKING:
    from fem import Simulation

FINER = 4
"""Nodes of a march per element of the simulation."""


def planned(
    scene: Scene,
    method: str = "auto",
    budget: float | None = None,
    *,
    snapshots: bool,
    **settings: Any,
) -> tuple[Solution | PairSolution | None, MeshChoice]:
    """Predict a scene, unless that has to follow the simulation, and choose the mesh to compare on.

    The prediction is None if it has to follow.  The method is as for `predict_like`, all else as in
    `choose_mesh`, and so are errors, also of a march that has to follow.
    """
    prediction = predict_before(scene, method)
    choice = choose_mesh(prediction, scene, budget=budget, snapshots=snapshots, **settings)
    # else a march, which follows the simulation, would refuse its loads only after that has run
    if prediction is None:
        speed, end_time = scene.material.shear_speed, settings.get("end_time")
        end_time = 1 / speed if end_time is None else end_time
        reach, element = scene.fastest_speed * end_time, speed * end_time / choice.resolution
        nodes, length = _grid(scene, reach, end_time, element, choice.resolution)
        # this march costs little compared with a simulation
        options = {"end_time": end_time, "nodes": nodes, "length": length, "estimate": False}
        whole(solve(scene, method="space-time", **options))
    return prediction, choice


def predict_before(scene: Scene, method: str = "auto") -> Solution | PairSolution | None:
    """Return the prediction of a self-similar scene, which needs no simulation first; else None.

    It raises the same errors as `predict_like`.
    """
    if scene.lower_material is not None and method == "space-time":
        raise SceneError(
            "--method space-time is for identical bodies; leave it out for different ones, or "
            "march them as an interface (docs/engine.md)."
        )
    exactly = chosen(scene, method).name
    return solve(scene, method=exactly) if exactly == "self-similar" else None


def predict_like(
    simulation: Simulation,
    method: str = "auto",
    progress: Callable[[float, float], object] | None = None,
) -> Solution | PairSolution | Marched:
    """Predict the scene of a simulation, on its contact and until its end.

    Its scene, end time, nodes and times are used, but none of its results.  The method is "auto",
    "self-similar" or "space-time"; `progress` is that of `march`.  Errors are those of `solve`, and
    SceneError if a march cannot follow the loads.
    """
    solution = predict_before(simulation.scene, method)
    if solution is not None:
        return solution
    scene, end_time = simulation.scene, float(simulation.interface.t[-1])
    # as far and as long as the simulation was recorded, on finer nodes
    reach, element = float(simulation.interface.x[-1]), simulation.element_size
    nodes, length = _grid(scene, reach, end_time, element, simulation.resolution)
    options = {"end_time": end_time, "nodes": nodes, "length": length, "progress": progress}
    return whole(solve(scene, method="space-time", **options))


def _grid(
    scene: Scene, reach: float, end_time: float, element: float, resolution: int
) -> tuple[int, float]:
    """Nodes and length of a march that reaches as far as a simulation, on finer nodes."""
    spacing = element / FINER
    nodes = int(np.ceil(reach / spacing)) + 1
    length, most = nodes * spacing, max(nodes, MOST_NODES)
    needed, name = nodes_for_loads(scene, end_time, length, nodes)
    if needed > most:
        raise SceneError(
            f"march: the {name} history turns faster than {most} nodes follow; raise `resolution` "
            f"from {resolution} to {math.ceil(resolution * needed / nodes)} (docs/limits.md)."
        )
    return needed, length
