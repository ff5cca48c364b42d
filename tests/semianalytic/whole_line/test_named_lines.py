"""Whole lines and growing loads by name and from TOML files."""

import pytest

from semianalytic import Scene, SceneError, find, solve
from semianalytic.parameters.overriding import override_scene
from semianalytic.scene.given.documents import scene_document, scene_from_document
from semianalytic.scene.given.finding import find_scene
from semianalytic.scene.given.template import in_si_units, scene_text

LINES = ("whole-line-patch", "point-load", "growing-load")

SOLID = """[material]
shear_modulus = 1.0
density = 1.0
poisson_ratio = 0.3333333333333333
"""
PATCH = f"""
contact = "whole line"
friction = 0.5
{SOLID}[base]
pressure = 1.0
shear = 0.0
[load]
kind = "patch"
speed = 0.3
shear = 1.0
"""
GROWING = f"""
friction = 0.5
{SOLID}[base]
pressure = 0.0
shear = 0.0
[load]
kind = "growing"
pressure = 1.0
shear = 1.0
"""


@pytest.mark.parametrize("name", LINES)
def test_documents_go_there_and_back(name):
    problem = find(name)
    assert scene_from_document(scene_document(problem)) == problem
    with pytest.raises(SceneError, match="slipfront solve, or `solve`"):
        find_scene(name)


def test_files_describe_the_named_ones(tmp_path):
    for text, name in ((PATCH, "whole-line-patch"), (GROWING, "growing-load")):
        path = tmp_path / f"{name}.toml"
        for written in (text, scene_text(find(name)), text.replace('contact = "whole line"\n', "")):
            path.write_text(written)
            assert find(path) == find(name)
        with pytest.raises(SceneError, match="slipfront solve, or `solve`"):
            find_scene(path)


@pytest.mark.parametrize("name", LINES)
def test_in_si_units_edges_are_at_the_same_share_of_the_shear_wave(name):
    plain, si = find(name), in_si_units(find(name))
    speeds = [solve(scene).edge_speed / scene.material.shear_speed for scene in (plain, si)]
    assert speeds[1] == pytest.approx(speeds[0], rel=1e-11)
    assert si.base.pressure == 1e6 * plain.base.pressure


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("whole line", "slot", 'contact must be "whole line"'),
        ('kind = "patch"\nspeed = 0.3\n', "pressure = 0\n", "the bodies touch everywhere"),
        ("patch", "path", "kind must be one of incident-wave, moving, patch, point-force"),
        ("speed = 0.3\n", "", "load.speed is missing"),
        ("speed = 0.3", 'speed = "fast"', "speed must be positive and finite, got 'fast'"),
        ("shear = 1.0", "sheer = 1.0", "unknown key load.sheer; did you mean shear"),
        ("friction = 0.5", "", "friction is missing"),
        ("friction = 0.5", 'friction = 0.5\nload_on = "remote"', "leave out load_on"),
        ('kind = "growing"', 'kind = "growing"\npower = 3', "power must be 1 or 2"),
        ('patch"\nspeed = 0.3', 'half-line"\nspeed = 0.3', "unknown key load.speed"),
    ],
)
def test_a_wrong_file_is_refused_with_its_name(tmp_path, old, new, said):
    path = tmp_path / "line.toml"
    text = PATCH if old in PATCH else GROWING
    assert old in text
    path.write_text(text.replace(old, new))
    with pytest.raises(SceneError, match=said) as refusal:
        find(path)
    assert str(refusal.value).startswith(str(path))


def test_unknown_names_are_refused():
    with pytest.raises(SceneError, match="did you mean point-load"):
        find("point-lode")
    with pytest.raises(SceneError, match=r"choose preloaded.* whole-line-patch"):
        find("?")
    with pytest.raises(SceneError, match="give a name"):
        find(3)


def test_parameters_are_replaced():
    line, growing = find("whole-line-patch"), find("growing-load")
    other = override_scene(line, friction=0.6, poisson_ratio=0.2, base_shear=0.1, load_shear=2.0)
    assert isinstance(other, Scene)
    assert (other.friction, other.material.poisson_ratio) == (0.6, 0.2)
    assert (other.base.shear, other.load.shear, other.load.speed) == (0.1, 2.0, 0.3)
    assert override_scene(line) == line
    changed = override_scene(growing, load_pressure=3.0, mode="antiplane")
    assert (changed.load.pressure, changed.load.power, changed.antiplane) == (3.0, 1, True)
    for name, value, said in (
        ("viscosity", 1.0, "constant friction"),
        ("lower_density", 2.0, "equal bodies"),
        ("load_on", "remote", "leave out load_on"),
    ):
        with pytest.raises(SceneError, match=said):
            solve(override_scene(line, **{name: value}))
    with pytest.raises(SceneError, match="with a base"):
        solve(override_scene(growing, base_pressure=1.0))
    with pytest.raises(SceneError, match="this load has no speed"):
        override_scene(growing, load_speed=1.0)
