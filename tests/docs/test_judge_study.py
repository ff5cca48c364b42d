"""How far the judge can be trusted: what is spoilt, how it is searched, what it comes to."""

import math
from dataclasses import replace

import numpy as np
import pytest
from catalogue import solved

from compare.comparison.rows import AGREES, DIFFERS, UNRESOLVED
from compare.output.tables import append_rows, sound_rows, started_rows
from docs.studies.judge import fronts as judge_fronts
from docs.studies.judge import spoils, spoilt_trials, tables
from docs.studies.judge import trials as judge_trials
from docs.studies.judge.__main__ import main
from docs.studies.judge.fronts import drawn
from docs.studies.judge.held_slot import held_slot
from docs.studies.judge.rows import JudgedRow, SpoiltRow
from docs.studies.judge.scenes import HISTORIES, OPENINGS, STEPS, draw, power_scenes
from docs.studies.judge.spoils import SPOILS, Window, effect, spoilt
from docs.studies.judge.spoilt_answers import profiled
from docs.studies.judge.spoilt_trials import SHARES, TRUTH
from docs.studies.judge.trials import run_trials
from docs.studies.pages import read_data
from semianalytic import Answer, CoulombFriction, SlipWeakening, solve
from semianalytic.cut.load import contact_opens
from semianalytic.scene.given.finding import find_scene
from tests.catalogue import REMOTE, SHOCK, over, unit_scene

WINDOW = Window(end_time=1.0, time_step=0.01, reach=2.0)
X = np.linspace(0.01, 2.0, 200)
NAMED = {spoil.name: spoil for spoil in SPOILS}


def wrong(name, right, share=1.0):
    return spoilt(NAMED[name], right, WINDOW, share)


# --- scenes -------------------------------------------------------------------------------------


def scenes_of(kind, count):
    return [draw(kind, np.random.default_rng([1, index])).scene for index in range(count)]


@pytest.mark.parametrize("kind", [STEPS, HISTORIES, OPENINGS])
def test_draws_are_the_same_for_the_same_seed_only(kind):
    one, same, other = (draw(kind, np.random.default_rng([1, index])) for index in (4, 4, 5))
    assert one == same
    assert one.scene != other.scene
    assert one.scene.is_self_similar is (kind != HISTORIES)


def test_draws_reach_all_kinds_of_step():
    scenes = scenes_of(STEPS, 60)
    assert {scene.friction == 0 for scene in scenes} == {True, False}
    assert {scene.load_on for scene in scenes} == {"slot", "remote"}
    assert {math.copysign(1, scene.load.shear) for scene in scenes if scene.load.shear} == {1, -1}
    assert {scene.load.pressure > 0 for scene in scenes} == {True, False}
    ratios = [scene.material.poisson_ratio for scene in scenes]
    assert min(ratios) < -0.5
    assert max(ratios) > 0.4


def test_openings_open_from_the_edge_and_ahead_and_steps_do_not():
    scenes = scenes_of(OPENINGS, 12)
    inner = [solved(scene).openings[0].inner for scene in scenes]
    assert {speed > 0 for speed in inner} == {True, False}
    assert {scene.load.shear == 0 for scene in scenes} == {True, False}
    steps = scenes_of(STEPS, 60)
    assert not any(contact_opens(scene) for scene in steps)


def test_histories_weaken_with_slip_if_at_all():
    scenes = scenes_of(HISTORIES, 40)
    laws = {type(scene.friction_law) for scene in scenes}
    assert laws == {CoulombFriction, SlipWeakening}


# --- spoilt answers -----------------------------------------------------------------------------


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


def test_slip_of_a_bent_profile_is_the_integral_of_its_rate():
    bent = wrong("c_R +0.5 %", solved(find_scene("preloaded")))
    t = np.linspace(0.0, 1.0, 4001)
    for x in (0.1, 0.5, 0.95):
        integral = np.trapezoid(bent.slip_rate(x, t), t)
        assert bent.slip(x, 1.0) == pytest.approx(integral, rel=1e-3)


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
    assert other.interface.t[-1] == right.interface.t[-1]
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


def test_the_rayleigh_front_is_moved():
    scene = find_scene("auxetic")
    speed, right = scene.material.rayleigh_speed, solved(scene)
    x = speed * np.linspace(0.98, 1.02, 2001)
    place = x[np.argmin(right.slip_rate(x, 1.0))]
    moved = x[np.argmin(wrong("c_R +0.5 %", right).slip_rate(x, 1.0))]
    assert place == pytest.approx(speed, rel=1e-4)
    assert moved == pytest.approx(1.005 * speed, rel=1e-4)


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


def test_the_articles_algorithm_is_far_off():
    right = solved(SHOCK)
    for name in ("signs as printed", "article's algorithm"):
        assert effect("slip_rate", wrong(name, right), right, X, np.ones(1)) > 1


def test_mistakes_that_make_no_sense_are_not_made():
    stuck, free = solved(unit_scene(2.0, **REMOTE)), solved(unit_scene(0.0))
    for name in ("edge +2 %", "no second zone", "slot held"):
        assert wrong(name, stuck) is None
    assert wrong("friction +3 %", free) is None
    assert wrong("base shear forgotten", free) is None
    assert wrong("article's algorithm", free) is None
    assert (
        wrong("edge +2 %", solve(find_scene("ramp"), method="space-time", end_time=1.0, nodes=50))
        is None
    )
    assert wrong("ν +0.01", solved(unit_scene(nu=0.495))) is None


@pytest.mark.thinned(9)
@over("witness", "exact", without="stuck")
def test_spoilt_answers_answer_all_questions(problem, monkeypatch):
    monkeypatch.setattr(spoils, "_HELD_NODES", 40)
    right = solved(problem.scene)
    for spoil in SPOILS:
        answer: Answer | None = spoilt(spoil, right, WINDOW)
        if answer is None:
            continue
        history = answer.history(X, np.array([0.0, 0.5, 1.0]))
        assert np.isfinite(history.slip).all()
        assert np.isfinite(history.shear_traction).all()
        assert history.slip_rate.shape == (3, len(X))
        assert answer.max_slip(1.0) >= 0.99 * np.abs(history.slip[-1]).max()
        held = problem.scene.superposition.in_place  # of a remote load, the load itself
        assert answer.scene.superposition.in_place.pressure == held.pressure
        assert set(answer.to_xarray(X, history.t)) >= {"slip", "frictional_work"}


def test_a_held_slot_matters_beside_it_only():
    far, near = find_scene("pressure-drop"), find_scene("preloaded")
    for scene, least, most in ((far, 0.0, 0.02), (near, 0.4, 0.7)):
        right, held = solved(scene), held_slot(scene, 200)
        exact = right.slip_rate(held.velocity, 1.0)
        off = np.abs(held.slip_rate - exact).sum() / np.abs(exact).sum()
        assert least <= off < most


# --- the search for sizes of mistakes -----------------------------------------------------------


class Searched(spoilt_trials._Trial):
    """A trial in which a mistake of a share has an effect of two bars, whatever the verdict."""

    def __init__(self, share, verdict):
        self.__dict__.update(right=solved(find_scene("preloaded")), window=WINDOW)
        self.__dict__.update(share=share, verdict=verdict)

    def outcome(self, answer):
        share = (answer.scene.friction / 0.3 - 1) / 0.03
        over_bar = 2.001 * share / self.share
        return spoilt_trials._Outcome(share, 0.0, over_bar, self.verdict, "")


@pytest.mark.thinned(6)
@pytest.mark.parametrize("share", [0.1, *SHARES, 10.0])
def test_sizes_are_chosen_by_effect_and_not_by_verdict(share):
    differs, agrees = (
        Searched(share, verdict).searched(NAMED["friction +3 %"], SHARES)
        for verdict in (DIFFERS, AGREES)
    )
    assert differs.keys() == agrees.keys() >= {1.0}
    assert len(agrees) <= 4
    beyond = [tried for tried, one in agrees.items() if one.over_bar > spoilt_trials.MIDDLE]
    expected = [tried for tried in SHARES if tried >= share]
    assert min(beyond, default=None) == min(expected, default=None)
    below = [tried for tried in agrees if tried < share]
    assert max(below, default=None) == max((s for s in SHARES if s < share), default=None)


# --- what it comes to ---------------------------------------------------------------------------


def judged(index, kind="slip", ratio=0.5, verdict=AGREES, group=STEPS, of=1):
    facts = (group, index, of, 1, 40, False, 1.0, verdict, "name", kind, "1")
    return JudgedRow(*facts, 2.0, ratio, 1.0, kind == "work", verdict)


def test_false_alarms_are_counted_by_row_and_scene():
    rows = [judged(0), judged(0, verdict=DIFFERS, ratio=2.0), judged(1), judged(2)]
    rows += [judged(3, verdict=UNRESOLVED, ratio=math.nan), judged(0, group=HISTORIES)]
    steps, histories, every = tables.alarm_rows(rows)
    assert (steps.scenes, steps.rows, steps.refusals) == (4, 5, 4)
    assert (steps.false_rows, steps.false_scenes, steps.unresolved_rows) == (1, 1, 0.2)
    assert steps.agreeing_scenes == 0.5
    assert (histories.scenes, histories.false_rows) == (1, 0)
    assert (every.group, every.scenes, every.false_scenes) == ("all", 5, 1)
    assert every.rate == tables.upper_limit(1, 5) > histories.rate - 1


@pytest.mark.parametrize(("count", "trials", "limit"), [(0, 59, 0.0495), (1, 93, 0.05), (5, 5, 1)])
def test_the_limit_of_a_rate_is_that_of_tables(count, trials, limit):
    """No alarm in 59 scenes, or one in 93, says that there are less than 5 %."""
    assert tables.upper_limit(count, trials) == pytest.approx(limit, rel=0.02)


def test_coverage_leaves_out_what_is_not_held_against_a_bar():
    rows = [judged(0, ratio=0.4), judged(1, ratio=0.9), judged(2, ratio=2.0, verdict=DIFFERS)]
    rows += [judged(3, ratio=1.2, verdict=UNRESOLVED), judged(4, ratio=9.0, verdict=UNRESOLVED)]
    rows += [judged(5, ratio=0.1, verdict=UNRESOLVED), judged(0, "work", 0.0)]
    slip, work = tables.bar_rows(rows)
    assert (slip.rows, slip.without, slip.covered, slip.within_half) == (4, 2, 0.5, 0.25)
    assert slip.bar == 0.5
    assert (work.kind, work.covered, work.bar) == ("work", 1, 1)


def test_power_is_that_of_scenes_without_a_false_alarm():
    def row(scene, share, verdict, beyond=False, spoil="friction +3 %"):
        over_bar = 2.0 if beyond else 1.4
        return SpoiltRow(scene, 0, 1, spoil, share, 0.1, 0.1, over_bar, verdict, "")

    rows = [row(scene, 0.0, AGREES, spoil=TRUTH) for scene in "abc"]
    rows += [row("d", 0.0, DIFFERS, spoil=TRUTH), row("d", 1.0, DIFFERS, True)]
    rows += [row("a", 1.0, DIFFERS, True), row("a", 0.5, DIFFERS), row("a", 0.25, AGREES)]
    rows += [row("b", 1.0, AGREES, True), row("b", 2.0, AGREES), row("b", 4.0, DIFFERS)]
    rows += [row("c", 1.0, AGREES), row("c", 2.0, AGREES), row("c", 4.0, AGREES)]
    rows += [row("c", 8.0, AGREES), row("a", 1.0, DIFFERS, True, "all slip reversed")]
    friction, reversed_ = tables.power_rows(rows)
    assert (friction.scenes, friction.beyond, friction.caught_beyond) == (3, 2, 0.5)
    assert friction.sure == 0
    assert friction.caught == pytest.approx(1 / 3)
    assert friction.least == pytest.approx(4 * 3)  # [%]; 0.5, 4 and more than 8 times
    assert reversed_.spoil == "all slip reversed"
    assert math.isnan(reversed_.least)


# --- the study ----------------------------------------------------------------------------------


def fake_judged(group, seed, index, resolution):
    return [judged(index, group=group, of=2) for _ in range(2)]


def fake_spoilt(name, index, resolution, bisect):
    return [SpoiltRow(name, index, 1, TRUTH, 0.0, 0.0, 0.0, 0.0, AGREES, "")]


def test_trials_go_on_where_they_were_stopped(tmp_path, monkeypatch):
    done = []

    def in_order(tasks, workers, progress, client):
        for number, (function, arguments) in enumerate(tasks):
            done.append(arguments)
            yield number, function(*arguments)

    monkeypatch.setattr(judge_trials, "run_tasks", in_order)
    monkeypatch.setattr(judge_trials, "judged_rows", fake_judged)
    monkeypatch.setattr(judge_trials, "spoilt_rows", fake_spoilt)
    first = run_trials(tmp_path, quick=True)
    assert run_trials(tmp_path, quick=True) == first
    counts = judge_trials.QUICK_COUNTS
    assert len(done) == sum(counts.values()) + judge_trials.QUICK_POWER
    table = tmp_path / "judge-rows-quick.csv"
    rows = started_rows(table, JudgedRow)
    table.unlink()
    started_rows(table, JudgedRow)
    append_rows(table, rows[:-1])
    assert run_trials(tmp_path, quick=True) == first
    assert done[-1][:3] == (rows[-1].group, judge_trials.SEED, rows[-1].index)
    assert len(done) == sum(counts.values()) + judge_trials.QUICK_POWER + 1
    # two scenes of mistakes have the name of a map, whose points have the same indices
    judged, tried = run_trials(tmp_path, quick=False)
    assert {(row.group, row.index) for row in judged} == {
        (group, index) for group, count in judge_trials.COUNTS.items() for index in range(count)
    }
    assert {row.scene for row in tried} == set(power_scenes())


@pytest.mark.slow
def test_the_judge_is_right_at_a_glance(tmp_path):
    """The quick trial raises few false alarms, and mistakes are caught."""
    assert main(["--quick", "--output", str(tmp_path)]) == 0
    judged_ones, spoilt_ones = run_trials(tmp_path, quick=True)
    alarms = tables.alarm_rows(judged_ones)
    assert sum(row.false_scenes for row in alarms) == 0
    assert all(row.verdict != DIFFERS for row in spoilt_ones if row.spoil == TRUTH)
    sure = [row for row in spoilt_ones if row.over_bar > tables.SURE]
    assert sum(row.verdict == DIFFERS for row in sure) >= 0.9 * len(sure) > 0
    for row in tables.power_rows(spoilt_ones):
        if row.spoil in ("friction +3 %", "all slip reversed", "slot held", "signs as printed"):
            assert row.caught == 1, row.spoil
    assert (tmp_path / "judge.png").stat().st_size > 0


def test_the_docs_hold_what_they_say():
    """The figures of docs/judge.md: no false alarms, honest bars, mistakes beyond them caught."""
    _, alarms = read_data("judge-alarms")
    assert {row["group"] for row in alarms} <= {*judge_trials.COUNTS, "all"}
    for row in alarms:
        false, scenes = int(row["false_scenes"]), int(row["scenes"])
        assert float(row["rate"]) == pytest.approx(tables.upper_limit(false, scenes))
    assert alarms[-1]["group"] == "all"
    assert false == int(alarms[-1]["false_rows"]) == 0
    assert scenes == 500
    _, power = read_data("judge-power")
    assert {row["spoil"] for row in power} <= set(NAMED)
    _, strengths = read_data("judge-strengths")
    tried = {float(row["above"]): int(row["tried"]) for row in strengths}
    caught = {float(row["above"]): float(row["caught"]) for row in strengths}
    assert caught[2.5] == 1
    assert tried[1.5] + tried[2.0] >= 150
    near = tried[1.5] * caught[1.5] + tried[2.0] * caught[2.0]
    assert near >= 0.95 * (tried[1.5] + tried[2.0])
    _, faults = read_data("judge-faults")
    assert all(float(row["caught_beyond"] or 1) == 1 for row in faults)
    _, bars = read_data("judge-bars")
    assert all(float(row["covered"]) >= 0.9 for row in bars if int(row["rows"]) >= 20)


def test_power_scenes_differ():
    scenes = power_scenes()
    assert len({repr(scene) for scene in scenes.values()}) == len(scenes) >= 15
    assert not all(scene.is_self_similar for scene in scenes.values())
    assert sum(len(solved(one).zones) > 1 for one in scenes.values() if one.is_self_similar) >= 4
    assert {one.friction == 0 for one in scenes.values()} == {True, False}


def test_scenes_under_moving_fronts_are_judged_once_and_summed_up(tmp_path, monkeypatch):
    monkeypatch.setattr(judge_fronts, "RESOLUTION", 16)
    assert drawn(3)[0] == drawn(3)[0] != drawn(7)[0]
    trials, bars = tmp_path / "trials" / "trials.csv", tmp_path / "bars.csv"
    first = judge_fronts.main(trials, bars, count=1)
    assert first[0].load == "P"
    assert first[0].rows == first[-1].rows > 5
    assert first[0].within == 1.0
    text = trials.read_text()
    assert judge_fronts.main(trials, bars, count=1) == first
    assert trials.read_text() == text
    row = sound_rows(trials, judge_fronts.TrialRow)[0]
    beyond = judge_fronts.summary([replace(row, bars=2.0, verdict=DIFFERS, undecided=False)])
    assert (beyond[0].within, beyond[0].most, beyond[-1].differing) == (0.0, 2.0, 1)
