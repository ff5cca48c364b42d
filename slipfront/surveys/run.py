"""One scene or interface at many values of its parameters, chunk by chunk on many processes.

The chunks depend only on the survey, not on who solves them.  Results are therefore identical to
the last bit on one process, on many, and on a cluster, with or without interruptions.
"""

from __future__ import annotations

import json
import os
import pickle
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from compare.output.places import check_file, working_folder, write_text
from compare.tasks.workers import Progress, Task, run_tasks
from semianalytic.results.files import Seal, check_seal, write_bytes
from semianalytic.scene.arguments import checking
from semianalytic.scene.errors import DataFileError, SceneError
from semianalytic.scene.extras import XARRAY, require
from slipfront.surveys.parameters import Scene
from slipfront.surveys.plan import Question, SurveyPlan, planned
from slipfront.surveys.points import solved_chunk

FIELDS = ("slip_rate", "shear_traction", "pressure")


@checking
def survey(
    scene: Scene | str | os.PathLike[str],
    *,
    together: bool = False,
    rtol: float | None = None,
    x: ArrayLike = (),
    t: ArrayLike = (),
    fields: Sequence[str] = FIELDS,
    end_time: float | None = None,
    nodes: int | None = None,
    length: float | None = None,
    path: str | os.PathLike[str] | None = None,
    chunk: int | None = None,
    workers: int | None = None,
    client: Any = None,
    progress: Progress | None = None,
    **parameters: ArrayLike,
) -> Any:
    """Solve a scene at many values of its parameters.

    Scenes that differ in friction and Poisson ratio are swept together.  Others are solved one by
    one, or marched if they are not self-similar, as `solve` does.

    Parameters
    ----------
    scene : Scene, str or path
        The scene, or its name or file as for `find`, whose values the parameters replace.  If a
        function or a law of it was defined in a notebook or the running program, one process
        marches all points.
    together : bool
        Whether the parameters are lists of equal length that form one list of points, along the
        dimension "point"; otherwise they span a grid, one dimension each.
    rtol : float, optional
        Requested relative accuracy, as for `solve`; 1e-6 for exact answers by default.
    x, t : arrays, optional
        Positions (n,) [length] and times (m,) [time] at which fields are stored.  On a line,
        onset and speed of the front are stored at positions x, with or without t.
    fields : sequence of str
        Fields to store there: slip, slip_rate, shear_traction, pressure, gap.
    end_time : float, optional
        End of totals and marches [time]; by default that of the scene's file, or the last of `t`,
        or the end time of `solve`.
    nodes, length : optional
        Number of nodes and length [length] of marches, see `solve`.
    path : path, optional
        NetCDF file to write, NAME.nc.  Until it is complete, finished chunks are kept in a hidden
        folder next to it, from which an interrupted survey resumes.
    chunk : int, optional
        Largest number of points that are solved and saved together; results depend on it
        within their error estimates.
    workers : int, optional
        Processes on this machine; one per core by default.
    client : distributed.Client, optional
        Client of a Dask cluster that solves the chunks instead of this machine.
    progress : callable, optional
        Called with the number of finished points and the number of all points.
    **parameters : numbers or (n,) arrays
        Any numbers of the scene: friction, poisson_ratio, shear_modulus, density, base_pressure,
        base_shear, load_pressure, load_shear, viscosity; numbers of histories and friction laws
        as shear_history_rise_time or, dotted, ``**{"friction_law.reduction": ...}``; the lower
        body as lower_shear_modulus, lower_density, lower_poisson_ratio.  Units are those
        of the scene.  Single numbers are the same at all points.  On a line, numbers have the names
        of their places in a file, such as friction_law_distance or contact_end; a field that varies
        is multiplied by a parameter such as base_pressure_factor (docs/engine.md).

    Returns
    -------
    xarray.Dataset
        Every variable has its unit and long_name as attributes.  A scene that is refused has nan
        values, and its status says why.

    Raises
    ------
    SceneError
        If a parameter does not exist, or an option is out of range.
    DataFileError
        If the file cannot be written, or another survey is there already.
    ComputationError
        If a process is killed, or a cluster does not answer.
    MissingLibraryError
        If xarray, or a library that writes the file, is not installed.
    """
    samples = {name: _samples(given) for name, given in (("x", x), ("t", t))}
    asked = tuple(fields) if samples["t"] else ()
    question = Question(rtol, end_time, nodes, length, **samples, fields=asked)
    plan = planned(scene, parameters, question, together=together, chunk=chunk)
    return run_survey(
        plan, None if path is None else Path(path), workers, client, progress, plan.call
    )


def _samples(given: ArrayLike) -> tuple[float, ...]:
    return tuple(np.atleast_1d(np.asarray(given, dtype=float)).ravel().tolist())


def run_survey(
    plan: SurveyPlan,
    path: Path | None,
    workers: int | None,
    client: Any,
    progress: Progress | None,
    command: str,
) -> Any:
    """Run a planned survey; return and raise like `survey`.

    The dataset holds the command, a call or a command line, that asked for it.
    """
    if plan.scene.on_line and client is None:
        workers = workers if can_travel(plan.scene) else 1
    plan.check_memory()
    from slipfront.surveys.dataset import dataset_of, netcdf_bytes

    if path is None:
        require("A survey", "xarray")
        kept: dict[int, bytes] = {}
        _solve(plan, {}, kept.__setitem__, workers, client, progress)
        return dataset_of(plan, sorted(kept.items()), command)
    if path.suffix != ".nc":
        raise SceneError(f"{path} is written as NetCDF; let its name end in .nc.")
    require("A survey in a file", *XARRAY)
    if path.exists():
        return _written(path, plan)
    check_file(path)
    with opened_store(path, plan) as store:
        known = {i for i in range(len(plan.regions)) if store.read(i) is not None}
        _solve(plan, known, store.keep, workers, client, progress)

        def chunks() -> Iterator[tuple[int, bytes]]:
            for index in range(len(plan.regions)):
                data = store.read(index)
                if data is None:
                    raise DataFileError(f"A chunk of {path} was damaged meanwhile; start again.")
                yield index, data

        result = dataset_of(plan, chunks(), command)
        write_bytes(path, netcdf_bytes(result), Seal.TRAILING)
        store.clear()
    return result


def _solve(
    plan: SurveyPlan,
    known: Any,
    keep: Callable[[int, bytes], object],
    workers: int | None,
    client: Any,
    progress: Progress | None,
) -> None:
    """Solve the chunks that are not known yet, and keep each as soon as it is done."""
    left = [index for index in range(len(plan.regions)) if index not in known]
    sizes = [int(np.prod([part.stop - part.start for part in region])) for region in plan.regions]
    done = plan.count - sum(sizes[index] for index in left)
    tasks: list[Task] = [
        (solved_chunk, (plan.scene, plan.region_values(plan.regions[i]), plan.fixed, plan.question))
        for i in left
    ]
    for task, data in run_tasks(tasks, workers, client=client):
        keep(left[task], data)
        done += sizes[left[task]]
        if progress is not None:
            progress(done, plan.count)


def _written(path: Path, plan: SurveyPlan) -> Any:
    """Return the survey that a file holds, if it is the planned one."""
    import xarray

    try:
        check_seal(path)
        found = xarray.load_dataset(path, engine="h5netcdf")
    except Exception as error:  # readers fail in any way on files that are no survey
        raise DataFileError(
            f"{path} cannot be read as a survey ({error}); move it away or give another path."
        ) from error
    if found.attrs.get("survey") != plan.digest:
        raise DataFileError(f"{path} holds something else; move it away or give another path.")
    return found


def can_travel(scene: Scene) -> bool:
    """Return whether other processes can receive a scene.

    They cannot receive functions and laws of a notebook or of the program that is running.
    """
    try:
        # Pickle refers to such functions by name, and other processes have another __main__.
        return b"__main__" not in pickle.dumps(scene)
    except Exception:  # what cannot be pickled fails in any way
        return False


_PLAN = "survey.json"


class Store:
    """A folder of finished chunks of one survey, each a file with a checksum."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def _path(self, index: int) -> Path:
        return self._folder / f"{index:08d}.npz"

    def keep(self, index: int, data: bytes) -> None:
        """Write a chunk to the disk; raises as `write_bytes`."""
        write_bytes(self._path(index), data, Seal.TRAILING)

    def read(self, index: int) -> bytes | None:
        """Return a chunk, or None if it is missing or damaged."""
        path = self._path(index)
        try:
            check_seal(path)
            return path.read_bytes()
        except (OSError, ValueError):
            return None

    def clear(self) -> None:
        """Remove everything that was kept."""
        for path in (*self._folder.glob("*.npz"), self._folder / _PLAN):
            with suppress(OSError):
                path.unlink(missing_ok=True)


def store_folder(path: Path) -> Path:
    """Return the folder next to the file of a survey that keeps its chunks until it is complete."""
    return path.with_name(f".{path.name}.survey")


@contextmanager
def opened_store(path: Path, plan: SurveyPlan) -> Iterator[Store]:
    """Open the store of a survey that will become a file, for one run at a time; DataFileError if
    it cannot be written, another run uses it, or it holds another survey."""
    folder = store_folder(path)
    with working_folder(folder):
        _check(folder, plan)
        yield Store(folder)
    with suppress(OSError):
        folder.rmdir()


def _check(folder: Path, plan: SurveyPlan) -> None:
    """Check that a folder belongs to this survey; record the survey in a new folder."""
    text = json.dumps(plan.identity, indent=2, sort_keys=True) + "\n"
    try:
        known = (folder / _PLAN).read_text(encoding="utf-8")
    except FileNotFoundError:
        write_text(folder / _PLAN, text)
        return
    except (OSError, ValueError):
        known = ""
    if known != text:
        raise DataFileError(
            f"{folder} holds part of another survey; repeat that one to continue it, give "
            "another path, or remove that folder."
        )
