"""Studies of different bodies: a small map, its figure, and the tables of docs."""

import pytest

from docs.studies.dissimilar.__main__ import FIELDS, STUDIES, growth_figure, map_rows, threshold_row
from docs.studies.dissimilar.pairs import fields_rows, honesty, stated_rows
from docs.studies.pages import read_data


def test_waves_grow_above_the_thresholds_alone():
    for contrast in (1.1, 1.5, 2.5):
        curve = threshold_row(contrast)
        for row in map_rows("map", contrast, 6):
            assert (row["with"] > 0) == (row["friction"] > curve["threshold_with"])
            assert (row["against"] > 0) == (row["friction"] > curve["threshold_against"])


def test_pairs_that_are_met_grow_in_the_map_and_its_figure_shows_them():
    rows = [
        row for name in ("gouge on rock", "rubber on steel") for row in map_rows("named", name, 3)
    ]
    assert [row["growth"] > 0 for row in rows] == [False, False, True, True, True, True]
    rows += [row for contrast in (1.1, 2.5) for row in map_rows("map", contrast, 3)]
    rows += [row for contrast in (1.1, 2.5) for row in map_rows("curves", contrast, 0)]
    mapped, *others = growth_figure(rows).axes
    assert len(mapped.lines) == 2  # both thresholds
    assert len(others) == 2


@pytest.mark.parametrize("name", ["thresholds", pytest.param("halflines", marks=pytest.mark.slow)])
def test_tables_of_docs_are_what_their_command_makes(name):
    (study,) = (one for one in STUDIES if one.name == f"dissimilar-{name}")
    points = study.points(False)[: None if name == "thresholds" else 1]
    _, kept = read_data(study.name)
    for point, written in zip(points, kept, strict=name == "thresholds"):
        row = study.row(*point)
        for key, value in written.items():
            assert float(value) == pytest.approx(row[key], rel=1e-9, nan_ok=True)


def test_estimates_in_docs_bound_all_errors():
    _, rows = read_data("dissimilar-honesty")
    assert [row["solved"] for row in rows] == ["200"] * 3
    for row in rows:
        assert row["below"] == row["compared"]
        assert float(row["worst_ratio"]) < 1


def test_finite_elements_agree_on_random_pairs_and_find_wrong_answers():
    """Bars of slip are below 0.1 on patches and above beside slots, where some are not found."""
    _, rows = read_data("interfaces-drawn")
    right = {(row["pairs"], row["number"]): row for row in rows if row["answer"] == "right"}
    assert len(right) == 30
    assert {row["verdict"] for row in right.values()} == {"agrees", "unresolved"}
    assert sum(row["verdict"] == "agrees" for row in right.values()) >= 27
    for row in rows:
        sharp = float(right[row["pairs"], row["number"]]["slip_bar"]) < 0.1  # a patch
        if sharp and row["answer"] != "right":
            assert row["verdict"] == "differs"
    _, kept = read_data("interfaces-pairs")
    assert [row["differ"] for row in kept if row["answer"] == "right"] == ["0", "0"]


@pytest.mark.slow
def test_errors_of_random_pairs_are_held_against_their_estimates():
    rows = honesty([row for number in range(1, 3) for row in stated_rows(number)])
    assert [row["drawn"] for row in rows] == [2, 2, 2]
    for row in rows:
        assert row["below"] == row["compared"] > 0
        assert row["worst_error"] <= 10 * row["rtol"]


@pytest.mark.slow
def test_finite_elements_witness_exact_fields_in_both_bodies():
    rows = [row for name in FIELDS for row in fields_rows(name, 32)]
    for row in rows:
        assert row["whole"] < row["whole_bar"]
        assert row["away"] < row["away_bar"]
    assert max(row["spoilt"] / row["away_bar"] for row in rows if row["component"] == "u_y") > 2


def test_the_table_of_witnesses_is_within_its_bars():
    _, rows = read_data("dissimilar-witness")
    for row in rows:
        assert float(row["whole"]) < float(row["whole_bar"])
        assert float(row["away"]) < float(row["away_bar"])
    for scene in {row["scene"] for row in rows}:  # an answer of a wrong material is told
        beyond = [float(r["spoilt"]) / float(r["away_bar"]) for r in rows if r["scene"] == scene]
        assert max(beyond) > 4
