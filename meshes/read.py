"""Read a mesh file and check that it is the mesh it should be."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import meshio
import numpy as np
from numpy.typing import NDArray
from skfem import MeshQuad, MeshTri

from meshes.blocks import Blocks
from semianalytic.scene.errors import DataFileError

POSITION_TOLERANCE = 1e-6
"""Largest distance of a node from its position on the grid, in elements."""


@dataclass(frozen=True)
class _Raw:
    """The contents of a mesh file.

    Attributes
    ----------
    points : (2, n) array
        Places of the nodes [length].
    elements : (k, m) array
        Nodes of each element.
    named : mapping from the name of a block to its elements
    sides : mapping from the name of a side to the nodes (2, j) of its element sides
    """

    points: NDArray[np.float64]
    elements: NDArray[np.int64]
    named: dict[str, NDArray[np.int64]]
    sides: dict[str, NDArray[np.int64]]


def read_mesh(path: str | Path, blocks: Blocks) -> MeshQuad | MeshTri:
    """Read the blocks from a mesh file.

    Parameters
    ----------
    path : path
        A binary MSH 4.1 file.
    blocks : Blocks
        What the file must hold.

    Returns
    -------
    MeshQuad, or MeshTri for the pattern "triangles"
        One mesh of one or two parts that share no node, with subdomains "upper" ("lower").  Its
        nodes, of triangles those on the boundaries, are put exactly on the grid; gmsh's own places
        are off by up to 1e-9 elements.  `side_nodes` finds those of a side.

    Raises
    ------
    DataFileError
        If the file is missing, damaged, or holds anything but these blocks, with each of their
        sides named.
    """
    raw = _parse(Path(path), "triangle" if blocks.pattern == "triangles" else "quad")
    places = _in_elements(raw.points, blocks)
    complaint = _block_complaint(raw, places, blocks) or _side_complaint(raw, places, blocks)
    if complaint:
        raise DataFileError(f"{path} is not the mesh asked for: {complaint}; delete it.")
    column, row = np.rint(places).astype(int)
    on_grid = np.array([blocks.size * column, np.sign(row) * blocks.rows[np.abs(row)]])
    parts = {block: raw.named[block] for block in blocks.names}
    if blocks.pattern != "triangles":
        return MeshQuad(on_grid, raw.elements, _subdomains=parts)
    inside = np.ones(len(column), dtype=bool)
    inside[np.concatenate([side.ravel() for side in raw.sides.values()])] = False
    on_grid[:, inside] = raw.points[:, inside]
    return MeshTri(on_grid, raw.elements, _subdomains=parts)


def side_nodes(
    points: NDArray[np.float64], nodes: NDArray[np.int64], side: str
) -> NDArray[np.int64]:
    """Return the nodes of a named side of a block, in order of increasing x and then |y|.

    Slot and contact meet at the node of the interface that is nearest to x = 0.

    Parameters
    ----------
    points : (2, n) array
        Places of all nodes [length], those of the sides exactly on the grid, as `read_mesh` has
        them.
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


def _parse(path: Path, kind: str) -> _Raw:
    """Parse the elements of one kind, "quad" or "triangle", and the named sides."""
    if not path.is_file():
        raise DataFileError(f"{path} does not exist; give the path of a mesh file.")
    try:
        file = meshio.gmsh.read(path)
        kinds = {cells.type for cells in file.cells}
        if kinds == {"line", kind}:
            return _raw(file, kind)
    # a damaged binary file can make the parser fail in any way at all
    except Exception as error:
        raise DataFileError(f"{path} cannot be read as a mesh ({error}); delete it.") from error
    raise DataFileError(
        f"{path} holds elements of type {', '.join(sorted(kinds)) or 'none'}, "
        f"not of type {kind} with named sides; delete it."
    )


def _raw(file: meshio.Mesh, kind: str) -> _Raw:
    elements, lines = (file.cells_dict[one].T for one in (kind, "line"))
    named: dict[str, NDArray[np.int64]] = {}
    sides: dict[str, NDArray[np.int64]] = {}
    for name, members in file.cell_sets_dict.items():
        if name.startswith("gmsh:"):
            continue
        if kind in members:
            named[name] = members[kind].astype(np.int32)
        if "line" in members:
            sides[name] = lines[:, members["line"]]
    points = np.ascontiguousarray(file.points[:, :2].T)
    return _Raw(points, np.ascontiguousarray(elements), named, sides)


def _in_elements(points: NDArray[np.float64], blocks: Blocks) -> NDArray[np.float64]:
    """Convert positions (2, n) to columns right of the edge and rows above the interface.

    Positions beyond the far sides are put beyond the last row.
    """
    x, y = points
    rows = np.append(blocks.rows, blocks.far + blocks.size)
    row = np.interp(np.abs(y), rows, np.arange(len(rows)))
    return np.array([x / blocks.size, np.sign(y) * row])


def _block_complaint(raw: _Raw, places: NDArray[np.float64], blocks: Blocks) -> str:
    """Say what is wrong with the elements of a mesh, or return an empty string."""
    regular, nodes, count = blocks.pattern != "triangles", places.shape[1], raw.elements.shape[1]
    if regular and (count != blocks.elements or nodes != blocks.nodes):
        return (
            f"it has {count} quadrilaterals and {nodes} nodes "
            f"instead of {blocks.elements} and {blocks.nodes}"
        )
    if not _are_named(raw.elements, nodes).all():
        return "some of its nodes belong to no element"
    for block in blocks.names:
        if block not in raw.named:
            return f"the block '{block}' is not named in it"
        sign = 1 if block == "upper" else -1
        elements = raw.elements[:, raw.named[block]]
        if regular:
            own = places[:, _are_named(elements, nodes)] * [[1], [sign]]
            if not _is_grid(own, blocks):
                return f"the nodes of the {block} block are not on its grid"
            if not _fill_cells(places[:, elements] * [[[1]], [[sign]]], blocks):
                return f"the elements of the {block} block do not fill one cell each"
        elif not _is_covered(places[:, elements] * [[[1]], [[sign]]], blocks):
            return f"the triangles of the {block} block do not cover it once"
    return ""


def _side_complaint(raw: _Raw, places: NDArray[np.float64], blocks: Blocks) -> str:
    """Say what is wrong with the sides of a mesh, or return an empty string."""
    for block in blocks.names:
        own = _are_named(raw.elements[:, raw.named[block]], places.shape[1])
        for name, count in blocks.sides(block).items():
            side = raw.sides.get(name, np.empty((2, 0), dtype=int))
            ends = places[:, side]
            if side.shape[1] != count or len(_middles(ends)) != count:
                return f"the side '{name}' does not consist of {count} element sides"
            if not (own[side].all() and _on_side(ends, name, blocks)):
                return f"the side '{name}' is not where it should be"
    if blocks.pattern != "triangles":  # whose cells are filled once each
        return ""
    mesh = MeshTri(raw.points, raw.elements)
    if len(mesh.boundary_facets()) != sum(
        count for block in blocks.names for count in blocks.sides(block).values()
    ):
        return "it has a boundary besides its named sides"
    return ""


def _are_named(elements: NDArray[np.int64], nodes: int) -> NDArray[np.bool_]:
    """Return which of so many nodes belong to one of the elements (k, m)."""
    named = np.zeros(nodes, dtype=bool)
    named[elements] = True
    return named


def _fill_cells(corners: NDArray[np.float64], blocks: Blocks) -> bool:
    """Return whether elements (2, 4, n) with corners on the grid fill each cell once."""
    x, y = corners = np.rint(corners)
    column, row = corners.min(axis=1)
    number = (column + blocks.left) * blocks.height + row
    filled = np.zeros((blocks.left + blocks.right) * blocks.height, dtype=bool)
    filled[number.astype(int)] = True
    area = (np.roll(y, -1, axis=0) * x - np.roll(x, -1, axis=0) * y).sum(axis=0) / 2
    return bool(filled.all() and (np.ptp(corners, axis=1) == 1).all() and (np.abs(area) == 1).all())


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


def _is_grid(places: NDArray[np.float64], blocks: Blocks) -> bool:
    """Return whether positions (2, n), in elements, are those of the upper nodes, once each."""
    columns, rows = blocks.left + blocks.right + 1, blocks.height + 1
    nearest = np.rint(places)
    column, row = nearest[0] + blocks.left, nearest[1]
    inside = (column >= 0) & (column < columns) & (row >= 0) & (row < rows)
    near = np.abs(places - nearest) <= POSITION_TOLERANCE
    each_once = len(np.unique(column * rows + row)) == columns * rows
    return bool(inside.all() and near.all() and each_once)


def _middles(ends: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the distinct middles, times two, of element sides with ends (2, 2, n) on the grid."""
    return np.unique(np.rint(ends).sum(axis=1), axis=1).T


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
