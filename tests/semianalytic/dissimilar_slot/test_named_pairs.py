"""Two different bodies by name: found, solved, listed, and told apart from scenes and lines."""

import pytest

import slipfront as sf
from semianalytic.scene.given.finding import find_blocks, scene_label
from semianalytic.scene.given.named import LINES, NAMED_PAIRS, NAMED_SCENES
from slipfront.cli.scenes.completion import scene_names

every = pytest.mark.parametrize("name", NAMED_PAIRS)


def test_no_name_is_taken_twice():
    assert not set(NAMED_PAIRS) & {*NAMED_SCENES, *LINES}
    assert all(one.lower is None for one in NAMED_SCENES.values())


@every
def test_a_name_is_that_of_both_bodies(name):
    pair, (scene, lower) = sf.find_pair(name), find_blocks(name)
    assert pair.alike == scene
    assert pair.lower == lower != pair.upper
    assert scene_label(name) == name
    assert name in scene_names("pair")


@pytest.mark.parametrize(
    ("name", "edges", "opening"),
    [("pair-slip", [0.0, 0.7614591804], None), ("pair-opening", [0.2360, 0.7222], 0.2360)],
)
def test_a_name_is_solved(name, edges, opening):
    answer = sf.solve_pair(name)
    assert answer.edge_speeds[0].tolist() == pytest.approx(edges, abs=5e-5)
    assert [part.outer for part in answer.openings] == pytest.approx(
        [] if opening is None else [opening], abs=5e-5
    )


@every
def test_what_knows_identical_bodies_only_names_what_can(name):
    for function in (sf.find_scene, sf.solve, sf.predict, lambda one: sf.march(one, 1.0)):
        with pytest.raises(sf.SceneError, match="solve_pair in Python"):
            function(name)


def test_a_misspelt_name_is_guessed():
    with pytest.raises(sf.SceneError, match="did you mean pair-opening"):
        sf.find_pair("pair-openin")


def test_the_list_has_both_bodies(printed):
    rows = {row["name"]: row for row in printed("scenes")["scenes"]}
    for name, named in NAMED_PAIRS.items():
        assert rows[name]["what"] == "two bodies"
        assert rows[name]["scene"]["lower_material"]["density"] == named.lower.density
    assert "lower_material" not in rows["preloaded"]["scene"]


@pytest.mark.thinned(2)
@every
def test_the_command_solves_it(name, printed):
    document = printed(f"solve {name}")
    assert document["zones"][0]["outer"] == sf.solve_pair(name).zones[0].outer
