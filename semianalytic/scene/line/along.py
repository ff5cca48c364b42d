"""Properties of a scene along a line: contacts, fields along x, several loads, for a march."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property
from numbers import Real
from typing import Any

from semianalytic.scene.checks import check_fields, checked_size, plain, shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.incident import IncidentWave, MovingLoad
from semianalytic.scene.laws.kinds import beyond_similarity
from semianalytic.scene.laws.law import Law
from semianalytic.scene.line.contact import Adhesion, Contact
from semianalytic.scene.line.loads import FrontLoad, InterfaceLoad
from semianalytic.scene.loading import REMOTE, WITHOUT_SLOT, Tractions
from semianalytic.scene.loads import LoadHistory, Step
from semianalytic.scene.material import Material

HALF_LINE, WHOLE_LINE = Contact.half_line(), Contact()


class AlongLine:
    """The part of a scene that only a march along the line knows, and what follows from it."""

    material: Material
    lower_material: Material | None
    friction: float | Law
    base: Tractions
    load: Any
    pressure_history: LoadHistory
    shear_history: LoadHistory
    mode: str
    load_on: str
    contact: Contact
    period: float
    rate: Any
    plate_rate: float
    held: float
    even: bool
    adhesion: Adhesion | None
    run: Any

    @cached_property
    def on_line(self) -> str:
        """Properties that only a march along a line takes, in words; "" if there are none."""
        if isinstance(self.friction, Law) and (beyond := beyond_similarity(self.friction)):
            return f"{type(self.friction).__name__} with {beyond}"
        parts = [self.base, self.load] if isinstance(self.load, Tractions) else [self.base]
        if any(callable(value) for part in parts for value in (part.pressure, part.shear)):
            return "tractions that vary along x"
        if isinstance(self.load, tuple | InterfaceLoad | FrontLoad):
            return "loads along x"
        # the slot x < 0 next to a contact, or the contact everywhere of loads without a slot
        if self.contact != (WHOLE_LINE if isinstance(self.load, WITHOUT_SLOT) else HALF_LINE):
            return "contacts"
        usuals = {"period": math.inf, "plate_rate": 0.0, "held": math.inf, "rate": 0.0}
        for name, usual in usuals.items():
            given = getattr(self, name)
            if not isinstance(plain(given), Real) or given != usual:
                return f"`{name}`"
        return next((f"`{name}`" for name in ("even", "adhesion") if getattr(self, name)), "")

    @cached_property
    def loads(self) -> tuple[InterfaceLoad | FrontLoad, ...]:
        """The load, or the loads, as tractions along x times histories, and fronts."""
        given = self.load if isinstance(self.load, tuple) else (self.load,)
        return tuple(load for part in given for load in self._along(part))

    def _along(self, load: Any) -> Iterator[InterfaceLoad | FrontLoad]:
        """Yield a load as loads along x."""
        if isinstance(load, IncidentWave | MovingLoad):
            both = self.shear_history, self.pressure_history
            yield FrontLoad(load, next((history for history in both if history != Step()), Step()))
        elif isinstance(load, Tractions):
            on = "line" if self.load_on == REMOTE else "slot"
            for name in ("shear", "pressure"):
                of = InterfaceLoad(history=getattr(self, f"{name}_history"), on=on)
                of = replace(of, **{name: getattr(load, name)})
                if of.acts(name):
                    yield of
        elif isinstance(load, InterfaceLoad) and load.on is None:
            yield replace(load, on="line")  # there are no slots
        else:
            yield load

    @property
    def impedance(self) -> float:
        """Traction per relative slip rate of plane waves into both bodies [stress time / length].

        It is mu / (2 c_t) between identical bodies.
        """
        upper, lower = self.material.shear_impedance, self.lower_material
        return upper / 2 if lower is None else 1 / (1 / upper + 1 / lower.shear_impedance)

    @property
    def may_open(self) -> bool:
        """Whether a load, or slip of different bodies, changes the pressure: gaps are computed."""
        return self.lower_material is not None or any(load.acts("pressure") for load in self.loads)

    @property
    def jumps(self) -> list[float]:
        """Times after t = 0 at which a load along x jumps, in order."""
        return sorted({at for load in self.loads for at in load.jumps if at > 0})

    def _check_line(self) -> None:
        """Raise SceneError unless everything that is marched along a line is admissible."""
        from semianalytic.scene.line.fields import check_field  # most scenes have no fields

        for what, value in (
            ("base pressure", self.base.pressure),
            ("base shear", self.base.shear),
            ("rate", self.rate),
        ):
            check_field(f"scene: {what}", value)
        self._check_contact()
        if not isinstance(self.even, bool):
            raise SceneError(f"scene: even must be true or false, got {shown(self.even)}.")
        if self.lower_material is not None and (self.mode == "antiplane" or self.even):
            advice = (
                "slip between different bodies is not even in x, because it raises the pressure on "
                "one side and lowers it on the other; set even = false"
                if self.even
                else 'between different bodies mode must be "in-plane"; leave out lower_material '
                "or change the mode"
            )
            raise SceneError(f"scene: {advice}.")
        self._check_loads()
        if not isinstance(self.adhesion, Adhesion | None):
            raise SceneError(f"scene: adhesion must be an Adhesion, got {shown(self.adhesion)}.")
        if self.adhesion is not None and not self.may_open:
            raise SceneError(
                "scene: nothing opens without a load that has a pressure; leave out adhesion."
            )
        if self.mode == "antiplane" and self.may_open:
            raise SceneError(
                "scene: loads on an antiplane line have no pressure; leave it out or set "
                'mode = "in-plane".'
            )

    def _check_contact(self) -> None:
        check_fields(self, "scene", ("plate_rate",))
        for name in ("held", "period"):
            if not isinstance(plain(size := getattr(self, name)), Real) or size != math.inf:
                check_fields(self, "scene", (name,), checked_size)
        reach = self.period / 2
        for begin, end in self.contact.intervals:
            if any(math.isfinite(end) and abs(end) > reach for end in (begin, end)):
                raise SceneError(
                    f"scene: the contact {begin:g} to {end:g} leaves the period, {-reach:g} to "
                    f"{reach:g}; raise `period`, or let an open end be inf."
                )

    def _check_loads(self) -> None:
        if not isinstance(self.load, Tractions | IncidentWave) and (
            self.pressure_history != Step() or self.shear_history != Step()
        ):
            raise SceneError(
                "scene: loads along x have histories of their own; leave out pressure_history and "
                "shear_history."
            )
        for load in self.load if isinstance(self.load, tuple) else (self.load,):
            if not isinstance(
                load, Tractions | InterfaceLoad | FrontLoad | IncidentWave | MovingLoad
            ):
                raise SceneError(
                    "scene: loads of a line must be InterfaceLoads, tractions, incident waves or "
                    f"moving loads, got {shown(load)}; give others as an InterfaceLoad of a "
                    "function of x and t, with history=None."
                )
            slots = not self.contact.is_whole
            if isinstance(load, InterfaceLoad) and load.on is None and slots:
                raise SceneError(
                    'load: say whether it acts on = "line", as it would be without slots, or '
                    'on = "slot", taken off the faces of slots; or give pressure and shear both.'
                )
            acts = isinstance(load, Tractions) and (load.pressure or load.shear)
            if acts and self.load_on != REMOTE and not slots:
                raise SceneError(
                    "scene: the bodies touch everywhere and tractions are taken off the faces of "
                    f'slots; write load_on = "{REMOTE}" for a load from far away.'
                )
        for part in self.loads:
            front = part.front if isinstance(part, FrontLoad) else None
            known = ("SH",) if self.mode == "antiplane" else ("P", "SV")
            if isinstance(front, IncidentWave) and front.kind not in known:
                raise SceneError(
                    f"scene: an incident {self.mode} wave must be of kind "
                    f"{' or '.join(known)}, got {front.kind}."
                )
            if self.even and isinstance(part, FrontLoad) and part.runs:
                raise SceneError(
                    "scene: a front that runs along x is not even in x; set even = false."
                )
