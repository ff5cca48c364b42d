"""Simulations with a fault in them, which no prediction is to blame for."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from fem import Simulation

PLACE = 0.3
"""Position on the contact, over c_t T, of a single node that is at fault."""


@dataclass(frozen=True)
class Fault:
    """A fault that a simulation may hold.

    Attributes
    ----------
    name : str
    what : str
        The fault in a line.
    make : callable
        Turns a simulation into one with the fault; gives None if the fault changes nothing.
    """

    name: str
    what: str
    make: Callable[[Simulation], Simulation | None]


def _field(name: str, factor: float) -> Callable[[Simulation], Simulation | None]:
    """Multiply a field of the simulation by a factor and leave its companions unchanged."""

    def make(simulation: Simulation) -> Simulation | None:
        values = factor * getattr(simulation.interface, name)
        return _with(simulation, name, values)

    return make


def _node(name: str, factor: float) -> Callable[[Simulation], Simulation | None]:
    """Multiply a field at one node by a factor."""

    def make(simulation: Simulation) -> Simulation | None:
        seen, scene = simulation.interface, simulation.scene
        place = PLACE * scene.material.shear_speed * simulation.end_time
        values = getattr(seen, name).copy()
        values[:, np.argmin(np.abs(seen.x - place))] *= factor
        return _with(simulation, name, values)

    return make


def _with(simulation: Simulation, name: str, values: np.ndarray) -> Simulation | None:
    """A simulation with other values of a field; None if they are the same."""
    seen = simulation.interface
    if np.array_equal(values, getattr(seen, name)):
        return None
    return replace(simulation, interface=replace(seen, **{name: values}))


def _moves_more(factor: float) -> Callable[[Simulation], Simulation | None]:
    """Multiply all slip on all meshes by a factor, as a wrong modulus would."""

    def make(simulation: Simulation) -> Simulation | None:
        seen = simulation.interface
        if not seen.slip.any():
            return None
        moved = replace(seen, slip=factor * seen.slip, slip_rate=factor * seen.slip_rate)
        return replace(
            simulation,
            interface=moved,
            final_path=factor * simulation.final_path,
            final_work_density=factor * simulation.final_work_density,
            companion=simulation.companion and make(simulation.companion),
        )

    return make


def _not_a_number(simulation: Simulation) -> Simulation | None:
    """Replace one value of the pressure by NaN."""
    values = simulation.interface.pressure.copy()
    values[-1, len(values[-1]) // 3] = np.nan
    return replace(simulation, interface=replace(simulation.interface, pressure=values))


FAULTS = (
    Fault("shear reversed", "shear traction of the other sign", _field("shear_traction", -1.0)),
    Fault("slip × 1.05", "slip too large, the slip rate as it was", _field("slip", 1.05)),
    Fault("slip rate × 1.02", "slip rate too large, slip as it was", _field("slip_rate", 1.02)),
    Fault("pressure × 1.02", "pressure too large", _field("pressure", 1.02)),
    Fault("motion × 1.03", "all motion too large, on all meshes", _moves_more(1.03)),
    Fault("node × 10, slip rate", "slip rate of one node too large", _node("slip_rate", 10.0)),
    Fault("node × 10, slip", "slip of one node too large", _node("slip", 10.0)),
    Fault("node × 10, shear", "traction of one node too large", _node("shear_traction", 10.0)),
    Fault("node × 10, pressure", "pressure of one node too large", _node("pressure", 10.0)),
    Fault("not a number", "one value that is not a number", _not_a_number),
)
"""Each fault affects the simulation alone, not its companions, unless its description says so."""
