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
from semianalytic.scene.given.finding import find_scene
from semianalytic.selfsimilar.solver import solve as solve_exactly
from semianalytic.sweeps.plane import COMPUTED, FROM_SCRATCH, INTERPOLATED, Plane
from semianalytic.sweeps.sweep import Sweep, sweep
from tests.semianalytic.sweeps.singly import (
    check_against_single,
    check_one,
    edge_difference,
)


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
