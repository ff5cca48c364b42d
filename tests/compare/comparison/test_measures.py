"""Errors, zone edges and onsets on samples whose answer is known; scales and names of speeds."""

import math
from dataclasses import replace

import numpy as np
import pytest

from compare.comparison.measures import first_above, norm, relative_error
from compare.comparison.scales import (
    scene_fronts,
    slip_rate_scale,
    speed_regime,
    stress_scale,
    wave_speeds,
)
from semianalytic import Material, Scene, Tractions
from semianalytic.results.intervals import slip_intervals
from semianalytic.scene.given.finding import find_scene

CELL = 0.01
VELOCITY = CELL * np.arange(1, 221)


def zone_profile(inner, outer, top=1.0):
    """Slip rate with square-root edges, as between two zone edges."""
    inside = np.clip((VELOCITY - inner) * (outer - VELOCITY), 0, None)
    return top * np.sqrt(inside) * 2 / (outer - inner)


def test_norms_of_a_ramp():
    x = np.linspace(0, 2, 2001)
    assert norm(-x, x, 1) == pytest.approx(2.0)
    # The trapezoidal rule errs by h^2/12 times the change of slope, here 3e-7.
    assert norm(x, x, 2) == pytest.approx(math.sqrt(8 / 3), rel=1e-6)


def test_norms_over_space_and_time():
    """Norms of x t over a unit square: 1/4 in L1, 1/3 in L2, off by the trapezoidal rule alone."""
    x = t = np.linspace(0, 1, 201)
    values = t[:, None] * x
    assert norm(values, x, 1, t) == pytest.approx(1 / 4, rel=1e-9)
    assert norm(values, x, 2, t) == pytest.approx(1 / 3, rel=1e-4)
    assert relative_error(1.1 * values, values, x, 1, t) == pytest.approx(0.1)


def test_relative_error_is_relative_to_the_prediction():
    x = np.linspace(0, 1, 11)
    for order in (1, 2):
        assert relative_error(1.1 * x, x, x, order) == pytest.approx(0.1)
    assert relative_error(x, 0 * x, x, 1) == math.inf


@pytest.mark.parametrize("shift", [0.0, 0.25, 0.5, 0.75])
@pytest.mark.parametrize("sense", [1, -1])
def test_square_root_edges_are_found_within_half_a_cell(shift, sense):
    inner, outer = 0.6 + shift * CELL, 0.9 + shift * CELL
    (zone,) = slip_intervals(VELOCITY, sense * zone_profile(inner, outer), 0.01)
    assert zone.sense == sense
    # The square is a parabola, not a line: half a cell covers its curvature over four cells.
    assert zone.start == pytest.approx(inner, abs=0.5 * CELL)
    assert zone.end == pytest.approx(outer, abs=0.5 * CELL)


def test_zones_of_both_senses_are_told_apart():
    profile = zone_profile(0.3, 0.6) - zone_profile(0.6, 0.7, 0.2) + zone_profile(0.98, 1.06, 0.1)
    zones = slip_intervals(VELOCITY, profile, 0.01)
    assert [zone.sense for zone in zones] == [1, -1, 1]
    assert zones[2].start == pytest.approx(0.98, abs=CELL)


def test_a_zone_at_either_end_of_the_samples_reaches_the_edge_or_infinity():
    (zone,) = slip_intervals(VELOCITY, np.ones_like(VELOCITY), 0.01)
    assert (zone.start, zone.end) == (0.0, math.inf)


def test_what_stays_below_the_threshold_or_on_one_node_is_no_zone():
    profile = np.full_like(VELOCITY, 0.009)
    profile[50] = 0.5
    assert slip_intervals(VELOCITY, profile, 0.01) == ()


@pytest.mark.parametrize(
    ("slip_rate", "onset"),
    [
        ([0, 0, 0.2, 0.9], pytest.approx(0.225)),  # between the samples around it
        ([1.0, 1.0, 1.0, 1.0], 0.1),  # slip that is there already
        ([0, 0, 0, 0], None),
    ],
)
def test_onset_of_slip(slip_rate, onset):
    assert first_above(np.array([0.1, 0.2, 0.3, 0.4]), np.array(slip_rate), 0.05) == onset


# --- reference values and names of speed ranges ---------------------------------------------------

MATERIAL = Material(shear_modulus=4.0, density=1.0, poisson_ratio=0.25)


def test_scale_of_stress_is_the_larger_step_then_the_larger_base_then_one():
    base, none = Tractions(5.0, -1.0), Tractions(0.0, 0.0)
    assert stress_scale(Scene(MATERIAL, 0.5, base, Tractions(0.5, -3.0))) == 3.0
    assert stress_scale(Scene(MATERIAL, 0.5, base, none)) == 5.0
    assert stress_scale(Scene(MATERIAL, 0.5, none, none)) == 1.0
    # that of slip rate is twice stress over impedance
    scene = Scene(MATERIAL, 0.5, base, Tractions(0.0, 3.0))
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
