"""``slipfront validate``: what it says, writes and returns."""

import json

import numpy as np
import pytest

from compare.records.record import QUANTITIES
from semianalytic import solve
from semianalytic.scene.given.finding import find_scene
from slipfront.cli.commands import main


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    path = tmp_path_factory.mktemp("other") / "run.csv"
    t, x = (
        grid.ravel() for grid in np.meshgrid(np.linspace(0.01, 1, 80), [0.1, 0.5], indexing="ij")
    )
    answer = solve(find_scene("preloaded"))
    columns = [t, x, *(getattr(answer, name)(x, t) for name in QUANTITIES)]
    columns = [*columns[:2], 0.5 * columns[2], 0.5 * columns[3], columns[4], -columns[5]]
    lines = [",".join(["t", "x", *QUANTITIES])]
    lines += [",".join(map(repr, map(float, row))) for row in zip(*columns, strict=True)]
    path.write_text("\n".join(lines))
    return path


def test_right_records_return_0_and_say_first_what_was_inferred(result, tmp_path, capsys):
    output = tmp_path / "out"
    arguments = ["validate", str(result), "--scene", "preloaded", "--spacing", "0.01"]
    assert main([*arguments, "--output", str(output)]) == 0
    said = capsys.readouterr().out
    assert said.startswith("Inferred: slip and slip rate: half of the relative one, doubled;")
    assert "To state it: --slip half --pressure tension" in said
    assert "Verdict: agrees after conversion" in said
    report = json.loads((output / "report.json").read_text())
    assert report["verdict"] == "agrees after conversion"
    assert report["reading"]["stated_by"] == [["slip", "half"], ["pressure", "tension"]]
    assert report["reading"]["left"] < 1e-6
    assert {row["verdict"] for row in report["rows"]} == {"agrees"}
    assert (output / "validation.png").stat().st_size > 10_000


@pytest.mark.slow
@pytest.mark.parametrize(
    ("options", "code"),
    [(["--strict"], 1), (["--strict", "--slip", "half", "--pressure", "tension"], 0)],
)
def test_strict_takes_nothing_that_is_inferred(result, options, code, tmp_path, capsys):
    arguments = ["validate", str(result), "--scene", "preloaded", "--spacing", "0.01"]
    assert main([*arguments, *options, "--output", str(tmp_path / "out")]) == code
    assert ("To state it" in capsys.readouterr().out) == bool(code)


@pytest.mark.slow
def test_wrong_friction_returns_1(result, tmp_path, capsys):
    arguments = ["validate", str(result), "--scene", "preloaded", "--spacing", "0.01"]
    assert main([*arguments, "--friction", "0.309", "--output", str(tmp_path)]) == 1
    assert "Verdict: differs" in capsys.readouterr().out


@pytest.mark.slow
def test_without_spacing_the_option_is_named(result, tmp_path, capsys):
    arguments = ["validate", str(result), "--scene", "preloaded", "--output", str(tmp_path)]
    assert main(arguments) == 0
    assert "give --spacing" in capsys.readouterr().out


@pytest.fixture
def steel(tmp_path):
    """A scene of steel, and a file in mm, mm/s, s and Pa whose contact begins at x = 10 mm."""
    scene = tmp_path / "steel.toml"
    assert main(["init", str(scene), "--material", "steel"]) == 0
    answer, t = solve(find_scene(str(scene))), np.linspace(1e-7, 4e-5, 200)
    rows = ["t,x,slip,slip_rate"]
    for x in (0.02, 0.05):
        pairs = zip(t, answer.slip(x, t), answer.slip_rate(x, t), strict=True)
        rows += [f"{a!r},{1e3 * x + 10},{1e3 * b!r},{1e3 * c!r}" for a, b, c in map(floats, pairs)]
    path = tmp_path / "run.csv"
    path.write_text("\n".join(rows))
    units = ["--length-unit", "mm", "--time-unit", "s", "--stress-unit", "Pa"]
    return ["validate", str(path), "--scene", str(scene), *units]


def floats(row):
    return map(float, row)


@pytest.mark.slow
def test_numbers_with_units_are_what_they_are_in_the_unit_of_the_file(steel, tmp_path, capsys):
    with_units = ["--spacing", "0.5mm", "--noise", "slip=0.02um", "--origin", "1cm"]
    plain = ["--spacing", "0.5", "--noise", "slip=2e-5", "--origin", "10"]
    of_scene = ["--threshold", "1mm/s", "--time-shift", "0us"], ["--threshold", "1e-3"]
    reports = []
    for number, options in enumerate((with_units + of_scene[0], plain + of_scene[1])):
        output = tmp_path / str(number)
        assert main([*steel, *options, "--output", str(output), "--json"]) == 0
        reports.append(json.loads((output / "report.json").read_text()))
    bars = [
        [(row["verdict"], pytest.approx(row["bar"], rel=1e-9)) for row in report["rows"]]
        for report in reports
    ]
    assert bars[0] == [(row["verdict"], row["bar"]) for row in reports[1]["rows"]]


def test_a_position_with_a_unit_needs_that_of_the_file(steel, refused):
    assert "name theirs by --length-unit" in refused([*steel[:4], "--origin", "1cm"])
    said = refused([*steel, "--noise", "slip=3kg"])
    assert "slip: the number must be a number alone or in m, cm" in said


def test_what_cannot_be_read_returns_3_with_the_line(tmp_path, refused):
    path = tmp_path / "odd.csv"
    path.write_text("time,x\n1,2\n")
    assert "line 1" in refused(["validate", path, "--scene", "preloaded"], 3)
    assert not (tmp_path / "results").exists()
