"""The plan of a run: everything that follows from its options, before anything is built."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import product
from os import PathLike
from typing import Any

import numpy as np

from fem.elements.assembly import IN_PLANE, OUT_OF_PLANE, X, Y, Z
from fem.elements.edge import edge_offset
from fem.elements.families import Family, find_family
from fem.patch import PATCH, highest_of_patch
from fem.resolution import check_resolved, mesh_caution
from fem.settings import Settings
from fem.stepping import critical_step
from meshes import Blocks, causal_blocks
from meshes.blocks import causal_margin, observed_slot
from semianalytic.scene.checks import checked_size, shown
from semianalytic.scene.contact import wave_slips_ahead
from semianalytic.scene.errors import SceneError
from semianalytic.scene.given.finding import checked_scene
from semianalytic.scene.incident import IncidentWave
from semianalytic.scene.scene import Material, Scene

TRIANGLES = 1.156
"""Measured ratio of the nodes of an unstructured mesh to those of squares of the same side."""
ANTISYMMETRIC = "antisymmetric half"
SYMMETRIC = "symmetric half"
LOCKSTEP = "antisymmetric and symmetric halves in lockstep"
ANTIPLANE = "antiplane half"
ANTIPLANE_LOCKSTEP = "antiplane and symmetric halves in lockstep"
TWO_BLOCKS = "two blocks"
TWO_MATERIALS = "two blocks of different materials"

HALVES: Mapping[str, tuple[int, ...]] = {
    ANTISYMMETRIC: (X,),
    SYMMETRIC: (Y,),
    LOCKSTEP: (X, Y),
    ANTIPLANE: (Z,),
    ANTIPLANE_LOCKSTEP: (Z, Y),
}
"""The displacement component that changes sign from the upper block to the lower one, for each half
of a model; the other component is the same in both."""


def choose_model(scene: Scene, model: str) -> str:
    """Return the name of the model that a scene needs.

    Under shear alone the motion is antisymmetric in y (u_x odd, u_y even) and does not touch
    the pressure; under pressure alone it is symmetric.  Two identical blocks under both are
    the sum of the two: slip feels the pressure, the pressure does not feel the slip.  Antiplane
    shear moves along z alone, oppositely in the two blocks.

    Parameters
    ----------
    scene : Scene
    model : str
        "auto", or "two-blocks" to keep both blocks whatever the symmetry.
    """
    if scene.lower_material is not None:  # there is no symmetry
        return TWO_MATERIALS
    if model == "two-blocks":
        return TWO_BLOCKS
    held, load = scene.superposition
    if load.pressure == 0:
        return ANTIPLANE if scene.antiplane else ANTISYMMETRIC
    if load.shear == 0 == held.shear:
        return SYMMETRIC
    return ANTIPLANE_LOCKSTEP if scene.antiplane else LOCKSTEP


@dataclass(frozen=True)
class Plan:
    """A run before anything is built: its scene, settings, and everything that follows from them.

    Parameters
    ----------
    scene : Scene
    end_time : float
        T [time].
    settings : Settings
    full : bool
        Whether whole fields are observed, not only the interface.
    follows : bool
        Whether the mesh has to follow the loads; that of a companion need not.

    Raises
    ------
    SceneError
        If the end time is out of range, a load swings faster than the mesh can follow, the mesh
        would be too large, the element does not fit the mesh, or different materials slide ahead
        of all waves, or slip along z while pressure makes them slip along x.
    """

    scene: Scene
    end_time: float
    settings: Settings
    full: bool = False
    follows: bool = True

    def __post_init__(self) -> None:
        object.__setattr__(self, "end_time", checked_size("simulate: end_time", self.end_time))
        if self.follows:
            check_resolved(self.scene, self.end_time, self.settings.resolution)
        _check_front(self.scene, self.end_time)
        if self.name == TWO_MATERIALS and isinstance(self.scene.load, IncidentWave):
            raise SceneError(
                "simulate: blocks of different materials reflect an incident wave before it comes "
                "to the slot; leave out lower_material, or load the slot."
            )
        if self.name == TWO_MATERIALS and self.scene.far_slip_rate:
            raise SceneError(
                "simulate: blocks of different materials cannot slide ahead of all waves; "
                "raise friction or lower the shear of the load (docs/limits.md)."
            )
        if self.name == TWO_MATERIALS and self.scene.antiplane and self._pressed:
            raise SceneError(
                "simulate: blocks of different materials slip along x as well where their "
                "pressure changes; keep the pressure of antiplane shear constant "
                "(docs/limits.md)."
            )

    @property
    def slides_ahead(self) -> bool:
        """Whether the contact slides ahead of all waves of the edge, under a load from far away."""
        return wave_slips_ahead(self.scene, self.end_time)

    @property
    def materials(self) -> dict[str, Material]:
        """Materials of the upper and of the lower block."""
        return dict(zip(("upper", "lower"), self.scene.bodies, strict=True))

    @property
    def name(self) -> str:
        """Name of the model."""
        return choose_model(self.scene, self.settings.model)

    @property
    def halves(self) -> tuple[int, ...]:
        """The component of `HALVES` for each body; none if both blocks are in the mesh."""
        return HALVES.get(self.name, ())

    @property
    def bodies(self) -> tuple[tuple[int, ...], ...]:
        """Displacement components of each body that marches on the mesh."""
        if self.halves:
            return tuple(OUT_OF_PLANE if one == Z else IN_PLANE for one in self.halves)
        if not self.scene.antiplane:
            return (IN_PLANE,)
        return (OUT_OF_PLANE, IN_PLANE) if self._pressed else (OUT_OF_PLANE,)

    @property
    def _pressed(self) -> bool:
        """Whether pressure acts on the slot."""
        return self.scene.superposition.taken_off.pressure != 0

    @property
    def size(self) -> float:
        """Distance h of the nodes on the interface [length]."""
        return self.scene.material.shear_speed * self.end_time / self.settings.resolution

    @property
    def edge(self) -> float:
        """Position of the edge node [length]: beside x = 0 if the slot is pressed.

        `fem.elements.edge` says where.  It is at x = 0 under shear alone, where the edge slips, and
        for meshes whose offset is not known: those of Q2, and unstructured ones.
        """
        family, pattern = self.family, self.settings.mesh
        if not self._pressed or family.spacing > 1 or pattern == "triangles":
            return 0.0
        return self.size * edge_offset(self.materials.values(), family)

    @property
    def damping_time(self) -> float:
        """eta of the damping C = eta K [time]."""
        return self.settings.damping * self.size / self.scene.material.shear_speed

    @property
    def forerun(self) -> float:
        """Distance beyond the fastest front at which nodes may already move [length]."""
        return causal_margin(self.scene.fastest_speed, self.end_time, self.size, self.damping_time)

    @property
    def family(self) -> Family:
        """Element family."""
        return find_family(self.settings.element, self.settings.mesh)

    @property
    def slot_length(self) -> float:
        """Length of slot next to the edge that is stored [length]."""
        return observed_slot(self.scene.fastest_speed, self.end_time, full=self.full)

    @property
    def blocks(self) -> Blocks:
        """The blocks that are meshed."""
        return causal_blocks(
            self.scene.fastest_speed,
            self.end_time,
            self.size * self.family.spacing,
            damping_time=self.damping_time,
            full=self.full,
            lower=not self.halves,
            # the walls let plane waves pass that come at once, and disturb those of a moving front
            free_walls=self.name == TWO_MATERIALS or self.scene.front_slowness != 0,
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
    def caution(self) -> str:
        """Sentences that say what the mesh is too coarse for; "" if nothing is known."""
        return mesh_caution(self.scene, self.end_time, self.settings.resolution)

    @cached_property
    def critical_step(self) -> float:
        """Largest stable step [time]; an estimate for unstructured triangles.

        `highest_of_patch` says why a patch of the mesh tells it.
        """
        blocks, settings = self.blocks, self.settings
        rows = tuple(np.round(blocks.rows[: PATCH + 1] / blocks.size, 12).tolist())
        kinds = product(dict.fromkeys(self.materials.values()), dict.fromkeys(self.bodies))
        highest = max(
            material.shear_speed
            * _highest_of_patch(
                settings.element, settings.mesh, rows, material.poisson_ratio, components
            )
            for material, components in kinds
        )
        # The step shortens as the frequency rises, whatever the damping.
        return critical_step(highest / blocks.size, self.damping_time)

    def steps(self, critical: float | None = None) -> int:
        """Number of steps to the end time, from another critical step if one is given [time]."""
        step = self.settings.step_ratio * (critical or self.critical_step)
        return math.ceil(self.end_time / step)


@lru_cache(maxsize=64)
def _highest_of_patch(
    element: str,
    mesh: str,
    rows: tuple[float, ...],
    poisson_ratio: float,
    components: tuple[int, ...],
) -> float:
    """Return the largest eigenfrequency of a patch with rows in element sides [c_t / side]."""
    x, solid = np.arange(PATCH + 1.0), Material(1.0, 1.0, poisson_ratio)
    return highest_of_patch(x, np.array(rows), find_family(element, mesh), solid, components)


def _check_front(scene: Scene, end_time: float) -> None:
    """Raise SceneError if the front of a load was on the slot or made the contact slip before."""
    slowness = scene.front_slowness
    if slowness > 0:
        raise SceneError(
            "simulate: the front of the load comes along the slot, whose faces move before t = 0, "
            "while a simulation begins at rest; let the front meet the contact first (a negative "
            "angle), or solve the scene."
        )
    # waves of the slot come as far as c_l T, which the front has passed |p| c_l T earlier
    until = end_time * (1 + abs(slowness) * scene.fastest_speed)
    if slowness and wave_slips_ahead(scene, until):
        raise SceneError(
            "simulate: the contact slips behind the front of the load before t = 0, while a "
            "simulation begins at rest; raise friction or lower the load."
        )


def make_plan(
    scene: Scene | str | PathLike[str],
    end_time: float | None,
    settings: Settings | None,
    options: Mapping[str, Any],
    *,
    full: bool = False,
) -> Plan:
    """Make the plan of a run from the arguments of `simulate`, `prepare` and `cost`.

    Options are fields of `Settings`, in place of those of `settings`; `full` observes whole fields.

    Raises
    ------
    SceneError
        If a setting is out of range, or for the reasons given at `Plan`.
    """
    if settings is None:
        settings = Settings()
    if not isinstance(settings, Settings):
        raise SceneError(
            f"simulate: settings must be fem.Settings, got {shown(settings)}; "
            "give single options by name, as in resolution=50."
        )
    settings = replace(settings, **options)
    scene = checked_scene("simulate", scene)
    if end_time is None:
        end_time = scene.run.get("end_time", 1 / scene.material.shear_speed)
    return Plan(scene, end_time, settings, full)
