"""The local problem of a march: the slip rate of each node of the line y = 0 at one time level.

On the slot the loads give the shear traction; on the contact friction does.  Neither knows of the
memory, which is contained in the traction that would stop the interface (`stepping`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from semianalytic.scene.errors import SceneError
from semianalytic.scene.scene import Scene

LARGEST_FEEDBACK = 0.95
"""Largest feedback of the shortest wave: the iteration of a step diverges from 1 on."""

Array = NDArray[np.float64]


def area_means(
    stopping: Array,
    excess: Array,
    inner: NDArray[np.bool_],
    before: Array | None = None,
    mirror: int | None = None,
) -> Array:
    """Return tractions by which nodes slip at the mean over the stretch of the line around them.

    A node stands for a stretch of 1.5 node distances on which the traction in excess of the
    strength is linear; it slips by the mean of the positive part of the excess.  Without this, the
    end of a slip zone crosses nodes one by one and radiates waves three nodes long.

    Parameters
    ----------
    stopping : (n,) array
        Absolute value of the traction that would stop each node [stress].
    excess : (n,) array
        The same less the strength of a node that does not slip [stress].
    inner : (n,) array of bool
        Whether a node has neighbours of the same contact on both sides.
    before : (n,) array, optional
        Excess at the time level before [stress]: nodes at which it falls do not take the mean,
        which would prolong slip where a zone ends.
    mirror : int, optional
        Node that is the image of the one before the first, on half of an even line.  Otherwise the
        line is periodic, which matters where its first and last nodes are `inner`.
    """
    below, last = excess < 0, len(excess) - 1
    # Beside a stuck edge the excess is singular but of one sign: there the mean must not slip.
    # Elsewhere the mean differs from the value only beside a change of sign, which the ends of the
    # line may have beyond them.
    changes = (below[1:] != below[:-1]).nonzero()[0].tolist()
    beside = {*changes, *(node + 1 for node in changes)}
    beside.update(end for end in (0, last) if inner[end])
    means = stopping
    # The few nodes are taken one by one, in a third of the time of arrays.
    for node in beside:
        if not inner[node] or (before is not None and not excess[node] > before[node]):
            continue
        left, right = node - 1, 0 if node == last else node + 1
        if mirror is not None and last >= mirror:
            left = mirror if node == 0 else left
            right = last - mirror if node == last else right
        here, earlier, later = float(excess[node]), float(excess[left]), float(excess[right])
        if min(earlier, here, later) >= 0 or max(earlier, here, later) <= 0:
            continue
        # Where strength or load jumps, the two one-sided slopes differ: the smaller one counts.
        slope = min(abs(later - earlier) / 4, abs(later - here), abs(here - earlier))
        # A traction of no size is the least there is: with more, slip would push against its sense.
        # With means over 0, 1.5 and 2 nodes the slip rate of `antiplane` is off by 2.6, 0.9 and
        # 0.3e-4, that of a zone of a thirteenth of the contact by 4.0, 1.8 and 3.0 %.
        reach = min(1.5 * slope, float(stopping[node]))
        if abs(here) < reach:
            if means is stopping:
                means = stopping.copy()
            means[node] += (here + reach) * (here + reach) / (4 * reach) - here
    return means


def check_feedback(what: str, feedback: Array) -> None:
    """Raise SceneError if the iteration of a step cannot converge under the memory's feedback.

    The iteration contracts by the feedback (size,) of the shortest wave, the largest.  h(0) = 0, so
    that it grows like the square of the step.
    """
    shortest = float(feedback[-1])
    if shortest >= LARGEST_FEEDBACK:
        raise SceneError(
            f"{what}: `step_ratio` is beyond the stable range for this Poisson ratio; lower it "
            f"by {math.ceil(100 * (1 - math.sqrt(LARGEST_FEEDBACK / shortest)))} %."
        )


def damped(feedback: Array, wavenumbers: Array, damping: float) -> Array:
    """Return the feedback of the memory (size,), raised so that short waves are damped.

    That of the shortest wave is raised to `damping`, and that of longer waves much less.

    Raises
    ------
    SceneError
        If that of the shortest wave is too close to 1 for the iteration.
    """
    check_feedback("march", feedback)
    lacking = max(damping - float(feedback[-1]), 0.0)
    return np.asarray(feedback + lacking * (wavenumbers / wavenumbers[-1]) ** 4)


@dataclass(frozen=True, eq=False)
class Level:
    """The loads that act at one time level.

    Attributes
    ----------
    time : float
        Time of the level [time].
    step : float
        Length of the step that ends there [time].
    uncut, on_slot : float, or (size,) and (slot,) arrays
        Shear traction of the uncut interface, and that of the slot faces [stress].
    pressure : (contact,) array
        Contact pressure at the nodes [stress].
    """

    time: float
    step: float
    uncut: float | Array
    on_slot: float | Array
    pressure: Array


class Line:
    """The line y = 0 in a step: shear is prescribed on the slot, the contact obeys friction.

    Parameters
    ----------
    scene : Scene
        Material, friction law and tractions.
    slot : int
        Number of nodes on the slot.

    Attributes
    ----------
    impedance : float
        Traction that slip releases at once, per relative slip rate [stress time / length].
    by_path : bool
        Whether friction may depend on the accumulated slip.
    """

    def __init__(self, scene: Scene, slot: int) -> None:
        # rho c_t / 2: half of it because V is the relative rate of two bodies
        self.impedance = scene.material.shear_impedance / 2
        self._law, self._slot = scene.law, slot
        self._is_constant = isinstance(scene.friction, float)
        # only these laws are known to have one strength at rest for one pressure
        self.by_path = not self._law.is_rated
        self._pressed = self._at_rest = np.zeros(0)
        self._inner = np.zeros(0, dtype=bool)
        self._level: Level | None = None
        self._excess: Array | None = None
        self._before: Array | None = None

    def forget(self) -> None:
        """Forget the last level, as loads jump: where slip grows or ends is not known then."""
        self._excess = None

    def recall(self, level: Level, traction: Array, rate: Array, path: Array) -> None:
        """Take up traction, slip rate and path of the contact (contact,) at a level."""
        self._look(level, path)
        if self._excess is None:
            self._level = level
            self._excess = np.abs(traction + self.impedance * rate) - self._at_rest

    def slip_rate(self, stopping: Array, level: Level, path: Array, rate: Array) -> None:
        """Find the relative slip rate of all nodes (size,) [length / time], written to `rate`.

        On the slot the shear traction is prescribed; on the contact tau = tau_stop - (rho c_t/2) V
        must satisfy the friction law, on the mean over the stretch of a node (`area_means`).

        Parameters
        ----------
        stopping : (size,) array
            Shear traction at which a node would not move [stress].
        level : Level
            Loads at the time of the slip rate.
        path : (contact,) array
            Accumulated |slip| [length].
        rate : (size,) array
            Where the result is written.
        """
        slot, on_contact, moving = self._slot, stopping[self._slot :], rate[self._slot :]
        self._look(level, path)
        if level is not self._level:
            self._level, self._before = level, self._excess
        size = np.abs(on_contact)
        self._excess = size - self._at_rest
        stopped = area_means(size, self._excess, self._inner, self._before)
        speed = self._law.slip_speed(stopped, self._pressed, self.impedance, path)
        # Slip has the sense of the traction that it reduces: V tau >= 0.  Adding 0.0 keeps the rate
        # of nodes that stick at +0.0.
        np.copysign(speed, on_contact, out=moving)
        moving += 0.0
        # on the slot tau_stop - (rho c_t/2) V is what its faces carry
        np.subtract(stopping[:slot], level.on_slot, out=rate[:slot])
        rate[:slot] /= self.impedance

    def power(self, rate: Array, path: Array) -> Array:
        """Return the frictional power (contact,) at the last level [stress length / time].

        Where a zone ends within the stretch of a node, a part of it slips under its strength, and
        the traction at the node is less: hence the strength.

        Parameters
        ----------
        rate, path : (contact,) arrays
            Slip rate [length / time] and accumulated |slip| [length] at the level.
        """
        speed = np.abs(rate)
        if self._is_constant:  # in a third of the time
            return speed * self._at_rest
        return speed * self._law.strength(self._pressed, speed, path)

    def _look(self, level: Level, path: Array) -> None:
        """Find the strength at rest under the pressure of a level and after a path (contact,)."""
        pressed = level.pressure is not self._pressed
        if pressed:
            self._pressed = level.pressure
        if pressed or self.by_path:
            self._at_rest = self._law.strength(level.pressure, np.zeros(len(path)), path)
        if len(self._inner) != len(self._at_rest):
            # the edge has no neighbour that obeys friction, and the last node none at all
            self._inner = np.ones(len(self._at_rest), dtype=bool)
            self._inner[[0, -1]] = False
