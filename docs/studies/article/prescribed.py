"""A half-plane by finite elements with prescribed tractions or motion on its surface.

It checks Lamb's functions and the kernels of section 4: bilinear squares, lumped mass and central
differences solve the equation of motion (4.1) without any transform.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from skfem import Basis, BilinearForm, ElementQuad1, ElementVector, MeshQuad, asm
from skfem.helpers import ddot, sym_grad, trace

from docs.studies.article.kernels import SlipHistory
from semianalytic import Material
from semianalytic.halfplane.rayleigh import Mode
from semianalytic.scene.arrays import Array

_STEP_RATIO = 0.9  # relative to h / c_l; squares are stable up to 0.98


@dataclass(frozen=True, eq=False)
class SurfaceMotion:
    """Surface of y > 0 at the end: positions (n,), displacements (2, n), and tractions (2, n).

    The traction is what a motion requires, of `slipping_half_plane` (n,) sigma_xy or pressure.
    """

    x: Array
    displacement: Array
    traction: Array


def slipping_half_plane(
    material: Material,
    slip: SlipHistory,
    mode: Mode,
    *,
    end_time: float,
    element_size: float,
    half_width: float,
) -> SurfaceMotion:
    """March the upper block with a prescribed motion of its contact face x > 0, slot face free.

    The component that is not prescribed is free of traction by symmetry; V is one-sided, (4.1).
    """
    plane = half_plane(material, element_size, half_width, end_time)
    component = 0 if mode == "II" else 1
    # the edge node moves with the contact
    moved = plane.x > -element_size / 2
    place = np.maximum(plane.x[moved], 0.0)

    def velocity(time: float) -> Array:
        return slip.slip_rate(place, np.full(len(place), time))

    motion = march(plane, None, plane.surface[component][moved], velocity)
    sign = -1.0 if mode == "II" else 1.0
    return SurfaceMotion(motion.x, motion.displacement, sign * motion.traction[component])


@BilinearForm
def _strain_energy(u, v, w):  # type: ignore[no-untyped-def]
    strain, virtual = sym_grad(u), sym_grad(v)
    return w["lam"] * trace(strain) * trace(virtual) + 2 * w["mu"] * ddot(strain, virtual)


@dataclass(frozen=True)
class HalfPlane:
    """Mass-normalised half-plane; surface[i] holds the unknowns of component i, by x."""

    matrix: sparse.csr_array
    root: Array
    surface: NDArray[np.int64]
    x: Array
    length: Array
    time_step: float
    steps: int


def half_plane(material: Material, size: float, half_width: float, end_time: float) -> HalfPlane:
    """Return a half-plane whose side walls, free of traction, are at a half-width from x = 0."""
    speed, mu = material.longitudinal_speed, material.shear_modulus
    columns = 2 * round(half_width / size)
    # waves reflected at the bottom must not return to the surface
    depth = round(speed * end_time / (2 * size)) + 4
    places = size * (np.arange(columns + 1) - columns // 2), size * np.arange(depth + 1)
    mesh = MeshQuad.init_tensor(*places)
    basis = Basis(mesh, ElementVector(ElementQuad1()), intorder=2)
    stiffness = asm(_strain_energy, basis, lam=material.density * speed**2 - 2 * mu, mu=mu)
    ends = np.ptp(mesh.p, axis=1)
    on_border = sum(
        (mesh.p[i] == mesh.p[i].min()) | (np.abs(mesh.p[i] - mesh.p[i].min() - ends[i]) < 1e-9)
        for i in (0, 1)
    )
    root = np.empty(2 * mesh.nvertices)
    root[basis.nodal_dofs] = np.sqrt(material.density * size**2 * 0.5**on_border)
    scaling = sparse.diags_array(1 / root)
    nodes = np.flatnonzero(mesh.p[1] == 0)
    nodes = nodes[np.argsort(mesh.p[0, nodes])]
    length = np.full(len(nodes), size)
    length[[0, -1]] = size / 2
    steps = int(np.ceil(end_time * speed / (_STEP_RATIO * size)))
    matrix = sparse.csr_array(scaling @ stiffness @ scaling)
    surface, x = basis.nodal_dofs[:, nodes], mesh.p[0, nodes]
    return HalfPlane(matrix, root, surface, x, length, end_time / steps, steps)


def march(
    plane: HalfPlane,
    force: Callable[[float], Array] | None,
    moved: NDArray[np.int64] | None,
    velocity: Callable[[float], Array] | None,
) -> SurfaceMotion:
    """March by central differences; return the surface and the reactions of moved unknowns."""
    step, root = plane.time_step, plane.root
    position, increment, reaction = (np.zeros(len(root)) for _ in range(3))
    for n in range(plane.steps + 1):
        kick = -(plane.matrix @ position)
        if force is not None:
            kick += force(n * step) / root
        after = increment + kick * step**2 * (0.5 if n == 0 else 1.0)
        if moved is not None and velocity is not None:
            prescribed = step * velocity((n + 0.5) * step) * root[moved]
            if n == plane.steps:
                reaction[moved] = (prescribed - after[moved]) / step**2 * root[moved]
            after[moved] = prescribed
        increment = after
        if n < plane.steps:
            position += increment
    shown = (position / root)[plane.surface]
    return SurfaceMotion(plane.x, shown, reaction[plane.surface] / plane.length)
