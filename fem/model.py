"""The model of a scene: bodies that march in time, and the faces that meet on the joint."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import product

import numpy as np
from numpy.typing import NDArray

from fem.elements.assembly import IN_PLANE, Space, X, Y, Z, tributary_length
from fem.interface import FaceMotion, Joint
from fem.loading import SceneTractions
from fem.march import March, Walls, body_matrix, face_pair, half_window, unknowns_of
from fem.plan import TWO_MATERIALS, Plan
from fem.stepping import MarchedBody, critical_step, highest_frequency
from meshes import mesh_of, side_nodes
from meshes.blocks import causal_margin
from semianalytic.scene.arrays import Array
from semianalytic.scene.contact import wave_slips_ahead

LAYER = 4
"""Elements in a layer of nodes whose unknowns begin to move together."""


def number_by_arrival(
    space: Space, size: float, *, slides: bool
) -> tuple[NDArray[np.int64], Array]:
    """Number the nodes by their distance from the slot x < 0, which is loaded at t = 0.

    Where the interface slides ahead of all waves of the edge, the distance is that from the whole
    line y = 0.  Return the new number of each node (n,), and the distance (n,) of each new number
    [length], rounded down to layers, in which the nodes keep the order they have in the mesh.
    """
    x, y = space.points
    ahead = np.zeros_like(x) if slides else np.maximum(x, 0.0)
    layers = np.floor(np.hypot(ahead, y) / (LAYER * size))
    order = np.argsort(layers, kind="stable")
    place = np.empty_like(order)
    place[order] = np.arange(len(order))
    return place, layers[order] * LAYER * size


@dataclass(frozen=True, eq=False, kw_only=True)
class Model(March):
    """Mesh, bodies and joint of a scene at rest, ready for one march in time.

    Attributes
    ----------
    plan : Plan
        Scene, options and what follows from them.
    space : Space
        Mesh and nodes of the upper block, whose mirror image is the lower one.
    place : (n,) array
        Index of each node of the mesh in the vectors of the bodies.
    contact_x, slot_x : arrays
        Positions of the nodes [length]; the edge node, at `Plan.edge`, belongs to the contact.
    slot : (k,) array
        Mesh nodes of the slot face.
    critical_step : float
        Largest stable step [time].
    steps : int
        Steps to the end time.
    half_window : int
        Number of steps before and after a level over which its slip rate is averaged; as many steps
        are computed beyond the end time.
    seconds : dict
        Wall-clock time of the stages "mesh" and "assembly" [s], as far as they were timed.

    Examples
    --------
    >>> from fem.model import build
    >>> from fem.plan import make_plan
    >>> model = build(make_plan("preloaded", None, None, {"resolution": 8}))
    >>> model.unknowns, model.copies, bool(model.time_step < model.critical_step)
    (1380, 2, True)
    """

    plan: Plan
    space: Space
    place: NDArray[np.int64]
    contact_x: Array
    slot_x: Array
    slot: NDArray[np.int64]
    critical_step: float
    steps: int
    half_window: int
    seconds: dict[str, float] = field(default_factory=dict)

    def __repr__(self) -> str:
        return f"<Model: {self.plan.name}, {self.unknowns:,} unknowns, {self.steps} steps>"

    @property
    def upper(self) -> list[MarchedBody]:
        """Bodies of the upper block, one for each of `Plan.bodies`."""
        return self.bodies[: len(self.plan.bodies)]

    @property
    def lower(self) -> list[MarchedBody]:
        """Bodies of the lower block likewise; none where it moves oppositely."""
        return self.bodies[len(self.plan.bodies) :]


def build(plan: Plan) -> Model:
    """Build mesh and model of a plan."""
    seconds: dict[str, float] = {}
    with timed(seconds, "mesh"):
        mesh = mesh_of(plan.blocks).translated((plan.edge, 0.0))
        space = Space(mesh)
    with timed(seconds, "assembly"):
        model = build_model(plan, space)
    model.seconds.update(seconds)
    return model


@contextmanager
def timed(seconds: dict[str, float], stage: str) -> Iterator[None]:
    """Add the wall-clock time spent in this context to that of a stage [s]."""
    started = time.perf_counter()
    yield
    seconds[stage] = seconds.get(stage, 0.0) + time.perf_counter() - started


def build_model(plan: Plan, space: Space) -> Model:
    """Assemble the bodies of a plan on a mesh of the upper block; choose the step."""
    scene, damping_time = plan.scene, plan.damping_time
    slides = wave_slips_ahead(scene, plan.end_time)
    place, distance = number_by_arrival(space, plan.size, slides=slides)
    solids = scene.bodies[: 1 if plan.is_half else 2]
    matrices = {
        (solid, components): body_matrix(space, solid, components, place)
        for solid, components in product(dict.fromkeys(solids), plan.bodies)
    }
    critical = plan.critical_step
    if plan.settings.mesh == "triangles":  # no patch has their fastest mode
        highest = max(highest_frequency(matrix) for matrix, _ in matrices.values())
        critical = critical_step(highest, damping_time)
    steps = plan.steps(critical)
    step = plan.end_time / steps
    for matrix, _ in matrices.values():
        matrix.data *= step**2
    margin = causal_margin(scene.fastest_speed, plan.end_time, plan.size, damping_time)
    arrival = (distance - margin) / scene.fastest_speed
    bodies = [
        MarchedBody(components, *matrices[solid, components], damping_time / step, arrival)
        for solid, components in product(solids, plan.bodies)
    ]

    def motion(side: str) -> FaceMotion:
        """Return the motion of faces along and across the interface."""
        nodes, length = tributary_length(space, side)
        pairs = []
        for component in (Z if scene.antiplane else X, Y):
            moving = [body for body in bodies if component in body.components]
            held = not moving or (component == Y and plan.is_half)
            pairs.append(None if held else face_pair(moving, place[nodes], length, step, component))
        return FaceMotion(*pairs)

    contact_nodes, slot_nodes = (side_nodes(space.points, side) for side in ("contact", "slot"))
    contact_x, slot_x = (space.points[0, nodes] for nodes in (contact_nodes, slot_nodes))
    window = half_window(plan.size, scene.material.shear_speed, step)
    tractions = SceneTractions(scene, step, steps + window, contact_x, slot_x)
    pressure, state = scene.superposition.in_place.pressure, np.zeros(len(contact_x))
    joint = Joint(scene.law, state, motion("contact"), motion("slot"), tractions, pressure)
    walls = None
    if plan.name != TWO_MATERIALS and IN_PLANE in plan.bodies:
        sides = [side_nodes(space.points, side) for side in ("left", "right")]
        nodes = place[np.concatenate(sides)]
        moving = [body for body in bodies if body.components == IN_PLANE]
        walls = Walls(moving, *(unknowns_of(nodes, component, IN_PLANE) for component in IN_PLANE))
    return Model(
        bodies=bodies,
        joint=joint,
        time_step=step,
        copies=2 if plan.is_half else 1,
        walls=walls,
        plan=plan,
        space=space,
        place=place,
        contact_x=contact_x,
        slot_x=slot_x[:-1],
        slot=slot_nodes[:-1],
        critical_step=critical,
        steps=steps,
        half_window=window,
    )
