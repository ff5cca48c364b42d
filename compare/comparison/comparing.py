"""Both answers to a problem, judged: `compare` for scenes and interfaces alike."""

from __future__ import annotations

from os import PathLike
from typing import Any

from compare.comparison.judgement import Judgement, judge
from compare.comparison.prediction import planned, predict_like
from semianalytic.finding import find
from semianalytic.interface.files import InterfaceFile
from semianalytic.interface.interface import Interface
from semianalytic.scene.checks import shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.scene import Scene

__all__ = ["compare"]


def compare(
    problem: Scene | Interface | InterfaceFile | str | PathLike[str],
    end_time: float | None = None,
    *,
    method: str = "auto",
    budget: float | None = None,
    **settings: Any,
) -> Judgement:
    """Solve a problem, simulate it with finite elements on three meshes, and judge both.

    Parameters
    ----------
    problem : Scene, Interface, InterfaceFile, str or path
        The problem, or its name or file as for `find`.
    end_time : float, optional
        Last time [time]; by default that of the file, or the time a shear wave takes over a length
        of 1 in the units of the scene.
    method : str
        Method that predicts a scene, as for `solve`.
    budget : float, optional
        Time that the simulation of a scene may take [s]; about a minute by default.
    **settings
        Settings of `simulate`, such as resolution, or, of an interface, its nodes, mesh_nodes and
        settings of its run.

    Returns
    -------
    Judgement
        Its `verdict` is "agrees", "differs" or "unresolved"; `rows` say what was compared, how far
        both are apart, and with which bar.

    Raises
    ------
    SceneError
        If there is no such problem, a setting is not admissible, or the simulation would take
        longer than the budget.
    MissingLibraryError
        If a library of finite elements is not installed.
    TensionError, ComputationError
        For the reasons given at `solve` and `simulate`.

    Examples
    --------
    >>> import slipfront as sf
    >>> judged = sf.compare("preloaded", resolution=40)
    >>> judged.verdict, len(judged.rows) > 10
    ('agrees', True)
    """
    found: Any = find(problem) if isinstance(problem, str | PathLike) else problem
    if isinstance(found, InterfaceFile):
        end_time = found.end_time if end_time is None else end_time
        found, settings = found.interface, {**found.options, **settings}
    if isinstance(found, Interface):
        from compare.comparison.interfaces.comparing import compare_interface

        if end_time is None:
            raise SceneError("compare: end_time is missing; say until when it is simulated.")
        return compare_interface(found, end_time, **settings)
    if not isinstance(found, Scene):
        raise SceneError(f"compare: problem must be a Scene or an Interface, got {shown(found)}.")
    from fem import simulate, with_companions

    if end_time is not None:
        settings["end_time"] = end_time
    prediction, choice = planned(found, method, budget, snapshots=False, **settings)
    settings["resolution"] = choice.resolution
    simulation = with_companions(simulate(found, **settings))
    return judge(prediction or predict_like(simulation, method), simulation)
