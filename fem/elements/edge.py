"""The place of the edge of a closed contact on a mesh: next to its first node, not at it.

Displacement is fixed at the nodes n >= 0 of the interface and tractions are given at n < 0.  Far
from the edge, the fields are those of a body whose edge is a fraction of h from node 0.
That is a Wiener-Hopf problem with the static surface stiffness of the meshed half-plane,

    k(theta) = mu / (1 - nu) 2 sin(theta/2) g(theta),    theta = wave number times h,  g(0) = 1,

in antiplane shear without 1 - nu.  The first factor splits into (1 - z)^(1/2) (1 - 1/z)^(1/2),
z = exp(i theta), whose coefficients Gamma(n + 1/2) / Gamma(n + 1) = (n + 1/4)^(-1/2) (1 + O(n^-2))
are a square root that begins at n = -1/4; the factors of g move its beginning by the slope of
their logarithm.  In all

    x / h = -1/4 - (1 / 4 pi) int_0^pi ln g(theta) / sin^2(theta/2) d theta.

In antiplane shear g is sqrt(1 - sin^2(theta/2) / 3), which makes that -sqrt(2/3)/4.

So node 0 is laid at minus that, which puts the edge at x = 0.  Where tractions are given on both
sides, at a slipping or open contact, the edge is where their shares of node 0 meet (see
`fem.elements.assembly.tributary_length`), which is x = 0 as well.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from skfem import MeshQuad

from fem.elements.assembly import IN_PLANE, OUT_OF_PLANE, STIFFNESS, Space
from semianalytic.scene.arrays import Array
from semianalytic.scene.scene import Material

ANGLES = np.pi * (np.arange(32) + 0.5) / 32
"""Number of points of the midpoint rule, which converges exponentially."""
DOUBLINGS = 14
"""Number of times that the depth of the meshed half-plane is doubled."""
FARTHEST = 0.49
"""Largest distance of an edge from its node, over h: beyond h/2 another node would be nearer."""


def edge_offset(materials: Iterable[Material], held: int = 1) -> float:
    """Return the place of the first node of a closed contact on squares, over h.

    It is 0.24 at nu = 1/3.  It is rounded to millionths, so that a run is the same to the
    last bit with any linear algebra library, and is at most `FARTHEST`, which matters for
    nu > 0.483.  Each of the two materials counts in proportion to its compliance.  The contact
    holds component 1 where it is closed, 0 where it is stuck, whose edge is elsewhere (0.40 h at
    nu = 1/3), 2 where it is stuck in antiplane shear (0.20 h).
    """
    bodies = list(materials)
    compliance = [1 / _static_modulus(body, held) for body in bodies]
    offsets = [_offset(body, held) for body in bodies]
    return min(round(float(np.average(offsets, weights=compliance)), 6), FARTHEST)


@lru_cache(maxsize=32)
def _offset(material: Material, held: int) -> float:
    ahead = _static_modulus(material, held) * 2 * np.sin(ANGLES / 2)
    components = next(pair for pair in (IN_PLANE, OUT_OF_PLANE) if held in pair)
    own = components.index(held)
    # the other component is free: one over its compliance
    stiffness = surface_stiffness(material, ANGLES, components)
    compliance = np.linalg.inv(stiffness)[:, own, own].real
    return float(0.25 - np.mean(np.log(compliance * ahead) / np.sin(ANGLES / 2) ** 2) / 4)


def _static_modulus(material: Material, held: int) -> float:
    """Return the static stiffness of a half-plane's surface over the wavenumber [stress]."""
    if held in OUT_OF_PLANE:
        return material.shear_modulus
    return material.shear_modulus / (1 - material.poisson_ratio)


def surface_stiffness(
    material: Material,
    angles: Array,
    components: tuple[int, ...] = IN_PLANE,
) -> NDArray[np.complex128]:
    """Return the static surface stiffness of a half-plane of unit squares [stress], (n, m, m).

    It is the force on each node of the surface y = 0 of y > 0 per displacement of it in m
    components, both multiplied by exp(i theta x), for angles theta > 0 (n,).  Rows are eliminated
    by cyclic reduction, every other one at a time.
    """
    patch = MeshQuad.init_tensor(np.arange(3.0), np.arange(4.0))
    space = Space(patch)
    count = len(components)
    matrix = STIFFNESS[components](space, material)
    blocks = matrix.toarray().reshape(12, count, 12, count)
    x, y = np.rint(space.points)

    def coupling(row: int, other: int) -> NDArray[np.complex128]:
        """Return the force on the middle node of a row per displacement of another row."""
        node = int(np.flatnonzero((x == 1) & (y == row))[0])
        nodes = np.flatnonzero(y == other)
        waves = np.exp(1j * np.outer(angles, x[nodes] - 1))
        return np.einsum("tn,inj->tij", waves, blocks[node][:, nodes])

    surface, inner = coupling(0, 0), coupling(1, 1)
    inwards, outwards = coupling(1, 2), coupling(1, 0)
    for _ in range(DOUBLINGS):
        solved = np.linalg.inv(inner)
        up, down = inwards @ solved, outwards @ solved
        surface = surface - up @ outwards
        inner = inner - up @ outwards - down @ inwards
        inwards, outwards = -up @ inwards, -down @ outwards
    return surface
