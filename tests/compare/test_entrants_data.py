"""Results of codes that are not ours: right or known to be wrong, and judged as they are."""

import numpy as np
import pytest

from compare.records.read import read_records
from compare.validation import validate
from docs.studies.pages import ROOT
from semianalytic.parameters.numbers import with_numbers
from slipfront import find, solve
from slipfront.cli.commands import main

ENTRANTS = ROOT / "tests" / "data" / "entrants"
STATIONS = (0.1, 0.25, 0.5, 0.75, 0.95)
QUANTITIES = ("slip_rate", "slip", "shear_traction", "pressure")
MOST = {"sem2dpack": (0.73, 0.2, 0.32, 0), "uguca": (0.22, 0.01, 0.22, 0)}
"""Errors of `QUANTITIES` of `preloaded` on the finest grid [%], a third above what they are."""
PAIR, TAP = ENTRANTS / "uguca/pair-opening/200.csv", ENTRANTS / "sem2dpack/tap/160.csv"


def runs(code):
    """Files of a code on `preloaded`, from few cells to many."""
    return sorted((ENTRANTS / code / "preloaded").glob("*.csv"), key=lambda path: int(path.stem))


def wrong(code):
    return ENTRANTS / f"{code}-friction-3-percent-off.csv"


def errors(path, answer):
    """L1 errors over times and stations over the L1 norm of the answer, by quantity."""
    (run,) = read_records([path])
    assert [record.x for record in run.stations] == list(STATIONS)
    found = []
    for name in QUANTITIES:
        pairs = [(row.values[name], getattr(answer, name)(row.x, row.t)) for row in run.stations]
        seen, right = np.concatenate(pairs, axis=1)
        found.append(np.abs(seen - right).mean() / np.abs(right).mean())
    return np.array(found)


@pytest.mark.parametrize("code", MOST)
def test_errors_fall_with_cells_and_stay_small(code):
    answer = solve("preloaded")
    coarse, *_, fine = (errors(path, answer) for path in runs(code))
    for most, at_first, at_last in zip(MOST[code], coarse, fine, strict=True):
        assert at_last <= max(most / 100, 1e-9)
        assert at_last <= max(0.7 * at_first, 1e-9)
    off = errors(wrong(code), answer)
    assert off[1] > 10 * fine[1]
    assert off[0] > 3 * fine[0]


def test_an_answer_whose_lower_body_is_three_per_cent_stiffer_is_worse():
    pair = find("pair-opening")
    stiffer = with_numbers(pair, {"lower_shear_modulus": 1.03 * pair.lower_material.shear_modulus})
    right, off = (errors(PAIR, solve(scene)) for scene in (pair, stiffer))
    assert np.all(right < (0.006, 0.00028, 0.0053, 0.00093))
    assert np.all(off > np.array([2, 20, 1, 1.5]) * right)


def test_contact_that_closes_before_its_gap_stays_wrong():
    (run,), answer = read_records([TAP]), solve("tap")
    (record,) = (station for station in run.stations if station.x == 0.5)
    early = (record.t > 0.7) & (record.t < 0.9)
    assert answer.gap(0.5, record.t[early]).min() > 0
    assert record.values["pressure"][early].min() > 0.1 * answer.scene.base.pressure
    assert validate([run], "tap").verdict == "differs"


# --- how they are validated -----------------------------------------------------------------------


@pytest.mark.thinned(4)
@pytest.mark.parametrize("count", [1, 3])
@pytest.mark.parametrize("code", MOST)
def test_codes_are_judged_as_they_are(code, count):
    scene, files = find("preloaded"), runs(code)[-count:]
    assert validate(read_records(files), scene).verdict == "agrees"
    judged = validate(read_records([*files[:-1], wrong(code)]), scene)
    assert judged.verdict == "differs"
    assert "strength where it slides" in [row.name for row in judged.having("differs")]


@pytest.mark.thinned(10)
@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (["README.md"], 3, ["line"]),
        (["uguca/preloaded/200.csv"], 0, ["Verdict: agrees"]),
        (["uguca-friction-3-percent-off.csv"], 1, ["Verdict: differs"]),
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
