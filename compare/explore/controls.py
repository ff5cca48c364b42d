"""The controls of the page: a scene as flat values, their ranges, and the query of an address."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any
from urllib.parse import parse_qsl, urlencode

from compare.comparison.scales import slip_rate_scale, stress_scale
from semianalytic import Scene
from semianalytic.scene.checks import shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.loading import LOADED, SLOT
from semianalytic.scene.loads import PULSE_SHAPES
from semianalytic.scene.scene import (
    IN_PLANE,
    MODES,
    part_document,
    scene_document,
    scene_from_document,
)
from semianalytic.scene.units import unit

Values = dict[str, Any]
"""Numbers and words of a scene, by the name of the control that sets them."""

LAWS: Mapping[str, tuple[str, ...]] = {
    "coulomb": (),
    "viscous": ("viscosity",),
    "rate-weakening": ("reduction", "rate"),
    "slip-weakening": ("reduction", "distance"),
}
HISTORIES: Mapping[str, tuple[str, ...]] = {
    "step": (),
    "ramp": ("rise_time",),
    "pulse": ("duration", "shape"),
    "harmonic": ("frequency",),
}
"""What can be chosen, and the controls that are shown then."""

CHOICES: Mapping[str, tuple[str, ...]] = {
    "mode": MODES,
    "load_on": LOADED,
    "law": tuple(LAWS),
    "history": tuple(HISTORIES),
    "shape": tuple(PULSE_SHAPES),
}
FIXED = ("shear_modulus", "density", "units")
"""What the scene the page was opened with decides; only in the address."""


@dataclass(frozen=True)
class Slider:
    """A number and the range it moves in [unit of the scene]."""

    name: str
    label: str
    unit: str
    low: float
    high: float
    step: float


def sliders(scene: Scene) -> tuple[Slider, ...]:
    """The sliders for scenes like one, in its units: tractions to twice its own, rates and lengths
    by what its waves do in the time they take over a length of 1.

    Raises
    ------
    SceneError
        If a range cannot be divided, as where an impedance underflows; or as `values_of`.
    """
    stress, rate = 2 * stress_scale(scene), slip_rate_scale(scene)
    time, impedance = 1 / scene.material.shear_speed, scene.material.shear_impedance
    given = (
        ("poisson_ratio", "Poisson ratio ν", "1", -0.95, 0.49),
        ("friction", "friction f", "1", 0.0, max(2.0, 2 * scene.friction)),
        ("base_pressure", "base pressure", "stress", 0.0, stress),
        ("base_shear", "base shear", "stress", -stress, stress),
        ("load_pressure", "load pressure", "stress", -stress, stress),
        ("load_shear", "load shear", "stress", -stress, stress),
        ("viscosity", "viscosity", "stress time / length", 0.0, 2 * impedance),
        ("reduction", "reduction", "1", 0.0, 1.0),
        ("rate", "rate", "length / time", rate / 10, 2 * rate),
        ("distance", "distance", "length", rate * time / 50, rate * time),
        ("rise_time", "rise time", "time", 0.0, 2 * time),
        ("duration", "duration", "time", time / 20, 2 * time),
        ("frequency", "frequency", "1 / time", 0.25 / time, 8 / time),
    )
    values = values_of(scene)
    result = []
    for name, label, dimension, low, high in given:
        own = values.get(name, low)
        low, high = min(low, own), max(high, own)
        if not (math.isfinite(high - low) and (high - low) / 200 > 0):
            raise SceneError(
                f"explore cannot draw a slider for {label} from {low:g} to {high:g}; choose units "
                "in which its numbers are neither so large nor so small."
            )
        named = "" if dimension == "1" else unit(dimension, scene.units)
        result.append(Slider(name, label, named, low, high, _step(high - low)))
    return tuple(result)


def serve_for(sliders_of: Scene, values: Mapping[str, Any]) -> bool:
    """Whether the sliders of a scene serve for that of other values too: in the same units, of
    bodies with the same waves, and none that it calls for out of range."""
    own, called_for = values_of(sliders_of), values_of(scene_of(values))
    return all(values[name] == own[name] for name in FIXED) and all(
        one.low <= called_for.get(one.name, one.low) <= one.high for one in sliders(sliders_of)
    )


def _step(width: float) -> float:
    """Of a slider: the power of ten that gives at least 200 places."""
    return float(10.0 ** math.floor(math.log10(width / 200)))


def defaults(scene: Scene) -> Values:
    """Values of all controls: the scene's own, and a middle of the range of the others."""
    rest = {one.name: _rounded((one.low + one.high) / 4, one.step) for one in sliders(scene)}
    words = {name: words[0] for name, words in CHOICES.items()}
    return rest | words | values_of(scene)


def _rounded(value: float, step: float) -> float:
    return float(f"{round(value / step) * step:.12g}")


def values_of(scene: Scene) -> Values:
    """A scene as values of controls.

    Raises
    ------
    SceneError
        If pressure and shear come with different histories, or a law or history has no control.
    """
    document = scene_document(scene)
    words = {"mode": scene.mode, "load_on": scene.load_on}
    values: Values = {**document["material"], "friction": scene.friction, **words}
    values |= {
        f"{part}_{kind}": document[part][kind]
        for part in ("base", "load")
        for kind in ("pressure", "shear")
    }
    histories = list(scene.acting_histories.values())
    if any(history != histories[0] for history in histories[1:]):
        raise SceneError(
            "explore has one history for pressure and shear of the load; give both the same."
        )
    history = part_document(histories[0]) if histories else {"kind": "step"}
    law = part_document(scene.friction_law)
    for name, part, known in (("law", law, LAWS), ("history", history, HISTORIES)):
        if part["kind"] not in known:
            raise SceneError(
                f"explore has no controls for the {name} {part['kind']}; "
                f"choose among {', '.join(known)}."
            )
        values[name] = part.pop("kind")
        values |= part
    return values | {"units": scene.units}


def scene_of(values: Mapping[str, Any]) -> Scene:
    """The scene that values of controls describe; values that it does not call for are ignored.

    Raises
    ------
    SceneError
        If a value is missing, no number, or out of range, or there is no such scene.
    """
    numbers = {name: _number(values, name) for name in _NUMBERS}
    document: dict[str, Any] = {
        "friction": numbers["friction"],
        "material": {name: numbers[name] for name in ("shear_modulus", "density", "poisson_ratio")},
        "base": {kind: numbers[f"base_{kind}"] for kind in ("pressure", "shear")},
        "load": {kind: numbers[f"load_{kind}"] for kind in ("pressure", "shear")},
        "mode": values.get("mode", IN_PLANE),
        "load_on": values.get("load_on", SLOT),
        "units": values.get("units", ""),
        "friction_law": _part(values, "law", LAWS),
    }
    history = _part(values, "history", HISTORIES)
    for kind, size in document["load"].items():
        if size:
            document[f"{kind}_history"] = history
    return scene_from_document(document)


_NUMBERS = (
    "shear_modulus",
    "density",
    "poisson_ratio",
    "friction",
    "base_pressure",
    "base_shear",
    "load_pressure",
    "load_shear",
)


def _part(values: Mapping[str, Any], name: str, known: Mapping[str, tuple[str, ...]]) -> Values:
    """A law or history as `scene_from_document` takes it."""
    kind = values.get(name, next(iter(known)))
    if kind not in known:
        raise SceneError(f"{name} must be one of {', '.join(known)}, got {shown(kind)}.")
    return {"kind": kind} | {
        one: values.get(one) if one in CHOICES else _number(values, one) for one in known[kind]
    }


def _number(values: Mapping[str, Any], name: str) -> float:
    try:
        number = float(values[name])
    except KeyError:
        raise SceneError(f"{name} is missing; give it a number.") from None
    except (TypeError, ValueError, OverflowError):
        number = math.nan
    if not math.isfinite(number):
        raise SceneError(f"{name} must be a number, got {shown(values[name])}.")
    return number


def query_of(values: Mapping[str, Any]) -> str:
    """The query of an address, ``?friction=0.3&...``, that holds all that its scene calls for."""
    names = [*_NUMBERS, "mode", "load_on", "units", "law", *LAWS[values["law"]], "history"]
    names += HISTORIES[values["history"]]
    return "?" + urlencode({name: values[name] for name in names})


def values_from_query(query: str, start: Scene) -> Values:
    """Values of all controls that an address gives.

    What it leaves out is that of a scene; what the two do not call for is in the middle of its
    range.

    Raises
    ------
    SceneError
        If a name is unknown or a value no such number or word, or there is no such scene.
    """
    base = defaults(start)
    texts = dict(parse_qsl(query.removeprefix("?"), keep_blank_values=True))
    given: Values = {}
    for name, text in texts.items():
        if name not in base and name not in FIXED:
            raise SceneError(f"the address names {shown(name)}, which no scene has; take it out.")
        word = name in CHOICES or name == "units"
        given[name] = text if word else _number(texts, name)
        if name in CHOICES and text not in CHOICES[name]:
            known = ", ".join(CHOICES[name])
            raise SceneError(f"{name} must be one of {known}, got {shown(text)}.")
    return defaults(scene_of(base | given)) | given
