"""Steps of `slipfront compare`: predict a scene, choose a mesh for it and judge the simulation."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from compare.comparison.fields.errors import field_errors
from compare.comparison.judgement import Judgement, judge
from compare.comparison.mesh_choice import MeshChoice, choose_mesh
from compare.comparison.prediction import check_marched, predict_before
from semianalytic import Marched, Scene, Solution
from semianalytic.dissimilar_slot.solution import PairSolution

if TYPE_CHECKING:
    from fem import Simulation

Progress = Callable[[int, int], None]


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


def held_against(
    simulation: Simulation,
    prediction: Solution | PairSolution | Marched,
    frames: Path | None = None,
    progress: Progress | None = None,
) -> Judgement:
    """Judge a simulation that carries its companions, including its snapshots if given.

    Parameters
    ----------
    simulation : Simulation
    prediction : Solution, PairSolution or Marched
    frames : Path, optional
        Folder of its field snapshots, if they are to be judged as well.
    progress : callable, optional
        Called with (frame, frames) after each frame.

    Raises
    ------
    SceneError, DataFileError
        As `field_errors` and `judge`.
    """
    fields = None
    if frames is not None:
        fields = field_errors(prediction, simulation, frames, progress)
    return judge(prediction, simulation, fields)
