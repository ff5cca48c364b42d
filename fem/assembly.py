"""Plane-strain stiffness and lumped mass of several elements, assembled by scikit-fem."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from skfem import (
    Basis,
    BilinearForm,
    ElementQuad1,
    ElementQuad2,
    ElementTriP1,
    FacetBasis,
    LinearForm,
    MeshQuad,
    MeshTri,
    asm,
)
from skfem.element import Element
from skfem.mesh import Mesh

from semianalytic.scene.errors import SceneError
from semianalytic.scene.scene import Material


@dataclass(frozen=True)
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
    triangular : bool
    centre : (2, 1) array
        Middle of the reference element.
    """

    name: str
    kind: Element
    nodal: tuple[NDArray[np.float64], NDArray[np.float64]]
    order: int
    spacing: int
    triangular: bool
    centre: NDArray[np.float64]


def _tensor(
    points: NDArray[np.float64], weights: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Product rule on the unit square."""
    x, y = np.meshgrid(points, points)
    return np.array([x.ravel(), y.ravel()]), np.outer(weights, weights).ravel()


_TRIANGLE = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
_ENDS = (np.array([0.0, 1.0]), np.array([0.5, 0.5]))
_SIMPSON = (np.array([0.0, 0.5, 1.0]), np.array([1.0, 4.0, 1.0]) / 6)
_MIDDLE = np.full((2, 1), 0.5)

FAMILIES: Mapping[str, Family] = {
    family.name: family
    for family in (
        Family("P1", ElementTriP1(), (_TRIANGLE, np.full(3, 1 / 6)), 0, 1, True, _MIDDLE * 2 / 3),
        Family("Q1", ElementQuad1(), _tensor(*_ENDS), 2, 1, False, _MIDDLE),
        Family("Q2", ElementQuad2(), _tensor(*_SIMPSON), 4, 2, False, _MIDDLE),
    )
}
"""Linear triangles, bilinear and biquadratic quadrilaterals, the last with Gauss-Lobatto mass."""


@dataclass(frozen=True)
class Space:
    """Nodes of one family on a mesh.

    Parameters
    ----------
    mesh : Mesh
        Of the shape the family needs.
    family : Family
    """

    mesh: Mesh
    family: Family

    @cached_property
    def basis(self) -> Basis:
        """Shape functions in the middle of each element."""
        middle = (self.family.centre, np.ones(1))
        return Basis(self.mesh, self.family.kind, quadrature=middle)

    @cached_property
    def points(self) -> NDArray[np.float64]:
        """Places of the nodes [length], (2, n)."""
        return self.basis.doflocs

    def side_nodes(self, side: str) -> NDArray[np.int64]:
        """Nodes of a named side, in order of increasing x and then |y|."""
        nodes = self.basis.get_dofs(self.mesh.boundaries[side]).all()
        x, y = self.points[:, nodes]
        return nodes[np.lexsort((np.abs(y), x))]


def find_family(element: str, pattern: str) -> Family:
    """Family of a name, to be used on meshes of a pattern.

    Raises
    ------
    SceneError
        If there is none, or it needs quadrilaterals and the pattern has triangles.
    """
    if element not in FAMILIES:
        known = ", ".join(FAMILIES)
        raise SceneError(f"simulate: element must be one of {known}, got {element!r}.")
    family = FAMILIES[element]
    if pattern == "triangles" and not family.triangular:
        raise SceneError(f"simulate: {element} needs quadrilaterals; choose P1 or another mesh.")
    return family


def make_space(mesh: MeshQuad | MeshTri, family: Family) -> Space:
    """Nodes of a family on a mesh; quadrilaterals are cut in two for triangles."""
    if isinstance(mesh, MeshQuad) and family.triangular:
        mesh = mesh.to_meshtri()
    return Space(mesh, family)


@BilinearForm
def _xx(u, v, _):  # type: ignore[no-untyped-def]
    return u.grad[0] * v.grad[0]


@BilinearForm
def _yy(u, v, _):  # type: ignore[no-untyped-def]
    return u.grad[1] * v.grad[1]


@BilinearForm
def _xy(u, v, _):  # type: ignore[no-untyped-def]
    return u.grad[1] * v.grad[0]


@LinearForm
def _one(v, _):  # type: ignore[no-untyped-def]
    return v


def stiffness(space: Space, materials: Mapping[str, Material]) -> sparse.csr_array:
    """Stiffness K in plane strain, the blocks with the same or different materials.

    With D_ij = int d_i phi_a d_j phi_b, the block of two nodes a, b is

        [ (lambda + 2 mu) D_xx + mu D_yy      lambda D_xy + mu D_yx            ]
        [ lambda D_yx + mu D_xy               (lambda + 2 mu) D_yy + mu D_xx   ]

    so three scalar matrices are all that has to be integrated.

    Parameters
    ----------
    space : Space
        n nodes.
    materials : mapping from the name of a block to its Material

    Returns
    -------
    (2 n, 2 n) CSR array
        Force per unit thickness per displacement [stress]; unknown 2 a + i is component i of
        node a.  Entries that cancel between neighbouring elements are left out.
    """
    nodes = space.points.shape[1]
    total = sparse.csr_array((2 * nodes, 2 * nodes))
    for name, basis in _block_bases(space, materials):
        mu, bulk = _moduli(materials[name])
        dxx, dyy, dxy = (asm(form, basis) for form in (_xx, _yy, _xy))
        across = (bulk - 2 * mu) * dxy + mu * dxy.T
        blocks = {
            (0, 0): bulk * dxx + mu * dyy,
            (0, 1): across,
            (1, 0): across.T,
            (1, 1): bulk * dyy + mu * dxx,
        }
        for place, block in blocks.items():
            unit = sparse.coo_array(([1.0], ([place[0]], [place[1]])), shape=(2, 2))
            total = total + sparse.kron(block, unit, format="csr")
    least = 1e-13 * min(_moduli(material)[1] for material in materials.values())
    total.data[np.abs(total.data) < least] = 0.0
    total.eliminate_zeros()
    return sparse.csr_array(
        (total.data, total.indices.astype(np.int32), total.indptr.astype(np.int32)),
        shape=total.shape,
    )


def lumped_mass(space: Space, materials: Mapping[str, Material]) -> NDArray[np.float64]:
    """Mass of each node per unit thickness, (n,) [mass / length], by quadrature at the nodes."""
    mass = np.zeros(space.points.shape[1])
    for name, basis in _block_bases(space, materials, quadrature=space.family.nodal):
        mass += materials[name].density * asm(_one, basis)
    return mass


def tributary_length(space: Space, side: str) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Nodes of a horizontal side and the length of the side that belongs to each.

    Inner nodes of linear elements own h, the two end nodes h/2: so an edge node at x = 0 owns h/2
    of the slot face and h/2 of the contact face, and one at x > 0 (`fem.edge`) as much less of
    the slot and more of the contact.  With Q2, nodes own 2/3 h and 4/3 h in turn, the ends 1/3 h.

    Parameters
    ----------
    space : Space
    side : str
        Name of a boundary.

    Returns
    -------
    nodes : (m,) array
        In order of increasing x.
    lengths : (m,) array
        int phi ds over the side [length].
    """
    nodes = space.side_nodes(side)
    facets = FacetBasis(space.mesh, space.family.kind, facets=space.mesh.boundaries[side])
    lengths = asm(_one, facets)[nodes]
    if side.endswith("_contact"):
        lengths[0] += space.points[0, nodes[0]]
    elif side.endswith("_slot"):
        lengths[-1] -= space.points[0, nodes[-1]]
    return nodes, lengths


def _block_bases(
    space: Space, materials: Mapping[str, Material], **options: Any
) -> Iterator[tuple[str, Basis]]:
    """Shape functions on each block, all at once where the materials are the same."""
    options = options or {"intorder": space.family.order}
    if len(set(materials.values())) == 1:
        yield next(iter(materials)), Basis(space.mesh, space.family.kind, **options)
        return
    for name in materials:
        elements = space.mesh.subdomains[name]
        yield name, Basis(space.mesh, space.family.kind, elements=elements, **options)


def _moduli(material: Material) -> tuple[float, float]:
    """mu and lambda + 2 mu [stress]."""
    return material.shear_modulus, material.density * material.longitudinal_speed**2
