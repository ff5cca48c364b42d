"""Quantities of a field to draw: speed, pressure, shear, fringes, single components."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from compare.comparison.scales import stress_scale
from compare.output.field_files import Fields, in_parts, resolved
from semianalytic import Scene, SceneError, fringes
from semianalytic.results.derived import principal_difference
from semianalytic.scene.arrays import Array
from semianalytic.scene.checks import shown
from semianalytic.scene.units import unit

FRINGES = 4
"""Default number of fringes per reference stress τ₀."""


@dataclass(frozen=True)
class Quantity:
    """A scalar at every point of the bodies."""

    label: str  # label of a colour bar, without its unit
    # name of the method of `Fields` that supplies the field
    field: Literal["velocity", "stress", "displacement"]
    of: Callable[[Array], Array]  # function that computes the scalar from the rows of that field
    # whether it is a "size" >= 0, has a "sign", or is a "light" intensity from 0 to 1
    kind: Literal["size", "sign", "light"] = "sign"

    def at(self, fields: Fields, x: Array, y: Array, t: float) -> Array:
        """Return the scalar at points (n,) [length] and a time [time]."""
        y = resolved(fields, y) if self.field == "stress" else y
        return self.of(in_parts(getattr(fields, self.field), x, y, t))

    def labelled(self, scene: Scene) -> str:
        """Return the label with its unit in a scene."""
        if self.kind == "light":
            return self.label
        dimension = {"velocity": "length / time", "displacement": "length"}.get(self.field)
        return f"{self.label} [{unit(dimension or self.field, scene.units)}]"


def _component(
    label: str, field: Literal["velocity", "stress", "displacement"], row: int
) -> Quantity:
    return Quantity(label, field, lambda rows: np.asarray(rows[row]))


QUANTITIES: Mapping[str, Quantity] = {
    "speed": Quantity(
        "particle speed $|v|$", "velocity", lambda v: np.sqrt(np.square(v).sum(axis=0)), "size"
    ),
    "pressure": Quantity(
        r"mean pressure in the plane $-(\sigma_{xx}+\sigma_{yy})/2$",
        "stress",
        lambda stress: -(stress[0] + stress[1]) / 2,
    ),
    "max-shear": Quantity(
        r"largest shear stress in the plane $(\sigma_1-\sigma_2)/2$",
        "stress",
        lambda stress: principal_difference(stress) / 2,
        "size",
    ),
    "fringes": Quantity("light intensity", "stress", lambda _: np.zeros(0), "light"),
    "vx": _component("$v_x$", "velocity", 0),
    "vy": _component("$v_y$", "velocity", 1),
    "ux": _component("$u_x$", "displacement", 0),
    "uy": _component("$u_y$", "displacement", 1),
    "sxx": _component(r"$\sigma_{xx}$ (change)", "stress", 0),
    "syy": _component(r"$\sigma_{yy}$", "stress", 1),
    "sxy": _component(r"$\sigma_{xy}$", "stress", 2),
}
ALONG_Z: Mapping[str, Quantity] = {
    "vz": _component("$v_z$", "velocity", 2),
    "uz": _component("$u_z$", "displacement", 2),
    "sxz": _component(r"$\sigma_{xz}$", "stress", 3),
    "syz": _component(r"$\sigma_{yz}$", "stress", 4),
}
"""Quantities of antiplane shear."""


def find_quantity(name: str, scene: Scene, fringe_stress: float | None = None) -> Quantity:
    """Return a quantity by its name; SceneError if the scene has none of that name.

    It is a key of `QUANTITIES`, or in antiplane shear of `ALONG_Z`, where "max-shear" is the
    largest shear stress on planes along z.  The fringe stress is the difference of principal
    stresses between fringes, i.e. fringe constant over thickness [stress]; by default the reference
    stress makes `FRINGES` fringes.
    """
    known = {**QUANTITIES, **(ALONG_Z if scene.antiplane else {})}
    if name not in known:
        alone = ", which only antiplane scenes have" if name in ALONG_Z else ""
        raise SceneError(f"of must be one of {', '.join(known)}, got {shown(name)}{alone}.")
    quantity = known[name]
    if name == "fringes":
        step = fringe_stress or stress_scale(scene) / FRINGES
        words = f"dark-field intensity, one fringe per {step:.3g} [{unit('stress', scene.units)}]"
        return replace(quantity, label=words, of=lambda stress: fringes(stress, 1.0, step))
    if name == "max-shear" and scene.antiplane:
        words = r"shear stress along z, $(\sigma_{xz}^2+\sigma_{yz}^2)^{1/2}$"
        return replace(quantity, label=words, of=lambda stress: np.hypot(stress[3], stress[4]))
    return quantity
