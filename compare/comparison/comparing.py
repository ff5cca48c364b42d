"""Both answers to a problem, judged: `compare` for all scenes alike."""

from __future__ import annotations

from os import PathLike
from typing import TYPE_CHECKING, Any

from compare.comparison.judgement import Judgement, judge
from compare.comparison.prediction import planned, predict_like
from semianalytic.scene.checks import shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.given.finding import find
from semianalytic.scene.scene import Scene

if TYPE_CHECKING:
    from fem import Specimen

__all__ = ["compare"]


def compare(
    problem: Scene | Specimen | str | PathLike[str],
    end_time: float | None = None,
    *,
    method: str = "auto",
    budget: float | None = None,
    **settings: Any,
) -> Judgement:
    """Solve a problem, simulate it with finite elements on three meshes, and judge both.

    Parameters
    ----------
    problem : Scene, str or path
        The problem, or its name or file as for `find`; it may be a Specimen.
    end_time : float, optional
        Last time [time]; by default that of the scene, or the time a shear wave takes over a length
        of 1 in the units of the scene.
    method : str
        Method that predicts a scene, as for `solve`.
    budget : float, optional
        Time that the simulation of a scene may take [s]; about a minute by default.
    **settings
        Settings of `simulate`, such as resolution; for a scene on a line, nodes, mesh_nodes and the
        settings of its run; for a specimen, size, damping and step_ratio.

    Returns
    -------
    Judgement
        Its `verdict` is "agrees", "differs" or "unresolved"; `rows` list the quantities that were
        compared, their differences and their error bars.

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
    from fem.lines.plates import find_specimen

    if (specimen := find_specimen(problem)) is not None:
        from compare.comparison.interfaces.specimens import compare_specimen

        return compare_specimen(specimen, end_time, **settings)
    found: Any = find(problem) if isinstance(problem, str | PathLike) else problem
    if not isinstance(found, Scene):
        raise SceneError(f"compare: problem must be a Scene, got {shown(found)}.")
    if found.on_line:
        from compare.comparison.interfaces.comparing import compare_interface

        given = {**found.run, **settings, **({} if end_time is None else {"end_time": end_time})}
        if "end_time" not in given:
            raise SceneError("compare: end_time is missing; give the end of the simulation.")
        return compare_interface(found, **given)
    from fem import simulate, with_companions

    end_time = found.run.get("end_time") if end_time is None else end_time
    if end_time is not None:
        settings["end_time"] = end_time
    prediction, choice = planned(found, method, budget, snapshots=False, **settings)
    settings |= {"resolution": choice.resolution, "damping": choice.damping}
    simulation = with_companions(simulate(found, **settings))
    return judge(prediction or predict_like(simulation, method), simulation)
