"""Loads whose front moves along the interface: plane waves that arrive at an angle, moving loads.

Each of them changes the tractions of an uncut, unslipped interface by S H(t - p x), with the
slowness p of its front along x.  It reaches the tip of the slot, x = 0, at t = 0.  p < 0 is a front
that comes over the contact and runs on over the slot, p > 0 one that comes along the slot.
docs/theory.md, "Loads whose front moves", states the tractions of the waves.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

from semianalytic.scene.arguments import checking_methods
from semianalytic.scene.checks import (
    LARGEST,
    among,
    check_fields,
    checked_kind,
    checked_number,
    checked_word,
    made,
)
from semianalytic.scene.errors import SceneError
from semianalytic.scene.loading import GrowingLoad, HalfLine, LineLoad, Patch, PointForce, Tractions
from semianalytic.scene.material import Material
from semianalytic.scene.quantities import with_quantities

WAVES = ("P", "SV", "SH")
SIDES = ("below", "above")
GRAZING = 89.9
"""Largest angle [degrees]: half or twice what is left of 90 changes no digit of estimates."""


@checking_methods
@with_quantities
@dataclass(frozen=True)
class IncidentWave:
    """A plane step wave that arrives from one body; its front reaches the slot's tip at t = 0.

    Parameters
    ----------
    kind : str
        "P", or "SV" in plane strain, or "SH" in antiplane shear.
    angle : float
        Angle between the direction of the wave and the normal of the interface [degrees], positive
        if the wave runs towards +x: along the slot, then over the contact.  Negative: it meets the
        contact first.
    velocity : float, optional
        Step v_0 of particle velocity [length / time], along the direction of a P wave, along
        (cos angle, -sin angle) from below and (cos angle, sin angle) from above in an SV wave, and
        along z in an SH wave.
    stress : float, optional
        rho c v_0 instead [stress], with the speed c of the wave: the pressure of a P wave's front
        and the shear stress of an S wave's.  Give one of the two.
    from_ : str
        "below" or "above": the body from which it arrives.

    Raises
    ------
    SceneError
        If the kind or side is unknown, the angle is beyond 89.9 degrees either way, or not exactly
        one of velocity and stress is given, as a finite number.

    Examples
    --------
    >>> from semianalytic import IncidentWave, Material
    >>> wave = IncidentWave("SV", angle=-30.0, velocity=0.5)
    >>> solid = Material(shear_modulus=1.0, density=1.0, poisson_ratio=1 / 3)
    >>> round(wave.slowness(solid), 12)
    -0.5
    >>> wave.tractions(solid)  # -rho c_t v_0 cos 2 angle in shear, -v_0 sin 2 angle in pressure
    Tractions(pressure=0.4330127018922193, shear=-0.2500000000000001)
    """

    kind: str
    angle: float
    velocity: float | None = None
    stress: float | None = None
    from_: str = "below"

    def __post_init__(self) -> None:
        checked_word("incident wave: kind", self.kind, WAVES)
        required = f"lie between -{GRAZING} and {GRAZING} degrees from the normal of the interface"
        within = (checked_number, required, lambda given: abs(given) <= GRAZING)
        check_fields(self, "incident wave", ("angle",), *within)
        checked_word("incident wave: from", self.from_, SIDES)
        if (self.velocity is None) == (self.stress is None):
            raise SceneError("incident wave: give either its velocity or its stress.")
        name = "stress" if self.velocity is None else "velocity"
        check_fields(self, "incident wave", (name,))

    def speed(self, material: Material) -> float:
        """Return the speed of the wave in a solid [length / time]."""
        return material.longitudinal_speed if self.kind == "P" else material.shear_speed

    def slowness(self, material: Material) -> float:
        """Return the slowness p of its front along the interface [time / length], sin(angle)/c."""
        return math.sin(math.radians(self.angle)) / self.speed(material)

    def particle_velocity(self, material: Material) -> float:
        """Return the step v_0 of particle velocity in a solid [length / time]."""
        if self.velocity is not None:
            return self.velocity
        assert self.stress is not None
        return self.stress / (material.density * self.speed(material))

    def direction(self) -> tuple[float, float]:
        """Return the unit vector (n_x, n_y) along which the wave runs."""
        angle = math.radians(self.angle)
        # The interface is y = 0: a wave from below runs towards +y, one from above towards -y.
        return math.sin(angle), math.cos(angle) * (1 if self.from_ == "below" else -1)

    def polarisation(self) -> tuple[float, float, float]:
        """Return the unit vector (d_x, d_y, d_z) of its particle velocity."""
        n_x, n_y = self.direction()
        if self.kind == "P":
            return n_x, n_y, 0.0
        if self.kind == "SH":
            return 0.0, 0.0, 1.0
        # The direction turned by 90 degrees, with d_x > 0: the sense of motion along the interface
        # does not change with the side from which the wave comes.
        return abs(n_y), -math.copysign(n_x, n_x * n_y), 0.0

    def stresses(self, material: Material) -> dict[str, float]:
        """Return the stress step behind its front, by component: xx, yy, xy, xz and yz [stress].

        It is tension positive, -lambda (d.n) I - mu (d n + n d) times v_0 / c for the direction n
        and the unit vector d of motion.
        """
        (n_x, n_y), (d_x, d_y, d_z) = self.direction(), self.polarisation()
        mu, ratio = material.shear_modulus, self.particle_velocity(material) / self.speed(material)
        # Lame's lambda = rho c_l^2 - 2 mu.
        modulus = material.density * material.longitudinal_speed**2 - 2 * mu
        # d.n is 1 in a P wave and 0 in an S wave, which changes no volume.
        spread = modulus * (d_x * n_x + d_y * n_y) if self.kind == "P" else 0.0
        return {
            "xx": -ratio * (spread + 2 * mu * d_x * n_x),
            "yy": -ratio * (spread + 2 * mu * d_y * n_y),
            "xy": -ratio * mu * (d_x * n_y + d_y * n_x),
            "xz": -ratio * mu * d_z * n_x,
            "yz": -ratio * mu * d_z * n_y,
        }

    def tractions(self, material: Material) -> Tractions:
        """Return the step of tractions on y = 0 of the uncut body: -sigma_yy, and the shear."""
        sigma = self.stresses(material)
        # Pressure is positive in compression; the sum with 0.0 turns -0.0 into 0.0.
        return Tractions(-sigma["yy"] + 0.0, sigma["yz" if self.kind == "SH" else "xy"])

    def derivatives(self, material: Material, by: str) -> tuple[Tractions, float]:
        """Return the derivatives of `tractions` and `slowness` with respect to one parameter.

        Parameters
        ----------
        material : Material
        by : str
            "angle", per degree, "poisson_ratio" at constant shear modulus and density, or another
            name for the amplitude that was given.
        """
        now, slowness = self.tractions(material), self.slowness(material)
        if not among(by, ("angle", "poisson_ratio")):
            of_stress = self.velocity is None
            # Tractions are linear in the amplitude, and the front does not depend on it.
            unit = replace(self, stress=1.0) if of_stress else replace(self, velocity=1.0)
            return unit.tractions(material), 0.0
        angle = math.radians(self.angle)
        sign, both = (1 if self.from_ == "below" else -1), 2 * angle
        stress = material.density * self.speed(material) * self.particle_velocity(material)
        # A P wave of stress S exerts the pressure S (1 - 2 r sin^2) and the shear -+ S r sin 2
        # angle with r = (c_t / c_l)^2; SV waves exert -S sin 2 angle and -+ S cos 2 angle.
        ratio2 = (material.shear_speed / material.longitudinal_speed) ** 2
        if by == "poisson_ratio":
            if self.kind != "P":
                return Tractions(0.0, 0.0), 0.0
            # of (c_t / c_l)^2 = (1 - 2 nu) / (2 (1 - nu)), over itself; p is as its root
            share = -1 / (2 * (1 - material.poisson_ratio) ** 2) / ratio2
            change = -share * ratio2 * stress
            slope = Tractions(change * 2 * math.sin(angle) ** 2, sign * change * math.sin(both))
            if self.velocity is not None:  # rho c_l v_0 changes too
                slope = slope.plus(_scaled(now, -share / 2))
            return slope, slowness * share / 2
        if self.kind == "SH":
            # An SH wave exerts -+ S cos(angle) along z, and no pressure.
            slope = Tractions(0.0, sign * stress * math.sin(angle))
        elif self.kind == "SV":
            slope = Tractions(-2 * stress * math.cos(both), 2 * sign * stress * math.sin(both))
        else:
            slope = Tractions(
                -2 * stress * ratio2 * math.sin(both), -2 * sign * stress * ratio2 * math.cos(both)
            )
        per_degree = math.radians(1.0)
        # p = sin(angle) / c.
        return _scaled(slope, per_degree), math.cos(angle) / self.speed(material) * per_degree


def _scaled(tractions: Tractions, factor: float) -> Tractions:
    return Tractions(factor * tractions.pressure, factor * tractions.shear)


@checking_methods
@with_quantities
@dataclass(frozen=True)
class MovingLoad:
    """Tractions that advance over the slot faces from its tip at constant speed, from t = 0 on.

    Parameters
    ----------
    speed : float
        Speed w > 0 [length / time] at which their front runs away from the tip: at t the part
        -w t < x < 0 of the slot is loaded, by the traction change (-pressure, -shear).  Negative:
        the front comes along the slot at speed |w| and reaches the tip at t = 0; behind it the slot
        is loaded.
    pressure : float
        Pressure taken off the slot faces [stress]; a negative one presses on them and opens the
        contact.
    shear : float
        Shear traction taken off the slot faces [stress].

    Raises
    ------
    SceneError
        If the speed is zero or a parameter is not a finite number.

    Examples
    --------
    >>> from semianalytic import Material, MovingLoad
    >>> load = MovingLoad(speed=0.5, pressure=0.0, shear=1.0)
    >>> load.slowness(Material(shear_modulus=1.0, density=1.0, poisson_ratio=0.25))
    -2.0
    """

    speed: float
    pressure: float
    shear: float

    def __post_init__(self) -> None:
        required = "be a finite number other than 0 (Tractions load the slot at once)"
        apart = (checked_number, required, lambda given: abs(given) >= 1 / LARGEST)
        check_fields(self, "moving load", ("speed",), *apart)
        check_fields(self, "moving load", ("pressure", "shear"))

    def slowness(self, material: Material) -> float:
        """Return the slowness p of its front along x [time / length], -1 / speed, in any solid."""
        return -1 / self.speed

    def tractions(self, material: Material) -> Tractions:
        """Return the tractions that it takes off the slot faces behind its front, in any solid."""
        return Tractions(self.pressure, self.shear)


Load = Tractions | IncidentWave | MovingLoad | LineLoad
OF_FRONT = ("angle", "wave_velocity", "wave_stress", "load_speed")
"""Numbers of incident waves and moving loads, as `override_scene` and derivatives name them."""
LOAD_KINDS: dict[str, type[IncidentWave | MovingLoad | LineLoad]] = {
    "incident-wave": IncidentWave,
    "moving": MovingLoad,
    "patch": Patch,
    "point-force": PointForce,
    "half-line": HalfLine,
    "growing": GrowingLoad,
}
"""Kinds of loads in files, besides tractions, which need no kind."""
_IN_FILES = {"kind": "wave", "from_": "from"}
"""Keys of files for the fields that cannot be called the same there."""


def load_document(load: Load) -> dict[str, Any]:
    """Return a load as a dictionary for TOML or JSON, without fields that were left out."""
    values = {field.name: getattr(load, field.name) for field in fields(load)}  # type: ignore[arg-type]
    if isinstance(load, Tractions):
        return values
    # Tractions need no kind: files without one were written before there were others.
    kind = next(name for name, known in LOAD_KINDS.items() if isinstance(load, known))
    given = {_IN_FILES.get(name, name): value for name, value in values.items()}
    return {"kind": kind, **{name: value for name, value in given.items() if value is not None}}


def load_from_document(table: Any) -> Load:
    """Make the load that a dictionary of `load_document`, or the table [load] of a file, describes.

    Errors are those of `checked_kind` and `made`.
    """
    if "kind" not in table:
        return Tractions(**table)
    kind = checked_kind("load", table["kind"], LOAD_KINDS, "leave it out for tractions; ")
    return made("load", LOAD_KINDS[kind], table, _IN_FILES)


def overridden_load(
    load: Load,
    of_tractions: Mapping[str, float | None],
    of_wave: Mapping[str, float | str | None],
) -> Load:
    """Return a load with parameters replaced that are not None, of another kind if they say so.

    A speed makes tractions move, and the fields of an `IncidentWave` replace any other load.
    Raises SceneError if tractions are given for a wave, or not enough for a new one, or a value is
    out of range.
    """
    waved: dict[str, Any] = {name: value for name, value in of_wave.items() if value is not None}
    given: dict[str, Any] = {name: part for name, part in of_tractions.items() if part is not None}
    if isinstance(load, tuple) and (waved or given):
        raise SceneError(
            "load: the scene has several loads; change one of them in its file, or vary it as "
            "load_1_shear in a survey."
        )
    if waved and given:
        raise SceneError(
            "load: give either a wave or the tractions and speed of a load, got "
            f"{', '.join([*waved, *given])}."
        )
    if waved:
        if isinstance(load, IncidentWave):
            if "velocity" in waved or "stress" in waved:
                # A new amplitude of either name replaces the one that is there: a wave has one of
                # the two.
                waved = {"velocity": None, "stress": None} | waved
            return replace(load, **waved)
        missing = {"kind", "angle"} - waved.keys()
        if missing or not waved.keys() & {"velocity", "stress"}:
            raise SceneError(
                "load: an incident wave needs its kind, its angle, and a velocity or a stress; the "
                "scene has no such load."
            )
        return IncidentWave(**waved)
    if given and isinstance(load, IncidentWave):
        raise SceneError(
            "load: the scene's load is an incident wave; its angle, velocity or stress may be "
            f"replaced, not its {', '.join(given)}."
        )
    if "speed" in given and isinstance(load, Tractions):
        # A speed makes the tractions of the scene move, and those given besides replace them.
        return MovingLoad(**{"pressure": load.pressure, "shear": load.shear} | given)
    for name in given:
        if name not in {field.name for field in fields(load)}:  # type: ignore[arg-type]
            raise SceneError(f"load: this load has no {name}; leave it out.")
    return replace(load, **given) if given else load  # type: ignore[type-var]
