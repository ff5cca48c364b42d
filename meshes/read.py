"""Reading a mesh file and making sure that it is what it should be."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import meshio
import numpy as np
from numpy.typing import NDArray
from skfem import MeshQuad, MeshTri
from skfem.io.meshio import from_meshio

from meshes.blocks import Blocks
from semianalytic.scene.errors import DataFileError

POSITION_TOLERANCE = 1e-6
"""Largest distance of a node from its place, in elements."""


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
        One mesh of one or two parts that share no node, with subdomains "upper" ("lower") and
        boundaries "upper_slot", "upper_contact", "upper_right", "upper_top", "upper_left" (and
        the same for the lower block, with "lower_bottom").  Its nodes, of triangles those on
        the boundaries, are put exactly on the grid; gmsh's own places are off by up to 1e-9
        elements.

    Raises
    ------
    DataFileError
        If the file is missing, damaged, or holds anything but these blocks.
    """
    mesh = _parse(Path(path), "triangle" if blocks.pattern == "triangles" else "quad")
    places = _in_elements(mesh.p, blocks)
    complaint = _block_complaint(mesh, places, blocks) or _side_complaint(mesh, places, blocks)
    if complaint:
        raise DataFileError(f"{path} is not the mesh asked for: {complaint}; delete it.")
    column, row = np.rint(places).astype(int)
    on_grid = np.array([blocks.size * column, np.sign(row) * blocks.rows[np.abs(row)]])
    named = {name: mesh.boundaries[name] for block in blocks.names for name in blocks.sides(block)}
    parts = {block: mesh.subdomains[block] for block in blocks.names}
    if blocks.pattern == "triangles":
        outer = np.unique(np.concatenate([mesh.facets[:, side].ravel() for side in named.values()]))
        inside = np.setdiff1d(np.arange(mesh.nvertices), outer)
        on_grid[:, inside] = mesh.p[:, inside]
    return replace(mesh, doflocs=on_grid, _boundaries=named, _subdomains=parts)


def _parse(path: Path, kind: str) -> MeshQuad | MeshTri:
    """Mesh of one kind of element, "quad" or "triangle", with named sides."""
    if not path.is_file():
        raise DataFileError(f"{path} does not exist; give the path of a mesh file.")
    try:
        raw = meshio.gmsh.read(path)
        kinds = {cells.type for cells in raw.cells}
        if kinds == {"line", kind}:
            mesh = from_meshio(raw)
    # a damaged binary file can make the parser fail in any way at all
    except Exception as error:
        raise DataFileError(f"{path} cannot be read as a mesh ({error}); delete it.") from error
    if kinds != {"line", kind}:
        raise DataFileError(
            f"{path} holds elements of type {', '.join(sorted(kinds)) or 'none'}, "
            f"not of type {kind} with named sides; delete it."
        )
    return mesh


def _in_elements(points: NDArray[np.float64], blocks: Blocks) -> NDArray[np.float64]:
    """Places (2, n) in columns right of the edge and rows above the interface.

    What lies beyond the far sides is put beyond the last row.
    """
    x, y = points
    rows = np.append(blocks.rows, blocks.far + blocks.size)
    row = np.interp(np.abs(y), rows, np.arange(len(rows)))
    return np.array([x / blocks.size, np.sign(y) * row])


def _block_complaint(mesh: MeshQuad | MeshTri, places: NDArray[np.float64], blocks: Blocks) -> str:
    """What is wrong with the elements of a mesh, or an empty string."""
    subdomains = mesh.subdomains or {}
    regular = blocks.pattern != "triangles"
    if regular and (mesh.nelements != blocks.elements or mesh.nvertices != blocks.nodes):
        return (
            f"it has {mesh.nelements} quadrilaterals and {mesh.nvertices} nodes "
            f"instead of {blocks.elements} and {blocks.nodes}"
        )
    if len(np.unique(mesh.t)) != mesh.nvertices:
        return "some of its nodes belong to no element"
    for block in blocks.names:
        if block not in subdomains:
            return f"the block '{block}' is not named in it"
        sign = 1 if block == "upper" else -1
        elements = mesh.t[:, subdomains[block]]
        if regular:
            if not _is_grid(places[:, np.unique(elements)] * [[1], [sign]], blocks):
                return f"the nodes of the {block} block are not on its grid"
            extents = np.ptp(places[:, elements], axis=1)
            if np.abs(extents - 1).max() > POSITION_TOLERANCE:
                return f"the elements of the {block} block do not fill one cell each"
        elif not _is_covered(places[:, elements] * [[[1]], [[sign]]], blocks):
            return f"the triangles of the {block} block do not cover it once"
    return ""


def _side_complaint(mesh: MeshQuad | MeshTri, places: NDArray[np.float64], blocks: Blocks) -> str:
    """What is wrong with the sides of a mesh, or an empty string."""
    boundaries = mesh.boundaries or {}
    for block in blocks.names:
        for name, count in blocks.sides(block).items():
            if name not in boundaries or len(boundaries[name]) != count:
                return f"the side '{name}' does not consist of {count} element sides"
            ends = places[:, mesh.facets[:, boundaries[name]]]
            off_grid = np.abs(ends - np.rint(ends)).max() > POSITION_TOLERANCE
            if off_grid or not _on_side(ends, name, blocks):
                return f"the side '{name}' is not where it should be"
    if len(mesh.boundary_facets()) != sum(
        count for block in blocks.names for count in blocks.sides(block).values()
    ):
        return "it has a boundary besides its named sides"
    return ""


def _is_covered(corners: NDArray[np.float64], blocks: Blocks) -> bool:
    """Whether triangles (2, 3, n), in elements, cover the upper rectangle without overlap."""
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
    """Whether places (2, n), in elements, are the nodes of the upper rectangle, each once."""
    columns, rows = blocks.left + blocks.right + 1, blocks.height + 1
    nearest = np.rint(places)
    column, row = nearest[0] + blocks.left, nearest[1]
    inside = (column >= 0) & (column < columns) & (row >= 0) & (row < rows)
    near = np.abs(places - nearest) <= POSITION_TOLERANCE
    each_once = len(np.unique(column * rows + row)) == columns * rows
    return bool(inside.all() and near.all() and each_once)


def _on_side(ends: NDArray[np.float64], name: str, blocks: Blocks) -> bool:
    """Whether element sides with ends (2, 2, n), in elements, lie on the named side."""
    x, y = ends
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
    return bool((distances[name.split("_")[1]] + outside).max() <= POSITION_TOLERANCE)
