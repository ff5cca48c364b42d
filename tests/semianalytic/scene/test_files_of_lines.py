"""Scenes on a line in files: expressions, tables with units, named ones, refusals."""

import os
import re
import tomllib

import numpy as np
import pytest

import semianalytic as sf
from docs.studies.lines import scene_along
from semianalytic.parameters.numbers import numbers_of, with_numbers
from semianalytic.scene.given.documents import scene_document, scene_from_document, toml_text
from semianalytic.scene.given.named import NAMED_LINES
from semianalytic.scene.line.fields import Expression
from semianalytic.scene.tables.columns import UnreadColumns
from slipfront.cli.commands import main

MATERIAL = "material = {shear_modulus = 1.0, density = 1.0, poisson_ratio = 0.25}\n"
SOFTER_BELOW = "lower_" + MATERIAL.replace("shear_modulus = 1.0", "shear_modulus = 0.3")
COULOMB = "friction = 0.3\n"
WHOLE = 'contact = "whole line"\nperiod = 8.0\n'
GOOD = f"""{WHOLE}{MATERIAL}
[base]
pressure = {{file = "p.csv", column = "pressure"}}
shear = {{x = [-4.0, 0.0, 4.0], values = [0.0, 0.2, 0.0]}}
[friction_law]
kind = "slip-weakening"
static = "0.5 + 0.1 * cos(pi * x / 4)"
dynamic = 0.2
distance = 4.0
[[load]]
shear = "exp(-x**2)"
history = {{kind = "ramp", rise_time = 0.5}}
[run]
end_time = 1.0
nodes = 64
"""
GLUED = f"""{WHOLE}base = {{pressure = 0.5, shear = 0.0}}
load = {{pressure = "-3.0 * exp(-x**2)"}}
{MATERIAL}{COULOMB}
[adhesion]
strength = "1 + 0.1 * (x > 0)"
length = 0.5
[run]
end_time = 1.0
"""
WAVE = f"""period = 8.0
base = {{pressure = 1.0, shear = 0.0}}
{MATERIAL}{COULOMB}
[load]
kind = "incident-wave"
wave = "SV"
angle = -20.0
stress = 0.3
at = 4.0
history = {{kind = "pulse", duration = 0.5, shape = "half-sine"}}
[run]
end_time = 1.0
nodes = 32
"""
TABLE = "# measured\nx [mm], gap [um], pressure [kPa]\n-4000, 0, 1e-3\n4000, 0, 1e-3\n"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    (tmp_path / "p.csv").write_text(TABLE)
    (tmp_path / "a.toml").write_text(GOOD)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_file_and_the_same_in_python(folder):
    with pytest.warns(UnreadColumns, match=r"p\.csv: columns that are not read: gap \[um\]\.$"):
        found = sf.find("a.toml")
    done = sf.solve(found, estimate=False)
    same = scene_along(
        sf.Material(1.0, 1.0, 0.25),
        sf.SlipWeakening(lambda x: 0.5 + 0.1 * np.cos(np.pi * x / 4), 0.2, 4.0),
        8.0,
        shear=lambda x: 0.2 * (1 - np.abs(x) / 4),
        loads=[sf.InterfaceLoad(lambda x: np.exp(-(x**2)), sf.Ramp(0.5))],
    )
    other = sf.solve(same, end_time=1.0, nodes=64, estimate=False)
    assert done.interface.slip.max() > 0.1
    assert done.interface.slip == pytest.approx(other.interface.slip, abs=1e-14)


def test_a_load_of_shear_and_pressure_in_a_file(folder, capsys):
    """Both with one history, and both as expressions of x and t; antiplane is refused."""
    shared = 'shear = "0.1 * exp(-x**2)"\npressure = "-2 * exp(-x**2)"\nhistory = "min(2 * t, 1)"\n'
    timed = """shear = "0.1 * exp(-x**2) * min(2 * t, 1)"
pressure = "-2 * exp(-x**2) * min(2 * t, 1)"
"""
    runs = []
    head, tail = (
        GOOD.split("[[load]]")[0].replace('{file = "p.csv", column = "pressure"}', "1.0"),
        ("[run]\nend_time = 1.0\nnodes = 64\n"),
    )
    for load in (shared, timed):
        (folder / "a.toml").write_text(f"{head}[[load]]\n{load}{tail}")
        found = sf.find("a.toml")
        runs.append(sf.solve(found, end_time=1.0, nodes=64, estimate=False))
    assert runs[0].interface.gap.max() > 0.1
    assert runs[0].interface.gap == pytest.approx(runs[1].interface.gap, abs=1e-14)
    assert runs[0].interface.slip == pytest.approx(runs[1].interface.slip, abs=1e-14)
    assert main(["solve", "a.toml"]) == 0
    assert "largest gap" in capsys.readouterr().out
    (folder / "a.toml").write_text(f'mode = "antiplane"\n{head}[[load]]\n{load}{tail}')
    assert main(["solve", "a.toml", "--save", "b.h5"]) == 2
    assert "antiplane line have no pressure" in " ".join(capsys.readouterr().err.split())
    assert not (folder / "b.h5").exists()


def test_files_and_surveys_know_adhesion(folder):
    (folder / "a.toml").write_text(GLUED)
    face = sf.find("a.toml")
    named = numbers_of(face)
    assert named["adhesion_length"].value == 0.5
    assert named["adhesion_strength_factor"].value == 1.0
    done = sf.solve(face, end_time=0.2, nodes=64, estimate=False)
    assert done.interface.pressure.min() < -1.0


def test_files_describe_fronts_and_surveys_vary_them(folder):
    (folder / "a.toml").write_text(WAVE)
    face = sf.find("a.toml")
    load = face.load
    assert load.front == sf.IncidentWave("SV", angle=-20.0, stress=0.3)
    assert (load.at, load.history) == (4.0, sf.Pulse(0.5, "half-sine"))
    known = numbers_of(face)
    assert {"load_angle", "load_stress", "load_at", "load_history_duration"} <= set(known)
    other = with_numbers(face, {"load_angle": -30.0, "shear_modulus": 4.0})
    assert (other.load.front.angle, other.material.shear_modulus) == (-30.0, 4.0)
    sf.solve(other, end_time=0.5, nodes=32)


@pytest.mark.parametrize("name", NAMED_LINES)
def test_named_lines_begin_and_are_written_as_files(name):
    found = sf.find(name)
    written = toml_text(scene_document(found))
    assert scene_from_document(tomllib.loads(written)) == found
    end = found.run["end_time"] / 1000
    done = sf.solve(found, end_time=end, nodes=256, estimate=False)
    assert np.isfinite(done.interface.slip).all()


@pytest.mark.parametrize(
    ("text", "old", "new", "said"),
    [
        (GOOD, "dynamic = 0.2\n", "", "friction_law.dynamic is missing"),
        (GOOD, "static =", "statik =", "did you mean static"),
        (GOOD, "slip-weakening", "coulombe", "kind must be one of"),
        (GOOD, '"exp(-x**2)"', '"__import__(1)"', "is not known here"),
        (GOOD, '"exp(-x**2)"', '"exp(-x**2"', "not an expression"),
        (GOOD, "period = 8.0\n", "", "give the `period` of the line"),
        (GOOD, "nodes = 64", "nodes = 1e9", "scene: run.nodes must be a whole number"),
        (GOOD, "[run]", "[run]\nrtol = -1", "scene: run.rtol must be positive"),
        (GOOD, "period = 8.0", "period = 80.0", "must cover the contact"),
        (GOOD, "period = 8.0", "length = 8.0", "unknown key length; known are"),
        (GOOD, 'column = "pressure"', 'column = "preasure"', "there is no column"),
        (GOOD, '"p.csv"', '"q.csv"', "q.csv cannot be read"),
        (GOOD, "poisson_ratio = 0.25", "poisson_ratio = 0.7", "poisson_ratio must"),
        (GOOD, 'contact = "whole line"', "contact = 1", "contact must be"),
        (GOOD, 'shear = "exp(-x**2)"\n', "", "load: shear or pressure is missing"),
        (GOOD, 'shear = "exp(-x**2)"\n', "presure = 1.0\n", "did you mean pressure"),
        (GOOD, 'shear = "exp(-x**2)"\n', "pressure = [1.0]\n", "load.pressure must be a number"),
        (GLUED, "length = 0.5", "length = 0.0", "adhesion: length must be positive"),
        (GLUED, '"1 + 0.1 * (x > 0)"', "-1.0", "adhesion: strength must be 0 or more"),
        (GLUED, "length = 0.5", "", "adhesion.length is missing"),
        (GLUED, "load =", "#", "nothing opens without a load"),
        (WAVE, 'wave = "SV"', 'wave = "SH"', "must be of kind P or SV, got SH"),
        (WAVE, "angle = -20.0", "angle = 95.0", "angle must"),
        (WAVE, "at = 4.0", "on = 4.0", "unknown key load.on"),
        (WAVE, "period = 8.0", "period = 8.0\neven = true", "not even in x"),
        (WAVE, "material", f"{SOFTER_BELOW}material", "beyond a critical angle"),
        (TABLE, "[kPa]", "[furlnog]", "must have no unit, or one such as"),
        (TABLE, "1e-3\n4000", "nan\n4000", "must hold finite numbers"),
        (TABLE, TABLE, "x [m], pressure [Pa]\n", "has no row of numbers"),
    ],
)
def test_mistakes_in_files_end_in_one_sentence(folder, capsys, text, old, new, said):
    assert old in text
    (folder / ("p.csv" if text is TABLE else "a.toml")).write_text(text.replace(old, new))
    assert main(["solve", "a.toml", "--save", "b.h5"]) == 2
    shown = capsys.readouterr()
    assert said in " ".join(shown.err.split())
    assert not shown.out
    assert not (folder / "b.h5").exists()


def test_the_command_saves_and_goes_on(folder, capsys):
    pytest.importorskip("h5netcdf")
    assert main(["solve", "a.toml", "--save", "b.h5", "--no-estimate", "--latest", "1.5"]) == 0
    assert main(["solve", "a.toml", "--go-on", "b.h5", "--end-time", "1.5", "--no-estimate",
                 "--save", "c.nc"]) == 0  # fmt: skip
    assert re.search(r"end time\W+1\.5", capsys.readouterr().out)
    assert (folder / "c.nc").stat().st_size > 1000


def test_unknown_names_and_saved_files(folder, capsys):
    assert main(["solve", "tpv11"]) == 2
    assert "did you mean tpv101" in capsys.readouterr().err
    (folder / "b.h5").write_bytes(b"PK spoilt")
    assert main(["solve", "a.toml", "--go-on", "b.h5"]) == 3


def test_expressions():
    assert Expression("2 * x**2 - -1", ("x",))(3.0) == 19
    assert Expression("where(abs(x) < 1, 1, 2)", ("x",))(np.array([0.0, 3.0])).tolist() == [1, 2]
    # comparisons are numbers: where two hold, their sum is 2, and each has a negative
    both = Expression("(abs(x) < 1) + (x > 0) - -(x > 5)", ("x",))
    assert both(np.array([-2.0, -0.5, 0.5, 7.0])).tolist() == [0, 1, 2, 2]
    for bad in ("x.real", "[1]", "x if x else 1", "'a'", "y", "exp", "exp(x=1)", "1j", "True"):
        with pytest.raises(sf.SceneError):
            Expression(bad, ("x",))


def test_functions_of_expressions_count_their_arguments():
    """A further argument of a function of numpy is where it writes to, so that x would change."""
    x = np.array([-3.0, 0.5, 2.0])
    for text, expected in (
        ("max(1, 0.2, 3 - abs(x))", np.maximum(1.0, 3 - np.abs(x))),
        ("min(1, x, 2, x**2)", np.minimum(np.minimum(1.0, x), x**2)),
        ("where(x < 0, 1, 2)", np.where(x < 0, 1, 2)),
    ):
        kept = x.copy()
        np.testing.assert_array_equal(Expression(text, ("x",))(x), expected)
        np.testing.assert_array_equal(x, kept)
    for name, given in (("exp", "x, x"), ("abs", "x, x"), ("tanh", ""), ("where", "x, 1")):
        with pytest.raises(sf.SceneError, match=f"{name} takes (1|3) argument"):
            Expression(f"{name}({given})", ("x",))
    with pytest.raises(sf.SceneError, match="max takes two or more arguments, got 1"):
        Expression("max(x)", ("x",))
    with pytest.raises(sf.SceneError, match="more than 250 operations"):
        Expression("-" * 1500 + "x", ("x",))


@pytest.mark.parametrize(
    ("x", "values"), [(["a", "b"], [1, 2]), ([[1], [2, 3]], [1, 2]), ([0, 1], [None, {}])]
)
def test_tables_of_anything_but_numbers_are_refused(x, values):
    with pytest.raises(sf.SceneError, match="must be two or more finite numbers"):
        sf.Table(x, values)


TABLES = {
    "brackets": "x [mm],note [1],pressure [MPa]\n0,7,1\n500,7,3\n",
    "behind the name": "x_mm,note,pressure_MPa\n0,7,1\n500,7,3\n",
    "second row": "x,note,pressure\nmm,-,MPa\n0,7,1\n500,7,3\n",
    "second row in brackets": "x;note;pressure\n[mm];[1];[MPa]\n0;7;1\n500;7;3\n",
    "of pint": "x (thou)\tnote\tpressure (N/mm^2)\n0\t7\t1\n19685.03937007874\t7\t3\n",
    "of Excel": "\ufeff# a comment\nx [mm];note;pressure [MPa]\n0;7;1,0\n5e2;7;3,0\n",
}


@pytest.mark.parametrize("column", ["pressure", "heading"])
@pytest.mark.parametrize("form", TABLES)
def test_units_of_tables_are_read_wherever_they_stand(form, column, tmp_path):
    path = tmp_path / "p.csv"
    path.write_text(TABLES[form], encoding="utf-8")
    heading = "pressure_MPa" if form == "behind the name" else "pressure"
    table = sf.Table.read(path, heading if column == "heading" else column)
    np.testing.assert_allclose(table.x, [0, 0.5], rtol=1e-12)
    np.testing.assert_allclose(table.values, [1e6, 3e6], rtol=1e-12)


def test_lines_of_tables_are_counted_with_comments(tmp_path):
    (tmp_path / "p.csv").write_text("# one\n\n# two\nx,p\n0,1\n# three\n1,abc\n")
    with pytest.raises(sf.SceneError, match=r"p.csv, line 7: 'abc' is not a number"):
        sf.Table.read(tmp_path / "p.csv")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="the system has no pipes with names")
def test_pipes_devices_and_huge_files_are_refused_at_once(folder, monkeypatch):
    os.mkfifo("pipe.toml")
    for find in (sf.find, sf.Table.read):
        with pytest.raises(sf.SceneError, match="not an ordinary file"):
            find("pipe.toml")
    with pytest.raises(sf.DataFileError, match="not an ordinary file"):
        sf.Marched.load("pipe.toml")
    with monkeypatch.context() as patch:
        patch.setattr("semianalytic.scene.given.files.LARGEST_DESCRIPTION", 10)
        with pytest.raises(sf.SceneError, match="and at most"):
            sf.find("a.toml")


def test_commands_of_scenes_name_what_takes_the_file_of_an_interface(tmp_path, capsys):
    face = tmp_path / "face.toml"
    solid = "[material]\nshear_modulus = 1.0\ndensity = 1.0\npoisson_ratio = 0.25\n"
    face.write_text(
        f"period = 16.0\nfriction = 0.3\n{solid}[base]\npressure = 1.0\nshear = 0.0\n"
        "[contact]\nintervals = [[-1.0, 1.0]]\n[run]\nend_time = 1.0\n"
    )
    assert main(["simulate", str(face)]) == 2
    said = " ".join(capsys.readouterr().err.split())
    assert f"{face}" in said
    assert "slipfront solve" in said
