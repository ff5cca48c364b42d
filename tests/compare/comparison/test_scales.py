"""Reference values and names of speed ranges."""

import math
from dataclasses import replace

import pytest

from compare.comparison.scales import (
    scene_fronts,
    slip_rate_scale,
    speed_regime,
    stress_scale,
    wave_speeds,
)
from semianalytic import Material, Scene, Tractions
from semianalytic.scene.given.finding import find_scene

MATERIAL = Material(shear_modulus=4.0, density=1.0, poisson_ratio=0.25)


def test_stress_scale_is_the_larger_step_then_the_larger_base_then_one():
    base, none = Tractions(5.0, -1.0), Tractions(0.0, 0.0)
    assert stress_scale(Scene(MATERIAL, 0.5, base, Tractions(0.5, -3.0))) == 3.0
    assert stress_scale(Scene(MATERIAL, 0.5, base, none)) == 5.0
    assert stress_scale(Scene(MATERIAL, 0.5, none, none)) == 1.0


def test_slip_rate_scale_is_twice_stress_over_impedance():
    scene = Scene(MATERIAL, 0.5, Tractions(5.0, 0.0), Tractions(0.0, 3.0))
    assert slip_rate_scale(scene) == pytest.approx(2 * 3.0 / (1.0 * 2.0))


def test_wave_speeds_come_slowest_first():
    speeds = wave_speeds(MATERIAL)
    assert list(speeds) == ["Rayleigh", "S", "P"]
    assert list(speeds.values()) == sorted(speeds.values())
    assert speeds["S"] == pytest.approx(2.0)


@pytest.mark.parametrize(
    ("speed", "name"),
    [
        (0.0, "fixed at the edge"),
        (0.5, "sub-Rayleigh"),
        (0.95, "c_R–c_t"),
        (1.0, "at c_t"),
        (1.5, "c_t–c_l"),
        (2.5, "beyond c_l"),
        (math.inf, "everywhere"),
    ],
)
def test_regimes_by_speed(speed, name):
    assert speed_regime(speed, find_scene("preloaded")) == name


def test_antiplane_shear_knows_one_front_and_pressure_the_others():
    scene = find_scene("antiplane")
    assert scene_fronts(scene) == {"S": scene.material.shear_speed}
    pressed = replace(scene, base=Tractions(1.0, 0.0), load=Tractions(0.5, 1.0))
    assert scene_fronts(pressed) == wave_speeds(scene.material)
    assert speed_regime(0.95, scene) == speed_regime(0.5, scene) == "sub-shear"
    assert speed_regime(1.5, pressed) == "c_t–c_l"
