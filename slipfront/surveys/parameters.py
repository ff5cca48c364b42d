"""The numbers of a scene by name, which are the parameters that a survey may vary."""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from dataclasses import fields, replace
from os import PathLike, fspath
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from semianalytic.dissimilar.described import find_pair, pair_document
from semianalytic.dissimilar.pair import Pair
from semianalytic.scene.checks import finite, shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.friction import CoulombFriction, ViscousFriction
from semianalytic.scene.incident import IncidentWave
from semianalytic.scene.named import checked_scene, find_blocks
from semianalytic.scene.scene import Scene, scene_document

Surveyed = Scene | Pair
"""What a survey takes: a scene, or two different bodies with a slot."""
Described = TypeVar("Described", Scene, Pair)

Array = NDArray[np.float64]

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


def checked_subject(given: Surveyed | str | PathLike[str]) -> Surveyed:
    """Return what a survey was given: a scene or a pair, or the one of a name or file.

    Raises
    ------
    SceneError
        For the reasons given at `find_scene` and `find_pair`.
    """
    if isinstance(given, Pair):
        return given
    if isinstance(given, str | PathLike):
        scene, lower = find_blocks(fspath(given))
        return scene if lower in (None, scene.material) else find_pair(given)
    return checked_scene("survey", given)


def subject_document(subject: Surveyed) -> dict[str, Any]:
    """Return a scene or a pair as plain dictionaries; a pair as in its file."""
    return scene_document(subject) if isinstance(subject, Scene) else pair_document(subject)


def parameters_of(scene: Surveyed) -> dict[str, tuple[str, str]]:
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


def parameter_name(scene: Surveyed, given: str) -> str:
    """Return the name of a parameter that is spelled as in TOML, dotted, or with underscores.

    Raises
    ------
    SceneError
        If the scene has no such number.
    """
    known = parameters_of(scene)
    name = given.replace(".", "_").replace("-", "_").removeprefix("material_")
    name = name.replace("lower_material_", "lower_")
    name = "viscosity" if name == "friction_law_viscosity" and "viscosity" in known else name
    if name not in known:
        close = difflib.get_close_matches(name, known, n=1)
        hint = f"did you mean {close[0]}?" if close else f"it has {', '.join(known)}."
        raise SceneError(f"survey: this scene has no parameter {shown(given)}; {hint}")
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
