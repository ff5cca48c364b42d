"""Checkpoints: everything a run needs to resume after an interruption, to the last bit."""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fem.model import Model
from fem.record import MeshRecord
from fem.settings import Pace
from semianalytic.results.files import sealed_hdf5, whole_hdf5
from semianalytic.scene.errors import DataFileError
from semianalytic.scene.given.documents import scene_document

FORMAT = "slipfront checkpoint 7"


@dataclass(frozen=True)
class Checkpoint:
    """The state of a run between two steps: the last time level whose drift is done, the arrays of
    each body, the interface and the record, and the field snapshots (time, name) written so far.
    """

    step: int
    parts: Mapping[str, Mapping[str, NDArray[Any]]]
    frames: list[tuple[float, str]]

    def restore(self, model: Model, record: MeshRecord) -> None:
        """Put a newly built model and record into this state."""
        for number, body in enumerate(model.bodies):
            body.restore(self.parts[f"body {number}"])
        model.joint.restore(self.parts["interface"])
        record.restore(self.parts["record"])


def take_checkpoint(
    step: int, model: Model, record: MeshRecord, frames: list[tuple[float, str]]
) -> Checkpoint:
    """Return the state after the drift of a step; the arrays are those of the model, not copies."""
    parts = {f"body {number}": body.state() for number, body in enumerate(model.bodies)}
    parts |= {"interface": model.joint.sums(), "record": record.stored()}
    return Checkpoint(step, parts, frames)


def run_identity(model: Model) -> dict[str, Any]:
    """Return everything that determines the result of a run, as plain numbers and strings."""
    plan = model.plan
    mesh = hashlib.sha256()
    for array in (model.space.points, model.space.element_nodes):
        mesh.update(np.ascontiguousarray(array).tobytes())
    options = {
        "scene": scene_document(plan.scene),
        "end_time": plan.end_time,
        **asdict(plan.settings),
        "model": plan.name,
        "snapshots": plan.full,
        "time_step": model.time_step,
        "set of mesh nodes": mesh.hexdigest()[:16],
        **_versions(),
    }
    plain: dict[str, Any] = json.loads(json.dumps(options))
    return plain


@cache  # looking them up takes as long as a small run
def _versions() -> dict[str, str]:
    return {f"{library} version": version(library) for library in ("slipfront", "numpy", "scipy")}


def run_name(identity: Mapping[str, Any]) -> str:
    """Return a short name for an identity, which the files of the run carry."""
    return hashlib.sha256(json.dumps(identity, sort_keys=True).encode()).hexdigest()[:16]


@dataclass
class Keeper:
    """Write and read the checkpoints of one run.

    A checkpoint that cannot be written does not stop the run: it goes on, the checkpoint before
    stays, and the next one is tried when it is due.
    """

    path: Path | None  # the file; None for no checkpoints
    pace: Pace  # how often they are written
    identity: Mapping[str, Any]  # identity of the run, from `run_identity`
    clock: Callable[[], float] = time.monotonic  # [s]; seconds count from when the keeper is made

    def __post_init__(self) -> None:
        self._last = self.clock()
        self.missing = ""  # why the last checkpoint that was due is missing, as a sentence

    def resume(self, model: Model, record: MeshRecord) -> tuple[int, list[tuple[float, str]]]:
        """Restore the checkpoint, if any; return the first level to compute, and the frames."""
        if self.path is None or not self.path.is_file():
            return 0, []
        earlier = read_checkpoint(self.path, self.identity)
        earlier.restore(model, record)
        return earlier.step + 1, earlier.frames

    def step_done(
        self,
        step: int,
        model: Model,
        record: MeshRecord,
        frames: list[tuple[float, str]],
        now: bool,
    ) -> None:
        """Write a checkpoint if one is due, or requested now; only then a failure is raised."""
        due = 0 < step < model.steps and self._is_due(step)
        if self.path is None or not (due or now):
            return
        self._last = self.clock()
        self.missing = ""
        try:
            write_checkpoint(self.path, self.identity, take_checkpoint(step, model, record, frames))
        except DataFileError as error:
            if now:
                raise
            self.missing = str(error)

    def _is_due(self, step: int) -> bool:
        steps, seconds = self.pace.steps, self.pace.seconds
        if steps is not None and step % steps == 0:
            return True
        return seconds is not None and self.clock() - self._last >= seconds


def forget_checkpoint(path: Path, run: str) -> None:
    """Remove the checkpoint of the finished run of a name (`run_name`), of no other run."""
    import h5py

    if not path.is_file():
        return
    try:
        with h5py.File(path, "r") as file:
            ours = run_name(json.loads(file.attrs["identity"])) == run
    except (OSError, LookupError, ValueError, TypeError, RuntimeError):
        return
    if ours:
        path.unlink(missing_ok=True)


def write_checkpoint(path: Path, identity: Mapping[str, Any], checkpoint: Checkpoint) -> None:
    """Write a checkpoint as HDF5; raises as `whole_hdf5`."""
    with whole_hdf5(path) as file:
        file.attrs["format"] = FORMAT
        file.attrs["identity"] = json.dumps(identity)
        file.attrs["facts"] = json.dumps({"step": checkpoint.step, "frames": checkpoint.frames})
        for part, arrays in checkpoint.parts.items():
            for name, array in arrays.items():
                file[f"{part}/{name}"] = array


def read_checkpoint(path: Path, identity: Mapping[str, Any]) -> Checkpoint:
    """Read the checkpoint of the run that has this identity.

    A DataFileError says that the file is damaged or not a checkpoint, or which option of its run
    differs.
    """
    try:
        with sealed_hdf5(path) as file:
            written_as = file.attrs.get("format")
            if written_as == FORMAT:
                theirs = json.loads(file.attrs["identity"])
                known = json.loads(file.attrs["facts"])
                parts = {
                    part: {name: array[...] for name, array in group.items()}
                    for part, group in file.items()
                }
    # a damaged HDF5 file can make the parser fail in any way at all
    except Exception as error:
        raise DataFileError(
            f"{path} cannot be read as a checkpoint ({error}); delete it and simulate again."
        ) from error
    if written_as != FORMAT:
        raise DataFileError(f"{path} is not a checkpoint of this version; delete it.")
    for name in (*identity, *theirs):
        if theirs.get(name) != identity.get(name):
            raise DataFileError(
                f"{path} is of another run: its {name.replace('_', ' ')} is {theirs.get(name)}, "
                f"not {identity.get(name)}; repeat those options or delete it."
            )
    return Checkpoint(known["step"], parts, [(time, name) for time, name in known["frames"]])
