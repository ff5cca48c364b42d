"""Scales of a comparison: reference stress and slip rate, wave fronts, speed regimes."""

from __future__ import annotations

import math

from semianalytic import Material, Scene
from semianalytic.scene.units import unit

WAVE_SYMBOLS = {"Rayleigh": "c_R", "S": "c_t", "P": "c_l"}
"""Symbols of the wave speeds, by the name of the signal."""
LOWER = "lower "
"""Beginning of the names of signals of a different lower body."""


def stress_scale(scene: Scene) -> float:
    """Reference stress τ₀ [stress], positive: the larger step, or without one the larger base."""
    along = (scene.base,) if scene.on_line else (scene.superposition.taken_off, scene.base)
    for tractions in along:
        both = tractions.pressure, tractions.shear
        largest = max((abs(value) for value in both if not callable(value)), default=0.0)
        if largest > 0:
            return largest
    return 1.0


def slip_rate_scale(scene: Scene) -> float:
    """Reference relative slip rate V₀ = 2 τ₀ / (ρ c_t) [length / time].

    Two frictionless faces slip at this rate under a plane shear wave of amplitude τ₀.
    """
    return 2 * stress_scale(scene) / scene.material.shear_impedance


def reference_values(scene: Scene, end_time: float) -> dict[str, tuple[float, str]]:
    """Return the reference values of a comparison: value and unit by symbol."""
    values = {
        "c_t": (scene.material.shear_speed, "length / time"),
        "T": (end_time, "time"),
        "τ₀": (stress_scale(scene), "stress"),
        "V₀": (slip_rate_scale(scene), "length / time"),
    }
    return {
        symbol: (value, unit(dimension, scene.units))
        for symbol, (value, dimension) in values.items()
    }


def wave_speeds(material: Material) -> dict[str, float]:
    """Speeds [length / time] of the three signals, slowest first, by the name of the signal."""
    return {
        "Rayleigh": material.rayleigh_speed,
        "S": material.shear_speed,
        "P": material.longitudinal_speed,
    }


def scene_fronts(scene: Scene) -> dict[str, float]:
    """Speeds of the signals of the upper body: in antiplane shear alone, only the S wave."""
    speeds = wave_speeds(scene.material)
    return {name: speed for name, speed in speeds.items() if name == "S" or not scene.shears_alone}


def contact_fronts(scene: Scene) -> dict[str, float]:
    """Speeds of the signals along the contact: those of the scene or, with another lower body, body
    waves of both, the lower ones called "lower S" and "lower P"."""
    if scene.lower_material is None:
        return scene_fronts(scene)
    fronts: dict[str, float] = {}
    for before, body in zip(("", LOWER), scene.bodies, strict=True):
        fronts |= {before + name: wave_speeds(body)[name] for name in ("S", "P")}
    return fronts


def speed_regime(speed: float, scene: Scene) -> str:
    """Name of the range between wave speeds in which a zone edge moves [length / time].

    An edge within 1e-6 of a wave moves at its speed.  In antiplane slip c_R does not divide ranges.
    """
    material = scene.material
    names = {"c_t": material.shear_speed, "c_l": material.longitudinal_speed}
    if not scene.antiplane:
        names = {"c_R": material.rayleigh_speed, **names}
    for name, wave in names.items():
        if math.isclose(speed, wave, rel_tol=1e-6):
            return f"at {name}"
    if speed == 0:
        return "fixed at the edge"
    if math.isinf(speed):
        return "everywhere"
    if speed < names.get("c_R", 0.0):
        return "sub-Rayleigh"
    if speed < names["c_t"]:
        return "sub-shear" if scene.antiplane else "c_R–c_t"
    if speed < names["c_l"]:
        return "c_t–c_l"
    return "beyond c_l"
