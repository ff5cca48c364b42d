"""The node pairs of the interface: unilateral contact and friction without a penalty.

A traction T per length on the faces of a pair with tributary length L and node masses m, m'
(upper +T, lower -T) changes the relative increment by c T, c = dt^2 L (1/m + 1/m').  Conversely,
the traction that brings a pair exactly to where it should be at the end of the step is known in
advance, without iteration or penalty.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fem.stepping import MarchedBody
from semianalytic.scene.errors import SceneError
from semianalytic.scene.scene import Scene

Array = NDArray[np.float64]


class ContactFace(NamedTuple):
    """One component of motion of a face: its body, unknowns there and roots of their masses.

    The sign is 1 for an upper face and -1 for a lower one.
    """

    body: MarchedBody
    unknowns: NDArray[np.int64] | slice
    root: Array
    sign: float


@dataclass(frozen=True)
class FacePair:
    """One component of motion of the two faces that meet on the contact.

    They are the upper face, and the lower one unless it moves oppositely; with tributary lengths
    (n,) or one [length], and a step dt [time].
    """

    faces: list[ContactFace]
    length: float | Array
    step: float

    @property
    def _times(self) -> float:
        """A lower face that is not there moves oppositely: the jump is twice the upper motion."""
        return 2.0 if len(self.faces) == 1 else 1.0

    @cached_property
    def compliance(self) -> Array:
        """Change c = dt^2 L (1/m + 1/m') of the relative increment per traction, (n,)."""
        inertia = self._times * sum(1 / face.root**2 for face in self.faces)
        return np.asarray(self.step**2 * self.length * inertia)

    def _jump(self, name: str) -> Array:
        """Return upper minus lower face of a mass-normalised vector, (n,) [length]."""
        parts = (one.sign * getattr(one.body, name)[one.unknowns] / one.root for one in self.faces)
        return np.asarray(self._times * sum(parts))

    def offset(self) -> Array:
        """Relative displacement, upper minus lower, (n,) [length]."""
        return self._jump("displacement")

    def increment(self) -> Array:
        """Relative increment over the step after this time level, (n,) [length]."""
        return self._jump("increment")

    def past_increment(self) -> Array:
        """Relative increment over the step before this time level, (n,) [length]."""
        return self._jump("before")

    def mean_increment(self) -> Array:
        """Mean of the relative increments before and after this time level, (n,) [length]."""
        return (self.past_increment() + self.increment()) / 2

    def push(self, traction: Array, part: float) -> Array:
        """Apply a traction (n,) [stress] to the upper face, and its opposite to the lower one.

        It acts for a part of a step.  The impulse (n,) is returned: times the mean increment it is
        the work, times dt^2 as energies of bodies are.
        """
        # in mass-normalised unknowns D = s d a force F changes D by dt^2 F / s
        impulse = part * (self.step**2 * self.length) * traction
        for face in self.faces:
            face.body.increment[face.unknowns] += face.sign * impulse / face.root
        return impulse


def contact_pressure(gap: Array, increment: Array, base: float | Array, compliance: Array) -> Array:
    """Return the pressure that ends the step with the gap closed, or zero if that needs tension.

    An open pair that would interpenetrate is stopped exactly at the end of the step, so the gap is
    never negative and the pressure only takes energy out.  The gap at the start of the step is >= 0
    [length]; the increment is its change if only the base pressure [stress] acted, and the
    compliance the opening over the step per pressure [length / stress].
    """
    # a pressure p adds compliance (p - base) to gap + increment; the pair ends the step closed at 0
    return np.maximum(base - (gap + increment) / compliance, 0.0)


STICK = 0
"""State of a node that does not move along the interface."""
FORWARD = 1
"""State of a node where the upper side slips towards +x."""
BACKWARD = -1
"""State of a node where the upper side slips towards -x."""
OPEN = 2
"""State of a node where the sides do not touch."""


class Carried(NamedTuple):
    """The tractions that the uncut contact carries, to which what the bodies do is added [stress].

    They are arrays (n,) under an incident wave that rises and falls.
    """

    pressure: float | Array
    shear: float | Array


class InterfaceWork(NamedTuple):
    """Work per unit thickness at the interface [stress length^2].

    It is taken by friction and by closing gaps, and done by tractions in place on slip and opening.
    """

    friction: float
    impact: float
    external: float


class MeshContact:
    """The contact x >= 0 during a simulation: its present tractions, and the work done so far.

    Parameters
    ----------
    scene : Scene
        Friction and tractions in place.
    length : (n,) array
        Tributary lengths of the pairs [length].
    sliding : FacePair or None
        Motion along x; None where symmetry forbids slip.
    pressing : FacePair or None
        Motion along y; None where antisymmetry keeps the gap closed and the pressure as it was.

    Attributes
    ----------
    held : Carried
        Tractions in place at the next kick; `loading.ContactLoad` sets them where they change.
    pressure, shear : (n,) arrays
        Total tractions of the last kick, those in place included [stress].
    strength : (n,) array
        Largest shear traction at the last kick, under the scene's law [stress]; 0 where open.
    path : (n,) array
        |slip| accumulated up to the time level of the last kick, also while open [length].
    offset : (n,) array
        Opening at the time level of the last kick, zero to rounding where closed [length].
    work : InterfaceWork
        Up to the middle of the step before the last kick, as in `MarchedBody.energy`.
    """

    def __init__(
        self,
        scene: Scene,
        length: Array,
        sliding: FacePair | None,
        pressing: FacePair | None,
    ) -> None:
        self.scene, self.length = scene, length
        self.sliding, self.pressing = sliding, pressing
        in_place = scene.superposition.in_place
        self.held = Carried(in_place.pressure, in_place.shear)
        self.pressure = np.full(len(length), self.held.pressure)
        self.shear = np.full(len(length), self.held.shear)
        self.strength = scene.strength(self.pressure)
        self.path = np.zeros(len(length))
        self.offset = np.zeros(len(length))
        self.work = InterfaceWork(0.0, 0.0, 0.0)
        self._friction = self._impact = self._external = 0.0
        self._rubbed = np.zeros(len(length))

    def state(self) -> NDArray[np.int8]:
        """State of each pair in the step after the last kick: STICK, FORWARD, BACKWARD or OPEN."""
        state = np.full(len(self.length), STICK, dtype=np.int8)
        if self.sliding is not None:
            slides = np.abs(self.shear) >= self.strength
            state[slides] = np.sign(self.sliding.increment()[slides])
        if self.pressing is not None:
            state[self.pressure == 0] = OPEN
        return state

    def work_density(self) -> Array:
        """Work per area taken by friction up to the level of the last kick (n,) [stress length].

        Half of what the last kick does on the step after it is still missing.
        """
        if self.sliding is None:
            return self._rubbed
        return self._rubbed - self.shear * self.sliding.increment() / 2

    def sums(self) -> dict[str, Array]:
        """The sums that the interface carries on; the arrays per node are its own, not copies."""
        work = np.array([self._friction, self._impact, self._external])
        return {"work": work, "path": self.path, "friction": self._rubbed}

    def restore(self, sums: Mapping[str, Array]) -> None:
        """Continue from the sums of another run of the same model, to the last bit."""
        self._friction, self._impact, self._external = sums["work"].tolist()
        self.path[:], self._rubbed[:] = sums["path"], sums["friction"]

    def act(self, part: float) -> None:
        """Find the tractions of this kick, which act for a part of a step, and apply them.

        Raises
        ------
        SceneError
            If friction falls with slip rate faster than a pair of nodes can radiate.
        """
        self.work = InterfaceWork(self._friction, self._impact, self._external)
        if self.pressing is not None:
            self._press(self.pressing, part)
        if self.sliding is not None:
            self._slide(self.sliding, part)

    def _press(self, faces: FacePair, part: float) -> None:
        """Find the pressure of this kick, apply it and add up its work."""
        held = self.held.pressure
        self.offset = faces.offset()
        self.pressure = contact_pressure(
            self.offset, faces.increment(), held, part * faces.compliance
        )
        # the bodies carry changes only: the pressure in place is not pushed, but does external work
        faces.push(self.pressure - held, part)
        work = part * self.length * faces.mean_increment()
        self._impact -= float(work @ self.pressure)
        self._external -= float(np.sum(work * held))

    def _strength(self, stopping: Array, impedance: Array) -> Array:
        """Return the strength at the slip rate of the step and the path so far (n,) [stress]."""
        law = self.scene.law
        # steeper than that, a pair has several slip rates, or none, for one stopping traction
        slope = self.pressure * law.fall_with_rate
        worst = int(np.argmax(slope / impedance))
        if slope[worst] >= impedance[worst]:
            raise SceneError(
                "simulate: friction falls with slip rate faster than a node of the interface can "
                f"radiate (by {slope[worst]:.4g} per slip rate under the pressure it has reached, "
                f"its impedance is {impedance[worst]:.4g}); raise the rate or the dynamic friction "
                "of the law, or lower `step_ratio` (docs/limits.md)."
            )
        speed = law.slip_speed(stopping, self.pressure, impedance, self.path)
        return law.strength(self.pressure, speed, self.path)

    def _slide(self, faces: FacePair, part: float) -> None:
        """Find the shear traction of this kick, apply it and add up its work."""
        held = self.held.shear
        increment, compliance = faces.increment(), part * faces.compliance
        self.path += np.abs(faces.past_increment())
        stopping = held + increment / compliance
        self.strength = self._strength(np.abs(stopping), faces.step / compliance)
        if self.pressing is not None:
            self.strength[self.pressure == 0] = 0.0  # open: nothing rubs, whatever the law
        # of the traction that stops the pair, what friction bears; slip that is left has its sense
        self.shear = np.clip(stopping, -self.strength, self.strength)
        # sigma_xy pulls the upper body, whose outward normal is -y, by -sigma_xy
        faces.push(held - self.shear, part)
        slip = part * faces.mean_increment()
        rubbed = slip * self.shear
        self._rubbed += rubbed
        self._friction += float(self.length @ rubbed)
        self._external += float(np.sum(self.length * slip * held))
