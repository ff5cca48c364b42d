"""Dimension and meaning of each parameter of a scene, for files, units and help texts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import Field, fields
from typing import Any, NamedTuple

from semianalytic.scene.incident import IncidentWave, MovingLoad
from semianalytic.scene.laws.law import Law
from semianalytic.scene.line.loads import FrontLoad
from semianalytic.scene.loading import GrowingLoad, HalfLine, LineLoad, Patch, PointForce
from semianalytic.scene.loads import LoadHistory
from semianalytic.scene.units import PARAMETERS


class Parameter(NamedTuple):
    """A parameter: its dimension as in `semianalytic.scene.units` ("" for words), and meaning."""

    dimension: str
    meaning: str


MATERIAL: Mapping[str, Parameter] = {
    "shear_modulus": Parameter(PARAMETERS["shear_modulus"], "shear modulus, positive"),
    "density": Parameter(PARAMETERS["density"], "mass density, positive"),
    "poisson_ratio": Parameter(PARAMETERS["poisson_ratio"], "Poisson ratio, between -1 and 0.5"),
}
TRACTIONS: Mapping[str, Parameter] = {
    "pressure": Parameter(PARAMETERS["pressure"], "pressure, positive in compression"),
    "shear": Parameter(PARAMETERS["shear"], "shear traction, either sign"),
}
_WAVE: Mapping[str, Parameter] = {
    "kind": Parameter("", "a plane step wave; its front reaches the slot's tip at t = 0"),
    "wave": Parameter("", "P or SV; SH in antiplane shear"),
    "angle": Parameter("degrees", "from the normal; negative: it meets the contact first"),
    "velocity": Parameter("length / time", "step of particle velocity"),
    "stress": Parameter("stress", "rho c times that step, in its place"),
    "from": Parameter("", "below or above: the body it arrives from"),
}
_MOVING: Mapping[str, Parameter] = {
    "kind": Parameter("", "tractions that advance over the slot from its tip"),
    "speed": Parameter("length / time", "speed of their front; negative: towards the tip"),
    **TRACTIONS,
}
_FORCE: Mapping[str, Parameter] = {
    "kind": Parameter("", "a force at x = 0 that grows linearly in time; there is no slot"),
    "pressure": Parameter("stress length / time", "its rate across the interface"),
    "shear": Parameter("stress length / time", "its rate along the interface, either sign"),
}
_ON_LINE: Mapping[type, Mapping[str, Parameter]] = {
    Patch: {
        "kind": Parameter("", "on |x| < speed t from t = 0 on; there is no slot"),
        "speed": Parameter("length / time", "speed of either end of the patch, positive"),
        **TRACTIONS,
    },
    PointForce: _FORCE,
    HalfLine: {"kind": Parameter("", "on all of x < 0 from t = 0 on; no slot"), **TRACTIONS},
}
_OF_PARTS: Mapping[str, Parameter] = {
    "rise_time": Parameter(PARAMETERS["rise_time"], "in which it rises evenly from 0 to 1"),
    "duration": Parameter(PARAMETERS["duration"], "after which it is over"),
    "shape": Parameter("", "rectangle, triangle, half-sine or haversine"),
    "frequency": Parameter(PARAMETERS["frequency"], "cycles per time"),
    "t": Parameter(PARAMETERS["t"], "increasing; a time given twice is a jump"),
    "value_at_t": Parameter(PARAMETERS["value_at_t"], "values there, straight lines between"),
    "friction": Parameter(PARAMETERS["friction"], "friction coefficient"),
    "static": Parameter(PARAMETERS["static"], "friction before any slip"),
    "dynamic": Parameter(PARAMETERS["dynamic"], "friction that is left, at most the static one"),
    "viscosity": Parameter(PARAMETERS["viscosity"], "strength over relative slip rate, 0 or more"),
    "cohesion": Parameter(PARAMETERS["cohesion"], "strength without pressure, 0 or more"),
    "rate": Parameter(PARAMETERS["rate"], "relative slip rate at which half is lost"),
    "distance": Parameter(PARAMETERS["distance"], "accumulated slip over which it is lost"),
}


def load_parameters(load: Any) -> Mapping[str, Parameter]:
    """Return the parameters of a load by the keys of its document."""
    if isinstance(load, tuple):  # that of the first one
        return load_parameters(load[0]) if load else {}
    if isinstance(load, FrontLoad):
        return load_parameters(load.front)
    if isinstance(load, IncidentWave):
        return _WAVE
    if isinstance(load, GrowingLoad):
        rate = f"stress / time{f'^{load.power}' if load.power > 1 else ''}"
        growth = {name: Parameter(rate, traction.meaning) for name, traction in TRACTIONS.items()}
        kind = Parameter("", "pressure everywhere and shear of the slot grow as t^power")
        return {"kind": kind, **growth, "power": Parameter("", "1 or 2")}
    if isinstance(load, LineLoad):
        return _ON_LINE[type(load)]
    return _MOVING if isinstance(load, MovingLoad) else TRACTIONS


def part_parameters(kind: type[LoadHistory] | type[Law]) -> dict[str, Parameter]:
    """Return the parameters of a class of load histories or friction laws, by name.

    A class of another package declares them in the metadata of its fields, as in
    ``field(metadata={"dimension": "length", "meaning": "..."})``; otherwise they are taken as
    dimensionless, "1".
    """
    described: tuple[Field[Any], ...] = fields(kind)  # type: ignore[arg-type]
    return {field.name: _parameter(field) for field in described}


def _parameter(field: Field[Any]) -> Parameter:
    ours = _OF_PARTS.get(field.name, Parameter("1", ""))
    return Parameter(
        str(field.metadata.get("dimension", ours.dimension)),
        str(field.metadata.get("meaning", ours.meaning)),
    )
