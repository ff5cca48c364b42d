"""Strength that depends on slip rate: Newton's method, what it agrees with, what it refuses."""

from itertools import product

import numpy as np
import pytest
from catalogue import REMOTE, under, unit_scene
from laws import check_march_converges

from semianalytic import Coulomb, RateWeakening, SceneError
from semianalytic.selfsimilar.rated import approach, newton
from semianalytic.selfsimilar.rated.approach import approached, settled_zones, unsettled
from semianalytic.selfsimilar.rated.law import unit_law
from semianalytic.selfsimilar.rated.newton import rated_zones
from semianalytic.selfsimilar.solver import solve
from semianalytic.selfsimilar.zones import tuning
from semianalytic.selfsimilar.zones.placement import polish_edges

ONE_ZONE = unit_scene(1.0, law=RateWeakening(1.0, 0.6, 1.0))


def dry(scene):
    return solve(under(scene, Coulomb(1.0)))


def test_newtons_method_converges_quadratically():
    start = dry(ONE_ZONE)
    zones = start.profile.fields.zones
    rated = rated_zones(start.profile, zones, unit_law(ONE_ZONE, start.stress_unit), 1e-6)
    assert rated.converged
    _, first, second, *_ = rated.moves
    assert first > 1e-5
    assert second < 10 * first**2


@pytest.mark.thinned(3)
@pytest.mark.parametrize(
    "scene",
    [
        ONE_ZONE,
        unit_scene(law=RateWeakening(1.0, 0.6, 1.0)),
        unit_scene(0.5, law=RateWeakening(1.0, 0.7, 1.0), mode="antiplane"),
    ],
    ids=["one zone", "two zones", "antiplane"],
)
def test_strength_and_slip_rate_agree_and_the_error_is_honest(scene):
    fine, loose = solve(scene, rtol=1e-7), solve(scene, rtol=1e-4)
    assert fine.status == loose.status == "converged"
    shift = np.abs(fine.edge_speeds - loose.edge_speeds).max()
    assert shift <= loose.error_estimate
    x = np.linspace(0.02, 1.95, 200)
    rate, traction = fine.slip_rate(x, 1.0), fine.shear_traction(x, 1.0)
    strength = scene.strength(1.0, rate)
    np.testing.assert_allclose(traction[rate > 0], strength[rate > 0], rtol=1e-12)
    assert np.all(np.abs(traction) <= strength + 1e-6)
    assert np.all(rate >= 0)
    more = fine.accumulated_slip(1.0) / dry(scene).accumulated_slip(1.0)
    assert 1.01 < float(more) < 1.5


@pytest.mark.thinned(2)
@pytest.mark.parametrize("mode", ["in-plane", "antiplane"])
def test_march_converges_to_the_answer(mode):
    scene = unit_scene(1.0, law=RateWeakening(1.0, 0.6, 4.0), mode=mode)
    check_march_converges(solve(scene, rtol=1e-6), (50, 100, 200, 400))


def test_weakening_across_the_rayleigh_front_is_refused():
    law = RateWeakening(1.0, 0.8, 5.0)
    for scene in (
        unit_scene(0.5, **REMOTE, law=law),
        unit_scene(0.3, (1.0, 0.295), (1.0, 0.0), law=law),
    ):
        with pytest.raises(SceneError, match="cover the Rayleigh front"):
            solve(scene)
    # pressure makes it steeper than radiation
    scene = unit_scene(1.0, (1.0, 0.0), (0.5, 1.5), law=RateWeakening(1.0, 0.55, 1.0))
    with pytest.raises(SceneError, match="makes pressure infinite at the contact edge"):
        solve(scene)


@pytest.mark.parametrize("mode", ["in-plane", "antiplane"])
@pytest.mark.parametrize("rtol", [1e-6, 1e-10])
def test_what_sticks_does_not_weaken(mode, rtol):
    law = RateWeakening(1.0, 0.9, 1.0)
    scene = unit_scene(3.0, (1.0, 0.0), (1.0, 1.0), law=law, mode=mode)
    stuck = solve(scene, rtol=rtol)
    assert (stuck.zones, stuck.status, stuck.scene) == ((), "converged", scene)


@pytest.mark.slow
def test_slip_rate_too_steep_for_any_rule_is_said():
    law = RateWeakening(1.0, 0.73785, 0.0193459)
    solution = solve(unit_scene(0.03417, (1.0, 0.0), (0.0, 0.1357), law=law), rtol=1e-5)
    assert "rises like the power 0.05" in solution.status
    assert "a zone edge near x/t = 0.92" in solution.status
    assert solution.error_estimate == np.inf


@pytest.mark.slow
@pytest.mark.parametrize(
    ("nu", "friction", "reduction", "load", "answered"),
    [  # zone edges pass the shear front on the way, and leave the nodes of slip rate behind
        *((1 / 3, 0.33, *case, True) for case in product((0.314, 0.4), (-10.4, 10.1))),
        # a zone edge comes so close to c_R that slip rate has the power 0 beside it
        (0.25, 0.6, 0.314, -10.4, False),
        (1 / 3, 0.05, 0.314, -10.4, False),
    ],
)
def test_falling_friction_is_answered_or_refused(nu, friction, reduction, load, answered):
    law = RateWeakening(1.0, 0.67, reduction)
    scene = unit_scene(friction, (0.13, 0.0), (0.0, load), nu=nu, law=law)
    solution = solve(scene, rtol=1e-5 if answered else 1e-8)
    refused = "which no rule resolves" in solution.status
    assert refused or (answered and solution.zones and solution.status == "converged")


@pytest.fixture
def fields(monkeypatch):
    """How many fields each call of `polish_edges` computes."""
    counts = []

    def polished(*given):
        found = polish_edges(*given)
        counts.append(1 + found[0].steps)
        return found

    monkeypatch.setattr(newton, "polish_edges", polished)
    return counts


@pytest.mark.slow
def test_slip_rate_that_no_step_makes_less_steep_is_given_up_at_once(monkeypatch, fields):
    """Draw 2747 of the campaign: weak friction leaves 1e-10 of stick around c_R, beside which even
    a part of the law is too steep; five more steps took a minute."""
    calls = []

    def counted(*given):
        calls.append(rated_zones(*given))
        return calls[-1]

    monkeypatch.setattr(approach, "rated_zones", counted)
    law = RateWeakening(1.0, 0.4326842190556096, 2.021263565484365)
    base = (0.8160586945782151, 0.0011639241467299353)
    friction, nu = 0.0014262750393603937, 0.41993813926217527
    solution = solve(unit_scene(friction, base, nu=nu, law=law), rtol=1e-5)
    assert "which no rule resolves" in solution.status
    assert len(calls) == 1
    assert sum(fields) <= tuning.MOST_RATE_FIELDS


def test_fields_without_end_are_given_up(monkeypatch, fields):
    """However many the iterations would take."""
    monkeypatch.setattr(tuning, "MOST_RATE_FIELDS", 6)
    start = dry(ONE_ZONE)
    law = unit_law(ONE_ZONE, start.stress_unit)
    assert not rated_zones(start.profile, start.profile.fields.zones, law, 1e-6).converged
    assert 6 <= sum(fields) <= 6 + tuning.MOST_BROYDEN_STEPS


def test_steps_of_the_share_lead_where_the_whole_law_at_once_does_not(monkeypatch):
    start = dry(ONE_ZONE)
    law, tried = unit_law(ONE_ZONE, start.stress_unit), []

    def settled(profile, towards, tolerance, speed):
        reached = tried[-1] if tried else 0.0
        if towards.share - reached > 0.3:
            return None
        tried.append(towards.share)
        return settled_zones(profile, towards, tolerance, speed)

    monkeypatch.setattr(approach, "settled_zones", settled)
    rated, last = approached(start.profile, law, 1e-5, 1.0)
    assert tried == [0.25, 0.5, 0.75, 1.0]
    assert rated.profile is last
    at_once = settled_zones(start.profile, law, 1e-5, 1.0)
    np.testing.assert_allclose(rated.placement.unknowns, at_once.placement.unknowns, atol=1e-6)


def test_where_no_step_leads_the_last_profile_is_left(monkeypatch):
    start = dry(ONE_ZONE)
    law = unit_law(ONE_ZONE, start.stress_unit)
    monkeypatch.setattr(approach, "settled_zones", lambda *_: None)
    assert approached(start.profile, law, 1e-5, 1.0) == (None, start.profile)
    assert unsettled(start.profile, law, 1.0).startswith("Newton's method found no slip rate")
