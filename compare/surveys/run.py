"""One scene at many values of its parameters, solved chunk by chunk on many processes or machines.

Chunks depend on what is asked alone, not on who solves them: results are the same to the last bit
on one process, on many, and on a cluster, without a stop or after many.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from compare.output.places import check_file
from compare.surveys.plan import Plan, Question, planned
from compare.surveys.points import solved_chunk
from compare.surveys.store import Store, check_folder, opened_store, seal_folder
from compare.surveys.workers import Progress, Task, run_tasks
from semianalytic.results.files import Seal, check_seal, write_bytes
from semianalytic.scene.checks import shown
from semianalytic.scene.errors import DataFileError, SceneError
from semianalytic.scene.extras import require
from semianalytic.scene.scene import Scene

SUFFIXES = {".nc": ("xarray", "h5netcdf", "h5py"), ".zarr": ("xarray", "zarr")}
"""What a survey is written as, and with what."""
FIELDS = ("slip_rate", "shear_traction", "pressure")


def survey(
    scene: Scene,
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

    Scenes that differ in friction and Poisson ratio are swept, others solved, or marched where they
    are not self-similar, as by `predict`.

    Parameters
    ----------
    scene : Scene
    together : bool
        Whether parameters are one list of points, as long each, along the dimension "point"; else
        they are a grid, each a dimension.
    rtol : float, optional
        Wanted accuracy, 1e-6 for solutions unless given; of marches as in `march`.
    x, t : arrays, optional
        Positions (n,) [length] and times (m,) [time] at which fields are held.
    fields : sequence of str
        Which fields those are: slip, slip_rate, shear_traction, pressure, gap.
    end_time : float, optional
        Until when totals are taken [time], and marches go; the last of `t`, or as in `predict`.
    nodes, length : optional
        Of marches, as in `predict`.
    path : path, optional
        File to write, .nc (NetCDF) or .zarr.  Chunks that are done are kept in a hidden folder
        beside it until then, from which an interrupted survey goes on.
    chunk : int, optional
        Most points that are solved, saved and lost together; results depend on it within their
        error estimates.
    workers : int, optional
        Processes on this machine; one for each core unless given.
    client : distributed.Client, optional
        Of a Dask cluster that is to work instead.
    progress : callable, optional
        Called with the number of points done and of all points.
    **parameters : numbers or (n,) arrays
        Any number of the scene: friction, poisson_ratio, shear_modulus, density, base_pressure,
        base_shear, load_pressure, load_shear, viscosity, and of histories and friction law as
        shear_history_rise_time or, dotted, ``**{"friction_law.reduction": ...}``.  Single numbers
        are the same at all points.

    Returns
    -------
    xarray.Dataset
        With units and long_name of every variable.  A scene that is refused is nan, and its status
        the sentence that says why.  From a .zarr path it is read when it is looked at.

    Raises
    ------
    SceneError
        If there is no such parameter, or an option is out of range.
    DataFileError
        If the file cannot be written, or another survey is there.
    ComputationError
        If a process is killed, or a cluster does not answer.
    MissingLibraryError
        If xarray, or what writes the file, is not installed.
    """
    samples = {name: _samples(name, given) for name, given in (("x", x), ("t", t))}
    asked = tuple(fields) if samples["x"] else ()
    question = Question(rtol, end_time, nodes, length, **samples, fields=asked)
    plan = planned(scene, parameters, question, together=together, chunk=chunk)
    return run_survey(
        plan, None if path is None else Path(path), workers, client, progress, plan.call
    )


def _samples(name: str, given: ArrayLike) -> tuple[float, ...]:
    try:
        return tuple(np.atleast_1d(np.asarray(given, dtype=float)).ravel().tolist())
    except (TypeError, ValueError):
        raise SceneError(f"survey: {name} must be numbers, got {shown(given)}.") from None


def run_survey(
    plan: Plan,
    path: Path | None,
    workers: int | None,
    client: Any,
    progress: Progress | None,
    command: str,
) -> Any:
    """Do what was planned; raises and returns as `survey`.  `command` is how it was asked for."""
    plan.check_memory(whole=path is None or path.suffix == ".nc")
    if path is None:
        require("A survey", "xarray")
        from compare.surveys.dataset import dataset_of

        kept: dict[int, bytes] = {}
        _solve(plan, {}, kept.__setitem__, workers, client, progress)
        return dataset_of(plan, lambda: sorted(kept.items()), command)
    if path.suffix not in SUFFIXES:
        raise SceneError(f"{path} is written as NetCDF or Zarr; let its name end in .nc or .zarr.")
    require(f"A survey as {path.suffix}", *SUFFIXES[path.suffix])
    if path.exists():
        return _written(path, plan)
    check_file(path)
    with opened_store(path, plan) as store:
        known = {i for i in range(len(plan.regions)) if store.read(i) is not None}
        _solve(plan, known, store.keep, workers, client, progress)
        result = _write(path, plan, store, command)
        store.clear()
    return result


def _solve(
    plan: Plan,
    known: Any,
    keep: Callable[[int, bytes], object],
    workers: int | None,
    client: Any,
    progress: Progress | None,
) -> None:
    """Solve what is not known yet, and keep it."""
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


def _write(path: Path, plan: Plan, store: Store, command: str) -> Any:
    """Make the file of all chunks; the survey it holds."""
    import xarray

    from compare.surveys.dataset import dataset_of, netcdf_bytes, write_zarr

    def chunks() -> Iterator[tuple[int, bytes]]:
        for index in range(len(plan.regions)):
            data = store.read(index)
            if data is None:
                raise DataFileError(f"A chunk of {path} was damaged meanwhile; start again.")
            yield index, data

    if path.suffix == ".nc":
        result = dataset_of(plan, chunks, command)
        write_bytes(path, netcdf_bytes(result), Seal.TRAILING)
        return result
    part = path.with_name(f".{path.name}.part")
    try:
        write_zarr(part, plan, chunks, command)
        seal_folder(part)
        os.replace(part, path)
    except OSError as error:
        raise DataFileError(f"Cannot write {path}: {error.strerror or error}.") from error
    return xarray.open_zarr(path, chunks=None)


def _written(path: Path, plan: Plan) -> Any:
    """The survey that a file holds, if it is this one."""
    import xarray

    try:
        if path.suffix == ".nc":
            check_seal(path)
            found = xarray.load_dataset(path, engine="h5netcdf")
        else:
            check_folder(path)
            found = xarray.open_zarr(path, chunks=None)
    except Exception as error:  # what is no survey at all makes its readers fail in any way
        raise DataFileError(
            f"{path} cannot be read as a survey ({error}); move it away or give another path."
        ) from error
    if found.attrs.get("survey") != plan.digest:
        raise DataFileError(f"{path} holds something else; move it away or give another path.")
    return found
