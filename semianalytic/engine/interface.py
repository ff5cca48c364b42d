"""The description of an interface: bodies, contact, friction, tractions and loads."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from semianalytic.dissimilar.kernels import BodyPair
from semianalytic.dissimilar.pair import LARGEST_CONTRAST, check_contrast
from semianalytic.engine.contact import Contact
from semianalytic.engine.fields import at_nodes, check_field
from semianalytic.engine.law import InterfaceLaw
from semianalytic.scene.checks import checked_number, checked_size, shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.loads import LoadHistory, Step
from semianalytic.scene.material import Material

Array = NDArray[np.float64]

MODES = ("in-plane", "antiplane")


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


@dataclass(frozen=True, eq=False)
class Interface:
    """A frictional interface between two half-planes, with fields that vary along x.

    Pressure, base shear, loads and all parameters of the law are fields: numbers, functions of x,
    or a `Table`.  The line y = 0 is periodic; waves leave one end and enter the other after
    length / c_l.

    Parameters
    ----------
    material : Material
        The solid on both sides, or that on y > 0.
    law : InterfaceLaw
        Friction; `Coulomb`, `SlipDependent`, `RateDependent`, `RateAndState`, or a law of your own.
    length : float
        Period of the line [length]; x runs from -length/2 to length/2.
    pressure : field
        Contact pressure [stress], 0 or more.
    shear : field
        Shear traction before slip, in place at t = 0 [stress].
    loads : sequence of InterfaceLoad
        Shear and pressure that are added from t = 0 on.
    contact : Contact
        Where the bodies touch; everywhere by default.
    mode : str
        "in-plane" or "antiplane".
    rate : field
        Slip rate at t = 0 [length / time], at which a law with a state carries the base shear.
    plate_rate : float
        Slip rate of the bodies far away [length / time]; the memory acts on the difference.
    held : float
        Wavelength [length] of the slip whose stiffness resists the mean slip.  With inf no
        stiffness does, and the mean slip only radiates.
    even : bool
        Whether everything is even in x, so that only x > 0 is computed.
    lower_material : Material, optional
        The solid on y < 0 if it is another one.  Slip then changes the pressure (in-plane only).

    Raises
    ------
    SceneError
        If a parameter is out of range; the message says what to change.

    Examples
    --------
    >>> from semianalytic import Interface, Material, SlipDependent
    >>> fault = Interface(Material(1.0, 1.0, 0.25), SlipDependent(0.6, 0.1, 0.02), length=20.0,
    ...                   pressure=1.0, shear=lambda x: 0.4 + 0.25 * (abs(x) < 1))
    >>> fault.mode, fault.contact.is_whole
    ('in-plane', True)
    """

    material: Material
    law: InterfaceLaw
    length: float
    pressure: Any = 1.0
    shear: Any = 0.0
    loads: Sequence[InterfaceLoad] = ()
    contact: Contact = Contact()  # noqa: RUF009
    mode: str = "in-plane"
    rate: Any = 0.0
    plate_rate: float = 0.0
    held: float = math.inf
    even: bool = False
    lower_material: Material | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.material, Material):
            raise SceneError(f"interface: material must be a Material, got {shown(self.material)}.")
        if not isinstance(self.law, InterfaceLaw):
            raise SceneError(
                "interface: law must be an InterfaceLaw such as Coulomb or RateAndState, got "
                f"{shown(self.law)}."
            )
        object.__setattr__(self, "length", checked_size("interface: length", self.length))
        for name in ("pressure", "shear", "rate"):
            check_field(f"interface: {name}", getattr(self, name))
        loads = [self.loads] if isinstance(self.loads, InterfaceLoad) else list(self.loads)
        if not all(isinstance(load, InterfaceLoad) for load in loads):
            raise SceneError(f"interface: loads must be InterfaceLoads, got {shown(self.loads)}.")
        object.__setattr__(self, "loads", tuple(loads))
        if not isinstance(self.contact, Contact):
            raise SceneError(f"interface: contact must be a Contact, got {shown(self.contact)}.")
        if self.mode not in MODES:
            raise SceneError(f"interface: mode must be in-plane or antiplane, got {self.mode!r}.")
        if not isinstance(self.even, bool):
            raise SceneError(f"interface: even must be true or false, got {shown(self.even)}.")
        if self.lower_material is not None:
            self._check_lower(self.lower_material)
        if self.mode == "antiplane" and self.may_open:
            raise SceneError(
                "interface: loads of an antiplane interface have no pressure; leave it out or set "
                'mode = "in-plane".'
            )
        plate = checked_number("interface: plate_rate", self.plate_rate)
        object.__setattr__(self, "plate_rate", plate)
        if self.held != math.inf:
            object.__setattr__(self, "held", checked_size("interface: held", self.held))

    def _check_lower(self, lower: Material) -> None:
        if not isinstance(lower, Material):
            raise SceneError(f"interface: lower_material must be a Material, got {shown(lower)}.")
        check_contrast(self.material, lower, LARGEST_CONTRAST)
        if self.pair is None:
            return
        if self.mode == "antiplane":
            raise SceneError(
                'interface: between different bodies mode must be "in-plane"; leave out '
                "lower_material or change the mode."
            )
        if self.even:
            raise SceneError(
                "interface: slip between different bodies is not even in x, because it raises the "
                "pressure on one side and lowers it on the other; set even = false."
            )

    @property
    def pair(self) -> BodyPair | None:
        """The two bodies if they are different ones."""
        if self.lower_material is None or self.lower_material == self.material:
            return None
        return BodyPair(self.material, self.lower_material)

    @property
    def impedance(self) -> float:
        """Traction per relative slip rate of plane waves [stress time / length].

        It is mu / (2 c_t) between identical bodies.
        """
        return self.material.shear_impedance / 2 if self.pair is None else self.pair.impedances[0]

    @property
    def opening_impedance(self) -> float:
        """Pressure per rate of the gap [stress time / length]; rho c_l / 2 if bodies are alike."""
        if self.pair is not None:
            return self.pair.impedances[1]
        return self.material.density * self.material.longitudinal_speed / 2

    @property
    def may_open(self) -> bool:
        """Whether a load, or slip of different bodies, changes the pressure: gaps are computed."""
        return self.pair is not None or any(load.acts("pressure") for load in self.loads)

    @property
    def jumps(self) -> list[float]:
        """Times after t = 0 at which a load jumps, in order."""
        return sorted({at for load in self.loads for at in load.jumps if at > 0})
