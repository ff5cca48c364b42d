"""The solver against closed forms, against itself on finer rules, and where it must refuse;
in plane and under antiplane shear."""

from dataclasses import replace

import numpy as np
import pytest
from catalogue import PRELOADED, REMOTE, STEEL, UNIT, under, unit_scene
from laws import check_invariants, viscous_scene

import semianalytic as sf
from semianalytic.reference import (
    antiplane_edge_speed,
    antiplane_slip,
    antiplane_slip_rate,
    antiplane_traction,
    edge_speed_under_shear_step,
    slip_rate_under_remote_shock,
    slip_rate_under_shear_step,
    slip_rate_without_friction,
    viscous_edge_speed,
    viscous_slip_rate,
)
from semianalytic.regimes import regime
from tests.semianalytic.selfsimilar.films.test_viscous import check_honest

KNOWN = {
    "one zone under a shear step": unit_scene(1.2),
    "one zone under a shear step, strong": unit_scene(2.5),
    "slip everywhere under a remote shock": unit_scene(0.9, **REMOTE),
    "slip everywhere under a remote shock, weak": unit_scene(0.3, **REMOTE),
    "Lamb's velocity without friction": unit_scene(0.0),
}


def closed_form(scene, x):
    """Edge speed (None where all slips), velocities x/t and slip rates of a scene of `KNOWN`."""
    material, friction, load = scene.material, scene.friction, scene.load
    if load.pressure:
        rate = slip_rate_under_remote_shock(material, load.pressure, load.shear, friction, x)
    elif friction:
        ratio = friction * scene.base.pressure / load.shear
        edge = edge_speed_under_shear_step(material, ratio)
        x = np.append(x, edge * np.array([0.01, 0.3, 0.7, 0.95]))
        return edge, x, slip_rate_under_shear_step(material, load.shear, ratio, x)
    else:
        rate = slip_rate_without_friction(material, load.shear, x)
    return None, x, rate


@pytest.mark.thinned(2)
@pytest.mark.parametrize("nu", [-0.9, -0.5, 0.0, 0.2, 1 / 3, 0.45, 0.499])
@pytest.mark.parametrize("name", KNOWN)
def test_closed_forms_are_met(name, nu):
    """Also in units of length, stress and time that are not 1."""
    scale, solid = 1.5, sf.Material(2.0, 3.0, nu)
    base, load = (
        sf.Tractions(scale * traction.pressure, scale * traction.shear)
        for traction in (KNOWN[name].base, KNOWN[name].load)
    )
    scene = replace(KNOWN[name], material=solid, base=base, load=load)
    solution = sf.solve(scene, rtol=1e-11)
    assert solution.status == "converged"
    shares = np.array([0.03, 0.2, 0.3, 0.5, 0.6, 0.85, 0.9, 0.97, 1.1, 1.2, 1.3, 1.6])
    edge, x, exact = closed_form(scene, shares * solid.shear_speed)
    assert (edge is None) == ("one zone" not in name)
    if edge is not None:
        assert [zone.sense for zone in solution.zones] == [1]
        assert solution.zones[0].outer == pytest.approx(edge, rel=1e-11)
    error = np.abs(solution.slip_rate(x, 1.0) - exact).max() / np.abs(exact).max()
    assert error < 1e-11
    assert error <= solution.error_estimate


@pytest.mark.parametrize(
    ("nu", "width"), [(-0.5, 0.09), (-0.2, 0.027), (0.0, 0.004), (0.2, 4e-5), (1 / 3, 5e-8)]
)
def test_reverse_slip_around_the_rayleigh_front_without_friction(nu, width):
    """Relative half-widths of theory.md section 4, given there to one or two digits."""
    solution = sf.solve(unit_scene(0.0, nu=nu))
    forward, reverse, ahead = solution.zones
    speed = solution.scene.material.rayleigh_speed
    assert (forward.sense, reverse.sense, ahead.sense) == (1, -1, 1)
    assert reverse.inner == forward.outer < speed < reverse.outer == ahead.inner
    assert (reverse.outer - reverse.inner) / (2 * speed) == pytest.approx(width, rel=0.13)


@pytest.mark.parametrize(("nu", "friction"), [(0.25, 0.05), (1 / 3, 0.04), (-0.5, 0.05)])
def test_critical_base_slips_from_the_longitudinal_front_against_the_step(nu, friction):
    """Where friction is reached ahead of all waves a zone starts at c_l, however little it is."""
    solution = sf.solve(unit_scene(friction, (1.0, friction), (0.6, -1.3), nu=nu), rtol=1e-9)
    ahead = solution.zones[-1]
    assert solution.status == "converged"
    assert (ahead.sense, ahead.outer) == (1, solution.scene.material.longitudinal_speed)
    assert solution.zones[0].sense == -1


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-8, 1e-10])
def test_strip_between_two_nodes_is_seen(rtol):
    """0.011 c_t wide, in a gap that sticks by all nodes of the rules for 1e-6 and 1e-8."""
    solution = sf.solve(unit_scene(0.0626, (1.0, -0.0361828), (0.0, -1.75), nu=-0.586), rtol=rtol)
    assert solution.status == "converged"
    assert [zone.sense for zone in solution.zones] == [-1, 1, -1]
    strip = solution.zones[1]
    np.testing.assert_allclose(
        [strip.inner, strip.outer], [0.75249524, 0.76381973], atol=rtol + 1e-8
    )


def test_second_zone_runs_ahead_of_the_shear_wave():
    inner, outer = sf.solve(PRELOADED).zones
    speed = PRELOADED.material.rayleigh_speed
    assert inner.inner == 0.0
    assert inner.outer < speed < outer.inner < 1.0 < outer.outer < 2.0


def test_edge_sticks_above_the_ratio_of_wave_speeds():
    """Remote load: the edge sticks iff chi >= sqrt(b/a) = sqrt 2 at nu = 1/3."""
    stuck = sf.solve(unit_scene(np.sqrt(2) * 1.001, **REMOTE))
    slips = sf.solve(unit_scene(np.sqrt(2) * 0.995, **REMOTE))
    assert stuck.zones == ()
    assert slips.zones[0].inner == 0.0
    assert slips.zones[0].outer < 0.1


@pytest.mark.parametrize("rtol", [1e-13, 0.1, float("nan")])
def test_rtol_out_of_range(rtol):
    with pytest.raises(sf.SceneError, match="rtol"):
        sf.solve(PRELOADED, rtol=rtol)


def test_tension_says_what_would_hold_the_contact():
    for step in (1.0, -0.5):
        with pytest.raises(
            sf.TensionError, match=r"nothing holds .* far ahead; .*positive.*\(docs/limits"
        ):
            sf.solve(unit_scene(1.0, (0.0, 0.0), (step, 1.0)))


def test_slip_rate_at_the_rayleigh_front_itself_is_finite():
    """Inside a zone that covers c_R, where the gap is narrower than rounding."""
    solution = sf.solve(unit_scene(1.1, **REMOTE))
    speed = solution.scene.material.rayleigh_speed
    assert solution.zones[0].outer > speed
    assert np.isfinite(solution.slip_rate(speed, 1.0))


@pytest.mark.parametrize("distance", [1e-5, 1e-7, 1e-9])
def test_nearly_incompressible(distance):
    """c_l / c_t up to 22,000."""
    material = sf.Material(1.0, 1.0, 0.5 - distance)
    solution = sf.solve(unit_scene(1.0, nu=material.poisson_ratio), rtol=1e-9)
    edge = edge_speed_under_shear_step(material, 1.0)
    assert abs(solution.zones[0].outer / edge - 1) <= solution.error_estimate


@pytest.mark.thinned(3)
@pytest.mark.parametrize(
    ("nu", "friction", "rtol"),
    [
        (0.25, 1.31607255659514, 1e-8),
        *((0.247, 1.313454840748274, rtol) for rtol in (1e-3, 1e-5, 1e-6, 1e-8, 1e-10)),
    ],
)
def test_a_threshold_scene_has_a_status_not_a_wrong_curve(nu, friction, rtol):
    """2e-7 and 8e-6 below the threshold of the edge: Newton walks into a zone without width."""
    solution = sf.solve(unit_scene(friction, **REMOTE, nu=nu), rtol=rtol)
    assert solution.error_estimate > 0
    if solution.status == "converged":
        assert solution.error_estimate <= rtol
    else:
        assert "no set of slip zones" in solution.status


# --- antiplane shear: closed forms, pressure that changes, error estimates ------------------------


SHARES = np.array([1e-3, 0.1, 0.5, 0.9, 0.97])
"""Shares of the speed of the zone's edge."""


def antiplane(friction, base=(1.0, 0.0), load=(0.0, 1.0), **parts):
    return unit_scene(friction, base, load, mode="antiplane", **parts)


@pytest.mark.thinned(3)
@pytest.mark.parametrize("friction", [3.0, 0.5, 1e-3, 1e-8, 0.0])
@pytest.mark.parametrize("rtol", [1e-6, 1e-11])
def test_closed_form_at_every_strength(friction, rtol):
    solution, t = sf.solve(antiplane(friction), rtol=rtol), 2.0
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


@pytest.mark.parametrize(("base", "load"), [(0.3, 1.0), (-0.4, 1.0), (0.1, -2.0), (0.5, 0.3)])
def test_base_shear_shifts_the_strength(base, load):
    """chi_b: strength less base shear, over the load; at 0.5 the base is critical."""
    scene = sf.Scene(
        STEEL, 0.5, sf.Tractions(1e6, base * 1e6), sf.Tractions(0.0, load * 1e6), mode="antiplane"
    )
    solution, shear = sf.solve(scene, rtol=1e-11), load * 1e6
    ratio = (0.5 - np.sign(load) * base) / abs(load)
    edge = antiplane_edge_speed(STEEL, ratio)
    assert solution.zones[0].outer == pytest.approx(edge, rel=1e-11)
    assert solution.zones[0].sense == np.sign(load)
    rate = antiplane_slip_rate(STEEL, shear, ratio, SHARES * edge)
    found = solution.slip_rate(SHARES * edge, 1.0)
    np.testing.assert_allclose(found, rate, rtol=1e-9, atol=1e-11 * np.abs(rate).max())


@pytest.mark.thinned(3)
@pytest.mark.parametrize("viscosity", [0.01, 0.25, 2.0])
def test_viscous_zone(viscosity):
    scene = antiplane(0.5, law=sf.Coulomb(1.0, viscosity=viscosity))
    solution, edge = sf.solve(scene, rtol=1e-11), viscous_edge_speed(UNIT, 0.5, viscosity, "III")
    assert solution.zones[0].outer == pytest.approx(edge, rel=1e-11)
    rate = viscous_slip_rate(UNIT, 1.0, 0.5, viscosity, SHARES * edge, "III")
    np.testing.assert_allclose(solution.slip_rate(SHARES * edge, 1.0), rate, atol=1e-11)


@pytest.mark.parametrize("nu", [-0.5, 0.0, 1 / 3, 0.45])
def test_remote_edge_sticks_above_the_ratio_of_intensities(nu):
    """K_III/K_I = sqrt((1 - nu) c_l/c_t) for equal loads; a slipping edge has K_III = f K_I."""
    threshold = np.sqrt((1 - nu) * sf.Material(1.0, 1.0, nu).longitudinal_speed)
    for friction, slips in ((threshold * (1 + 1e-4), False), (threshold * (1 - 1e-2), True)):
        solution = sf.solve(antiplane(friction, **REMOTE, nu=nu))
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
    solution = sf.solve(scene, rtol=1e-10)
    (zone,) = solution.zones
    assert solution.status == "converged"
    assert zone.inner < UNIT.shear_speed < zone.outer < UNIT.longitudinal_speed
    # where it opens, friction has fallen to the base shear; nothing else has arrived
    assert 0.3 * solution.pressure(zone.outer, 1.0) == pytest.approx(0.298, rel=1e-9)
    x = np.linspace(0.05, 1.95, 400)
    margin = solution.stick_margin(x, 1.0)
    assert margin.min() > -1e-9
    assert np.abs(margin[(x > zone.inner) & (x < zone.outer)]).max() < 1e-9


@pytest.mark.thinned(4)
@pytest.mark.parametrize("seed", range(12))
def test_error_estimates_are_honest_under_any_load(seed):
    random = np.random.default_rng(seed)
    law = sf.Coulomb(1.0, viscosity=random.choice([0.0, random.uniform(0, 1)]))
    scene = under(replace(viscous_scene(random), mode="antiplane"), law)
    assert check_honest(sf.solve(scene, rtol=1e-10), 1e-5)


@pytest.mark.parametrize("load", [(-1.0, 1.0), (60.0, 1.0)])
def test_contacts_open_as_in_plane(load):
    scene = antiplane(0.5, load=load)
    solution, in_plane = sf.solve(scene), sf.solve(replace(scene, mode="in-plane"))
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
    assert regime(sf.solve(antiplane(friction, **tractions))) == name
