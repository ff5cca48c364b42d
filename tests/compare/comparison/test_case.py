"""What a case reads off meshes: differences from one to the next, and what it can judge."""

from dataclasses import replace

import pytest
from catalogue import solved
from compare_cases import sampled_run, simulated
from hypothesis import given
from hypothesis import strategies as st

from compare import judge
from compare.comparison.case import own_wear, worn_by
from compare.comparison.judgement import side_by_side
from compare.comparison.judging import mesh_changes
from compare.comparison.measures import NOTHING
from compare.comparison.prediction import predict_like
from semianalytic.scene.given.finding import find_scene

PRELOADED = find_scene("preloaded")


@given(st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=5))
def test_differences_add_up_from_the_finest_mesh_to_the_coarsest(values):
    changes = mesh_changes(values)
    assert len(changes) == len(values) - 1
    assert sum(changes) == pytest.approx(values[0] - values[-1], abs=1e-8)


@pytest.mark.parametrize(
    ("values", "changes"),
    [
        ([None, 1.0, 2.0], []),
        ([1.0, None, 2.0], []),
        ([3.0, 1.0, None], [2.0]),
        ([3.0, 1.0, None, 7.0], [2.0]),
    ],
)
def test_differences_end_at_the_first_mesh_that_does_not_show_a_value(values, changes):
    assert mesh_changes(values) == changes


@pytest.mark.slow
def test_bars_shrink_with_the_mesh(solution, coarse):
    """Bars of a simulation at h = 1/30 and at h = 1/60."""
    runs = simulated(PRELOADED, 30), coarse
    large, small = ({row.name: row for row in judge(solution, run).rows} for run in runs)
    both = [
        (name, small[name].bar, large[name].bar)
        for name in large.keys() & small.keys()
        if large[name].bar is not None and small[name].bar is not None
    ]
    assert len(both) >= 10
    for name, *bars in both:
        if small[name].kind == "law":  # what a run has to hold on any mesh, but for rounding
            assert bars == [NOTHING, NOTHING], name
        elif not small[name].converges:  # its bar is the range of what the meshes show
            assert (name, small[name].verdict) == ("shear traction, L1", "unresolved")
        else:  # Pressure is that of the base to rounding throughout: its bar is none at all.
            assert bars[0] < bars[1] or name.startswith("pressure, "), name


def rounded(run):
    seen = replace(run.interface, pressure=run.interface.pressure * (1 + 1e-12))
    return replace(run, interface=seen, companion=run.companion and rounded(run.companion))


def test_rounding_is_no_difference(solution):
    """Pressure that is that of the base throughout, to twelve digits on each mesh."""
    rows = {row.name: row for row in judge(solution, rounded(sampled_run(solution, 40))).rows}
    pressure = rows["pressure, L1"]
    assert 0 < pressure.difference < 1e-11
    assert (pressure.verdict, pressure.obstacle) == ("agrees", "")


@pytest.mark.slow
def test_wear_is_the_answers_own_where_it_has_any_and_else_summed_over_the_times():
    run = sampled_run(solved(PRELOADED), resolution=40, times=200)
    x, end = run.interface.x, run.end_time
    own = {}
    for method in ("self-similar", "space-time"):
        prediction = predict_like(run, method)
        case = side_by_side(prediction, run)
        own[method] = own_wear(prediction, x, end)
        for mine, at_nodes in zip(own[method], case.worn_at_nodes, strict=True):
            assert mine == pytest.approx(at_nodes, abs=0)
    for exact, marched in zip(*own.values(), strict=True):
        assert marched.sum() == pytest.approx(exact.sum(), rel=0.02)
    assert own_wear(run, x, end) is None
    summed = worn_by(run, run.interface)
    for exact, values in zip(own["self-similar"], summed, strict=True):
        assert values.sum() == pytest.approx(exact.sum(), rel=0.01)
        assert values.sum() != exact.sum()
