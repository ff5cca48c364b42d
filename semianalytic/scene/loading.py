"""What a scene does to the interface at t = 0: tractions it puts on, and takes off the slot.

All solvers take a load as a superposition.  On the uncut line y = 0 stand tractions "in place";
the slot is made by taking tractions off its faces, and waves run out from there.  A load on the
slot leaves the base in place and takes the load off.  One from far away is a plane wave of normal
incidence that both half-planes let through as one body: from t = 0 on the whole line carries base
and load, and off the slot faces, on which the base stays, the load is taken.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from semianalytic.scene.checks import checked_number

if TYPE_CHECKING:
    from semianalytic.scene.scene import Scene

Array = NDArray[np.float64]

SLOT, REMOTE = "slot", "remote"
LOADED = (SLOT, REMOTE)
"""Where a load acts: it is taken off the slot faces, or arrives as a plane wave from far away."""


@dataclass(frozen=True)
class Tractions:
    """A uniform pair of tractions [stress]: pressure (compression positive) and shear."""

    pressure: float
    shear: float

    def __post_init__(self) -> None:
        for name in ("pressure", "shear"):
            object.__setattr__(
                self, name, checked_number(f"tractions: {name}", getattr(self, name))
            )

    def plus(self, other: Tractions) -> Tractions:
        """The sum of two."""
        return Tractions(self.pressure + other.pressure, self.shear + other.shear)


class Superposition(NamedTuple):
    """A load as all solvers take it.

    Attributes
    ----------
    in_place : Tractions
        On the contact from t = 0 on, where no wave from the slot has come.
    taken_off : Tractions
        Off the slot faces, each times its history f(t).
    """

    in_place: Tractions
    taken_off: Tractions


def superposition(scene: Scene) -> Superposition:
    """What the load of a scene puts on the interface, and takes off the slot faces."""
    if scene.load_on == REMOTE:
        return Superposition(scene.base.plus(scene.load), scene.load)
    return Superposition(scene.base, scene.load)


def superposed_by(scene: Scene, name: str) -> tuple[str, ...]:
    """What a traction of base or load is added to in the superposition.

    Parameters
    ----------
    scene : Scene
    name : str
        "base_pressure", "base_shear", "load_pressure" or "load_shear"; any other name is added to
        nothing.

    Returns
    -------
    tuple of str
        The same names, here those of what is in place, "base_...", and taken off, "load_...".
    """
    part, _, kind = name.partition("_")
    if part not in ("base", "load"):
        return ()
    comes_everywhere = part == "load" and scene.load_on == REMOTE
    return (f"base_{kind}", name) if comes_everywhere else (name,)


def traction_ahead(scene: Scene, kind: Literal["pressure", "shear"], t: ArrayLike) -> Array:
    """A traction of the contact where no wave from the slot has come, at times t, any shape
    [stress]: that of the base before t = 0, what is in place from then on."""
    before, after = getattr(scene.base, kind), getattr(scene.superposition.in_place, kind)
    return np.where(np.asarray(t, dtype=float) < 0, before, after)
