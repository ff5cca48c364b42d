"""Interfaces at the nodes of finite-element meshes: their description, and fields of answers."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from compare.comparison.quantities.own_rows import fields_of, refuse_unfinite
from fem.lines import Line, LineSimulation
from semianalytic import Run
from semianalytic.engine.acting import ActingLoads
from semianalytic.engine.line import grid_of
from semianalytic.engine.tuning import LEAST_GAP
from semianalytic.interface.fields import at_nodes, sampled
from semianalytic.interface.interface import Interface
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.scene.errors import SceneError

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

NOTHING = 1e-9
"""Part of the slip, or of the strength, below which a gap or a traction counts as none, and of what
loads would move, below which contacts that can stick do not."""
UNITS = {
    "slip": "length",
    "slip_rate": "length / time",
    "gap": "length",
    "shear_traction": "stress",
    "pressure": "stress",
}
"""Unit of each field; of tractions, changes are compared."""


@dataclass(frozen=True, eq=False)
class LineMesh:
    """A simulation as it is compared, and the next coarser one."""

    interface: InterfaceHistory
    resolution: int
    companion: LineMesh | None
    rate_window: float = 0.0


def line_of(interface: Interface, nodes: int, shift: float | None = None) -> Line:
    """Return what finite elements have to know of an interface, at the nodes that `run` has.

    Parameters
    ----------
    interface : Interface
    nodes : int
        Nodes of the whole period; even interfaces are simulated on all of it.
    shift : float, optional
        Distance by which the nodes are moved [length]; what suits the ends of contacts by default.

    Raises
    ------
    SceneError
        If mean slip is held, which no body does, there is adhesion, or a field has no value at a
        node.
    """
    if interface.held != math.inf:
        raise SceneError(
            "simulate: finite elements have no stiffness that holds the mean slip; leave out "
            "`held` (docs/engine.md)."
        )
    if interface.adhesion is not None:
        raise SceneError(
            "simulate: finite elements have no adhesion; leave it out to compare (docs/engine.md)."
        )
    # Even interfaces are simulated on all of the line.
    grid = replace(grid_of(interface, nodes, shift), even=False)
    x, spacing = grid.x, grid.spacing
    touching = interface.contact.touches(x)
    on = x[touching]
    law = interface.law.on(on, spacing)
    pressure = at_nodes("interface: pressure", interface.pressure, x, touching, spacing)
    shear = sampled("interface: shear", interface.shear, x, spacing)
    rate = np.abs(sampled("interface: rate", interface.rate, on))
    state = np.asarray(law.start(pressure[touching], shear[touching], rate), dtype=float)
    return Line(
        upper=interface.material,
        lower=interface.lower_material or interface.material,
        length=interface.length,
        x=x,
        touching=touching,
        friction=law,
        state=state,
        shear=ActingLoads("shear", shear, interface.loads, x, touching),
        pressure=ActingLoads("pressure", pressure, interface.loads, x, touching),
        opens=interface.may_open,
        antiplane=interface.mode == "antiplane",
        plate_rate=interface.plate_rate,
    )


def field_at(answer: Run | LineSimulation, name: str, done: Run, count: int) -> Array:
    """Return a field of a run or a simulation, of tractions its change, at so many places, (m, n).

    Parameters
    ----------
    answer, name
        The run or a simulation, and the field.
    done : Run
    count : int
        Number n of places in the whole period; its own nodes are a multiple of them.
    """
    values = getattr(answer, name)
    if answer is not done:
        return _common(values - _in_place(name, done, answer.nodes), count, done)
    return _common(_whole(values, done) - _in_place(name, done, done.nodes), count, done)


def touching(answers: Iterable[Run | LineSimulation], done: Run, count: int) -> Mask:
    """Return which of so many places stand for nothing but contact in all answers, (count,)."""
    on = np.ones(count, dtype=bool)
    for one in answers:
        whole = one.touching[None].astype(float)
        on &= _common(_whole(whole, done) if one is done else whole, count, done)[0] == 1
    return on


def history_of(answer: Run | LineSimulation, done: Run, x: Array) -> InterfaceHistory:
    """Return all fields of a run or a simulation at places of the whole period (n,)."""
    fields = {name: field_at(answer, name, done, len(x)) for name in UNITS}
    return InterfaceHistory(x=x, t=answer.t, **fields)


def places(one: LineSimulation, done: Run, count: int) -> Array:
    """Return the positions of so many places of the period of a simulation, (count,) [length]."""
    return _common(one.x[None], count, done)[0]


def check_lines(done: Run, simulations: Iterable[LineSimulation]) -> None:
    """Raise DataFileError if a field of a run or a simulation holds what is no finite number."""
    refuse_unfinite("the run", done.x, done.t, fields_of(done, UNITS))
    for one in simulations:
        whose = f"the simulation of {one.nodes} nodes"
        refuse_unfinite(whose, one.x, one.t, fields_of(one, (*UNITS, "strength")))
        refuse_unfinite(whose, one.x, one.window[:, 1], {"slip": one.window_slip[:, 1]})


def nothing_of(done: Run, name: str) -> float:
    """Return the mean of a field of a run up to which it counts as nothing.

    It is a part of the motion of the faces or of all tractions: rounding moves faces that rest, and
    a small gap decides nothing.
    """
    mean = {one: float(np.abs(getattr(done, one)[:, done.touching]).mean()) for one in UNITS}
    stress = max(mean["shear_traction"], mean["pressure"])
    motion = max(mean["slip"], mean["gap"])
    if UNITS[name] == "stress":
        return NOTHING * stress
    if name == "gap":  # slots are wider than contacts open
        return LEAST_GAP * motion
    if done.interface.law.has_threshold:
        motion = max(motion, stress * done.end_time / done.interface.material.shear_impedance)
    return NOTHING * motion / (done.end_time if name == "slip_rate" else 1.0)


def _in_place(name: str, done: Run, count: int) -> Array:
    """Return the tractions in place at t = 0 at so many places, (count,) [stress]; 0 for others."""
    interface, spacing = done.interface, done.interface.length / done.nodes
    if name == "pressure":
        base = at_nodes("interface: pressure", interface.pressure, done.x, done.touching, spacing)
    elif name == "shear_traction":
        base = sampled("interface: shear", interface.shear, done.x, spacing)
    else:
        return np.zeros(count)
    return _common(_whole(base[None], done), count, done)[0]


def _whole(values: Array, done: Run) -> Array:
    """Return fields (m, n) of a run on the whole period, mirrored where it computed one half."""
    if not done.interface.even:
        return values
    if done.interface.contact.is_whole:
        # nodes at 0 and length / 2 are their own mirror images
        return np.concatenate([values[:, :0:-1], values[:, :-1]], axis=1)
    return np.concatenate([values[:, ::-1], values], axis=1)


def _common(values: Array, count: int, done: Run) -> Array:
    """Return fields (m, n) at the nodes of a coarser grid of the same period, (m, count).

    Nodes of grids that lie between the ends of contacts do not coincide: means replace them.
    """
    times = values.shape[1] // count
    if done.interface.contact.is_whole:
        return np.asarray(values[:, ::times])
    return np.asarray(values.reshape(len(values), count, times).mean(axis=2))
