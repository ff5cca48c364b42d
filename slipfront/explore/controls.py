"""Controls of the page: a scene as flat values, their ranges, and the query of an address."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any
from urllib.parse import parse_qsl, urlencode

from compare.comparison.scales import slip_rate_scale, stress_scale
from semianalytic import Scene
from semianalytic.dissimilar.pair import check_bodies
from semianalytic.parameters.numbers import numbers_of
from semianalytic.scene.checks import checked_word, shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.given.documents import history_document, scene_from_document
from semianalytic.scene.given.finding import check_slot
from semianalytic.scene.incident import SIDES, WAVES, IncidentWave, MovingLoad
from semianalytic.scene.laws.kinds import law_table
from semianalytic.scene.loading import LOADED, SLOT
from semianalytic.scene.loads import PULSE_SHAPES
from semianalytic.scene.scene import IN_PLANE, MODES
from semianalytic.scene.units import unit

Values = dict[str, Any]
"""Numbers and words of a scene, keyed by the control that sets them."""

ALIKE, ANOTHER, AT_ONCE = "like the upper", "another", "at once"
PARTS: Mapping[str, Mapping[str, tuple[str, ...]]] = {
    "law": {
        "coulomb": ("viscosity",),
        "rate-weakening": ("reduction", "rate"),
        "slip-weakening": ("reduction", "distance"),
    },
    "load": {
        AT_ONCE: ("load_pressure", "load_shear", "load_on"),
        "incident-wave": ("wave", "angle", "wave_stress", "wave_from"),
        "moving": ("load_pressure", "load_shear", "load_speed"),
    },
    "history": {
        "step": (),
        "ramp": ("rise_time",),
        "pulse": ("duration", "shape"),
        "harmonic": ("frequency",),
    },
    "lower_body": {
        ALIKE: (),
        ANOTHER: ("modulus_ratio", "density_ratio", "lower_poisson_ratio"),
    },
}
"""Friction laws, load histories, loads and lower bodies to choose from, and the controls that each
shows; ratios are those of the lower body over the upper one."""
_IN_FILES = {"wave": "wave", "wave_stress": "stress", "wave_from": "from"} | {
    f"load_{name}": name for name in ("pressure", "shear", "speed")
}
"""Keys of a load in files, by its controls."""

CHOICES: Mapping[str, tuple[str, ...]] = {
    "mode": MODES,
    "load_on": LOADED,
    "wave": WAVES,
    "wave_from": SIDES,
    "shape": tuple(PULSE_SHAPES),
    **{name: tuple(kinds) for name, kinds in PARTS.items()},
}
STEEPEST = 85.0
"""Largest angle of the slider [degrees], unless the scene has a larger one."""
FIXED = ("shear_modulus", "density", "units")
"""Values that the scene given at the start fixes; they appear only in the address."""


@dataclass(frozen=True)
class Slider:
    """A number with a slider, and the range of the slider [unit of the scene]."""

    name: str
    label: str
    unit: str
    low: float
    high: float
    step: float


def sliders(scene: Scene) -> tuple[Slider, ...]:
    """Return the sliders for problems like a given one, in its units.

    Tractions range up to twice its own.  Ranges of rates and lengths follow from the motion that
    its waves cause while they cross a length of 1.  A range that cannot be divided into steps, for
    instance because an impedance underflows, is refused by a SceneError.
    """
    stress, rate = 2 * stress_scale(scene), slip_rate_scale(scene)
    time, impedance = 1 / scene.material.shear_speed, scene.material.shear_impedance
    given = (
        ("poisson_ratio", "Poisson ratio ν", "1", -0.95, 0.49),
        ("friction", "friction f", "1", 0.0, max(2.0, 2 * scene.coefficient)),
        ("base_pressure", "base pressure", "stress", 0.0, stress),
        ("base_shear", "base shear", "stress", -stress, stress),
        ("load_pressure", "load pressure", "stress", -stress, stress),
        ("load_shear", "load shear", "stress", -stress, stress),
        ("angle", "angle of the wave", "degrees", -STEEPEST, STEEPEST),
        ("wave_stress", "stress of the wave", "stress", -stress, stress),
        ("load_speed", "speed of the load", "length / time", 0.1 / time, 5 / time),
        ("viscosity", "viscosity", "stress time / length", 0.0, 2 * impedance),
        ("reduction", "reduction", "1", 0.0, 1.0),
        ("rate", "rate", "length / time", rate / 10, 2 * rate),
        ("distance", "distance", "length", rate * time / 50, rate * time),
        ("rise_time", "rise time", "time", 0.0, 2 * time),
        ("duration", "duration", "time", time / 20, 2 * time),
        ("frequency", "frequency", "1 / time", 0.25 / time, 8 / time),
        ("modulus_ratio", "modulus, lower over upper", "1", 0.1, 10.0),
        ("density_ratio", "density, lower over upper", "1", 0.25, 4.0),
        ("lower_poisson_ratio", "Poisson ratio, lower", "1", -0.95, 0.49),
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
        step = float(10.0 ** math.floor(math.log10((high - low) / 200)))  # at least 200 positions
        result.append(Slider(name, label, named, low, high, step))
    return tuple(result)


def serve_for(sliders_of: Scene, values: Mapping[str, Any]) -> bool:
    """Return whether the sliders of a problem suit other values too.

    The values must have the same units and the same upper body, and lie within the ranges.
    """
    own, called_for = values_of(sliders_of), values_of(scene_of(values))
    return all(values[name] == own[name] for name in FIXED) and all(
        bar.low <= called_for.get(bar.name, bar.low) <= bar.high for bar in sliders(sliders_of)
    )


def defaults(scene: Scene) -> Values:
    """Return the values of all controls; those that the problem does not use are mid-range.

    A lower body that is not used has the Poisson ratio of the upper one.
    """
    rest: Values = {}
    for slider in sliders(scene):
        steps = round((slider.low + slider.high) / 4 / slider.step)
        rest[slider.name] = float(f"{steps * slider.step:.12g}")
    rest["lower_poisson_ratio"] = scene.material.poisson_ratio
    words = {name: words[0] for name, words in CHOICES.items()}
    return rest | words | values_of(scene)


def values_of(scene: Scene) -> Values:
    """Return a scene, or two different bodies, as values of controls.

    A SceneError refuses what there is no control for, as different histories of pressure and shear.
    """
    check_slot("explore", scene)
    numbers = {name: number.value for name, number in numbers_of(scene).items()}
    values: Values = {"mode": scene.mode, "load_on": scene.load_on, "units": scene.units}
    values |= {name: numbers[name] for name in _NUMBERS} | _load_values(scene, numbers)
    histories = list(scene.acting_histories.values())
    if any(history != histories[0] for history in histories[1:]):
        raise SceneError(
            "explore has one history for pressure and shear of the load; give both the same."
        )
    history = history_document(histories[0]) if histories else {"kind": "step"}
    law = law_table(scene.law)
    for name, part in (("law", law), ("history", history)):
        known = PARTS[name]
        if part["kind"] not in known or "cohesion" in part or part.get("shape") == "exponential":
            raise SceneError(
                f"explore has no controls for the {name} {part['kind']}; "
                f"choose among {', '.join(known)}."
            )
        values[name] = part.pop("kind")
    values |= history | {
        name: numbers.get(name, numbers.get(f"friction_law_{name}"))
        for name in PARTS["law"][values["law"]]
    }
    if scene.lower_material is None:
        return values | {"lower_body": ALIKE}
    return values | {
        "lower_body": ANOTHER,
        "modulus_ratio": numbers["lower_shear_modulus"] / numbers["shear_modulus"],
        "density_ratio": numbers["lower_density"] / numbers["density"],
        "lower_poisson_ratio": numbers["lower_poisson_ratio"],
    }


def _load_values(scene: Scene, numbers: Mapping[str, float]) -> Values:
    """Return the load of a scene as values of controls; a wave by its stress."""
    load, solid = scene.load, scene.material
    if isinstance(load, IncidentWave):
        stress = solid.density * load.speed(solid) * load.particle_velocity(solid)
        words = {"load": "incident-wave", "wave": load.kind, "wave_from": load.from_}
        return {**words, "angle": load.angle, "wave_stress": stress}
    kind = "moving" if isinstance(load, MovingLoad) else AT_ONCE
    shown = (name for name in PARTS["load"][kind] if name in numbers)
    return {"load": kind, **{name: numbers[name] for name in shown}}


def scene_of(values: Mapping[str, Any]) -> Scene:
    """Return the scene that values of controls describe; values that it does not use are ignored.

    A SceneError refuses values that are missing or no numbers, scenes that do not exist, and
    different bodies that have no exact answer under such a load or law.
    """
    numbers = {name: _number(values, name) for name in _NUMBERS}
    load = {_IN_FILES.get(name, name): value for name, value in _part(values, "load").items()}
    load_on = load.pop("load_on", None) or SLOT
    if load["kind"] == AT_ONCE:
        del load["kind"]
    document: dict[str, Any] = {
        "friction": numbers["friction"],
        "material": {name: numbers[name] for name in ("shear_modulus", "density", "poisson_ratio")},
        "base": {kind: numbers[f"base_{kind}"] for kind in ("pressure", "shear")},
        "load": load,
        "mode": values.get("mode", IN_PLANE),
        "load_on": load_on,
        "units": values.get("units", ""),
        "friction_law": _part(values, "law"),
    }
    history, lower = _part(values, "history"), _part(values, "lower_body")
    for kind in ("pressure", "shear"):
        if load.get(kind, "angle" in load):
            document[f"{kind}_history"] = history
    if lower["kind"] == ANOTHER:
        document["lower_material"] = {
            "shear_modulus": numbers["shear_modulus"] * lower["modulus_ratio"],
            "density": numbers["density"] * lower["density_ratio"],
            "poisson_ratio": lower["lower_poisson_ratio"],
        }
    scene = scene_from_document(document)
    if scene.lower_material is not None:
        check_bodies(scene)
    return scene


_NUMBERS = (
    *("shear_modulus", "density", "poisson_ratio"),
    *("friction", "base_pressure", "base_shear"),
)


def _part(values: Mapping[str, Any], name: str) -> Values:
    """Return the kind that is chosen of a part, and the values of the controls that it shows."""
    known = PARTS[name]
    kind = values.get(name, next(iter(known)))
    checked_word(name, kind, known)
    return {"kind": kind} | {
        key: values.get(key) if key in CHOICES else _number(values, key) for key in known[kind]
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
    """Return the query of an address, ``?friction=0.3&...``, with all that its scene uses."""
    names = [*_NUMBERS, *PARTS["load"][values["load"]], "mode", "units"]
    for name, known in PARTS.items():
        kind = values[name]
        names += [] if kind in (AT_ONCE, ALIKE) else [name]
        names += known[kind]
    return "?" + urlencode({name: values[name] for name in dict.fromkeys(names)})


def values_from_query(query: str, start: Scene) -> Values:
    """Return the values of all controls for the query of an address.

    Values missing from the query are those of the problem `start`; values that neither uses are
    mid-range.  Names and values that are none are refused by a SceneError.
    """
    base = defaults(start)
    texts = dict(parse_qsl(query.removeprefix("?"), keep_blank_values=True))
    given: Values = {}
    for name, text in texts.items():
        if name not in base and name not in FIXED:
            raise SceneError(f"the address names {shown(name)}, which no scene has; remove it.")
        word = name in CHOICES or name == "units"
        given[name] = text if word else _number(texts, name)
        if name in CHOICES:
            checked_word(name, text, CHOICES[name])
    return defaults(scene_of(base | given)) | given
