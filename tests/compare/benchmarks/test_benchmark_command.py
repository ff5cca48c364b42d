"""``slipfront benchmark``: what it shows, writes and refuses."""

import hashlib
import json

import pytest

from compare.benchmarks.answers import table_of
from compare.benchmarks.sheets import find_sheet, sheet_names
from slipfront.cli.commands import main


def test_sheets_are_listed_shown_exported_and_scored(tmp_path, capsys):
    assert main(["benchmark"]) == 0
    shown = capsys.readouterr().out
    assert all(name in shown for name in sheet_names())
    assert main(["benchmark", "show", "lift-off"]) == 0
    assert "0 to 0.1875" in capsys.readouterr().out
    assert main(["benchmark", "export", str(tmp_path / "[/x]"), "antiplane", "stuck"]) == 0
    table = tmp_path / "[/x]" / "antiplane" / "antiplane.csv"
    signed = [line.split() for line in (tmp_path / "[/x]" / "SHA256SUMS").read_text().splitlines()]
    assert len(signed) == 6
    for digest, name in signed:
        assert hashlib.sha256((tmp_path / "[/x]" / name).read_bytes()).hexdigest() == digest
    assert table.read_text() == table_of(find_sheet("antiplane"))
    table.write_text("mine")
    assert main(["benchmark", "export", str(tmp_path / "[/x]"), "antiplane", "--overwrite"]) == 0
    capsys.readouterr()
    assert main(["benchmark", "score", str(table), "--json"]) == 0
    scores = json.loads(capsys.readouterr().out)["scores"]
    assert [row["quantity"] for row in scores] == ["arrival", "slip_rate", "slip", "shear_traction"]
    assert max(score["error"] for score in scores[1:]) < 1e-9
    few = tmp_path / "[bold] few.csv"
    rows = "0.1,0.5,0,1\n0.9,0.5,0,1\n9,0.5,0,1\n0.1,0.7123,0,1\n0.2,0.7123,0,1\n"
    few.write_text(f"# benchmark: antiplane\nt,x,slip,heat\n{rows}")
    assert main(["benchmark", "score", str(table), str(few)]) == 0
    shown = capsys.readouterr().out
    assert "antiplane: columns without a known name: heat." in shown
    assert "1 stations that the sheet does not have are left out" in shown
    assert "1 times beyond T are left out" in shown
    assert "[bold]" in shown
    assert "no class (-) below 90 %" in shown


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (["show", "stick"], 2, "did you mean stuck?"),
        (["show", "zzz"], 2, "choose stuck"),
        (["show", "pmma-specimen"], 2, "a specimen of finite size"),
        (["score", "none.csv"], 3, "none.csv cannot be read"),
        (["score", "mine.csv"], 2, "does not say of which benchmark it is; give --sheet."),
        (["score", "mine.csv", "--sheet", "tap"], 3, "no column of times"),
        (["score", "face.csv", "--sheet", "tap"], 3, "holds motion of one face"),
        (["export", "there", "tap"], 2, "--overwrite"),
    ],
)
def test_refusals_are_one_sentence(tmp_path, refused, monkeypatch, arguments, code, words):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.csv").write_text("a,b\n1,2\n")
    (tmp_path / "face.csv").write_text("t,x,u_upper\n0,0.5,1\n1,0.5,2\n")
    (tmp_path / "there" / "tap").mkdir(parents=True)
    (tmp_path / "there" / "tap" / "tap.md").write_text("mine")
    assert words in refused(["benchmark", *arguments], code)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["face.csv", "mine.csv", "there"]
