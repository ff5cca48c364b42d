"""Sweeps: the same answers as one by one, across thresholds, and faster; what they refuse; and a
sweep as a sequence with slip rates and a dataset."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from catalogue import PRELOADED, REMOTE, SHOCK, unit_scene
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from semianalytic import Material, RateWeakening, Scene, SceneError, Tractions, solve
from semianalytic.cut.profile import Profile
from semianalytic.cut.zones import ZoneFields
from semianalytic.halfplane.families import rayleigh_family
from semianalytic.halfplane.rayleigh import rayleigh_factors
from semianalytic.halfplane.rules import rule_for
from semianalytic.halfplane.stuck import stuck_traction, traction_of
from semianalytic.parameters.numbers import with_numbers
from semianalytic.scene.given.finding import find_scene
from semianalytic.selfsimilar.solver import solve as solve_exactly
from semianalytic.selfsimilar.zones.coulomb import _one_of, admissible
from semianalytic.sweeps.plane import COMPUTED, FROM_SCRATCH, INTERPOLATED, Plane
from semianalytic.sweeps.predictions import Followed, predicted
from semianalytic.sweeps.sweep import Sweep, _scenes, sweep

SWEEPS = {"preloaded": (0.05, 1.0), "remote-shock": (1.05, 1.5)}
"""Frictions of sweeps of named scenes, which cross thresholds."""


def edge_difference(first, other):
    """The largest difference of zone edges over c_t; None if the zones differ in number.

    Zones that are closer to each other than rounding count as one.
    """
    speed = first.scene.material.shear_speed
    mine, theirs = (joined(solution.edge_speeds / speed) for solution in (first, other))
    if len(mine) != len(theirs):
        return None
    return max((abs(p - q) for p, q in zip(mine, theirs, strict=True) if p != q), default=0.0)


def joined(fronts):
    edges = fronts.ravel().tolist()
    gaps = [i for i in range(1, len(edges) - 1, 2) if edges[i + 1] - edges[i] < 1e-13]
    return [edge for i, edge in enumerate(edges) if i not in gaps and i - 1 not in gaps]


def check_against_single(swept, rtol):
    for friction, solution in zip(swept.friction, swept.solutions, strict=True):
        other = solve(with_numbers(swept.scene, {"friction": friction}), rtol=rtol)
        assert solution.scene == other.scene
        assert solution.status == other.status
        if other.status == "converged":
            difference = edge_difference(solution, other)
            assert difference is not None, (friction, solution.zones, other.zones)
            assert difference <= solution.error_estimate + other.error_estimate
            assert solution.error_estimate <= rtol


def check_one(first, rtol, strict=1e-10):
    """Edges and slip rate at the contact edge are off by no more than is estimated; the truth."""
    exact = solve(first.scene, rtol=strict)
    difference = edge_difference(first, exact)
    assert difference is not None, (first, exact)
    assert difference <= first.error_estimate <= rtol
    rate = np.abs(first.edge_slip_rate - exact.edge_slip_rate)
    assert rate <= first.error_estimate * max(1.0, abs(exact.edge_slip_rate))
    return exact


@pytest.mark.thinned(5)
@pytest.mark.parametrize(
    ("start", "low", "high"),
    [
        (SHOCK, 0.9, 1.6),  # everywhere, past c_R, two zones, one, none
        (PRELOADED, 0.2, 0.6),  # a second zone until 0.34
        (unit_scene(nu=-0.5), 1e-3, 0.2),  # reverse slip, two zones, one
        (unit_scene(1.1, **REMOTE, nu=-0.5), 1.05, 1.2),  # stuck edge
        (unit_scene(base=(2.0, 0.1), load=(0.5, 0.6)), 0.1, 0.9),  # both senses
    ],
)
def test_sweep_agrees_with_single_solutions_across_thresholds(start, low, high):
    swept = sweep(start, np.linspace(low, high, 14), 1e-7)
    assert set(swept.status) == {"converged"}
    assert len({tuple(z.sense for z in s.zones) for s in swept.solutions}) > 1
    check_against_single(swept, 1e-7)


@pytest.mark.parametrize("name", ["viscous", "antiplane", "moving-load"])
def test_sweeps_of_films_antiplane_shear_and_moving_loads_agree_with_single_solutions(name):
    check_against_single(sweep(find_scene(name), np.linspace(0.15, 1.0, 6), 1e-8), 1e-8)


def test_a_third_zone_that_appears_next_to_two_is_that_of_single_solutions():
    """It exists below a friction within the sweep, next to the ratio of tractions at a front."""
    start = Scene(
        Material(1, 1, 0.45), 0.0057,
        base=Tractions(1, 0.002242159297204636),
        load=Tractions(0.49976385766580994, -0.1382420818219758),
    )  # fmt: skip
    swept = sweep(start, np.linspace(0.0022425, 0.0023, 24), 1e-6)
    assert [len(solution.zones) for solution in swept.solutions[:: len(swept) - 1]] == [3, 2]
    check_against_single(swept, 1e-6)


@pytest.mark.parametrize("friction", [0.0, 0.3, 5.0])
def test_a_sweep_of_one_friction_is_the_single_solution(friction):
    """Also without friction, and with so much that hardly anything slips."""
    swept = sweep(unit_scene(1.0), [friction], 1e-6)
    assert swept.origin == (FROM_SCRATCH,)
    check_against_single(swept, 1e-6)


def test_friction_that_falls_with_slip_rate_is_solved_one_by_one():
    """Edges would be followed under the friction at rest, 2 % off."""
    start = replace(PRELOADED, friction=RateWeakening(0.5, 0.3, 5.0))
    swept = sweep(start, [0.6, 0.65, 0.7], 1e-5)
    for answer in swept:
        np.testing.assert_array_equal(
            answer.edge_speeds, solve_exactly(answer.scene, rtol=1e-5).edge_speeds
        )
    assert set(swept.status) == {"converged"}


def test_fields_are_those_of_single_solutions():
    friction = np.linspace(1.15, 1.25, 9)
    swept = sweep(SHOCK, friction)
    assert not swept.from_scratch.all()
    x = np.linspace(0.05, 1.9, 50)
    for solution in swept.solutions:
        other = solve(solution.scene)
        scale = other.edge_slip_rate
        np.testing.assert_allclose(
            solution.slip_rate(x, 1.0), other.slip_rate(x, 1.0), atol=1e-6 * scale
        )
        margin = solution.stick_margin(x, 1.0)
        np.testing.assert_allclose(margin, other.stick_margin(x, 1.0), atol=1e-6)


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


def test_order_and_repetition_of_frictions_do_not_matter():
    friction = np.array([0.5, 0.2, 0.3, 0.3, 0.25, 0.45, 0.4, 0.35])
    swept = sweep(PRELOADED, friction, 1e-6)
    assert [s.scene.friction for s in swept.solutions] == friction.tolist()
    np.testing.assert_allclose(swept.edges[2], swept.edges[3], atol=1e-6)
    outer = swept.edges[np.argsort(friction, kind="stable"), 0, 1]
    assert np.all(np.diff(outer) <= 1e-6)  # the slow zone is slower under more friction


def test_most_frictions_are_followed_not_solved_from_scratch():
    swept = sweep(PRELOADED, np.linspace(0.05, 1.0, 60))
    assert swept.from_scratch.sum() <= 12


@pytest.mark.parametrize(("start", "low", "high"), [(PRELOADED, 0.3, 0.4), (SHOCK, 1.1, 1.45)])
def test_a_sweep_goes_on_with_one_friction_after_another(start, low, high):
    """Beyond what is known and between it, on both sides of thresholds."""
    known = Plane([start], 1e-7)
    for friction in (low + (high - low) * np.random.default_rng(5).uniform(size=30)).tolist():
        known.add([replace(start, friction=friction)])
        check_one(known.solutions[len(known.scenes) - 1], 1e-7)
    assert Counter(known.origin.values())[FROM_SCRATCH] <= 20  # those next to thresholds


def test_interpolated_frictions_are_as_good_as_their_estimates_say():
    swept = sweep(PRELOADED, np.linspace(0.36, 0.9, 300), 1e-6)
    between = [i for i, origin in enumerate(swept.origin) if origin == INTERPOLATED]
    assert len(between) > 200
    for i in between[::21]:
        exact = check_one(swept[i], 1e-6, strict=1e-11)
        rate = exact.edge_slip_rate
        assert swept[i].edge_slip_rate == pytest.approx(rate, rel=swept[i].error_estimate)


@pytest.mark.parametrize(
    ("low", "high", "count", "some"),
    [
        (0.08289836027350878, 0.6187197360930274, 100, range(33, 38)),
        (0.0769197110720411, 0.2786472006766832, 300, range(248, 253)),
    ],
)
def test_estimates_hold_though_neighbours_have_narrower_gaps(low, high, count, some):
    # on the finer panels of narrow gaps edges lack less than on their own
    swept = sweep(PRELOADED, np.linspace(low, high, count), 1e-6)
    for i in some:
        assert len(swept[i].zones) == 2
        check_one(swept[i], 1e-6)


@pytest.mark.thinned(2)
@pytest.mark.parametrize(("start", "low", "high"), [(PRELOADED, 0.335, 0.35), (SHOCK, 1.1, 1.45)])
def test_changes_of_zones_are_not_smeared(start, low, high):
    swept = sweep(start, np.linspace(low, high, 200), 1e-7)
    count = [len(solution.zones) for solution in swept.solutions]
    changes = np.flatnonzero(np.diff(count))
    assert len(changes)
    for i in changes:
        for j in (i, i + 1):  # on either side the zones of a solution of its own
            check_one(swept.solutions[j], 1e-7)


@pytest.mark.slow
@settings(max_examples=20, deadline=None, suppress_health_check=list(HealthCheck))
@given(
    nu=st.floats(-0.8, 0.48).map(lambda value: round(value, 3)),
    remote=st.booleans(),
    low=st.floats(0.02, 0.9),
    width=st.floats(0.02, 1.5),
    count=st.sampled_from([12, 60, 120]),
    rtol=st.sampled_from([1e-3, 1e-4, 1e-5, 1e-6, 1e-8]),
)
def test_error_estimates_hold_for_every_origin(nu, remote, low, width, count, rtol):
    """Also where the rule of a batch is longer than one friction needs: beside narrow gaps."""
    start = unit_scene(2.0, **REMOTE if remote else {}, nu=nu)
    low = 1.001 + low / 4 if remote else low  # the base of a remote load is at friction at 1
    swept = sweep(start, low + width * np.linspace(0, 1, count), rtol)
    assert set(swept.origin) <= {FROM_SCRATCH, COMPUTED, INTERPOLATED}
    for origin in (COMPUTED, INTERPOLATED):
        some = [i for i, source in enumerate(swept.origin) if source == origin]
        for i in some[:: max(1, len(some) // 8)]:
            entry, exact = swept[i], solve(swept[i].scene, rtol=1e-10)
            difference = edge_difference(entry, exact)
            if difference is None and origin == COMPUTED:  # a zone that only just exists
                assert abs(len(entry.zones) - len(exact.zones)) == 1
                continue
            assert entry.status == exact.status == "converged"
            assert difference is not None, (i, entry.zones, exact.zones)
            assert difference <= entry.error_estimate <= rtol
            rates = np.abs(exact.slip_rate(np.linspace(0.01, 1.99, 200), 1.0))
            scale = max(rates.max(), abs(exact.edge_slip_rate))  # zones may be slower than these
            assert abs(entry.edge_slip_rate - exact.edge_slip_rate) <= entry.error_estimate * scale


def test_frictionless_points_empty_sweeps_and_refusals():
    swept = sweep(PRELOADED, [0.0, 0.3])
    assert len(swept.solutions[0].zones) == 3
    assert sweep(PRELOADED, []).solutions == ()
    with pytest.raises(SceneError, match="one-dimensional"):
        sweep(PRELOADED, [[0.3]])
    with pytest.raises(SceneError, match="friction"):
        sweep(PRELOADED, [0.3, -0.1])
    with pytest.raises(SceneError, match="rtol"):
        sweep(PRELOADED, [0.3], rtol=1.0)
    with pytest.raises(SceneError, match="step loads only"):
        sweep(find_scene("ramp"), [0.3])


# --- a sweep as a sequence, its slip rates and its dataset ----------------------------------------


X = np.array([0.05, 0.2, 0.4])
T = np.array([0.5, 1.0])


@pytest.fixture(scope="module")
def swept():
    """Two zones under little friction, one under more."""
    return sweep(PRELOADED, [0.9, 0.2, 0.5], 1e-6)


def test_a_sweep_is_a_sequence_of_its_solutions_and_a_slice_one_over_some_frictions(swept):
    assert len(swept) == 3
    assert list(swept) == list(swept.solutions)
    assert [answer.scene.friction for answer in swept] == [0.9, 0.2, 0.5]
    assert swept[0] is swept.solutions[0]
    assert swept[-1] is swept.solutions[2]
    for beyond in (3, -4):
        with pytest.raises(IndexError):
            swept[beyond]
    part = swept[::-2]
    assert isinstance(part, Sweep)
    assert part.friction.tolist() == [0.5, 0.9]
    assert part.solutions == (swept.solutions[2], swept.solutions[0])
    assert part.origin == (swept.origin[2], swept.origin[0])
    assert part.scene == swept.scene
    assert len(swept[3:]) == 0
    shown = repr(swept)
    assert "3 friction coefficients from 0.2 to 0.9" in shown
    assert "3 converged" in shown
    assert "\n" not in shown
    assert repr(swept[3:]) == "<Sweep: no friction coefficients>"


def test_slip_rates_have_friction_first_and_broadcast(swept):
    rate = swept.slip_rate(X, T[:, None])
    assert rate.shape == (3, 2, 3)
    for row, solution in zip(rate, swept, strict=True):
        np.testing.assert_array_equal(row, solution.slip_rate(X, T[:, None]))
    assert swept.slip_rate(0.1, 1.0).shape == (3,)
    assert swept[3:].slip_rate(X, T[:, None]).shape == (0, 2, 3)
    with pytest.raises(SceneError, match="positive positions"):
        swept.slip_rate(-1.0, 1.0)


def test_edges_of_fewer_zones_are_padded_and_estimates_given(swept):
    assert swept.error_estimate.shape == (3,)
    assert np.all(swept.error_estimate <= 1e-6)
    assert swept.edges.shape == (3, 2, 2)
    assert np.isnan(swept.edges[0, 1]).all()
    for row, solution in zip(swept.edges, swept, strict=True):
        pairs = [(zone.inner, zone.outer) for zone in solution.zones]
        np.testing.assert_array_equal(row[: len(pairs)], pairs)
    assert swept[3:].edges.shape == (0, 0, 2)


def test_the_dataset_has_a_dimension_friction_and_units(swept):
    data = swept.to_xarray(X, T)
    assert data.slip_rate.dims == ("friction", "t", "x")
    assert data.friction.values.tolist() == [0.9, 0.2, 0.5]
    for name in ("slip", "slip_rate", "shear_traction", "pressure"):
        for j, solution in enumerate(swept):
            exact = getattr(solution, name)(X, T[:, None])
            np.testing.assert_array_equal(data[name].values[j], exact)
    assert data.slip_rate.attrs["dimension"] == "length / time"
    assert all({"units", "long_name"} <= set(data[name].attrs) for name in (*data, *data.coords))
    np.testing.assert_array_equal(data.edges.sel(edge="outer"), swept.edges[..., 1])
    assert data.origin.values.tolist() == list(swept.origin)
    assert data.status.values.tolist() == ["converged"] * 3
    assert swept[3:].to_xarray(X, T).sizes["friction"] == 0


# --- friction and Poisson ratio -------------------------------------------------------------------


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
