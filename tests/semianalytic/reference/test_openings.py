"""Openings in closed form: against one another, numbers formed elsewhere, and where they end."""

import numpy as np
import pytest

from semianalytic import Material, SceneError
from semianalytic.halfplane.stuck import stuck_traction
from semianalytic.reference import detached_opening, edge_speed_of_opening, gap_rate_of_opening

MATERIAL = Material(1.0, 1.0, 1 / 3)


def test_speeds_of_an_opening_from_the_edge():
    assert edge_speed_of_opening(MATERIAL, 1.0) == pytest.approx(0.1875, rel=1e-15)
    assert edge_speed_of_opening(MATERIAL, 0.5) == pytest.approx(1 / 3, rel=1e-15)


@pytest.mark.parametrize("poisson_ratio", [-0.9, 0.0, 1 / 3, 0.49])
@pytest.mark.parametrize("ratio", [0.0, 0.3, 4.0])
def test_no_opening_from_the_edge_reaches_the_rayleigh_front(poisson_ratio, ratio):
    material = Material(1.0, 1.0, poisson_ratio)
    assert edge_speed_of_opening(material, ratio) < 0.97 * material.rayleigh_speed


def test_gap_rate_vanishes_at_the_edge_of_the_opening_like_a_square_root():
    edge = edge_speed_of_opening(MATERIAL, 1.0)
    beside = edge * (1 - np.array([0.0, 1e-8, 4e-8, 0.5, 1.0]))
    rate = gap_rate_of_opening(MATERIAL, -1.0, 1.0, beside)
    assert rate[0] == 0
    assert rate[2] / rate[1] == pytest.approx(2.0, rel=1e-6)
    assert rate[4] > rate[3] > 0
    assert np.all(gap_rate_of_opening(MATERIAL, -1.0, 1.0, [edge, 1.0, 3.0]) == 0)


# Of a prototype with trapezoidal rules of its own, good across the shear front as well: the outer
# edge, the inner edge and P_b / P_0 at nu = 1/3.
@pytest.mark.parametrize(
    ("outer", "inner", "ratio"), [(0.98, 0.8055372604836609, 0.047640821955792)]
)
def test_detached_opening_against_numbers_of_another_quadrature(outer, inner, ratio):
    opening = detached_opening(MATERIAL, outer)
    assert opening.inner == pytest.approx(inner, rel=1e-13)
    assert opening.pressure_ratio == pytest.approx(ratio, rel=1e-13)


@pytest.mark.parametrize("poisson_ratio", [-0.9, -0.3, 0.0, 0.2, 0.45, 0.49])
def test_detached_openings_begin_where_the_stuck_pressure_turns_tensile(poisson_ratio):
    material = Material(1.0, 1.0, poisson_ratio)
    threshold = -stuck_traction(poisson_ratio, "I").at_rayleigh_front
    opening = detached_opening(material, 1.0001 * material.rayleigh_speed)
    assert 0 < threshold - opening.pressure_ratio < 1e-5 * threshold
    wider = detached_opening(material, 0.5 * (1 + material.rayleigh_speed))
    assert wider.pressure_ratio < opening.pressure_ratio
    assert wider.inner < opening.inner < material.rayleigh_speed


def test_openings_that_are_not_there_are_refused():
    with pytest.raises(SceneError, match="negative pressure step"):
        gap_rate_of_opening(MATERIAL, 1.0, 1.0, 0.1)
    for outer in (MATERIAL.rayleigh_speed, 1.01):
        with pytest.raises(SceneError, match="between the Rayleigh and the shear speed"):
            detached_opening(MATERIAL, outer)
