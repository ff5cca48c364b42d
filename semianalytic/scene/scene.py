"""The scene: bodies, loads and friction, the description that all solvers share.

Conventions of all modules: the interface is y = 0, with contact on x > 0 and an open slot on x < 0.
Compressive pressure is positive.  Shear traction is sigma_xy on y = 0 in plane strain, or sigma_yz
in antiplane shear, where nothing depends on z.  Slip and slip rate are relative (upper face minus
lower face), positive towards +x, or +z.  Any consistent set of units may be used.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from types import NoneType
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from semianalytic.scene.arguments import checking_methods
from semianalytic.scene.arrays import Array
from semianalytic.scene.checks import (
    among,
    check_keys,
    checked_count,
    checked_size,
    checked_word,
    shown,
)
from semianalytic.scene.errors import SceneError
from semianalytic.scene.incident import IncidentWave, MovingLoad
from semianalytic.scene.laws.alike import expression
from semianalytic.scene.laws.coulomb import Coulomb
from semianalytic.scene.laws.kinds import LAW_KINDS, checked_friction
from semianalytic.scene.laws.law import Law, check_balance, check_law
from semianalytic.scene.line.along import HALF_LINE, WHOLE_LINE, AlongLine
from semianalytic.scene.line.contact import Adhesion, Contact
from semianalytic.scene.line.loads import FrontLoad, InterfaceLoad
from semianalytic.scene.loading import (
    LOADED,
    REMOTE,
    SLOT,
    WITHOUT_SLOT,
    GrowingLoad,
    LineLoad,
    Superposition,
    Tractions,
)
from semianalytic.scene.loads import LoadHistory, Step, check_pieces
from semianalytic.scene.material import Material
from semianalytic.scene.quantities import made_in_si, with_quantities
from semianalytic.scene.tabulated import HISTORY_FIELDS, HISTORY_KINDS, history_kind
from semianalytic.scene.units import SI

SLOWEST_FRONT = 1e-4
"""Least speed of a load's front over c_t: all digits are there, at a tenth of it ten."""
IN_PLANE, ANTIPLANE = "in-plane", "antiplane"
MODES = (IN_PLANE, ANTIPLANE)
"""Directions of shear: along x, across the edge of the contact, or along z, along that edge."""
RUN = ("end_time", "nodes", "step_ratio", "every", "frames", "rtol")
"""Settings of marches that a scene may have; each method takes those that it knows."""
_LOADS = (Tractions, IncidentWave, MovingLoad, LineLoad, InterfaceLoad, FrontLoad, tuple)


@checking_methods
@with_quantities
@dataclass(frozen=True)
class Scene(AlongLine):
    """Two half-planes in frictional contact, with base tractions and a load.

    Bodies touch on x > 0, next to an open slot x < 0, unless `contact` says otherwise.  Contacts,
    fields that vary along x, several loads and laws with a state are marched along a line, which
    `period`, `rate`, `plate_rate`, `held`, `even`, `adhesion` and `run` describe.  A field is a
    number, a function of x, or a `Table`.

    Parameters
    ----------
    material : Material
        Solid on both sides of the interface, or that of the upper body, y > 0.
    friction : float or Law
        Coulomb friction coefficient f >= 0, or a law: `Coulomb` with a viscosity or cohesion,
        `RateWeakening`, `SlipWeakening`, `RateAndState`, or a class of your own.  Coulomb's law of
        a coefficient alone is stored as that number.
    base : Tractions
        Tractions (P_b, Q_b) [stress] on the whole line y = 0, at rest before t = 0.
    load : Tractions, IncidentWave, MovingLoad, Patch, PointForce, HalfLine or GrowingLoad
        Load (P_0, Q_0) [stress]; `load_on` says where tractions act.  Or a plane wave that arrives
        at an angle, or tractions that move over the slot, or that grow.  A patch, a point force and
        a half-line load bodies that touch along the whole line, without a slot.  On a line also an
        `InterfaceLoad`, a `FrontLoad`, or a sequence of loads.  None by default.
    pressure_history, shear_history : LoadHistory
        Histories f(t) by which P_0 and Q_0 are multiplied; steps by default.
    mode : str
        "in-plane": shear and slip along x, plane strain; "antiplane": shear and slip along z.
        Pressure acts in plane strain in both.
    load_on : str
        "slot": from t = 0 the slot faces x < 0 receive the traction change (-P_0 f(t), -Q_0 f(t)).
        "remote": a plane wave of normal incidence arrives from far away at t = 0, a step, and far
        ahead of the slot the contact then carries (P_b + P_0, Q_b + Q_0).
    units : str
        "SI" if all numbers are in metres, seconds, kilograms and pascals, which tables then state;
        "" for any consistent set.  Scenes that differ only in their units compare as equal.  Where
        numbers are given with units, as quantities of pint, all numbers are taken as those of the
        SI and the scene says so.
    lower_material : Material, optional
        Solid of the lower body, y < 0, if it is another one; None if both bodies are equal.
    contact : Contact
        Where the bodies touch: x > 0 by default.
    period : float
        Period of the line [length], from -period/2 to period/2; waves leave one end and enter the
        other.  By default it is so long that none comes back within the time of the march.
    rate : field
        Slip rate at t = 0 [length / time], at which a law with a state carries the base shear.
    plate_rate : float
        Slip rate of the bodies far away [length / time]; they respond to the difference from it.
    held : float
        Wavelength [length] of the slip whose stiffness resists the mean slip.  With inf no
        stiffness does, and the mean slip only radiates.
    even : bool
        Whether everything is even in x, so that only x > 0 is computed.
    adhesion : Adhesion, optional
        Tension that the contact carries before it opens; none by default.
    run : mapping
        Settings of a march, such as end_time and nodes, where others are not given to `solve`.
        Scenes that differ only in them compare as equal.

    Raises
    ------
    SceneError
        If friction is negative or not finite, if the mode or the place of the load is unknown, if
        the base, alone or with a remote load, is tensile, if the base cannot be at rest, if a
        remote load is no step, or if friction falls with slip rate faster than radiation can
        balance under the pressure in place.

    Examples
    --------
    >>> from semianalytic import Material, Scene, Tractions
    >>> scene = Scene(
    ...     Material(shear_modulus=80e9, density=7800.0, poisson_ratio=1 / 3),
    ...     friction=0.3,
    ...     base=Tractions(pressure=5e6, shear=0.0),
    ...     load=Tractions(pressure=0.0, shear=5e6),
    ... )
    >>> scene.is_self_similar
    True
    >>> scene.superposition.taken_off
    Tractions(pressure=0.0, shear=5000000.0)
    """

    material: Material
    friction: float | Law
    base: Tractions
    load: Any = Tractions(0.0, 0.0)  # noqa: RUF009
    pressure_history: LoadHistory = field(default_factory=Step)
    shear_history: LoadHistory = field(default_factory=Step)
    mode: str = IN_PLANE
    load_on: str = SLOT
    units: str = field(default="", compare=False)
    lower_material: Material | None = None
    contact: Contact = HALF_LINE
    period: float = math.inf
    rate: Any = 0.0
    plate_rate: float = 0.0
    held: float = math.inf
    even: bool = False
    adhesion: Adhesion | None = None
    run: Mapping[str, Any] = field(default_factory=dict, compare=False)

    def __post_init__(self) -> None:
        if isinstance(self.load, list | tuple):
            object.__setattr__(self, "load", tuple(self.load))
        for name, kinds in (
            ("material", (Material,)),
            ("base", (Tractions,)),
            ("load", _LOADS),
            ("lower_material", (Material, NoneType)),
            ("contact", (Contact,)),
            ("run", (Mapping,)),
        ):
            if not isinstance(getattr(self, name), kinds):
                known = " or ".join(kind.__name__ for kind in kinds if kind is not NoneType)
                known = known.replace("tuple", "a sequence of them")
                raise SceneError(
                    f"scene: {name} must be a {known}, got {shown(getattr(self, name))}."
                )
        check_keys("run.", self.run, (), RUN)
        for name, value in self.run.items():
            if name in ("nodes", "every", "frames"):
                checked_count(f"scene: run.{name}", value, 1, "a whole number from")
            else:
                checked_size(f"scene: run.{name}", value)
        # Equal bodies are one problem, however it is stated.
        if self.lower_material == self.material:
            object.__setattr__(self, "lower_material", None)
        # The class is frozen; a number is stored as a plain float, whatever its type was.
        object.__setattr__(self, "friction", checked_friction(self.friction))
        for name in HISTORY_FIELDS:
            part = getattr(self, name)
            if history_kind(part) is None:
                known = ", ".join(kind.__name__ for kind in HISTORY_KINDS.values())
                raise SceneError(
                    f"scene: {name} must be one of {known}, or of a package that brings it "
                    f"(docs/extending.md), got {shown(part)} (docs/not_here.md)."
                )
        checked_word("scene: mode", self.mode, MODES, "docs/not_here.md")
        checked_word("scene: load_on", self.load_on, LOADED)
        # Numbers given with units have been turned into those of the SI.
        if made_in_si(self) and not self.units:
            object.__setattr__(self, "units", SI)
        if not among(self.units, ("", SI)):
            raise SceneError(f'scene: units must be "SI" or left out, got {shown(self.units)}.')
        if isinstance(self.load, WITHOUT_SLOT) and self.contact == HALF_LINE:
            object.__setattr__(self, "contact", WHOLE_LINE)
        if self.on_line:
            self._check_line()
            return
        if self.base.pressure < 0:
            raise SceneError(
                "scene: base pressure must not be negative (compression is positive), "
                f"got {self.base.pressure}."
            )
        self._check_rest()
        if not isinstance(self.load, Tractions):
            self._check_front()
        if self.arrives:
            self._check_remote()
        self._check_brought()
        self.check_weakening(self.superposition.in_place.pressure)

    def _check_rest(self) -> None:
        """Raise SceneError unless friction holds the interface under the base tractions."""
        if self._at_rest(self.base):
            return
        load = self.load.tractions(self.material)
        # Base and load of a sudden remote load may have been written as one base: without the load
        # it may be at rest, and the message then says how to write it.
        before = self.base.plus(Tractions(-load.pressure, -load.shear))
        advice = "lower the base shear below friction times base pressure"
        if isinstance(self.load, Tractions) and self.is_step and self._at_rest(before):
            advice += (
                ", or, for a load that comes suddenly from far away, write "
                f'base = Tractions({before.pressure:g}, {before.shear:g}) and load_on = "{REMOTE}"'
            )
        raise SceneError(
            "scene: the interface would already slide before the load arrives; "
            f"{advice} (docs/limits.md)."
        )

    def _check_brought(self) -> None:
        """Raise SceneError unless laws and histories of other packages keep what they promise."""
        for name in HISTORY_FIELDS:
            history = getattr(self, name)
            if type(history) not in HISTORY_KINDS.values():
                check_pieces(name, history)
        pressure = self.superposition.in_place.pressure
        if type(self.law) not in LAW_KINDS.values() and pressure > 0:
            check_law(self.law, np.full(3, pressure), np.zeros(3))
            check_balance(self.law, pressure, self.material.shear_impedance / 2)

    def _check_remote(self) -> None:
        """Raise SceneError unless a load from far away is a step that leaves a contact."""
        if isinstance(self.load, Tractions) and not self.is_step:
            raise SceneError(
                "scene: a load from far away comes as a step; leave out its histories, or take "
                f'load_on = "{SLOT}" (docs/limits.md).'
            )
        pressure = self.superposition.in_place.pressure
        if pressure < 0:
            raise SceneError(
                "scene: a load from far away must leave the contact pressed together, base and "
                f"load pressure are {pressure:g} in all; raise one of them (docs/limits.md)."
            )

    def _check_front(self) -> None:
        """Raise SceneError unless a wave goes with the mode, and nothing says where it acts."""
        name = f"a load of the kind {type(self.load).__name__}"
        if self.load_on != SLOT:
            raise SceneError(
                f"scene: {name} determines where it acts; leave out load_on, which is for "
                "tractions."
            )
        if not isinstance(self.load, IncidentWave):
            if not self.is_step:
                raise SceneError(f"scene: {name} has a history of its own; leave out histories.")
            return
        if (self.load.kind == "SH") != self.antiplane:
            known = "SH" if self.antiplane else "P or SV"
            raise SceneError(
                f"scene: in {self.mode} shear an incident wave is {known}, got "
                f"{shown(self.load.kind)}; change its kind, or the mode."
            )
        # By repr, since histories of packages need not compare by value.
        if len({repr(history) for history in self.acting_histories.values()}) > 1:
            raise SceneError(
                "scene: an incident wave has one history; give pressure_history and shear_history "
                "the same one."
            )

    def __repr__(self) -> str:
        """Return the expression that makes the scene, without parameters at their default."""
        return expression(self)

    def check_weakening(self, pressure: float) -> None:
        """Raise SceneError if rate weakening is ill posed under a pressure [stress]."""
        slope = pressure * self.law.fall_with_rate
        # rho c_t / 2, the local term of the space-time equation: a steeper law would have several
        # slip rates, or none, for one stopping traction
        radiated = self.material.shear_impedance / 2
        if slope >= radiated:
            raise SceneError(
                "scene: friction falls with slip rate faster than radiation can balance "
                f"(by {slope:.4g} per slip rate under pressure {pressure:.4g}, the impedance is "
                f"{radiated:.4g}); raise its rate or dynamic friction (docs/limits.md)."
            )

    def _at_rest(self, tractions: Tractions) -> bool:
        """Return whether friction holds the interface under tractions, up to rounding."""
        strength = float(self.strength(tractions.pressure))
        # 1e-12 lets a base exactly at friction count as at rest though its product was rounded.
        return tractions.pressure >= 0 and abs(tractions.shear) <= strength * (1 + 1e-12)

    @cached_property
    def law(self) -> Law:
        """The friction law, also where `friction` is a number."""
        return self.friction if isinstance(self.friction, Law) else Coulomb(self.friction)

    @cached_property
    def coefficient(self) -> float:
        """Friction coefficient at rest, before any slip."""
        return self.friction if isinstance(self.friction, float) else self.law.coefficient

    def strength(
        self, pressure: ArrayLike, slip_rate: ArrayLike = 0.0, path: ArrayLike = 0.0
    ) -> Array:
        """Return the strength under a pressure [stress], at rest before any slip by default.

        Slip rates may be of either sign; the shapes of all arguments broadcast.
        """
        if isinstance(self.friction, float):  # also where the slip rate is infinite
            return np.asarray(self.friction * np.asarray(pressure))
        given = np.broadcast_arrays(pressure, np.abs(slip_rate), path)
        flat = (np.ravel(values).astype(float) for values in given)
        return np.reshape(self.law.strength(*flat), given[0].shape)

    @cached_property
    def superposition(self) -> Superposition:
        """Tractions in place on the contact from t = 0 on, and those taken off the slot faces."""
        load = self.load.tractions(self.material)
        return Superposition(self.base.plus(load) if self.arrives else self.base, load)

    @property
    def before_load(self) -> Tractions:
        """Tractions of the whole interface before the load, or its front, has come."""
        return self.base

    @property
    def arrives(self) -> bool:
        """Whether the load comes from far away, so that the contact carries it too."""
        return self.load_on == REMOTE or isinstance(self.load, IncidentWave)

    @cached_property
    def front_slowness(self) -> float:
        """Slowness p of the front of the load along x [time / length].

        The load acts from t = p x on: over the contact first if p < 0, along the slot if p > 0, and
        everywhere at once, p = 0, if it is no incident wave and does not move.
        """
        return self.load.slowness(self.material)

    @cached_property
    def has_slot(self) -> bool:
        """Whether there is an open slot; a patch, a point force or a half-line has none."""
        return not self.contact.is_whole

    @property
    def kind(self) -> str:
        """Kind of the scene in the table of methods."""
        if self.on_line:
            return "Scene on a line"
        if self.grows:
            return "Scene that grows"
        if not self.has_slot:
            return "Scene without a slot"
        return "Scene" if self.lower_material is None else "Scene of two solids"

    @property
    def grows(self) -> bool:
        """Whether load and strength grow as a power of time."""
        return isinstance(self.load, GrowingLoad)

    @property
    def bodies(self) -> tuple[Material, Material]:
        """Solids of the upper and of the lower body."""
        return self.material, self.lower_material or self.material

    @property
    def antiplane(self) -> bool:
        """Whether shear and slip are along z."""
        return self.mode == ANTIPLANE

    @property
    def shear_mode(self) -> Literal["II", "III"]:
        """Mode of fracture in which shear loads the edge."""
        return "III" if self.antiplane else "II"

    @property
    def static_modulus(self) -> float:
        """Static shear traction of a slip cos(q x), divided by q/2 times its amplitude [stress].

        It is mu / (1 - nu) in plane strain and mu in antiplane shear.
        """
        material = self.material
        return material.shear_modulus / (1 if self.antiplane else 1 - material.poisson_ratio)

    @property
    def fastest_speed(self) -> float:
        """Speed of the first wave [length / time]: c_l, or c_t where only antiplane shear acts."""
        wave = "shear_speed" if self.shears_alone else "longitudinal_speed"
        return max(getattr(body, wave) for body in self.bodies)

    @property
    def shears_alone(self) -> bool:
        """Whether only antiplane shear waves run: nothing presses the slot."""
        return self.antiplane and bool(self.on_line or not self.superposition.taken_off.pressure)

    @property
    def acting_histories(self) -> dict[str, LoadHistory]:
        """Histories of the loads that are not zero, by name: pressure, shear."""
        histories = {"pressure": self.pressure_history, "shear": self.shear_history}
        load = self.superposition.taken_off
        return {name: history for name, history in histories.items() if getattr(load, name)}

    @property
    def is_step(self) -> bool:
        """Whether every load that is not zero is a step."""
        return all(history == Step() for history in self.acting_histories.values())

    @property
    def is_self_similar(self) -> bool:
        """Whether all fields depend on x/t alone: step loads, friction independent of slip.

        In addition, the front of a load that comes along the slot must be ahead of all waves.
        """
        return self.is_step and self.law.keeps_similarity and not self.front_too_slow

    @property
    def front_too_slow(self) -> bool:
        """Whether the front of the load comes along the slot no faster than the first wave."""
        # p c >= 1: the front along the slot is no faster than the first wave that it sends out.
        # Tables of stuck tractions have all digits 1e-2 from it; at 1e-4, 5 in mode I.
        return self.front_slowness * self.fastest_speed >= 1 - 1e-2

    def check_front(self) -> None:
        """Raise SceneError if the front of the load leaves no self-similar answer."""
        if abs(self.front_slowness) * self.material.shear_speed > 1 / SLOWEST_FRONT:
            raise SceneError(
                f"solve: the load moves at {abs(1 / self.front_slowness):.4g}, slower than "
                f"{SLOWEST_FRONT:g} of the shear wave, so that digits are lost; make it faster "
                "(docs/limits.md)."
            )
        if self.front_too_slow:
            raise SceneError(
                "solve: the front of the load comes along the slot at "
                f"{1 / self.front_slowness:.4g}, not 1 % faster than the first wave, "
                f"{self.fastest_speed:.4g}, so that the edge was loaded for all time before and "
                "nothing depends on x/t alone; let it meet the contact first (a negative angle), "
                "or march it from where it enters the slot, with `method` space-time "
                "(docs/limits.md)."
            )
        if self.front_slowness and self.far_slip_rate:
            raise SceneError(
                "solve: the wave alone exceeds friction, so that the contact slips from its front "
                "on, before any wave from the slot arrives; lower the wave, or raise friction or "
                "the base pressure (docs/limits.md)."
            )

    def check_self_similar(self) -> None:
        """Raise SceneError unless all fields depend on x/t alone."""
        self.check_front()
        if not self.is_self_similar:
            raise SceneError(
                "the self-similar solver takes step loads only, and friction without cohesion that "
                "is constant or depends on slip rate alone; use the space-time solver for this "
                "scene, `method` space-time (docs/limits.md)."
            )

    @property
    def far_slip_rate(self) -> float:
        """Relative slip rate far ahead of all waves [length / time], 2 V(inf), before any slip.

        It is zero unless a sudden remote load exceeds friction everywhere, by more than rounding;
        strength and radiation then balance.
        """
        held = self.superposition.in_place
        shear, frictional = abs(held.shear), float(self.strength(held.pressure))
        # An excess of a few roundings is none: the contact ahead would slide at the rate of
        # rounding errors.
        if shear - frictional <= 4 * sys.float_info.epsilon * frictional:
            return 0.0
        radiated = self.material.shear_impedance / 2
        # Plane waves into both half-planes balance friction: shear - strength(V) = (rho c_t / 2) V.
        unit = np.ones(1)
        (speed,) = self.law.slip_speed(shear * unit, held.pressure * unit, radiated, 0 * unit)
        return math.copysign(float(speed), held.shear)
