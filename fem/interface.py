"""The joint of two bodies: node pairs with unilateral contact and friction without a penalty.

A traction T per length on the faces of a pair with tributary length L and node masses m, m'
(upper +T, lower -T) changes the relative increment by c T, c = dt^2 L (1/m + 1/m').  Conversely,
the traction that brings a pair exactly to where it should be at the end of the step is known in
advance, without iteration or penalty.

Bodies carry changes only: tractions in place are not pushed, but do work on slip and opening.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from fem.stepping import MarchedBody
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import SceneError
from semianalytic.scene.laws.law import Law


class ContactFace(NamedTuple):
    """One component of motion of a face: its body, unknowns there, and what they add to the jump.

    The scale is one over the root of the mass of each unknown, with a sign: 1 for an upper face;
    for a lower one, whose body is described by its mirror image, 1 across the interface and -1
    along it.  What a force gives is less where a dashpot resists, and nothing where a side is held.
    """

    body: MarchedBody
    unknowns: NDArray[np.int64]
    scale: Array
    given: Array

    @classmethod
    def of(cls, body: MarchedBody, unknowns: NDArray[np.int64], sign: float = 1.0) -> ContactFace:
        """Return the face of some unknowns of a body."""
        scale = sign / body.root[unknowns]
        return cls(body, unknowns, scale, scale * body.ease[unknowns])


@dataclass(frozen=True)
class FacePair:
    """One component of motion of the two faces of a contact, or of a slot.

    They are the upper face, and the lower one unless it moves oppositely; with tributary lengths
    (n,) [length], and a step dt [time].
    """

    faces: list[ContactFace]
    length: Array
    step: float

    @cached_property
    def compliance(self) -> Array:
        """Change c = dt^2 L (1/m + 1/m') of the relative increment per traction, (n,)."""
        # a lower face that is not there moves oppositely: the jump is twice the upper motion
        inertia = (3 - len(self.faces)) * sum(face.scale * face.given for face in self.faces)
        # pairs held on both sides do not move, whatever their traction
        held = inertia == 0
        return np.asarray(self.step**2 * self.length * np.where(held, 1.0, inertia))

    def _jump(self, name: str) -> Array:
        """Return upper minus lower face of a mass-normalised vector, (n,) [length]."""
        upper, *lower = (getattr(f.body, name)[f.unknowns] * f.scale for f in self.faces)
        return np.asarray(upper + lower[0] if lower else 2 * upper)

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

        It acts for a part of a step.  The force (n,) is returned, times that part: times the mean
        increment it is the work.
        """
        force = (part * self.length) * traction
        # in mass-normalised unknowns D = s d a force F changes D by dt^2 F / s
        change = self.step**2 * force
        for face in self.faces:
            face.body.increment[face.unknowns] += change * face.given
        return force


STICK = 0
"""State of a node that does not move along the interface."""
FORWARD = 1
"""State of a node where the upper side slips towards +x."""
BACKWARD = -1
"""State of a node where the upper side slips towards -x."""
OPEN = 2
"""State of a node where the sides do not touch."""


class KickTractions(NamedTuple):
    """The tractions of a kick that are known in advance [stress]."""

    # float or (n,) arrays: tractions that the contact would carry in uncut bodies
    pressure: float | Array
    shear: float | Array
    # float or (k,) arrays: tractions on the upper slot face besides those in place, opposite on the
    # lower one
    along: float | Array
    across: float | Array


class InterfaceWork(NamedTuple):
    """Work per unit thickness at the interface [stress length^2].

    It is taken by friction and by closing gaps, and done by tractions in place on slip and opening
    and by those on the slot.
    """

    friction: float
    impact: float
    external: float


class FaceMotion(NamedTuple):
    """The motion of faces along the interface and across it, None where symmetry forbids it."""

    sliding: FacePair | None
    pressing: FacePair | None


AT_ONCE = 1e-300
"""Time in which friction without a delay follows the pressure of the first kick [time]."""


class Joint:
    """The contact and the slot during a simulation: present tractions, and the work done so far.

    A law acts on the contact with its state (n,) at t = 0; tractions are those of the kick at a
    time level, and the plate rate is the slip rate of the bodies far away [length / time].  Where
    the contact has no motion across the interface, it stays closed and its pressure as it was.
    """

    def __init__(
        self,
        law: Law,
        state: Array,
        contact: FaceMotion,
        slot: FaceMotion,
        tractions: Callable[[int], KickTractions],
        pressure: float | Array,
        plate_rate: float = 0.0,
    ) -> None:
        self.law, self.state, self.tractions, self.plate_rate = law, state, tractions, plate_rate
        (self.sliding, self.pressing), self.slot = contact, slot
        pair = self.sliding or self.pressing
        assert pair is not None
        # tributary lengths of the pairs of the contact (n,) [length]
        self.length, self.step = pair.length, pair.step
        # total tractions of the last kick, those in place included, and the pressure that friction
        # follows then (n,) [stress]
        self.pressure = pressure + np.zeros(len(self.length))
        self.felt = self.pressure.copy()
        # of the last kick: shear traction, the largest that friction bears, 0 where open [stress],
        # |slip| accumulated until then, also while open, and opening, zero to rounding where
        # closed [length], (n,) each
        self.shear, self.strength, self.path, self.offset, self._rubbed = np.zeros(
            (5, len(self.length))
        )
        # up to the middle of the step before the last kick, as in `MarchedBody.energy`
        self.work = InterfaceWork(0.0, 0.0, 0.0)
        self._friction = self._impact = self._external = 0.0

    def states(self) -> NDArray[np.int8]:
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
        """Sums carried on from kick to kick; arrays per node are those of the joint, not copies."""
        work = np.array([self._friction, self._impact, self._external])
        names = ("path", "state", "felt", "pressure")
        return {"work": work, "friction": self._rubbed} | {n: getattr(self, n) for n in names}

    def restore(self, sums: Mapping[str, Array]) -> None:
        """Continue from the sums of another run of the same model, to the last bit."""
        self._friction, self._impact, self._external = sums["work"].tolist()
        self._rubbed = sums["friction"]
        for name in ("path", "state", "felt", "pressure"):
            setattr(self, name, sums[name])

    def act(self, level: int, part: float) -> None:
        """Find the tractions of the kick at a level, which act for a part of a step; apply them.

        Friction that falls with slip rate faster than nodes can radiate raises SceneError.
        """
        known = self.tractions(level)
        self.work = InterfaceWork(self._friction, self._impact, self._external)
        loaded = [
            (faces, faces.push(np.asarray(traction), part))
            for faces, traction in zip(self.slot, (known.along, known.across), strict=True)
            if faces is not None
        ]
        before = self.pressure
        if self.pressing is not None:
            self._press(self.pressing, known.pressure, part)
        if self.sliding is not None:
            self._follow(self.sliding, level, before)
            self._slide(self.sliding, known.shear, part)
        for faces, force in loaded:
            self._external += float(force @ faces.mean_increment())

    def _press(self, faces: FacePair, in_place: float | Array, part: float) -> None:
        """Find the pressure of this kick, apply it and add up its work.

        It ends the step with the gap closed, or is zero if that needs tension.  An open pair that
        would interpenetrate is stopped exactly at the end of the step, so the gap is never negative
        and the pressure only takes energy out.
        """
        self.offset = faces.offset()
        # a pressure p adds compliance (p - in place) to the gap at the end, which is to be 0
        closing = (self.offset + faces.increment()) / (part * faces.compliance)
        self.pressure = np.maximum(in_place - closing, 0.0)
        faces.push(self.pressure - in_place, part)
        work = part * self.length * faces.mean_increment()
        self._impact -= float(work @ self.pressure)
        self._external -= float(np.sum(work * in_place))

    def _follow(self, faces: FacePair, level: int, before: Array) -> None:
        """Let path, state and pressure that friction follows evolve over the step before a kick.

        The pressure before the loads changes at once to that of the first kick.
        """
        speed = np.abs(faces.past_increment() / self.step + self.plate_rate)
        changing = before, self.pressure
        if level:
            self.path += self.step * speed
            evolved = self.law.evolved_under(self.state, speed, self.step, *changing)
            self.state = np.asarray(evolved)
        time = self.step if level else AT_ONCE
        self.felt = self.law.felt_pressure(self.felt, speed, time, *changing)

    def _slide(self, faces: FacePair, in_place: float | Array, part: float) -> None:
        """Find the shear traction of this kick, apply it and add up its work."""
        moving, compliance = self.plate_rate * self.step, part * faces.compliance
        stopping = in_place + (faces.increment() + moving) / compliance
        self.strength = self._strength(np.abs(stopping), self.step / compliance)
        # of the traction that stops the pair, what friction bears; slip that remains has its sense
        self.shear = np.clip(stopping, -self.strength, self.strength)
        # sigma_xy pulls the upper body, whose outward normal is -y, by -sigma_xy
        faces.push(in_place - self.shear, part)
        slip = part * faces.mean_increment()
        rubbed = slip * self.shear
        self._rubbed += rubbed
        self._friction += float(self.length @ rubbed)
        self._external += float(np.sum(self.length * slip * in_place))

    def _strength(self, stopping: Array, impedance: Array) -> Array:
        """Return the strength at the slip rate of the step (n,) [stress]; 0 where open."""
        law, felt, is_open = self.law, self.felt, self.pressure == 0
        if self.pressing:  # an open pair does not rub, whatever its law says of a pressure of 0
            felt = np.where(is_open, 1.0, felt)
        # steeper than that, a pair has several slip rates, or none, for one stopping traction
        slope = felt * law.fall_with_rate
        if (slope >= impedance).any():
            worst = int(np.argmax(slope / impedance))
            raise SceneError(
                "simulate: friction falls with slip rate faster than a node of the interface can "
                f"radiate (by {slope[worst]:.4g} per slip rate under the pressure it has reached, "
                f"its impedance is {impedance[worst]:.4g}); raise the rate or the dynamic friction "
                "of the law, or lower `step_ratio` (docs/limits.md)."
            )
        speed = law.slip_speed(stopping, felt, impedance, self.state)
        strength = law.strength(felt, speed, self.state)
        return np.where(is_open, 0.0, strength) if self.pressing else strength
