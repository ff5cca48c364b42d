"""Evaluation anywhere: consistent fields, limits, and refusals."""

import numpy as np
import pytest
from catalogue import PRELOADED, REMOTE, SHOCK, UNIT, unit_scene
from scipy.integrate import quad

from semianalytic import SceneError, solve
from semianalytic.halfplane.stuck import stuck_traction


@pytest.fixture(scope="module")
def preloaded():
    return solve(PRELOADED)


@pytest.fixture(scope="module")
def shock():
    return solve(SHOCK)


@pytest.fixture(scope="module")
def stuck():
    return solve(unit_scene(2.0, **REMOTE))


@pytest.fixture(scope="module")
def sliding():
    return solve(unit_scene(0.5, **REMOTE))


@pytest.mark.thinned(3)
@pytest.mark.parametrize("name", ["preloaded", "shock", "sliding"])
def test_slip_is_the_time_integral_of_slip_rate(name, request):
    solution = request.getfixturevalue(name)
    for x in (0.3, 0.9, 1.02, 1.4):
        fronts = [x / 2, x, x / UNIT.rayleigh_speed]
        fronts += [x / v for z in solution.zones for v in (z.inner, z.outer) if 0 < v < np.inf]
        points = sorted(t for t in fronts if 0 < t < 2)
        expected = quad(
            lambda t, x=x: float(solution.slip_rate(x, t)),
            0,
            2,
            points=points,
            limit=400,
            epsabs=1e-9,
        )[0]
        assert float(solution.slip(x, 2.0)) == pytest.approx(expected, abs=2e-8)


def test_fields_broadcast_and_depend_on_the_ratio_only(preloaded):
    x, t = np.array([0.2, 0.5, 1.01]), np.array([[1.0], [3.0]])
    rate = preloaded.slip_rate(x * t, t)
    assert rate.shape == (2, 3)
    np.testing.assert_allclose(rate[0], rate[1], rtol=1e-12)
    np.testing.assert_allclose(preloaded.slip(x * t, t)[1], 3 * preloaded.slip(x, 1.0), rtol=1e-12)


@pytest.mark.parametrize("name", ["preloaded", "shock"])
def test_traction_is_continuous_and_bounded_by_friction(name, request):
    solution = request.getfixturevalue(name)
    edges = [v for z in solution.zones for v in (z.inner, z.outer) if 0 < v < np.inf]
    for edge in edges:
        below, above = solution.shear_traction(edge * np.array([1 - 1e-9, 1 + 1e-9]), 1.0)
        assert below == pytest.approx(above, abs=1e-3)  # square root of 1e-9 beside an edge
    x = np.linspace(0.01, 1.99, 500)
    assert np.all(solution.stick_margin(x, 1.0) > -1e-7)


def test_shear_traction_of_the_stuck_scene_is_the_diffracted_load(stuck):
    x = np.array([0.05, 0.5, 0.99, 1.2, 1.8])
    np.testing.assert_allclose(
        stuck.shear_traction(x, 1.0), 1 + stuck_traction(1 / 3, "II")(1 / x), rtol=1e-8
    )
    np.testing.assert_allclose(
        stuck.pressure(x, 1.0), 1 + stuck_traction(1 / 3, "I")(1 / x), rtol=1e-12
    )
    assert np.all(stuck.slip(x, 1.0) == 0)


@pytest.mark.parametrize("friction", [1.25, 1.5, 2.0])
def test_stress_intensity_is_the_limit_of_the_tractions(friction):
    solution = solve(unit_scene(friction, **REMOTE))
    x = 1e-10
    mode_one, mode_two = solution.stress_intensity(1.0)
    near = np.sqrt(2 * np.pi * x)
    # The next term is the base traction itself, smaller by sqrt(x).
    assert solution.pressure(x, 1.0) * near == pytest.approx(mode_one, rel=1e-4)
    assert solution.shear_traction(x, 1.0) * near == pytest.approx(mode_two, rel=1e-4)


def test_edge_slip_rate_is_the_limit(preloaded, stuck):
    assert preloaded.edge_slip_rate == pytest.approx(
        float(preloaded.slip_rate(1e-9, 1.0)), rel=1e-7
    )
    assert stuck.edge_slip_rate == 0


def test_energy_leaves_through_friction_alone(shock, stuck, sliding):
    """The fronts are free of singular energy flux: slip rate or stick margin vanishes beside one.

    That power is traction times slip rate over the contact is in test_totals.py.
    """
    edges = shock.edge_speeds
    for edge in edges[edges > 0]:
        distance = np.array([1e-4, 1e-6, 1e-8])
        for side in (-1, 1):
            x = edge * (1 + side * distance)
            product = np.abs(shock.slip_rate(x, 1.0) * shock.stick_margin(x, 1.0))
            assert np.all(product < 1e-9)  # one of them vanishes on either side
            concentration = np.abs(shock.shear_traction(x, 1.0)) * np.sqrt(distance)
            assert np.all(np.diff(concentration) < 0)
    assert stuck.frictional_power(1.0) == sliding.frictional_power(0.0) == 0
    assert sliding.frictional_power(1.0) == np.inf


def test_edge_speeds_are_the_edges_of_the_zones(preloaded, stuck):
    assert preloaded.edge_speeds.tolist() == [[z.inner, z.outer] for z in preloaded.zones]
    assert stuck.edge_speeds.shape == (0, 2)


def test_far_slot_faces_carry_plane_waves(shock):
    tangential, normal = shock.slot_velocity(np.array([-2.5, -9.0]), 1.0)
    np.testing.assert_allclose(tangential, 1.0, rtol=1e-12)  # Q_0 / mu b
    np.testing.assert_allclose(normal, -0.5, rtol=1e-12)  # -P_0 / rho c_l


def test_slot_and_contact_meet_with_one_velocity(preloaded):
    """x -> 0 from the slot and from the contact: the slipping edge is continuous."""
    tangential, _ = preloaded.slot_velocity(-1e-7, 1.0)
    assert 2 * float(tangential) == pytest.approx(preloaded.edge_slip_rate, rel=1e-3)


def test_history_samples_every_field(preloaded):
    x, t = np.array([0.2, 0.6, 1.0]), np.array([0.5, 1.0])
    history = preloaded.history(x, t)
    assert history.slip.shape == (2, 3)
    np.testing.assert_allclose(history.slip_rate[1], preloaded.slip_rate(x, 1.0), rtol=1e-14)
    np.testing.assert_array_equal(history.pressure, 1.0)


def test_positions_off_the_slot_are_refused(preloaded):
    with pytest.raises(SceneError, match="x < 0"):
        preloaded.slot_velocity(0.1, 1.0)
