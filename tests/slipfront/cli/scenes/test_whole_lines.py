"""``slipfront solve`` of whole lines and growing loads."""

import json

import pytest

from semianalytic import find_line, solve_growing, solve_line
from slipfront.cli.commands import main
from tests.slipfront.cli.test_json_output import checked

HALF_LINE = """
contact = "whole line"
friction = 0.5
units = "SI"
[material]
shear_modulus = 30e9
density = 2700.0
poisson_ratio = 0.25
[base]
pressure = 10e6
shear = 1e6
[load]
kind = "half-line"
shear = 8e6
"""


def run(capsys, *arguments, code=0):
    capsys.readouterr()
    assert main(["solve", *arguments]) == code
    return capsys.readouterr()


@pytest.mark.parametrize("name", ["whole-line-patch", "point-load", "growing-load"])
def test_a_named_line_is_solved(capsys, name):
    problem = find_line(name)
    answer = solve_growing(problem) if name == "growing-load" else solve_line(problem)
    said = run(capsys, name, "--end-time", "2").out
    assert f"{answer.edge_speed:.12g}" in said
    assert "converged" in said
    document = checked(run(capsys, name, "--json", "--end-time", "2").out)
    assert document["edge_speed"] == answer.edge_speed
    end = document["until_end_time"]
    assert end["accumulated_slip"] == pytest.approx(float(answer.accumulated_slip(2.0)))
    if name == "point-load":
        assert end["largest_slip"] is None  # infinite at the force


def test_a_line_in_si_units_has_them(tmp_path, capsys):
    path = tmp_path / "patch.toml"
    text = HALF_LINE.replace('"half-line"', '"patch"\nspeed = 500.0')
    path.write_text(text)
    document = checked(run(capsys, str(path), "--json").out)
    assert document["units"]["edge_speed"] == "m/s"
    assert document["units"]["line"]["load"]["shear"] == "Pa"
    path.write_text(text.replace('"patch"\nspeed = 500.0', '"point-force"'))
    document = checked(run(capsys, str(path), "--json").out)
    assert document["units"]["line"]["load"]["shear"] == "N/(m s)"
    growing = text.replace('contact = "whole line"', "growth = 2").replace("[base]", "[load]")
    path.write_text(growing.partition("[load]\nkind")[0].replace("shear = 1e6", "shear = 8e6"))
    document = checked(run(capsys, str(path), "--json").out)
    assert document["units"]["line"]["load"]["shear"] == "Pa/s^2"
    assert document["units"]["edge_amplitude"] == "m/s^3"


def test_a_half_line_is_solved_as_the_slot_that_moves_alike(tmp_path, capsys):
    path = tmp_path / "half.toml"
    path.write_text(HALF_LINE)
    document = checked(run(capsys, str(path), "--json").out)
    assert document["scene"]["load"] == {"pressure": 0.0, "shear": 4e6}
    assert document["zones"][0]["inner"] == 0
    marched = run(capsys, str(path), "--method", "space-time", "--json", "--nodes", "300")
    assert json.loads(marched.out)["method"] == "space-time"


def test_a_figure_is_drawn(tmp_path, capsys):
    for name in ("whole-line-patch", "growing-load"):
        path = tmp_path / f"{name}.svg"
        run(capsys, name, "--plot", str(path))
        text = path.read_text()
        for word in (
            "shear traction",
            "strength f p",
            "excess of the patch" if "patch" in name else "Q₀ t^1",
        ):
            assert word in text


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("whole-line-patch", "--friction", "0.1"), "a second zone of slip starts"),
        (("whole-line-patch", "--friction", "1.1"), "nothing slips"),
        (("whole-line-patch", "--friction", "-1"), "must not be negative"),
        (("whole-line-patch", "--viscosity", "1"), "scenes with a slot alone"),
        (("whole-line-patch", "--load-on", "remote"), "scenes with a slot alone"),
        (("whole-line-patch", "--method", "space-time"), "marched for scenes with a slot alone"),
        (("whole-line-patch", "--method", "magic"), "is unknown"),
        (("whole-line-patch", "--nodes", "100"), "is for the space-time solver"),
        (("whole-line-patch", "--figure", "interface", "--plot", "a.png"), "leave it out"),
        (("growing-load", "--base-pressure", "1"), "with a base the edge of slip accelerates"),
        (("whole-line-patch", "--end-time", "-1"), "end-time must be positive"),
    ],
)
def test_what_cannot_be_is_refused_in_a_sentence(tmp_path, monkeypatch, capsys, arguments, said):
    monkeypatch.chdir(tmp_path)
    shown = run(capsys, *arguments, code=2)
    assert said in shown.err
    assert shown.err.count("\n") == 1
    assert not shown.out
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("command", ["simulate", "compare", "field"])
def test_what_knows_slots_alone_says_what_solves_a_line(command, capsys):
    capsys.readouterr()
    assert main([command, "whole-line-patch"]) == 2
    assert "slipfront solve" in capsys.readouterr().err
