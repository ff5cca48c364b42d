"""Scenes by name, from TOML files and with overrides."""

import json
from dataclasses import replace

import numpy as np
import pytest
from catalogue import under
from pint import UnitRegistry

import slipfront as sf
from semianalytic.parameters.overriding import override_scene
from semianalytic.scene.given.documents import scene_document, scene_from_document
from semianalytic.scene.given.files import read_scene
from semianalytic.scene.given.finding import scene_label
from semianalytic.scene.given.named import DEFAULT_SCENE, NAMED_SCENES
from tests.fem.runs import prepare

STEEL = """
friction = 0.4
[material]
shear_modulus = 80e9
density = 7800
poisson_ratio = 0.29
[base]
pressure = 1e6
shear = 0
[load]
pressure = 0
shear = 5e5
"""


@pytest.fixture
def steel(tmp_path):
    """Write a valid scene file, part of it in other words, and return its path."""

    def write(old="", new=""):
        assert old in STEEL
        path = tmp_path / "steel.toml"
        path.write_text(STEEL.replace(old, new) if old else STEEL)
        return path

    return write


def test_default_scene_is_constant_pressure_and_sudden_shear():
    scene = sf.find(DEFAULT_SCENE)
    assert scene.coefficient * scene.base.pressure / scene.load.shear == pytest.approx(0.3)
    assert scene.material.poisson_ratio == pytest.approx(1 / 3)
    assert scene.load.pressure == scene.base.shear == 0
    assert sf.find("ramp").shear_history == sf.Ramp(0.5)
    assert sf.find("harmonic").shear_history == sf.Harmonic(3.0)


@pytest.mark.parametrize(("name", "ratio"), [("remote-shock", 1.25), ("stuck", 2.0)])
def test_remote_scenes_come_onto_nothing(name, ratio):
    scene = sf.find(name)
    assert (scene.load_on, scene.base) == ("remote", sf.Tractions(0.0, 0.0))
    assert scene.coefficient * scene.load.pressure / scene.load.shear == ratio


def test_every_named_scene_has_a_one_line_summary():
    for named in NAMED_SCENES.values():
        assert named.summary
        assert "\n" not in named.summary


def test_file_gives_the_scene_it_describes(steel):
    path = steel()
    expected = sf.Scene(
        sf.Material(80e9, 7800, 0.29), 0.4, sf.Tractions(1e6, 0), sf.Tractions(0, 5e5)
    )
    assert read_scene(path) == expected
    assert sf.find(str(path)) == expected
    assert scene_label(str(path)) == "steel"


def test_a_file_without_the_ending_is_found_too(steel, tmp_path):
    plain = steel().rename(tmp_path / "steel")
    assert sf.find(str(plain)).friction == 0.4


@pytest.mark.parametrize(
    ("old", "new", "named"),
    [
        ("friction = 0.4", "frction = 0.4", "unknown key frction; did you mean friction?"),
        ("friction = 0.4", "friction = 0.4\nzzz = 1", "unknown key zzz; known are friction, "),
        ("friction = 0.4", "", "friction is missing"),
        ("friction = 0.4", "friction = [1]", r"friction must be a number, .*, got \[1\]"),
        ("density = 7800", "density = -1", "density must be positive"),
        ("friction = 0.4", "friction = ", "not a valid TOML file"),
        ("[base]", "[base]  # once\n[base]", r"the table \[base\] twice"),
        *(
            ("friction = 0.4", f"friction = 0.4\n{line}", named)
            for line, named in (
                ('shear_history = {kind = "sawtooth"}', "kind must be one of step, ramp"),
                ('shear_history = {kind = "ramp"}', "shear_history.rise_time is missing"),
                (
                    'shear_history = {kind = "ramp", rise = 1.0}',
                    "unknown key shear_history.rise; did you mean rise_time",
                ),
                (
                    'shear_history = {kind = "tabulated", t = [1, 0], value_at_t = [0, 1]}',
                    "must start at 0 or later and not decrease",
                ),
                (
                    'friction_law = {kind = "rate-weakening", reduction = 1, rate = 1e-8}',
                    "faster than radiation can balance",
                ),
            )
        ),
    ],
)
def test_a_faulty_file_is_named_with_the_key(steel, old, new, named):
    path = steel(old, new)
    with pytest.raises(sf.SceneError, match=named) as caught:
        read_scene(path)
    assert str(path) in str(caught.value)


def test_histories_and_laws_are_tables_of_a_file_and_a_mode_turns_shear_along_z(steel):
    tables = """friction = 0.4
mode = 'antiplane'
shear_history = {kind = "tabulated", t = [0, 1, 2], value_at_t = [0, 1, 0]}
friction_law = {kind = "slip-weakening", reduction = 0.5, distance = 0.2}
"""
    scene = read_scene(steel("friction = 0.4", tables))
    assert scene.mode == "antiplane"
    assert scene.shear_history.value(0.5) == 0.5
    assert scene.friction == sf.SlipWeakening(0.4, 0.2, 0.2)
    assert scene_from_document(scene_document(scene)) == scene


@pytest.mark.parametrize("named", NAMED_SCENES.values(), ids=list(NAMED_SCENES))
def test_documents_of_scenes_come_back(named):
    text = json.dumps(scene_document(named.scene))
    assert scene_from_document(json.loads(text)) == named.scene


def test_a_value_in_place_of_a_table_is_refused(tmp_path):
    path = tmp_path / "flat.toml"
    path.write_text("friction = 0.4\nmaterial = 1\nbase = 2\nload = 3\n")
    with pytest.raises(sf.SceneError, match="material must be a table"):
        read_scene(path)


def test_binary_and_missing_files_are_refused(tmp_path):
    path = tmp_path / "mesh.toml"
    path.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(sf.SceneError, match="a character is not in UTF-16"):
        read_scene(path)
    with pytest.raises(sf.SceneError, match="cannot be read"):
        sf.find(str(tmp_path / "absent.toml"))


@pytest.mark.parametrize(
    ("name", "hint"), [("preloadd", "did you mean preloaded"), ("xyz", "choose preloaded, ")]
)
def test_unknown_names_are_answered_with_known_ones(name, hint):
    with pytest.raises(sf.SceneError, match=hint):
        sf.find(name)


def test_every_parameter_can_be_overridden():
    values = {
        "shear_modulus": 2.0,
        "density": 3.0,
        "poisson_ratio": 0.1,
        "friction": 0.7,
        "base_pressure": 4.0,
        "base_shear": 0.5,
        "load_pressure": 0.25,
        "load_shear": 6.0,
    }
    expected = sf.Scene(
        sf.Material(2.0, 3.0, 0.1), 0.7, sf.Tractions(4.0, 0.5), sf.Tractions(0.25, 6.0)
    )
    scene = sf.find("preloaded")
    assert override_scene(scene, **values) == expected
    out = override_scene(scene, mode="antiplane", **values)
    assert out == replace(expected, mode="antiplane")
    assert override_scene(scene) == scene


def test_a_viscosity_overrides_that_of_constant_or_viscous_friction():
    preloaded, viscous = sf.find("preloaded"), sf.find("viscous")
    assert override_scene(preloaded, viscosity=0.2).friction == sf.Coulomb(0.3, viscosity=0.2)
    assert override_scene(viscous, viscosity=0.2).friction == sf.Coulomb(0.2, viscosity=0.2)
    assert override_scene(viscous, viscosity=0.0).friction == 0.2
    assert override_scene(viscous, friction=0.1).friction == sf.Coulomb(0.1, viscosity=0.1)
    with pytest.raises(sf.SceneError, match="0 or more and finite, got -1"):
        override_scene(preloaded, viscosity=-1.0)
    with pytest.raises(sf.SceneError, match="this scene's weakens; leave viscosity out"):
        override_scene(under(preloaded, sf.RateWeakening(1.0, 0.9, 5.0)), viscosity=0.2)


def test_functions_of_a_scene_take_its_name_or_file(steel):
    path = steel("friction = 0.4", 'units = "SI"\nfriction = 0.4')
    given = str(path)
    end, units = 2e-4, UnitRegistry()
    record = sf.Gauge(0.05, np.array([1e-4, 2e-4]), np.array([0.0, 1e-7]), 1e-8)
    scenes = [
        sf.solve(path).scene,
        sf.solve(given).scene,
        sf.solve(
            given, method="space-time", end_time=200 * units.us, nodes=32
        ).scene,  # in the units of the file
        sf.sweep(given, [0.3]).scene,
        sf.fit([record], given, "gain").scene,  # which leaves the scene as it is
        prepare(given, end, resolution=8).plan.scene,
        sf.simulate(given, end * units.s, resolution=8).scene,
    ]
    assert scenes == [read_scene(path)] * len(scenes)
    assert sf.cost(given, end, resolution=8).unknowns > 0
    data = {"t": record.t, "x": np.array([0.05]), "slip": np.zeros((2, 1))}
    assert sf.validate(data, given).scene == scenes[0]
    surveyed = sf.survey(given, friction=[0.4], workers=1)
    assert surveyed.attrs == sf.survey(scenes[0], friction=[0.4], workers=1).attrs


def test_named_scenes_are_solved_by_name():
    assert sf.solve("preloaded").zones == sf.solve(sf.find("preloaded")).zones
    assert sf.solve("ramp", method="space-time", end_time=0.5, nodes=32).error_estimate > 0
    with pytest.raises(sf.SceneError, match="whole-line-patch: this takes only scenes with a slot"):
        sf.sweep("whole-line-patch", [0.3])


# --- tables of loads that a file names ------------------------------------------------------------


SCENE = """
friction = 0.3
{units}
material = {{shear_modulus = 80e9, density = 7800.0, poisson_ratio = 0.29}}
base = {{pressure = 5e6, shear = 0.0}}
load = {{pressure = 0.0, shear = {shear}}}
[shear_history]
kind = "tabulated"
file = "{file}"
"""


def scene_of(folder, table, units='units = "SI"', shear="4e6", file="pulse.csv"):
    folder.mkdir(exist_ok=True)
    (folder / "pulse.csv").write_text(table, encoding="utf-8")
    path = folder / "scene.toml"
    path.write_text(SCENE.format(units=units, shear=shear, file=file), encoding="utf-8")
    return sf.find(str(path))


@pytest.mark.parametrize(
    "table",
    [
        "t [us],shear [MPa]\n0,0\n10,4\n40,1\n",
        "# from the scope\n\nshear (kPa);Time (ms)\n0;0\n4000;0,01\n1000;0,04\n",
        "t,value\n0,0\n1e-5,1\n4e-5,0.25\n",
        "t_us,shear_MPa\n0,0\n10,4\n40,1\n",
        "t,shear\nus,MPa\n0,0\n10,4\n40,1\n",
        "t [min],shear [N/mm^2]\n0,0\n1.6666666666666667e-7,4\n6.666666666666667e-7,1\n",
        "t [us]\tvalue [%]\n0\t0\n10\t100\n40\t25\n",
    ],
)
def test_tables_are_read_in_the_units_of_their_header(tmp_path, table):
    history = scene_of(tmp_path / "deeper", table).shear_history
    assert isinstance(history, sf.Tabulated)
    assert history.t == pytest.approx((0.0, 1e-5, 4e-5), rel=1e-14)
    assert history.value_at_t == pytest.approx((0.0, 1.0, 0.25), rel=1e-14)


@pytest.mark.parametrize(
    ("table", "given", "said"),
    [
        ("t [us],V [mm]\n0,0\n", {}, "two columns, t and value, or t and shear; it has t, V"),
        ("0, 0\n1, 1\n", {}, "no header"),
        ("t [mm],value\n0,0\n", {}, "t must have no unit, or one such as µs, got 'mm'"),
        ("t,shear [m]\n0,0\n", {}, "shear must have no unit, or one such as MPa"),
        ("t,value\n0,a\n", {}, "line 2: 'a' is not a number"),
        ("", {}, "has no row of numbers"),
        ("t [us],value\n0,0\n", {"units": ""}, 'write units = "SI"'),
        ("t,shear\n0,0\n1,1\n", {"shear": "0.0"}, "divided by that of"),
        ("t,value\n0,0\n", {"file": "absent.csv"}, "absent.csv cannot be read"),
    ],
)
def test_wrong_tables_are_refused_in_a_sentence(tmp_path, table, given, said):
    with pytest.raises(sf.SceneError, match=said):
        scene_of(tmp_path, table, **given)


def test_numbers_and_a_table_together_are_refused(tmp_path):
    scene_of(tmp_path, "t,value\n0,1\n")
    path = tmp_path / "scene.toml"
    path.write_text(path.read_text() + "t = [0.0]\n")
    with pytest.raises(sf.SceneError, match="in place of t and value_at_t"):
        sf.find(str(path))
