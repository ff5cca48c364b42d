"""Results of UGUCA and SEM2DPACK are judged right, and wrong where they are."""

from pathlib import Path

import pytest

from compare.records.read import read_records
from compare.validation import validate
from semianalytic import find_scene
from slipfront.cli.commands import main

ENTRANTS = Path(__file__).parents[2] / "data" / "entrants"
SHEETS = ("lift-off-shear", "preloaded", "remote-shock", "tap")
MORE_SHEETS = ("antiplane", "auxetic", "lift-off", "stuck", "viscous")
WRONG = {
    ("sem2dpack", "tap", 1),  # its contact closes while the gap is open
    ("sem2dpack", "tap", 3),
    ("sem2dpack", "remote-shock", 1),  # slip rate beside the edge is noisy
}


def runs(code, name):
    """Files of a code on a scene, the finest first."""
    return sorted((ENTRANTS / code / name).glob("*.csv"), key=lambda path: -int(path.stem))


def check_verdict(code, name, count):
    files = runs(code, name)[:count][::-1]
    judged = validate(read_records(files), find_scene(name))
    assert judged.verdict == ("differs" if (code, name, count) in WRONG else "agrees")


@pytest.mark.thinned(18)
@pytest.mark.parametrize("count", [1, 3])
@pytest.mark.parametrize("name", SHEETS)
@pytest.mark.parametrize("code", ["uguca", "sem2dpack"])
def test_codes_are_judged_as_they_are(code, name, count):
    check_verdict(code, name, count)


@pytest.mark.slow
@pytest.mark.parametrize("count", [1, 3])
@pytest.mark.parametrize("name", MORE_SHEETS)
@pytest.mark.parametrize("code", ["uguca", "sem2dpack"])
def test_codes_are_judged_as_they_are_in_more_scenes(code, name, count):
    if (code, name) == ("sem2dpack", "viscous"):
        assert not runs(code, name)  # none of its laws is a film
        return
    check_verdict(code, name, count)


@pytest.mark.thinned(6)
@pytest.mark.parametrize("coarser", [0, 2])
@pytest.mark.parametrize("code", ["uguca", "sem2dpack"])
def test_friction_three_per_cent_off_differs(code, coarser):
    files = runs(code, "preloaded")[1 : 1 + coarser][::-1]
    wrong = ENTRANTS / f"{code}-friction-3-percent-off.csv"
    judged = validate(read_records([*files, wrong]), find_scene("preloaded"))
    assert judged.verdict == "differs"
    assert "strength where it slides" in [row.name for row in judged.having("differs")]


@pytest.mark.thinned(10)
@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (["README.md"], 3, ["line"]),
        (["uguca/preloaded/200.csv"], 0, ["Verdict: agrees"]),
        (["uguca-friction-3-percent-off.csv"], 1, ["Verdict: differs"]),
        (["sem2dpack/preloaded/160.csv"], 0, ["Verdict: agrees"]),
        (["sem2dpack-friction-3-percent-off.csv"], 1, ["Verdict: differs"]),
        (
            ["uguca-own-files/preloaded.info", "--origin", "2.115", "--spacing", "0.01"],
            0,
            ["Inferred: pressure: tension is positive", "upper face alone", "one face, doubled"],
        ),
        (
            ["sem2dpack-own-files/preloaded", "--spacing", "1.25"]
            + [word for name in ("length", "time", "slip") for word in ("--scale", f"{name}=.01")],
            0,
            ["tension is positive", "--pressure tension"],
        ),
        (["nothing.csv"], 3, ["does not exist"]),
        (["uguca/preloaded/200.csv", "--column", "x"], 2, ["--column must be"]),
    ],
)
def test_one_command_says_so(arguments, code, words, tmp_path, capsys):
    path, *options = arguments
    given = ["validate", str(ENTRANTS / path), "--scene", "preloaded", *options]
    assert main([*given, "--output", str(tmp_path / "out")]) == code
    said = capsys.readouterr()
    shown = " ".join((said.out + said.err).split())
    assert [word for word in words if word not in shown] == []
    written = {file.name for file in (tmp_path / "out").glob("*")}
    assert written == ({"report.json", "validation.png"} if code < 2 else set())
