"""Plane-strain stiffness and lumped mass on quadrilaterals, assembled by scikit-fem."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from skfem import Basis, BilinearForm, ElementQuad1, FacetBasis, LinearForm, MeshQuad, asm

from semianalytic.scene import Material

CORNERS = (np.array([[0.0, 1.0, 1.0, 0.0], [0.0, 0.0, 1.0, 1.0]]), np.full(4, 0.25))
"""Quadrature at the corners of the reference square: it makes the mass matrix diagonal."""


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


def stiffness(mesh: MeshQuad, material: Material) -> sparse.csr_array:
    """Stiffness K of bilinear quadrilaterals with full 2 x 2 Gauss quadrature, plane strain.

    With D_ij = int d_i phi_a d_j phi_b, the block of two nodes a, b is

        [ (lambda + 2 mu) D_xx + mu D_yy      lambda D_xy + mu D_yx            ]
        [ lambda D_yx + mu D_xy               (lambda + 2 mu) D_yy + mu D_xx   ]

    so three scalar matrices are all that has to be integrated.

    Parameters
    ----------
    mesh : MeshQuad
        n nodes.
    material : Material

    Returns
    -------
    (2 n, 2 n) CSR array
        Force per unit thickness per displacement [stress]; unknown 2 a + i is component i of
        node a.  Entries that cancel between neighbouring elements are left out.
    """
    mu = material.shear_modulus
    bulk = material.density * material.longitudinal_speed**2  # lambda + 2 mu
    basis = Basis(mesh, ElementQuad1(), intorder=2)
    dxx, dyy, dxy = (asm(form, basis) for form in (_xx, _yy, _xy))
    across = (bulk - 2 * mu) * dxy + mu * dxy.T
    blocks = {
        (0, 0): bulk * dxx + mu * dyy,
        (0, 1): across,
        (1, 0): across.T,
        (1, 1): bulk * dyy + mu * dxx,
    }
    total = sparse.csr_array((2 * mesh.nvertices, 2 * mesh.nvertices))
    for place, block in blocks.items():
        unit = sparse.coo_array(([1.0], ([place[0]], [place[1]])), shape=(2, 2))
        total = total + sparse.kron(block, unit, format="csr")
    total.data[np.abs(total.data) < 1e-13 * bulk] = 0.0
    total.eliminate_zeros()
    return sparse.csr_array(
        (total.data, total.indices.astype(np.int32), total.indptr.astype(np.int32)),
        shape=total.shape,
    )


def lumped_mass(mesh: MeshQuad, density: float) -> NDArray[np.float64]:
    """Mass of each node per unit thickness, (n,) [mass / length], by quadrature at the corners."""
    return density * asm(_one, Basis(mesh, ElementQuad1(), quadrature=CORNERS))


def tributary_length(mesh: MeshQuad, side: str) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Nodes of a horizontal side and the length of the side that belongs to each.

    Inner nodes own h, the two end nodes h/2: so the edge node x = 0 owns h/2 of the slot face
    and h/2 of the contact face.

    Parameters
    ----------
    mesh : MeshQuad
    side : str
        Name of a boundary.

    Returns
    -------
    nodes : (m,) array
        In order of increasing x.
    lengths : (m,) array
        int phi ds over the side [length].
    """
    facets = mesh.boundaries[side]
    nodes = np.unique(mesh.facets[:, facets])
    nodes = nodes[np.argsort(mesh.p[0, nodes])]
    lengths = asm(_one, FacetBasis(mesh, ElementQuad1(), facets=facets))
    return nodes, lengths[nodes]
