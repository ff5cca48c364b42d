"""From a scene to the bodies that march and the faces that meet."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from fem.assembly import Space, lumped_mass, stiffness, tributary_length
from fem.interface import Faces, Interface
from fem.loading import SlotLoad, slot_loads
from fem.stepping import Body, critical_step, highest_frequency, normalised
from semianalytic.scene.scene import Material, Scene

ANTISYMMETRIC = "antisymmetric half"
SYMMETRIC = "symmetric half"
LOCKSTEP = "antisymmetric and symmetric halves in lockstep"
TWO_BLOCKS = "two blocks"
TWO_MATERIALS = "two blocks of different materials, to which the theory does not apply"


def choose_model(scene: Scene, model: str, lower_material: Material | None = None) -> str:
    """Name of the model a scene needs.

    Under shear alone the motion is antisymmetric in y (u_x odd, u_y even) and does not touch
    the pressure; under pressure alone it is symmetric.  Two identical blocks under both are
    the sum of the two: slip feels the pressure, the pressure does not feel the slip.

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
    if scene.load.pressure == 0:
        return ANTISYMMETRIC
    return SYMMETRIC if scene.load.shear == 0 == scene.base.shear else LOCKSTEP


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
        """Unknowns of one component (0: x, 1: y) at mesh nodes."""
        return 2 * self.place[nodes] + component

    def reached(self, distance: float) -> int:
        """Number of leading unknowns within a distance."""
        return 2 * int(np.searchsorted(self.distance, distance, side="right"))


def number_by_arrival(space: Space, scene: Scene, size: float) -> Numbering:
    """Number the nodes by their distance from the slot x < 0, loaded at t = 0.

    If the interface slides at once everywhere, the distance is that from the whole line y = 0.

    Parameters
    ----------
    space : Space
    scene : Scene
    size : float
        Distance of the nodes on the interface [length].
    """
    x, y = space.points
    ahead = np.zeros_like(x) if scene.far_slip_rate else np.maximum(x, 0.0)
    thickness = 4 * size
    layers = np.floor(np.hypot(ahead, y) / thickness)
    order = np.argsort(layers, kind="stable")
    place = np.empty_like(order)
    place[order] = np.arange(len(order))
    return Numbering(place, order, layers[order] * thickness)


@dataclass
class Model:
    """Bodies, interface and slot, ready to march.

    Attributes
    ----------
    name : str
        What is simulated.
    space : Space
        Mesh and nodes.
    materials : dict
        Material of the blocks "upper" and "lower".
    numbering : Numbering
    bodies : list of Body
        One or, in lockstep, two bodies on the same mesh; the motion is their sum.
    odd : tuple of int
        For each half, the displacement component that changes sign from the upper block to
        the lower one, the other being the same in both; empty with two blocks.
    loads : list of SlotLoad
        Of bodies whose load changes with time.
    interface : Interface
    root : (2 n,) array
        Square roots of the masses of the unknowns.
    contact_x, slot_x : arrays
        Positions of the nodes [length]; the edge node belongs to the contact.
    slot : (2, k) array
        Unknowns of the upper slot face, x and y.
    critical_step, time_step : float
        Largest stable step and the one taken [time].
    steps : int
        Steps to the end time.
    """

    name: str
    space: Space
    materials: dict[str, Material]
    numbering: Numbering
    bodies: list[Body]
    odd: tuple[int, ...]
    loads: list[SlotLoad]
    interface: Interface
    root: NDArray[np.float64]
    contact_x: NDArray[np.float64]
    slot_x: NDArray[np.float64]
    slot: NDArray[np.int64]
    critical_step: float
    time_step: float
    steps: int

    @property
    def copies(self) -> int:
        """How many blocks a body stands for: 2 for a half, 1 when both are in the mesh."""
        return 2 if self.odd else 1

    @property
    def unknowns(self) -> int:
        """Number of unknowns of all bodies."""
        return len(self.root) * len(self.bodies)


def build_model(
    scene: Scene,
    space: Space,
    *,
    name: str,
    size: float,
    end_time: float,
    damping_time: float,
    step_ratio: float,
    lower_material: Material | None = None,
) -> Model:
    """Assemble the bodies of a scene on a mesh and choose the time step.

    Parameters
    ----------
    scene : Scene
    space : Space
        Upper block, or both blocks where the name says so; see `meshes.read_mesh`.
    name : str
        From `choose_model`.
    size : float
        Distance h of the nodes on the interface [length].
    end_time : float
        [time]; a whole number of steps reaches it.
    damping_time : float
        eta of the damping C = eta K [time].
    step_ratio : float
        Upper bound of the time step over the critical one.
    lower_material : Material, optional
        Of the lower block, if it is another one.

    Returns
    -------
    Model
    """
    numbering = number_by_arrival(space, scene, size)
    both = name in (TWO_BLOCKS, TWO_MATERIALS)
    materials = {"upper": scene.material, "lower": lower_material or scene.material}
    in_mesh = {block: materials[block] for block in space.mesh.subdomains}
    mass = lumped_mass(space, in_mesh)
    matrix, root = normalised(stiffness(space, in_mesh), mass, numbering.order)
    critical = critical_step(highest_frequency(matrix), damping_time)
    steps = int(np.ceil(end_time / (step_ratio * critical)))
    step = end_time / steps
    matrix.data *= step**2

    parts = _Parts(scene, space, numbering, matrix, root, step, damping_time)
    sliding: Faces | None = None
    pressing: Faces | None = None
    odd: tuple[int, ...] = ()
    if both:
        bodies = [parts.two_blocks(walls=name == TWO_BLOCKS)]
        sliding, pressing = (parts.faces(bodies[0], i, ("upper", "lower")) for i in (0, 1))
    else:
        odd = {ANTISYMMETRIC: (0,), SYMMETRIC: (1,), LOCKSTEP: (0, 1)}[name]
        bodies = [parts.half(i) for i in odd]
        faces = {i: parts.faces(body, i, ("upper",)) for i, body in zip(odd, bodies, strict=True)}
        sliding, pressing = faces.get(0), faces.get(1)
    slot_nodes, _ = tributary_length(space, "upper_slot")
    contact_nodes, length = tributary_length(space, "upper_contact")
    slot = slot_nodes[:-1]
    return Model(
        name=name,
        space=space,
        materials=materials,
        numbering=numbering,
        bodies=bodies,
        odd=odd,
        loads=slot_loads(scene, bodies, step, steps),
        interface=Interface(scene, length, sliding, pressing),
        root=root,
        contact_x=space.points[0, contact_nodes],
        slot_x=space.points[0, slot],
        slot=np.array([numbering.unknowns(slot, i) for i in (0, 1)]),
        critical_step=critical,
        time_step=step,
        steps=steps,
    )


@dataclass(frozen=True)
class _Parts:
    """Everything `build_model` puts bodies and faces together from."""

    scene: Scene
    space: Space
    numbering: Numbering
    matrix: sparse.csr_array
    root: NDArray[np.float64]
    step: float
    damping_time: float

    def half(self, component: int) -> Body:
        """Upper block moved by slot tractions along one component; walls hold the other one."""
        loaded, load = self._slot_load("upper", component)
        walls = np.concatenate([self._wall("upper", side) for side in ("left", "right")])
        held = self.numbering.unknowns(walls, 1 - component)
        return self._body(loaded, load, held=held)

    def two_blocks(self, walls: bool) -> Body:
        """Both blocks, whose walls are free, or where the materials are equal as in the halves.

        There mirror nodes of the walls move oppositely: that is u_y = 0 for the antisymmetric
        part of the motion and u_x = 0 for the symmetric one.
        """
        loads = [self._slot_load(block, i) for block in ("upper", "lower") for i in (0, 1)]
        mirrored = [
            [self.numbering.unknowns(self._wall(block, side), i) for block in ("upper", "lower")]
            for side in ("left", "right")
            for i in (0, 1)
        ]
        return self._body(
            np.concatenate([unknowns for unknowns, _ in loads]),
            np.concatenate([load for _, load in loads]),
            mirrored=np.concatenate(mirrored, axis=1) if walls else None,
        )

    def faces(self, body: Body, component: int, blocks: tuple[str, ...]) -> Faces:
        """One component of the contact faces of the named blocks."""
        sides = [tributary_length(self.space, f"{block}_contact") for block in blocks]
        unknowns = [self.numbering.unknowns(nodes, component) for nodes, _ in sides]
        return Faces(
            body=body,
            upper=unknowns[0],
            lower=unknowns[1] if len(blocks) == 2 else None,
            root=[self.root[face] for face in unknowns],
            length=sides[0][1],
            step=self.step,
        )

    def _slot_load(
        self, block: str, component: int
    ) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """Unknowns on a slot face and the forces on them at f = 1: (Q_0, -P_0) on the upper
        block."""
        nodes, length = tributary_length(self.space, f"{block}_slot")
        step = self.scene.load
        traction = (step.shear, -step.pressure)[component]
        sign = 1 if block == "upper" else -1
        return self.numbering.unknowns(nodes, component), sign * traction * length

    def _wall(self, block: str, side: str) -> NDArray[np.int64]:
        """Nodes of a side wall, from the interface outwards."""
        return self.space.side_nodes(f"{block}_{side}")

    def _body(
        self,
        loaded: NDArray[np.int64],
        load: NDArray[np.float64],
        held: NDArray[np.int64] | None = None,
        mirrored: NDArray[np.int64] | None = None,
    ) -> Body:
        return Body(
            matrix=self.matrix,
            damping=self.damping_time / self.step,
            loaded=loaded,
            load=self.step**2 * load / self.root[loaded],
            held=np.empty(0, dtype=np.int64) if held is None else held,
            mirrored=np.empty((2, 0), dtype=np.int64) if mirrored is None else mirrored,
        )
