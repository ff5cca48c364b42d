"""Pictures of the whole fields in both blocks: one VTU file per frame and a PVD index."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path

import meshio
import numpy as np
from numpy.typing import NDArray

from fem.model import Model
from semianalytic.scene import Scene

INDEX = "fields.pvd"
CELLS = {"P1": "triangle", "Q1": "quad", "Q2": "quad9"}
"""Names VTK gives to the elements, whose nodes scikit-fem puts in the same order."""

MIRRORED = {"P1": [0, 2, 1], "Q1": [0, 3, 2, 1], "Q2": [0, 3, 2, 1, 7, 6, 5, 4, 8]}
"""Order of the nodes of an element that turns its mirror image counter-clockwise again."""


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
    frames : iterable of (time, name)
        Frames of an interrupted run to go on from.

    Attributes
    ----------
    frames : list of (time, name)
        What the index lists.
    """

    def __init__(
        self,
        directory: str | Path,
        model: Model,
        scene: Scene,
        frames: Iterable[tuple[float, str]] = (),
    ) -> None:
        self.directory = Path(directory)
        self.directory.mkdir(parents=True, exist_ok=True)
        self.model, self.scene = model, scene
        points, cells = both_blocks(model)
        self._points = np.pad(points.T, ((0, 0), (0, 1)))
        self._cells = [(CELLS[model.space.family.name], cells.T)]
        self.frames = [(time, name) for time, name in frames if (self.directory / name).is_file()]
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
        name = f"fields-{len(self.frames) + 1:04d}.vtu"
        part = self.directory / f"{name}.part"
        meshio.write(part, frame, file_format="vtu")
        os.replace(part, self.directory / name)
        self.frames.append((time, name))
        self._write_index()

    def _stress(self, displacement: NDArray[np.float64]) -> tuple[NDArray[np.float64], ...]:
        materials, base = self.model.materials, self.scene.base
        (uxx, uxy), (uyx, uyy) = self._gradient(displacement)
        lower = self._points[self._cells[0][1], 1].mean(axis=1) < 0
        mu, bulk = (
            np.where(lower, *(value(materials[name]) for name in ("lower", "upper")))
            for value in (
                lambda material: material.shear_modulus,
                lambda material: material.density * material.longitudinal_speed**2,
            )
        )
        return (
            bulk * uxx + (bulk - 2 * mu) * uyy,
            bulk * uyy + (bulk - 2 * mu) * uxx - base.pressure,
            mu * (uxy + uyx) + base.shear,
        )

    def _gradient(self, displacement: NDArray[np.float64]) -> NDArray[np.float64]:
        """Gradient d_j u_i in the middle of each element, (2, 2, elements), index i first."""
        basis = self.model.space.basis
        gradients = [
            [basis.interpolate(component.copy()).grad[..., 0] for component in part.T]
            for part in np.split(displacement, len(displacement) // basis.N)
        ]
        for mirrored in gradients[1:]:
            for gradient in mirrored:
                gradient[1] *= -1
        return np.concatenate(gradients, axis=2)

    def _write_index(self) -> None:
        entries = "".join(
            f'    <DataSet timestep="{time!r}" part="0" file="{name}"/>\n'
            for time, name in self.frames
        )
        part = self.directory / f"{INDEX}.part"
        part.write_text(
            '<?xml version="1.0"?>\n'
            '<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">\n'
            f"  <Collection>\n{entries}  </Collection>\n</VTKFile>\n"
        )
        os.replace(part, self.directory / INDEX)


def both_blocks(model: Model) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Places (2, n) of the nodes of both blocks, and the nodes (k, m) of each element.

    A half gets its mirror image, whose nodes and elements come after its own.
    """
    points, cells = model.space.points, model.space.basis.element_dofs
    if not model.odd:
        return points, cells
    mirrored = cells[MIRRORED[model.space.family.name]] + points.shape[1]
    return (
        np.concatenate([points, points * [[1], [-1]]], axis=1),
        np.concatenate([cells, mirrored], axis=1),
    )


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
