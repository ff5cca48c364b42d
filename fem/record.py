"""Collecting the histories while a model marches."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fem.model import Model
from fem.results import EnergyHistory, SlotHistory
from semianalytic.results.interface_history import InterfaceHistory


class Record:
    """Histories of the interface, the slot and the energies, filled level by level.

    Parameters
    ----------
    model : Model
    every : int
        Store every n-th time level, and the last one; the energies are those of every step.
    slot_length : float
        Length of slot next to the edge that is stored [length].
    """

    def __init__(self, model: Model, every: int, slot_length: float) -> None:
        self.model = model
        self._levels = np.union1d(np.arange(0, model.steps + 1, every), model.steps)
        self._row = self._level = 0
        stored = model.slot_x >= -slot_length
        self._slot, self._slot_x = model.slot[:, stored], model.slot_x[stored]
        self._interface = np.zeros((4, len(self._levels), len(model.contact_x)))
        self._velocity = np.zeros((2, len(self._levels), len(self._slot_x)))
        self._energy = np.zeros((6, model.steps + 1))
        self._state = np.zeros((len(self._levels), len(model.contact_x)), dtype=np.int8)

    def level(self, step: int) -> None:
        """Store a time level, if it is one to store, when its kick and tractions are done.

        Rates are means over the steps before and after the level; at t = 0 all is at rest.
        """
        if step:
            self._energy[:, step] = self._energies()
        self._level = step
        if step != self._levels[self._row]:
            return
        interface, row, dt = self.model.interface, self._row, self.model.time_step
        slip, rate, shear, pressure = self._interface[:, row]
        shear[:], pressure[:] = interface.shear, interface.pressure
        self._state[row] = interface.state()
        if step:
            if interface.sliding is not None:
                slip[:] = interface.sliding.offset()
                rate[:] = interface.sliding.mean_increment() / dt
            for body in self.model.bodies:
                increments = body.before[self._slot] + body.increment[self._slot]
                self._velocity[:, row] += increments / (2 * dt * self.model.root[self._slot])
        self._row += 1

    def _energies(self) -> NDArray[np.float64]:
        """Energies in the middle of the past step, in the order of the fields of EnergyHistory."""
        bodies = np.sum([body.energy for body in self.model.bodies], axis=0)
        kinetic, strain, damping, load = bodies * self.model.copies / self.model.time_step**2
        friction, impact, base = self.model.interface.work
        return np.array([kinetic, strain, friction, damping, load + base, impact])

    def stored(self) -> dict[str, NDArray[Any]]:
        """The rows stored so far, for a checkpoint."""
        rows = self._row
        return {
            "interface": self._interface[:, :rows],
            "slot": self._velocity[:, :rows],
            "energy": self._energy[:, : self._level + 1],
            "state": self._state[:rows],
        }

    def restore(self, stored: Mapping[str, NDArray[Any]]) -> None:
        """Go on after the rows that `stored` returned in another run of the same model."""
        self._row = rows = len(stored["state"])
        self._interface[:, :rows] = stored["interface"]
        self._velocity[:, :rows] = stored["slot"]
        self._level = stored["energy"].shape[1] - 1
        self._energy[:, : self._level + 1] = stored["energy"]
        self._state[:rows] = stored["state"]

    @property
    def states(self) -> NDArray[np.int8]:
        """State of each contact node at each stored level, (m, n)."""
        return self._state

    def histories(self) -> tuple[InterfaceHistory, SlotHistory, EnergyHistory]:
        """All that was stored."""
        t = self._levels * self.model.time_step
        return (
            InterfaceHistory(self.model.contact_x, t, *self._interface),
            SlotHistory(self._slot_x, t, *self._velocity),
            EnergyHistory(
                np.arange(0.5, self.model.steps) * self.model.time_step,
                *self._energy[:, 1:],
            ),
        )
