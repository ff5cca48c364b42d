"""``slipfront validate``: what it says, writes and returns."""

import json
from pathlib import Path

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
    return f"validate {path} --scene preloaded --output out"


def test_right_records_return_0_and_say_first_what_was_inferred(result, shown):
    said, output = shown(f"{result} --spacing 0.01").out, Path("out")
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
    ("options", "code", "said"),
    [
        ("--spacing 0.01 --strict", 1, "To state it"),
        ("--spacing 0.01 --strict --slip half --pressure tension", 0, "Verdict: agrees"),
        ("--spacing 0.01 --friction 0.309", 1, "Verdict: differs"),
        ("", 0, "give --spacing"),
    ],
)
def test_what_is_stated_and_what_is_wrong_decide_the_verdict(result, options, code, said, shown):
    shown_now = shown(f"{result} {options}", code).out
    assert said in shown_now
    assert ("To state it" in shown_now) == ("--slip" not in options)


@pytest.fixture
def steel(tmp_path):
    """A scene of steel, and a file in mm, mm/s, s and Pa whose contact begins at x = 10 mm."""
    assert main(["init", "steel.toml", "--material", "steel"]) == 0
    answer, t = solve(find_scene("steel.toml")), np.linspace(1e-7, 4e-5, 200)
    rows = ["t,x,slip,slip_rate"]
    for x in (0.02, 0.05):
        numbers = np.stack([t, answer.slip(x, t), answer.slip_rate(x, t)], axis=1).tolist()
        rows += [f"{a!r},{1e3 * x + 10},{1e3 * b!r},{1e3 * c!r}" for a, b, c in numbers]
    (tmp_path / "run.csv").write_text("\n".join(rows))
    return "validate run.csv --scene steel.toml --time-unit s --stress-unit Pa"


@pytest.mark.slow
def test_numbers_with_units_are_what_they_are_in_the_unit_of_the_file(steel, printed):
    with_units = "--spacing 0.5mm --noise slip=0.02um --origin 1cm --threshold 1mm/s"
    plain = "--spacing 0.5 --noise slip=2e-5 --origin 10 --threshold 1e-3"
    first, other = (
        printed(f"{steel} --length-unit mm {options} --output {folder}")["rows"]
        for folder, options in (("one", f"{with_units} --time-shift 0us"), ("other", plain))
    )
    bars = [(row["verdict"], pytest.approx(row["bar"], rel=1e-9)) for row in first]
    assert bars == [(row["verdict"], row["bar"]) for row in other]


def test_a_position_with_a_unit_needs_that_of_the_file(steel, refused):
    assert "name theirs by --length-unit" in refused(f"{steel} --origin 1cm")
    said = refused(f"{steel} --length-unit mm --noise slip=3kg")
    assert "slip: the number must be a number alone or in m, cm" in said


@pytest.mark.parametrize("name", ["tau_xy", "sigma_12", "sxy", "traction0", "shear_force"])
def test_a_verdict_says_what_it_has_not_seen(name, result, tmp_path, capsys):
    """Shear traction twice too large: found under its names, said not to be read under others."""
    lines = [line.split(",") for line in Path(result.split()[1]).read_text().splitlines()]
    rows = [[*line[:4], repr(2 * float(line[4]))] for line in lines[1:]]
    header = ["t", "x", "slip_rate", "slip", name]
    (tmp_path / "a.csv").write_text("\n".join(map(",".join, [header, *rows])))
    line = (
        "validate a.csv --scene preloaded --output out --spacing 0.01 --slip half --sign as-given"
    )
    code = main([*line.split(), "--scale", "stress=1"])
    said, known = " ".join(capsys.readouterr().out.split()), name != "shear_force"
    report = json.loads((tmp_path / "out" / "report.json").read_text())
    assert ((code, report["verdict"]) == (1, "differs")) == known
    assert report["unread"] == ([] if known else [name])
    assert ("does not cover: columns without a known name: shear_force" in said) != known
    missed = ["pressure"] if known else ["shear_traction", "pressure"]
    assert report["not_compared"] == missed
    assert f"not compared: {', '.join(missed)}".replace("_", " ") in said


def test_what_cannot_be_read_returns_3_with_the_line(tmp_path, refused):
    (tmp_path / "odd.csv").write_text("time,x\n1,2\n")
    assert "line 1" in refused("validate odd.csv --scene preloaded", 3)
    assert not (tmp_path / "results").exists()
