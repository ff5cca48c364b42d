"""The plan of a run: everything that follows from its options, before anything is built."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import product
from os import PathLike, fspath
from typing import Any

import numpy as np
from skfem import MeshQuad

from fem.elements.assembly import (
    IN_PLANE,
    OUT_OF_PLANE,
    STIFFNESS,
    Family,
    X,
    Y,
    Z,
    find_family,
    lumped_mass,
    make_space,
)
from fem.elements.edge import edge_offset
from fem.resolution import check_resolved, mesh_caution
from fem.stepping import critical_step, highest_frequency, normalised
from meshes import Blocks, causal_blocks
from meshes.blocks import causal_margin, observed_slot
from semianalytic.scene.checks import (
    check_fields,
    checked_count,
    checked_size,
    shown,
)
from semianalytic.scene.contact import wave_slips_ahead
from semianalytic.scene.errors import SceneError
from semianalytic.scene.given.finding import checked_scene, find_blocks
from semianalytic.scene.incident import IncidentWave
from semianalytic.scene.scene import Material, Scene

LEAST_RESOLUTION = 8
STABLE_RATIO = 1.0
LARGEST_RATIO = 1.5
LARGEST_DAMPING = 100.0
DEFAULT_PACE = 100
"""Steps between checkpoints."""

PATCH = 24
"""Elements along a side of the patch on which the fastest mode is computed."""

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


@dataclass(frozen=True)
class Settings:
    """Settings of a simulation: mesh, elements, time step and what is stored.

    Parameters
    ----------
    resolution : int
        Node distances per c_t T, at least 8: h = c_t T / resolution.
    damping : float
        eta of the Kelvin-Voigt damping C = eta K, in units of h / c_t; 0 for none.
    step_ratio : float
        Largest time step over the critical one, above 0.  Beyond 1 the scheme is unstable; up
        to 1.5 is accepted to show it.
    model : str
        "auto" uses one block where symmetry allows it, which is exact; "two-blocks" never does.
    element : str
        "P1" linear triangles, "Q1" bilinear or "Q2" biquadratic quadrilaterals, all with
        diagonal mass.
    mesh : str
        "squares"; "graded", rows that grow away from the interface; or "triangles",
        unstructured, for P1.  P1 cuts squares and graded rows along a diagonal.
    lower_material : Material, optional
        Material of the lower block, if it differs from the scene's.
    every : int
        Store every n-th step in the histories; the last one is always stored.
    frames : int
        Number of snapshots of the whole fields, if any are written, at evenly spaced steps.

    Raises
    ------
    SceneError
        If one is out of range.

    Examples
    --------
    >>> from fem import Settings, simulate
    >>> from semianalytic import find_scene
    >>> settings = Settings(resolution=8, element="P1", mesh="triangles")
    >>> settings.resolution, settings.every
    (8, 1)
    """

    resolution: int = 100
    damping: float = 0.02
    step_ratio: float = 0.95
    model: str = "auto"
    element: str = "Q1"
    mesh: str = "squares"
    lower_material: Material | None = None
    every: int = 1
    frames: int = 10

    def __post_init__(self) -> None:
        check_fields(self, "simulate", ("damping", "step_ratio"))
        if not 0 <= self.damping <= LARGEST_DAMPING:
            raise SceneError(
                f"simulate: damping must lie between 0 and {LARGEST_DAMPING:g}, got {self.damping}."
            )
        if not 0 < self.step_ratio <= LARGEST_RATIO:
            raise SceneError(
                f"simulate: step_ratio must be above 0 and at most {LARGEST_RATIO} "
                f"(above {STABLE_RATIO} it is unstable), got {self.step_ratio}."
            )
        for name, least in (("resolution", LEAST_RESOLUTION), ("every", 1), ("frames", 1)):
            object.__setattr__(self, name, check_count(name, getattr(self, name), least))
        if self.model not in ("auto", "two-blocks"):
            raise SceneError(f"simulate: model must be 'auto' or 'two-blocks', got {self.model!r}.")
        if not isinstance(self.lower_material, Material | None):
            raise SceneError(
                f"simulate: lower_material must be a Material, got {shown(self.lower_material)}."
            )


@dataclass(frozen=True)
class Pace:
    """The interval between checkpoints, in steps or seconds, whichever is shorter.

    Raises
    ------
    SceneError
        If one is out of range.
    """

    steps: int | None = None
    seconds: float | None = None

    def __post_init__(self) -> None:
        if self.steps is not None:
            object.__setattr__(self, "steps", check_count("checkpoint_every", self.steps, 1))
        elif self.seconds is None:
            object.__setattr__(self, "steps", DEFAULT_PACE)
        if self.seconds is not None:
            seconds = checked_size("simulate: checkpoint_seconds", self.seconds)
            object.__setattr__(self, "seconds", seconds)


def check_count(name: str, value: int, least: int) -> int:
    """Return an option as int; raise SceneError unless it is an integer of at least `least`."""
    return checked_count(f"simulate: {name}", value, least, "an integer of at least")


def choose_model(scene: Scene, model: str, lower_material: Material | None = None) -> str:
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
    lower_material : Material, optional
        Of the lower block, if it is another one: there is no symmetry then.
    """
    if lower_material not in (None, scene.material):
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
            check_resolved(self.scene, self.lower_material, self.end_time, self.settings.resolution)
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
    def lower_material(self) -> Material:
        """Material of the lower block."""
        return self.settings.lower_material or self.scene.material

    @property
    def slides_ahead(self) -> bool:
        """Whether the contact slides ahead of all waves of the edge, under a load from far away."""
        return wave_slips_ahead(self.scene, self.end_time)

    @property
    def materials(self) -> dict[str, Material]:
        """Materials of the upper and of the lower block."""
        return {"upper": self.scene.material, "lower": self.lower_material}

    @property
    def name(self) -> str:
        """Name of the model."""
        return choose_model(self.scene, self.settings.model, self.settings.lower_material)

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
    def fastest_speed(self) -> float:
        """Speed of the first wave in the faster block [length / time]."""
        return max(map(self.scene.fastest_in, self.materials.values()))

    @property
    def size(self) -> float:
        """Distance h of the nodes on the interface [length]."""
        return self.scene.material.shear_speed * self.end_time / self.settings.resolution

    @property
    def edge(self) -> float:
        """Position of the edge node [length]: beside x = 0 if the slot is pressed (`fem.elements.edge`).

        It is at x = 0 under shear alone, where the edge slips, and for meshes whose offset is not
        known: those of Q2, and unstructured ones.
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
        return causal_margin(self.fastest_speed, self.end_time, self.size, self.damping_time)

    @property
    def family(self) -> Family:
        """Element family."""
        return find_family(self.settings.element, self.settings.mesh)

    @property
    def slot_length(self) -> float:
        """Length of slot next to the edge that is stored [length]."""
        return observed_slot(self.fastest_speed, self.end_time, full=self.full)

    @property
    def blocks(self) -> Blocks:
        """The blocks that are meshed."""
        return causal_blocks(
            self.fastest_speed,
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
        settings = self.settings
        return mesh_caution(self.scene, settings.lower_material, self.end_time, settings.resolution)

    @cached_property
    def critical_step(self) -> float:
        """Largest stable step [time]; an estimate for unstructured triangles.

        The fastest mode is localised in the corners of the blocks, so a patch of a few elements has
        it.
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
    """Return the largest eigenfrequency of a patch with rows in element sides [c_t / side].

    It is kept, because meshes are chosen among many that differ in size alone.
    """
    x = np.arange(PATCH + 1.0)
    space = make_space(MeshQuad.init_tensor(x, np.array(rows)), find_family(element, mesh))
    one = {"upper": Material(1.0, 1.0, poisson_ratio)}
    matrix, _ = normalised(STIFFNESS[components](space, one), lumped_mass(space, one))
    return highest_frequency(matrix, tol=1e-7)


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

    Parameters
    ----------
    scene : Scene, str or path
    end_time : float or None
        T [time]; the time a shear wave takes over a length of 1 if None.
    settings : Settings or None
    options : mapping
        Fields of `Settings`, in place of those of `settings`.
    full : bool
        Whether whole fields are observed.

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
    if isinstance(scene, str | PathLike):
        scene, lower = find_blocks(fspath(scene))
        if settings.lower_material is None and lower is not None:
            settings = replace(settings, lower_material=lower)
    scene = checked_scene("simulate", scene)
    end_time = 1 / scene.material.shear_speed if end_time is None else end_time
    return Plan(scene, end_time, settings, full)
