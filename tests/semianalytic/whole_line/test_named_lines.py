"""Whole lines and growing loads by name and from TOML files."""

import pytest

from semianalytic import GrowingSlot, SceneError, WholeLine, find
from semianalytic.parameters.overriding import override_line
from semianalytic.scene.given.finding import BODIES, LINE, find_scene, kind_of
from semianalytic.scene.given.named import LINES, NAMED_PAIRS, NAMED_SCENES
from semianalytic.whole_line.named import (
    NAMED_LINES,
    line_document,
    line_from_document,
)

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
growth = 1
friction = 0.5
{SOLID}[load]
pressure = 1.0
shear = 1.0
"""


def test_names_are_those_that_scenes_know_of_and_none_is_taken_twice():
    assert tuple(NAMED_LINES) == LINES
    names = [*LINES, *NAMED_PAIRS, *NAMED_SCENES]
    assert len({*names}) == len(names)


@pytest.mark.parametrize("name", LINES)
def test_documents_go_there_and_back(name):
    problem = find(name)
    assert line_from_document(line_document(problem)) == problem
    assert kind_of(name) == LINE
    with pytest.raises(SceneError, match="slipfront solve, or `solve`"):
        find_scene(name)


def test_files_describe_the_named_ones(tmp_path):
    for text, name in ((PATCH, "whole-line-patch"), (GROWING, "growing-load")):
        path = tmp_path / f"{name}.toml"
        path.write_text(text)
        assert kind_of(str(path)) == LINE
        assert find(path) == find(name)
        with pytest.raises(SceneError, match="slipfront solve, or `solve`"):
            find_scene(path)
    path.write_text(GROWING.replace("growth = 1\n", "[base]\npressure = 0\nshear = 0\n"))
    assert kind_of(str(path)) == BODIES


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("whole line", "slot", 'contact must be "whole line"'),
        ('kind = "patch"\n', "", "belong to a scene, without contact"),
        ("patch", "path", "kind must be one of patch, point-force, half-line"),
        ("speed = 0.3\n", "", "load.speed is missing"),
        ("speed = 0.3", 'speed = "fast"', "speed must be positive and finite, got 'fast'"),
        ("shear = 1.0", "sheer = 1.0", "unknown key load.sheer; did you mean shear"),
        ("friction = 0.5", "", "friction is missing"),
        ("friction = 0.5", "friction = 0.5\ngrowth = 1", "not both"),
        ("friction = 0.5", 'friction = 0.5\nload_on = "slot"', "unknown key load_on"),
        ('patch"\nspeed = 0.3', 'half-line"\nspeed = 0.3', "unknown key load.speed"),
        (
            "33\n[load]",
            "33\n[base]\npressure = 1\nshear = 0\n[load]",
            "march a scene with this base",
        ),
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
    other = override_line(line, friction=0.6, poisson_ratio=0.2, base_shear=0.1, load_shear=2.0)
    assert isinstance(other, WholeLine)
    assert (other.friction, other.material.poisson_ratio) == (0.6, 0.2)
    assert (other.base.shear, other.load.shear, other.load.speed) == (0.1, 2.0, 0.3)
    assert override_line(line) == line
    changed = override_line(growing, load_pressure=3.0, mode="antiplane")
    assert isinstance(changed, GrowingSlot)
    assert changed.strength_ratio == 1.5
    assert changed.antiplane
    for name, value in (("viscosity", 1.0), ("load_on", "slot")):
        with pytest.raises(SceneError, match=f"{name} is a parameter of scenes with a slot"):
            override_line(line, **{name: value})
    with pytest.raises(SceneError, match="with a base"):
        override_line(growing, base_pressure=1.0)
