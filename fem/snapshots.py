"""Snapshots of the whole fields in both blocks: one VTU file per frame and a PVD index."""

from __future__ import annotations

import re
import zlib
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from functools import cached_property, lru_cache, partial
from pathlib import Path
from types import SimpleNamespace
from xml.etree import ElementTree

import meshio
import numpy as np
from meshio.vtu import _vtu
from numpy.typing import NDArray
from scipy import sparse

from fem.budget import free_space
from fem.loading import arrived_wave
from fem.model import Model
from fem.settings import COMPANIONS
from semianalytic.results.files import Seal, new_file, remove_empty, write_bytes
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import DataFileError

INDEX = "fields.pvd"
CELLS = {"squares": "quad", "triangles": "triangle"}
"""VTK's names of the elements, whose nodes scikit-fem puts in the same order."""
PRECISION = np.float32
"""Type of the fields in a frame.  Its rounding, 6e-8, is far below the errors of any mesh; in
double precision a frame is 1.7 times as large and takes 1.7 times as long to write and to read."""
COMPRESSION_LEVEL = 1
"""Level at which zlib compresses frames.  On a frame of 190,000 nodes the default level, 6, takes
3.4 times as long and saves 3 %."""
_blocks = lru_cache(maxsize=1024)  # of 32 kB; those of the mesh come again in each frame
_ZLIB = SimpleNamespace(
    compress=_blocks(partial(zlib.compress, level=COMPRESSION_LEVEL)),
    decompress=_blocks(zlib.decompress),
)
_RUN = re.compile(rb"<!-- slipfront run ([0-9a-f]+) -->")


class Snapshots:
    """Write frames into a folder, each complete before it gets its name and enters the index.

    A run that is interrupted leaves a valid index of the frames written so far.

    Point data: `displacement` since t = 0 and `velocity`, three components each.
    Cell data: `sigma_xx`, `sigma_yy`, `sigma_xy` at the centre of each element, in antiplane shear
    `sigma_xz` and `sigma_yz` too, tension positive.  The base tractions are part of sigma_yy and
    sigma_xy, or sigma_yz; they do not determine the initial sigma_xx, so that one is the change
    since t = 0.

    Index and frames carry the identity of the run, and those of another run are removed from the
    directory, which is made if it does not exist.  A run that goes on from an interrupted one
    starts at a level above 0, with the frames (time, name) that one had written, as far as they
    still exist.  Frames leave a reserve of disk space for the histories [bytes].  DataFileError is
    raised if the folder or its index cannot be written.
    """

    def __init__(
        self,
        directory: Path,
        model: Model,
        run: str,
        started: int = 0,
        frames: Iterable[tuple[float, str]] = (),
        reserve: int = 0,
    ) -> None:
        self.directory, self.model, self.run, self.reserve = directory, model, run, reserve
        forget_other_frames(self.directory, run)
        count = model.plan.settings.frames
        levels = np.rint(np.linspace(0, model.steps, count + 1)[1:]).astype(int)
        self._levels = np.unique(levels).tolist()
        points, cells = both_blocks(model)
        self._points = np.pad(points.T, ((0, 0), (0, 1)))
        # nodes are fewer than 2^31; their numbers in 32 bits are written in two thirds of the time
        self._cells = [(CELLS[model.plan.settings.mesh], cells.T.astype(np.int32))]
        self._centres = self._points[cells.T, :2].mean(axis=1).T
        # (time, name) of the frames that the index lists
        self.frames = [entry for entry in frames if frame_run(self.directory / entry[1]) == run]
        # why frames are missing, as a sentence, and whether one failed, after which none is tried
        self.missing, self.failed = "", False
        due = sum(level < started for level in self._levels)
        if len(self.frames) < due:
            self.missing = (
                f"{due - len(self.frames)} of the {due} snapshots due before the interruption are "
                f"not in {self.directory}."
            )
        write_index(self.directory, self.frames, self.run)

    def is_due(self, level: int) -> bool:
        """Return whether a time level has a frame, and no frame has failed."""
        return level in self._levels and not self.failed

    def write(self, level: int) -> None:
        """Write the frame of a time level if it is due, after its kick and before its drift."""
        time, number = level * self.model.time_step, self._levels.index(level) + 1
        name = f"fields-{number:04d}.vtu"
        path = self.directory / name
        try:
            with new_frame(path, self._frame(time), self.run):
                if free_space(self.directory) < self.reserve:
                    raise DataFileError(
                        f"{path} would leave no room on the disk for the histories."
                    )
            self.frames.append((time, name))
            write_index(self.directory, self.frames, self.run)
        except DataFileError as error:
            self.frames = [entry for entry in self.frames if entry[1] != name]
            self.failed = True
            path.unlink(missing_ok=True)
            self.missing = (
                f"{str(error).rstrip('.')}; snapshots from t = {time:.6g} on are missing."
            )

    def _frame(self, time: float) -> meshio.Mesh:
        """Return the fields at a time level, after its kick and before its drift."""
        bodies, step = self.model.bodies, self.model.time_step
        displacement = spread(self.model, [body.displacement for body in bodies])
        velocity = spread(self.model, [(b.before + b.increment) / (2 * step) for b in bodies])
        stress = self._stress(displacement, time)
        wave = arrived_wave(self.model.plan.scene, self._points[:, 0], self._points[:, 1], time)
        if wave is not None:
            displacement = displacement + wave.displacement.T
            velocity = velocity + wave.velocity.T
        return meshio.Mesh(
            self._points,
            self._cells,
            point_data={
                "displacement": displacement.astype(PRECISION),
                "velocity": velocity.astype(PRECISION),
            },
            cell_data={name: [field.astype(PRECISION)] for name, field in stress.items()},
        )

    def _stress(self, displacement: Array, time: float) -> dict[str, Array]:
        """Return the stress at the centre of each element under what the slot scatters, the base
        and an incident wave."""
        scene = self.model.plan.scene
        antiplane, (x, y) = scene.antiplane, self._centres
        wave = arrived_wave(scene, x, y, time)
        held = scene.superposition.in_place if wave is None else scene.base
        (uxx, uxy), (uyx, uyy), (uzx, uzy) = self._gradient(displacement)
        mu, bulk = (
            np.where(y < 0, *(value(body) for body in reversed(scene.bodies)))
            for value in (
                lambda material: material.shear_modulus,
                lambda material: material.density * material.longitudinal_speed**2,
            )
        )
        stress = {
            "sigma_xx": bulk * uxx + (bulk - 2 * mu) * uyy,
            "sigma_yy": bulk * uyy + (bulk - 2 * mu) * uxx - held.pressure,
            "sigma_xy": mu * (uxy + uyx) + (0.0 if antiplane else held.shear),
        }
        if antiplane:
            stress |= {"sigma_xz": mu * uzx, "sigma_yz": mu * uzy + held.shear}
        if wave is not None:
            stress = {name: values + wave.stress[name[-2:]] for name, values in stress.items()}
        return stress

    def _gradient(self, displacement: Array) -> Array:
        """Return the gradient d_j u_i at the centre of each element, (3, 2, elements), i first."""
        upper, lower = (
            (self._slopes @ part).T.reshape(3, 2, -1) for part in np.split(displacement, 2)
        )
        return np.concatenate([upper, lower * [[1], [-1]]], axis=2)

    @cached_property
    def _slopes(self) -> sparse.csr_array:
        """Matrix from values at the nodes of a block to d_x, then d_y, at its elements' centres."""
        basis = self.model.space.basis
        # d_j u = sum over the nodes of an element of u d_j (shape function)
        shapes = np.stack([shape.grad[..., 0] for (shape,) in basis.basis], axis=2)
        nodes = np.broadcast_to(basis.element_dofs.T, shapes.shape).ravel()
        ends = np.arange(shapes.size + 1, step=shapes.shape[2])
        return sparse.csr_array((shapes.ravel(), nodes, ends), (2 * basis.nelems, basis.N))


@contextmanager
def new_frame(path: Path, mesh: meshio.Mesh, run: str) -> Iterator[None]:
    """Open a frame of a run for writing; it gets its name when the context ends without error."""
    with new_file(path, seal=Seal.XML) as part:
        with quick_compression():
            meshio.write(part, mesh, file_format="vtu")
        with part.open("ab") as stream:
            stream.write(f"<!-- slipfront run {run} -->\n".encode())
        yield


@contextmanager
def quick_compression() -> Iterator[None]:
    """Let meshio compress at `COMPRESSION_LEVEL`, for which it has no option, and no block twice.

    Its VTU reader and writer call functions of the module zlib that they have imported.
    """
    _vtu.zlib = _ZLIB
    try:
        yield
    finally:
        _vtu.zlib = zlib  # not what was found: that may be the stand-in of another thread


def write_index(directory: Path, frames: Iterable[tuple[float, str]], run: str) -> None:
    """Write the index of the frames (time, name) of a run, completely or not at all."""
    entries = "".join(
        f'    <DataSet timestep="{time!r}" part="0" file="{name}"/>\n' for time, name in frames
    )
    text = (
        '<?xml version="1.0"?>\n'
        '<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">\n'
        f'  <Collection run="{run}">\n'
        f"{entries}  </Collection>\n</VTKFile>\n"
    )
    write_bytes(directory / INDEX, text.encode(), Seal.XML)


def frame_run(path: Path) -> str | None:
    """Return the identity of the run that wrote a frame; None if there is none or it has none."""
    try:
        with path.open("rb") as stream:
            stream.seek(max(stream.seek(0, 2) - 400, 0))
            names = _RUN.findall(stream.read())
    except OSError:
        return None
    return names[-1].decode() if names else None


def index_run(directory: Path) -> str | None:
    """Return the identity of the run that wrote the index of a folder; None if not known."""
    return _collection(directory).get("run")


def _collection(directory: Path) -> ElementTree.Element:
    """Return what the index of a folder lists; an empty collection without an index."""
    with suppress(OSError, ElementTree.ParseError):
        found = ElementTree.parse(directory / INDEX).getroot().find("Collection")
        if found is not None:
            return found
    return ElementTree.Element("Collection")


def companion_folder(snapshots: Path, number: int) -> Path:
    """Return the folder of the last frame of the companion of 2^number times the element size."""
    return snapshots / f"{2**number}h"


def forget_other_frames(directory: Path, run: str) -> None:
    """Remove index and frames of other runs from a folder of snapshots, and nothing else.

    The folder need not exist.  If its index was of another run, the frames of its companions go
    too.  DataFileError is raised if they cannot be removed.
    """
    listed = [entry.get("file") for entry in _collection(directory).iter("DataSet")]
    try:
        for path in sorted(directory.glob("fields-*.vtu")):
            owner = frame_run(path)
            if owner != run and (owner is not None or path.name in listed):
                path.unlink(missing_ok=True)
        owner = index_run(directory)
        if owner != run and (owner is not None or listed):
            (directory / INDEX).unlink(missing_ok=True)
        for number in range(1, COMPANIONS + 1) if owner not in (run, None) else ():
            folder = companion_folder(directory, number)
            forget_other_frames(folder, run)
            remove_empty([folder] if folder.is_dir() else [])
    except OSError as error:
        raise DataFileError(
            f"the snapshots of another run in {directory} cannot be removed ({error.strerror}); "
            "choose another folder."
        ) from error


def both_blocks(model: Model) -> tuple[Array, NDArray[np.int64]]:
    """Return the positions (2, n) of the nodes of both blocks, and each element's nodes (k, m).

    The lower block, the mirror image of the upper one, comes last.
    """
    points, cells = model.space.points, model.space.element_nodes
    # its nodes the other way round, so that they are counter-clockwise again
    mirrored = cells[[0, *range(len(cells) - 1, 0, -1)]] + points.shape[1]
    return (
        np.concatenate([points, points * [[1], [-1]]], axis=1),
        np.concatenate([cells, mirrored], axis=1),
    )


def spread(model: Model, unknowns: list[Array]) -> Array:
    """Return the vectors (n, 3) at the nodes of `both_blocks`.

    They come from the mass-normalised unknowns of each body.
    """
    blocks = np.zeros((2, len(model.place), 3))
    for number, (body, values) in enumerate(zip(model.bodies, unknowns, strict=True)):
        own = (values / body.root).reshape(-1, len(body.components))
        blocks[number // len(model.upper)][:, body.components] += own[model.place]
    upper, lower = blocks if model.lower else (blocks[0], -blocks[0])
    # lower bodies are described by their mirror images
    return np.concatenate([upper, lower * [1, -1, 1]])
