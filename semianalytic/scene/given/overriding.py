"""Override single parameters of a scene, as the options of commands do."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from semianalytic.scene.errors import SceneError
from semianalytic.scene.friction import CoulombFriction, FrictionLaw, ViscousFriction
from semianalytic.scene.incident import overridden_load
from semianalytic.scene.quantities import in_units_of
from semianalytic.scene.scene import Scene
from semianalytic.scene.units import PARAMETERS


def override_scene(
    scene: Scene,
    *,
    shear_modulus: float | None = None,
    density: float | None = None,
    poisson_ratio: float | None = None,
    friction: float | None = None,
    base_pressure: float | None = None,
    base_shear: float | None = None,
    load_pressure: float | None = None,
    load_shear: float | None = None,
    viscosity: float | None = None,
    mode: str | None = None,
    load_on: str | None = None,
    wave: str | None = None,
    angle: float | None = None,
    wave_velocity: float | None = None,
    wave_stress: float | None = None,
    wave_from: str | None = None,
    load_speed: float | None = None,
    units: str | None = None,
) -> Scene:
    """Return a scene with every parameter replaced that is not None.

    Dimensions are those of `Scene`, `Material` and `Tractions`.  A viscosity turns constant
    friction into viscous friction, and 0 turns it back.  `wave`, `angle`, `wave_velocity` or
    `wave_stress` and `wave_from` are those of an `IncidentWave`, in place of whatever the scene's
    load is; `load_speed` is that of a `MovingLoad`, which takes the scene's tractions.  Numbers
    with units, as quantities of pint, need a scene in SI units.

    Raises
    ------
    SceneError
        If the resulting scene is not admissible, or a viscosity is given for friction that weakens.
    """
    # First, since quantities with units are allowed in a scene in SI units alone.
    scene = scene if units is None else replace(scene, units=units)
    given = {
        "shear_modulus": shear_modulus,
        "density": density,
        "poisson_ratio": poisson_ratio,
        "friction": friction,
        "base_pressure": base_pressure,
        "base_shear": base_shear,
        "load_pressure": load_pressure,
        "load_shear": load_shear,
        "load_speed": load_speed,
        "angle": angle,
        "wave_velocity": wave_velocity,
        "wave_stress": wave_stress,
        "viscosity": viscosity,
    }
    for name, value in given.items():
        parameter = name.removeprefix("base_").removeprefix("load_")
        in_units_of(scene.units, name.replace("_", " "), value, PARAMETERS[parameter])
    return replace(
        scene,
        material=_replace_given(
            scene.material,
            shear_modulus=shear_modulus,
            density=density,
            poisson_ratio=poisson_ratio,
        ),
        base=_replace_given(scene.base, pressure=base_pressure, shear=base_shear),
        load=overridden_load(
            scene.load,
            {"pressure": load_pressure, "shear": load_shear, "speed": load_speed},
            {
                "kind": wave,
                "angle": angle,
                "velocity": wave_velocity,
                "stress": wave_stress,
                "from_": wave_from,
            },
        ),
        friction=scene.friction if friction is None else friction,
        friction_law=_with_viscosity(scene.friction_law, viscosity),
        mode=scene.mode if mode is None else mode,
        load_on=scene.load_on if load_on is None else load_on,
    )


def _with_viscosity(law: FrictionLaw, viscosity: float | None) -> FrictionLaw:
    """Return a law with this viscosity; Coulomb friction if it is 0, the same law if it is None."""
    if viscosity is None:
        return law
    if not isinstance(law, CoulombFriction | ViscousFriction):
        raise SceneError(
            "viscosity goes with constant or viscous friction only, and this scene's weakens; "
            "leave viscosity out, or take out the scene's friction law."
        )
    # Zero viscosity is Coulomb's law itself, so that such scenes compare as equal.
    return ViscousFriction(viscosity) if viscosity else CoulombFriction()


def _replace_given(description: Any, **values: float | None) -> Any:
    """Return a dataclass with the fields replaced that are not None."""
    return replace(description, **{key: v for key, v in values.items() if v is not None})
