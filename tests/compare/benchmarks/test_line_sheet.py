"""The sheet without a slot: its answer, its page, its score, and what does not take it."""

import numpy as np
import pytest

from compare.benchmarks.answers import answer_to, changes, content_of, written_document
from compare.benchmarks.entries import enter, read_run
from compare.benchmarks.export import exported
from compare.benchmarks.pages import as_markdown, sheet_blocks
from compare.benchmarks.scores import score
from compare.benchmarks.sheet import SI_SCALES, STATIONS
from compare.benchmarks.sheets import ALL_SHEETS, LINE_SHEETS, find_sheet
from semianalytic import SceneError, solve_line

SHEET = LINE_SHEETS["whole-line-patch"]


def test_the_written_answer_is_the_one_computed_now():
    assert list(changes(SHEET)) == []
    answers = written_document(SHEET)["answers"]
    assert answers["zones"] == [[-0.395154376971, 0.395154376971, 1.0]]
    assert answers["arrivals"][2:] == [None, None, None]
    assert answers["frictional_work"] == pytest.approx(0.5 * answers["accumulated_slip"], abs=1e-12)


def test_the_si_problem_is_the_same_times_its_scales():
    plain, si = answer_to(SHEET), solve_line(SHEET.si_problem)
    x = np.array(STATIONS)
    for name in ("slip", "slip_rate", "shear_traction", "pressure"):
        ours, theirs = getattr(plain, name)(x, 0.9), getattr(si, name)(x * SI_SCALES["x"], 0.9)
        assert theirs == pytest.approx(ours * SI_SCALES[name], rel=1e-11, abs=1e-9)


def test_the_page_states_the_problem_without_a_slot():
    text = as_markdown(list(sheet_blocks(SHEET)))
    assert "touch along all of y = 0, without a slot" in text
    assert "| speed w of either end of the patch | 0.3 | 600 m/s |" in text
    assert "-0.395154377 to 0.395154377" in text
    assert "without classes" in text
    assert "Tolerance classes" not in text
    assert find_sheet("whole-line-patch") is SHEET
    assert ALL_SHEETS[SHEET.name] is SHEET


def test_an_export_has_page_answer_and_figure():
    contents = exported([SHEET])
    names = {name.removeprefix("whole-line-patch/") for name in contents}
    assert {"whole-line-patch.html", "figure.png", "records.csv", "answers.json"} <= names
    assert not any("uguca/" in name or "sem2dpack/" in name for name in names)


@pytest.mark.parametrize(("factor", "error"), [(1.02, 0.02), (0.9, 0.1)])
def test_a_run_is_scored_by_its_errors(tmp_path, factor, error):
    answer, times = answer_to(SHEET), np.linspace(0.001, 1.0, 700)
    lines = ["# benchmark: whole-line-patch", "# code: mine", "# cells: 100"]
    lines.append("t,x,slip_rate,slip,shear_traction")
    for x in STATIONS:
        fields = (
            answer.slip_rate(x, times),
            answer.slip(x, times),
            answer.shear_traction(x, times),
        )
        rows = np.transpose(
            [times, np.full(700, x), factor * fields[0], factor * fields[1], fields[2]]
        )
        lines += [",".join(f"{value:.10g}" for value in row) for row in rows]
    path = tmp_path / "mine.csv"
    path.write_text("\n".join(lines) + "\n")
    found = {one.quantity: one for one in score(read_run(path))}
    assert found["slip"].error == pytest.approx(error, rel=1e-6)
    assert found["slip_rate"].error == pytest.approx(error, rel=1e-6)
    assert found["shear_traction"].error < 1e-9
    assert found["arrival"].error < 2e-3


@pytest.mark.parametrize("code", ["fem", "march"])
def test_own_codes_do_not_take_it(code):
    with pytest.raises(SceneError, match="takes scenes with a slot"):
        enter(code, SHEET, 100)


def test_what_is_reported_is_there():
    content = content_of(SHEET, answer_to(SHEET))
    assert content["slip_rate"].shape == (33, 5)
    assert all(np.isfinite(content[name]).all() for name in SHEET.report)
