"""Pictures of the whole fields in both blocks: one VTU file per frame and a PVD index."""

from __future__ import annotations

import os
from pathlib import Path

import meshio
import numpy as np
from numpy.typing import NDArray
from skfem import Basis, ElementQuad1, ElementVector, MeshQuad

from fem.model import Model
from semianalytic.scene import Scene

INDEX = "fields.pvd"
CENTRE = (np.array([[0.5], [0.5]]), np.array([1.0]))


class Snapshots:
    """Writes frames into a folder, each complete before it gets its name and enters the index.

    A run that is interrupted leaves a valid index of the frames written so far.

    Point data: `displacement` since t = 0 and `velocity`, padded to three components.
    Cell data: `sigma_xx`, `sigma_yy`, `sigma_xy` at the centre of each element, tension
    positive.  The base tractions are part of sigma_yy and sigma_xy; they do not determine the
    initial sigma_xx, so that one is the change since t = 0.

    Parameters
    ----------
    directory : path
        Made if it is not there; frames of the same number are replaced.
    model : Model
    scene : Scene
    """

    def __init__(self, directory: str | Path, model: Model, scene: Scene) -> None:
        self.directory = Path(directory)
        self.directory.mkdir(parents=True, exist_ok=True)
        self.model, self.scene = model, scene
        mesh = both_blocks(model)
        self._points = np.pad(mesh.p.T, ((0, 0), (0, 1)))
        self._cells = [("quad", mesh.t.T)]
        self._basis = Basis(mesh, ElementVector(ElementQuad1()), quadrature=CENTRE)
        self._frames: list[tuple[float, str]] = []
        self._write_index()

    def write(self, time: float) -> None:
        """Add a frame at a time level whose kick is done and whose drift is not."""
        bodies, step = self.model.bodies, self.model.time_step
        displacement = spread(self.model, [body.displacement for body in bodies])
        velocity = spread(self.model, [(b.before + b.increment) / (2 * step) for b in bodies])
        sxx, syy, sxy = self._stress(displacement)
        frame = meshio.Mesh(
            self._points,
            self._cells,
            point_data={
                "displacement": np.pad(displacement, ((0, 0), (0, 1))),
                "velocity": np.pad(velocity, ((0, 0), (0, 1))),
            },
            cell_data={"sigma_xx": [sxx], "sigma_yy": [syy], "sigma_xy": [sxy]},
        )
        name = f"fields-{len(self._frames) + 1:04d}.vtu"
        part = self.directory / f"{name}.part"
        meshio.write(part, frame, file_format="vtu")
        os.replace(part, self.directory / name)
        self._frames.append((time, name))
        self._write_index()

    def _stress(self, displacement: NDArray[np.float64]) -> tuple[NDArray[np.float64], ...]:
        material, base = self.scene.material, self.scene.base
        mu = material.shear_modulus
        bulk = material.density * material.longitudinal_speed**2  # lambda + 2 mu
        unknowns = np.empty(self._basis.N)
        unknowns[self._basis.nodal_dofs] = displacement.T
        (uxx, uxy), (uyx, uyy) = self._basis.interpolate(unknowns).grad[..., 0]
        return (
            bulk * uxx + (bulk - 2 * mu) * uyy,
            bulk * uyy + (bulk - 2 * mu) * uxx - base.pressure,
            mu * (uxy + uyx) + base.shear,
        )

    def _write_index(self) -> None:
        entries = "".join(
            f'    <DataSet timestep="{time!r}" part="0" file="{name}"/>\n'
            for time, name in self._frames
        )
        part = self.directory / f"{INDEX}.part"
        part.write_text(
            '<?xml version="1.0"?>\n'
            '<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">\n'
            f"  <Collection>\n{entries}  </Collection>\n</VTKFile>\n"
        )
        os.replace(part, self.directory / INDEX)


def both_blocks(model: Model) -> MeshQuad:
    """Mesh of both blocks; a half gets its mirror image, whose nodes come after its own."""
    mesh = model.mesh
    if not model.odd:
        return mesh
    points = np.concatenate([mesh.p, mesh.p * [[1], [-1]]], axis=1)
    mirrored = mesh.t[[0, 3, 2, 1]] + mesh.nvertices  # still counter-clockwise
    return MeshQuad(points, np.concatenate([mesh.t, mirrored], axis=1))


def spread(model: Model, unknowns: list[NDArray[np.float64]]) -> NDArray[np.float64]:
    """Vectors at the nodes of `both_blocks` from the unknowns of each body.

    Parameters
    ----------
    model : Model
    unknowns : list of (2 n,) arrays
        Mass-normalised, one per body.

    Returns
    -------
    (n or 2 n, 2) array
    """
    fields = [(u / model.root).reshape(-1, 2)[model.numbering.place] for u in unknowns]
    upper = np.sum(fields, axis=0)
    if not model.odd:
        return upper
    lower = np.zeros_like(upper)
    for odd, vectors in zip(model.odd, fields, strict=True):
        lower += vectors * [-1 if i == odd else 1 for i in (0, 1)]
    return np.concatenate([upper, lower])
