"""A half-plane by finite elements with prescribed tractions or motion on its surface.

It checks Lamb's functions and the two kernels of section 4 independently.  Bilinear squares, lumped
mass and central differences solve the equation of motion (4.1) without any transform.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from skfem import Basis, BilinearForm, ElementQuad1, ElementVector, MeshQuad, asm
from skfem.helpers import ddot, sym_grad, trace

from semianalytic import Material
from semianalytic.halfplane.rayleigh import Mode
from semianalytic.reference.kernels import SlipHistory

Array = NDArray[np.float64]
Field = Callable[[Array, Array], Array]
_STEP_RATIO = 0.9  # relative to h / c_l; squares are stable up to 0.98


@dataclass(frozen=True, eq=False)
class SurfaceMotion:
    """Motion of the surface y = 0 of the half-plane y > 0 at the end time.

    Attributes
    ----------
    x : (n,) array
        Positions of the nodes [length].
    displacement : (2, n) array
        Displacements u_x and u_y [length].
    traction : array
        Traction that the prescribed motion requires [stress].  `slipping_half_plane` gives (n,),
        sigma_xy in mode II and pressure in mode I; `loaded_half_plane` gives (2, n), all zero.
        Where the surface is free, it is 0.
    """

    x: Array
    displacement: Array
    traction: Array


def loaded_half_plane(
    material: Material,
    pressure: Field,
    shear: Field,
    *,
    end_time: float,
    element_size: float,
    half_width: float,
) -> SurfaceMotion:
    """March a half-plane under tractions p(x, t) and sigma_xy(x, t) on its whole surface.

    Parameters
    ----------
    material : Material
    pressure, shear : callable
        Smooth functions (x, t) -> array [stress], zero before t = 0.
    end_time : float
        Time at which the march ends [time].
    element_size : float
        Size of the elements [length].
    half_width : float
        Distance of the traction-free side walls from x = 0 [length].
    """
    plane = _HalfPlane.build(material, element_size, half_width, end_time)
    surface = plane.surface

    def force(time: float) -> Array:
        now = np.full(len(plane.x), time)
        load = np.zeros(plane.unknowns)
        load[surface[0]] = -shear(plane.x, now) * plane.length
        load[surface[1]] = pressure(plane.x, now) * plane.length
        return load

    return plane.march(force, None, None)


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

    By symmetry, the component that is not prescribed is free of traction everywhere.

    Parameters
    ----------
    slip : SlipHistory
        Velocity of the upper face, tangential in mode II, normal in mode I: the one-sided V of
        the article's (4.1), half of the relative slip rate.
    """
    plane = _HalfPlane.build(material, element_size, half_width, end_time)
    component = 0 if mode == "II" else 1
    # the edge node moves with the contact
    moved = plane.x > -element_size / 2
    unknowns = plane.surface[component][moved]
    place = np.maximum(plane.x[moved], 0.0)

    def velocity(time: float) -> Array:
        return slip.slip_rate(place, np.full(len(place), time))

    motion = plane.march(None, unknowns, velocity)
    sign = -1.0 if mode == "II" else 1.0
    return SurfaceMotion(motion.x, motion.displacement, sign * motion.traction[component])


@BilinearForm
def _strain_energy(u, v, w):  # type: ignore[no-untyped-def]
    strain, virtual = sym_grad(u), sym_grad(v)
    return w["lam"] * trace(strain) * trace(virtual) + 2 * w["mu"] * ddot(strain, virtual)


@dataclass(frozen=True)
class _HalfPlane:
    """Mass-normalised half-plane; surface[i] holds the unknowns of component i, by x."""

    matrix: sparse.csr_array
    root: Array
    surface: NDArray[np.int64]
    x: Array
    length: Array
    time_step: float
    steps: int

    @property
    def unknowns(self) -> int:
        return len(self.root)

    @classmethod
    def build(
        cls, material: Material, size: float, half_width: float, end_time: float
    ) -> _HalfPlane:
        speed, mu = material.longitudinal_speed, material.shear_modulus
        columns = 2 * round(half_width / size)
        # waves reflected at the bottom must not return to the surface
        depth = round(speed * end_time / (2 * size)) + 4
        mesh = MeshQuad.init_tensor(
            size * (np.arange(columns + 1) - columns // 2), size * np.arange(depth + 1)
        )
        basis = Basis(mesh, ElementVector(ElementQuad1()), intorder=2)
        stiffness = asm(_strain_energy, basis, lam=material.density * speed**2 - 2 * mu, mu=mu)
        ends = np.ptp(mesh.p, axis=1)
        on_border = sum(
            (mesh.p[i] == mesh.p[i].min()) | (np.abs(mesh.p[i] - mesh.p[i].min() - ends[i]) < 1e-9)
            for i in (0, 1)
        )
        mass = material.density * size**2 * 0.5**on_border
        root = np.empty(2 * mesh.nvertices)
        root[basis.nodal_dofs] = np.sqrt(mass)
        scaling = sparse.diags_array(1 / root)
        nodes = np.flatnonzero(mesh.p[1] == 0)
        nodes = nodes[np.argsort(mesh.p[0, nodes])]
        length = np.full(len(nodes), size)
        length[[0, -1]] = size / 2
        steps = int(np.ceil(end_time * speed / (_STEP_RATIO * size)))
        return cls(
            sparse.csr_array(scaling @ stiffness @ scaling),
            root,
            basis.nodal_dofs[:, nodes],
            mesh.p[0, nodes],
            length,
            end_time / steps,
            steps,
        )

    def march(
        self,
        force: Callable[[float], Array] | None,
        moved: NDArray[np.int64] | None,
        velocity: Callable[[float], Array] | None,
    ) -> SurfaceMotion:
        """March by central differences; return the surface and the reactions of moved unknowns."""
        step = self.time_step
        position, increment = np.zeros(self.unknowns), np.zeros(self.unknowns)
        reaction = np.zeros(self.unknowns)
        for n in range(self.steps + 1):
            kick = -(self.matrix @ position)
            if force is not None:
                kick += force(n * step) / self.root
            kick *= step**2 * (0.5 if n == 0 else 1.0)
            after = increment + kick
            if moved is not None and velocity is not None:
                prescribed = step * velocity((n + 0.5) * step) * self.root[moved]
                if n == self.steps:
                    reaction[moved] = (prescribed - after[moved]) / step**2 * self.root[moved]
                after[moved] = prescribed
            increment = after
            if n < self.steps:
                position += increment
        shown = (position / self.root)[self.surface]
        return SurfaceMotion(self.x, shown, reaction[self.surface] / self.length)
