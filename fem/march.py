"""Two bodies and their joint, marched from one time level to the next."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from skfem import MeshQuad

from fem.elements.assembly import STIFFNESS, Space, Y, lumped_mass
from fem.interface import ContactFace, FacePair, Joint
from fem.loading import kick_interval
from fem.stepping import MarchedBody, highest_frequency, normalised
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import ComputationError
from semianalytic.scene.loads import LoadHistory
from semianalytic.scene.material import Material

RATE_WINDOW = 2.8
"""Elements that a shear wave crosses in the time over which slip rates are averaged.  The surface
of a mesh rings with about that period; the error of averaged slip rates is half of that of single
steps."""


def half_window(size: float, speed: float, step: float) -> int:
    """Return the steps before and after a level over which its slip rate is the mean.

    The elements have a size [length], and the shear wave a speed [length / time].
    """
    return max(1, round(RATE_WINDOW / 2 * size / speed / step))


PATCH = 24
"""Elements along a side of the patch."""


def highest_of_patch(size: float, material: Material, components: tuple[int, ...]) -> float:
    """Return the largest eigenfrequency of a free patch of squares [1 / time].

    The fastest mode of a block is localised in its corners, so a patch of a few elements has it,
    and no block that is larger or fixed exceeds it.  Squares have sides of a size [length].
    """
    side = size * np.arange(PATCH + 1.0)
    space = Space(MeshQuad.init_tensor(side, side))
    matrix, _ = normalised(STIFFNESS[components](space, material), lumped_mass(space, material))
    return highest_frequency(matrix, tol=1e-7)


def body_matrix(
    space: Space, material: Material, components: tuple[int, ...], place: NDArray[np.int64]
) -> tuple[sparse.csr_array, Array]:
    """Return stiffness and roots of masses of a body, as `normalised`, with nodes at new places."""
    mass = lumped_mass(space, material, place)
    return normalised(STIFFNESS[components](space, material, place), mass)


def unknowns_of(
    numbers: NDArray[np.int64], component: int, components: tuple[int, ...]
) -> NDArray[np.int64]:
    """Return the unknowns of one displacement component at nodes of given numbers."""
    return len(components) * numbers + components.index(component)


def face_pair(
    bodies: list[MarchedBody],
    numbers: NDArray[np.int64],
    length: Array,
    step: float,
    component: int,
    firsts: Sequence[int] = (0, 0),
) -> FacePair:
    """Return one component of motion of nodes with given numbers on the faces of bodies.

    Bodies are the upper one and, unless it moves oppositely, the lower one; in each, numbers count
    from a first node on.
    """
    faces = []
    for body, sign, first in zip(bodies, (1.0, -1.0), firsts, strict=False):
        unknowns = unknowns_of(first + numbers, component, body.components)
        # the lower body is described by its mirror image, whose u_y is the opposite
        sign = 1.0 if component == Y else sign
        faces.append(ContactFace.of(body, unknowns, sign))
    return FacePair(faces, length, step)


@dataclass(frozen=True)
class Walls:
    """Side walls that let plane waves pass along them.

    They fix u_y of the motion in which blocks move oppositely along x, and u_x of the rest.
    """

    bodies: list[MarchedBody]  # the upper body and, unless it moves oppositely, the lower one
    # unknowns of u_x and of u_y on the walls
    along: NDArray[np.int64]
    across: NDArray[np.int64]

    def hold(self) -> None:
        """Hold these parts of the increments."""
        upper, *lower = (body.increment for body in self.bodies)
        if not lower:
            upper[self.across] = 0.0
            return
        odd = (upper[self.along] - lower[0][self.along]) / 2
        upper[self.along], lower[0][self.along] = odd, -odd
        even = (upper[self.across] + lower[0][self.across]) / 2
        upper[self.across] = lower[0][self.across] = even


@dataclass
class SidePush:
    """Tractions on a side of a body that change with time."""

    face: ContactFace  # unknowns of the side, each once
    force: Array  # (k,) array: force on them where the history is 1 [stress length]
    history: LoadHistory
    step: float  # dt [time]

    def __post_init__(self) -> None:
        self.now = np.zeros_like(self.force)
        self.work = self.done = 0.0

    def act(self, level: int, part: float) -> None:
        """Push at a level; the work is that up to the middle of the step before."""
        mean = float(self.history.mean(*kick_interval(level, self.step)))
        self.now, self.work = part * mean * self.force, self.done
        self.face.body.increment[self.face.unknowns] += self.step**2 * self.now * self.face.given

    def drift(self) -> None:
        """Add the work of the last push, once its increment is known."""
        body, unknowns = self.face.body, self.face.unknowns
        twice = (body.before[unknowns] + body.increment[unknowns]) * self.face.scale
        self.done += float(self.now @ twice) / 2


@dataclass(frozen=True, eq=False, kw_only=True)
class March:
    """Bodies and joint at rest, ready for one march in time."""

    # upper ones before lower ones, which are left out where they move oppositely
    bodies: list[MarchedBody]
    joint: Joint
    time_step: float  # dt [time]
    copies: int  # number of blocks that a body stands for: 2 where the lower one moves oppositely
    walls: Walls | None = None  # side walls that are not free
    pushes: Sequence[SidePush] = ()  # tractions on other sides than the joint

    @property
    def unknowns(self) -> int:
        """Number of unknowns of all bodies."""
        return sum(len(body.root) for body in self.bodies)

    def kick(self, level: int) -> None:
        """Kick the bodies at a time level; forces act for half a step at t = 0, from rest."""
        for body in self.bodies:
            body.activate((level + 1) * self.time_step)
            body.kick()
        if not math.isfinite(sum(body.energy.kinetic for body in self.bodies)):
            raise ComputationError(
                f"the simulation has values that are not finite at step {level}; "
                "lower `step_ratio`, or give loads and moduli of ordinary size."
            )
        if self.walls is not None:
            self.walls.hold()
        part = 1.0 if level else 0.5
        for push in self.pushes:
            push.act(level, part)
        self.joint.act(level, part)

    def drift(self) -> None:
        """Move the bodies on to the next time level, after its kick."""
        for push in self.pushes:
            push.drift()
        for body in self.bodies:
            body.drift()

    def energies(self) -> Array:
        """Return the energies in the middle of the past step, in the order of `EnergyHistory`."""
        bodies = np.sum([body.energy for body in self.bodies], axis=0)
        kinetic, strain, damping = bodies * self.copies / self.time_step**2
        friction, impact, external = self.joint.work
        external += sum(push.work for push in self.pushes)
        return np.array([kinetic, strain, friction, damping, external, impact])
