"""Gauges: records of a quantity at a place, on the interface or in the bodies near it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.scene.arguments import floats_of
from semianalytic.scene.arrays import Array
from semianalytic.scene.checks import LARGEST, SMALLEST, checked_number, checked_word, shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.scene import Scene
from semianalytic.selfsimilar.solution import Solution

INTERFACE: Mapping[str, str] = {
    "slip_rate": "length / time",
    "slip": "length",
    "shear_traction": "stress",
    "pressure": "stress",
}
"""Quantities of the interface, and their dimensions; they have exact derivatives."""

_KINDS: Mapping[str, tuple[str, str]] = {
    "v": ("x y z", "length / time"),
    "u": ("x y z", "length"),
    "s": ("xx yy xy xz yz", "stress"),
    "e": ("xx yy xy xz yz", "1"),
}
"""Letters of velocity, displacement, stress and strain; their components and dimensions."""

_FIELD_OF = {"v": "velocity", "u": "displacement", "s": "stress", "e": "strain"}

FIELDS: Mapping[str, str] = {
    letter + axis: dimension
    for letter, (axes, dimension) in _KINDS.items()
    for axis in axes.split()
}
"""Quantities of the bodies by name, as vx, uy, sxx and exy, and their dimensions."""

QUANTITIES: Mapping[str, str] = {**INTERFACE, **FIELDS}


@dataclass(frozen=True, eq=False)
class Gauge:
    """A record of one quantity at one place.

    Parameters
    ----------
    x : float
        Position along the interface [length]; next to a slot it must be positive for quantities of
        the interface.
    t : (n,) array
        Times of the samples [time], ascending.
    values : (n,) array
        Samples, in the units of the scene.
    noise : float or (n,) array
        Standard deviation of the errors of the samples, which are assumed to be independent.
    quantity : str
        "slip_rate", "slip", "shear_traction" or "pressure" of the interface; or of the bodies:
        velocity "vx", "vy", displacement "ux", "uy", stress "sxx", "syy", "sxy" (tension positive,
        the base included as in `Solution.stress`) or strain since t = 0 "exx", "eyy", "exy"
        (`exy` is half the shear angle), in antiplane shear also "vz", "uz", "sxz", "syz", "exz",
        "eyz".
    y : float, optional
        Distance above the interface [length], negative in the lower body; required for quantities
        of the bodies, and for these only.
    name : str
        Name of the gauge in messages and gains; if it is "", messages give its position.

    Raises
    ------
    SceneError
        If a number is out of range or not finite, times and samples do not match, or the quantity
        is unknown.

    Examples
    --------
    >>> from semianalytic import Gauge
    >>> gauge = Gauge(x=0.2, t=[0.5, 1.0], values=[0.7, 0.8], noise=0.05, quantity="slip_rate")
    >>> gauge.values.tolist(), gauge.on_interface
    ([0.7, 0.8], True)
    """

    x: float
    t: Array
    values: Array
    noise: float | Array
    quantity: str = "slip_rate"
    y: float | None = None
    name: str = ""

    def __post_init__(self) -> None:
        checked_word("gauge: quantity", self.quantity, QUANTITIES)
        object.__setattr__(self, "x", checked_number("gauge: x", self.x))
        if self.on_interface and self.y is not None:
            raise SceneError(f"gauge: {self.quantity} is a quantity of the interface; leave y out.")
        if not self.on_interface:
            if self.y is None:
                raise SceneError(f"gauge: {self.quantity} is a quantity in the bodies; give y.")
            object.__setattr__(self, "y", checked_number("gauge: y", self.y))
        for name in ("t", "values"):
            object.__setattr__(self, name, _numbers(name, getattr(self, name)))
        t, values = self.t, self.values
        if t.ndim != 1 or t.shape != values.shape or not t.size:
            raise SceneError("gauge: t and values must be one-dimensional and of equal length.")
        if not np.all(np.isfinite(t)) or not np.all(np.isfinite(values)) or np.any(np.diff(t) <= 0):
            raise SceneError("gauge: t and values must be finite numbers, and t ascending.")
        if max(np.abs(t).max(), np.abs(values).max()) > LARGEST:
            raise SceneError(f"gauge: t and values must not exceed {LARGEST:g}; use other units.")
        object.__setattr__(self, "noise", checked_noise(self.noise, values))

    def __repr__(self) -> str:
        place = f"x = {self.x:g}" + ("" if self.y is None else f", y = {self.y:g}")
        name = f"{self.name!r}, " if self.name else ""
        times = f"{len(self.t)} samples, t = {self.t[0]:.4g} ... {self.t[-1]:.4g}"
        return f"<Gauge: {name}{self.quantity} at {place}, {times}>"

    @property
    def on_interface(self) -> bool:
        """Whether the gauge records a quantity of the interface."""
        return self.quantity in INTERFACE

    @property
    def label(self) -> str:
        """Name of the gauge, or its quantity and place."""
        place = f"x = {self.x:.6g}" + ("" if self.y is None else f", y = {self.y:.6g}")
        return self.name or f"{self.quantity} at {place}"

    @property
    def half_interval(self) -> Array:
        """Half the time between samples, (n,); a hundredth of the time itself for a single one."""
        if len(self.t) > 1:
            # The mean of both neighbouring intervals, halved; one-sided at the ends.
            return np.asarray(np.gradient(self.t) / 2)
        # The smallest positive number keeps a lone sample at t = 0 from having no interval at all.
        return np.abs(self.t) / 100 + np.finfo(float).tiny


def _numbers(name: str, given: ArrayLike) -> Array:
    if (found := floats_of(given)) is None:
        raise SceneError(f"gauge: {name} must be numbers, got {shown(given)}.")
    return found.copy()


def checked_noise(given: ArrayLike, values: Array) -> float | Array:
    """Return the standard deviation of samples, one or (n,), above the rounding of values."""
    noise = _numbers("noise", given)
    if noise.shape not in ((), values.shape) or not np.all((noise > 0) & np.isfinite(noise)):
        raise SceneError(
            "gauge: noise must be positive and finite, one number or one for each sample."
        )
    # Misfits over less noise than the rounding of the values would be rounding themselves.
    least = max(SMALLEST, float(np.finfo(float).eps * np.abs(values).max()))
    if noise.min() < least or noise.max() > LARGEST:
        raise SceneError(
            f"gauge: noise must lie within {least:.2g}, to which the largest value is rounded, and "
            f"{LARGEST:g}; give the standard deviation of the samples."
        )
    return noise if noise.ndim else float(noise)


def check_gauge(gauge: Gauge, scene: Scene) -> None:
    """Raise SceneError if a scene has no such quantity."""
    quantity = gauge.quantity
    if quantity in FIELDS and "z" in quantity and not scene.antiplane:
        raise SceneError(
            f'gauge: {quantity} is zero in this scene; it needs one with mode="antiplane".'
        )


def component(quantity: str) -> tuple[str, int]:
    """Return the kind of `seen` that holds a quantity, and its row there."""
    if quantity in INTERFACE:
        return quantity, 0
    return quantity[0], _KINDS[quantity[0]][0].split().index(quantity[1:])


def seen(solution: Solution, kind: str, x: Array, y: Array, t: Array) -> Array:
    """Return what gauges would see of a solution at n places and times, (k, n).

    It is a quantity of the interface, which does not depend on y, or all components of "v",
    velocity, "u", displacement, "s", stress, or "e", strain since t = 0.
    """
    if kind in INTERFACE:
        return np.asarray(getattr(solution, kind)(x, t))[None]
    return np.asarray(getattr(solution, _FIELD_OF[kind])(x, y, t))
