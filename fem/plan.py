"""The plan of a run: everything that follows from its options, before anything is built."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import product
from os import PathLike
from typing import Any

from fem.elements.assembly import IN_PLANE, OUT_OF_PLANE
from fem.elements.edge import edge_offset
from fem.march import highest_of_patch
from fem.resolution import check_resolved, mesh_caution
from fem.settings import COMPANIONS, Settings
from fem.stepping import critical_step
from meshes import Blocks, causal_blocks
from meshes.blocks import observed_slot
from semianalytic.scene.checks import check_fields, checked_size, shown
from semianalytic.scene.contact import wave_slips_ahead
from semianalytic.scene.errors import SceneError
from semianalytic.scene.given.finding import checked_scene
from semianalytic.scene.incident import IncidentWave
from semianalytic.scene.scene import Material, Scene

TRIANGLES, TRIANGLE_STEP = 1.156, 0.67
"""Measured ratios of an unstructured mesh to squares of the same side: of the nodes, and of the
critical step, which was 0.61 to 0.74."""
ANTISYMMETRIC = "antisymmetric half"
ANTIPLANE = "antiplane half"
TWO_BLOCKS = "two blocks"
TWO_MATERIALS = "two blocks of different materials"


@dataclass(frozen=True)
class Plan:
    """A run before anything is built: its scene, settings, and everything that follows from them.

    Raises
    ------
    SceneError
        If the end time is out of range, a load swings faster than the mesh can follow, the mesh
        would be too large, or different materials slide ahead of all waves, or slip along z while
        pressure makes them slip along x.
    """

    scene: Scene
    end_time: float  # T [time]
    settings: Settings
    full: bool = False  # whether whole fields are observed, not only the interface
    # whether the mesh has to follow the loads; that of a companion, whose steps are given by those
    # of its simulation, need not
    follows: bool = True

    def __post_init__(self) -> None:
        check_fields(self, "simulate", ("end_time",), checked_size)
        if self.follows:
            check_resolved(self.scene, self.end_time, self.settings.resolution)
        _check_front(self.scene, self.end_time)
        if self.name == TWO_MATERIALS and isinstance(self.scene.load, IncidentWave):
            raise SceneError(
                "simulate: blocks of different materials reflect an incident wave before it "
                "reaches the slot; leave out lower_material, or load the slot."
            )
        if self.name == TWO_MATERIALS and self.scene.far_slip_rate:
            raise SceneError(
                "simulate: blocks of different materials cannot slide ahead of all waves; "
                "raise friction or lower the shear of the load (docs/limits.md)."
            )
        if self.name == TWO_MATERIALS and self.scene.antiplane and self.is_pressed:
            raise SceneError(
                "simulate: blocks of different materials slip along x as well where their "
                "pressure changes; keep it constant in antiplane shear (docs/limits.md)."
            )

    @property
    def name(self) -> str:
        """Name of the model that the scene needs, or that is asked for.

        Under shear alone identical blocks move oppositely (u_x and u_z odd in y, u_y even), and the
        pressure stays as it was: one of them is enough.
        """
        if self.scene.lower_material is not None:  # there is no symmetry
            return TWO_MATERIALS
        if self.settings.model == "two-blocks" or self.is_pressed:
            return TWO_BLOCKS
        return ANTIPLANE if self.scene.antiplane else ANTISYMMETRIC

    @property
    def is_half(self) -> bool:
        """Whether the upper block alone marches."""
        return self.name in (ANTISYMMETRIC, ANTIPLANE)

    @property
    def bodies(self) -> tuple[tuple[int, ...], ...]:
        """Displacement components of each body that marches in each block."""
        if not self.scene.antiplane:
            return (IN_PLANE,)
        return (OUT_OF_PLANE, IN_PLANE) if self.is_pressed else (OUT_OF_PLANE,)

    @property
    def is_pressed(self) -> bool:
        """Whether pressure acts on the slot."""
        return self.scene.superposition.taken_off.pressure != 0

    @property
    def size(self) -> float:
        """Distance h of the nodes on the interface [length]."""
        return self.scene.material.shear_speed * self.end_time / self.settings.resolution

    @property
    def edge(self) -> float:
        """Position of the edge node [length]: next to x = 0 if the slot is pressed.

        `fem.elements.edge` says where.  It is at x = 0 under shear alone, where the edge slips, and
        for unstructured meshes, whose offset is not known.
        """
        if not self.is_pressed or self.settings.mesh == "triangles":
            return 0.0
        return self.size * edge_offset(self.scene.bodies)

    @property
    def damping_time(self) -> float:
        """eta of the damping C = eta K [time]."""
        return self.settings.damping * self.size / self.scene.material.shear_speed

    @property
    def slot_length(self) -> float:
        """Length of slot next to the edge that is stored [length]."""
        return observed_slot(self.scene.fastest_speed, self.end_time, full=self.full)

    @property
    def blocks(self) -> Blocks:
        """The rectangle that is meshed."""
        return causal_blocks(
            self.scene.fastest_speed,
            self.end_time,
            self.size,
            damping_time=self.damping_time,
            full=self.full,
            # the walls let plane waves pass that come at once, and disturb those of a moving front
            free_walls=self.name == TWO_MATERIALS or self.scene.front_slowness != 0,
            pattern=self.settings.mesh,
        )

    @property
    def nodes(self) -> int:
        """Number of nodes of all blocks; an estimate for unstructured triangles."""
        count = self.blocks.nodes * (1 if self.is_half else 2)
        return round(TRIANGLES * count) if self.settings.mesh == "triangles" else count

    @property
    def caution(self) -> str:
        """Sentences on what the mesh is too coarse for; "" if nothing is known."""
        return mesh_caution(self.scene, self.end_time, self.settings.resolution)

    @cached_property
    def critical_step(self) -> float:
        """Largest stable step [time]; an estimate for unstructured triangles.

        `highest_of_patch` says why a patch of the mesh determines it.
        """
        kinds = product(dict.fromkeys(self.scene.bodies), dict.fromkeys(self.bodies))
        highest = max(
            material.shear_speed * _highest_of_patch(material.poisson_ratio, components)
            for material, components in kinds
        )
        # The step shortens as the frequency rises, whatever the damping.
        step = critical_step(highest / self.size, self.damping_time)
        return TRIANGLE_STEP * step if self.settings.mesh == "triangles" else step

    def steps(self, critical: float | None = None) -> int:
        """Number of steps to the end time, from another critical step if one is given [time].

        A run whose companions take a half and a quarter of its steps is, under self-similar loads,
        each of them until a half and a quarter of its end time, in other units.
        """
        count = self.end_time / (self.settings.step_ratio * (critical or self.critical_step))
        if not self.follows:  # a companion has the ratio that its simulation has
            return round(count)
        return 2**COMPANIONS * math.ceil(count / 2**COMPANIONS)


@lru_cache(maxsize=64)
def _highest_of_patch(poisson_ratio: float, components: tuple[int, ...]) -> float:
    """Return the largest eigenfrequency of a patch of squares [c_t / side]."""
    return highest_of_patch(1.0, Material(1.0, 1.0, poisson_ratio), components)


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
    """Make the plan of a run from the arguments of `simulate` and `cost`.

    Options are fields of `Settings`, in place of those of `settings`; `full` observes whole fields.
    A setting out of range raises SceneError, and so does what `Plan` refuses.
    """
    if settings is None:
        settings = Settings()
    if not isinstance(settings, Settings):
        raise SceneError(
            f"simulate: settings must be fem.Settings, got {shown(settings)}; "
            "give single options by name, as in resolution=50."
        )
    scene = checked_scene("simulate", scene)
    settings = replace(settings, **options)
    if end_time is None:
        end_time = scene.run.get("end_time", 1 / scene.material.shear_speed)
    return Plan(scene, end_time, settings, full)
