"""Build meshes with gmsh's built-in geometry kernel, or without gmsh where it is missing."""

from __future__ import annotations

import errno
import os
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from importlib.resources import files
from itertools import pairwise
from pathlib import Path
from typing import Any

from meshes.blocks import GROWTH, Blocks
from meshes.laid import LEAST_SIDES, write_laid
from semianalytic.results.files import Seal, new_file
from semianalytic.scene.errors import MissingLibraryError
from semianalytic.scene.extras import how_to_install

APT_PACKAGES = files("meshes").joinpath("apt-packages.txt").read_text(encoding="ascii").strip()
"""Debian packages of the shared libraries that libgmsh is linked against; CI installs them too."""

Tell = Callable[[str], object]
"""A function that receives a sentence."""

LAST_LINE = b"$EndElements\n"
"""Last line of a mesh file that gmsh could write to its end."""


def build_mesh(blocks: Blocks, path: str | Path, tell: Tell | None = None) -> None:
    """Mesh the blocks and write them as binary MSH 4.1.

    The file appears under its name only when complete.

    Parameters
    ----------
    blocks : Blocks
    path : path
        Where to write; the folder must exist.
    tell : callable, optional
        Called with a sentence if gmsh cannot be loaded and the mesh is laid without it.

    Raises
    ------
    MissingLibraryError
        If gmsh cannot be loaded and the mesh cannot be laid without it.
    DataFileError
        If the file cannot be written.
    """
    with new_mesh_file(blocks, path) as part:
        write_mesh(blocks, part, tell)


def new_mesh_file(blocks: Blocks, path: str | Path) -> AbstractContextManager[Path]:
    """Open a sealed file for the mesh of blocks, like `semianalytic.results.files.new_file`."""
    return new_file(path, _size(blocks), Seal.MSH, suffix=".msh")


def write_mesh(blocks: Blocks, part: Path, tell: Tell | None = None) -> None:
    """Mesh the blocks into a file that exists; `tell` as in `build_mesh`.

    Raises
    ------
    MissingLibraryError
        As `build_mesh`.
    OSError
        If the file cannot be written.
    """
    try:
        gmsh = _loaded_gmsh()
    except (ImportError, OSError) as error:
        if not _can_be_laid(blocks):
            raise MissingLibraryError(_refusal(blocks, error)) from error
        write_laid(blocks, part)
        if tell is not None:
            tell(
                f"gmsh cannot be loaded ({error}), so the {_pattern(blocks)} is laid without it, "
                "node for node the same."
            )
    else:
        _write_with(gmsh, blocks, part)
    # gmsh goes on without a word when the disk is full
    with part.open("rb") as stream:
        stream.seek(-min(len(LAST_LINE), stream.seek(0, os.SEEK_END)), os.SEEK_END)
        if stream.read() != LAST_LINE:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def _loaded_gmsh() -> Any:
    """Import and return gmsh, which loads libgmsh and the libraries it is linked against."""
    import gmsh

    return gmsh


def _can_be_laid(blocks: Blocks) -> bool:
    """Return whether `meshes.laid` can lay the blocks."""
    shortest = min(blocks.left, blocks.right, blocks.height)
    return blocks.pattern != "triangles" and shortest >= LEAST_SIDES


def _pattern(blocks: Blocks) -> str:
    """Describe the mesh in words."""
    return "graded mesh" if blocks.pattern == "graded" else f"mesh of {blocks.pattern}"


def _refusal(blocks: Blocks, error: Exception) -> str:
    """Make the error that says why blocks cannot be meshed without gmsh, and what to do."""
    triangles = blocks.pattern == "triangles"
    what = _pattern(blocks) + ("" if triangles else " with a side of a single element")
    other = "choose squares or a graded mesh" if triangles else "make every side longer"
    if isinstance(error, ImportError):
        remedy = f"run {how_to_install('fem')}"
    else:
        remedy = f"install its libraries with `apt install {APT_PACKAGES}`"
    return f"a {what} needs gmsh, which cannot be loaded ({error}); {remedy}, or {other}."


def _write_with(gmsh: Any, blocks: Blocks, part: Path) -> None:
    """Let gmsh mesh the blocks into a file that exists."""
    with _empty_model(gmsh):
        for block in blocks.names:
            _add_block(gmsh, blocks, block)
        gmsh.option.setNumber("Mesh.Algorithm", 6)  # frontal Delaunay, for triangles
        gmsh.model.mesh.generate(2)
        gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
        gmsh.option.setNumber("Mesh.Binary", 1)
        part.stat()  # a folder that has gone meanwhile is found out here
        gmsh.write(str(part))


def _size(blocks: Blocks) -> int:
    """Return the approximate size of a mesh file [bytes]: nodes of 32 and elements of 40."""
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
