"""Viscous friction: slip across the Rayleigh front, traction, energy, limits, march and sweep; and
films of any viscosity in random scenes of every mode, answered honestly or said why not."""

import numpy as np
import pytest
from catalogue import REMOTE, under, unit_scene
from laws import check_invariants, check_march_converges, viscous_scene

from semianalytic import Coulomb, SceneError, solve
from semianalytic.cut.load import scaled_load
from semianalytic.cut.quadrature.layout import Zone
from semianalytic.halfplane.rayleigh import rayleigh_factors
from semianalytic.halfplane.rules import rule_for
from semianalytic.reference.closed_forms import slip_rate_without_friction
from semianalytic.regimes import (
    closing_limit,
    closing_poisson_ratio,
    nucleation,
    regime,
    scene_of,
    viscous_closing,
)
from semianalytic.scene.given.named import NAMED_SCENES
from semianalytic.scene.scene import Material
from semianalytic.selfsimilar.zones.placement import locate_edges
from tests.semianalytic.selfsimilar.test_solution import integral, power_density, singular_speeds

VISCOUS = NAMED_SCENES["viscous"].scene
LOADED = unit_scene(0.2, (1.0, 0.1), (0.8, 1.0), nu=0.25, law=Coulomb(1.0, viscosity=0.2))


@pytest.mark.parametrize("scene", [VISCOUS, LOADED])
def test_slip_rate_is_least_and_flat_at_the_rayleigh_front(scene):
    """V'(c) = -s f p'(c) / eta = 0: pressure is least there."""
    solution, speed = solve(scene, rtol=1e-10), scene.material.rayleigh_speed
    assert any(zone.inner < speed < zone.outer for zone in solution.zones)
    step = 1e-3 * np.array([-2.0, -1.0, 0.0, 1.0, 2.0])
    rate = solution.slip_rate(speed + step, 1.0)
    assert rate[2] == rate.min() > 0
    slope = (rate[3] - rate[1]) / 2e-3
    assert abs(slope) < 1e-2 * (rate[4] - 2 * rate[2] + rate[0]) / 4e-6


@pytest.mark.thinned(2)
@pytest.mark.parametrize("scene", [VISCOUS, LOADED])
def test_traction_follows_slip_rate_and_power_is_its_product(scene):
    solution = solve(scene, rtol=1e-10)
    for zone in solution.zones:
        x = (
            zone.inner
            + (zone.outer - zone.inner) * np.sin(np.linspace(0, np.pi / 2, 402)[1:-1]) ** 2
        )
        rate, traction = solution.slip_rate(x, 1.0), solution.shear_traction(x, 1.0)
        expected = zone.sense * scene.strength(solution.pressure(x, 1.0), rate)
        np.testing.assert_allclose(traction, expected, rtol=1e-12)
    power = integral(power_density(solution), 0.0, 9.0, singular_speeds(solution))
    assert float(solution.frictional_power(1.0)) == pytest.approx(power, rel=1e-9)
    assert float(solution.frictional_power(1.0, 0.0, 9.0)) == pytest.approx(power, rel=1e-9)


@pytest.mark.slow
def test_march_converges_to_the_exact_answer():
    check_march_converges(solve(VISCOUS), (100, 200, 400, 800))


def test_little_viscosity_is_near_constant_friction():
    scene = unit_scene()
    little, constant = solve(under(scene, Coulomb(1.0, viscosity=1e-7))), solve(scene)
    np.testing.assert_allclose(little.edge_speeds, constant.edge_speeds, atol=1e-6)
    assert np.abs(little.edge_speeds - constant.edge_speeds).max() > 1e-9
    # alone it is nearly Lamb's problem
    x = np.array([0.3, 0.7, 1.2, 1.7])
    solution = solve(unit_scene(0.0, law=Coulomb(1.0, viscosity=1e-8)))
    lamb = slip_rate_without_friction(Material(1.0, 1.0, 1 / 3), 1.0, x)
    np.testing.assert_allclose(solution.slip_rate(x, 1.0), lamb, rtol=1e-6)


def test_slip_everywhere_is_balanced_by_viscosity_far_ahead():
    """f P_b + (rho c_t / 2 + viscosity) V = Q_b."""
    scene = unit_scene(0.5, **REMOTE, law=Coulomb(1.0, viscosity=0.25))
    assert scene.far_slip_rate == pytest.approx(0.5 / 0.75)
    ahead = solve(scene).shear_traction(3.0, 1.0)
    assert float(ahead) == pytest.approx(0.5 + 0.25 * scene.far_slip_rate)


@pytest.mark.slow
@pytest.mark.parametrize("viscosity", [1e-3, 0.3, 10.0])
def test_gap_closes_and_shear_front_slips_where_the_thresholds_say(viscosity):
    nu = 1 / 3
    closing, begins = viscous_closing(nu, viscosity), nucleation("preload", nu, viscosity)
    law = Coulomb(1.0, viscosity=viscosity / 2)
    seen = [
        regime(solve(under(scene_of("preload", nu, chi), law)))
        for chi in (
            closing * (1 - 1e-3),
            closing * (1 + 1e-3),
            begins * (1 - 1e-2),
            begins * (1 + 1e-2),
        )
    ]
    assert seen == ["one", "two", "two", "slow"]


@pytest.mark.slow
def test_where_the_gap_never_closes():
    assert viscous_closing(1 / 3, 0.0) is None
    assert viscous_closing(1 / 3, 1e-9) is None
    assert closing_limit(closing_poisson_ratio()) == pytest.approx(0, abs=1e-12)
    assert viscous_closing(closing_poisson_ratio() - 0.05, 100.0) is None
    assert viscous_closing(1 / 3, 1e4) == pytest.approx(closing_limit(1 / 3), rel=1e-3)


def test_slip_below_rounding_is_refused():
    """eta V is what traction exceeds friction by: slip rates fall like 1 / eta until then."""
    thick, thicker, too_thick = (
        under(VISCOUS, Coulomb(1.0, viscosity=number)) for number in (1e6, 1e8, 1e20)
    )
    x = np.linspace(0.1, 0.4, 4)
    rates = [solve(answer, rtol=1e-6).slip_rate(x, 1.0) for answer in (thick, thicker)]
    np.testing.assert_allclose(rates[0], 100 * rates[1], rtol=1e-4)
    with pytest.raises(SceneError, match=r"slip is below rounding; .* 5e\+14 \(docs/limits"):
        solve(too_thick)


# --- any viscosity ------------------------------------------------------------------------------

ANSWERED = ("converged", "the error estimate ", "no set of slip zones ")


def check_honest(exact, rtol=1e-8):
    """Laws, a clear status, and an estimate that bounds the error of slip rate in L1 and of edges.

    Whether it converged; `exact` is a solution to more digits.
    """
    scene = exact.scene
    solution = solve(scene, rtol=rtol)
    assert solution.status.startswith(ANSWERED)
    if solution.status != "converged":
        return False
    assert solution.error_estimate <= rtol
    check_invariants(scene)
    if not exact.error_estimate <= 0.1 * solution.error_estimate:
        return True  # no better than what it is to judge
    x = np.linspace(0.003, 2.0, 900)
    rate = exact.slip_rate(x, 1.0)
    error = np.abs(solution.slip_rate(x, 1.0) - rate).sum() / max(np.abs(rate).sum(), 1e-300)
    assert error <= solution.error_estimate
    if len(solution.zones) == len(exact.zones):
        moves = np.isfinite(exact.edge_speeds)
        edges = np.abs(solution.edge_speeds[moves] - exact.edge_speeds[moves])
        assert edges.max(initial=0.0) <= solution.error_estimate
    return True


@pytest.mark.parametrize(
    ("count", "answered"), [(1, 1), pytest.param(40, 38, marks=pytest.mark.slow)]
)
def test_films_are_answered_lawfully_and_honestly(count, answered):
    """Of the others the status says why not."""
    scenes = (viscous_scene(np.random.default_rng(seed)) for seed in range(count))
    assert sum(check_honest(solve(scene, rtol=1e-12)) for scene in scenes) >= answered


@pytest.mark.thinned(2)
@pytest.mark.parametrize(
    ("mode", "viscosity"),
    [("in-plane", 1e8), ("antiplane", 1e6), ("antiplane", 1e8)],
)
def test_estimates_hold_off_a_contact_edge_where_slip_rate_towers(mode, viscosity):
    law = Coulomb(1.0, viscosity=viscosity)
    scene = unit_scene(0.494, (1.0, 0.3), (0.0, 0.783), nu=-0.243, law=law, mode=mode)
    exact, x = solve(scene, rtol=1e-12), np.linspace(0.003, 2.0, 900)
    assert exact.edge_slip_rate > 100 * exact.slip_rate(x, 1.0).max()
    for rtol in (1e-5, 1e-8):
        assert check_honest(exact, rtol)


@pytest.mark.thinned(12)
@pytest.mark.parametrize("viscosity", [1e4, 1e6, 1e8])
@pytest.mark.parametrize("mode", ["in-plane", "antiplane"])
@pytest.mark.parametrize("load", [(0.0, 1.0), (0.5, 1.0)])
def test_slip_off_a_contact_edge_where_it_towers_is_the_integral_of_its_rate(load, mode, viscosity):
    """Slip at u = t/x is the mean of the slip rate up to u: 50 estimates off when it was taken as
    the difference of two integrals of which one grows with the viscosity."""
    base, law = (1.0, 0.2 if load[0] else 0.0), Coulomb(1.0, viscosity=viscosity)
    scene = unit_scene(0.3, base, load, law=law, mode=mode)
    solution = solve(scene, rtol=1e-6)
    for x in np.geomspace(0.05, 0.8, 9):
        times = sorted(x / speed for speed in singular_speeds(solution))
        slip = integral(lambda t, x=x: solution.slip_rate(x, t), 0.0, 1.0, times)
        error = abs(solution.slip(x, 1.0) - slip)
        assert error < 0.01 * solution.error_estimate * solution.max_slip(1.0)


@pytest.mark.thinned(2)
@pytest.mark.parametrize("viscosity", [1e10, 1e14])
def test_zones_under_strong_films_need_one_set(viscosity):
    scene = unit_scene(load=(0.5, 1.0), nu=0.33, law=Coulomb(1.0, viscosity=viscosity))
    loose, exact = solve(scene, rtol=1e-5), solve(scene, rtol=1e-8)
    assert loose.status == exact.status == "converged"
    assert loose.statistics.zone_sets == exact.statistics.zone_sets == 1
    assert loose.statistics.pivots < 100
    assert np.abs(loose.edge_speeds - exact.edge_speeds).max() < loose.error_estimate


def test_zones_that_rounding_made_overlap_are_given_up():
    """As one behind an opening may begin inward of its end under the strongest films."""
    scene = viscous_scene(np.random.default_rng(5))
    load, factors = scaled_load(scene)[0], rayleigh_factors(0.25)
    first, second = (
        Zone(factors.cut([left]), factors.cut([right]), sense)
        for left, right, sense in ((3.0, 5.0, 1), (4.0, 6.0, -1))
    )
    with np.errstate(invalid="ignore"):  # as the search does
        placement = locate_edges(factors, (first, second), load, rule_for(1e-4), 1e-7)
    assert not placement.converged
    assert placement.steps == 0
