"""The record of a simulation: the histories that are collected while a model marches."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fem.elements.assembly import X, Y, Z
from fem.loading import arrived_wave
from fem.march import unknowns_of
from fem.model import Model
from fem.results import ContactOpening, EnergyHistory, SlotHistory
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.results.sampled import Totals
from semianalytic.scene.arrays import Array

LEAST_GAP = 1e-9
"""Gap below which the contact counts as closed, over c_t T times load or base over shear modulus:
rounding is 1e-16 of that."""
SEEN = slice(1, None)
"""Nodes of the contact whose histories are stored: all beyond the edge node."""


class MeshRecord:
    """Histories of the interface, the slot and the energies, filled level by level.

    Every n-th time level of interface and slot is stored, and the last one; energies and totals of
    the contact are those of every step.  The edge node is left out of the interface and of the
    largest slip: part of its mass belongs to the slot, and its motion does not converge.
    """

    def __init__(self, model: Model) -> None:
        self.model = model
        plan, steps, nodes = model.plan, model.steps, len(model.contact_x) - 1
        self._levels = np.union1d(np.arange(0, steps + 1, plan.settings.every), steps)
        self._row = self._level = 0
        solid, loads = plan.scene.material, plan.scene.superposition
        largest = max(max(abs(load.pressure), abs(load.shear)) for load in loads)
        # the displacement that the largest traction causes until the end
        moved = largest / solid.shear_modulus * solid.shear_speed * plan.end_time
        self._least_gap = LEAST_GAP * moved
        rows = len(self._levels)
        stored = model.slot_x >= -plan.slot_length
        self._slot_x, nodes_on_slot = model.slot_x[stored], model.slot[stored]
        rows_of, numbers = {Z if plan.scene.antiplane else X: 0, Y: 1}, model.place[nodes_on_slot]
        self._slot = [
            (body, rows_of[component], unknowns_of(numbers, component, body.components))
            for body in model.upper
            for component in body.components
            if component in rows_of
        ]
        self._interface = np.zeros((4, rows, nodes))
        self._gap = np.zeros((rows, nodes))  # takes no memory until something opens
        self._state = np.zeros((rows, nodes), dtype=np.int8)
        self._velocity = np.zeros((2, rows, len(self._slot_x)))
        self._totals = np.zeros((3, steps + 1))
        self._energy = np.zeros((6, steps + 1))
        self._opened = np.array([math.inf, 0.0, 0.0, 0.0])  # the fields of Opening
        self._after = np.zeros((model.half_window, nodes))
        self._final = np.zeros((2, nodes))

    def level(self, step: int) -> None:
        """Record a time level whose kick and tractions are done; beyond the end, only its slip.

        At t = 0 everything is at rest.
        """
        self._level = step
        if step:
            self._add_slip(step)
        if step > self.model.steps:
            return
        if step:
            self._energy[:, step] = self.model.energies()
            self._totals[:, step] = self._sums()
        offset = self.model.joint.offset[SEEN]
        gap = np.where(offset > self._least_gap, offset, 0.0)
        if gap.any():
            self._note_opening(step, gap)
        if step == self._levels[self._row]:
            self._store(step, gap)
        if step == self.model.steps:
            joint = self.model.joint
            self._final[:] = joint.path[SEEN], joint.work_density()[SEEN]

    def _store(self, step: int, gap: Array) -> None:
        joint, row, dt = self.model.joint, self._row, self.model.time_step
        slip, _, shear, pressure = self._interface[:, row]
        shear[:], pressure[:] = joint.shear[SEEN], joint.pressure[SEEN]
        self._state[row] = joint.states()[SEEN]
        if gap.any():
            self._gap[row] = gap
        if step:
            if joint.sliding is not None:
                slip[:] = joint.sliding.offset()[SEEN]
            for body, along, slot in self._slot:
                increments = body.before[slot] + body.increment[slot]
                self._velocity[along, row] += increments / (2 * dt * body.root[slot])
        self._row += 1

    def _add_slip(self, step: int) -> None:
        """Add the slip at a level to the rates of the levels whose window it begins or ends.

        The window of a level n is from n - k to n + k, k being the model's half window or, soon
        after the start, n.
        """
        sliding, half = self.model.joint.sliding, self.model.half_window
        if sliding is None:
            return
        slip, rates = sliding.offset()[SEEN], self._interface[1]
        if step > self.model.steps:
            self._after[step - self.model.steps - 1] = slip
        ended = step - half if step >= 2 * half else step / 2
        for row in np.flatnonzero(self._levels == ended):
            window = 2 * min(half, ended) * self.model.time_step
            rates[row] = (slip - rates[row]) / window
        for row in np.flatnonzero(self._levels == step + half):
            rates[row] = slip

    def _sums(self) -> Array:
        """Return the totals of the contact at this level, in the order of `Totals`."""
        joint, length = self.model.joint, self.model.joint.length
        if joint.sliding is None:
            return np.zeros(3)
        slip = joint.sliding.offset()[SEEN]
        return np.array(
            [
                np.abs(slip).max(),
                length @ joint.path,
                length @ joint.work_density(),
            ]
        )

    def _note_opening(self, step: int, gap: Array) -> None:
        """Record a gap, (n,), that is open somewhere."""
        x, length = self.model.contact_x[SEEN], self.model.joint.length
        lengths = length[SEEN].copy()
        lengths[0] += length[0]  # the edge node counts as its neighbour does
        widest = int(np.argmax(gap))
        first, place, largest, longest = self._opened
        if math.isinf(first):
            first, place = step * self.model.time_step, x[widest]
        open_now = float(lengths @ (gap > 0))
        self._opened[:] = first, place, max(largest, gap[widest]), max(longest, open_now)

    def _arrays(self) -> dict[str, NDArray[Any]]:
        """The arrays that are recorded, by their names in a checkpoint."""
        names = ("interface", "energy", "totals", "state", "gap", "opened", "after", "final")
        return {"slot": self._velocity, **{name: getattr(self, f"_{name}") for name in names}}

    def stored(self) -> dict[str, NDArray[Any]]:
        """Return everything that was recorded so far, for a checkpoint."""
        rows, levels = self._row, min(self._level, self.model.steps) + 1
        # of levels to come, half of the slip rates
        begun = int(np.searchsorted(self._levels, self._level + self.model.half_window, "right"))
        known = {"interface": begun, "slot": rows, "energy": levels, "totals": levels}
        arrays = {
            name: array[:, : known[name]] if name in known else array
            for name, array in self._arrays().items()
        }
        return arrays | {"state": self._state[:rows], "gap": self._gap[:rows]}

    def restore(self, stored: Mapping[str, NDArray[Any]]) -> None:
        """Continue from what `stored` returned in another run of the same model."""
        self._row = len(stored["state"])
        self._level = stored["energy"].shape[1] - 1
        for name, own in self._arrays().items():
            if name != "gap" or stored["gap"].any():
                own[tuple(map(slice, stored[name].shape))] = stored[name]

    def results(self) -> dict[str, Any]:
        """Return everything that was recorded, under the names of the fields of `Simulation`."""
        dt, steps = self.model.time_step, self.model.steps
        t = self._levels * dt
        first, place, largest, length = self._opened.tolist()
        fields = [*self._interface, self._gap]
        return {
            "interface": InterfaceHistory(self.model.contact_x[SEEN], t, *fields),
            "state": self._state,
            "slip_after": self._after,
            "final_path": self._final[0],
            "final_work_density": self._final[1],
            "slot": SlotHistory(self._slot_x, t, *self._whole_velocity(t)),
            "totals": Totals(dt * np.arange(steps + 1.0), *self._totals),
            "energy": EnergyHistory(np.arange(0.5, steps) * dt, *self._energy[:, 1:]),
            "opened": None if math.isinf(first) else ContactOpening(first, place, largest, length),
        }

    def _whole_velocity(self, times: Array) -> Array:
        """Return the velocity of the slot, (2, m, n), with an incident wave as part of it."""
        scene, places = self.model.plan.scene, np.zeros_like(self._slot_x)
        waves = [arrived_wave(scene, self._slot_x, places, t) for t in times.tolist()]
        along = [Z if scene.antiplane else X, Y]
        arrived = [wave.velocity[along] for wave in waves if wave is not None]
        return self._velocity + np.stack(arrived, axis=1) if arrived else self._velocity
