"""Shear and pressure that loads exert at the nodes of a grid over time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from semianalytic.interface.fields import at_nodes, moving
from semianalytic.interface.loads import FrontLoad, InterfaceLoad

Array = NDArray[np.float64]


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
        of: str,
        base: Array,
        loads: Sequence[InterfaceLoad | FrontLoad],
        x: Array,
        touching: NDArray[np.bool_],
        step: float = 0.0,
    ) -> None:
        self._of, self._base, self._x, self._free = of, base, x, ~touching
        self._spread = (float(x[1] - x[0]), step)
        # The field of a load that is a product of space and time is sampled only once.
        self._parts: list[tuple[Array | None, InterfaceLoad | FrontLoad]] = []
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
            if isinstance(load, FrontLoad):
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
            now = [one[at] for one in factors]
            if not steady or now != kept:
                line, slot = self(time)
                slot, kept = slot[self._free], now
            yield line, slot
