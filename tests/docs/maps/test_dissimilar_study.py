"""Studies of different bodies: a small map, its figure, and the tables of docs."""

import pytest

from docs.studies.dissimilar.__main__ import FIELDS, STUDIES, map_rows, threshold_row
from docs.studies.dissimilar.pairs import fields_rows, honesty, stated_rows
from docs.studies.pages import read_data


def test_waves_grow_above_the_thresholds_alone():
    for contrast in (1.1, 1.5, 2.5):
        curve = threshold_row(contrast)
        for row in map_rows("map", contrast, 6):
            assert (row["with"] > 0) == (row["friction"] > curve["threshold_with"])
            assert (row["against"] > 0) == (row["friction"] > curve["threshold_against"])


@pytest.mark.parametrize("name", ["thresholds", pytest.param("halflines", marks=pytest.mark.slow)])
def test_tables_of_docs_are_what_their_command_makes(name):
    (study,) = (study for study in STUDIES if study.name == f"dissimilar-{name}")
    points = study.points(False)[: None if name == "thresholds" else 1]
    _, kept = read_data(study.name)
    for point, written in zip(points, kept, strict=name == "thresholds"):
        row = study.row(*point)
        for key, value in written.items():
            assert float(value) == pytest.approx(row[key], rel=1e-9, nan_ok=True)


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
