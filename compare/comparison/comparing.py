"""What `slipfront compare` makes of a scene: a prediction, a mesh for it, and the judgement."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from compare.comparison.fields.errors import field_errors
from compare.comparison.judgement import Judgement, judge
from compare.comparison.mesh_choice import MeshChoice, choose_mesh
from compare.comparison.prediction import check_marched, predict_before
from semianalytic import Marched, Scene, Solution

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
) -> tuple[Solution | None, MeshChoice]:
    """The prediction of a scene, None if it has to follow a simulation, and the mesh to compare on.

    Parameters
    ----------
    scene, method
        As in `predict_before`.
    budget, snapshots, **settings
        As in `choose_mesh`.

    Raises
    ------
    SceneError, TensionError
        As both.
    """
    prediction = predict_before(scene, method)
    choice = choose_mesh(prediction, scene, budget=budget, snapshots=snapshots, **settings)
    # a march that follows the simulation would refuse its loads only once that has run
    check_marched(scene, method, choice.resolution, settings.get("end_time"))
    return prediction, choice


def held_against(
    simulation: Simulation,
    prediction: Solution | Marched,
    frames: Path | None = None,
    progress: Progress | None = None,
) -> Judgement:
    """The judgement of a simulation that carries its companions, its snapshots included.

    Parameters
    ----------
    simulation : Simulation
    prediction : Solution or Marched
    frames : Path, optional
        Folder of its field snapshots, if they are to be judged as well.
    progress : callable, optional
        Called with (frame, frames) after each.

    Raises
    ------
    SceneError, DataFileError
        As `field_errors` and `judge`.
    """
    fields = None
    if frames is not None:
        fields = field_errors(prediction, simulation, frames, progress)
    return judge(prediction, simulation, fields)
