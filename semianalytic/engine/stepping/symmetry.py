"""What a grid must show of an interface: nodes on its contact, and its symmetry if it has one."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from semianalytic.engine.stepping.line import Grid
from semianalytic.engine.stepping.pace import in_fours, nodes_for_contact
from semianalytic.interface.fields import sampled
from semianalytic.interface.interface import Interface
from semianalytic.scene.errors import SceneError

Array = NDArray[np.float64]

LOOKS = 66
"""Times until the end of a run at which loads are looked at, for their symmetry and identity."""


def check_touching(interface: Interface, touching: NDArray[np.bool_]) -> None:
    """Raise SceneError unless a node lies on the contact."""
    if not touching.any():
        least = in_fours(nodes_for_contact(interface))
        raise SceneError(f"run: no node lies on the contact; use {least} nodes or more.")


def times_of_loads(end_time: float) -> Array:
    """Return the times at which loads that are functions are looked at, until an end time."""
    return end_time * np.linspace(0.0, 1.0, LOOKS)[1:]


def check_even(interface: Interface, grid: Grid, end_time: float) -> None:
    """Raise SceneError if what is called even in x is not: each field at the nodes of the contact,
    each parameter of the law, and each load, also at times until an end time [time]."""
    x, on = grid.x, grid.x[interface.contact.touches(grid.x)]
    given: list[tuple[str, Any, Array]] = [
        ("contact", lambda at: 1.0 * interface.contact.touches(at), x),
        ("shear", partial(sampled, "interface: shear", interface.shear), x),
    ]
    names = ("pressure", "rate")
    fields_along: list[tuple[str, Any]] = [(name, getattr(interface, name)) for name in names]
    for part, called in ((interface.law, "friction"), (interface.adhesion, "adhesion")):
        if is_dataclass(part):
            parameters = [
                (f"{called}: {one.name}", getattr(part, one.name)) for one in fields(part)
            ]
            fields_along += [(name, value) for name, value in parameters if callable(value)]
    given += [(name, partial(sampled, name, value), on) for name, value in fields_along]
    for load in interface.loads:
        given += [
            (f"{of} of a load", partial(load.traction, t=float(time), of=of), x)
            for of in ("shear", "pressure")
            for time in times_of_loads(end_time)
        ]
    for what, value, at in given:
        right, left = value(at), value(-at)
        if np.abs(right - left).max() > 1e-9 * max(np.abs(right).max(), np.abs(left).max()):
            raise SceneError(f"interface: the {what} is not even in x; set even = false.")
