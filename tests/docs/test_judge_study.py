"""How far the judge can be trusted: what is made wrong, and what the trial comes to."""

import math

import numpy as np
import pytest
from catalogue import solved

from compare.comparison.rows import AGREES, DIFFERS, UNRESOLVED
from docs.studies.trials import judge as trial
from docs.studies.trials.draws import HISTORIES, KINDS, OPENINGS, STEPS, judged_scene
from docs.studies.trials.wrong_answers import MISTAKES, profiled, spoilt
from semianalytic import CoulombFriction, SlipWeakening, solve
from semianalytic.cut.load import contact_opens
from semianalytic.scene.given.finding import find_scene
from tests.catalogue import REMOTE, over, unit_scene

STEP = 0.01
X = np.linspace(0.01, 2.0, 200)


def wrong(name, right, share=1.0):
    return spoilt(name, right, STEP, share)


def effect(field, wrong, right, x, t):
    """Relative L1 difference of a field over positions and times."""
    expected, given = (np.asarray(getattr(one, field)(x, t[:, None])) for one in (right, wrong))
    size = float(np.abs(expected).sum())
    return float(np.abs(given - expected).sum()) / size if size else 0.0


# --- scenes -------------------------------------------------------------------------------------


def scenes_of(kind, count):
    return [judged_scene(kind, np.random.default_rng([1, index])) for index in range(count)]


@pytest.mark.thinned(2)
@pytest.mark.parametrize("kind", KINDS)
def test_draws_are_the_same_for_the_same_seed_only(kind):
    one, same, other = (judged_scene(kind, np.random.default_rng([1, i])) for i in (4, 4, 5))
    assert one == same
    assert one != other


def test_draws_reach_all_kinds_of_step():
    scenes = scenes_of(STEPS, 60)
    assert {scene.friction == 0 for scene in scenes} == {True, False}
    assert {scene.load_on for scene in scenes} == {"slot", "remote"}
    assert {math.copysign(1, scene.load.shear) for scene in scenes if scene.load.shear} == {1, -1}
    assert {scene.load.pressure > 0 for scene in scenes} == {True, False}
    assert not any(contact_opens(scene) for scene in scenes)
    ratios = [scene.material.poisson_ratio for scene in scenes]
    assert min(ratios) < -0.5
    assert max(ratios) > 0.4


def test_openings_open_from_the_edge_and_ahead_and_histories_weaken_with_slip_if_at_all():
    scenes = scenes_of(OPENINGS, 12)
    inner = [solved(scene).openings[0].inner for scene in scenes]
    assert {speed > 0 for speed in inner} == {True, False}
    laws = {type(scene.friction_law) for scene in scenes_of(HISTORIES, 40)}
    assert laws == {CoulombFriction, SlipWeakening}


# --- wrong answers ------------------------------------------------------------------------------


@pytest.mark.thinned(12)
@over("exact", without="thin")
def test_a_profile_is_told_from_its_solution_by_digits_only(problem):
    right = solved(problem.scene)
    table, speed = profiled(right), problem.scene.material.shear_speed
    for field in ("slip_rate", "slip", "shear_traction", "pressure"):
        assert effect(field, table, right, speed * X, np.array([0.7, 1.0])) < 1e-4
    for total in ("max_slip", "accumulated_slip", "frictional_work"):
        expected = getattr(right, total)(0.7)
        np.testing.assert_allclose(getattr(table, total)(0.7), expected, rtol=2e-3)
    assert table.zones_at(0.7) == right.zones_at(0.7)


def test_friction_ratio_and_base_are_those_of_another_scene():
    right = solved(unit_scene(0.3, (1.0, 0.1), (0.0, 1.0)))
    assert wrong("friction +3 %", right).scene.friction == pytest.approx(0.309)
    assert wrong("friction -3 %", right, 2.0).scene.friction == pytest.approx(0.282)
    assert wrong("ν -0.01", right).scene.material.poisson_ratio == pytest.approx(1 / 3 - 0.01)
    assert wrong("base shear forgotten", right).scene.base.shear == 0


def test_a_marched_answer_is_marched_again():
    right = solve(find_scene("ramp"), method="space-time", end_time=1.0, nodes=100)
    other = wrong("friction +3 %", right)
    np.testing.assert_array_equal(other.interface.x, right.interface.x)
    assert 0.01 < effect("slip_rate", other, right, X[:160], np.array([0.5, 1.0])) < 0.03


@pytest.mark.parametrize("sign", ["+", "-"])
def test_an_edge_is_moved_and_its_neighbours_are_not(sign):
    right = solved(find_scene("preloaded"))
    bent = wrong(f"edge {sign}2 %", right)
    share = {"+": 1.02, "-": 0.98}[sign]
    (_, end), (start, outer) = ((zone.start, zone.end) for zone in bent.zones_at(1.0))
    assert end == pytest.approx(share * right.zones[0].outer)
    assert (start, outer) == (right.zones[1].inner, right.zones[1].outer)
    just = np.array([0.999, 1.001]) * end
    assert list(bent.slip_rate(just, 1.0) > 0) == [True, False]


def test_the_second_zone_is_left_out_or_reversed():
    right = solved(find_scene("preloaded"))
    zone = right.zones[1]
    inside = (zone.inner < X) & (zone.outer > X)
    for name, factor, senses in (("no second zone", 0, [1]), ("second zone reversed", -1, [1, -1])):
        answer = wrong(name, right)
        assert [part.sense for part in answer.zones_at(1.0)] == senses
        rate = right.slip_rate(X, 1.0)
        np.testing.assert_allclose(
            answer.slip_rate(X, 1.0), np.where(inside, factor * rate, rate), atol=1e-4
        )
        # what slips behind the second zone has lost what that had slipped before
        lost = right.slip(0.5, 1.0) - answer.slip(0.5, 1.0)
        before = right.slip(0.5, 0.5 / zone.inner)
        assert lost == pytest.approx((1 - factor) * before, rel=1e-3)


def test_late_and_backward_answers():
    right = solved(find_scene("preloaded"))
    table = profiled(right)
    late, back = wrong("a step late", right), wrong("all slip reversed", right)
    np.testing.assert_array_equal(late.slip_rate(X, 1.0), table.slip_rate(X, 0.99))
    assert late.frictional_work(1.0) == table.frictional_work(0.99)
    assert late.zones_at(0.005) == ()
    assert np.all(late.slip(X, 0.005) == 0)
    np.testing.assert_array_equal(back.slip(X, 1.0), -table.slip(X, 1.0))
    np.testing.assert_array_equal(back.shear_traction(X, 1.0), table.shear_traction(X, 1.0))
    assert [zone.sense for zone in back.zones_at(1.0)] == [-1, -1]


def test_mistakes_that_make_no_sense_are_not_made():
    stuck, free = solved(unit_scene(2.0, **REMOTE)), solved(unit_scene(0.0))
    for name in ("edge +2 %", "no second zone", "gap +3 %"):
        assert wrong(name, stuck) is None
    assert wrong("friction +3 %", free) is None
    assert wrong("base shear forgotten", free) is None
    assert (
        wrong("edge +2 %", solve(find_scene("ramp"), method="space-time", end_time=1.0, nodes=50))
        is None
    )
    assert wrong("ν +0.01", solved(unit_scene(nu=0.495))) is None


@pytest.mark.thinned(9)
@over("witness", "exact", without="stuck")
def test_spoilt_answers_answer_all_questions(problem):
    right = solved(problem.scene)
    for mistake in MISTAKES:
        answer = wrong(mistake, right)
        if answer is None:
            continue
        history = answer.history(X, np.array([0.0, 0.5, 1.0]))
        assert np.isfinite(history.slip).all()
        assert np.isfinite(history.shear_traction).all()
        assert answer.max_slip(1.0) >= 0.98 * np.abs(history.slip[-1]).max()
        assert set(answer.to_xarray(X, history.t)) >= {"slip", "frictional_work"}


# --- what it comes to ---------------------------------------------------------------------------


def judged(index, bars=0.5, verdict=AGREES, group=STEPS, judgement=None):
    row = {"group": group, "index": index, "judgement": judgement or verdict, "kind": "slip"}
    return {**row, "name": "name", "verdict": verdict, "bars": bars}


def test_false_alarms_are_counted_by_row_and_scene():
    rows = [judged(0, judgement=DIFFERS), judged(0, 2.0, DIFFERS), judged(1), judged(2)]
    rows += [judged(3, math.nan, UNRESOLVED), judged(0, group=HISTORIES)]
    steps, histories, every = trial.alarms(rows)
    assert (steps["scenes"], steps["rows"]) == (4, 5)
    assert (steps["false_rows"], steps["false_scenes"], steps["unresolved_rows"]) == (1, 1, 0.2)
    assert (steps["agreeing_scenes"], steps["within"], steps["within_half"]) == (0.5, 0.75, 0.75)
    assert (histories["scenes"], histories["false_rows"]) == (1, 0)
    assert (every["group"], every["scenes"], every["false_scenes"]) == ("all", 5, 1)
    assert every["rate"] == trial.upper_limit(1, 5)


@pytest.mark.parametrize(("count", "trials", "limit"), [(0, 59, 0.0495), (1, 93, 0.05), (5, 5, 1)])
def test_the_limit_of_a_rate_is_that_of_tables(count, trials, limit):
    """No alarm in 59 scenes, or one in 93, says that there are less than 5 %."""
    assert trial.upper_limit(count, trials) == pytest.approx(limit, rel=0.02)


def test_power_is_that_of_scenes_without_a_false_alarm():
    def row(scene, bars, verdict, mistake="friction +3 %"):
        return {"scene": scene, "mistake": mistake, "bars": bars, "verdict": verdict, "by": ""}

    rows = [row(scene, 0.0, AGREES, trial.TRUTH) for scene in "abc"]
    rows += [row("d", 0.0, DIFFERS, trial.TRUTH), row("d", 9.0, AGREES)]
    rows += [row("a", 2.0, DIFFERS), row("b", 2.0, AGREES), row("c", 1.4, AGREES)]
    (friction,) = trial.power(rows)
    assert (friction["scenes"], friction["caught"]) == (3, pytest.approx(1 / 3))
    assert (friction["scenes_beyond"], friction["caught_beyond"]) == (2, 0.5)
    assert friction["scenes_sure"] == 0
    assert math.isnan(friction["caught_sure"])


@pytest.mark.slow
def test_the_judge_is_right_at_a_glance():
    """No false alarm in a few scenes of every kind; mistakes that show are caught."""
    rows = [row for point in trial.right_points(True) for row in trial.right_rows(*point)]
    alarms = trial.alarms(rows)
    assert {row["group"] for row in alarms} == {*KINDS, "all"}
    assert alarms[-1]["false_scenes"] == 0
    assert alarms[-1]["within"] > 0.97
    tried = trial.wrong_rows("preloaded", 60)
    assert tried[0]["verdict"] != DIFFERS
    caught = [row["verdict"] in (DIFFERS, "refused") for row in tried if row["bars"] > trial.SURE]
    assert len(caught) > 12
    assert np.mean(caught) >= 0.9


def test_power_scenes_differ():
    scenes = [trial.power_scene(name) for name, _ in trial.wrong_points(False)]
    assert len({repr(scene) for scene in scenes}) == len(scenes) >= 15
    assert not all(scene.is_self_similar for scene in scenes)
    assert sum(len(solved(one).zones) > 1 for one in scenes if one.is_self_similar) >= 4
    assert {one.friction == 0 for one in scenes} == {True, False}
