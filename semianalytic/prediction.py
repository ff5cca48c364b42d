"""The history of an interface by the solver its scene calls for."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.scene.checks import checked_count, checked_size, shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.scene import Scene
from semianalytic.selfsimilar.solver import solve
from semianalytic.spacetime.march import march

METHODS = ("auto", "self-similar", "space-time")
_LEVELS = 200
_NODES = 1000


def chosen_method(scene: Scene, method: str = "auto") -> str:
    """ "self-similar" or "space-time": the one asked for, or the faster one that is right.

    Raises
    ------
    SceneError
        If the method is unknown, or the self-similar one is asked for a scene that is not.
    """
    if method not in METHODS:
        raise SceneError(f"method must be one of {', '.join(METHODS)}, got {shown(method)}.")
    if method == "auto":
        return "self-similar" if scene.is_self_similar else "space-time"
    if method == "self-similar":
        scene.check_self_similar()
    return method


def slip_history(
    scene: Scene,
    end_time: float | None = None,
    nodes: int | None = None,
    *,
    length: float | None = None,
    method: str = "auto",
    progress: Callable[[int, int], None] | None = None,
) -> InterfaceHistory:
    """What happens on the contact until an end time.

    Parameters
    ----------
    scene : Scene
    end_time : float, optional
        T [time]; by default the time a shear wave takes over a length of 1.
    nodes : int, optional
        Positions, evenly spaced on 0 < x < length, the first half a spacing from the edge; 1000
        unless given, more where a march needs them to follow the loads.
    length : float, optional
        Of the contact that is observed [length]; c_l T unless given.
    method : str
        "self-similar" (exact, sampled at 200 times), "space-time" (marched, every step), or "auto",
        which takes the first wherever it applies.
    progress : callable, optional
        Called with (step, steps) during a march.

    Raises
    ------
    SceneError
        If the method does not apply or an option is out of range.
    TensionError
        If the pressure turns tensile.
    ComputationError
        If a march fails.
    """
    if chosen_method(scene, method) == "space-time":
        return march(scene, end_time, nodes, length=length, progress=progress).interface
    end_time = 1 / scene.material.shear_speed if end_time is None else end_time
    end_time = checked_size("slip_history: end_time", end_time)
    length = scene.material.longitudinal_speed * end_time if length is None else length
    length = checked_size("slip_history: length", length)
    nodes = checked_count("slip_history: nodes", nodes, 1, "a whole number from")
    solution = solve(scene)
    nodes = _NODES if nodes is None else nodes
    x = (np.arange(nodes) + 0.5) * length / nodes
    t = end_time * np.arange(1, _LEVELS + 1) / _LEVELS
    return solution.history(x, t)
