"""Read an answer from the file or folder to which its `save` wrote it."""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import Any

from semianalytic import solve
from semianalytic.results.saved import SOLVED, SavedScene, kind_of_file, read_answer
from semianalytic.scene.checks import shown
from semianalytic.scene.errors import DataFileError, SceneError
from semianalytic.scene.scene import Scene

__all__ = ["load"]


def load(path: str | PathLike[str], scene: Scene | None = None) -> Any:
    """Read an answer that was saved: a march, a solution, a simulation or a history.

    Parameters
    ----------
    path : str or path
        File that `save` wrote, or the folder of a simulation.
    scene : Scene, optional
        The scene of a march, if it has Python functions, which no file can contain.

    Returns
    -------
    Solution, Marched, Simulation, LineSimulation or InterfaceHistory
        The answer as it was saved; an exact one is solved again.

    Raises
    ------
    MissingLibraryError
        If h5py is not installed.
    DataFileError
        If the file is missing, damaged, or holds no answer, or that of a scene with Python
        functions that is not given.

    Examples
    --------
    >>> import tempfile
    >>> import slipfront as sf
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     sf.solve("ramp", nodes=64).save(f"{folder}/ramp.h5")
    ...     sf.load(f"{folder}/ramp.h5").status == sf.solve("ramp", nodes=64).status
    True
    """
    if not isinstance(path, str | PathLike):
        raise SceneError(f"load: path must be the path of a file or folder, got {shown(path)}.")
    path = Path(path)
    kind = "slipfront simulation" if path.is_dir() else kind_of_file(path)
    if kind == "slipfront simulation":
        from fem.results import load_simulation

        return load_simulation(path if path.is_dir() else path.parent)
    if kind == "slipfront specimen":
        from fem.lines.march import SPECIMEN_FORMAT, LineSimulation

        found = "a specimen that was simulated"
        return read_answer(path, SPECIMEN_FORMAT, LineSimulation, found, "simulate it again")
    if kind == "slipfront march":
        from semianalytic.engine.marched import Marched

        return Marched.load(path, scene)
    if kind == "slipfront interface history":
        from semianalytic.results.interface_history import InterfaceHistory

        return InterfaceHistory.load(path)
    if kind == SOLVED.rpartition(" ")[0]:
        asked = read_answer(path, SOLVED, SavedScene, "a solution that was saved", "solve it again")
        return solve(asked.scene, method="self-similar", **asked.settings)
    raise DataFileError(f"{path} holds no answer of slipfront; give a file that `save` wrote.")
