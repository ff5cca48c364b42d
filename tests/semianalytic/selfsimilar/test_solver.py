"""The solver against closed forms, against itself on finer rules, and where it must refuse."""

import numpy as np
import pytest

from semianalytic import Material, Scene, SceneError, TensionError, Tractions, solve
from semianalytic.reference.closed_forms import (
    edge_speed_under_shear_step,
    slip_rate_under_remote_shock,
    slip_rate_under_shear_step,
    slip_rate_without_friction,
)
from semianalytic.regimes.reverse_slip import reverse_threshold

POISSON_RATIOS = [-0.9, -0.5, 0.0, 0.2, 1 / 3, 0.45, 0.499]


def scene(nu=1 / 3, friction=0.3, base=(1.0, 0.0), load=(0.0, 1.0)):
    return Scene(Material(1.0, 1.0, nu), friction, Tractions(*base), Tractions(*load))


PRELOADED = scene()
REMOTE = scene(friction=1.25, base=(1.0, 1.0), load=(1.0, 1.0))
MANY = {
    "two zones": PRELOADED,
    "two zones under a shock": REMOTE,
    "narrow gap around c_R": scene(friction=0.1),
    "gap of 1e-6 around c_R": scene(nu=0.2, friction=1.1, base=(1.0, 1.0), load=(1.0, 1.0)),
    "gap of 1e-9 around c_R": scene(friction=0.3, base=(0.25, 0.075), load=(1.2, 1.3)),
    "auxetic": scene(nu=-0.5, friction=0.05),
    "slip everywhere": scene(friction=0.5, base=(1.0, 1.0), load=(1.0, 1.0)),
    "backward": scene(friction=0.3, load=(0.0, -1.0)),
    "shear base released by pressure": scene(friction=0.5, base=(2.0, 0.99), load=(1.5, 0.0)),
    "both senses": scene(friction=0.2, base=(1.0, -0.19), load=(0.5, 0.6)),
}


@pytest.mark.parametrize("nu", POISSON_RATIOS)
@pytest.mark.parametrize("strength", [1.2, 2.5])
def test_one_zone_under_a_shear_step(nu, strength):
    material = Material(1.0, 1.0, nu)
    solution = solve(scene(nu, strength), rtol=1e-11)
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
    solution = solve(scene(nu, friction, (1.0, 1.0), (1.0, 1.0)), rtol=1e-11)
    exact = slip_rate_under_remote_shock(Material(1.0, 1.0, nu), 1.0, 1.0, friction, x)
    assert solution.status == "converged"
    assert np.abs(solution.slip_rate(x, 1.0) - exact).max() < 1e-11 * exact.max()


@pytest.mark.parametrize("nu", POISSON_RATIOS)
def test_lamb_surface_velocity_without_friction(nu):
    x = np.array([0.2, 0.5, 0.6, 0.85, 0.97, 1.1, 1.2])
    solution = solve(scene(nu, 0.0), rtol=1e-11)
    exact = slip_rate_without_friction(Material(1.0, 1.0, nu), 1.0, x)
    assert solution.status == "converged"
    assert np.abs(solution.slip_rate(x, 1.0) - exact).max() < 1e-11 * np.abs(exact).max()


def test_reference_values_of_the_theory():
    """theory.md section 4, one-sided V(0) to six digits."""
    for strength, edge, rate in ((1.0, 0.375, 0.293203), (0.5, 2 / 3, 0.370954)):
        solution = solve(scene(friction=strength))
        assert solution.zones[0].outer == pytest.approx(edge, rel=1e-8)
        assert solution.edge_slip_rate / 2 == pytest.approx(rate, abs=1e-6)


@pytest.mark.parametrize(
    ("nu", "width"), [(-0.5, 0.09), (-0.2, 0.027), (0.0, 0.004), (0.2, 4e-5), (1 / 3, 5e-8)]
)
def test_reverse_slip_around_the_rayleigh_front_without_friction(nu, width):
    """Relative half-widths of theory.md section 4, given there to one or two digits."""
    solution = solve(scene(nu, 0.0))
    forward, reverse, ahead = solution.zones
    speed = solution.scene.material.rayleigh_speed
    assert (forward.sense, reverse.sense, ahead.sense) == (1, -1, 1)
    assert reverse.inner == forward.outer < speed < reverse.outer == ahead.inner
    assert (reverse.outer - reverse.inner) / (2 * speed) == pytest.approx(width, rel=0.13)


@pytest.mark.parametrize("name", MANY)
def test_error_estimate_bounds_the_true_error(name):
    fine = solve(MANY[name], rtol=1e-11)
    assert fine.status == "converged"
    x = np.linspace(0.02, 1.95, 300)
    scale = np.abs(fine.slip_rate(x, 1.0)).max()
    for rtol in (1e-3, 1e-5, 1e-8):
        solution = solve(MANY[name], rtol=rtol)
        assert solution.status == "converged"
        assert solution.error_estimate <= rtol
        assert [z.sense for z in solution.zones] == [z.sense for z in fine.zones]
        edges = [
            abs(p - q)
            for one, other in zip(solution.zones, fine.zones, strict=True)
            for p, q in ((one.inner, other.inner), (one.outer, other.outer))
            if np.isfinite(p)
        ]
        assert max(edges) <= solution.error_estimate
        # The logarithm at c_R and the square roots at edges amplify a shift of the edge; the
        # estimate is for the slip rate away from them by more than the shift itself.
        fronts = [1.0, fine.scene.material.rayleigh_speed]
        fronts += [v for zone in fine.zones for v in (zone.inner, zone.outer)]
        clear = np.min(np.abs(x[:, None] - np.array(fronts)), axis=1) > 0.01
        error = np.abs(solution.slip_rate(x, 1.0) - fine.slip_rate(x, 1.0))[clear].max() / scale
        assert error <= solution.error_estimate


@pytest.mark.parametrize(("nu", "friction"), [(0.25, 0.05), (1 / 3, 0.04), (-0.5, 0.05)])
def test_critical_base_slips_from_the_longitudinal_front_against_the_step(nu, friction):
    """Where friction is reached ahead of all waves a zone starts at c_l, however little it is."""
    solution = solve(scene(nu, friction, (1.0, friction), (0.6, -1.3)), rtol=1e-9)
    ahead = solution.zones[-1]
    assert solution.status == "converged"
    assert (ahead.sense, ahead.outer) == (1, solution.scene.material.longitudinal_speed)
    assert solution.zones[0].sense == -1


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-8, 1e-10])
def test_strip_between_two_nodes_is_seen(rtol):
    """0.011 c_t wide, in a gap that sticks by all nodes of the rules for 1e-6 and 1e-8."""
    solution = solve(scene(-0.586, 0.0626, (1.0, -0.0361828), (0.0, -1.75)), rtol=rtol)
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
    stuck = solve(scene(friction=np.sqrt(2) * 1.001, base=(1.0, 1.0), load=(1.0, 1.0)))
    slips = solve(scene(friction=np.sqrt(2) * 0.995, base=(1.0, 1.0), load=(1.0, 1.0)))
    assert stuck.zones == ()
    assert slips.zones[0].inner == 0.0
    assert slips.zones[0].outer < 0.1


def test_sense_follows_the_load():
    forward, backward = solve(PRELOADED), solve(MANY["backward"])
    for one, other in zip(forward.zones, backward.zones, strict=True):
        assert (one.inner, one.outer, one.sense) == (other.inner, other.outer, -other.sense)
    x = np.linspace(0.1, 1.9, 7)
    np.testing.assert_allclose(forward.slip_rate(x, 1.0), -backward.slip_rate(x, 1.0), atol=1e-14)


def test_units_do_not_matter():
    steel = Material(80e9, 7800.0, 1 / 3)
    solution = solve(Scene(steel, 0.3, Tractions(5e6, 0.0), Tractions(0.0, 5e6)))
    unit = solve(PRELOADED)
    speed = steel.shear_speed
    for one, other in zip(solution.zones, unit.zones, strict=True):
        assert one.outer == pytest.approx(other.outer * speed, rel=1e-12)
    rate = solution.slip_rate(0.5 * speed * 1e-3, 1e-3)
    assert rate == pytest.approx(unit.slip_rate(0.5, 1.0) * 5e6 / steel.shear_impedance, rel=1e-12)


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


def test_tension_names_the_place():
    with pytest.raises(TensionError, match=r"Rayleigh front.*finite elements \(docs/limits"):
        solve(scene(friction=1.0, base=(0.0, 0.0), load=(1.0, 1.0)))
    with pytest.raises(TensionError, match=r"edge x = 0.*finite elements \(docs/limits"):
        solve(scene(friction=1.0, base=(1.0, 0.0), load=(-0.5, 0.0)))


@pytest.mark.parametrize("excess", [1e-3, 1e-5])
def test_narrow_zone_at_the_edge_just_below_its_threshold(excess):
    """The zone is about 8 (1 - chi / sqrt(b/a)) c_t wide: seen by K_II > f K_I, not by nodes."""
    friction = np.sqrt(2) * (1 - excess)
    (zone,) = solve(scene(friction=friction, base=(1.0, 1.0), load=(1.0, 1.0))).zones
    assert zone.inner == 0.0
    assert zone.outer == pytest.approx(8 * excess, rel=0.01)


def test_slip_rate_at_the_rayleigh_front_itself_is_finite():
    """Inside a zone that covers c_R, where the gap is narrower than rounding."""
    solution = solve(scene(friction=1.1, base=(1.0, 1.0), load=(1.0, 1.0)))
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
    limit = scene(nu=0.25, friction=1.31607255659514, base=(1.0, 1.0), load=(1.0, 1.0))
    solution = solve(limit)
    assert solution.status == "converged" or "no set of slip zones" in solution.status


@pytest.mark.parametrize("nu", [-0.2, 0.0, 0.1])
def test_reversed_strip_just_below_its_threshold_is_not_missed(nu):
    """In the stick gap around c_R the traction misses -f p by little of the load, not of f p."""
    threshold = reverse_threshold(nu)
    for share, senses in ((0.98, [1, -1, 1]), (1.02, [1, 1])):
        solution = solve(scene(nu, share * threshold), rtol=1e-6)
        assert [zone.sense for zone in solution.zones] == senses


@pytest.mark.parametrize("rtol", [1e-3, 1e-5, 1e-6, 1e-8, 1e-10])
def test_zone_that_shrinks_to_nothing_ends_in_a_status(rtol):
    """8e-6 below the threshold of the edge, where Newton walks into a zone without width."""
    solid, load = Material(1.0, 1.0, 0.247), Tractions(1.0, 1.0)
    solution = solve(Scene(solid, 1.313454840748274, load, load), rtol=rtol)
    assert solution.status != "converged" or solution.error_estimate <= rtol
    assert solution.error_estimate > 0
