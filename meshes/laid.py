"""Meshes of squares and graded blocks, made in numpy."""

from __future__ import annotations

import numpy as np
from skfem import MeshQuad

from meshes.blocks import Blocks


def laid_mesh(blocks: Blocks) -> MeshQuad:
    """Make a mesh of squares, or of rows that grow away from the interface.

    Corners come first, then the inner nodes of the sides and those of the surfaces, upper block
    before lower one.  Elements go column by column, each counter-clockwise.
    """
    shape = (blocks.left + blocks.right + 1, blocks.height + 1)  # columns and rows of a block
    place = np.arange(shape[0] * shape[1]).reshape(shape)
    edge = blocks.left
    sides = [place[: edge + 1, 0], place[edge:, 0], place[-1], place[::-1, -1], place[0, ::-1]]
    stages = (
        np.array([side[0] for side in sides]),
        np.concatenate([side[1:-1] for side in sides]),
        place[1:-1, 1:-1].ravel(),
    )
    numbers = np.empty((len(blocks.names), place.size), dtype=np.int64)
    start = 0
    for stage in stages:
        for number in numbers:
            number[stage] = np.arange(start, start + len(stage))
            start += len(stage)

    points, elements = np.empty((2, blocks.nodes)), []
    x = blocks.size * np.arange(-edge, blocks.right + 1.0)
    for up, number in zip((1, -1), numbers.reshape(-1, *shape), strict=False):
        points[0, number] = x[:, None]
        points[1, number] = up * blocks.rows + 0.0  # without negative zeros
        around = [number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]]
        around = around if up > 0 else [around[0], *around[:0:-1]]
        elements.append(np.stack([corner.ravel() for corner in around]))
    parts = np.arange(blocks.elements).reshape(len(elements), -1)
    named = dict(zip(blocks.names, parts, strict=True))
    return MeshQuad(points, np.concatenate(elements, axis=1), _subdomains=named)
