"""The judge on predictions that were marched, and what it does not judge."""

import math
from dataclasses import replace

import pytest
from catalogue import solved
from compare_cases import differing, named, sampled_run, simulated

from compare import judge
from compare.comparison.prediction import method_of, predict_like, seconds_of
from fem import simulate
from semianalytic import Material, Scene, SceneError, SlipWeakening, Tractions
from semianalytic.scene.given.finding import find_scene
from semianalytic.scene.given.overriding import override_scene

PRELOADED = find_scene("preloaded")


@pytest.fixture(scope="module")
def solution():
    return solved(PRELOADED)


@pytest.fixture(scope="module")
def coarse():
    """A finite-element run of the preloaded scene."""
    return simulated(PRELOADED, 60)


@pytest.mark.thinned(2)
@pytest.mark.parametrize("name", ["ramp", "unload"])
def test_a_march_is_judged(name):
    run = simulated(find_scene(name), 60)
    prediction = predict_like(run)
    assert method_of(prediction) == "space-time"
    assert 0 < seconds_of(prediction) < math.inf
    judgement = judge(prediction, run)
    assert differing(judgement) == []
    assert judgement.verdict == "agrees"
    assert not any(row.kind == "arrival" for row in judgement.rows)


def test_a_march_of_another_load_differs():
    run = simulated(find_scene("ramp"), 60)
    other = predict_like(replace(run, scene=find_scene("unload")))
    assert judge(other, run).verdict == "differs"


def test_a_march_of_a_self_similar_scene_is_judged_too(coarse, solution):
    marched = predict_like(coarse, "space-time")
    judgement = judge(marched, coarse)
    assert differing(judgement) == []
    exact = named(judge(solution, coarse))
    for name, row in named(judgement).items():
        if name in exact and row.relative:
            assert row.simulated == exact[name].simulated


def test_what_a_march_misses_makes_its_rows_unresolved():
    """Slip next to the edge within less than a cell: its answer of "no slip" is not believed."""
    scene = override_scene(PRELOADED, friction=20.0)
    run = sampled_run(solved(scene), resolution=40)
    marched = predict_like(run, "space-time")
    assert marched.caution
    judgement = judge(marched, run)
    assert judgement.verdict != "differs"
    for row in judgement.rows:
        if row.kind not in ("arrival", "pressure"):
            reason, times = row.obstacle.removeprefix("the march: "), marched.shortfalls[0].times
            assert marched.caution.startswith(reason)
            assert reason
            assert row.resolution == math.ceil(times * run.resolution)
    assert judge(solved(scene), run).case.caution == ""


@pytest.mark.slow
def test_a_march_that_does_not_reach_as_far_is_refused(coarse):
    from semianalytic import march

    with pytest.raises(SceneError, match="answer"):
        judge(march(PRELOADED, 0.5, 100, length=3.0), coarse)
    with pytest.raises(SceneError, match="answer"):
        judge(march(PRELOADED, 1.0, 100, length=1.0), coarse)


def test_two_materials_are_refused(solution):
    run = simulate(PRELOADED, resolution=14, lower_material=Material(2.0, 1.0, 0.3))
    with pytest.raises(SceneError, match="two materials"):
        judge(solution, run)


@pytest.mark.slow
def test_a_weakening_front_agrees_or_is_unresolved():
    """The slip-weakening scene of issue 14: f from 0.6 to 0.2 within 0.05."""
    scene = Scene(
        Material(1.0, 1.0, 0.25),
        0.6,
        Tractions(1.0, 0.4),
        Tractions(0.0, 0.4),
        friction_law=SlipWeakening(2 / 3, 0.05),
    )
    run = simulated(scene, 100, 2.0)
    assert differing(judge(predict_like(run), run)) == []
