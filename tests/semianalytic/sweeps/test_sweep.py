"""Sweeps over friction: the same answers as one by one, across thresholds, and what they refuse."""

from dataclasses import replace

import numpy as np
import pytest
from catalogue import PRELOADED, REMOTE, SHOCK, unit_scene
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from compare.studies.chart.benchmark import edge_difference
from semianalytic import SceneError, solve
from semianalytic.sweeps.continuation import COMPUTED, FROM_SCRATCH, INTERPOLATED
from semianalytic.sweeps.sweep import sweep


def check_against_single(swept, rtol):
    for friction, one in zip(swept.friction, swept.solutions, strict=True):
        other = solve(replace(swept.scene, friction=float(friction)), rtol=rtol)
        assert one.scene == other.scene
        assert one.status == other.status
        if other.status == "converged":
            difference = edge_difference(one, other)
            assert difference is not None, (friction, one.zones, other.zones)
            assert difference <= one.error_estimate + other.error_estimate
            assert one.error_estimate <= rtol


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
    swept = sweep(start, np.linspace(low, high, 30), 1e-7)
    assert set(swept.status) == {"converged"}
    assert len({tuple(z.sense for z in s.zones) for s in swept.solutions}) > 1
    check_against_single(swept, 1e-7)


def start_of(nu, remote, low):
    """A shear step or a remote load, and where a sweep over friction may start: under the second
    above 1, its base being at friction there."""
    start = unit_scene(2.0, **REMOTE if remote else {}, nu=nu)
    return start, 1.001 + low / 4 if remote else low


@pytest.mark.slow
@settings(max_examples=15, deadline=None, suppress_health_check=list(HealthCheck))
@given(
    nu=st.floats(-0.8, 0.48).map(lambda value: round(value, 3)),
    remote=st.booleans(),
    low=st.floats(0.02, 0.9),
    width=st.floats(0.05, 1.5),
)
def test_sweeps_of_any_material(nu, remote, low, width):
    start, low = start_of(nu, remote, low)
    swept = sweep(start, low + width * np.linspace(0, 1, 12), 1e-6)
    for one in swept.solutions:
        other = solve(one.scene, rtol=1e-6)
        assert one.status == other.status
        difference = edge_difference(one, other)
        if difference is None:  # a zone that only just exists may be below what is resolved
            assert abs(len(one.zones) - len(other.zones)) == 1
        elif one.status == "converged":
            assert difference <= one.error_estimate + other.error_estimate


def test_fields_are_those_of_single_solutions():
    friction = np.linspace(1.15, 1.25, 9)
    swept = sweep(SHOCK, friction)
    assert not swept.from_scratch.all()
    x = np.linspace(0.05, 1.9, 50)
    for one in swept.solutions:
        other = solve(one.scene)
        scale = other.edge_slip_rate
        np.testing.assert_allclose(
            one.slip_rate(x, 1.0), other.slip_rate(x, 1.0), atol=1e-6 * scale
        )
        margin = one.stick_margin(x, 1.0)
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


def test_interpolated_frictions_are_as_good_as_their_estimates_say():
    swept = sweep(PRELOADED, np.linspace(0.36, 0.9, 300), 1e-6)
    between = [i for i, origin in enumerate(swept.origin) if origin == INTERPOLATED]
    assert len(between) > 200
    for i in between[::21]:
        one = swept.solutions[i]
        exact = solve(one.scene, rtol=1e-11)
        assert edge_difference(one, exact) <= one.error_estimate <= 1e-6
        assert one.edge_slip_rate == pytest.approx(exact.edge_slip_rate, rel=one.error_estimate)


@pytest.mark.slow
@settings(max_examples=12, deadline=None, suppress_health_check=list(HealthCheck))
@given(
    nu=st.floats(-0.8, 0.48).map(lambda value: round(value, 3)),
    remote=st.booleans(),
    low=st.floats(0.02, 0.9),
    width=st.floats(0.02, 0.6),
    rtol=st.sampled_from([1e-3, 1e-5, 1e-8]),
)
def test_interpolated_frictions_agree_with_single_solutions(nu, remote, low, width, rtol):
    start, low = start_of(nu, remote, low)
    swept = sweep(start, low + width * np.linspace(0, 1, 120), rtol)
    assert set(swept.origin) <= {FROM_SCRATCH, COMPUTED, INTERPOLATED}
    between = [i for i, origin in enumerate(swept.origin) if origin == INTERPOLATED]
    for i in between[:: max(1, len(between) // 10)]:
        one = swept.solutions[i]
        other = solve(one.scene, rtol=rtol)
        assert one.status == other.status == "converged"
        if edge_difference(one, other) is None:  # `solve` may miss a zone that has just begun
            other = solve(one.scene, rtol=1e-9)
        difference = edge_difference(one, other)
        assert difference is not None, (i, one.zones, other.zones)
        assert difference <= one.error_estimate + other.error_estimate <= 2 * rtol


@pytest.mark.thinned(2)
@pytest.mark.parametrize(("start", "low", "high"), [(PRELOADED, 0.335, 0.35), (SHOCK, 1.1, 1.45)])
def test_changes_of_zones_are_not_smeared(start, low, high):
    swept = sweep(start, np.linspace(low, high, 200), 1e-7)
    count = [len(solution.zones) for solution in swept.solutions]
    changes = np.flatnonzero(np.diff(count))
    assert len(changes)
    for i in changes:
        for j in (i, i + 1):  # on either side a solution of its own
            assert swept.origin[j] != INTERPOLATED
            other = solve(swept.solutions[j].scene, rtol=1e-7)
            assert edge_difference(swept.solutions[j], other) is not None


@pytest.mark.slow
@settings(max_examples=10, deadline=None, suppress_health_check=list(HealthCheck))
@given(
    nu=st.floats(-0.8, 0.48).map(lambda value: round(value, 3)),
    low=st.floats(0.05, 0.4),
    width=st.floats(0.1, 0.6),
    rtol=st.sampled_from([1e-4, 1e-6]),
)
def test_error_estimates_hold_for_every_origin(nu, low, width, rtol):
    """Also where the rule of a batch is longer than one friction needs: beside narrow gaps."""
    swept = sweep(unit_scene(nu=nu), low + width * np.linspace(0, 1, 60), rtol)
    for origin in (COMPUTED, INTERPOLATED):
        some = [i for i, one in enumerate(swept.origin) if one == origin]
        for i in some[:: max(1, len(some) // 6)]:
            one = swept.solutions[i]
            exact = solve(one.scene, rtol=1e-10)
            difference = edge_difference(one, exact)
            if difference is None:  # a zone that only just exists
                continue
            assert difference <= one.error_estimate <= rtol
            scale = np.abs(exact.slip_rate(np.linspace(0.01, 1.99, 200), 1.0)).max()
            assert abs(one.edge_slip_rate - exact.edge_slip_rate) <= one.error_estimate * scale


def test_frictionless_points_and_empty_sweeps():
    swept = sweep(PRELOADED, [0.0, 0.3])
    assert len(swept.solutions[0].zones) == 3
    assert sweep(PRELOADED, []).solutions == ()


def test_refusals():
    with pytest.raises(SceneError, match="one-dimensional"):
        sweep(PRELOADED, [[0.3]])
    with pytest.raises(SceneError, match="friction"):
        sweep(PRELOADED, [0.3, -0.1])
    with pytest.raises(SceneError, match="rtol"):
        sweep(PRELOADED, [0.3], rtol=1.0)
