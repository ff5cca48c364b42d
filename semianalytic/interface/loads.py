"""Loads of an interface: tractions that act on the line, or on the faces of slots."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from semianalytic.dissimilar.bonded import bonded_tractions
from semianalytic.interface.fields import check_field
from semianalytic.interface.hilbert import transformed
from semianalytic.scene.checks import checked_number, shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.incident import IncidentWave, MovingLoad
from semianalytic.scene.laws.alike import Alike
from semianalytic.scene.loads import LoadHistory, Step
from semianalytic.scene.material import Material

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class InterfaceLoad(Alike):
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
    history: LoadHistory | Callable[[float], float] | None = field(default_factory=Step)
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
            given = getattr(self, name)
            check_field(f"load: {name}", given)
            if history is None and self.acts(name) and not callable(given):
                raise SceneError(f"load: without a history `{name}` must be a function of x and t.")

    def acts(self, name: str) -> bool:
        """Return whether the load has "shear" or "pressure": anything but the number 0."""
        given = getattr(self, name)
        return callable(given) or float(given) != 0

    def traction(self, x: Any, t: float, after: bool = False, of: str = "shear") -> Array:
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


@dataclass(frozen=True, eq=False)
class FrontLoad(Alike):
    """A plane wave that arrives at an angle, or a load that moves, as a load of an interface.

    The traction is S f(t - p (x - at)), with the step S and the slowness p of the front, and a
    history f that is a step by default.  At nodes it rises over the time in which the front crosses
    a node distance, but not faster than in a step.

    Parameters
    ----------
    front : IncidentWave or MovingLoad
        An incident wave acts on the line; a moving load is taken off the faces of slots: those at
        x < at if it moves away (its speed is positive), all that it has passed if it comes.
    history : LoadHistory
        Factor over the time since the front.
    at : float
        Where the front is at t = 0 [length].  What it has passed is loaded from t = 0 on: a wave of
        negative angle therefore begins at the end of the line, or of the contacts.
    material, lower : Material, optional
        The solid, and the one on y < 0 if it is another one, which `Interface` sets.  The step of a
        wave is then that of the bonded line (`dissimilar.bonded`).

    Raises
    ------
    SceneError
        If a parameter is of the wrong kind.

    Examples
    --------
    >>> from semianalytic import FrontLoad, IncidentWave, Material
    >>> wave = FrontLoad(IncidentWave("SH", angle=-30.0, stress=2.0), at=4.0)
    >>> wave = wave.of(Material(1.0, 1.0, 0.25))  # the front is at 4 - 2 t
    >>> wave.traction([1.0, 3.0], 1.0).round(6) + 0.0
    array([ 0.      , -1.732051])
    """

    front: IncidentWave | MovingLoad
    history: LoadHistory = field(default_factory=Step)
    at: float = 0.0
    material: Material | None = field(default=None, repr=False)
    lower: Material | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        if not isinstance(self.front, IncidentWave | MovingLoad):
            raise SceneError(
                f"load: front must be an IncidentWave or a MovingLoad, got {shown(self.front)}."
            )
        if not isinstance(self.history, LoadHistory):
            raise SceneError(
                f"load: the history of a front must be a LoadHistory, got {shown(self.history)}."
            )
        object.__setattr__(self, "at", checked_number("load: at", self.at))

    def of(self, material: Material, lower: Material | None = None) -> FrontLoad:
        """Return the load of a solid, or of two, of which the second one is on y < 0."""
        return replace(self, material=material, lower=lower)

    @cached_property
    def slowness(self) -> float:
        """Slowness of the front along x [time / length]."""
        assert self.material is not None
        body = self.material
        if isinstance(self.front, IncidentWave) and self.front.from_ == "below":
            body = self.lower or body
        return self.front.slowness(body)

    @cached_property
    def amplitudes(self) -> dict[str, complex]:
        """Pressure and shear per unit of the history [stress].

        They are those of the uncut line, bonded where the bodies differ; those with an imaginary
        part exert that part of the Hilbert transform of the history (`dissimilar.bonded`).
        """
        assert self.material is not None
        if self.lower is not None and isinstance(self.front, IncidentWave):
            pressure, shear = bonded_tractions(self.front, self.material, self.lower)
            return {"pressure": pressure, "shear": shear}
        one = self.front.tractions(self.material)
        return {"pressure": complex(one.pressure), "shear": complex(one.shear)}

    @property
    def on(self) -> str:
        """Where it acts, as for `InterfaceLoad`."""
        return "line" if isinstance(self.front, IncidentWave) else "slot"

    def acts(self, name: str) -> bool:
        """Return whether the load has "shear" or "pressure"."""
        front = self.front
        if isinstance(front, MovingLoad):
            return bool(getattr(front, name))
        alone = {"P": "pressure", "SV": "shear", "SH": "shear"}[front.kind]
        return name == alone or (front.kind != "SH" and front.angle != 0)

    def traction(
        self,
        x: Any,
        t: float,
        after: bool = False,
        of: str = "shear",
        spread: tuple[float, float] = (0.0, 0.0),
    ) -> Array:
        """Return the shear, or the pressure, at positions x (n,) at a time, (n,) [stress].

        At a jump of a load that is everywhere at once this is the value before it, or the one
        `after` it.

        Parameters
        ----------
        x : (n,) array
        t : float
        after : bool
        of : str
            "shear" or "pressure".
        spread : (float, float)
            Node distance [length] and step [time] over which the load is averaged.
        """
        x = np.asarray(x, dtype=float)
        slowness, size = self.slowness, self.amplitudes[of]
        since = t - slowness * (x - self.at)
        half = max(abs(slowness) * spread[0], spread[1]) / 2 if slowness else 0.0
        if half > 0:
            factor = self.history.mean(since - half, since + half)
        else:
            factor = self.history.value(np.nextafter(since, np.inf) if after else since)
        if isinstance(self.front, MovingLoad) and self.front.speed > 0:
            factor = np.where(x < self.at, factor, 0.0)
        if size.imag:
            ahead = transformed(self.history, since - half, since + half)
            return np.asarray(size.real * factor + size.imag * ahead)
        return np.asarray(size.real * factor)

    @property
    def jumps(self) -> list[float]:
        """Times at which the load jumps, if it is everywhere at once."""
        if self.slowness:
            return []
        return [float(at) for at, _ in self.history.pieces.jumps]
