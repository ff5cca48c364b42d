"""``slipfront solve`` of whole lines and growing loads."""

import pytest

from semianalytic import find_line, solve_growing, solve_line
from slipfront.cli.commands import main

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


@pytest.mark.parametrize("name", ["whole-line-patch", "point-load", "growing-load"])
def test_a_named_line_is_solved(capsys, printed, name):
    problem = find_line(name)
    answer = solve_growing(problem) if name == "growing-load" else solve_line(problem)
    assert main(["solve", name, "--end-time", "2"]) == 0
    said = capsys.readouterr().out
    assert f"{answer.edge_speed:.12g}" in said
    assert "converged" in said
    document = printed(f"solve {name} --end-time 2")
    assert document["edge_speed"] == answer.edge_speed
    end = document["until_end_time"]
    assert end["accumulated_slip"] == pytest.approx(float(answer.accumulated_slip(2.0)))
    if name == "point-load":
        assert end["largest_slip"] is None  # infinite at the force


def test_a_line_in_si_units_has_them(tmp_path, printed):
    path = tmp_path / "patch.toml"
    text = HALF_LINE.replace('"half-line"', '"patch"\nspeed = 500.0')
    path.write_text(text)
    document = printed(["solve", path])
    assert document["units"]["edge_speed"] == "m/s"
    assert document["units"]["line"]["load"]["shear"] == "Pa"
    path.write_text(text.replace('"patch"\nspeed = 500.0', '"point-force"'))
    document = printed(["solve", path])
    assert document["units"]["line"]["load"]["shear"] == "N/(m s)"
    growing = text.replace('contact = "whole line"', "growth = 2").replace("[base]", "[load]")
    path.write_text(growing.partition("[load]\nkind")[0].replace("shear = 1e6", "shear = 8e6"))
    document = printed(["solve", path])
    assert document["units"]["line"]["load"]["shear"] == "Pa/s^2"
    assert document["units"]["edge_amplitude"] == "m/s^3"


def test_a_half_line_is_solved_as_the_slot_that_moves_alike(tmp_path, printed):
    path = tmp_path / "half.toml"
    path.write_text(HALF_LINE)
    document = printed(["solve", path])
    assert document["scene"]["load"] == {"pressure": 0.0, "shear": 4e6}
    assert document["zones"][0]["inner"] == 0
    marched = printed(["solve", path, "--method", "space-time", "--nodes", 300])
    assert marched["method"] == "space-time"


def test_a_figure_is_drawn(tmp_path):
    for name in ("whole-line-patch", "growing-load"):
        path = tmp_path / f"{name}.svg"
        assert main(["solve", name, "--plot", str(path)]) == 0
        text = path.read_text()
        for word in (
            "shear traction",
            "strength f p",
            "excess of the patch" if "patch" in name else "Q₀ t^1",
        ):
            assert word in text


@pytest.mark.parametrize(
    ("command", "said"),
    [
        ("solve whole-line-patch --friction 0.1", "a second zone of slip starts"),
        ("solve whole-line-patch --friction 1.1", "nothing slips"),
        ("solve whole-line-patch --friction -1", "must not be negative"),
        ("solve whole-line-patch --viscosity 1", "scenes with a slot alone"),
        ("solve whole-line-patch --load-on remote", "scenes with a slot alone"),
        ("solve whole-line-patch --method space-time", "marched for scenes with a slot alone"),
        ("solve whole-line-patch --method magic", "is unknown"),
        ("solve whole-line-patch --nodes 100", "is for the space-time solver"),
        ("solve whole-line-patch --figure interface --plot a.png", "leave it out"),
        ("solve growing-load --base-pressure 1", "with a base the edge of slip accelerates"),
        ("solve whole-line-patch --end-time -1", "end-time must be positive"),
        ("simulate whole-line-patch", "slipfront solve"),
        ("compare whole-line-patch", "slipfront solve"),
        ("field whole-line-patch", "slipfront solve"),
    ],
)
def test_what_cannot_be_is_refused_in_a_sentence(tmp_path, monkeypatch, refused, command, said):
    """Commands that take scenes with a slot only name the commands that solve a line."""
    monkeypatch.chdir(tmp_path)
    assert said in refused(command)
    assert not list(tmp_path.iterdir())
