"""Closed forms: where they end, against one another and numbers formed elsewhere."""

import numpy as np
import pytest
from catalogue import UNIT

from semianalytic import Coulomb, Material, Scene, SceneError, Tractions, solve
from semianalytic.halfplane.stuck import stuck_traction
from semianalytic.reference import (
    detached_opening,
    edge_speed_of_opening,
    edge_speed_under_shear_step,
    gap_rate_of_opening,
    slip_rate_under_remote_shock,
    slip_rate_under_shear_step,
    slip_rate_without_friction,
    viscous_edge_speed,
    viscous_slip_rate,
)
from semianalytic.reference.viscous_zone import _viscous_zone


@pytest.mark.parametrize(
    "slip_rate",
    [
        lambda velocity: slip_rate_under_shear_step(UNIT, 1.0, 1.0, velocity - 1e-9),
        lambda velocity: slip_rate_under_remote_shock(UNIT, 1.0, 1.0, 0.5, velocity),
        lambda velocity: slip_rate_without_friction(UNIT, 1.0, velocity),
    ],
)
def test_velocities_off_the_contact_are_refused(slip_rate):
    with pytest.raises(SceneError, match="x/t must be"):
        slip_rate(np.array([0.5, 0.0]))


# --- the viscous zone in plane: its own transform, limits, and the solver against it --------------


CASES = [(0.5, 0.25), (1.0, 2.0), (1.0, 1e-5), (2.0, 0.01)]


def test_reference_values():
    """nu = 1/3, mu = rho = Q_0 = 1."""
    assert viscous_edge_speed(UNIT, 1.0, 0.25) == pytest.approx(0.353434881776, abs=1e-12)
    assert viscous_edge_speed(UNIT, 0.5, 0.25) == pytest.approx(0.614433256870, abs=1e-12)
    at_edge = viscous_slip_rate(UNIT, 1.0, 1.0, 0.25, 0.0)
    assert float(at_edge) == pytest.approx(2 * 0.2799308415206, abs=1e-12)


@pytest.mark.parametrize("mode", ["II", "III"])
@pytest.mark.parametrize(("ratio", "viscosity"), CASES)
def test_traction_jumps_at_the_contact_edge_by_what_the_transform_says(ratio, viscosity, mode):
    """T(inf) = R is the jump at x = 0, from -Q_0 on the slot to f P_b + eta V(0+)."""
    zone = _viscous_zone(UNIT, ratio, viscosity, mode)
    carried = ratio + 2 * viscosity * zone.slip_rate(0.0)
    assert zone.constant == pytest.approx(1 + carried, abs=1e-13)


def test_without_viscosity_it_is_the_closed_form():
    velocity = np.array([0.0, 0.1, 0.3, 0.4])
    assert viscous_edge_speed(UNIT, 1.0, 0.0) == pytest.approx(
        edge_speed_under_shear_step(UNIT, 1.0), abs=1e-13
    )
    np.testing.assert_allclose(
        viscous_slip_rate(UNIT, 1.5, 1.0, 0.0, velocity),
        slip_rate_under_shear_step(UNIT, 1.5, 1.0, velocity),
        atol=1e-12,
    )


@pytest.mark.thinned(6)
@pytest.mark.parametrize(("ratio", "viscosity"), CASES)
def test_solver_agrees_with_the_quadrature(ratio, viscosity):
    material, load = Material(2.0, 0.5, 1 / 3), 3.0
    viscosity *= material.shear_impedance
    law, base, step = Coulomb(1.0, viscosity=viscosity), Tractions(load, 0.0), Tractions(0.0, load)
    scene = Scene(material, law.with_coefficient(ratio), base, step)
    solution = solve(scene, rtol=1e-12)
    (zone,) = solution.zones
    edge = viscous_edge_speed(material, ratio, viscosity)
    assert zone.outer == pytest.approx(edge, rel=1e-11)
    velocity = edge * np.array([0.1, 0.5, 0.9])
    rate = viscous_slip_rate(material, load, ratio, viscosity, velocity)
    np.testing.assert_allclose(solution.slip_rate(velocity, 1.0), rate, rtol=1e-11)
    at_edge = viscous_slip_rate(material, load, ratio, viscosity, 0.0)
    assert solution.edge_slip_rate == pytest.approx(float(at_edge), rel=1e-11)


def test_what_makes_no_sense_is_refused():
    with pytest.raises(SceneError, match="velocity"):
        viscous_slip_rate(UNIT, 1.0, 1.0, 0.1, -1.0)
    for ratio, viscosity in ((0.0, 0.1), (1.0, -0.1)):
        with pytest.raises(SceneError, match="must be positive"):
            viscous_edge_speed(UNIT, ratio, viscosity)


# --- openings -------------------------------------------------------------------------------------


def test_speeds_of_an_opening_from_the_edge():
    assert edge_speed_of_opening(UNIT, 1.0) == pytest.approx(0.1875, rel=1e-15)
    assert edge_speed_of_opening(UNIT, 0.5) == pytest.approx(1 / 3, rel=1e-15)


@pytest.mark.parametrize("poisson_ratio", [-0.9, 0.0, 1 / 3, 0.49])
@pytest.mark.parametrize("ratio", [0.0, 0.3, 4.0])
def test_no_opening_from_the_edge_reaches_the_rayleigh_front(poisson_ratio, ratio):
    material = Material(1.0, 1.0, poisson_ratio)
    assert edge_speed_of_opening(material, ratio) < 0.97 * material.rayleigh_speed


def test_gap_rate_vanishes_at_the_edge_of_the_opening_like_a_square_root():
    edge = edge_speed_of_opening(UNIT, 1.0)
    beside = edge * (1 - np.array([0.0, 1e-8, 4e-8, 0.5, 1.0]))
    rate = gap_rate_of_opening(UNIT, -1.0, 1.0, beside)
    assert rate[0] == 0
    assert rate[2] / rate[1] == pytest.approx(2.0, rel=1e-6)
    assert rate[4] > rate[3] > 0
    assert np.all(gap_rate_of_opening(UNIT, -1.0, 1.0, [edge, 1.0, 3.0]) == 0)


# Of a prototype with trapezoidal rules of its own, good across the shear front as well: the outer
# edge, the inner edge and P_b / P_0 at nu = 1/3.
@pytest.mark.parametrize(
    ("outer", "inner", "ratio"), [(0.98, 0.8055372604836609, 0.047640821955792)]
)
def test_detached_opening_against_numbers_of_another_quadrature(outer, inner, ratio):
    opening = detached_opening(UNIT, outer)
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
        gap_rate_of_opening(UNIT, 1.0, 1.0, 0.1)
    for outer in (UNIT.rayleigh_speed, 1.01):
        with pytest.raises(SceneError, match="between the Rayleigh and the shear speed"):
            detached_opening(UNIT, outer)
