"""Read a file of triangles and check that it is the mesh it should be; find nodes of sides."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import meshio
import numpy as np
from numpy.typing import NDArray
from skfem import MeshTri

from meshes.blocks import Blocks
from semianalytic.scene.errors import DataFileError

POSITION_TOLERANCE = 1e-6
"""Largest distance of a node from its position on the grid, in elements."""


@dataclass(frozen=True)
class _Raw:
    """Contents of a mesh file: places of nodes (2, n) [length], nodes of each element (3, m), and
    nodes (2, j) of the element sides of each named side.
    """

    points: NDArray[np.float64]
    elements: NDArray[np.int64]
    sides: dict[str, NDArray[np.int64]]


def read_mesh(path: str | Path, blocks: Blocks) -> MeshTri:
    """Read a block of triangles from a binary MSH 4.1 file, as `mesh_of` describes them.

    Nodes on the boundaries are put exactly on the grid; gmsh's own places are off by up to 1e-9
    elements.

    Raises
    ------
    DataFileError
        If the file is missing, damaged, or holds anything but this block, with each of its sides
        named.
    """
    raw = _parse(Path(path))
    places = raw.points / blocks.size
    complaint = _block_complaint(raw, places, blocks) or _side_complaint(raw, places, blocks)
    if complaint:
        raise DataFileError(f"{path} is not the requested mesh: {complaint}; delete it.")
    on_sides = np.unique(np.concatenate([side.ravel() for side in raw.sides.values()]))
    # zeros without a sign
    raw.points[:, on_sides] = blocks.size * np.rint(places[:, on_sides]) + 0.0
    return MeshTri(raw.points, raw.elements)


def side_nodes(points: NDArray[np.float64], side: str) -> NDArray[np.int64]:
    """Return the nodes of a named side of the block, in order of increasing x and then y.

    Slot and contact meet at the node of the interface that is nearest to x = 0.

    Parameters
    ----------
    points : (2, n) array
        Places of all nodes [length], those of the sides exactly on the grid.
    side : str
        As "slot" or "far"; see `Blocks.sides`.
    """
    x, y = points
    on_face = y == 0
    edge = min(x[on_face], key=abs)
    on_side = {
        "slot": on_face & (x <= edge),
        "contact": on_face & (x >= edge),
        "left": x == x.min(),
        "right": x == x.max(),
        "far": y == y.max(),
    }[side]
    nodes = np.flatnonzero(on_side)
    return nodes[np.lexsort((y[nodes], x[nodes]))]


def _parse(path: Path) -> _Raw:
    """Parse the triangles and the named sides of a file."""
    if not path.is_file():
        raise DataFileError(f"{path} does not exist; give the path of a mesh file.")
    try:
        file = meshio.gmsh.read(path)
        kinds = {cells.type for cells in file.cells}
        if kinds == {"line", "triangle"}:
            elements, lines = (file.cells_dict[shape].T for shape in ("triangle", "line"))
            sides = {
                name: lines[:, members["line"]]
                for name, members in file.cell_sets_dict.items()
                if "line" in members and not name.startswith("gmsh:")
            }
            points = np.ascontiguousarray(file.points[:, :2].T)
            return _Raw(points, np.ascontiguousarray(elements), sides)
    # a damaged binary file can make the parser fail in any way at all
    except Exception as error:
        raise DataFileError(f"{path} cannot be read as a mesh ({error}); delete it.") from error
    raise DataFileError(
        f"{path} holds elements of type {', '.join(sorted(kinds)) or 'none'}, "
        "not triangles with named sides; delete it."
    )


def _block_complaint(raw: _Raw, places: NDArray[np.float64], blocks: Blocks) -> str:
    """Say what is wrong with the elements of a mesh, or return an empty string."""
    if len(np.unique(raw.elements)) < places.shape[1]:
        return "some of its nodes belong to no element"
    if not _is_covered(places[:, raw.elements], blocks):
        return "its triangles do not cover it once"
    return ""


def _side_complaint(raw: _Raw, places: NDArray[np.float64], blocks: Blocks) -> str:
    """Say what is wrong with the sides of a mesh, or return an empty string."""
    for name, count in blocks.sides.items():
        side = raw.sides.get(name, np.empty((2, 0), dtype=int))
        ends = places[:, side]
        middles = np.unique(np.rint(ends).sum(axis=1), axis=1)
        if side.shape[1] != count or middles.shape[1] != count:
            return f"the side '{name}' does not consist of {count} element sides"
        if not _on_side(ends, name, blocks):
            return f"the side '{name}' is not where it should be"
    if len(MeshTri(raw.points, raw.elements).boundary_facets()) != sum(blocks.sides.values()):
        return "it has a boundary besides its named sides"
    return ""


def _is_covered(corners: NDArray[np.float64], blocks: Blocks) -> bool:
    """Return whether triangles (2, 3, n), in elements, cover the rectangle once."""
    (x, y), first = corners, corners[:, 0]
    side, other = corners[:, 1] - first, corners[:, 2] - first
    area = (side[0] * other[1] - side[1] * other[0]) / 2
    slack = POSITION_TOLERANCE
    inside = (
        (-blocks.left - slack <= x.min())
        and (x.max() <= blocks.right + slack)
        and (-slack <= y.min())
        and (y.max() <= blocks.height + slack)
    )
    whole = (blocks.left + blocks.right) * blocks.height
    return bool(inside) and abs(np.abs(area).sum() / whole - 1) < slack


def _on_side(ends: NDArray[np.float64], name: str, blocks: Blocks) -> bool:
    """Return whether lines with ends (2, 2, n), in elements, are element sides on a side."""
    x, y = ends
    on_grid = np.abs(ends - np.rint(ends)) <= POSITION_TOLERANCE
    one_long = np.ptp(np.rint(ends), axis=1).sum(axis=0) == 1
    distances = {
        "slot": np.abs(y) + np.maximum(x, 0),
        "contact": np.abs(y) + np.maximum(-x, 0),
        "left": np.abs(x + blocks.left),
        "right": np.abs(x - blocks.right),
        "far": np.abs(y - blocks.height),
    }
    near = distances[name] + np.maximum(-y, 0) <= POSITION_TOLERANCE
    return bool(near.all() and on_grid.all() and one_long.all())
