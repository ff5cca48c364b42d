"""The numbers of a scene or an interface by name, which a survey may vary."""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from dataclasses import fields, replace
from os import PathLike, fspath
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from compare.comparison.documents import SCENE_DIMENSIONS
from semianalytic.dissimilar.described import pair_of
from semianalytic.dissimilar.pair import Pair
from semianalytic.interface.files import InterfaceFile
from semianalytic.interface.named import described_interface
from semianalytic.interface.parameters import interface_at, interface_parameters, spelled
from semianalytic.scene.checks import finite, shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.friction import CoulombFriction, ViscousFriction
from semianalytic.scene.given.finding import checked_scene, find_blocks
from semianalytic.scene.given.parameters import part_parameters
from semianalytic.scene.incident import IncidentWave
from semianalytic.scene.scene import Scene

Array = NDArray[np.float64]
Subject = Scene | Pair | InterfaceFile
"""What a survey is of."""
Described = TypeVar("Described", Scene, Pair)

_PARTS = (
    "material",
    "upper",
    "lower",
    "base",
    "load",
    "pressure_history",
    "shear_history",
    "friction_law",
)
MATERIAL = ("shear_modulus", "density", "poisson_ratio")
_VISCOSITY = ("friction_law", "viscosity")


def parameters_of(scene: Scene | Pair) -> dict[str, tuple[str, str]]:
    """Return part and field of every number of a scene, by its name.

    Friction belongs to no part; its part is "".
    """
    names = {"friction": ("", "friction")}
    for part in _PARTS:
        held = getattr(scene, part, None)
        if held is None:  # pairs have no histories, and scenes no second body
            continue
        for field in fields(held):
            if finite(getattr(held, field.name)) is not None:
                prefix = "" if part in ("material", "upper") else f"{part}_"
                if isinstance(held, IncidentWave):  # as derivatives and options name them
                    prefix = "" if field.name == "angle" else "wave_"
                names[prefix + field.name] = part, field.name
    if isinstance(scene.friction_law, CoulombFriction | ViscousFriction):
        names.pop("friction_law_viscosity", None)
        names["viscosity"] = _VISCOSITY
    return names


def checked_subject(given: object) -> Subject:
    """Return the scene, pair or interface that a survey was given, itself or by its name or file.

    Raises
    ------
    SceneError
        If it is none of them.
    """
    if isinstance(given, Pair):
        return given
    described = described_interface(given)
    if described is not None:
        return described
    if isinstance(given, str | PathLike):
        scene, lower = find_blocks(fspath(given))
        return scene if lower in (None, scene.material) else pair_of(scene, lower)
    return checked_scene("survey", given)


def dimension_of(subject: Subject, name: str) -> str:
    """Return the dimension of a parameter."""
    if isinstance(subject, InterfaceFile):
        return interface_parameters(subject.interface)[name].dimension
    part, field = parameters_of(subject)[name]
    if part in ("friction_law", "pressure_history", "shear_history"):
        viscous = field == "viscosity"  # a viscosity turns constant friction into viscous friction
        kind = ViscousFriction if viscous else type(getattr(subject, part))
        return part_parameters(kind)[field].dimension
    part = "material" if part in ("upper", "lower") else part
    dimension: str = SCENE_DIMENSIONS[part][field] if part else SCENE_DIMENSIONS[field]
    return dimension


def parameter_name(subject: Subject, given: str) -> str:
    """Return the name of a parameter that is spelled as in TOML, dotted, or with underscores.

    Raises
    ------
    SceneError
        If the scene or interface has no such number.
    """
    known: Mapping[str, object]
    if isinstance(subject, InterfaceFile):
        known, what = interface_parameters(subject.interface), "interface"
    else:
        known, what = parameters_of(subject), "scene"
    name = spelled(given).replace("lower_material_", "lower_")
    name = "viscosity" if name == "friction_law_viscosity" and "viscosity" in known else name
    if name not in known:
        close = difflib.get_close_matches(name, known, n=1)
        hint = f"did you mean {close[0]}?" if close else f"it has {', '.join(known)}."
        raise SceneError(f"survey: this {what} has no parameter {shown(given)}; {hint}")
    return name


def checked_values(name: str, given: Any) -> Array:
    """Return the values of a parameter as an array, (n,) or ().

    Raises
    ------
    SceneError
        If they are not a number or a row of finite numbers.
    """
    try:
        values = np.asarray(given)
    except ValueError:
        values = np.array(None)
    if values.dtype.kind not in "fiu" or values.ndim > 1 or not values.size:
        raise SceneError(
            f"survey: {name} must be a number or a row of numbers, got {shown(given)}."
        )
    if not np.all(np.isfinite(values)):
        raise SceneError(f"survey: {name} must hold finite numbers only, got {shown(given)}.")
    return values.astype(float)


def interface_with(described: InterfaceFile, values: Mapping[str, float]) -> InterfaceFile:
    """Return an interface with other values of some parameters; errors are those of `Interface`."""
    return replace(described, interface=interface_at(described.interface, values))


def scene_at(scene: Described, values: Mapping[str, float]) -> Described:
    """Return the scene, or the pair, with other values of some parameters.

    A viscosity turns constant friction into viscous friction, and 0 turns it back.

    Raises
    ------
    SceneError
        If the values are out of range for a scene.
    """
    known = parameters_of(scene)
    changes: dict[str, dict[str, float]] = {}
    for name, value in values.items():
        part, field = known[name]
        changes.setdefault(part, {})[field] = value
    whole: dict[str, Any] = dict(changes.pop("", {}))
    for part, some in changes.items():
        if part == "friction_law" and "viscosity" in values:
            viscosity = values["viscosity"]
            whole[part] = ViscousFriction(viscosity) if viscosity else CoulombFriction()
        else:
            whole[part] = replace(getattr(scene, part), **some)
    return replace(scene, **whole)
