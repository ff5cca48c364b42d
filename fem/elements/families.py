"""Families of finite elements, and the integrals over single elements that they need."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import skfem
from numpy.typing import NDArray
from skfem.element import Element
from skfem.mesh import Mesh

from semianalytic.scene.errors import SceneError


@dataclass(frozen=True, eq=False)
class Family:
    """A finite element with a diagonal mass matrix.

    Attributes
    ----------
    name : str
    kind : Element
        Shape functions, one node each.
    nodal : (points, weights)
        Quadrature with its points at the nodes; it is what makes the mass matrix diagonal.
    order : int
        Degree that the quadrature of the stiffness integrates exactly.
    spacing : int
        Node distances per element side.
    side : (spacing + 1,) array
        Fraction of an element side that belongs to each of its nodes.
    triangular : bool
    centre : (2, 1) array
        Middle of the reference element.
    """

    name: str
    kind: Element
    nodal: tuple[NDArray[np.float64], NDArray[np.float64]]
    order: int
    spacing: int
    side: NDArray[np.float64]
    triangular: bool
    centre: NDArray[np.float64]


def _tensor(
    points: NDArray[np.float64], weights: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the product rule on the unit square."""
    x, y = np.meshgrid(points, points)
    return np.array([x.ravel(), y.ravel()]), np.outer(weights, weights).ravel()


_CORNERS = (np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]), np.full(3, 1 / 6))
_ENDS = (np.array([0.0, 1.0]), np.array([0.5, 0.5]))
_SIMPSON = (np.array([0.0, 0.5, 1.0]), np.array([1.0, 4.0, 1.0]) / 6)
_MIDDLE = np.full((2, 1), 0.5)

FAMILIES: Mapping[str, Family] = {
    family.name: family
    for family in (
        Family("P1", skfem.ElementTriP1(), _CORNERS, 0, 1, _ENDS[1], True, _MIDDLE * 2 / 3),
        Family("Q1", skfem.ElementQuad1(), _tensor(*_ENDS), 2, 1, _ENDS[1], False, _MIDDLE),
        Family("Q2", skfem.ElementQuad2(), _tensor(*_SIMPSON), 4, 2, _SIMPSON[1], False, _MIDDLE),
    )
}
"""Linear triangles, bilinear and biquadratic quadrilaterals, the last with Gauss-Lobatto mass."""


FEW = 256
"""Number of elements up to which their integrals are kept, which take at most 0.6 MB."""


def find_family(element: str, pattern: str) -> Family:
    """Return the element family of a name, for meshes of a pattern; SceneError if there is none."""
    if element not in FAMILIES:
        known = ", ".join(FAMILIES)
        raise SceneError(f"simulate: element must be one of {known}, got {element!r}.")
    family = FAMILIES[element]
    if pattern == "triangles" and not family.triangular:
        raise SceneError(f"simulate: {element} needs quadrilaterals; choose P1 or another mesh.")
    return family


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
    """Integrals over one element of each shape; D_ij = int d_i phi_a d_j phi_b.

    Attributes
    ----------
    xx, yy, xy : (shapes, k, k) arrays
        D_xx, D_yy and D_yx, symmetric but for the last.
    area : (shapes, k) array
        int phi_a, by the quadrature that makes the mass matrix diagonal [length^2].
    """

    xx: NDArray[np.float64]
    yy: NDArray[np.float64]
    xy: NDArray[np.float64]
    area: NDArray[np.float64]


def apart(kind: type[Mesh], corners: NDArray[np.float64], count: int) -> Mesh:
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
    kind = skfem.MeshTri if family.triangular else skfem.MeshQuad
    return _integrals(family, apart(kind, np.frombuffer(corners).reshape(2, -1), count))
