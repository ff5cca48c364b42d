"""The solver against closed forms, against itself on finer rules, and where it must refuse."""

import numpy as np
import pytest
from catalogue import PRELOADED, REMOTE, unit_scene

from semianalytic import Material, Scene, SceneError, TensionError, Tractions, solve
from semianalytic.reference import (
    edge_speed_under_shear_step,
    slip_rate_under_remote_shock,
    slip_rate_under_shear_step,
    slip_rate_without_friction,
)
from semianalytic.regimes import reverse_threshold

POISSON_RATIOS = [-0.9, -0.5, 0.0, 0.2, 1 / 3, 0.45, 0.499]


@pytest.mark.parametrize("nu", POISSON_RATIOS)
@pytest.mark.parametrize("strength", [1.2, 2.5])
def test_one_zone_under_a_shear_step(nu, strength):
    material = Material(1.0, 1.0, nu)
    solution = solve(unit_scene(strength, nu=nu), rtol=1e-11)
    edge = edge_speed_under_shear_step(material, strength)
    x = edge * np.array([0.01, 0.3, 0.7, 0.95])
    exact = slip_rate_under_shear_step(material, 1.0, strength, x)
    assert solution.status == "converged"
    assert [zone.sense for zone in solution.zones] == [1]
    assert solution.zones[0].outer == pytest.approx(edge, rel=1e-11)
    error = np.abs(solution.slip_rate(x, 1.0) - exact).max() / exact.max()
    assert error < 1e-11
    assert error <= solution.error_estimate


@pytest.mark.parametrize("nu", POISSON_RATIOS)
@pytest.mark.parametrize("friction", [0.9, 0.3])
def test_slip_everywhere_under_a_remote_shock(nu, friction):
    x = np.array([0.3, 0.9, 1.1, 1.3])
    solution = solve(unit_scene(friction, **REMOTE, nu=nu), rtol=1e-11)
    exact = slip_rate_under_remote_shock(Material(1.0, 1.0, nu), 1.0, 1.0, friction, x)
    assert solution.status == "converged"
    assert np.abs(solution.slip_rate(x, 1.0) - exact).max() < 1e-11 * exact.max()


@pytest.mark.parametrize("nu", POISSON_RATIOS)
def test_lamb_surface_velocity_without_friction(nu):
    x = np.array([0.2, 0.5, 0.6, 0.85, 0.97, 1.1, 1.2])
    solution = solve(unit_scene(0.0, nu=nu), rtol=1e-11)
    exact = slip_rate_without_friction(Material(1.0, 1.0, nu), 1.0, x)
    assert solution.status == "converged"
    assert np.abs(solution.slip_rate(x, 1.0) - exact).max() < 1e-11 * np.abs(exact).max()


@pytest.mark.parametrize(
    ("nu", "width"), [(-0.5, 0.09), (-0.2, 0.027), (0.0, 0.004), (0.2, 4e-5), (1 / 3, 5e-8)]
)
def test_reverse_slip_around_the_rayleigh_front_without_friction(nu, width):
    """Relative half-widths of theory.md section 4, given there to one or two digits."""
    solution = solve(unit_scene(0.0, nu=nu))
    forward, reverse, ahead = solution.zones
    speed = solution.scene.material.rayleigh_speed
    assert (forward.sense, reverse.sense, ahead.sense) == (1, -1, 1)
    assert reverse.inner == forward.outer < speed < reverse.outer == ahead.inner
    assert (reverse.outer - reverse.inner) / (2 * speed) == pytest.approx(width, rel=0.13)


@pytest.mark.parametrize(("nu", "friction"), [(0.25, 0.05), (1 / 3, 0.04), (-0.5, 0.05)])
def test_critical_base_slips_from_the_longitudinal_front_against_the_step(nu, friction):
    """Where friction is reached ahead of all waves a zone starts at c_l, however little it is."""
    solution = solve(unit_scene(friction, (1.0, friction), (0.6, -1.3), nu=nu), rtol=1e-9)
    ahead = solution.zones[-1]
    assert solution.status == "converged"
    assert (ahead.sense, ahead.outer) == (1, solution.scene.material.longitudinal_speed)
    assert solution.zones[0].sense == -1


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-8, 1e-10])
def test_strip_between_two_nodes_is_seen(rtol):
    """0.011 c_t wide, in a gap that sticks by all nodes of the rules for 1e-6 and 1e-8."""
    solution = solve(unit_scene(0.0626, (1.0, -0.0361828), (0.0, -1.75), nu=-0.586), rtol=rtol)
    assert solution.status == "converged"
    assert [zone.sense for zone in solution.zones] == [-1, 1, -1]
    strip = solution.zones[1]
    np.testing.assert_allclose(
        [strip.inner, strip.outer], [0.75249524, 0.76381973], atol=rtol + 1e-8
    )


def test_second_zone_runs_ahead_of_the_shear_wave():
    inner, outer = solve(PRELOADED).zones
    speed = PRELOADED.material.rayleigh_speed
    assert inner.inner == 0.0
    assert inner.outer < speed < outer.inner < 1.0 < outer.outer < 2.0


def test_edge_sticks_above_the_ratio_of_wave_speeds():
    """Remote load: the edge sticks iff chi >= sqrt(b/a) = sqrt 2 at nu = 1/3."""
    stuck = solve(unit_scene(np.sqrt(2) * 1.001, **REMOTE))
    slips = solve(unit_scene(np.sqrt(2) * 0.995, **REMOTE))
    assert stuck.zones == ()
    assert slips.zones[0].inner == 0.0
    assert slips.zones[0].outer < 0.1


def test_statistics_tell_what_was_done():
    statistics = solve(PRELOADED).statistics
    assert statistics.unknowns == 3
    assert statistics.pivots > 0
    assert statistics.newton_steps > 0
    assert statistics.zone_sets >= 1
    assert statistics.nodes > 0
    assert set(statistics.seconds) == {"zones", "edges", "check"}


@pytest.mark.parametrize("rtol", [1e-13, 0.1, float("nan")])
def test_rtol_out_of_range(rtol):
    with pytest.raises(SceneError, match="rtol"):
        solve(PRELOADED, rtol=rtol)


def test_tension_says_what_would_hold_the_contact():
    for step in (1.0, -0.5):
        with pytest.raises(TensionError, match=r"holds .* far ahead; .*positive.*\(docs/limits"):
            solve(unit_scene(1.0, (0.0, 0.0), (step, 1.0)))


@pytest.mark.parametrize("excess", [1e-3, 1e-5])
def test_narrow_zone_at_the_edge_just_below_its_threshold(excess):
    """The zone is about 8 (1 - chi / sqrt(b/a)) c_t wide: seen by K_II > f K_I, not by nodes."""
    friction = np.sqrt(2) * (1 - excess)
    (zone,) = solve(unit_scene(friction, **REMOTE)).zones
    assert zone.inner == 0.0
    assert zone.outer == pytest.approx(8 * excess, rel=0.01)


def test_slip_rate_at_the_rayleigh_front_itself_is_finite():
    """Inside a zone that covers c_R, where the gap is narrower than rounding."""
    solution = solve(unit_scene(1.1, **REMOTE))
    speed = solution.scene.material.rayleigh_speed
    assert solution.zones[0].outer > speed
    assert np.isfinite(solution.slip_rate(speed, 1.0))


@pytest.mark.parametrize("distance", [1e-5, 1e-7, 1e-9])
def test_nearly_incompressible(distance):
    """c_l / c_t up to 22,000."""
    material = Material(1.0, 1.0, 0.5 - distance)
    solution = solve(Scene(material, 1.0, Tractions(1.0, 0.0), Tractions(0.0, 1.0)), rtol=1e-9)
    edge = edge_speed_under_shear_step(material, 1.0)
    assert abs(solution.zones[0].outer / edge - 1) <= solution.error_estimate


def test_a_threshold_scene_has_a_status_not_a_wrong_curve():
    """Within 2e-7 of the edge threshold a zone of width 1e-5 cannot be settled: it says so."""
    limit = unit_scene(1.31607255659514, **REMOTE, nu=0.25)
    solution = solve(limit)
    assert solution.status == "converged" or "no set of slip zones" in solution.status


@pytest.mark.parametrize("nu", [-0.2, 0.0, 0.1])
def test_reversed_strip_just_below_its_threshold_is_not_missed(nu):
    """In the stick gap around c_R the traction misses -f p by little of the load, not of f p."""
    threshold = reverse_threshold(nu)
    for share, senses in ((0.98, [1, -1, 1]), (1.02, [1, 1])):
        solution = solve(unit_scene(share * threshold, nu=nu), rtol=1e-6)
        assert [zone.sense for zone in solution.zones] == senses


@pytest.mark.thinned(3)
@pytest.mark.parametrize("rtol", [1e-3, 1e-5, 1e-6, 1e-8, 1e-10])
def test_zone_that_shrinks_to_nothing_ends_in_a_status(rtol):
    """8e-6 below the threshold of the edge, where Newton walks into a zone without width."""
    solution = solve(unit_scene(1.313454840748274, **REMOTE, nu=0.247), rtol=rtol)
    assert solution.status != "converged" or solution.error_estimate <= rtol
    assert solution.error_estimate > 0
