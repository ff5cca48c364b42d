"""The description of an interface: bodies, contact, friction, tractions and loads."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from semianalytic.dissimilar.kernels import BodyPair
from semianalytic.dissimilar.pair import LARGEST_CONTRAST, check_contrast
from semianalytic.interface.contact import Adhesion, Contact
from semianalytic.interface.fields import check_field
from semianalytic.interface.hilbert import comes_back
from semianalytic.interface.loads import FrontLoad, InterfaceLoad
from semianalytic.scene.checks import checked_number, checked_size, shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.incident import IncidentWave, MovingLoad
from semianalytic.scene.laws.alike import Alike
from semianalytic.scene.laws.law import Law
from semianalytic.scene.material import Material
from semianalytic.scene.scene import MODES


@dataclass(frozen=True, eq=False)
class Interface(Alike):
    """A frictional interface between two half-planes, with fields that vary along x.

    Pressure, base shear, loads and all parameters of the law are fields: numbers, functions of x,
    or a `Table`.  The line y = 0 is periodic; waves leave one end and enter the other after
    length / c_l.

    Parameters
    ----------
    material : Material
        The solid on both sides, or that on y > 0.
    law : Law
        Friction; `Coulomb`, `SlipWeakening`, `RateWeakening`, `RateAndState`, or a law of your own.
    length : float
        Period of the line [length]; x runs from -length/2 to length/2.
    pressure : field
        Contact pressure [stress], 0 or more.
    shear : field
        Shear traction before slip, in place at t = 0 [stress].
    loads : sequence of InterfaceLoad, IncidentWave, MovingLoad or FrontLoad
        Shear and pressure that are added from t = 0 on.  A wave or moving load given itself is a
        `FrontLoad` whose front is at x = 0 at t = 0.
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
    adhesion : Adhesion, optional
        Tension that the contact carries before it opens; none by default.

    Raises
    ------
    SceneError
        If a parameter is out of range; the message says what to change.

    Examples
    --------
    >>> from semianalytic import Interface, Material, SlipWeakening
    >>> fault = Interface(Material(1.0, 1.0, 0.25), SlipWeakening(0.6, 0.1, 0.02), length=20.0,
    ...                   pressure=1.0, shear=lambda x: 0.4 + 0.25 * (abs(x) < 1))
    >>> fault.mode, fault.contact.is_whole
    ('in-plane', True)
    """

    material: Material
    law: Law
    length: float
    pressure: Any = 1.0
    shear: Any = 0.0
    loads: Any = ()
    contact: Contact = Contact()  # noqa: RUF009
    mode: str = "in-plane"
    rate: Any = 0.0
    plate_rate: float = 0.0
    held: float = math.inf
    even: bool = False
    lower_material: Material | None = None
    adhesion: Adhesion | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.material, Material):
            raise SceneError(f"interface: material must be a Material, got {shown(self.material)}.")
        if not isinstance(self.law, Law):
            raise SceneError(
                "interface: law must be a Law such as Coulomb or RateAndState, got "
                f"{shown(self.law)}."
            )
        object.__setattr__(self, "length", checked_size("interface: length", self.length))
        for name in ("pressure", "shear", "rate"):
            check_field(f"interface: {name}", getattr(self, name))
        object.__setattr__(self, "loads", self._bound_loads())
        if not isinstance(self.contact, Contact):
            raise SceneError(f"interface: contact must be a Contact, got {shown(self.contact)}.")
        reach = self.length / 2
        for begin, end in self.contact.intervals:
            if any(math.isfinite(one) and abs(one) > reach for one in (begin, end)):
                raise SceneError(
                    f"interface: the contact {begin:g} to {end:g} leaves the period, {-reach:g} to "
                    f"{reach:g}; raise `length`, or let an open end be inf."
                )
        if self.mode not in MODES:
            raise SceneError(f"interface: mode must be in-plane or antiplane, got {self.mode!r}.")
        if not isinstance(self.even, bool):
            raise SceneError(f"interface: even must be true or false, got {shown(self.even)}.")
        if self.lower_material is not None:
            self._check_lower(self.lower_material)
        for load in self.loads:
            if isinstance(load, FrontLoad):
                self._check_front(load)
        if not isinstance(self.adhesion, Adhesion | None):
            raise SceneError(
                f"interface: adhesion must be an Adhesion, got {shown(self.adhesion)}."
            )
        if self.adhesion is not None and not self.may_open:
            raise SceneError(
                "interface: nothing opens without a load that has a pressure; leave out adhesion."
            )
        if self.mode == "antiplane" and self.may_open:
            raise SceneError(
                "interface: loads of an antiplane interface have no pressure; leave it out or set "
                'mode = "in-plane".'
            )
        plate = checked_number("interface: plate_rate", self.plate_rate)
        object.__setattr__(self, "plate_rate", plate)
        if self.held != math.inf:
            object.__setattr__(self, "held", checked_size("interface: held", self.held))

    def _bound_loads(self) -> tuple[InterfaceLoad | FrontLoad, ...]:
        """Return the loads, fronts of them with the material of the upper body."""
        given: Any = self.loads
        single = isinstance(given, InterfaceLoad | FrontLoad | IncidentWave | MovingLoad)
        loads: list[InterfaceLoad | FrontLoad] = []
        for load in [given] if single else list(given):
            if isinstance(load, IncidentWave | MovingLoad):
                load = FrontLoad(load)
            if not isinstance(load, InterfaceLoad | FrontLoad):
                raise SceneError(
                    "interface: loads must be InterfaceLoads, incident waves or moving loads, got "
                    f"{shown(load)}."
                )
            if isinstance(load, FrontLoad):
                load = load.of(self.material, self.lower_material if self.pair else None)
            loads.append(load)
        return tuple(loads)

    def _check_front(self, load: FrontLoad) -> None:
        front = load.front
        if isinstance(front, IncidentWave):
            known = ("SH",) if self.mode == "antiplane" else ("P", "SV")
            if front.kind not in known:
                raise SceneError(
                    f"interface: a wave that arrives {self.mode} must be of kind "
                    f"{' or '.join(known)}, got {front.kind}."
                )
            runs_ahead = any(one.imag for one in load.amplitudes.values())
            if runs_ahead and not comes_back(load.history):
                raise SceneError(
                    f"interface: at {front.angle:g} degrees, beyond a critical angle, a wave runs "
                    "along the interface ahead of the front; its history has to return to 0 by "
                    "jumps and straight lines, as a rectangle, a triangle or a Table does."
                )
        if self.even and load.slowness:
            raise SceneError(
                "interface: a front that runs along x is not even in x; set even = false."
            )

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
    def units(self) -> str:
        """System of units of the numbers, which interfaces do not name."""
        return ""

    @property
    def impedance(self) -> float:
        """Traction per relative slip rate of plane waves [stress time / length].

        It is mu / (2 c_t) between identical bodies.
        """
        return self.material.shear_impedance / 2 if self.pair is None else self.pair.impedances[0]

    @property
    def fastest(self) -> float:
        """Speed of the fastest wave [length / time], in antiplane shear without pressure c_t."""
        bodies = (self.material, self.lower_material or self.material)
        sheared = self.mode == "antiplane"
        return max(one.shear_speed if sheared else one.longitudinal_speed for one in bodies)

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
