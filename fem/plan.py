"""From the options of a run to its mesh, before anything is built."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from skfem import MeshQuad

from fem.assembly import Family, find_family, lumped_mass, make_space, stiffness
from fem.model import LOCKSTEP, TWO_BLOCKS, TWO_MATERIALS, choose_model
from fem.settings import Settings
from fem.stepping import critical_step, highest_frequency, normalised
from meshes import Blocks, causal_blocks
from meshes.blocks import observed_slot
from semianalytic.scene.errors import SceneError
from semianalytic.scene.scene import Material, Scene

PATCH = 8
"""Elements along a side of the patch on which the fastest mode is looked for."""

TRIANGLES = 1.156
"""Nodes of an unstructured mesh over those of squares of the same side, measured."""


@dataclass(frozen=True)
class Plan:
    """What is going to be simulated.

    Parameters
    ----------
    scene : Scene
    settings : Settings
    lower_material : Material or None
        Of the lower block, if it is another one.
    full : bool
        Whether whole fields are observed, not only the interface.

    Raises
    ------
    SceneError
        If the mesh would be too large, the element does not fit the mesh, or different materials
        slide ahead of all waves.
    """

    scene: Scene
    settings: Settings
    lower_material: Material | None
    full: bool

    def __post_init__(self) -> None:
        if self.name == TWO_MATERIALS and self.scene.far_slip_rate:
            raise SceneError(
                "simulate: blocks of different materials cannot slide ahead of all waves; "
                "raise friction or lower the base shear."
            )

    @property
    def name(self) -> str:
        """Name of the model."""
        return choose_model(self.scene, self.settings.model, self.lower_material)

    @property
    def materials(self) -> list[Material]:
        """Those in the mesh, each once."""
        return list(
            dict.fromkeys((self.scene.material, self.lower_material or self.scene.material))
        )

    @property
    def fastest(self) -> Material:
        """The material whose waves are faster."""
        return max(self.materials, key=lambda material: material.longitudinal_speed)

    @property
    def size(self) -> float:
        """Distance h of the nodes on the interface [length]."""
        reach = self.scene.material.shear_speed * self.settings.end_time
        return reach / self.settings.resolution

    @property
    def damping_time(self) -> float:
        """eta of the damping C = eta K [time]."""
        return self.settings.damping * self.size / self.scene.material.shear_speed

    @property
    def family(self) -> Family:
        """Element family."""
        return find_family(self.settings.element, self.settings.mesh)

    @property
    def slot_length(self) -> float:
        """Length of slot next to the edge that is stored [length]."""
        return observed_slot(self.fastest, self.settings.end_time, full=self.full)

    @property
    def blocks(self) -> Blocks:
        """What is meshed."""
        return causal_blocks(
            self.fastest,
            self.settings.end_time,
            self.size * self.family.spacing,
            damping_time=self.damping_time,
            full=self.full,
            lower=self.name in (TWO_BLOCKS, TWO_MATERIALS),
            free_walls=self.name == TWO_MATERIALS,
            pattern=self.settings.mesh,
        )

    @property
    def nodes(self) -> int:
        """Number of nodes of the mesh; an estimate for unstructured triangles."""
        blocks, spacing = self.blocks, self.family.spacing
        columns = (blocks.left + blocks.right) * spacing + 1
        count = len(blocks.names) * columns * (blocks.height * spacing + 1)
        return round(TRIANGLES * count) if blocks.pattern == "triangles" else count

    @property
    def bodies(self) -> int:
        """How many bodies march on the mesh."""
        return 2 if self.name == LOCKSTEP else 1

    def steps(self) -> int:
        """Number of steps to the end time.

        The fastest mode sits in the corners of the blocks: a patch of a few elements has it too.
        """
        blocks, family = self.blocks, self.family
        rows = blocks.rows[: PATCH + 1]
        x = blocks.size * np.arange(PATCH + 1.0)
        space = make_space(MeshQuad.init_tensor(x, rows), family)
        step = math.inf
        for material in self.materials:
            mass = lumped_mass(space, {"upper": material})
            order = np.arange(len(mass))
            matrix, _ = normalised(stiffness(space, {"upper": material}), mass, order)
            step = min(step, critical_step(highest_frequency(matrix), self.damping_time))
        return math.ceil(self.settings.end_time / (self.settings.step_ratio * step))
