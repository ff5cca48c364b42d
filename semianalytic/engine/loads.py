"""Loads of an interface: tractions that act on the line, or on the faces of slots."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from semianalytic.engine.fields import at_nodes, check_field
from semianalytic.scene.checks import shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.loads import LoadHistory, Step

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class InterfaceLoad:
    """Tractions that act from t = 0 on: fields along x times a history of time.

    Parameters
    ----------
    shear : field or function of x and t
        Shear traction [stress]; a number, a function of x or a `Table`.  With ``history=None`` it
        is a function of x (n,) and t that returns the traction itself.
    history : LoadHistory, function of t, or None
        Factor over time, a step at t = 0 by default.
    on : str
        "line": the tractions that an interface without slots, slip and gap would carry, such as
        those of an over-stressed patch or of a wave.  "slot": taken off the faces of slots.
    pressure : field or function of x and t
        Pressure [stress], positive in compression, given like `shear`.  The contact opens where the
        total pressure would be negative.

    Raises
    ------
    SceneError
        If a parameter is of the wrong kind.

    Examples
    --------
    >>> from semianalytic import InterfaceLoad
    >>> load = InterfaceLoad(lambda x: 2.0 * (abs(x) < 1), history=lambda t: min(t, 1.0))
    >>> load.traction([0.0, 3.0], 0.5).tolist()
    [1.0, 0.0]
    >>> lifted = InterfaceLoad(pressure=-3.0)
    >>> lifted.traction([0.0], 1.0, of="pressure").tolist(), lifted.acts("shear")
    ([-3.0], False)
    """

    shear: Any = 0.0
    history: LoadHistory | Callable[[float], float] | None = Step()  # noqa: RUF009
    on: str = "line"
    pressure: Any = 0.0

    def __post_init__(self) -> None:
        history = self.history
        if not (history is None or isinstance(history, LoadHistory) or callable(history)):
            raise SceneError(
                f"load: history must be a LoadHistory or a function of t, got {shown(history)}."
            )
        if self.on not in ("line", "slot"):
            raise SceneError(f'load: on must be "line" or "slot", got {shown(self.on)}.')
        for name in ("shear", "pressure"):
            field = getattr(self, name)
            check_field(f"load: {name}", field)
            if history is None and self.acts(name) and not callable(field):
                raise SceneError(f"load: without a history `{name}` must be a function of x and t.")

    def acts(self, name: str) -> bool:
        """Return whether the load has "shear" or "pressure": anything but the number 0."""
        field = getattr(self, name)
        return callable(field) or float(field) != 0

    def traction(self, x: Any, t: float, after: bool = False, of: str = "shear") -> Array:
        """Return the shear, or the pressure, at positions x (n,) at a time, (n,) [stress].

        At a jump of the history this is the value before it, or the one `after` it.
        """
        x, field = np.asarray(x, dtype=float), getattr(self, of)
        if self.history is None:
            return np.asarray(field(x, t) if callable(field) else 0 * x, dtype=float)
        shape = field(x) if callable(field) else field
        return np.broadcast_to(np.asarray(shape, dtype=float) * self.factor(t, after), x.shape)

    def factor(self, t: float, after: bool = False) -> float:
        """Return the factor at a time; at a jump, the value before it or the one `after` it."""
        if isinstance(self.history, LoadHistory):
            return float(self.history.value(math.nextafter(t, math.inf) if after else t))
        return float(self.history(t)) if self.history is not None else 1.0

    @property
    def jumps(self) -> list[float]:
        """Times at which the load jumps."""
        if isinstance(self.history, LoadHistory):
            return [float(at) for at, _ in self.history.pieces.jumps]
        return []


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
    """

    def __init__(
        self,
        of: str,
        base: Array,
        loads: Sequence[InterfaceLoad],
        x: Array,
        touching: NDArray[np.bool_],
    ) -> None:
        self._of, self._base, self._x = of, base, x
        # The field of a load that is a product of space and time is sampled only once.
        self._parts: list[tuple[Array | None, InterfaceLoad]] = []
        for load in loads:
            if load.acts(of):
                field = None
                if load.history is not None:
                    where = touching | True if load.on == "line" else ~touching
                    field = at_nodes(f"load: {of}", getattr(load, of), x, where)
                self._parts.append((field, load))

    def __call__(self, time: float, after: bool = False) -> tuple[Array, Array]:
        """Return the traction that an uncut line carries, and that of slot faces, (n,) each.

        At a jump of a load these are the values before it, or those `after` it.
        """
        line, slot = self._base.copy(), self._base.copy()
        for field, load in self._parts:
            if field is None:
                value = load.traction(self._x, time, of=self._of)
            else:
                value = field * load.factor(time, after)
            if load.on == "line":
                line += value
            else:
                slot -= value
        return line, slot
