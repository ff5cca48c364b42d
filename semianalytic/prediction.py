"""Predict what happens in a scene, by the solver that suits it."""

from __future__ import annotations

from collections.abc import Callable
from os import PathLike
from typing import TYPE_CHECKING

from semianalytic.scene.checks import checked_count, checked_size, shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.given.finding import checked_scene, of_scene
from semianalytic.scene.scene import Scene
from semianalytic.selfsimilar.solution import Solution
from semianalytic.selfsimilar.solver import solve

if TYPE_CHECKING:
    from semianalytic.spacetime.marched import Marched

METHODS = ("auto", "self-similar", "space-time")


def chosen_method(scene: Scene, method: str = "auto") -> str:
    """Return the method for a scene, "self-similar" or "space-time".

    It is the requested one, or for "auto" the faster one that is right.  Friction that falls with
    slip rate is marched by default: the exact answer takes longer, and is unstable (docs/rate.md).

    Raises
    ------
    SceneError
        If the method is unknown, or the self-similar one is asked for a scene that is not.
    """
    if method not in METHODS:
        raise SceneError(f"method must be one of {', '.join(METHODS)}, got {shown(method)}.")
    if method == "auto":
        if scene.is_step:
            scene.check_front()  # a march would answer, but of a load that begins somewhere
        marched = not scene.is_self_similar or scene.friction_law.fall_with_rate > 0
        return "space-time" if marched else "self-similar"
    if method == "self-similar":
        scene.check_self_similar()
    return method


@of_scene
def predict(
    scene: Scene | str | PathLike[str],
    end_time: float | None = None,
    *,
    nodes: int | None = None,
    length: float | None = None,
    rtol: float | None = None,
    method: str = "auto",
    progress: Callable[[int, int], object] | None = None,
) -> Solution | Marched:
    """Predict what happens on the contact of a scene: exactly if self-similar, else by a march.

    Both results answer the same questions, those of `Answer`: a solution at all times and
    positions, a march until the end time and on the length it was given.

    Parameters
    ----------
    scene : Scene, str or path
        Material, friction law, tractions and load histories, or a name or file as for `find_scene`.
    end_time : float, optional
        End time of a march [time]; by default the time a shear wave takes over a length of 1.
    nodes : int, optional
        Contact nodes of a march; by default 1000, or as many as follow the loads and resolve slip
        at the edge and slip weakening.
    length : float, optional
        Length of the contact that a march observes [length]; c_l end_time unless given.
    rtol : float, optional
        Wanted accuracy: of a solution as in `solve`, 1e-8 unless given; of a march as in `march`,
        where it replaces `nodes`.
    method : str
        "self-similar", "space-time", or "auto", which takes the first wherever it applies.
    progress : callable, optional
        Called with (step, steps) after each step of a march; if it returns True it ends there.

    Returns
    -------
    Solution or Marched

    Raises
    ------
    SceneError
        If the method does not apply, or an option is out of range, whichever method takes it, or
        both nodes and an rtol are given for a march.
    TensionError
        If the pressure turns tensile.
    ComputationError
        If a march fails.

    Examples
    --------
    >>> from semianalytic import Solution, predict
    >>> answer = predict("preloaded")  # step loads: the exact, self-similar solution
    >>> isinstance(answer, Solution), round(float(answer.slip_rate(0.1, 1.0)), 3)
    (True, 0.771)
    >>> predict("ramp", nodes=128).status  # any other history: a march in time
    'resolved'
    """
    scene = checked_scene("predict", scene)
    if end_time is not None:
        end_time = checked_size("predict: end_time", end_time)
    if length is not None:
        length = checked_size("predict: length", length)
    if nodes is not None:
        nodes = checked_count("predict: nodes", nodes, 1, "a whole number from")
    if chosen_method(scene, method) == "self-similar":
        return solve(scene) if rtol is None else solve(scene, rtol=rtol)
    from semianalytic.spacetime.march import march  # 50 ms that a solution does not need

    return march(scene, end_time, nodes, rtol=rtol, length=length, progress=progress)
