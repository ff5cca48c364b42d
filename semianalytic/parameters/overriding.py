"""Override single parameters of a scene, as the options of commands do."""

from __future__ import annotations

import re
from dataclasses import replace

from semianalytic.parameters.numbers import numbers_of, with_numbers
from semianalytic.scene.errors import SceneError
from semianalytic.scene.incident import overridden_load
from semianalytic.scene.quantities import in_units_of
from semianalytic.scene.scene import Scene
from semianalytic.scene.units import PARAMETERS

_LOADS = ("load_pressure", "load_shear", "load_speed")
_WAVES = {"angle": "angle", "wave_velocity": "velocity", "wave_stress": "stress"}


def override_scene(
    scene: Scene,
    *,
    units: str | None = None,
    mode: str | None = None,
    load_on: str | None = None,
    wave: str | None = None,
    wave_from: str | None = None,
    **numbers: float | None,
) -> Scene:
    """Return a scene with every parameter replaced that is not None.

    Numbers go by their names in `parameters.numbers`, and dimensions are those of `Scene`,
    `Material` and `Tractions`; those of the lower body begin with "lower_", and what is not given
    of it stays, or is like the upper body where both were equal.  A viscosity turns constant
    friction into viscous friction, and 0 turns it back.  `wave`, `angle`, `wave_velocity` or
    `wave_stress` and `wave_from` are those of an `IncidentWave`, in place of whatever the scene's
    load is; `load_speed` is that of a `MovingLoad`, which takes the scene's tractions.  Numbers
    with units, as quantities of pint,
    need a scene in SI units.

    Raises SceneError if the resulting scene is not admissible, or a viscosity is given for friction
    that weakens.
    """
    # First, since quantities with units are allowed in a scene in SI units alone.
    scene = scene if units is None else replace(scene, units=units)
    given = {name: value for name, value in numbers.items() if value is not None}
    for name, value in given.items():
        parameter = re.sub("^(base|load|lower)_", "", name)
        in_units_of(scene.units, name.replace("_", " "), value, PARAMETERS[parameter])
    loads = {name.removeprefix("load_"): given.pop(name, None) for name in _LOADS}
    waves = {field: given.pop(name, None) for name, field in _WAVES.items()}
    if "viscosity" in given.keys() - numbers_of(scene).keys():
        raise SceneError(
            "viscosity goes with constant or viscous friction only, and this scene's weakens; "
            "leave viscosity out, or take out the scene's friction law."
        )
    asked = (("mode", mode), ("load_on", load_on))
    words = {name: word for name, word in asked if word is not None}
    load = overridden_load(scene.load, loads, {**waves, "kind": wave, "from_": wave_from})
    lower = {name: given.pop(name) for name in list(given) if name.startswith("lower_")}
    if missing := sorted(given.keys() - numbers_of(scene).keys()):
        raise SceneError(
            f"{missing[0]} is no number of this scene: it varies along x, or its friction law has "
            "none; change the scene itself."
        )
    scene = with_numbers(scene, given, load=load, **words)
    if not lower:
        return scene
    try:
        body = replace(scene.bodies[1], **{name[len("lower_") :]: lower[name] for name in lower})
    except SceneError as error:  # it does not know which of the two bodies it is
        raise SceneError(str(error).replace("material: ", "lower_", 1)) from error
    return replace(scene, lower_material=body)
