"""Building the blocks with gmsh's built-in geometry kernel."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import pairwise
from pathlib import Path
from typing import Any

from meshes.blocks import GROWTH, Blocks
from semianalytic.errors import MissingLibraryError

APT_PACKAGES = (
    "libglu1-mesa libgl1 libxrender1 libxcursor1 libxfixes3 libxext6 libxft2 libfontconfig1 "
    "libxinerama1 libx11-6 libgomp1"
)
"""Debian packages of the shared libraries that libgmsh is linked against."""


def build_mesh(blocks: Blocks, path: str | Path) -> None:
    """Mesh the blocks and write them as binary MSH 4.1.

    The file appears under its name only when complete.

    Parameters
    ----------
    blocks : Blocks
    path : path
        Where to write; the folder must exist.

    Raises
    ------
    MissingLibraryError
        If gmsh cannot be loaded because a system library is missing.
    OSError
        If the folder cannot be written.
    """
    path = Path(path)
    part = path.with_name(f".{path.stem}.{os.getpid()}.msh")
    part.touch()  # a folder that cannot be written is found out at once
    try:
        with _gmsh_model() as gmsh:
            for block in blocks.names:
                _add_block(gmsh, blocks, block)
            gmsh.option.setNumber("Mesh.Algorithm", 6)  # frontal Delaunay, for triangles
            gmsh.model.mesh.generate(2)
            gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
            gmsh.option.setNumber("Mesh.Binary", 1)
            gmsh.write(str(part))
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)


def _add_block(gmsh: Any, blocks: Blocks, block: str) -> None:
    """Add one rectangle with its own points and curves, nothing shared with the other one."""
    geo = gmsh.model.geo
    up = 1 if block == "upper" else -1
    left, right = -blocks.left * blocks.size, blocks.right * blocks.size
    far = up * blocks.far

    slot_end, edge, contact_end, far_right, far_left = (
        geo.addPoint(x, y, 0) for x, y in ((left, 0), (0, 0), (right, 0), (right, far), (left, far))
    )
    loop = (slot_end, edge, contact_end, far_right, far_left, slot_end)
    curves = [geo.addLine(start, end) for start, end in pairwise(loop)]
    # counter-clockwise around the block, so that every element has positive area
    surface = geo.addPlaneSurface([geo.addCurveLoop([up * c for c in curves[::up]])])

    sides = blocks.sides(block)
    for curve, elements in zip(curves, sides.values(), strict=True):
        geo.mesh.setTransfiniteCurve(curve, elements + 1)
    if blocks.pattern == "graded":
        _, _, right_side, _, left_side = curves  # away from the interface, and back to it
        for curve, growth in ((right_side, GROWTH), (left_side, 1 / GROWTH)):
            geo.mesh.setTransfiniteCurve(curve, blocks.height + 1, "Progression", growth)
    if blocks.pattern != "triangles":
        corners = [slot_end, contact_end, far_right, far_left]
        geo.mesh.setTransfiniteSurface(surface, "Left", corners)
        geo.mesh.setRecombine(2, surface)
    geo.synchronize()

    for curve, name in zip(curves, sides, strict=True):
        gmsh.model.addPhysicalGroup(1, [curve], name=name)
    gmsh.model.addPhysicalGroup(2, [surface], name=block)


@contextmanager
def _gmsh_model() -> Iterator[Any]:
    """An empty gmsh model; gmsh is silent and leaves Ctrl-C and its configuration alone."""
    try:
        import gmsh
    except OSError as error:
        raise MissingLibraryError(
            f"gmsh cannot be loaded ({error}); install its libraries with "
            f"`apt install {APT_PACKAGES}`."
        ) from error

    ours = not gmsh.isInitialized()
    if ours:
        gmsh.initialize(readConfigFiles=False, interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.model.add("slipfront")
    try:
        yield gmsh
    finally:
        gmsh.model.remove()
        if ours:
            gmsh.finalize()
