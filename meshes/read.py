"""Reading a mesh file and making sure that it is what it should be."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import meshio
import numpy as np
from numpy.typing import NDArray
from skfem import MeshQuad
from skfem.io.meshio import from_meshio

from meshes.blocks import Blocks
from semianalytic.errors import DataFileError

POSITION_TOLERANCE = 1e-6
"""Largest distance of a node from its place, in elements."""


def read_mesh(path: str | Path, blocks: Blocks) -> MeshQuad:
    """Read the blocks from a mesh file.

    Parameters
    ----------
    path : path
        A binary MSH 4.1 file.
    blocks : Blocks
        What the file must hold.

    Returns
    -------
    MeshQuad
        One mesh of one or two parts that share no node, with subdomains "upper" ("lower") and
        boundaries "upper_slot", "upper_contact", "upper_right", "upper_top", "upper_left" (and
        the same for the lower block, with "lower_bottom").  Its nodes are put exactly on the
        grid; gmsh's own places are off by up to 1e-9 elements.

    Raises
    ------
    DataFileError
        If the file is missing, damaged, or holds anything but these blocks.
    """
    mesh = _parse(Path(path))
    complaint = _complaint(mesh, blocks)
    if complaint:
        raise DataFileError(f"{path} is not the mesh asked for: {complaint}; delete it.")
    on_grid = blocks.size * np.rint(mesh.p / blocks.size)
    named = {name: mesh.boundaries[name] for block in blocks.names for name in blocks.sides(block)}
    parts = {block: mesh.subdomains[block] for block in blocks.names}
    return replace(mesh, doflocs=on_grid, _boundaries=named, _subdomains=parts)


def _parse(path: Path) -> MeshQuad:
    if not path.is_file():
        raise DataFileError(f"{path} does not exist; give the path of a mesh file.")
    try:
        raw = meshio.gmsh.read(path)
        kinds = {cells.type for cells in raw.cells}
        if kinds == {"line", "quad"}:
            mesh = from_meshio(raw)
    # a damaged binary file can make the parser fail in any way at all
    except Exception as error:
        raise DataFileError(f"{path} cannot be read as a mesh ({error}); delete it.") from error
    if kinds != {"line", "quad"}:
        raise DataFileError(
            f"{path} holds elements of type {', '.join(sorted(kinds)) or 'none'}, "
            "not quadrilaterals with named sides; delete it."
        )
    return mesh


def _complaint(mesh: MeshQuad, blocks: Blocks) -> str:
    """First difference between a mesh and its description, or an empty string."""
    subdomains, boundaries = mesh.subdomains or {}, mesh.boundaries or {}
    if mesh.nelements != blocks.elements or mesh.nvertices != blocks.nodes:
        return (
            f"it has {mesh.nelements} quadrilaterals and {mesh.nvertices} nodes "
            f"instead of {blocks.elements} and {blocks.nodes}"
        )
    for block in blocks.names:
        if block not in subdomains:
            return f"the block '{block}' is not named in it"
        sign = 1 if block == "upper" else -1
        elements = mesh.t[:, subdomains[block]]
        places = mesh.p[:, np.unique(elements)] / blocks.size
        if not _is_grid(places * [[1], [sign]], blocks):
            return f"the nodes of the {block} block are not on its grid"
        extents = np.ptp(mesh.p[:, elements], axis=1) / blocks.size
        if np.abs(extents - 1).max() > POSITION_TOLERANCE:
            return f"the elements of the {block} block are not squares of size {blocks.size}"
        for name, count in blocks.sides(block).items():
            if name not in boundaries or len(boundaries[name]) != count:
                return f"the side '{name}' does not consist of {count} element sides"
            if not _on_side(mesh.p[:, mesh.facets[:, boundaries[name]]], name, blocks):
                return f"the side '{name}' is not where it should be"
    return ""


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
    """Whether element sides with end points (2, 2, n) lie on the named side of their block."""
    x, y = ends / blocks.size
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
