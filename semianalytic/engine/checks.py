"""Whether an interface fits a grid: nodes on the contact, and symmetry that is claimed."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from semianalytic.engine.line import Grid
from semianalytic.engine.pace import in_fours, nodes_for_contact
from semianalytic.interface.fields import sampled
from semianalytic.interface.interface import Interface
from semianalytic.scene.errors import SceneError


def check_touching(interface: Interface, touching: NDArray[np.bool_]) -> None:
    """Raise SceneError unless a node lies on the contact."""
    if not touching.any():
        least = in_fours(nodes_for_contact(interface))
        raise SceneError(f"run: no node lies on the contact; use {least} nodes or more.")


def check_even(interface: Interface, grid: Grid, time: float) -> None:
    """Raise SceneError if what is called even in x is not, at the nodes and at a time [time]."""
    x, spacing = grid.x, grid.spacing
    given: list[tuple[str, Any]] = [
        ("contact", lambda at: 1.0 * interface.contact.touches(at)),
        ("shear", lambda at: sampled("interface: shear", interface.shear, at, spacing)),
    ]
    for load in interface.loads:
        given += [
            (f"{of} of a load", partial(load.traction, t=time, of=of))
            for of in ("shear", "pressure")
        ]
    for what, value in given:
        right, left = value(x), value(-x)
        if np.abs(right - left).max() > 1e-9 * max(np.abs(right).max(), np.abs(left).max()):
            raise SceneError(f"interface: the {what} is not even in x; set even = false.")
