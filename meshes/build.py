"""Build meshes of triangles with gmsh's built-in geometry kernel."""

from __future__ import annotations

import errno
import os
import signal
import threading
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from importlib.resources import files
from itertools import pairwise
from pathlib import Path
from typing import Any

from meshes.blocks import Blocks
from semianalytic.results.files import Seal, new_file
from semianalytic.scene.errors import MissingLibraryError
from semianalytic.scene.extras import how_to_install

APT_PACKAGES = files("meshes").joinpath("apt-packages.txt").read_text(encoding="ascii").strip()
"""Debian packages of the shared libraries that libgmsh is linked against; CI installs them too."""
LAST_LINE = b"$EndElements\n"
"""Last line of a mesh file that gmsh could write to its end."""


def new_mesh_file(blocks: Blocks, path: str | Path) -> AbstractContextManager[Path]:
    """Open a sealed file for the mesh of blocks, like `semianalytic.results.files.new_file`."""
    size = 32 * blocks.nodes + 40 * blocks.elements  # about [bytes]
    return new_file(path, size, Seal.MSH, suffix=".msh")


def write_mesh(blocks: Blocks, part: Path) -> None:
    """Mesh the blocks into a file that exists; MissingLibraryError if gmsh cannot be loaded."""
    try:
        import gmsh  # which loads libgmsh and the libraries it is linked against
    except (ImportError, OSError) as error:
        remedy = f"install its libraries with `apt install {APT_PACKAGES}`"
        if isinstance(error, ImportError):
            remedy = f"run {how_to_install('fem')}"
        raise MissingLibraryError(
            f"a mesh of triangles needs gmsh, which cannot be loaded ({error}); {remedy}, or "
            "choose squares."
        ) from error
    with _empty_model(gmsh):
        _add_block(gmsh, blocks)
        gmsh.option.setNumber("Mesh.Algorithm", 6)  # frontal Delaunay
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


def _add_block(gmsh: Any, blocks: Blocks) -> None:
    """Add the rectangle with sides of whole elements."""
    geo, far = gmsh.model.geo, blocks.far
    left, right = -blocks.left * blocks.size, blocks.right * blocks.size
    corners = ((left, 0), (0, 0), (right, 0), (right, far), (left, far))
    loop = [geo.addPoint(x, y, 0) for x, y in corners]
    curves = [geo.addLine(start, end) for start, end in pairwise([*loop, loop[0]])]
    # counter-clockwise around the block, so that every element has positive area
    surface = geo.addPlaneSurface([geo.addCurveLoop(curves)])
    for curve, elements in zip(curves, blocks.sides.values(), strict=True):
        geo.mesh.setTransfiniteCurve(curve, elements + 1)
    geo.synchronize()
    gmsh.model.addPhysicalGroup(2, [surface], name="block")  # of which elements are written


@contextmanager
def _signals_kept() -> Iterator[None]:
    """Restore the signal handlers that gmsh replaces, those of SIGTERM and SIGPIPE among them.

    Only the main thread can restore them; elsewhere they are left to gmsh.
    """
    before = {number: signal.getsignal(number) for number in signal.valid_signals()}
    yield
    if threading.current_thread() is not threading.main_thread():
        return
    for number, done in before.items():
        if done is not None and done is not signal.SIG_DFL:
            signal.signal(number, done)


@contextmanager
def _empty_model(gmsh: Any) -> Iterator[None]:
    """Open an empty gmsh model; gmsh is silent and does not touch Ctrl-C or its configuration."""
    ours = not gmsh.isInitialized()
    if ours:
        with _signals_kept():
            gmsh.initialize(readConfigFiles=False, interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.model.add("slipfront")
    try:
        yield
    finally:
        gmsh.model.remove()
        if ours:
            gmsh.finalize()
