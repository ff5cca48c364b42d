"""``slipfront benchmark``: what it shows, writes and refuses."""

import json

import pytest

from compare.benchmarks.sheets import SHEETS
from slipfront.cli.commands import main


def test_sheets_are_listed_and_shown(capsys):
    assert main(["benchmark"]) == 0
    shown = capsys.readouterr().out
    assert all(name in shown for name in SHEETS)
    assert main(["benchmark", "show", "lift-off"]) == 0
    assert "0 to 0.1875" in capsys.readouterr().out


def test_runs_enter_and_are_scored(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for cells in ("25", "50"):
        assert main(["benchmark", "enter", "march", "preloaded", "--cells", cells]) == 0
    assert main(["benchmark", "enter", "fem", "tap", "--cells", "20", "--output", "f.csv"]) == 0
    files = ["march-preloaded-25.csv", "march-preloaded-50.csv", "f.csv"]
    assert main(["benchmark", "score", *files, "--output", "scores"]) == 0
    shown = capsys.readouterr().out
    assert shown.count("march") >= 2
    assert (tmp_path / "scores" / "scores.png").stat().st_size > 10_000
    scores = json.loads((tmp_path / "scores" / "scores.json").read_text())["scores"]
    assert {one["sheet"] for one in scores} == {"preloaded", "tap"}
    rows = (tmp_path / "scores" / "scores.csv").read_text().splitlines()
    assert rows[0] == "# slipfront benchmark score"
    assert len(rows) == 2 + len(scores)
    by_cells = {one["cells"]: one["error"] for one in scores if one["quantity"] == "slip"}
    assert by_cells[50] < by_cells[25]


def test_a_label_is_no_markup(tmp_path, capsys):
    rows = "".join(f"{t},{x},{t},{t},{t}\n" for t in (0.1, 0.9) for x in (0.1, 0.5))
    text = "# benchmark: antiplane\n# code: a [/x] [bold] $b\\foo$\n"
    text += "t,x,slip,slip_rate,shear_traction\n"
    path = tmp_path / "mine.csv"
    path.write_text(text + rows)
    assert main(["benchmark", "score", str(path), "--output", str(tmp_path / "[/x]")]) == 0
    shown = capsys.readouterr().out
    assert "[/x] [bold]" in shown
    assert "no class" in shown
    assert (tmp_path / "[/x]" / "scores.png").is_file()


@pytest.mark.slow
def test_sheets_are_exported(tmp_path, refused):
    place = tmp_path / "sheets"
    place.mkdir()
    (place / "README.md").write_text("mine")
    assert "--overwrite" in refused(["benchmark", "export", place, "lift-off"])
    assert main(["benchmark", "export", str(place), "lift-off", "--overwrite"]) == 0
    assert (place / "lift-off" / "lift-off.html").is_file()


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (["show", "stick"], 2, "did you mean stuck?"),
        (["show", "zzz"], 2, "choose stuck"),
        (["enter", "dem", "stuck"], 2, "no code called 'dem' to enter; choose fem, march"),
        (["enter", "march", "stuck", "--cells", "3"], 2, "--cells must"),
        (["enter", "march", "tap", "--output", "x.csv"], 2, "tensile"),
        (["score", "none.csv"], 3, "none.csv cannot be read"),
        (["score", "mine.csv"], 2, "does not say of which benchmark it is; give --sheet."),
        (["score", "mine.csv", "--sheet", "tap"], 3, "no column of times"),
    ],
)
def test_refusals_are_one_sentence(tmp_path, refused, monkeypatch, arguments, code, words):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.csv").write_text("a,b\n1,2\n")
    assert words in refused(["benchmark", *arguments], code)
    assert [path.name for path in tmp_path.iterdir()] == ["mine.csv"]
