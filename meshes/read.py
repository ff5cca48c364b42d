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
    """Contents of a mesh file: places of nodes (2, n) [length], nodes of each element (k, m),
    elements of each named block, and nodes (2, j) of the element sides of each named side.
    """

    points: NDArray[np.float64]
    elements: NDArray[np.int64]
    named: dict[str, NDArray[np.int64]]
    sides: dict[str, NDArray[np.int64]]


def read_mesh(path: str | Path, blocks: Blocks) -> MeshTri:
    """Read blocks of triangles from a binary MSH 4.1 file, as `mesh_of` describes them.

    Nodes on the boundaries are put exactly on the grid; gmsh's own places are off by up to 1e-9
    elements.

    Raises
    ------
    DataFileError
        If the file is missing, damaged, or holds anything but these blocks, with each of their
        sides named.
    """
    raw = _parse(Path(path))
    places = raw.points / blocks.size
    complaint = _block_complaint(raw, places, blocks) or _side_complaint(raw, places, blocks)
    if complaint:
        raise DataFileError(f"{path} is not the mesh asked for: {complaint}; delete it.")
    on_sides = np.unique(np.concatenate([side.ravel() for side in raw.sides.values()]))
    # zeros without a sign
    raw.points[:, on_sides] = blocks.size * np.rint(places[:, on_sides]) + 0.0
    return MeshTri(raw.points, raw.elements, _subdomains={b: raw.named[b] for b in blocks.names})


def side_nodes(
    points: NDArray[np.float64], nodes: NDArray[np.int64], side: str
) -> NDArray[np.int64]:
    """Return the nodes of a named side of a block, in order of increasing x and then |y|.

    Slot and contact meet at the node of the interface that is nearest to x = 0.

    Parameters
    ----------
    points : (2, n) array
        Places of all nodes [length], those of the sides exactly on the grid.
    nodes : (m,) array
        Which of them belong to the block.
    side : str
        As "upper_slot" or "lower_bottom"; see `Blocks.sides`.
    """
    x, y = points[:, nodes]
    on_face = y == 0
    edge = min(x[on_face], key=abs)
    on_side = {
        "slot": on_face & (x <= edge),
        "contact": on_face & (x >= edge),
        "left": x == x.min(),
        "right": x == x.max(),
        "top": y == y.max(),
        "bottom": y == y.min(),
    }[side.split("_")[1]]
    order = np.lexsort((np.abs(y[on_side]), x[on_side]))
    return nodes[on_side][order]


def _parse(path: Path) -> _Raw:
    """Parse the triangles and the named sides of a file."""
    if not path.is_file():
        raise DataFileError(f"{path} does not exist; give the path of a mesh file.")
    try:
        file = meshio.gmsh.read(path)
        kinds = {cells.type for cells in file.cells}
        if kinds == {"line", "triangle"}:
            elements, lines = (file.cells_dict[one].T for one in ("triangle", "line"))
            named, sides = {}, {}
            for name, members in file.cell_sets_dict.items():
                if name.startswith("gmsh:"):
                    continue
                if "triangle" in members:
                    named[name] = members["triangle"].astype(np.int32)
                if "line" in members:
                    sides[name] = lines[:, members["line"]]
            points = np.ascontiguousarray(file.points[:, :2].T)
            return _Raw(points, np.ascontiguousarray(elements), named, sides)
    # a damaged binary file can make the parser fail in any way at all
    except Exception as error:
        raise DataFileError(f"{path} cannot be read as a mesh ({error}); delete it.") from error
    raise DataFileError(
        f"{path} holds elements of type {', '.join(sorted(kinds)) or 'none'}, "
        "not triangles with named sides; delete it."
    )


def _block_complaint(raw: _Raw, places: NDArray[np.float64], blocks: Blocks) -> str:
    """Say what is wrong with the elements of a mesh, or return an empty string."""
    if not _are_named(raw.elements, places.shape[1]).all():
        return "some of its nodes belong to no element"
    for block, sign in zip(blocks.names, (1, -1), strict=False):
        if block not in raw.named:
            return f"the block '{block}' is not named in it"
        corners = places[:, raw.elements[:, raw.named[block]]]
        if not _is_covered(corners * [[[1]], [[sign]]], blocks):
            return f"the triangles of the {block} block do not cover it once"
    return ""


def _side_complaint(raw: _Raw, places: NDArray[np.float64], blocks: Blocks) -> str:
    """Say what is wrong with the sides of a mesh, or return an empty string."""
    total = 0
    for block in blocks.names:
        own = _are_named(raw.elements[:, raw.named[block]], places.shape[1])
        for name, count in blocks.sides(block).items():
            side = raw.sides.get(name, np.empty((2, 0), dtype=int))
            ends = places[:, side]
            middles = np.unique(np.rint(ends).sum(axis=1), axis=1)
            if side.shape[1] != count or middles.shape[1] != count:
                return f"the side '{name}' does not consist of {count} element sides"
            if not (own[side].all() and _on_side(ends, name, blocks)):
                return f"the side '{name}' is not where it should be"
            total += count
    if len(MeshTri(raw.points, raw.elements).boundary_facets()) != total:
        return "it has a boundary besides its named sides"
    return ""


def _are_named(elements: NDArray[np.int64], nodes: int) -> NDArray[np.bool_]:
    """Return which of so many nodes belong to one of the elements (k, m)."""
    named = np.zeros(nodes, dtype=bool)
    named[elements] = True
    return named


def _is_covered(corners: NDArray[np.float64], blocks: Blocks) -> bool:
    """Return whether triangles (2, 3, n), in elements, cover the upper rectangle once."""
    (x, y), first = corners, corners[:, 0]
    one, two = corners[:, 1] - first, corners[:, 2] - first
    area = (one[0] * two[1] - one[1] * two[0]) / 2
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
    sign = 1 if name.startswith("upper") else -1
    distances = {
        "slot": np.abs(y) + np.maximum(x, 0),
        "contact": np.abs(y) + np.maximum(-x, 0),
        "left": np.abs(x + blocks.left),
        "right": np.abs(x - blocks.right),
        "top": np.abs(y - blocks.height),
        "bottom": np.abs(y + blocks.height),
    }
    outside = np.maximum(-sign * y, 0)
    near = distances[name.split("_")[1]] + outside <= POSITION_TOLERANCE
    return bool(near.all() and on_grid.all() and one_long.all())
