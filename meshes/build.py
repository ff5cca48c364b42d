"""Meshes of a block: squares, or triangles of gmsh, which are kept in the user's cache folder."""

from __future__ import annotations

import errno
import hashlib
import logging
import os
import signal
import threading
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import asdict
from importlib.resources import files
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from platformdirs import user_cache_dir
from skfem import MeshQuad, MeshTri

from meshes.blocks import Blocks
from meshes.read import read_mesh
from semianalytic.results.files import Seal, check_seal, new_file
from semianalytic.scene.errors import DataFileError, MissingLibraryError
from semianalytic.scene.extras import how_to_install

_log = logging.getLogger(__name__)

FORMAT = "slipfront blocks 4"
APT_PACKAGES = files("meshes").joinpath("apt-packages.txt").read_text(encoding="ascii").strip()
"""Debian packages of the shared libraries that libgmsh is linked against; CI installs them too."""
LAST_LINE = b"$EndElements\n"
"""Last line of a mesh file that gmsh could write to its end."""


def cache_directory() -> Path:
    """Return the folder of cached meshes: $SLIPFRONT_CACHE, or the system's place for caches."""
    return Path(os.environ.get("SLIPFRONT_CACHE") or user_cache_dir("slipfront"))


def cache_path(blocks: Blocks) -> Path:
    """Return the file in which the mesh of these blocks is cached."""
    key = repr((FORMAT, sorted(asdict(blocks).items())))
    return cache_directory() / f"blocks-{hashlib.sha256(key.encode()).hexdigest()[:20]}.msh"


def mesh_of(blocks: Blocks) -> MeshQuad | MeshTri:
    """Return the mesh of the upper block; triangles come from the cache, or are built and kept.

    A damaged file in the cache is built again, which costs only time.

    Parameters
    ----------
    blocks : Blocks

    Returns
    -------
    MeshQuad, or MeshTri for the pattern "triangles"
        `side_nodes` finds the nodes of a side.

    Raises
    ------
    MissingLibraryError
        If triangles have to be built, and gmsh cannot be loaded.
    DataFileError
        If the cache folder cannot be written, or a mesh just built cannot be read.
    """
    if blocks.pattern != "triangles":
        x = blocks.size * np.arange(-blocks.left, blocks.right + 1.0)
        mesh = MeshQuad.init_tensor(x, blocks.size * np.arange(blocks.height + 1.0))
        return MeshQuad(mesh.p, np.ascontiguousarray(mesh.t[::-1]))  # counter-clockwise
    path = cache_path(blocks)
    # what is damaged is replaced, and what cannot be looked at is not there
    with suppress(DataFileError, OSError, ValueError):
        if path.is_file():
            check_seal(path)
            mesh = read_mesh(path, blocks)
            _log.debug("mesh read from %s", path)
            return mesh
    try:
        with new_mesh_file(blocks, path) as part:
            write_mesh(blocks, part)
            mesh = read_mesh(part, blocks)
        _log.debug("mesh built and kept in %s", path)
    except DataFileError as error:
        raise DataFileError(
            f"the mesh cache {path.parent} cannot be used ({str(error).rstrip('.')}); "
            "set SLIPFRONT_CACHE to a folder of your own with room for it."
        ) from error
    return mesh


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
