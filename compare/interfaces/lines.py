"""The description of an interface at the nodes of a finite-element mesh."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fem.lines import Line
from semianalytic.engine.stepping.acting import ActingLoads
from semianalytic.engine.stepping.line import grid_of
from semianalytic.interface.fields import at_nodes
from semianalytic.interface.interface import Interface
from semianalytic.scene.errors import SceneError
from semianalytic.scene.laws.sampling import sampled

Array = NDArray[np.float64]


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
