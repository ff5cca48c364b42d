"""Answers at points on the command line, numbers with units, and what is said to wrong ones."""

import re

import pytest
from rich.text import Text

from docs.studies.schema import DOCUMENTS
from semianalytic import find, solve
from slipfront.cli.commands import command_for
from slipfront.cli.scenes.points import written

STEEL = [
    *("solve", "preloaded", "--units", "SI", "--shear-modulus", "80GPa", "--density", "7.8 g/cm^3"),
    *("--poisson-ratio", "0.29", "--friction", "0.25"),
    *("--base-pressure", "5MPa", "--load-shear", "5e6", "--x", "5cm"),
]


def test_points_are_answered_in_the_units_asked_for(shown, monkeypatch):
    monkeypatch.setenv("COLUMNS", "100")
    text = " ".join(shown([*STEEL, "--t", "30us,0.04ms"]).out.split())
    assert re.search(r"x = 5 cm .*forward slip begins .*14\.1605\d+ .*us", text)
    assert re.search(r"t = 30 us .* slip .* 9\.829\d+e-07 .* m ", text)
    assert "t = 0.04 ms" in text


def test_json_of_points_holds_values_and_bars_in_si(printed):
    document = printed([*STEEL, "--t", "30us"])
    (point,) = document["points"]
    assert (point["x"], point["t"]) == (0.05, 3e-5)
    assert point["arrivals"]["slip"]["value"] == pytest.approx(1.41605e-5, rel=1e-5)
    assert 0 < point["slip"]["error"] < 1e-6 * point["slip"]["value"]
    assert point["arrivals"]["opening"] == {"value": None, "error": 0.0}
    units = document["units"]
    assert units["points"]["slip_rate"] == "m/s"
    assert document["scene"]["units"] == "SI"


def test_arrivals_alone_and_of_marches(printed):
    first, second = printed("solve preloaded --x 0.5,1")["points"]
    assert "t" not in first
    assert "slip" not in first
    exact = solve(find("preloaded"))
    assert second["arrivals"]["slip"]["value"] == pytest.approx(float(exact.arrival(1.0)))
    document = printed("solve preloaded --x 0.5 --method space-time --nodes 128 -q")
    assert document["end_time"] == 1.0  # twice the time of a shear wave
    arrival = document["points"][0]["arrivals"]["slip"]
    assert abs(arrival["value"] - exact.arrival(0.5)) < arrival["error"] < 0.1


def test_a_march_that_ended_before_slip_came_does_not_say_never(shown):
    said = shown("solve ramp --x 0.5 --t 0.6 --nodes 64 -q").out
    assert said.count("not until 0.6") == 2  # at the point, and among the onsets of the march
    assert "never" not in said
    assert "never" in shown("solve remote-shock --friction 5 --x 0.5 -q").out


@pytest.mark.parametrize(
    ("pair", "shown"),
    [
        ((0.0123456789, 3.2e-5), ("0.012346", "3.2e-05")),
        ((5.0, float("inf")), ("5", "unknown")),
        ((float("inf"), 0.0), ("never", "")),
        ((0.0, 1e-9), ("0", "1.0e-09")),
    ],
)
def test_values_are_written_to_the_digits_of_their_bar(pair, shown):
    assert written(*pair, never="never") == shown


def test_init_begins_with_a_real_solid(refused, shown, tmp_path):
    for name in ("steel", "aluminium", "pmma", "homalite", "granite"):
        shown(f"init {name}.toml --material {name} --from ramp")
        scene = find(f"{name}.toml")
        assert scene.units == "SI"
        assert scene.material.shear_speed > 1000
    assert "Leet and Ewing" in (tmp_path / "granite.toml").read_text()
    said = refused("init gold.toml --material gold")
    assert "one of steel, aluminium, pmma, homalite, granite" in said
    assert not (tmp_path / "gold.toml").exists()


@pytest.mark.parametrize("command", DOCUMENTS)
def test_no_bracket_of_a_help_text_is_swallowed(command):
    found = command_for([])
    for name in command.split():
        found = found.commands[name]
    for text in filter(None, (getattr(param, "help", None) for param in found.params)):
        assert Text.from_markup(text).plain == text.replace("\\[", "["), text
