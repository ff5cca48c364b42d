"""Sweeps over friction and Poisson ratio: the same answers as one by one, and faster."""

from collections import Counter
from dataclasses import replace
from time import process_time

import numpy as np
import pytest
from catalogue import PRELOADED, unit_scene

from compare.studies.chart.benchmark import SWEEPS, edge_difference
from semianalytic import SceneError, solve
from semianalytic.halfplane.families import rayleigh_family
from semianalytic.halfplane.rayleigh import rayleigh_factors
from semianalytic.halfplane.stuck import stuck_traction, traction_of
from semianalytic.scene.given.finding import find_scene
from semianalytic.sweeps.neighbours import Neighbourhood
from semianalytic.sweeps.predictions import Followed, Footing, predicted
from semianalytic.sweeps.sweep import sweep

RTOL = 1e-6


def grid(name, count, low=0.0, high=0.45):
    """Friction and Poisson ratios of a grid over a named family of scenes."""
    return np.linspace(*SWEEPS[name], count), np.linspace(low, high, count)[:, None]


def check_against_single(swept, count):
    """Some solutions are those of `solve` within their error estimates."""
    assert set(swept.status) == {"converged"}
    for i in np.random.default_rng(0).choice(len(swept), count, replace=False):
        one, exact = swept[i], solve(swept[i].scene, rtol=1e-9)
        difference = edge_difference(one, exact)
        assert difference is not None, (one, exact)
        assert difference <= one.error_estimate <= RTOL
        rate = np.abs(one.edge_slip_rate - exact.edge_slip_rate)
        assert rate <= one.error_estimate * max(1.0, abs(exact.edge_slip_rate))


@pytest.mark.slow
@pytest.mark.parametrize("name", SWEEPS)
def test_points_of_a_fine_grid_agree_with_single_solutions(name):
    friction, ratio = grid(name, 60)
    swept = sweep(find_scene(name), friction, RTOL, poisson_ratio=ratio)
    origin = Counter(swept.origin)
    assert origin["interpolated"] > 2 * origin["computed"] > 4 * origin["from scratch"]
    assert len({tuple(zone.sense for zone in one.zones) for one in swept}) > 1
    check_against_single(swept, 60)


@pytest.mark.slow
def test_points_anywhere_agree_with_single_solutions():
    random = np.random.default_rng(1)
    friction, ratio = random.uniform(0.05, 1.0, 400), random.uniform(-0.3, 0.47, 400)
    swept = sweep(PRELOADED, friction, RTOL, poisson_ratio=ratio)
    assert [one.scene.friction for one in swept] == friction.tolist()
    assert [one.scene.material.poisson_ratio for one in swept] == ratio.tolist()
    assert swept.origin.count("from scratch") < 100
    check_against_single(swept, 40)


def test_few_points_and_few_ratios_take_the_way_over_friction():
    ratio, friction = np.array([0.1, 0.3]), np.linspace(0.2, 0.9, 12)
    swept = sweep(PRELOADED, friction, RTOL, poisson_ratio=ratio[:, None])
    for nu, part in zip(ratio, (swept[:12], swept[12:]), strict=True):
        material = replace(PRELOADED.material, poisson_ratio=nu)
        alone = sweep(replace(PRELOADED, material=material), friction, RTOL)
        assert part.origin == alone.origin
        np.testing.assert_array_equal(part.edges[:, : alone.edges.shape[1]], alone.edges)


@pytest.mark.slow
def test_contact_that_opens_at_some_ratios_is_solved_one_by_one():
    """Least pressure at the Rayleigh front depends on the Poisson ratio."""
    start = unit_scene(0.5, (0.05, 0.0), (1.0, 1.0))
    swept = sweep(
        start, np.linspace(0.3, 0.9, 20), 1e-4, poisson_ratio=np.linspace(0, 0.45, 20)[:, None]
    )
    opens = np.array([len(one.openings) > 0 for one in swept])
    assert 0 < opens.sum() < len(opens)
    assert set(np.array(swept.origin)[opens]) == {"from scratch"}
    for i in np.flatnonzero(opens)[::20]:
        np.testing.assert_array_equal(
            swept[i].edge_speeds, solve(swept[i].scene, rtol=1e-4).edge_speeds
        )


def test_shapes_are_those_of_numpy():
    swept = sweep(PRELOADED, 0.5, RTOL, poisson_ratio=[0.1, 0.2])
    assert swept.friction.tolist() == [0.5, 0.5]
    assert swept.poisson_ratio.tolist() == [0.1, 0.2]
    data = swept.to_xarray([0.2, 0.3], [1.0])
    assert data.slip_rate.dims == ("point", "t", "x")
    assert data.poisson_ratio.values.tolist() == [0.1, 0.2]
    assert data.friction.dims == ("point",)
    with pytest.raises(SceneError, match="do not broadcast"):
        sweep(PRELOADED, [0.1, 0.2, 0.3], poisson_ratio=[0.1, 0.2])
    with pytest.raises(SceneError, match="poisson_ratio"):
        sweep(PRELOADED, [0.1, 0.2], poisson_ratio=[0.1, 0.6])


@pytest.mark.thinned(2)
@pytest.mark.parametrize("low", [-0.9, -0.3, 0.1, 0.3, 0.46, 0.488])
def test_interpolated_tables_are_exact_to_rounding(low):
    ratios = np.random.default_rng(2).uniform(low, low + 0.01, 40)
    family = rayleigh_family(ratios)
    k = np.concatenate([np.linspace(0.05, 0.99, 40), np.geomspace(1.001, 1e6, 60)])
    for j in (0, 17, 39):
        one, alone = family.chosen(np.array([j])), rayleigh_factors(ratios[j])
        np.testing.assert_allclose(one.s_plus(k[None])[0], alone.s_plus(k), rtol=1e-14)
        np.testing.assert_allclose([one.a[0, 0], one.c[0, 0]], [alone.a, alone.c], rtol=1e-15)
        for mode in ("I", "II"):
            exact = stuck_traction(ratios[j], mode)(k)
            scale = np.abs(exact).max()
            np.testing.assert_allclose(
                traction_of(one, mode)(k[None])[0], exact, rtol=1e-13, atol=1e-14 * scale
            )


def test_polynomials_between_neighbours_reproduce_their_degree():
    random = np.random.default_rng(3)
    places, to = random.random((60, 2)), random.random((5, 2))

    def cubic(at):
        x, y = at.T
        return np.stack([1 + x * y * y - 2 * x**3, y], axis=-1)

    value, other = Neighbourhood(places).stencils(to).best(cubic(places))(cubic(places))
    np.testing.assert_allclose(value, cubic(to), atol=1e-10)
    assert np.all(np.abs(value - other) < 0.1)


def test_edges_near_the_end_of_their_segment_are_predicted_by_their_shares():
    """A share that is a polynomial is met where it is 1, and its logit infinite, close by; another
    edge has a logit that is one, over all scales of shares."""
    random = np.random.default_rng(4)
    places, to = random.random((200, 2)), 0.05 + 0.9 * random.random((20, 2))

    def unknowns(at):
        x, y = at.T
        share = 1 - 0.02 * (1.02 - x) * (1.1 - y)
        return np.stack([np.log(share / (1 - share)), 30 * x - 20 * y], axis=-1)

    known = [
        Followed(((), (False, True), (2, 2)), one, 1e-7, 1e-7, Footing(np.eye(2), 0.0))
        for one in unknowns(places)
    ]
    predictions = predicted(known, places, np.arange(20), to, RTOL)
    np.testing.assert_allclose(predictions.unknowns, unknowns(to), atol=1e-8)
    assert predictions.doubt.max() < 1e-7


@pytest.mark.slow
def test_neighbours_of_other_ratios_save_most_of_the_time():
    """Over 1,600 points a seventh of what `solve` takes for each is left."""
    friction, ratio = np.linspace(0.05, 1.0, 40), np.linspace(0.0, 0.45, 40)[:, None]
    start = process_time()
    swept = sweep(PRELOADED, friction, RTOL, poisson_ratio=ratio)
    quick = process_time() - start
    some = swept[::40]
    start = process_time()
    for one in some:
        solve(one.scene, rtol=RTOL)
    assert quick < (process_time() - start) * len(swept) / len(some) / 4
