"""Frames of field snapshots: their files, velocity and displacement at nodes, stresses, areas."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from semianalytic.results.files import check_seal
from semianalytic.scene.arrays import Array, Mask
from semianalytic.scene.errors import DataFileError

if TYPE_CHECKING:
    import meshio

IN_PLANE = ("sigma_xx", "sigma_yy", "sigma_xy")
OUT_OF_PLANE = ("sigma_xz", "sigma_yz")
AXES = "xyz"
CORNERS = {"triangle": 3, "quad": 4, "quad9": 4}
"""Number of corner nodes of an element, which come first among its nodes."""


@dataclass(frozen=True, eq=False)
class Places:
    """Places in both bodies at which a frame has fields."""

    # (m,) arrays: coordinates [length]; on the faces y is 0.0 above and -0.0 below
    x: Array
    y: Array
    area: Array  # (m,) array: area that each place stands for [length^2]
    # dict of (m,) arrays: fields by the name of the component, in the units of the scene
    fields: dict[str, Array]

    def at(self, chosen: Mask) -> Places:
        """Return the chosen places."""
        some = {name: values[chosen] for name, values in self.fields.items()}
        return Places(self.x[chosen], self.y[chosen], self.area[chosen], some)

    def thinned(self, most: int) -> Places:
        """Return at most `most` of the places, drawn at random, whose areas stand for all."""
        count = len(self.x)
        if count <= most:
            return self
        kept = np.zeros(count, dtype=bool)
        kept[np.random.default_rng(0).choice(count, most, replace=False)] = True
        thin = self.at(kept)
        return replace(thin, area=thin.area * count / most)


@dataclass(frozen=True, eq=False)
class Mesh:
    """Mesh of both bodies, with the areas that its nodes and elements stand for."""

    points: Array  # (n, 2) array: nodes [length]
    cells: NDArray[np.integer[Any]]  # (m, k) array: nodes of each element, its corners first
    # (n,) array: second coordinate of the nodes, with the sign of their body: -0.0 on the lower
    # face
    y: Array
    held: Array  # (n,) array: area that each node stands for [length^2]
    centre: Array  # (m, 2) array: centres of the elements [length]
    area: Array  # (m,) array: areas of the elements [length^2]

    def is_of(self, points: Array, cells: NDArray[np.integer[Any]]) -> bool:
        """Whether the mesh has these nodes and elements."""
        return np.array_equal(self.points, points) and np.array_equal(self.cells, cells)


@dataclass(frozen=True, eq=False)
class Frame:
    """One frame of both bodies."""

    time: float  # [time]
    nodes: Places  # v_x, v_y, u_x, u_y; in antiplane shear v_z, u_z too
    elements: Places  # stresses at the centre of each element
    mesh: Mesh

    def clear_of_left(self, distance: float) -> Frame:
        """Return the part of the frame that is further than a distance [length] from its left."""
        left = self.nodes.x.min() + distance
        nodes, elements = (places.at(places.x > left) for places in (self.nodes, self.elements))
        return replace(self, nodes=nodes, elements=elements)

    def thinned(self, most: int) -> Frame:
        """Return the frame at so many nodes and elements at most; see `Places.thinned`."""
        return replace(self, nodes=self.nodes.thinned(most), elements=self.elements.thinned(most))


def read_frame(time: float, path: Path, known: Mesh | None = None) -> Frame:
    """Read the frame of a time [time] from a file; DataFileError if it is missing or damaged.

    The mesh of an earlier frame is used again if this frame has the same: areas and centres take
    almost as long as reading.
    """
    with frame_mesh(path) as mesh:
        (block,) = mesh.cells
        points, cells = mesh.points[:, :2], block.data
        antiplane = "sigma_yz" in mesh.cell_data
        axes = AXES if antiplane else AXES[:2]
        moved = {
            f"{symbol}_{axis}": mesh.point_data[name][:, number]
            for symbol, name in (("v", "velocity"), ("u", "displacement"))
            for number, axis in enumerate(axes)
        }
        names = IN_PLANE + (OUT_OF_PLANE if antiplane else ())
        stress = {name: mesh.cell_data[name][0] for name in names}
        if known is None or not known.is_of(points, cells):
            known = _mesh(points, cells, CORNERS[block.type])
    if not all(np.isfinite(values).all() for values in (moved | stress).values()):
        raise DataFileError(f"{path} has values that are not finite; simulate again.")
    nodes = Places(points[:, 0], known.y, known.held, moved)
    return Frame(
        time, nodes, Places(known.centre[:, 0], known.centre[:, 1], known.area, stress), known
    )


def _mesh(points: Array, cells: NDArray[np.integer[Any]], sides: int) -> Mesh:
    """Return a mesh whose elements have a number of sides."""
    corners = points[cells[:, :sides]]
    x, y = np.moveaxis(corners, 2, 0)
    following = np.roll(x, -1, axis=1), np.roll(y, -1, axis=1)
    area = np.abs((x * following[1] - y * following[0]).sum(axis=1)) / 2
    centre = corners.mean(axis=1)
    above = np.zeros(len(points), dtype=bool)
    above[cells[centre[:, 1] > 0]] = True
    share = np.broadcast_to(area[:, None] / cells.shape[1], cells.shape)
    held = np.bincount(cells.ravel(), share.ravel(), len(points)).astype(float)
    height = np.copysign(points[:, 1], np.where(above, 1.0, -1.0))
    return Mesh(points, cells, height, held, centre, area)


def last_frame(folder: Path, run: str | None = None) -> Frame:
    """Read the last frame that the index of a folder of snapshots lists.

    Index and frame must belong to a run, any by default; else, or if they are missing or damaged, a
    DataFileError is raised.
    """
    return read_frame(*listed_frames(folder, run)[-1])


INDEX = "fields.pvd"


def listed_frames(folder: Path, run: str | None = None) -> list[tuple[float, Path]]:
    """Times [time] and files of the frames that the index of a folder of snapshots lists, in order.

    Index and last frame must belong to a run, any by default; else, or if the index is missing,
    damaged or empty, a DataFileError is raised.
    """
    from fem.snapshots import frame_run, index_run

    index = folder / INDEX
    try:
        check_seal(index)
        entries = [
            (float(entry.attrib["timestep"]), folder / entry.attrib["file"])
            for entry in ElementTree.parse(index).getroot().iter("DataSet")
        ]
        if not all(math.isfinite(time) for time, _ in entries):
            raise ValueError("times that are not finite")
        _, last = entries[-1]
    except (OSError, ElementTree.ParseError, IndexError, KeyError, ValueError) as error:
        raise DataFileError(
            f"{index} lists no snapshot that can be read; simulate again."
        ) from error
    if run is not None and not index_run(folder) == run == frame_run(last):
        raise DataFileError(
            f"the snapshots in {folder} are not of its simulation but of another run; "
            "simulate again, or leave them out with --no-snapshots."
        )
    return entries


@contextmanager
def frame_mesh(path: Path) -> Iterator[meshio.Mesh]:
    """The mesh and fields of a frame; DataFileError if it is damaged or lacks what is read."""
    import meshio

    from fem.snapshots import quick_compression

    try:
        check_seal(path)
        with quick_compression():
            mesh = meshio.read(path)
        yield mesh
    except (Exception, SystemExit) as error:  # meshio raises bare exceptions, and exits on some
        raise DataFileError(f"{path} cannot be read as a snapshot; simulate again.") from error
