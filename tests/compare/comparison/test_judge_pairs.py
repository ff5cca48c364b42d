"""Exact answers for two different bodies against finite elements: right, and wrong on purpose."""

from functools import cache

import numpy as np
import pytest
from compare_cases import Spoilt, differing, named

from compare import judge
from compare.comparison.mesh_choice import choose_mesh
from compare.comparison.report import report_document
from compare.studies.dissimilar.judged import SEED, drawn_rows, wrong_ones
from compare.studies.dissimilar.pairs import SCENES, random_pair
from docs.studies.pages import read_data
from fem import simulate, with_companions
from semianalytic import Material, Pair, SceneError, Tractions, find_pair, solve, solve_pair

RESOLUTION = 48


@cache
def simulated(name):
    """A finite-element run of two bodies with its companions; each is run once for all tests."""
    pair = pair_called(name)
    return with_companions(
        simulate(pair.alike, 1.0, resolution=RESOLUTION, lower_material=pair.lower)
    )


@cache
def answer_to(pair):
    """The answer, to far less than any bar; each is solved once for all tests."""
    return solve_pair(pair, rtol=1e-5)


def pair_called(name):
    return SCENES[name] if name in SCENES else find_pair(name)


@pytest.mark.parametrize("name", ["pair-slip", "pair-opening", "both senses", "film"])
def test_the_right_answer_does_not_differ(name):
    judgement = judge(answer_to(pair_called(name)), simulated(name))
    assert judgement.having("differs") == ()
    rows = named(judgement)
    for quantity in ("slip rate", "slip", "shear traction", "pressure"):
        assert rows[f"{quantity}, L1"].verdict == "agrees"
    assert rows["pressure, place by place"].verdict == "agrees"
    assert {"accumulated |slip|, L1", "frictional work, L1"} <= rows.keys()
    if name == "pair-opening":
        assert rows["gap, L1"].verdict == "agrees"
        assert rows["opening 1, outer edge"].exact == pytest.approx(0.2360, abs=1e-4)


def test_the_first_front_is_that_of_the_faster_body():
    judgement = judge(answer_to(find_pair("pair-slip")), simulated("pair-slip"))
    row = named(judgement)["lower P front, interface (shear traction)"]
    assert row.exact == pytest.approx(2.5)  # over c_t of the upper body, whose P wave has 1.73
    assert row.verdict == "agrees"
    assert judgement.case.fastest_speed == find_pair("pair-slip").lower.longitudinal_speed


@pytest.mark.parametrize(
    ("name", "wrong"),
    [
        ("pair-slip", "friction"),
        ("pair-slip", "exchanged"),
        ("pair-opening", "friction"),
        ("pair-opening", "exchanged"),
        ("both senses", "exchanged"),
    ],
)
def test_wrong_answers_differ(name, wrong):
    answer = answer_to(wrong_ones(pair_called(name))[wrong])
    judgement = judge(answer, simulated(name))
    assert judgement.verdict == "differs", judgement.counts


def test_a_missing_zone_is_told():
    """The outermost zone of three, ahead of the shear waves of the upper body, is left out."""
    answer = answer_to(SCENES["both senses"])

    def without(x, t):
        x, t = np.broadcast_arrays(np.asarray(x, float), t)
        return np.where(x > 1.5 * t, 0.0, answer.slip_rate(x, t))

    spoilt = Spoilt(answer, slip_rate=without, zones_at=lambda t: answer.zones_at(t)[:-1])
    judgement = judge(spoilt, simulated("both senses"))
    assert judgement.verdict == "differs"
    assert any(name.startswith("unpredicted slip") for name in differing(judgement))


def test_bodies_on_which_errors_of_the_mesh_grow_are_unresolved_and_agree_with_more_damping():
    """Number 20 of the table, whose meshes move apart: the answer is right, and nothing differs."""
    pair = random_pair(np.random.default_rng([SEED, 20]))
    answer, judged = answer_to(pair), {}
    for damping in (0.02, 0.2):
        run = simulate(
            pair.alike, 1.0, resolution=RESOLUTION, lower_material=pair.lower, damping=damping
        )
        judged[damping] = judge(answer, with_companions(run))
        assert judged[damping].having("differs") == ()
    assert judged[0.02].verdict == "unresolved"
    told = [row for row in judged[0.02].rows if "raise `damping`" in row.obstacle]
    assert max(row.over_bar for row in told) > 1.4
    assert judged[0.2].verdict == "agrees"
    assert named(judged[0.2])["slip, L1"].difference < 0.01


def test_answers_for_identical_bodies_are_refused():
    with pytest.raises(SceneError, match="give the answer of solve_pair"):
        judge(solve(find_pair("pair-slip").alike), simulated("pair-slip"))


def test_the_report_has_both_bodies_and_the_exact_answer():
    document = report_document(
        judge(answer_to(find_pair("pair-slip")), simulated("pair-slip")), "pair-slip"
    )
    assert document["parameters"]["lower_material"]["shear_modulus"] == 2.5
    assert document["method"] == "self-similar"
    assert document["semianalytic"]["pair"]["lower_material"]["density"] == 1.2
    assert document["units"]["parameters"]["lower_material"]["density"] == "mass/length^3"


def test_the_mesh_follows_the_shear_waves_of_a_slower_lower_body():
    upper, slow = Material(1.0, 1.0, 0.25), Material(0.01, 1.0, 0.25)
    pair = Pair(upper, slow, 0.2, Tractions(1.0, 0.0), Tractions(0.0, 1.0))
    choice = choose_mesh(None, pair.alike, lower_material=slow)
    assert choice.resolution == 160  # 16 elements over the way of its shear waves
    assert "shear waves of the slower body" in choice.reason
    assert choose_mesh(None, pair.alike).resolution == 100


def test_right_answers_of_the_table_agree_and_wrong_ones_differ():
    for name, least in (("judged", 8), ("drawn", 15)):
        _, rows = read_data(f"dissimilar-{name}")
        assert {row["verdict"] for row in rows} <= {"agrees", "unresolved"}
        assert sum(row["verdict"] == "agrees" for row in rows) >= least
        assert all(row["differ"] == "0" and float(row["over_bar"]) <= 1 for row in rows)
    _, rows = read_data("dissimilar-judged")
    assert {row["friction"] for row in rows} == {"differs"}
    assert {row["exchanged"] for row in rows} == {"differs", "refused"}


@pytest.mark.slow
def test_a_random_pair_is_judged_as_in_the_table():
    (row,) = drawn_rows(1)
    (kept, *_) = read_data("dissimilar-drawn")[1]
    assert (row.scene, row.verdict, row.exchanged) == (
        kept["scene"],
        kept["verdict"],
        kept["exchanged"],
    )
