"""Loads of an interface: tractions that act on the line, or on the faces of slots."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.scene.arguments import checking_methods
from semianalytic.scene.arrays import Array
from semianalytic.scene.checks import check_fields, checked_word, shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.incident import IncidentWave, MovingLoad
from semianalytic.scene.laws.alike import Alike
from semianalytic.scene.loads import LoadHistory, Step
from semianalytic.scene.quantities import with_quantities

Part = Literal["shear", "pressure"]


@checking_methods
@with_quantities
@dataclass(frozen=True, eq=False)
class InterfaceLoad(Alike):
    """Tractions that act from t = 0 on: fields along x times a history.

    Parameters
    ----------
    shear : field or function of x and t
        Shear traction [stress]; a number, a function of x or a `Table`.  With ``history=None`` it
        is a function of x (n,) and t that returns the traction itself.
    history : LoadHistory, function of t, or None
        Factor over time, a step at t = 0 by default.
    on : str, optional
        "line": the tractions that an interface without slots, slip and gap would carry, such as
        those of an over-stressed patch or of a wave.  "slot": taken off the faces of slots.  It
        may be left out, and is then "line", where the bodies touch everywhere.
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
    history: LoadHistory | Callable[[float], float] | None = field(default_factory=Step)
    on: str | None = None
    pressure: Any = 0.0

    def __post_init__(self) -> None:
        history = self.history
        if not (history is None or isinstance(history, LoadHistory) or callable(history)):
            raise SceneError(
                f"load: history must be a LoadHistory or a function of t, got {shown(history)}."
            )
        if self.on is not None:
            checked_word("load: on", self.on, ("line", "slot"))
        from semianalytic.scene.line.fields import Table, check_field

        for name in ("shear", "pressure"):
            given = getattr(self, name)
            check_field(f"load: {name}", given)
            fixed = isinstance(given, Table) or not callable(given)
            if history is None and self.acts(name) and fixed:
                raise SceneError(
                    f"load: with history=None `{name}` must be a function of x and t, got "
                    f"{shown(given)}; leave history out for a step, or give a function of t."
                )

    def acts(self, name: Part) -> bool:
        """Return whether the load has "shear" or "pressure": anything but the number 0."""
        given = getattr(self, name)
        return callable(given) or float(given) != 0

    def traction(self, x: ArrayLike, t: float, after: bool = False, of: Part = "shear") -> Array:
        """Return the shear, or the pressure, at positions x (n,) at a time, (n,) [stress].

        At a jump of the history this is the value before it, or the one `after` it.
        """
        x, given = np.asarray(x, dtype=float), getattr(self, of)
        if self.history is None:
            return np.asarray(given(x, t) if callable(given) else 0 * x, dtype=float)
        shape = given(x) if callable(given) else given
        return np.broadcast_to(np.asarray(shape, dtype=float) * self.factor(t, after), x.shape)

    @property
    def is_timed(self) -> bool:
        """Whether the history is a function of time, of which nothing but values is known."""
        return callable(self.history) and not isinstance(self.history, LoadHistory)

    def factor(self, t: float, after: bool = False) -> float:
        """Return the factor at a time; at a jump, the value before it or the one `after` it."""
        if isinstance(self.history, LoadHistory):
            return float(self.history.value(math.nextafter(t, math.inf) if after else t))
        if self.history is None:
            return 1.0
        value = float(self.history(t))
        if not math.isfinite(value):
            raise SceneError(f"load: history must always be finite, got {value} at t = {t:g}.")
        return value

    def factors(self, times: Sequence[float]) -> Array:
        """Return the factors at times (k,), (k,); at a jump the value before it."""
        if isinstance(self.history, LoadHistory):
            return np.asarray(self.history.value(np.asarray(times)), dtype=float)
        return np.array([self.factor(t) for t in times])

    @property
    def jumps(self) -> list[float]:
        """Times at which the load jumps."""
        if isinstance(self.history, LoadHistory):
            return [float(at) for at, _ in self.history.pieces.jumps]
        return []


@checking_methods
@with_quantities
@dataclass(frozen=True, eq=False)
class FrontLoad(Alike):
    """A plane wave that arrives at an angle, or a load that moves, as one of several loads.

    The traction is S f(t - p (x - at)), with the step S and the slowness p of the front, and a
    history f that is a step by default.

    Parameters
    ----------
    front : IncidentWave or MovingLoad
        An incident wave acts on the line; a moving load is taken off the faces of slots: those at
        x < at if it moves away (its speed is positive), all that it has passed if it approaches.
    history : LoadHistory
        Factor over the time since the front.
    at : float
        Where the front is at t = 0 [length].  The part behind it is loaded from t = 0 on: a wave of
        negative angle therefore begins at the end of the line, or of the contacts.

    Raises
    ------
    SceneError
        If a parameter is of the wrong kind.

    Examples
    --------
    >>> from semianalytic import FrontLoad, IncidentWave
    >>> wave = FrontLoad(IncidentWave("SH", angle=-30.0, stress=2.0), at=4.0)
    >>> wave.on, wave.acts("pressure"), wave.runs
    ('line', False, True)
    """

    front: IncidentWave | MovingLoad
    history: LoadHistory = field(default_factory=Step)
    at: float = 0.0

    def __post_init__(self) -> None:
        if not isinstance(self.front, IncidentWave | MovingLoad):
            raise SceneError(
                f"load: front must be an IncidentWave or a MovingLoad, got {shown(self.front)}."
            )
        if not isinstance(self.history, LoadHistory):
            raise SceneError(
                f"load: the history of a front must be a LoadHistory, got {shown(self.history)}."
            )
        check_fields(self, "load", ("at",))

    @property
    def on(self) -> str:
        """Where it acts, as for `InterfaceLoad`."""
        return "line" if isinstance(self.front, IncidentWave) else "slot"

    @property
    def runs(self) -> bool:
        """Whether its front runs along x, and is not everywhere at once."""
        return isinstance(self.front, MovingLoad) or self.front.angle != 0

    def acts(self, name: Part) -> bool:
        """Return whether the load has "shear" or "pressure"."""
        front = self.front
        if isinstance(front, MovingLoad):
            return bool(getattr(front, name))
        alone = {"P": "pressure", "SV": "shear", "SH": "shear"}[front.kind]
        return name == alone or (front.kind != "SH" and front.angle != 0)

    @property
    def jumps(self) -> list[float]:
        """Times at which the load jumps, if it is everywhere at once."""
        return [] if self.runs else [float(at) for at, _ in self.history.pieces.jumps]
