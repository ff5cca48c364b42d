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
def test_bars_shrink_with_the_mesh():
    """Bars of a simulation at h = 1/30 and at h = 1/60."""
    solution = solved(PRELOADED)
    coarse, fine = (
        {row.name: row for row in judge(solution, simulated(PRELOADED, n)).rows} for n in (30, 60)
    )
    both = [
        name
        for name in coarse.keys() & fine.keys()
        if coarse[name].bar is not None and fine[name].bar is not None
    ]
    assert len(both) >= 10
    for name in both:
        # Pressure is that of the base to rounding throughout: its bar is none at all.
        bars = fine[name].bar, coarse[name].bar
        if fine[name].kind == "law":  # what a run has to hold on any mesh, but for rounding
            assert bars == (NOTHING, NOTHING), name
        elif not fine[name].converges:  # its bar is the range of what the meshes show
            assert (name, fine[name].verdict) == ("shear traction, L1", "unresolved")
        else:
            assert bars[0] < bars[1] or name.startswith("pressure, "), name


def test_rounding_is_no_difference():
    """Pressure that is that of the base throughout, to twelve digits on each mesh."""
    solution = solved(PRELOADED)
    rows = {row.name: row for row in judge(solution, rounded(sampled_run(solution, 40))).rows}
    pressure = rows["pressure, L1"]
    assert 0 < pressure.difference < 1e-11
    assert (pressure.verdict, pressure.obstacle) == ("agrees", "")


def rounded(run):
    seen = run.interface
    return replace(
        run,
        interface=replace(seen, pressure=seen.pressure * (1 + 1e-12)),
        companion=run.companion and rounded(run.companion),
    )


def test_without_a_coarser_mesh_a_row_says_so():
    solution = solved(PRELOADED)
    rows = judge(solution, sampled_run(solution, resolution=12, companions=0)).rows
    reasons = [row.obstacle for row in rows if row.kind == "slip"]
    assert set(reasons) == {"no coarser mesh was run, so that it has no error bar"}


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
