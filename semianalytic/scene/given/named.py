"""Scenes that come with the package, by name."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from semianalytic.scene.incident import IncidentWave, MovingLoad
from semianalytic.scene.laws.coulomb import Coulomb
from semianalytic.scene.loading import REMOTE, GrowingLoad, Patch, PointForce
from semianalytic.scene.loads import Harmonic, Pulse, Ramp
from semianalytic.scene.scene import Material, Scene, Tractions


@dataclass(frozen=True)
class NamedScene:
    """A scene that comes with the package, and a line that says what it shows."""

    scene: Scene
    summary: str


_UNIT_SOLID = Material(shear_modulus=1.0, density=1.0, poisson_ratio=1 / 3)
_NOTHING, _PRELOAD = Tractions(0.0, 0.0), Tractions(1.0, 0.0)
_SHEAR, _BOTH = Tractions(0.0, 1.0), Tractions(1.0, 1.0)

DEFAULT_SCENE = "preloaded"
_GOUGE, _ROCK = Material(1.0, 1.0, 0.25), Material(2.5, 1.2, 0.25)
"""A slow solid on a fast one, with the ratios of gouge and rock."""

NAMED_SCENES: dict[str, NamedScene] = {
    "preloaded": NamedScene(
        Scene(_UNIT_SOLID, 0.3, base=Tractions(1.0, 0.0), load=Tractions(0.0, 1.0)),
        "constant pressure, sudden shear: two slip zones, one across the shear wave",
    ),
    "remote-shock": NamedScene(
        Scene(_UNIT_SOLID, 1.25, base=_NOTHING, load=_BOTH, load_on=REMOTE),
        "sudden remote pressure and shear, friction just low enough for the edge to slip",
    ),
    "stuck": NamedScene(
        Scene(_UNIT_SOLID, 2.0, base=_NOTHING, load=_BOTH, load_on=REMOTE),
        "sudden remote pressure and shear, friction high enough to prevent slip",
    ),
    "auxetic": NamedScene(
        Scene(Material(1.0, 1.0, -0.5), 0.005, base=_PRELOAD, load=_SHEAR),
        "nu = -0.5 and little friction: reverse slip in a strip around the Rayleigh front",
    ),
    "ramp": NamedScene(
        Scene(_UNIT_SOLID, 0.3, _PRELOAD, _SHEAR, shear_history=Ramp(0.5)),
        "constant pressure, shear rising evenly until t = 0.5, then constant",
    ),
    "unload": NamedScene(
        Scene(_UNIT_SOLID, 0.15, _PRELOAD, _SHEAR, shear_history=Pulse(0.6, "triangle")),
        "constant pressure, shear that ramps up and down again: slip reverses",
    ),
    "pulse": NamedScene(
        Scene(_UNIT_SOLID, 0.15, _PRELOAD, _SHEAR, shear_history=Pulse(0.4)),
        "constant pressure, shear on and off again suddenly",
    ),
    "harmonic": NamedScene(
        Scene(_UNIT_SOLID, 0.1, _PRELOAD, _SHEAR, shear_history=Harmonic(3.0)),
        "constant pressure, shear that oscillates: slip reverses each half cycle",
    ),
    "pressure-drop": NamedScene(
        Scene(_UNIT_SOLID, 0.3, base=Tractions(1.0, 0.295), load=Tractions(1.0, 0.0)),
        "constant shear, sudden loss of pressure on the slot: slip ahead of the shear wave",
    ),
    "viscous": NamedScene(
        Scene(_UNIT_SOLID, Coulomb(0.2, viscosity=0.1), _PRELOAD, _SHEAR),
        "constant pressure, sudden shear, a viscous film: one slip zone across the Rayleigh front",
    ),
    "antiplane": NamedScene(
        Scene(_UNIT_SOLID, 0.5, _PRELOAD, _SHEAR, mode="antiplane"),
        "constant pressure, sudden antiplane shear: one slip zone, all of it in closed form",
    ),
    "incident-p": NamedScene(
        Scene(_UNIT_SOLID, 0.4, _PRELOAD, IncidentWave("P", angle=-30.0, stress=-0.6)),
        "a wave of tension at 30 degrees: the contact opens from its edge, with slip ahead",
    ),
    "incident-sv": NamedScene(
        Scene(_UNIT_SOLID, 0.3, _PRELOAD, IncidentWave("SV", angle=-20.0, stress=0.3)),
        "a shear wave at 20 degrees that meets the contact first: slip from the edge",
    ),
    "incident-pulse": NamedScene(
        Scene(
            _UNIT_SOLID,
            0.25,
            _PRELOAD,
            IncidentWave("SV", angle=-20.0, stress=0.3),
            pressure_history=Pulse(0.6),
            shear_history=Pulse(0.6),
        ),
        "a pulse of that wave: slip from the edge ends where the end of the pulse meets it",
    ),
    "moving-load": NamedScene(
        Scene(_UNIT_SOLID, 0.3, _PRELOAD, MovingLoad(speed=0.5, pressure=0.0, shear=1.0)),
        "shear that advances over the slot at half the shear wave's speed",
    ),
    "lift-off": NamedScene(
        Scene(_UNIT_SOLID, 0.3, base=_PRELOAD, load=Tractions(-1.0, 0.0)),
        "pressure applied to the slot: the contact opens from its edge",
    ),
    "lift-off-shear": NamedScene(
        Scene(_UNIT_SOLID, 0.3, base=_PRELOAD, load=Tractions(-1.0, 1.0)),
        "pressure and shear applied to the slot: slip runs ahead of the opening",
    ),
    "tap": NamedScene(
        Scene(_UNIT_SOLID, 0.3, base=Tractions(0.02, 0.0), load=Tractions(1.0, 0.0)),
        "sudden loss of 50 times the base pressure: the contact opens ahead and closes again",
    ),
    "pair-slip": NamedScene(
        Scene(_GOUGE, 0.2, Tractions(2.0, 0.0), Tractions(0.3, 1.0), lower_material=_ROCK),
        "two different bodies, sudden pressure and shear: slip changes the pressure",
    ),
    "pair-opening": NamedScene(
        Scene(_GOUGE, 0.3, _PRELOAD, Tractions(-1.0, 0.5), lower_material=_ROCK),
        "two different bodies, pressure and shear applied to the slot: slip ahead of an opening",
    ),
    "whole-line-patch": NamedScene(
        Scene(_UNIT_SOLID, 0.5, _PRELOAD, Patch(speed=0.3, shear=1.0)),
        "no slot: slip spreads to both sides of an over-stressed patch that grows",
    ),
    "point-load": NamedScene(
        Scene(_UNIT_SOLID, 1.0, _PRELOAD, PointForce(shear=1.0)),
        "no slot: slip spreads from a point force that grows linearly in time",
    ),
    "growing-load": NamedScene(
        Scene(_UNIT_SOLID, 0.5, _NOTHING, GrowingLoad(1.0, 1.0)),
        "pressure everywhere and shear on the slot grow linearly: one slip zone",
    ),
}
"""Scenes by name; those of two different bodies are in units of the upper one."""

NAMED_LINES, NAMED_SPECIMENS = (
    {path.stem: path for path in sorted((Path(__file__).parent / folder).glob("*.toml"))}
    for folder in ("lines", "specimens")
)
"""Files of scenes on a line, and of specimens of finite size, by name."""
