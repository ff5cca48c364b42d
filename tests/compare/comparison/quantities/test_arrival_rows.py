"""Rows of fronts: which there are, how far off they are, and what cannot be read."""

from dataclasses import replace

import pytest
from catalogue import solved
from compare_cases import sampled_run

from compare.comparison.judgement import side_by_side
from compare.comparison.prediction import predict_like
from compare.comparison.quantities.arrival_rows import arrival_rows
from semianalytic.scene.given.finding import find_scene

IN_PLANE = {"P interface", "Rayleigh slot face", "P slot face"}
PRESENT = {
    "preloaded": IN_PLANE,
    "remote-shock": IN_PLANE,
    "stuck": IN_PLANE,
    "antiplane": {"S interface", "S slot face"},
}
"""The first signal on either face and the Rayleigh signal: an S front behind a P front is too close
to others for the mesh at 2h."""


def rows_of(prediction, run):
    return list(arrival_rows(side_by_side(prediction, run)))


@pytest.mark.thinned(6)
@pytest.mark.parametrize("name", PRESENT)
def test_every_signal_on_either_face_has_one_row(name):
    exact = solved(find_scene(name))
    rows = rows_of(exact, sampled_run(exact))
    assert len({row.name for row in rows}) == len(rows)
    signals = [row.name.split(" (")[0].replace(" front,", "") for row in rows]
    assert sorted(signals) == sorted(PRESENT[name])
    for row in rows:
        assert (row.unit, row.kind) == ("c_t", "arrival")
        # A Rayleigh front is too blurred at 4h to say how fast it converges.
        assert row.verdict == "agrees" or (row.verdict, row.name.split()[0]) == (
            "unresolved",
            "Rayleigh",
        )


@pytest.mark.thinned(2)
@pytest.mark.parametrize("stretch", [0.99, 1.01])
def test_arrivals_off_by_one_percent_say_so(solution, stretch):
    rows = rows_of(solution, sampled_run(solution, stretch=stretch))
    assert len(rows) == 3
    for row in rows:
        # A fifth of an element, 0.01.
        assert row.difference == pytest.approx((stretch - 1) * row.exact, abs=2e-3)
    fastest = [row for row in rows if row.exact == pytest.approx(2.0)]
    assert [row.verdict for row in fastest] == 2 * ["differs"]


@pytest.mark.slow
def test_arrivals_off_by_what_coarser_meshes_are_off_agree_and_say_where_they_are(solution):
    """By 1 % at h, 2 % at 2h, 4 % at 4h."""
    rows = rows_of(solution, sampled_run(solution, stretch=1.01, growth=2.0))
    agreeing = [row for row in rows if row.verdict == "agrees"]
    assert len(agreeing) >= 2
    for row in agreeing:
        assert row.bar > 0.01 * row.exact
    material, exact = solution.scene.material, {row.name.split()[0]: row.exact for row in rows}
    assert exact["P"] == pytest.approx(material.longitudinal_speed / material.shear_speed)
    assert exact["Rayleigh"] == pytest.approx(material.rayleigh_speed / material.shear_speed)


def test_a_mistake_of_the_prediction_does_not_widen_its_bars(solution):
    run = sampled_run(solution)
    wrong = solved(replace(solution.scene, friction=1.2 * solution.scene.friction))
    bars = {row.name: row.bar for row in rows_of(solution, run)}
    widened = {row.name: row.bar / bars[row.name] for row in rows_of(wrong, run)}
    assert len(widened) == 3
    assert max(widened.values()) < 1.1


def test_few_nodes_about_a_front_leave_it_unresolved(solution):
    rows = rows_of(solution, sampled_run(solution, resolution=16))
    (row,) = (row for row in rows if row.name.startswith("Rayleigh"))
    assert row.verdict == "unresolved"
    assert row.obstacle


def test_a_march_that_ends_before_the_fronts_has_none(solution):
    run = sampled_run(solution, resolution=40)
    assert rows_of(predict_like(run, "space-time"), run) == []
