"""First steps of `slipfront compare`: predict a scene and choose a mesh for it."""

from __future__ import annotations

from typing import Any

from compare.comparison.mesh_choice import MeshChoice, choose_mesh
from compare.comparison.prediction import check_marched, predict_before
from semianalytic import Scene, Solution
from semianalytic.dissimilar_slot.solution import PairSolution


def planned(
    scene: Scene,
    method: str = "auto",
    budget: float | None = None,
    *,
    snapshots: bool,
    **settings: Any,
) -> tuple[Solution | PairSolution | None, MeshChoice]:
    """Predict a scene, unless that has to follow the simulation, and choose the mesh to compare on.

    The prediction is None if it has to follow.

    Parameters
    ----------
    scene, method
        As in `predict_before`.
    budget, snapshots, **settings
        As in `choose_mesh`.

    Raises
    ------
    SceneError, TensionError
        As `predict_before` and `check_marched`, and as `choose_mesh`.
    """
    prediction = predict_before(scene, method)
    choice = choose_mesh(prediction, scene, budget=budget, snapshots=snapshots, **settings)
    # else a march, which follows the simulation, would refuse its loads only after that has run
    if prediction is None:
        check_marched(scene, method, choice.resolution, settings.get("end_time"))
    return prediction, choice
