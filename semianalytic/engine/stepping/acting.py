"""Shear and pressure that loads exert at nodes over time, and whether these are as they must be."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import fields, is_dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from semianalytic.engine.stepping.fronts import ActingFront
from semianalytic.engine.stepping.line import Grid
from semianalytic.engine.stepping.pace import in_fours, nodes_for_contact
from semianalytic.scene.arrays import Array
from semianalytic.scene.errors import SceneError
from semianalytic.scene.laws.sampling import moving, sampled
from semianalytic.scene.line.fields import at_nodes
from semianalytic.scene.line.loads import InterfaceLoad, Part
from semianalytic.scene.scene import Scene


class ActingLoads:
    """Shear or pressure at the nodes of a grid over time: the base traction and the loads.

    Parameters
    ----------
    of : str
        "shear" or "pressure".
    base : (n,) array
        Traction before t = 0 [stress].
    loads : sequence of InterfaceLoad
        Loads, of which those that have this traction are added.
    x : (n,) array
        Positions of the nodes [length].
    touching : (n,) array of bool
        Whether the bodies touch there.
    step : float
        Shortest step [time], over which the fronts of loads rise at least.
    """

    def __init__(
        self,
        of: Part,
        base: Array,
        loads: Sequence[InterfaceLoad | ActingFront],
        x: Array,
        touching: NDArray[np.bool_],
        step: float = 0.0,
    ) -> None:
        self._of, self._base, self._x, self._free = of, base, x, ~touching
        self._spread = (float(x[1] - x[0]), step)
        # The field of a load that is a product of space and time is sampled only once.
        self._parts: list[tuple[Array | None, InterfaceLoad | ActingFront]] = []
        for load in loads:
            if load.acts(of):
                shape = None
                if isinstance(load, InterfaceLoad) and load.history is not None:
                    where = touching | True if load.on == "line" else ~touching
                    shape = at_nodes(f"load: {of}", getattr(load, of), x, where, self._spread[0])
                self._parts.append((shape, load))

    def __call__(self, time: float, after: bool = False) -> tuple[Array, Array]:
        """Return the traction that an uncut line carries, and that of slot faces, (n,) each.

        At a jump of a load these are the values before it, or those `after` it.
        """
        line, slot = self._base.copy(), self._base.copy()
        for shape, load in self._parts:
            if isinstance(load, ActingFront):
                value = load.traction(self._x, time, after, self._of, self._spread)
            elif shape is None:
                value = moving(getattr(load, self._of), self._x, time, self._spread[0])
            else:
                value = shape * load.factor(time, after)
            if load.on == "line":
                line += value
            else:
                slot -= value
        return line, slot

    def over(self, times: Sequence[float]) -> Iterator[tuple[Array, Array]]:
        """Yield what `__call__` returns at one time after the other, that of faces at slots alone.

        Arrays stay the same objects as long as the loads do not change.
        """
        # what is a product of space and time changes with its factor alone
        products = [load for _, load in self._parts if isinstance(load, InterfaceLoad)]
        steady = len(products) == len(self._parts)
        steady = steady and not any(load.history is None for load in products)
        factors = [load.factors(times).tolist() for load in products]
        kept: list[float] | None = None
        line = slot = self._base
        for at, time in enumerate(times):
            now = [factor[at] for factor in factors]
            if not steady or now != kept:
                line, slot = self(time)
                slot, kept = slot[self._free], now
            yield line, slot


LOOKS = 66
"""Times until the end of a run at which loads are looked at, for their symmetry and identity."""


def check_touching(scene: Scene, touching: NDArray[np.bool_]) -> None:
    """Raise SceneError unless a node lies on the contact."""
    if not touching.any():
        least = in_fours(nodes_for_contact(scene))
        raise SceneError(f"march: no node lies on the contact; use {least} nodes or more.")


def check_even(
    scene: Scene, loads: Sequence[InterfaceLoad | ActingFront], grid: Grid, end_time: float
) -> None:
    """Raise SceneError if what is called even in x is not: each field at the nodes of the contact,
    each parameter of the law, and each load, also at times until an end time [time]."""
    x, on = grid.x, grid.x[scene.contact.touches(grid.x)]
    given: list[tuple[str, Any, Array]] = [
        ("contact", lambda at: 1.0 * scene.contact.touches(at), x),
        ("shear", partial(sampled, "scene: shear", scene.base.shear), x),
    ]
    fields_along: list[tuple[str, Any]] = [("pressure", scene.base.pressure), ("rate", scene.rate)]
    for part, called in ((scene.law, "friction"), (scene.adhesion, "adhesion")):
        if is_dataclass(part):
            parameters = [
                (f"{called}: {field.name}", getattr(part, field.name)) for field in fields(part)
            ]
            fields_along += [(name, value) for name, value in parameters if callable(value)]
    given += [(name, partial(sampled, name, value), on) for name, value in fields_along]
    for load in loads:
        given += [
            (f"{of} of a load", partial(load.traction, t=float(time), of=of), x)
            for of in ("shear", "pressure")
            for time in end_time * np.linspace(0.0, 1.0, LOOKS)[1:]
        ]
    for what, value, at in given:
        right, left = value(at), value(-at)
        if np.abs(right - left).max() > 1e-9 * max(np.abs(right).max(), np.abs(left).max()):
            raise SceneError(f"scene: the {what} is not even in x; set even = false.")
