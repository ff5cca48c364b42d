"""Interfaces at the nodes of finite-element meshes: their description, and fields of answers."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fem.lines import Line, LineSimulation
from semianalytic import Run
from semianalytic.engine.acting import ActingLoads
from semianalytic.engine.line import grid_of
from semianalytic.engine.tuning import LEAST_GAP
from semianalytic.interface.fields import at_nodes, sampled
from semianalytic.interface.interface import Interface
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.results.sampled import interpolated
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
    element_size: float
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


def changes_of(answer: Run | LineSimulation, done: Run) -> InterfaceHistory:
    """Return the fields of a run or a simulation in the whole period; of tractions, the changes.

    Parameters
    ----------
    answer : Run or LineSimulation
    done : Run
        The run, which knows the tractions in place.
    """
    face, spacing = done.interface, done.interface.length / done.nodes
    x, base = done.x, dict.fromkeys(UNITS, np.zeros_like(done.x))
    base["pressure"] = at_nodes("interface: pressure", face.pressure, x, done.touching, spacing)
    base["shear_traction"] = sampled("interface: shear", face.shear, x, spacing)
    if answer is not done:
        own, still = _whole(-1.0, x, done), {n: _whole(1.0, base[n], done) for n in UNITS}
        fields = {n: getattr(answer, n) - np.interp(answer.x, own, still[n]) for n in UNITS}
        return InterfaceHistory(x=answer.x, t=answer.t, **fields)
    fields = {n: _whole(1.0, getattr(done, n) - base[n], done) for n in UNITS}
    return InterfaceHistory(x=_whole(-1.0, x, done), t=done.t, **fields)


def _whole(sign: float, values: Array, done: Run) -> Array:
    """Return values at the nodes of a run (..., n) in the whole period, mirrored with a sign where
    it computed one half."""
    if not done.interface.even:
        return values
    # nodes of a whole line at 0 and length / 2 are their own mirror images
    once = 1 if done.interface.contact.is_whole else 0
    right = values[..., : values.shape[-1] - once]
    return np.concatenate([sign * values[..., once:][..., ::-1], right], axis=-1)


def moved_to(x: Array, history: InterfaceHistory) -> InterfaceHistory:
    """Return a history at other positions (n,), linear between its own."""
    places = np.broadcast_arrays(x, history.t[:, None])
    fields = {name: interpolated(history, name, *places) for name in UNITS}
    return InterfaceHistory(x=x, t=history.t, **fields)


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
