"""Errors, zone edges and onset times on samples whose answer is known."""

import math

import numpy as np
import pytest

from compare.comparison.measures import norm, onset_time, relative_error, sampled_zones

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


def test_relative_error_is_relative_to_the_prediction():
    x = np.linspace(0, 1, 11)
    assert relative_error(1.1 * x, x, x, 1) == pytest.approx(0.1)
    assert relative_error(1.1 * x, x, x, 2) == pytest.approx(0.1)
    assert relative_error(x, 0 * x, x, 1) == math.inf


@pytest.mark.parametrize("shift", [0.0, 0.25, 0.5, 0.75])
@pytest.mark.parametrize("sense", [1, -1])
def test_square_root_edges_are_found_within_half_a_cell(shift, sense):
    inner, outer = 0.6 + shift * CELL, 0.9 + shift * CELL
    (zone,) = sampled_zones(VELOCITY, sense * zone_profile(inner, outer), 0.01)
    assert zone.sense == sense
    # The square is a parabola, not a line: half a cell covers its curvature over four cells.
    assert zone.inner == pytest.approx(inner, abs=0.5 * CELL)
    assert zone.outer == pytest.approx(outer, abs=0.5 * CELL)


def test_zones_of_both_senses_are_told_apart():
    profile = zone_profile(0.3, 0.6) - zone_profile(0.6, 0.7, 0.2) + zone_profile(0.98, 1.06, 0.1)
    zones = sampled_zones(VELOCITY, profile, 0.01)
    assert [zone.sense for zone in zones] == [1, -1, 1]
    assert zones[2].inner == pytest.approx(0.98, abs=CELL)


def test_a_zone_at_either_end_of_the_samples_reaches_the_edge_or_infinity():
    (zone,) = sampled_zones(VELOCITY, np.ones_like(VELOCITY), 0.01)
    assert (zone.inner, zone.outer) == (0.0, math.inf)


def test_what_stays_below_the_threshold_or_on_one_node_is_no_zone():
    profile = np.full_like(VELOCITY, 0.009)
    profile[50] = 0.5
    assert sampled_zones(VELOCITY, profile, 0.01) == ()


def test_onset_lies_between_the_samples_around_it():
    time = np.array([0.1, 0.2, 0.3, 0.4])
    assert onset_time(time, np.array([0, 0, -0.2, -0.9]), 0.05) == pytest.approx(0.225)


def test_onset_of_slip_already_there_is_the_first_time():
    assert onset_time(np.array([0.1, 0.2]), np.array([1.0, 1.0]), 0.05) == 0.1


def test_no_slip_has_no_onset():
    assert onset_time(np.array([0.1, 0.2]), np.zeros(2), 0.05) is None
