"""Arrivals and fields at points: what they mean, and that errors lie within their bars."""

from dataclasses import replace

import numpy as np
import pytest
from catalogue import unit_scene
from hypothesis import given
from hypothesis import strategies as st

import semianalytic as sf
from fem import simulate, with_companions
from semianalytic.dissimilar_slot.solver import coupled
from semianalytic.results.answer import ARRIVALS, FIELDS
from tests.laws import opening_scene, random_scenes

PRELOADED = sf.solve(sf.find("preloaded"))


def beside(solution, random):
    """Positions at t = 1 anywhere, and very close to edges and to the Rayleigh front."""
    speed = solution.scene.material.longitudinal_speed
    edges = [*np.ravel(solution.edge_speeds)]
    edges += [end for part in solution.openings for end in (part.inner, part.outer)]
    edges += [solution.scene.material.rayleigh_speed]
    near = [
        edge * (1 + sign * 10.0 ** -random.uniform(1, 10))
        for edge in edges
        if 0 < edge < np.inf
        for sign in (-1, 1)
    ]
    return np.concatenate([random.uniform(0.01, 1.2 * speed, 40), near])


def over_bars(solution, exact, x, t=1.0):
    """Largest difference of two readings over the sum of their bars."""
    worst, (first, other) = 0.0, (answer.reading(x, t) for answer in (solution, exact))
    for pair in (
        *((getattr(first, name), getattr(other, name)) for name in FIELDS),
        *((first.arrivals[name], other.arrivals[name]) for name in ARRIVALS),
    ):
        (value, bar), (right, its_bar) = pair
        both = np.isfinite(value) & np.isfinite(right)
        apart = np.abs(np.where(both, value, 0.0) - np.where(both, right, 0.0))
        share = np.divide(apart, bar + its_bar, out=np.zeros_like(apart), where=apart > 0)
        worst = max(worst, float(share.max()))
    return worst


def solutions_of_any_kind():
    """Solutions to twelve digits, or to eleven where the contact opens or a film carries shear."""
    random = np.random.default_rng(3)
    yield from random_scenes(6)
    drawn = [opening_scene(random) for _ in range(4)]
    yield from (sf.solve(scene, rtol=1e-11) for scene in drawn)
    # a film so strong that slip away from the edge is a billionth of that at the edge
    film, base = sf.Coulomb(1.0, viscosity=4e7), sf.Tractions(1.0, 0.0)
    solid = sf.Material(1.0, 1.0, 0.25)
    yield sf.solve(sf.Scene(solid, film.with_coefficient(0.5), base, sf.Tractions(0.0, 1.0)))
    for load in (sf.IncidentWave("SV", -20.0, stress=0.3), sf.MovingLoad(-2.0, 0.1, 0.7)):
        yield sf.solve(sf.Scene(solid, 0.5, base, load), rtol=1e-11)


@pytest.mark.slow
def test_errors_of_random_scenes_are_within_their_bars():
    random = np.random.default_rng(5)
    for exact in solutions_of_any_kind():
        solution = sf.solve(exact.scene, rtol=1e-6)
        assert over_bars(solution, exact, beside(solution, random)) < 1, exact.scene


@given(st.floats(1e-3, 1e3), st.floats(1e-3, 1e3))
def test_arrivals_are_proportional_to_the_distance(x, scale):
    for of in ARRIVALS:
        assert PRELOADED.arrival(scale * x, of) == pytest.approx(scale * PRELOADED.arrival(x, of))


def test_slip_and_openings_begin_when_they_arrive():
    for name in ("preloaded", "lift-off-shear", "remote-shock"):
        solution = sf.solve(sf.find(name))
        when = solution.arrival(0.7)
        before, after = solution.slip_rate(0.7, when * np.array([1 - 1e-6, 1 + 1e-6]))
        assert before == 0
        assert after != 0
    tap = sf.solve(sf.find("tap"))
    assert tap.arrival(2.0, "opening") == pytest.approx(2.0 / tap.openings[0].outer)
    assert tap.gap(2.0, 1.001 * float(tap.arrival(2.0, "opening"))) > 0


def test_senses_arrive_with_zones_of_their_sense():
    scene = unit_scene(0.01, load=(0.2, 1.0))
    solution = sf.solve(scene)
    for sense, of in ((1, "forward"), (-1, "reverse")):
        speeds = [zone.outer for zone in solution.zones if zone.sense == sense]
        expected = 1 / max(speeds) if speeds else np.inf
        assert solution.arrival(1.0, of) == pytest.approx(expected)
    first = min(float(solution.arrival(1.0, of)) for of in ("forward", "reverse"))
    assert float(solution.arrival(1.0)) == first


def test_what_never_comes_is_infinite_and_what_is_everywhere_comes_at_once():
    assert np.isinf(PRELOADED.arrival([0.1, 3.0], "opening")).all()
    stuck = sf.solve(sf.find("stuck"))
    assert np.isinf(stuck.arrival(1.0))
    assert stuck.reading(1.0, 1.0).arrivals["slip"].error == 0
    sudden = replace(
        sf.find("remote-shock"), friction=0.1, load=sf.Tractions(pressure=1.0, shear=1.0)
    )
    assert sf.solve(sudden).arrival(1.0) == 0


def test_a_solution_that_breaks_the_law_has_no_bars():
    broken = replace(PRELOADED, status="no set of slip zones was found")
    reading = broken.reading(0.3, 1.0)
    assert np.isinf(reading.slip.error)
    assert np.isinf(reading.arrivals["slip"].error)
    assert reading.status == broken.status


@pytest.mark.parametrize(("x", "of"), [(0.0, "slip"), (-1.0, "slip"), (np.nan, "slip"), (1, "on")])
def test_bad_questions_are_refused_in_a_sentence(x, of):
    with pytest.raises(sf.SceneError, match=r"(positive|finite|must be one of slip, forward)"):
        PRELOADED.arrival(x, of)


def covered(answer, exact, count=300):
    """Shares of values, and of arrivals that both know, whose errors lie within the bars."""
    random = np.random.default_rng(2)
    x = random.uniform(0.03, 0.9, count) * answer.interface.x[-1]
    t = random.uniform(0.1, 1.0, count) * answer.end_time
    reading = answer.reading(x, t)
    shares = {}
    for name in ("slip", "slip_rate", "shear_traction", "pressure"):
        value, bar = getattr(reading, name)
        shares[name] = np.mean(np.abs(value - getattr(exact, name)(x, t)) <= bar)
    for of in ("slip", "forward", "reverse"):
        value, bar = reading.arrivals[of]
        right = exact.arrival(x, of)
        both = np.isfinite(value) & (right < answer.end_time)
        shares[of] = np.mean(np.abs(value[both] - right[both]) <= bar[both]) if both.any() else 1.0
    return shares


@pytest.mark.thinned(2)
@pytest.mark.parametrize("name", ["preloaded", "remote-shock"])
def test_bars_of_a_march_hold(name):
    exact = sf.solve(sf.find(name))
    marched = sf.solve(exact.scene, method="space-time", end_time=1.0, nodes=200)
    assert min(covered(marched, exact).values()) > 0.97


def test_bars_of_marches_hold_on_fronts_and_beside_edges():
    """The cusp of the traction at x = c_t t was up to four bars off on either grid."""
    fronts = unit_scene(0.4861, (1, 0.3227), (0.17, -1.8458), nu=-0.1668)
    edge = unit_scene(0.633619, (1, 0.385934), (-0.048355, 1.511743), nu=0.048208)
    for scene, x in ((fronts, np.array([1.0, 0.999])), (edge, np.array([1.0, 1.05]))):
        exact = sf.solve(scene, rtol=1e-10)
        for nodes in (100, 200):
            at = sf.solve(scene, method="space-time", end_time=1.0, nodes=nodes).reading(x, 1.0)
            for name in FIELDS:
                value, bar = getattr(at, name)
                off = np.abs(value - getattr(exact, name)(x, 1.0))
                assert np.all((off < bar) | ((bar == 0) & (value == 0))), name
                assert bar.max() < 0.2


def test_bars_of_a_simulation_hold():
    simulation = with_companions(simulate(PRELOADED.scene, resolution=48))
    assert min(covered(simulation, PRELOADED).values()) > 0.97
    alone = replace(simulation, companion=None).reading(0.3, 0.5)
    assert np.isinf(alone.slip.error)


def test_a_pair_of_equal_bodies_reads_like_one_body():
    solid, base, load = sf.Material(1.0, 1.0, 0.25), sf.Tractions(1.0, 0.0), sf.Tractions(0.0, 0.8)
    pair = coupled(sf.Scene(solid, 0.4, base, load, lower_material=solid), 1e-6)
    exact = sf.solve(sf.Scene(solid, 0.4, base, load), rtol=1e-12)
    x = np.linspace(0.05, 1.5, 30)
    assert over_bars(pair, exact, x) < 1
