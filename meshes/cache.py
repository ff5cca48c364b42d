"""Meshes of a block: squares, or triangles, which are kept in the user's cache folder."""

from __future__ import annotations

import hashlib
import logging
import os
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path

import numpy as np
from platformdirs import user_cache_dir
from skfem import MeshQuad, MeshTri

from meshes.blocks import Blocks
from meshes.build import new_mesh_file, write_mesh
from meshes.read import read_mesh
from semianalytic.results.files import check_seal
from semianalytic.scene.errors import DataFileError

_log = logging.getLogger(__name__)

FORMAT = "slipfront blocks 4"


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
