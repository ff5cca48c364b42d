"""The viscous zone in plane: what its own transform says, limits, and the solver against it."""

import numpy as np
import pytest

from semianalytic import Material, Scene, SceneError, Tractions, ViscousFriction, solve
from semianalytic.reference import (
    edge_speed_under_shear_step,
    slip_rate_under_shear_step,
    viscous_edge_speed,
    viscous_slip_rate,
)
from semianalytic.reference.viscous_zone import _viscous_zone

UNIT = Material(1.0, 1.0, 1 / 3)
CASES = [(0.5, 0.25), (1.0, 2.0), (1.0, 1e-5), (2.0, 0.01)]


def test_reference_values():
    """nu = 1/3, mu = rho = Q_0 = 1."""
    assert viscous_edge_speed(UNIT, 1.0, 0.25) == pytest.approx(0.353434881776, abs=1e-12)
    assert viscous_edge_speed(UNIT, 0.5, 0.25) == pytest.approx(0.614433256870, abs=1e-12)
    at_edge = viscous_slip_rate(UNIT, 1.0, 1.0, 0.25, 0.0)
    assert float(at_edge) == pytest.approx(2 * 0.2799308415206, abs=1e-12)


@pytest.mark.parametrize(("ratio", "viscosity"), CASES)
def test_traction_jumps_at_the_contact_edge_by_what_the_transform_says(ratio, viscosity):
    """T(inf) = R is the jump at x = 0, from -Q_0 on the slot to f P_b + eta V(0+)."""
    zone = _viscous_zone(UNIT, ratio, viscosity)
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
    scene = Scene(
        material,
        ratio,
        Tractions(load, 0.0),
        Tractions(0.0, load),
        friction_law=ViscousFriction(viscosity),
    )
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
