"""Building the blocks with gmsh's built-in geometry kernel."""

from __future__ import annotations

import errno
import os
import signal
import threading
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from itertools import pairwise
from pathlib import Path
from typing import Any

from meshes.blocks import GROWTH, Blocks
from semianalytic.results.files import Seal, new_file
from semianalytic.scene.errors import MissingLibraryError
from semianalytic.scene.extras import needing

APT_PACKAGES = (
    "libglu1-mesa libgl1 libxrender1 libxcursor1 libxfixes3 libxext6 libxft2 libfontconfig1 "
    "libxinerama1 libx11-6 libgomp1"
)
"""Debian packages of the shared libraries that libgmsh is linked against."""

LAST_LINE = b"$EndElements\n"
"""Of a mesh file that gmsh could write to its end."""


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
    DataFileError
        If the file cannot be written.
    """
    with new_mesh_file(blocks, path) as part:
        write_mesh(blocks, part)


def new_mesh_file(blocks: Blocks, path: str | Path) -> AbstractContextManager[Path]:
    """A sealed file for the mesh of these blocks, as `semianalytic.results.files.new_file`."""
    return new_file(path, _size(blocks), Seal.MSH, suffix=".msh")


def write_mesh(blocks: Blocks, part: Path) -> None:
    """Mesh the blocks into a file that is there.

    Raises
    ------
    MissingLibraryError
        If gmsh cannot be loaded because a system library is missing.
    OSError
        If the file cannot be written.
    """
    with _gmsh_model() as gmsh:
        for block in blocks.names:
            _add_block(gmsh, blocks, block)
        gmsh.option.setNumber("Mesh.Algorithm", 6)  # frontal Delaunay, for triangles
        gmsh.model.mesh.generate(2)
        gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
        gmsh.option.setNumber("Mesh.Binary", 1)
        part.stat()  # a folder that has gone meanwhile is found out here
        gmsh.write(str(part))
    # gmsh goes on without a word when the disk is full
    with part.open("rb") as stream:
        stream.seek(-min(len(LAST_LINE), stream.seek(0, os.SEEK_END)), os.SEEK_END)
        if stream.read() != LAST_LINE:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def _size(blocks: Blocks) -> int:
    """About how large the file of a mesh gets [bytes]: nodes of 32 and elements of 40."""
    return 32 * blocks.nodes + 40 * blocks.elements


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
def _signals_kept() -> Iterator[None]:
    """Put back what is done on signals, SIGTERM and SIGPIPE among them, which gmsh forgets.

    Only the main thread can; elsewhere it is left to gmsh.
    """
    before = {number: signal.getsignal(number) for number in signal.valid_signals()}
    yield
    if threading.current_thread() is not threading.main_thread():
        return
    for number, done in before.items():
        if done is not None and done is not signal.SIG_DFL:
            signal.signal(number, done)


@contextmanager
def _gmsh_model() -> Iterator[Any]:
    """An empty gmsh model; gmsh is silent and leaves Ctrl-C and its configuration alone."""
    try:
        with needing("the mesh of a finite-element model"):
            import gmsh
    except OSError as error:
        raise MissingLibraryError(
            f"gmsh cannot be loaded ({error}); install its libraries with "
            f"`apt install {APT_PACKAGES}`."
        ) from error

    ours = not gmsh.isInitialized()
    if ours:
        with _signals_kept():
            gmsh.initialize(readConfigFiles=False, interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.model.add("slipfront")
    try:
        yield gmsh
    finally:
        gmsh.model.remove()
        if ours:
            gmsh.finalize()
