"""Scenes as TOML files to start from, with the unit and meaning of every parameter."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, replace
from decimal import Decimal
from itertools import chain
from textwrap import wrap
from typing import Any, TypeVar

import numpy as np

from semianalytic.scene.errors import SceneError
from semianalytic.scene.given.documents import WHOLE_LINE, history_document, scene_document
from semianalytic.scene.given.parameters import (
    MATERIAL,
    TRACTIONS,
    Parameter,
    load_parameters,
    part_parameters,
)
from semianalytic.scene.incident import (
    IncidentWave,
    Load,
    MovingLoad,
    load_document,
    load_from_document,
)
from semianalytic.scene.laws.coulomb import Coulomb
from semianalytic.scene.laws.kinds import law_table
from semianalytic.scene.laws.law import Law
from semianalytic.scene.laws.weakening import RateWeakening, SlipWeakening
from semianalytic.scene.loading import LineLoad
from semianalytic.scene.loads import Harmonic, LoadHistory, Pulse, Ramp, Step
from semianalytic.scene.scene import Material, Scene, Tractions
from semianalytic.scene.tabulated import Tabulated
from semianalytic.scene.units import SI, unit

Part = TypeVar("Part", LoadHistory, Law)

SI_SOLID, SI_STRESS = (1e9, 1000.0), 1e6
"""Shear modulus [Pa] and density [kg/m^3] that replace 1, near those of polymers, in which a shear
wave takes a millisecond for a metre; and the traction that replaces 1 [Pa]."""

_HISTORIES: tuple[LoadHistory, ...] = (
    Step(),
    Ramp(0.5),
    Pulse(0.4, "triangle"),
    Harmonic(3.0),
    Tabulated((0.0, 0.2, 1.0), (0.0, 1.0, 0.5)),
)
_LAWS: tuple[Law, ...] = (
    Coulomb(1.0, viscosity=0.1),
    RateWeakening(1.0, 0.8, 1.0),
    SlipWeakening(1.0, 0.5, 0.05),
)
"""Examples in units mu = rho = 1, under tractions of 1."""
_WAVE, _MOVING = IncidentWave("SV", angle=-30.0, velocity=0.5), MovingLoad(0.5, 0.0, 1.0)
"""Examples of other loads, in the same units."""
_SAYINGS: Mapping[type, str] = {
    Step: "on at t = 0, and stays",
    Ramp: "rises evenly, then stays",
    Pulse: "comes and goes",
    Harmonic: "sin(2 pi frequency t)",
    Tabulated: 'straight between times; or, for t and value_at_t, file = "pulse.csv"',
    Coulomb: "friction p + viscosity |V|",
    RateWeakening: "p (dynamic + (friction - dynamic) rate / (|V| + rate))",
    SlipWeakening: "friction falls to dynamic with slip, evenly or by a shape",
}


def in_si_units(scene: Scene, solid: Material | None = None) -> Scene:
    """Return a scene of unit modulus and density in SI units, by `SI_SOLID` and `SI_STRESS`.

    The contact slips at the same x / (c_t t), as far as the Poisson ratio is the same; a length of
    1 becomes a metre.

    A solid in SI units may take the place of `SI_SOLID` and the Poisson ratio of the scene.  Raises
    SceneError if the scene is in other units, or a parameter has a dimension that is not known.
    """
    material = scene.material
    if scene.units == SI:
        return scene if solid is None else replace(scene, **_bodies(scene, solid))
    if (material.shear_modulus, material.density) != (1.0, 1.0):
        raise SceneError(
            "only scenes of unit shear modulus and density can be converted to SI units; take "
            "another scene, or leave the units out."
        )
    # numbers to begin with need no more digits than a reader does
    digits = 15 if solid is None else 3
    solid = Material(*SI_SOLID, material.poisson_ratio) if solid is None else solid
    scales = _scales(solid, SI_STRESS)
    base, load = (_load_in(scales, tractions) for tractions in (scene.base, scene.load))
    assert isinstance(base, Tractions)
    return Scene(
        **_bodies(scene, solid),
        friction=_scaled(scene.law, scales, digits),
        base=base,
        load=load,
        pressure_history=_scaled(scene.pressure_history, scales, digits),
        shear_history=_scaled(scene.shear_history, scales, digits),
        mode=scene.mode,
        load_on=scene.load_on,
        units=SI,
    )


def _bodies(scene: Scene, upper: Material) -> dict[str, Any]:
    """Return bodies with another upper one, from which the lower one differs as it did before."""
    former, lower = scene.bodies
    body = Material(
        upper.shear_modulus * (lower.shear_modulus / former.shear_modulus),
        upper.density * (lower.density / former.density),
        upper.poisson_ratio if lower == former else lower.poisson_ratio,
    )
    return {"material": upper, "lower_material": body}


def _load_in(scales: Mapping[str, float], load: Load) -> Load:
    """Convert a load from units mu = rho = 1 to those of the scales."""
    document = load_document(load)
    # particle velocities are in the unit of slip rate, the speed of a front in that of waves
    units = {**scales, "length / time": scales["1 / time"]} if "speed" in document else scales
    for name, (dimension, _) in load_parameters(load).items():
        if dimension in units and document.get(name) is not None:
            document[name] = float(f"{units[dimension] * document[name]:.12g}")
    return load_from_document(document)


def scene_text(scene: Scene, origin: str = "", remark: str = "", *, with_all: bool = False) -> str:
    """Write a scene as a TOML file in which every number has its unit and meaning as a comment.

    `find` reads the same scene from the file.  Its origin stands in the first line, the remark is a
    sentence about the material; `with_all` lets comments show the other loads, histories and laws,
    and a lower body.
    """
    lines = _lines(scene, origin, remark, with_all=with_all)
    if not with_all:
        lines = chain(
            lines, ["", "# Other loads, histories and friction laws: slipfront init --all"]
        )
    return "\n".join(lines) + "\n"


def _lines(scene: Scene, origin: str, remark: str, *, with_all: bool) -> Iterator[str]:
    document, lower = scene_document(scene), scene.lower_material
    yield f"# A scene of slipfront{origin and f', made from {origin}'}: slipfront solve FILE."
    slot = "x > 0, an open slot on x < 0" if scene.has_slot else "all x, without a slot"
    yield f"# Contact on y = 0, {slot}; the load comes at t = 0."
    yield ""
    yield '# "SI": m, s, kg and Pa. Left out: any consistent set of units.'
    yield ("" if scene.units else "# ") + f'units = "{SI}"'
    if not scene.has_slot:
        yield f'contact = "{WHOLE_LINE}"'
    yield f'mode = "{scene.mode}"  # in-plane: shear and slip along x; antiplane: along z, the edge'
    if isinstance(scene.load, Tractions):
        said = "slot: taken off its faces; remote: arrives from far away"
        yield f'load_on = "{scene.load_on}"  # {said}'
    if "friction" in document:
        yield f"friction = {_value(document['friction'])}  # friction coefficient f, 0 or more"
    said_of_load = "what comes at t = 0, where load_on says"
    if not isinstance(scene.load, Tractions):
        said_of_load = "its front reaches the tip of the slot at t = 0"
    if isinstance(scene.load, LineLoad):
        said_of_load = "what comes from t = 0 on"
    for table, said, parameters in (
        ("material", "of both bodies" if lower is None else "of the upper body", MATERIAL),
        ("base", "in place before the load, on the whole line y = 0", TRACTIONS),
        ("load", said_of_load, load_parameters(scene.load)),
    ):
        yield f"\n[{table}]  # {said}"
        if table == "material" and remark:
            yield from (f"# {line}" for line in wrap(remark, 96))
        yield from _values(document[table], parameters, scene.units)
    for example in (_WAVE, _MOVING) if with_all and scene.has_slot else ():
        if type(example) is not type(scene.load):
            other = _load_in(_scales(scene.material, _largest(scene)), example)
            for line in _values(load_document(other), load_parameters(other), scene.units):
                yield f"# {line}"
    for kind in ("pressure", "shear"):
        if with_all or f"{kind}_history" in document:
            yield f"\n[{kind}_history]  # how the {kind} of the load comes, over time"
            own = getattr(scene, f"{kind}_history")
            others = [
                history for history in _HISTORIES if with_all and type(history) is not type(own)
            ]
            yield from _part(scene, own, others)
    if with_all or "friction_law" in document:
        yield "\n[friction_law]  # strength of what slips at V under the pressure p"
        laws = [law for law in _LAWS if with_all and type(law) is not type(scene.friction)]
        yield from _part(
            scene, scene.law, [law.with_coefficient(scene.coefficient) for law in laws]
        )
    if lower is not None:
        yield "\n[lower_material]  # of the lower body"
        yield from _values(asdict(lower), MATERIAL, scene.units)
    elif with_all:
        yield "\n# [lower_material]  # where it is another solid: for solve, compare and others"
        for line in _values(document["material"], MATERIAL, scene.units):
            yield f"# {line}"


def _part(scene: Scene, own: Any, examples: Sequence[Any]) -> Iterator[str]:
    """Return the lines of the scene's history or law, and of the others as comments."""
    yield from _kind(own, scene.units)
    scales = _scales(scene.material, _largest(scene))
    for example in examples:
        for line in _kind(_scaled(example, scales, digits=3), scene.units):
            yield f"# {line}"


def _kind(part: LoadHistory | Law, units: str) -> Iterator[str]:
    saying = Parameter("", _SAYINGS.get(type(part), ""))
    document = law_table(part) if isinstance(part, Law) else history_document(part)
    yield from _values(document, {"kind": saying, **part_parameters(type(part))}, units)


def _values(
    values: Mapping[str, Any], parameters: Mapping[str, Parameter], units: str
) -> Iterator[str]:
    """Return the lines of a table, each value followed by its meaning and unit."""
    for name, value in values.items():
        dimension, meaning = parameters[name]
        measure = "" if dimension in ("", "1") else f"[{unit(dimension, units)}]"
        note = " ".join(filter(None, (meaning, measure)))
        yield f"{name} = {_value(value)}" + (f"  # {note}" if note else "")


def _value(value: Any) -> str:
    """Write a value in TOML, large and small numbers as short as possible."""
    if isinstance(value, tuple):
        return f"[{', '.join(map(_value, value))}]"
    if isinstance(value, str):
        return f'"{value}"'
    if not isinstance(value, float):
        return str(value).lower()
    if 1e-3 <= abs(value) < 1e5:
        return repr(value)
    mantissa, _, exponent = f"{Decimal(repr(value)).normalize():e}".partition("e")
    short = f"{mantissa}e{int(exponent)}"
    return min(repr(value), short, key=len)


def _largest(scene: Scene) -> float:
    """Return the largest traction of a scene [stress], 1 if there is none."""
    tractions = (scene.superposition.taken_off, scene.base)
    return max(max(abs(traction.pressure), abs(traction.shear)) for traction in tractions) or 1.0


def _scales(material: Material, stress: float) -> dict[str, float]:
    """Return the unit of each dimension in a solid under a traction; lengths are those of slip."""
    speed, impedance = material.shear_speed, material.shear_impedance
    return {
        "1": 1.0,
        "time": 1 / speed,
        "1 / time": speed,
        "length": stress / material.shear_modulus,
        "length / time": stress / impedance,
        "stress time / length": impedance,
        "stress": stress,
        # of forces at a point and loads that grow, along which a length of 1 becomes a metre
        **dict.fromkeys(("stress / time", "stress length / time"), stress * speed),
        "stress / time^2": stress * speed**2,
    }


def _scaled(part: Part, scales: Mapping[str, float], digits: int = 15) -> Part:
    """Convert a history or law from units mu = rho = 1 to those of the scales, rounded."""
    values: dict[str, Any] = {}
    for name, (dimension, _) in part_parameters(type(part)).items():
        if dimension and dimension not in scales:
            raise SceneError(f"{name} is in {dimension}, which cannot be converted to other units.")
        if dimension:
            value = np.multiply(scales[dimension], getattr(part, name))
            rounded = np.array([float(f"{number:.{digits}g}") for number in value.ravel()])
            values[name] = rounded.reshape(value.shape).tolist()
    return replace(part, **values)  # type: ignore[type-var]
