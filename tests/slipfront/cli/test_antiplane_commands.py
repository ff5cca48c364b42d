"""The commands on antiplane scenes: by name, by file, by option."""

import json

import pytest

from slipfront.cli.commands import main

FILE = """
friction = 1.0
mode = "antiplane"
material = {shear_modulus = 80e9, density = 7800, poisson_ratio = 0.29}
base = {pressure = 1e6, shear = 1e6}
load = {pressure = 1e6, shear = 1e6}
"""


def report(folder):
    return json.loads((folder / "report.json").read_text())


@pytest.mark.usefixtures("undrawn")
def test_compare_agrees_on_the_named_scene(tmp_path, capsys):
    options = ["--resolution", "50", "--output", str(tmp_path), "--quiet"]
    assert main(["compare", "antiplane", *options]) == 0
    document = report(tmp_path)
    assert document["verdict"] == "agrees"
    assert {row["name"] for row in document["rows"]} >= {
        "S front, interface (shear traction)",
        "zone 1, outer edge",
        "slip rate, L1",
        "v_z, whole",
    }
    assert "Rayleigh front" not in capsys.readouterr().out


@pytest.mark.slow
def test_compare_takes_a_file_in_which_pressure_changes_too(tmp_path):
    path = tmp_path / "remote.toml"
    path.write_text(FILE)
    options = ["--resolution", "60", "--output", str(tmp_path / "out"), "--quiet"]
    assert main(["compare", str(path), *options, "--no-snapshots"]) in (0, 3)
    assert report(tmp_path / "out")["verdict"] != "differs"


def test_any_scene_can_be_turned(printed):
    document = printed("solve preloaded --mode antiplane")
    assert document["scene"]["mode"] == "antiplane"
    assert document["wave_speeds"] == {"shear": 1.0}
    assert document["zones"][0]["outer"] == pytest.approx(1 / 1.3**2, rel=1e-8)
    assert document["zones"][0]["outer_regime"] == "sub-shear"
    assert set(document["edge"]["stress_intensity_at_unit_time"]) == {"K_I", "K_III"}
