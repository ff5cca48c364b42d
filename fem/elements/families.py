"""Families of finite elements, and the integrals over single elements that they need."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import skfem
from skfem.element import Element
from skfem.mesh import Mesh

from semianalytic.arrays import Array


@dataclass(frozen=True, eq=False)
class Family:
    """A finite element with its nodes at its corners and a diagonal mass matrix."""

    kind: Element  # shape functions, one node each
    # (points, weights): quadrature with its points at the nodes; it is what makes the mass matrix
    # diagonal
    nodal: tuple[Array, Array]
    order: int  # degree that the quadrature of the stiffness integrates exactly
    shape: type[Mesh]

    @property
    def centre(self) -> Array:
        """Middle of the reference element, (2, 1)."""
        return self.nodal[0].mean(axis=1, keepdims=True)


_CORNERS = np.array([[0.0, 1.0, 0.0, 1.0], [0.0, 0.0, 1.0, 1.0]])
_THREE = (_CORNERS[:, :3], np.full(3, 1 / 6))
_FOUR = (_CORNERS, np.full(4, 1 / 4))

FAMILIES: Mapping[str, Family] = {
    "squares": Family(skfem.ElementQuad1(), _FOUR, 2, skfem.MeshQuad),
    "triangles": Family(skfem.ElementTriP1(), _THREE, 0, skfem.MeshTri),
}
"""Bilinear squares and linear triangles, by the pattern of the mesh."""


FEW = 256
"""Number of elements up to which their integrals are kept, which take at most 0.6 MB."""


@skfem.BilinearForm
def _xx(u, v, _):  # type: ignore[no-untyped-def]
    return u.grad[0] * v.grad[0]


@skfem.BilinearForm
def _yy(u, v, _):  # type: ignore[no-untyped-def]
    return u.grad[1] * v.grad[1]


@skfem.BilinearForm
def _xy(u, v, _):  # type: ignore[no-untyped-def]
    return u.grad[1] * v.grad[0]


@skfem.LinearForm
def _one(v, _):  # type: ignore[no-untyped-def]
    return v


class Integrals(NamedTuple):
    """Integrals over one element of each shape; D_ij = int d_i phi_a d_j phi_b."""

    # (shapes, k, k) arrays: D_xx, D_yy and D_yx, symmetric but for the last
    xx: Array
    yy: Array
    xy: Array
    # (shapes, k) array: int phi_a, by the quadrature that makes the mass matrix diagonal [length^2]
    area: Array


def apart(kind: type[Mesh], corners: Array, count: int) -> Mesh:
    """Return a mesh of so many elements that share no node, from their corners in turn, (2, n)."""
    numbers = np.arange(corners.shape[1]).reshape(count, -1)
    return kind(corners, np.ascontiguousarray(numbers.T))


def integrals_of(family: Family, elements: Mesh) -> Integrals:
    """Return the integrals over elements that share no node, by scikit-fem.

    Those over a few elements are kept, since meshes of one size consist of the same elements: they
    take 10 of the 35 ms in which a model of 3,000 unknowns is built.
    """
    if elements.nelements > FEW:
        return _integrals(family, elements)
    corners = np.ascontiguousarray(elements.p).tobytes()
    return _integrals_of_few(family, corners, elements.nelements)


def _integrals(family: Family, elements: Mesh) -> Integrals:
    inside = skfem.Basis(elements, family.kind, intorder=family.order)
    at_nodes = skfem.Basis(elements, family.kind, quadrature=family.nodal)
    xx, yy, xy = (form.elemental(inside).tolocal() for form in (_xx, _yy, _xy))
    return Integrals(xx, yy, xy, _one.elemental(at_nodes).tolocal())


@lru_cache(maxsize=32)
def _integrals_of_few(family: Family, corners: bytes, count: int) -> Integrals:
    elements = apart(family.shape, np.frombuffer(corners).reshape(2, -1), count)
    return _integrals(family, elements)
