"""The model of a scene: bodies that march in time, and the faces that meet on the contact."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from fem.elements.assembly import (
    IN_PLANE,
    OUT_OF_PLANE,
    STIFFNESS,
    Space,
    X,
    Y,
    Z,
    lumped_mass,
    make_space,
    tributary_length,
)
from fem.interface import ContactFace, FacePair, MeshContact
from fem.loading import ContactLoad, FrontTractions, SlotTractions, contact_loads, slot_loads
from fem.plan import TWO_BLOCKS, Plan, make_plan
from fem.settings import Settings
from fem.stepping import MarchedBody, critical_step, highest_frequency, normalised
from meshes import mesh_of
from semianalytic.scene.scene import Scene

BLOCKS = ("upper", "lower")

RATE_WINDOW = 2.8
"""Elements that a shear wave crosses in the time over which slip rates are averaged.  The surface
of a mesh rings with about that period; the error of averaged slip rates is half of that of single
steps (docs/fem.md)."""


@dataclass(frozen=True)
class Numbering:
    """Nodes sorted by the time the first wave can reach them.

    Parameters
    ----------
    place : (n,) array
        New number of each mesh node.
    order : (n,) array
        Mesh node behind each new number.
    distance : (n,) array
        Distance of each new number from what moves first [length], rounded down to layers a few
        elements thick, in which the nodes keep the order they have in the mesh.
    """

    place: NDArray[np.int64]
    order: NDArray[np.int64]
    distance: NDArray[np.float64]

    def unknowns(self, nodes: NDArray[np.int64], component: int) -> NDArray[np.int64]:
        """Return the unknowns of one displacement component at mesh nodes."""
        components = OUT_OF_PLANE if component == Z else IN_PLANE
        return len(components) * self.place[nodes] + components.index(component)

    def reached(self, distance: float) -> int:
        """Return the number of leading nodes within a distance."""
        return int(np.searchsorted(self.distance, distance, side="right"))


def number_by_arrival(space: Space, size: float, *, slides: bool) -> Numbering:
    """Number the nodes by their distance from the slot x < 0, which is loaded at t = 0.

    The size is the distance of the nodes on the interface [length].  Where the interface slides
    ahead of all waves of the edge, the distance is that from the whole line y = 0.
    """
    x, y = space.points
    ahead = np.zeros_like(x) if slides else np.maximum(x, 0.0)
    thickness = 4 * size
    layers = np.floor(np.hypot(ahead, y) / thickness)
    order = np.argsort(layers, kind="stable")
    place = np.empty_like(order)
    place[order] = np.arange(len(order))
    return Numbering(place, order, layers[order] * thickness)


@dataclass(frozen=True, eq=False)
class Model:
    """Mesh, bodies, interface and loads at rest, ready for one march in time.

    Attributes
    ----------
    plan : Plan
        Scene, options and what follows from them.
    space : Space
        Mesh and nodes.
    numbering : Numbering
    bodies : list of MarchedBody
        One or, in lockstep, two bodies on the same mesh; the motion is their sum.
    loads : list of SlotTractions, FrontTractions or ContactLoad
        Loads of the bodies, and of the contact, that change with time.
    interface : MeshContact
    contact_x, slot_x : arrays
        Positions of the nodes [length]; the edge node, at `Plan.edge`, belongs to the contact.
    slot : (k,) array
        Mesh nodes of the upper slot face.
    critical_step, time_step : float
        Largest stable step and the one taken [time].
    steps : int
        Steps to the end time.
    half_window : int
        Steps before and after a level over which its slip rate is the mean; as many follow the end.
    seconds : dict
        Wall-clock time of the stages "mesh" and "assembly" [s], as far as they were timed.

    Examples
    --------
    >>> from fem.model import prepare
    >>> from semianalytic import find
    >>> model = prepare(find("preloaded"), resolution=8)
    >>> model.unknowns, model.copies, bool(model.time_step < model.critical_step)
    (1380, 2, True)
    """

    plan: Plan
    space: Space
    numbering: Numbering
    bodies: list[MarchedBody]
    loads: Sequence[SlotTractions | FrontTractions | ContactLoad]
    interface: MeshContact
    contact_x: NDArray[np.float64]
    slot_x: NDArray[np.float64]
    slot: NDArray[np.int64]
    critical_step: float
    time_step: float
    steps: int
    half_window: int
    seconds: dict[str, float] = field(default_factory=dict)

    def __repr__(self) -> str:
        return f"<Model: {self.plan.name}, {self.unknowns:,} unknowns, {self.steps} steps>"

    @property
    def copies(self) -> int:
        """Number of blocks that a body stands for: 2 for a half, 1 if both are in the mesh."""
        return 2 if self.plan.halves else 1

    @property
    def unknowns(self) -> int:
        """Number of unknowns of all bodies."""
        return sum(len(body.root) for body in self.bodies)


def prepare(
    scene: Scene | str | PathLike[str],
    end_time: float | None = None,
    settings: Settings | None = None,
    *,
    full: bool = False,
    **options: Any,
) -> Model:
    """Build everything that `simulate` needs before its first step.

    Parameters
    ----------
    scene, end_time, settings, **options
        Arguments of `simulate`.
    full : bool
        Whether the mesh is to be large enough for pictures of the whole fields.

    Returns
    -------
    Model

    Raises
    ------
    SceneError, MissingLibraryError, DataFileError
        For the reasons given at `simulate`; nothing is refused for its size.

    Examples
    --------
    >>> from fem.model import prepare
    >>> prepare("antiplane", resolution=8).plan.name
    'antiplane half'
    """
    return build(make_plan(scene, end_time, settings, options, full=full))


def build(plan: Plan) -> Model:
    """Build mesh and model of a plan."""
    seconds: dict[str, float] = {}
    with timed(seconds, "mesh"):
        mesh = mesh_of(plan.blocks).translated((plan.edge, 0.0))
        space = make_space(mesh, plan.family)
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
    """Assemble the bodies of a plan on a mesh of the upper block or of both; choose the step."""
    numbering = number_by_arrival(space, plan.size, slides=plan.slides_ahead)
    in_mesh = {block: plan.materials[block] for block in space.mesh.subdomains}
    mass = lumped_mass(space, in_mesh)[numbering.order]
    matrices = {
        components: normalised(STIFFNESS[components](space, in_mesh, numbering.place), mass)
        for components in dict.fromkeys(plan.bodies)
    }
    critical = plan.critical_step
    if plan.blocks.pattern == "triangles":  # no patch has their fastest mode
        highest = max(highest_frequency(matrix) for matrix, _ in matrices.values())
        critical = critical_step(highest, plan.damping_time)
    steps = plan.steps(critical)
    step = plan.end_time / steps
    for matrix, _ in matrices.values():
        matrix.data *= step**2

    crossing = plan.size / plan.scene.material.shear_speed
    half_window = max(1, round(RATE_WINDOW / 2 * crossing / step))

    parts = _Parts(plan.scene, space, numbering, matrices, step, plan.damping_time)
    bodies, sliding, pressing = parts.put_together(plan)
    slot_nodes, _ = tributary_length(space, "upper_slot")
    contact_nodes, length = tributary_length(space, "upper_contact")
    slot = slot_nodes[:-1]
    places = [
        space.points[0, numbering.order[body.loaded // len(body.components)]] for body in bodies
    ]
    interface = MeshContact(plan.scene, length, sliding, pressing)
    contact_x, end = space.points[0, contact_nodes], steps + half_window
    return Model(
        plan=plan,
        space=space,
        numbering=numbering,
        bodies=bodies,
        loads=[
            *slot_loads(plan.scene, bodies, step, end, places),
            *contact_loads(plan.scene, interface, step, contact_x),
        ],
        interface=interface,
        contact_x=contact_x,
        slot_x=space.points[0, slot],
        slot=slot,
        critical_step=critical,
        time_step=step,
        steps=steps,
        half_window=half_window,
    )


@dataclass(frozen=True)
class _Parts:
    """The parts from which `build_model` makes bodies and faces."""

    scene: Scene
    space: Space
    numbering: Numbering
    matrices: dict[tuple[int, ...], tuple[sparse.csr_array, NDArray[np.float64]]]
    step: float
    damping_time: float

    def put_together(
        self, plan: Plan
    ) -> tuple[list[MarchedBody], FacePair | None, FacePair | None]:
        """Make the bodies, and the faces that slide and that press, where symmetry allows it."""
        meeting: tuple[str, ...] = BLOCKS
        if plan.halves:
            halves = {i: self.half(i) for i in plan.halves}
            bodies, meeting = list(halves.values()), ("upper",)
        else:
            walls = plan.name == TWO_BLOCKS
            bodies = [self.two_blocks(one, walls) for one in plan.bodies]
            halves = {i: body for body in bodies for i in body.components}
        faces = {i: self.faces(body, i, meeting) for i, body in halves.items()}
        return bodies, faces.get(Z if plan.scene.antiplane else X), faces.get(Y)

    def half(self, component: int) -> MarchedBody:
        """Make the upper block, moved by slot tractions along one component; walls hold the other.

        In antiplane shear walls are free, since plane waves pass along free walls.
        """
        loaded, load = self._slot_load("upper", component)
        if component == Z:
            return self._body(OUT_OF_PLANE, loaded, load)
        walls = np.concatenate([self._wall("upper", side) for side in ("left", "right")])
        held = self.numbering.unknowns(walls, 1 - component)
        return self._body(IN_PLANE, loaded, load, held=held)

    def two_blocks(self, components: tuple[int, ...], walls: bool) -> MarchedBody:
        """Make both blocks; their walls are free, or as in the halves if the materials are equal.

        As in the halves, mirror nodes of the walls move oppositely, which is u_y = 0 for the
        antisymmetric part of the motion and u_x = 0 for the symmetric one.
        """
        loads = [self._slot_load(block, i) for block in BLOCKS for i in components]
        mirrored = [
            [self.numbering.unknowns(self._wall(block, side), i) for block in BLOCKS]
            for side in ("left", "right")
            for i in components
        ]
        loaded, load = (np.concatenate(parts) for parts in zip(*loads, strict=True))
        walled = walls and components == IN_PLANE
        held = {"mirrored": np.concatenate(mirrored, axis=1)} if walled else {}
        return self._body(components, loaded, load, **held)

    def faces(self, body: MarchedBody, component: int, blocks: tuple[str, ...]) -> FacePair:
        """Make the contact faces of the named blocks for one component of motion."""
        faces = []
        for block, sign in zip(blocks, (1.0, -1.0), strict=False):
            nodes, length = tributary_length(self.space, f"{block}_contact")
            unknowns = self.numbering.unknowns(nodes, component)
            faces.append(ContactFace(body, unknowns, body.root[unknowns], sign))
        return FacePair(faces, length, self.step)

    def _slot_load(
        self, block: str, component: int
    ) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Return the unknowns on a slot face and the forces on them at f = 1, of (Q_0, -P_0)."""
        nodes, length = tributary_length(self.space, f"{block}_slot")
        load = self.scene.superposition.taken_off
        tractions = {Z if self.scene.antiplane else X: load.shear, Y: -load.pressure}
        sign = 1 if block == "upper" else -1
        force = sign * tractions.get(component, 0.0) * length
        return self.numbering.unknowns(nodes, component), force

    def _wall(self, block: str, side: str) -> NDArray[np.int64]:
        """Return the nodes of a side wall, from the interface outwards."""
        return self.space.side_nodes(f"{block}_{side}")

    def _body(
        self,
        components: tuple[int, ...],
        loaded: NDArray[np.int64],
        load: NDArray[np.float64],
        **walls: NDArray[np.int64],
    ) -> MarchedBody:
        matrix, root = self.matrices[components]
        damping, load = self.damping_time / self.step, self.step**2 * load / root[loaded]
        return MarchedBody(components, matrix, root, damping, loaded, load, **walls)
