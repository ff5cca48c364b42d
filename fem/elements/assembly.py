"""Squares and triangles: stiffness in plane strain and antiplane shear, and lumped mass."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any, NamedTuple

import numpy as np
import skfem
from numpy.typing import NDArray
from scipy import sparse
from skfem import Basis
from skfem.element import Element
from skfem.mesh import Mesh

from meshes import side_nodes
from semianalytic.scene.arrays import Array
from semianalytic.scene.scene import Material


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


ROUNDED = 1e-13
"""Entries of a stiffness matrix below this fraction of the stiffest modulus count as zero."""
SAME_SHAPE = 1e-12
"""Largest difference of the corners of elements of one shape, over the largest element."""


@dataclass(frozen=True)
class Shapes:
    """Elements grouped by shape: integrals over one element are those of all of its shape."""

    kind: NDArray[np.int64]  # (elements,) array: number of the shape of each element
    samples: Mesh  # one element of each shape, in the order of the numbers; they share no node


def element_shapes(mesh: Mesh) -> Shapes:
    """Group elements by shape; elements that are shifts of one another have the same shape.

    Squares have a few shapes, by the numbering of their corners.  If most elements have a shape of
    their own, as unstructured triangles do, each gets its own.
    """
    corners = mesh.p[:, mesh.t]
    offsets = corners[:, 1:] - corners[:, :1]
    steps = np.rint(offsets / (SAME_SHAPE * np.abs(offsets).max())).astype(np.int64)
    steps = steps.reshape(-1, mesh.nelements)
    # one number instead of all steps, which are compared once elements are sorted by it
    weights = np.random.default_rng(0).integers(1, 2**20, len(steps))
    _, first, kind = np.unique(weights @ steps, return_index=True, return_inverse=True)
    if 2 * len(first) > mesh.nelements or not np.array_equal(steps, steps[:, first[kind]]):
        first = kind = np.arange(mesh.nelements)
    samples = np.ascontiguousarray(corners[:, :, first].transpose(0, 2, 1)).reshape(2, -1)
    return Shapes(kind, apart(type(mesh), samples, len(first)))


@dataclass(frozen=True)
class Space:
    """A mesh of squares or triangles, whose corners are the nodes."""

    mesh: Mesh

    @property
    def family(self) -> Family:
        """Element family."""
        return next(family for family in FAMILIES.values() if isinstance(self.mesh, family.shape))

    @cached_property
    def basis(self) -> Basis:
        """Shape functions at the centre of each element."""
        middle = (self.family.centre, np.ones(1))
        return Basis(self.mesh, self.family.kind, quadrature=middle)

    @property
    def points(self) -> Array:
        """Positions of the nodes [length], (2, n)."""
        return self.mesh.p

    @property
    def element_nodes(self) -> NDArray[np.int64]:
        """Nodes of each element, (k, elements)."""
        return self.mesh.t

    @cached_property
    def shapes(self) -> Shapes:
        """Groups of elements that differ in their position only."""
        return element_shapes(self.mesh)

    @cached_property
    def integrals(self) -> Integrals:
        """Integrals over one element of each shape."""
        return integrals_of(self.family, self.shapes.samples)


def stiffness(
    space: Space, material: Material, place: NDArray[np.int64] | None = None
) -> sparse.csr_array:
    """Assemble the stiffness K in plane strain.

    scikit-fem integrates one element of each shape; the matrices are then added up over all
    elements to (2 n, 2 n), force per unit thickness per displacement [stress]; unknown 2 a + i is
    component i of node a.  Nodes have new numbers (n,) if a place is given for each; nodes of the
    same number are the same one.  Entries that cancel between neighbouring elements are left out.
    """
    local, assembled = _element_stiffness(space, material), _assembler(space, place)
    # two matrices at a time, as real and imaginary part
    along = assembled(local[..., 0, 0] + 1j * local[..., 1, 1])
    across = assembled(local[..., 0, 1] + 1j * local[..., 1, 0])
    entries = np.array([[along.data.real, across.data.real], [across.data.imag, along.data.imag]])
    count, least = along.shape[0], ROUNDED * _moduli(material)[1]
    entries[np.abs(entries) < least] = 0.0
    blocks = (np.ascontiguousarray(entries.transpose(2, 0, 1)), along.indices, along.indptr)
    total = sparse.bsr_array(blocks, shape=(2 * count, 2 * count)).tocsr()
    total.eliminate_zeros()
    return total


def antiplane_stiffness(
    space: Space, material: Material, place: NDArray[np.int64] | None = None
) -> sparse.csr_array:
    """Assemble the (n, n) stiffness of displacement along z, mu (D_xx + D_yy), like `stiffness`."""
    local = material.shear_modulus * (space.integrals.xx + space.integrals.yy)
    total = _assembler(space, place)(local)
    least = ROUNDED * material.shear_modulus
    total.data[np.abs(total.data) < least] = 0.0
    total.eliminate_zeros()
    return total


X, Y, Z = range(3)
IN_PLANE, OUT_OF_PLANE = (X, Y), (Z,)
"""Displacement components that a body moves in, one unknown of a node after the other."""

STIFFNESS: Mapping[tuple[int, ...], Callable[..., sparse.csr_array]] = {
    IN_PLANE: stiffness,
    OUT_OF_PLANE: antiplane_stiffness,
}


def _assembler(
    space: Space, place: NDArray[np.int64] | None
) -> Callable[[NDArray[Any]], sparse.csr_array]:
    """Return a function that assembles scalar matrices from local ones, (k, k) for each shape."""
    kind, nodes = space.shapes.kind, space.element_nodes.T
    nodes = nodes if place is None else place[nodes]
    count, corners = int(nodes.max()) + 1, nodes.shape[1]
    rows = np.repeat(nodes, corners, axis=1).astype(np.int32).ravel()
    columns = np.tile(nodes, corners).astype(np.int32).ravel()

    def assembled(local: NDArray[Any]) -> sparse.csr_array:
        values = local[kind].ravel()
        return sparse.coo_array((values, (rows, columns)), shape=(count, count)).tocsr()

    return assembled


def lumped_mass(space: Space, material: Material, place: NDArray[np.int64] | None = None) -> Array:
    """Return the mass of each node per unit thickness, (n,) [mass / length], like `stiffness`.

    Quadrature at the nodes makes the mass matrix diagonal.
    """
    nodes = space.element_nodes if place is None else place[space.element_nodes]
    mass = material.density * space.integrals.area[space.shapes.kind].T
    return np.asarray(np.bincount(nodes.ravel(), mass.ravel()), dtype=np.float64)


def tributary_length(space: Space, side: str) -> tuple[NDArray[np.int64], Array]:
    """Return the nodes of a horizontal side and the length of the side that belongs to each.

    They are in order of increasing x; the lengths are int phi ds over the side [length].  Inner
    nodes own h, the two end nodes h/2: so an edge node at x = 0 owns h/2 of the slot face and h/2
    of the contact face, and one at x > 0 (`fem.elements.edge`) as much less of the slot and more of
    the contact.
    """
    nodes = side_nodes(space.points, side)
    halves = np.diff(space.points[0, nodes]) / 2
    lengths = np.pad(halves, (1, 0)) + np.pad(halves, (0, 1))
    if side == "contact":
        lengths[0] += space.points[0, nodes[0]]
    elif side == "slot":
        lengths[-1] -= space.points[0, nodes[-1]]
    return nodes, lengths


def _element_stiffness(space: Space, material: Material) -> Array:
    """Integrate the stiffness of an element of each shape, (shapes, k, k, 2, 2) [stress].

    With D_ij = int d_i phi_a d_j phi_b, the block of two nodes a, b is

        [ (lambda + 2 mu) D_xx + mu D_yy      lambda D_xy + mu D_yx            ]
        [ lambda D_yx + mu D_xy               (lambda + 2 mu) D_yy + mu D_xx   ]

    so three scalar matrices are all that has to be integrated.
    """
    mu, bulk = _moduli(material)
    dxx, dyy, dxy = (integral.swapaxes(1, 2) for integral in space.integrals[:3])
    dyx, lame = dxy.swapaxes(1, 2), bulk - 2 * mu
    rows = [[bulk * dxx + mu * dyy, lame * dxy + mu * dyx]]
    rows += [[lame * dyx + mu * dxy, bulk * dyy + mu * dxx]]
    return np.array(rows).transpose(2, 3, 4, 0, 1)


def _moduli(material: Material) -> tuple[float, float]:
    """Return mu and lambda + 2 mu of a material [stress]."""
    return material.shear_modulus, material.density * material.longitudinal_speed**2
