"""Sweeps over friction and Poisson ratio: planes of scenes, their batches and predictions."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from catalogue import PRELOADED, unit_scene

from semianalytic import SceneError, solve
from semianalytic.cut.profile import Profile
from semianalytic.cut.zones import ZoneFields
from semianalytic.halfplane.families import rayleigh_family
from semianalytic.halfplane.rayleigh import rayleigh_factors
from semianalytic.halfplane.rules import rule_for
from semianalytic.halfplane.stuck import stuck_traction, traction_of
from semianalytic.scene.given.finding import find_scene
from semianalytic.selfsimilar.zones.coulomb import _one_of, admissible
from semianalytic.sweeps.plane import INTERPOLATED, Plane
from semianalytic.sweeps.predictions import Followed, predicted
from semianalytic.sweeps.sweep import _scenes, sweep
from tests.semianalytic.sweeps.singly import (
    SWEEPS,
    check_one,
)

RTOL = 1e-6


def check_some(swept, count):
    """Some solutions are those of `solve`, and their slip rates at the edge, within estimates."""
    assert set(swept.status) == {"converged"}
    for i in np.random.default_rng(0).choice(len(swept), count, replace=False):
        check_one(swept[i], RTOL, strict=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("name", SWEEPS)
def test_points_of_a_fine_grid_agree_with_single_solutions(name):
    friction, ratio = np.linspace(*SWEEPS[name], 60), np.linspace(0.0, 0.45, 60)[:, None]
    swept = sweep(find_scene(name), friction, RTOL, poisson_ratio=ratio)
    origin = Counter(swept.origin)
    assert origin["interpolated"] > 2 * origin["computed"] > 4 * origin["from scratch"]
    assert len({tuple(zone.sense for zone in answer.zones) for answer in swept}) > 1
    check_some(swept, 60)


@pytest.mark.slow
def test_points_anywhere_agree_with_single_solutions():
    random = np.random.default_rng(1)
    friction, ratio = random.uniform(0.05, 1.0, 400), random.uniform(-0.3, 0.47, 400)
    swept = sweep(PRELOADED, friction, RTOL, poisson_ratio=ratio)
    assert [answer.scene.friction for answer in swept] == friction.tolist()
    assert [answer.scene.material.poisson_ratio for answer in swept] == ratio.tolist()
    assert swept.origin.count("from scratch") < 100
    check_some(swept, 40)


def test_few_points_and_few_ratios_take_the_way_over_friction():
    ratio, friction = np.array([0.1, 0.3]), np.linspace(0.2, 0.9, 6)
    swept = sweep(PRELOADED, friction, RTOL, poisson_ratio=ratio[:, None])
    for nu, part in zip(ratio, (swept[:6], swept[6:]), strict=True):
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
    opens = np.array([len(answer.openings) > 0 for answer in swept])
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
        single, alone = family.chosen(np.array([j])), rayleigh_factors(ratios[j])
        np.testing.assert_allclose(single.s_plus(k[None])[0], alone.s_plus(k), rtol=1e-14)
        np.testing.assert_allclose([single.a[0, 0], single.c[0, 0]], [alone.a, alone.c], rtol=1e-15)
        for mode in ("I", "II"):
            exact = stuck_traction(ratios[j], mode)(k)
            scale = np.abs(exact).max()
            np.testing.assert_allclose(
                traction_of(single, mode)(k[None])[0], exact, rtol=1e-13, atol=1e-14 * scale
            )


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
        Followed(((), (False, True), (2, 2)), unknown, 1e-7, 1e-7, np.eye(2), 0.0)
        for unknown in unknowns(places)
    ]
    predictions = predicted(known, places, np.arange(20), to, RTOL)
    np.testing.assert_allclose(predictions.unknowns, unknowns(to), atol=1e-8)
    assert predictions.doubt.max() < 1e-7


def test_fields_of_one_of_many_sets_are_those_of_its_own_panels():
    friction, nu = np.meshgrid(np.linspace(0.9, 1.3, 20), np.linspace(0.1, 0.45, 20))
    plane = Plane(
        _scenes(find_scene("remote-shock"), np.stack([nu.ravel(), friction.ravel()]), 1e-6), 1e-6
    )
    plane.run()
    patterns = Counter(zone.pattern for zone in plane.zones.values() if len(zone.unknowns))
    for pattern, _ in patterns.most_common(3):
        points = np.array([i for i, zone in plane.zones.items() if zone.pattern == pattern])
        unknowns = np.array([plane.zones[i].unknowns for i in points])
        batch = next(plane._batches(pattern, points, unknowns, np.full(len(points), 1e-8), False))
        sets = plane._sets(pattern, points[batch])
        every = Profile(sets.fields(unknowns[batch].T, rule_for(1e-8)))
        admissible(every, 1e-6)
        one = _one_of(every, len(batch) // 2)
        fields = one.fields
        own = Profile(ZoneFields(fields.factors, fields.load, fields.zones, fields.rule))
        for panel in range(len(one.panels.sense)):
            at = one.panels.inside(panel, np.linspace(-4, 4, 9))
            assert one.wrong(panel, at) == pytest.approx(own.wrong(panel, at), abs=1e-5)


@pytest.mark.parametrize(
    ("name", "low", "high", "most"),
    [("remote-shock", 0.9, 1.3, 0.24), ("preloaded", 0.2, 0.6, 0.12)],
)
def test_few_points_of_a_plane_need_the_fine_rule(name, low, high, most):
    friction, nu = np.linspace(low, high, 30), np.linspace(0.1, 0.45, 30)[:, None]
    swept = sweep(name, friction, 1e-6, poisson_ratio=nu)
    # 0.20 and 0.07; 0.28 and 0.17 while only points from the fine rule lent others their Jacobians
    assert np.mean([origin != INTERPOLATED for origin in swept.origin]) < most
