"""Meshes of squares and graded blocks made with numpy where gmsh cannot be loaded.

Nodes, elements and the tags of both are those of `meshes.build`, in the same order, so that either
file gives the same mesh.
"""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import meshio
import numpy as np
from numpy.typing import NDArray

from meshes.blocks import Blocks

LEAST_SIDES = 2
"""Fewest element sides on each boundary: meshio loses the name of a curve without inner nodes."""

Numbers = NDArray[np.int64]


@dataclass(frozen=True)
class _Block:
    """One block of the mesh.

    Attributes
    ----------
    name : str
    up : int
        1 for the upper block, -1 for the lower one.
    number : (columns, rows) array
        Number of each node, columns from left to right and rows away from the interface.
    curves : list of (m,) arrays
        Nodes along each side in the order of `Blocks.sides`, ends included.
    """

    name: str
    up: int
    number: Numbers
    curves: list[Numbers]

    @property
    def inside(self) -> Numbers:
        """Nodes inside the block, column by column."""
        return self.number[1:-1, 1:-1].ravel()

    @property
    def cells(self) -> Numbers:
        """Corners (n, 4) of the elements, column by column, counter-clockwise."""
        number = self.number
        around = [number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]]
        if self.up < 0:
            around = [around[0], *around[:0:-1]]
        return np.stack(around, axis=-1).reshape(-1, 4)


def write_laid(blocks: Blocks, part: Path) -> None:
    """Make squares or a graded mesh and write it as binary MSH 4.1.

    Parameters
    ----------
    blocks : Blocks
        Each side has at least `LEAST_SIDES` elements.
    part : Path
        A file that is there.

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    try:
        meshio.gmsh.write(part, laid_mesh(blocks), fmt_version="4.1", binary=True)
    except OSError as error:
        if error.errno is not None:
            raise
        # numpy says how much it could not write, but not that there is no room for it
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC)) from error


def laid_mesh(blocks: Blocks) -> meshio.Mesh:
    """Make the mesh of squares or of a graded pattern, with the tags that gmsh gives to its parts.

    Points come first, then the inner nodes of the curves and those of the surfaces, upper block
    before lower one.  Points, curves and surfaces are numbered from 1 on; so are the physical
    groups, which are the sides and then the surface of each block.
    """
    parts = list(_numbered(blocks))
    points = np.zeros((blocks.nodes, 3))
    tags = np.zeros((blocks.nodes, 2), dtype=np.int64)  # dimension and number of the entity
    x = blocks.size * np.arange(-blocks.left, blocks.right + 1.0)
    for at, part in enumerate(parts):
        points[part.number, 0] = x[:, None]
        points[part.number, 1] = part.up * blocks.rows
        tags[part.inside] = 2, at + 1
        for tag, curve in enumerate(part.curves, start=5 * at + 1):
            tags[curve[1:-1]] = 1, tag
            tags[curve[0]] = 0, tag

    cells, physical, entity, bounds = [], [], [], []
    names: dict[str, Numbers] = {}
    for at, part in enumerate(parts):
        for tag, (name, curve) in enumerate(
            zip(blocks.sides(part.name), part.curves, strict=True), start=1
        ):
            cells.append(("line", np.stack([curve[:-1], curve[1:]], axis=1)))
            physical.append(6 * at + tag)
            entity.append(5 * at + tag)
            bounds.append(np.array([5 * at + tag, -(5 * at + tag % 5 + 1)]))
            names[name] = np.array([6 * at + tag, 1])
    for at, part in enumerate(parts):
        cells.append(("quad", part.cells))
        physical.append(6 * at + 6)
        entity.append(at + 1)
        bounds.append(np.arange(5 * at + 1, 5 * at + 6)[:: part.up] * part.up)
        names[part.name] = np.array([6 * at + 6, 2])
    return meshio.Mesh(
        points,
        cells,
        point_data={"gmsh:dim_tags": tags},
        cell_data={
            "gmsh:physical": _for_each(cells, physical),
            "gmsh:geometrical": _for_each(cells, entity),
        },
        field_data=names,
        cell_sets={"gmsh:bounding_entities": bounds},
    )


def _for_each(cells: list[tuple[str, Numbers]], tags: list[int]) -> list[Numbers]:
    """Return the tag of a group of cells for each of them."""
    return [np.full(len(nodes), tag) for (_, nodes), tag in zip(cells, tags, strict=True)]


def _numbered(blocks: Blocks) -> Iterator[_Block]:
    """Number the nodes of blocks: points, inner nodes of curves, inner nodes of surfaces."""
    shape = (blocks.left + blocks.right + 1, blocks.height + 1)
    place = np.arange(shape[0] * shape[1]).reshape(shape)
    sides = [
        place[: blocks.left + 1, 0],
        place[blocks.left :, 0],
        place[-1],
        place[::-1, -1],
        place[0, ::-1],
    ]
    stages = (
        np.array([side[0] for side in sides]),
        np.concatenate([side[1:-1] for side in sides]),
        place[1:-1, 1:-1].ravel(),
    )
    numbers = [np.empty(place.size, dtype=np.int64) for _ in blocks.names]
    start = 0
    for stage in stages:
        for number in numbers:
            number[stage] = np.arange(start, start + len(stage))
            start += len(stage)
    for name, number in zip(blocks.names, numbers, strict=True):
        curves = [number[side] for side in sides]
        yield _Block(name, 1 if name == "upper" else -1, number.reshape(shape), curves)
