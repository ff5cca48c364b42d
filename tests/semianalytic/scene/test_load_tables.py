"""Tables of loads that a scene file names: what they may hold, and how a wrong one is refused."""

import pytest

from semianalytic import SceneError, Tabulated, find_scene

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
    return find_scene(str(path))


@pytest.mark.parametrize(
    "table",
    [
        "t [us],shear [MPa]\n0,0\n10,4\n40,1\n",
        "# from the scope\n\nshear (kPa);Time (ms)\n0;0\n4000;0,01\n1000;0,04\n",
        "t,value\n0,0\n1e-5,1\n4e-5,0.25\n",
        "t [us]\tvalue [%]\n0\t0\n10\t100\n40\t25\n",
    ],
)
def test_tables_are_read_in_the_units_of_their_header(tmp_path, table):
    history = scene_of(tmp_path / "deeper", table).shear_history
    assert isinstance(history, Tabulated)
    assert history.t == pytest.approx((0.0, 1e-5, 4e-5), rel=1e-14)
    assert history.value_at_t == pytest.approx((0.0, 1.0, 0.25), rel=1e-14)


@pytest.mark.parametrize(
    ("table", "given", "said"),
    [
        ("t [us],V [mm]\n0,0\n", {}, "two columns, t and value, or t and shear; it has t, V"),
        ("t,value,more\n0,0,0\n", {}, "it has t, value, more"),
        ("0,0\n1,1\n", {}, "no header"),
        ("t [min],value\n0,0\n", {}, "t must be in s, ms, us or ns, or have no unit, got 'min'"),
        ("t,shear [m]\n0,0\n", {}, "shear must be in Pa, kPa, MPa or GPa"),
        ("t,value\n0,a\n", {}, "line 2: there must be 2 numbers"),
        ("t,value\n0\n", {}, "line 2: there must be 2 numbers"),
        ("", {}, "is empty"),
        ("t [us],value\n0,0\n", {"units": ""}, 'write units = "SI"'),
        ("t,shear\n0,0\n1,1\n", {"shear": "0.0"}, "divided by that of"),
        ("t,value\n1,0\n0,1\n", {}, "not decrease"),
        ("t,value\n0,0\n", {"file": "absent.csv"}, "Cannot read the table .*absent.csv"),
    ],
)
def test_wrong_tables_are_refused_in_a_sentence(tmp_path, table, given, said):
    with pytest.raises(SceneError, match=said):
        scene_of(tmp_path, table, **given)


def test_numbers_and_a_table_together_are_refused(tmp_path):
    scene_of(tmp_path, "t,value\n0,1\n")
    path = tmp_path / "scene.toml"
    path.write_text(path.read_text() + "t = [0.0]\n")
    with pytest.raises(SceneError, match="in place of t and value_at_t"):
        find_scene(str(path))
