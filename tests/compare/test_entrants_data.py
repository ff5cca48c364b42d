"""Results of codes that are not ours: readable, right or known to be wrong, judged as they are."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from compare.records.read import read_records
from compare.validation import validate
from docs.studies.pages import ROOT, read_data
from semianalytic.scene.given.named import NAMED_PAIRS
from slipfront import find, solve
from slipfront.cli.commands import main

ENTRANTS = ROOT / "tests" / "data" / "entrants"
COLUMNS = ("t", "x", "slip_rate", "slip", "shear_traction", "pressure")
STATIONS = (0.1, 0.25, 0.5, 0.75, 0.95)
QUANTITIES = COLUMNS[2:]
MOST = {
    "sem2dpack/antiplane": (1.4, 0.2, 0.17, 0),
    "sem2dpack/auxetic": (2.2, 0.36, 2.2, 0),
    "sem2dpack/lift-off": (0, 0, 0, 0.09),
    "sem2dpack/lift-off-shear": (0.55, 0.26, 0.55, 0.09),
    "sem2dpack/pair-opening": (0.96, 0.15, 0.48, 0.074),
    "sem2dpack/pair-slip": (0.5, 0.16, 0.27, 0.031),
    "sem2dpack/preloaded": (0.73, 0.2, 0.32, 0),
    "sem2dpack/pulse": (2.2, 0.19, 0.2, 0),
    "sem2dpack/remote-shock": (3.7, 0.7, 0.19, 0.18),
    "sem2dpack/stuck": (0, 0, 0.27, 0.18),
    "uguca/antiplane": (0.64, 0.03, 0.28, 0),
    "uguca/auxetic": (3.1, 0.57, 1.4, 0),
    "uguca/lift-off": (0, 0, 0, 0.1),
    "uguca/lift-off-shear": (0.31, 0.01, 0.42, 0.1),
    "uguca/pair-opening": (0.6, 0.028, 0.53, 0.093),
    "uguca/pair-slip": (0.27, 0.0125, 0.245, 0.029),
    "uguca/preloaded": (0.22, 0.01, 0.22, 0),
    "uguca/pulse": (0.95, 0.015, 0.16, 0),
    "uguca/remote-shock": (0.62, 0.5, 0.21, 0.17),
    "uguca/stuck": (0, 0, 0.25, 0.17),
    "uguca/tap": (0, 0, 0, 1.7),
    "uguca/viscous": (0.23, 0.01, 0.16, 0),
}
"""Errors of `QUANTITIES` on the finest grid [%], a third above what they are; 0 for rounding."""
ROUNDING = 1e-9
CLOSES_EARLY = "sem2dpack/tap"


def labels(path):
    """What the comment lines of a file say."""
    lines = (line for line in path.read_text().splitlines() if line.startswith("# "))
    return dict(line[2:].split(": ", 1) for line in lines)


def table(path):
    """Columns by name."""
    lines = [line for line in path.read_text().splitlines() if not line.startswith("#")]
    assert tuple(lines[0].split(",")) == COLUMNS
    return dict(zip(COLUMNS, np.loadtxt(lines[1:], delimiter=",").T, strict=True))


def runs(folder):
    """Files of a code on a sheet, from few cells to many."""
    return sorted((ENTRANTS / folder).glob("*.csv"), key=lambda path: int(path.stem))


@cache
def exact(name):
    return solve(name) if name in NAMED_PAIRS else solve(find(name))


def error(path, quantity):
    """L1 error over times and stations over the L1 norm of the answer, or over 1 without one."""
    run, answer = table(path), exact(labels(path)["benchmark"])
    after = run["t"] > 0
    right = getattr(answer, quantity)(run["x"][after], run["t"][after])
    norm = np.abs(right).mean()
    return np.abs(run[quantity][after] - right).mean() / (norm if norm > ROUNDING else 1.0)


@pytest.mark.thinned(2)
@pytest.mark.parametrize("path", sorted(ENTRANTS.rglob("*.csv")), ids=lambda path: path.name)
def test_files_are_of_the_form_that_all_hand_in(path):
    run, said = table(path), labels(path)
    assert set(run["x"]) == set(STATIONS)
    assert all(np.isfinite(column).all() for column in run.values())
    assert np.all(np.diff(run["t"])[np.diff(run["x"]) == 0] > 0)
    assert run["t"].max() == pytest.approx(1.0)
    assert said.keys() >= {"benchmark", "code", "version", "commit", "licence", "cells", "seconds"}
    if path.parent.parent.parent == ENTRANTS:
        assert (said["benchmark"], said["cells"]) == (path.parent.name, path.stem)


def test_every_folder_is_looked_at():
    folders = {
        f"{path.parent.parent.name}/{path.parent.name}" for path in ENTRANTS.glob("*/*/*.csv")
    }
    assert folders == {*MOST, CLOSES_EARLY}
    assert all(len(runs(folder)) == 3 for folder in folders)


@pytest.mark.thinned(6)
@pytest.mark.parametrize("folder", MOST)
def test_errors_fall_with_cells_and_stay_small(folder):
    coarse, *_, fine = runs(folder)
    for quantity, most in zip(QUANTITIES, MOST[folder], strict=True):
        assert error(fine, quantity) <= max(most / 100, ROUNDING)
        assert error(fine, quantity) <= max(0.7 * error(coarse, quantity), ROUNDING)


def test_contact_that_closes_before_its_gap_stays_wrong():
    assert all(error(path, "pressure") > 0.04 for path in runs(CLOSES_EARLY))
    fine = table(runs(CLOSES_EARLY)[-1])
    early = (fine["x"] == 0.5) & (fine["t"] > 0.7) & (fine["t"] < 0.9)
    answer = exact("tap")
    assert answer.gap(0.5, fine["t"][early]).min() > 0
    assert answer.pressure(0.5, fine["t"][early]).max() == 0
    assert fine["pressure"][early].min() > 0.1 * answer.scene.base.pressure


@pytest.mark.parametrize("code", ["uguca", "sem2dpack"])
def test_friction_three_per_cent_off_is_worse(code):
    right, wrong = runs(f"{code}/preloaded")[-1], ENTRANTS / f"{code}-friction-3-percent-off.csv"
    assert labels(right)["cells"] == labels(wrong)["cells"]
    assert error(wrong, "slip") > 10 * error(right, "slip")
    assert error(wrong, "slip_rate") > 3 * error(right, "slip_rate")


@pytest.mark.thinned(2)
@pytest.mark.parametrize("name", NAMED_PAIRS)
def test_an_answer_whose_lower_body_is_three_per_cent_stiffer_is_worse(name, monkeypatch):
    path, pair = runs(f"uguca/{name}")[-1], find(name)
    right = {quantity: error(path, quantity) for quantity in QUANTITIES}
    lower = replace(pair.lower, shear_modulus=1.03 * pair.lower.shear_modulus)
    monkeypatch.setitem(globals(), "exact", lambda _: solve(replace(pair, lower=lower)))
    assert error(path, "slip") > 20 * right["slip"]
    assert error(path, "slip_rate") > 2 * right["slip_rate"]
    assert error(path, "pressure") > 1.5 * right["pressure"]


def test_own_files_of_uguca_are_the_ones_read():
    folder = ENTRANTS / "uguca-own-files"
    x = np.loadtxt(folder / "preloaded.coord")[:, 0] - 2.115
    top = np.loadtxt(folder / "preloaded-DataFiles" / "top_disp_0.out")
    slip = 2 * np.array([np.interp(STATIONS, x, row) for row in top]).T
    assert slip.ravel() == pytest.approx(table(runs("uguca/preloaded")[1])["slip"], rel=1e-4)


@pytest.mark.parametrize(("sheet", "sign"), [("preloaded", 1), ("antiplane", -1)])
def test_own_files_of_sem2dpack_are_the_ones_read(sheet, sign):
    folder = ENTRANTS / "sem2dpack-own-files" / sheet
    heading = (folder / "Flt01_sem2d.hdr").read_text().splitlines()
    points, fields, samples = map(int, heading[1].split()[:3])
    assert [float(line.split()[0]) / 100 for line in heading[4:]] == pytest.approx(STATIONS)
    rows = np.fromfile(folder / "Flt01_sem2d.dat", dtype="<f4")
    slip = sign * rows.reshape(samples, fields, points + 2)[:, 0, 1:-1].T / 100
    assert slip.ravel() == pytest.approx(table(runs(f"sem2dpack/{sheet}")[1])["slip"], rel=1e-4)


def test_league_runs_are_those_of_the_files():
    command, rows = read_data("league-runs")
    assert __file__.endswith(command.split()[1].rstrip(";"))
    told = {(row["sheet"], row["code"], row["cells"]): float(row["seconds"]) for row in rows}
    files = [labels(path) for folder in {*MOST, CLOSES_EARLY} for path in runs(folder)]
    assert told == {
        (said["benchmark"], said["code"], said["cells"]): float(said["seconds"]) for said in files
    }


# --- how they are validated -----------------------------------------------------------------------

WRONG = {
    ("sem2dpack/tap", 1),  # its contact closes while the gap is open
    ("sem2dpack/tap", 3),
    ("sem2dpack/remote-shock", 1),  # slip rate beside the edge is noisy
}


@pytest.mark.thinned(40)
@pytest.mark.parametrize("count", [1, 3])
@pytest.mark.parametrize("folder", [one for one in (*MOST, CLOSES_EARLY) if "pair" not in one])
def test_codes_are_judged_as_they_are(folder, count):
    judged = validate(read_records(runs(folder)[-count:]), find(folder.partition("/")[2]))
    assert judged.verdict == ("differs" if (folder, count) in WRONG else "agrees")


@pytest.mark.thinned(6)
@pytest.mark.parametrize("coarser", [0, 2])
@pytest.mark.parametrize("code", ["uguca", "sem2dpack"])
def test_friction_three_per_cent_off_differs(code, coarser):
    files = runs(f"{code}/preloaded")[:coarser]
    wrong = ENTRANTS / f"{code}-friction-3-percent-off.csv"
    judged = validate(read_records([*files, wrong]), find("preloaded"))
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
