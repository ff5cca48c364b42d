"""Read a file of triangles and check that it is the mesh it should be; find nodes of sides."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np
from numpy.typing import NDArray
from skfem import MeshTri

from meshes.blocks import Blocks
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import DataFileError

POSITION_TOLERANCE = 1e-6
"""Largest distance of a node from its position on the grid, in elements."""


def read_mesh(path: str | Path, blocks: Blocks) -> MeshTri:
    """Read a block of triangles from a binary MSH 4.1 file, as `mesh_of` describes them.

    Nodes on the boundaries are put exactly on the grid; gmsh's own places are off by up to 1e-9
    elements.  A file that is missing, damaged, or holds anything else raises DataFileError.
    """
    points, elements = _parse(Path(path))
    places, mesh = points / blocks.size, MeshTri(points, elements)
    outer = mesh.boundary_facets()
    sides = np.unique(mesh.facets[:, outer])
    beyond = np.abs(places[:, sides] - np.rint(places[:, sides])).max() > POSITION_TOLERANCE
    complaint = ""
    if not _is_covered(places, elements, blocks):
        complaint = "its triangles do not cover it once"
    elif beyond or len(outer) != sum(blocks.sides.values()):
        complaint = "its sides do not consist of whole element sides"
    if complaint:
        raise DataFileError(f"{path} is not the requested mesh: {complaint}; delete it.")
    # zeros without a sign
    points[:, sides] = blocks.size * np.rint(places[:, sides]) + 0.0
    return MeshTri(points, elements)


def side_nodes(points: Array, side: str) -> NDArray[np.int64]:
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


def _parse(path: Path) -> tuple[Array, NDArray[np.int64]]:
    """Return places of nodes (2, n) [length] and the nodes of each triangle (3, m) of a file."""
    if not path.is_file():
        raise DataFileError(f"{path} does not exist; give the path of a mesh file.")
    try:
        file = meshio.gmsh.read(path)
        kinds = {cells.type for cells in file.cells}
        if kinds == {"triangle"}:
            parts = file.points[:, :2].T, file.cells_dict["triangle"].T
            points, elements = map(np.ascontiguousarray, parts)
            return points, elements
    # a damaged binary file can make the parser fail in any way at all
    except Exception as error:
        raise DataFileError(f"{path} cannot be read as a mesh ({error}); delete it.") from error
    raise DataFileError(
        f"{path} holds elements of type {', '.join(sorted(kinds)) or 'none'}, not triangles; "
        "delete it."
    )


def _is_covered(places: Array, elements: NDArray[np.int64], blocks: Blocks) -> bool:
    """Return whether triangles with nodes (2, n), in elements, cover the rectangle once."""
    first, second, third = (places[:, nodes] for nodes in elements)
    side, other = second - first, third - first
    area = float(np.abs(side[0] * other[1] - side[1] * other[0]).sum()) / 2
    corners = [[-blocks.left, blocks.right], [0, blocks.height]]
    extent = np.stack([places.min(axis=1), places.max(axis=1)], axis=1)
    whole = (blocks.left + blocks.right) * blocks.height
    inside = np.abs(extent - corners).max() < POSITION_TOLERANCE
    return bool(inside) and abs(area / whole - 1) < POSITION_TOLERANCE
