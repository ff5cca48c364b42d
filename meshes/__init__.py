"""Meshes of the blocks that meet along y = 0: their description, construction and cache."""

import logging

from semianalytic.scene.extras import needing

logging.getLogger(__name__).addHandler(logging.NullHandler())  # silent unless asked

with needing("the mesh of a finite-element model"):
    from meshes.blocks import Blocks, causal_blocks
    from meshes.build import cache_directory, mesh_of
    from meshes.read import side_nodes

__all__ = [
    "Blocks",
    "cache_directory",
    "causal_blocks",
    "mesh_of",
    "side_nodes",
]
