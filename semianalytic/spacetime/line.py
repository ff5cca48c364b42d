"""The local problem of a march: the slip rate of each node of the line y = 0 at one time level.

On the slot the loads give the shear traction; on the contact friction does.  Neither knows of the
memory, which is contained in the traction that would stop the interface (`stepping`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from semianalytic.scene.scene import Scene

Array = NDArray[np.float64]


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
    """

    def __init__(self, scene: Scene, slot: int) -> None:
        # rho c_t / 2: half of it because V is the relative rate of two bodies
        self.impedance = scene.material.shear_impedance / 2
        self._law, self._friction, self._slot = scene.friction_law, scene.friction, slot
        self._pressed = self._dry = np.zeros(0)

    def slip_rate(self, stopping: Array, level: Level, path: Array, rate: Array) -> None:
        """Find the relative slip rate of all nodes (size,) [length / time], written to `rate`.

        On the slot the shear traction is prescribed; on the contact tau = tau_stop - (rho c_t/2) V
        must satisfy the friction law.

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
        if level.pressure is not self._pressed:
            self._pressed, self._dry = level.pressure, self._friction * level.pressure
        np.abs(on_contact, out=moving)
        speed = self._law.slip_speed(moving, self._dry, self.impedance, path)
        # Slip has the sense of the traction that it reduces: V tau >= 0.  Adding 0.0 keeps the rate
        # of nodes that stick at +0.0.
        np.copysign(speed, on_contact, out=moving)
        moving += 0.0
        # on the slot tau_stop - (rho c_t/2) V is what its faces carry
        np.subtract(stopping[:slot], level.on_slot, out=rate[:slot])
        rate[:slot] /= self.impedance
