"""Two materials from a scene file or options: simulated, and refused where bodies are alike."""

import pytest

from fem import load_simulation
from semianalytic.scene.errors import SceneError
from semianalytic.scene.given.files import read_scene
from semianalytic.scene.given.finding import find_blocks, find_scene
from semianalytic.scene.scene import Material
from slipfront.cli.commands import main

FILE = """friction = 0.3
[material]
shear_modulus = 1.0
density = 1.0
poisson_ratio = 0.25
[lower_material]
shear_modulus = 4.0
density = 2.0
poisson_ratio = 0.4
[base]
pressure = 1.0
shear = 0.0
[load]
pressure = 0.0
shear = 1.0
"""
UPPER, LOWER = Material(1.0, 1.0, 0.25), Material(4.0, 2.0, 0.4)


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "two.toml"
    path.write_text(FILE)
    return path


def simulated(folder, source, *options):
    command = ["simulate", str(source), "--resolution", "12", "--no-snapshots"]
    assert main([*command, "--output", str(folder), *options]) == 0
    return load_simulation(folder)


def test_file_says_what_the_lower_block_is_made_of(file, tmp_path):
    assert find_blocks(str(file)) == (find_blocks(str(file))[0], LOWER)
    sim = simulated(tmp_path / "out", file, "--quiet")
    assert (sim.scene.material, sim.lower_material) == (UPPER, LOWER)
    assert sim.model == "two blocks of different materials"


def test_options_replace_single_parameters(file, tmp_path):
    options = ("--lower-shear-modulus", "9", "--poisson-ratio", "0.3", "--quiet")
    sim = simulated(tmp_path / "out", file, *options)
    assert sim.scene.material == Material(1.0, 1.0, 0.3)
    assert sim.lower_material == Material(9.0, 2.0, 0.4)
    sim = simulated(tmp_path / "other", "preloaded", "--lower-density", "0.5", "--quiet")
    assert sim.lower_material == Material(1.0, 0.5, 1 / 3)


def test_folder_says_what_the_lower_block_was(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    command = ["simulate", "preloaded", "--resolution", "8", "--no-snapshots", "--quiet"]
    assert main([*command, "--lower-density", "0.5"]) == 0
    assert (tmp_path / "results" / "preloaded-lower-density-0.5" / "simulation.h5").is_file()


def test_readers_of_one_material_refuse_it(file):
    for read in (find_scene, read_scene):
        with pytest.raises(SceneError, match="identical bodies only"):
            read(str(file))


def test_equal_lower_material_is_an_ordinary_scene(file):
    equal = FILE.replace("4.0", "1.0").replace("2.0", "1.0").replace("0.4", "0.25")
    file.write_text(equal)
    assert find_scene(str(file)).material == UPPER


@pytest.mark.parametrize(
    ("before", "after", "match"),
    [
        ("shear_modulus = 4.0\n", "", "lower_material.shear_modulus is missing"),
        ("density = 2.0", "dense = 2.0", r"unknown key lower_material.dense; did you mean density"),
        ("poisson_ratio = 0.4", "poisson_ratio = 0.5", "poisson_ratio must lie"),
        ("poisson_ratio = 0.4", 'poisson_ratio = "soft"', "must be a number"),
    ],
)
def test_mistakes_in_the_table_are_named(before, after, match, file):
    file.write_text(FILE.replace(before, after))
    with pytest.raises(SceneError, match=match):
        find_blocks(str(file))


def test_opening_and_what_is_under_resolved_are_told(tmp_path, capsys):
    simulated(tmp_path / "open", "lift-off", "--resolution", "24")
    told = " ".join(capsys.readouterr().err.split())
    first = load_simulation(tmp_path / "open").interface.x[0]  # one element beyond the edge node
    assert 0.04167 < first < 1.5 * 0.04167
    assert f"lift-off: the contact opened, first at x = {first:.4g}" in told
    simulated(tmp_path / "soft", "preloaded", "--lower-shear-modulus", "0.0625")
    told = " ".join(capsys.readouterr().err.split())
    assert "the lower block is under-resolved" in told
    assert "opened" not in told
