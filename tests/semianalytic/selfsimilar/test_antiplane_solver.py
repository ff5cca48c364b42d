"""`solve` under antiplane shear: closed forms, pressure that changes, error estimates."""

from dataclasses import replace

import numpy as np
import pytest
from catalogue import REMOTE, STEEL, UNIT, unit_scene
from laws import check_invariants

from semianalytic import Material, Scene, Tractions, ViscousFriction, solve, sweep
from semianalytic.reference import (
    antiplane_edge_speed,
    antiplane_slip,
    antiplane_slip_rate,
    antiplane_traction,
    viscous_antiplane_edge_speed,
    viscous_antiplane_slip_rate,
)
from semianalytic.reference.known_answers import closed_form
from semianalytic.regimes import regime

SHARES = np.array([1e-3, 0.1, 0.5, 0.9, 0.97])
"""Shares of the speed of the zone's edge."""


def antiplane(friction, base=(1.0, 0.0), load=(0.0, 1.0), **parts):
    return unit_scene(friction, base, load, mode="antiplane", **parts)


@pytest.mark.parametrize("friction", [3.0, 0.5, 1e-3, 1e-8, 0.0])
@pytest.mark.parametrize("rtol", [1e-6, 1e-11])
def test_closed_form_at_every_strength(friction, rtol):
    solution, t = solve(antiplane(friction), rtol=rtol), 2.0
    edge = antiplane_edge_speed(UNIT, friction)
    assert solution.status == "converged"
    assert solution.zones[0].outer == pytest.approx(edge, rel=rtol)
    x = SHARES * edge * t
    rate = antiplane_slip_rate(UNIT, 1.0, friction, x / t)
    np.testing.assert_allclose(solution.slip_rate(x, t), rate, atol=rtol)
    np.testing.assert_allclose(
        solution.slip(x, t), antiplane_slip(UNIT, 1.0, friction, x, t), atol=t * rtol
    )
    ahead = np.array([edge + 0.2 * (1 - edge), 0.99, 1.5])
    traction = antiplane_traction(UNIT, 1.0, friction, ahead)
    np.testing.assert_allclose(solution.shear_traction(t * ahead, t), traction, atol=rtol)


@pytest.mark.parametrize("nu", [-0.9, 0.499])
def test_poisson_ratio_does_not_count(nu):
    one, other = solve(antiplane(0.5)), solve(antiplane(0.5, nu=nu))
    assert one.zones == other.zones
    assert one.edge_slip_rate == other.edge_slip_rate


@pytest.mark.parametrize(("base", "load"), [(0.3, 1.0), (-0.4, 1.0), (0.1, -2.0), (0.5, 0.3)])
def test_base_shear_shifts_the_strength(base, load):
    """chi_b: strength less base shear, over the load; at 0.5 the base is critical."""
    scene = Scene(
        STEEL, 0.5, Tractions(1e6, base * 1e6), Tractions(0.0, load * 1e6), mode="antiplane"
    )
    solution, known = solve(scene, rtol=1e-11), closed_form(scene)
    assert solution.zones[0].outer == pytest.approx(known.edge_speed, rel=1e-11)
    assert solution.zones[0].sense == np.sign(load)
    rate = known.slip_rate(SHARES * known.edge_speed)
    found = solution.slip_rate(SHARES * known.edge_speed, 1.0)
    np.testing.assert_allclose(found, rate, rtol=1e-9, atol=1e-11 * np.abs(rate).max())


@pytest.mark.thinned(3)
@pytest.mark.parametrize("viscosity", [0.01, 0.25, 2.0])
def test_viscous_zone(viscosity):
    scene = antiplane(0.5, friction_law=ViscousFriction(viscosity))
    solution, edge = solve(scene, rtol=1e-11), viscous_antiplane_edge_speed(UNIT, 0.5, viscosity)
    assert solution.zones[0].outer == pytest.approx(edge, rel=1e-11)
    rate = viscous_antiplane_slip_rate(UNIT, 1.0, 0.5, viscosity, SHARES * edge)
    np.testing.assert_allclose(solution.slip_rate(SHARES * edge, 1.0), rate, atol=1e-11)


@pytest.mark.parametrize("nu", [-0.5, 0.0, 1 / 3, 0.45])
def test_remote_edge_sticks_above_the_ratio_of_intensities(nu):
    """K_III/K_I = sqrt((1 - nu) c_l/c_t) for equal loads; a slipping edge has K_III = f K_I."""
    threshold = np.sqrt((1 - nu) * Material(1.0, 1.0, nu).longitudinal_speed)
    for friction, slips in ((threshold * (1 + 1e-4), False), (threshold * (1 - 1e-2), True)):
        solution = solve(antiplane(friction, **REMOTE, nu=nu))
        assert solution.status == "converged"
        assert bool(solution.zones and solution.zones[0].inner == 0) == slips
        mode_one, sheared = solution.stress_intensity(1.0)
        if slips:
            assert sheared == pytest.approx(friction * mode_one, rel=1e-12)
        elif not solution.zones:
            assert sheared == pytest.approx(2 * np.sqrt(2 / np.pi), rel=1e-11)


def test_loss_of_pressure_slips_ahead_of_the_shear_wave():
    """Pressure falls between the two fronts, where shear is still that of the base."""
    scene = antiplane(0.3, (1.0, 0.298), (1.0, 0.1))
    solution = solve(scene, rtol=1e-10)
    (zone,) = solution.zones
    assert solution.status == "converged"
    assert zone.inner < UNIT.shear_speed < zone.outer < UNIT.longitudinal_speed
    # where it opens, friction has fallen to the base shear; nothing else has arrived
    assert 0.3 * solution.pressure(zone.outer, 1.0) == pytest.approx(0.298, rel=1e-9)
    x = np.linspace(0.05, 1.95, 400)
    margin = solution.stick_margin(x, 1.0)
    assert margin.min() > -1e-9
    assert np.abs(margin[(x > zone.inner) & (x < zone.outer)]).max() < 1e-9


def random_scene(random):
    nu = random.choice([-0.5, -0.2, 0.0, 0.2, 1 / 3, 0.45])
    friction, pressure = 10 ** random.uniform(-2, 0.5), random.uniform(0, 2)
    shear = random.choice([1.0, random.uniform(-1, 1)])
    tractions = [
        {"base": (1.0, 0.0), "load": (pressure, 1.0)},
        REMOTE,
        {"base": (1.0, friction * random.uniform(-1, 1)), "load": (pressure, shear)},
        {"base": (1.0, friction), "load": (pressure, shear)},
    ][random.integers(4)]
    viscosity = random.choice([0.0, random.uniform(0, 1)])
    return antiplane(friction, **tractions, nu=nu, friction_law=ViscousFriction(viscosity))


@pytest.mark.thinned(4)
@pytest.mark.parametrize("seed", range(12))
def test_error_estimates_are_honest_under_any_load(seed):
    scene = random_scene(np.random.default_rng(seed))
    rough, fine = solve(scene, rtol=1e-5), solve(scene, rtol=1e-10)
    assert rough.status == fine.status == "converged"
    np.testing.assert_allclose(rough.edge_speeds, fine.edge_speeds, atol=rough.error_estimate)
    x = np.linspace(0.003, 2.0, 1500)
    wanted = fine.slip_rate(x, 1.0)
    difference = np.abs(rough.slip_rate(x, 1.0) - wanted).sum()
    assert difference <= rough.error_estimate * np.abs(wanted).sum() + 1e-12
    slipping = np.abs(wanted) > 1e-6 * np.abs(wanted).max(initial=0.0)
    assert fine.stick_margin(x, 1.0).min() > -1e-8
    traction = fine.shear_traction(x, 1.0)
    viscosity = scene.friction_law.viscosity
    strength = scene.friction * fine.pressure(x, 1.0) + viscosity * np.abs(wanted)
    assert np.abs(np.abs(traction) - strength)[slipping].max(initial=0.0) < 1e-8


def test_sweeps_follow_the_zone():
    frictions = np.linspace(0.2, 1.0, 9)
    swept = sweep(antiplane(0.5), frictions, rtol=1e-8)
    edges = [swept[i].zones[0].outer for i in range(len(frictions))]
    np.testing.assert_allclose(
        edges, antiplane_edge_speed(UNIT, 0.0) / (1 + frictions) ** 2, rtol=1e-8
    )


def test_slot_face_moves_as_the_transform_says():
    """v_z = Q_0/(mu b) until the shear wave of the edge; through the edge it is continuous."""
    solution = solve(antiplane(0.5), rtol=1e-10)
    along, normal = solution.slot_velocity(np.array([-1.5, -1.001, -1e-10]), 1.0)
    np.testing.assert_allclose(along[:2], 1.0, rtol=1e-12)
    assert along[2] == pytest.approx(solution.edge_slip_rate / 2, rel=1e-4)
    assert not normal.any()


@pytest.mark.parametrize("load", [(-1.0, 1.0), (60.0, 1.0)])
def test_contacts_open_as_in_plane(load):
    scene = antiplane(0.5, load=load)
    solution, in_plane = solve(scene), solve(replace(scene, mode="in-plane"))
    assert solution.status == "converged"
    assert solution.openings == in_plane.openings
    x = np.linspace(0.1, 1.9, 30)
    np.testing.assert_array_equal(solution.gap(x, 1.0), in_plane.gap(x, 1.0))
    check_invariants(scene)


@pytest.mark.parametrize(
    ("friction", "tractions", "name"),
    [
        (1e-3, {}, "slow"),
        (2.0, REMOTE, "stuck"),
        (0.5, REMOTE, "everywhere"),
        (0.3, {"base": (1.0, 0.298), "load": (1.0, 0.1)}, "one"),
    ],
)
def test_regimes_are_told_by_the_shear_wave(friction, tractions, name):
    assert regime(solve(antiplane(friction, **tractions))) == name
