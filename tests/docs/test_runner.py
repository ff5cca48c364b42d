"""The runner of studies: rows are kept, tables name their command, figures show their rows."""

import math
from dataclasses import dataclass

import pytest

from docs.studies.pages import read_data
from docs.studies.runner import Study, drawn, main

CALLS = []


@dataclass(frozen=True)
class Found:
    word: str
    y: int
    x: int
    value: float


def row(word, x):
    CALLS.append((word, x))
    return [Found(word, len(word) + ord(word[0]), x, x / 3 if x < 3 else math.nan)]


def points(quick):
    return [(word, x) for word in ("one", "two") for x in ((1,) if quick else (1, 2, 3))]


def largest(rows):
    return [{"largest": max(row["value"] for row in rows if row["value"] == row["value"])}]


def curves(rows):
    panel = {"x": "x", "y": "value", "by": ("word",), "failed": lambda row: row["x"] == 3}
    coloured = {"x": "x", "y": "y", "value": "word", "colours": {"one": "red", "two": "blue"}}
    return drawn(
        rows, [panel | {"yscale": "log"}, panel | {"where": {"word": "one"}}, coloured], ""
    )


STUDIES = [
    Study("all", points, row, figures={"curves": curves}),
    Study("worst", points, row, largest),
]


@pytest.fixture(autouse=True)
def _empty(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    CALLS.clear()


def test_a_table_names_its_command_and_a_figure_is_drawn(tmp_path):
    assert main("docs.studies.some", STUDIES, ["all", "--output", "docs"]) == 0
    command, rows = read_data("all", tmp_path / "docs" / "data")
    assert command == "python -m docs.studies.some all --output docs"
    assert rows[0] == {"word": "one", "y": "114", "x": "1", "value": str(1 / 3)}
    assert [row["value"] for row in rows].count("nan") == 2
    assert (tmp_path / "docs" / "figures" / "curves.png").stat().st_size > 1000


def test_finished_points_are_kept_until_asked_anew(tmp_path):
    main("docs.studies.some", STUDIES, ["worst", "--quick"])
    journal = tmp_path / "results" / "studies" / "worst-quick.jsonl"
    lines = journal.read_text().splitlines()
    journal.write_text("\n".join([*lines[:-1], lines[-1][:9]]))  # killed within its last line
    CALLS.clear()
    main("docs.studies.some", STUDIES, ["worst", "--quick"])
    assert CALLS == [("two", 1)]
    main("docs.studies.some", STUDIES, ["worst", "--quick"])
    assert len(CALLS) == 1
    main("docs.studies.some", STUDIES, ["worst", "--quick", "--fresh"])
    assert len(CALLS) == 3
    assert read_data("worst", tmp_path / "results" / "data")[1] == [{"largest": str(1 / 3)}]


def test_an_unknown_study_is_refused(capsys):
    with pytest.raises(SystemExit, match="2"):
        main("docs.studies.some", STUDIES, ["speed"])
    assert "no study speed; there are all, worst" in capsys.readouterr().err


def test_panels_show_the_rows_they_choose():
    rows = [vars(one) for word, x in points(False) for one in row(word, x)]
    first, second, third = curves(rows).axes
    assert [list(line.get_xdata()) for line in first.lines if len(line.get_xdata()) > 1] == [
        [1, 2],
        [1, 2],
    ]
    assert len(second.lines) == 2  # a curve and the cross of the row without a value
    assert third.collections[0].get_array().tolist() == [[0, 1], [0, 1], [0, 1]]
