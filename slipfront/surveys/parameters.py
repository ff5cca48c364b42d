"""The numbers of a scene by name, which a survey may vary."""

from __future__ import annotations

from os import PathLike
from typing import Any

import numpy as np

from semianalytic.parameters.numbers import numbers_of, spelled
from semianalytic.scene.arguments import floats_of
from semianalytic.scene.arrays import Array
from semianalytic.scene.checks import meant, shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.given.finding import checked_scene, find
from semianalytic.scene.scene import Scene


def checked_subject(given: object) -> Scene:
    """Return the scene that a survey was given, itself or by its name or file.

    Errors are those of `find` and `checked_scene`.
    """
    found = find(given) if isinstance(given, str | PathLike) else given
    if isinstance(found, Scene) and found.on_line:
        return found
    return checked_scene("survey", found)


def parameter_name(subject: Scene, given: str) -> str:
    """Return the name of a parameter that is spelled as in TOML, dotted, or with underscores;
    SceneError if the scene has no such number."""
    known, name = numbers_of(subject), spelled(given)
    name = "viscosity" if name == "friction_law_viscosity" and "viscosity" in known else name
    if name not in known:
        hint = meant(name, known, f"it has {', '.join(known)}.")
        raise SceneError(f"survey: this scene has no parameter {shown(given)}; {hint}")
    return name


def checked_values(name: str, given: Any) -> Array:
    """Return the values of a parameter as an array, (n,) or (); SceneError if they are not a number
    or a row of finite numbers."""
    values = floats_of(given)
    if values is None or values.ndim > 1 or not values.size or not np.all(np.isfinite(values)):
        raise SceneError(
            f"survey: {name} must be a number or a row of finite numbers, got {shown(given)}."
        )
    return values
