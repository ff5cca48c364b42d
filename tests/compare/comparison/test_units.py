"""Every number that is printed has a unit: that of the scene, or what it is measured against."""

import json
import math
from dataclasses import replace

import pytest
from catalogue import solved
from compare_cases import sampled_run

from compare import judge
from compare.comparison.documents import march_document, solution_document
from compare.comparison.measures import norm, relative_error
from compare.comparison.report import report_document
from compare.comparison.scales import reference_values
from semianalytic import Material, Scene, SlipWeakening, Tractions, march
from semianalytic.scene.errors import SceneError
from semianalytic.scene.given.documents import scene_document, scene_from_document
from semianalytic.scene.given.finding import find_scene
from semianalytic.scene.units import unit
from slipfront.cli.commands import main

STEEL = Scene(
    Material(80e9, 7800.0, 0.3), 0.3, Tractions(1e6, 0.0), Tractions(0.0, 1e6), units="SI"
)
STEEL_FILE = """
units = "SI"
friction = 0.3
material = {shear_modulus = 80e9, density = 7800.0, poisson_ratio = 0.3}
base = {pressure = 1e6, shear = 0.0}
load = {pressure = 0.0, shear = 1e6}
"""


def without_unit(document, units, path=""):
    """Paths of numbers that are no counts and have no unit under the same names."""
    if isinstance(units, str):
        return
    if isinstance(document, (list, tuple)):
        for item in document:
            yield from without_unit(item, units, path)
    elif isinstance(document, dict):
        for name, part in document.items():
            if name != "units":
                yield from without_unit(part, units.get(name, {}), f"{path}/{name}")
    elif isinstance(document, float):
        yield path


@pytest.mark.parametrize("name", ["preloaded", "stuck", "remote-shock", "auxetic"])
def test_every_number_of_a_solution_has_a_unit(name):
    document = solution_document(solved(find_scene(name)), end_time=0.5)
    assert list(without_unit(document, document["units"])) == []
    assert document["units"]["edge"]["slip_rate"] == "length/time"
    assert document["units"]["until_end_time"]["accumulated_slip"] == "length^2"


@pytest.mark.parametrize("name", ["ramp", "pulse", "harmonic", "weakening"])
def test_every_number_of_a_march_has_a_unit(name):
    weakening = replace(find_scene("preloaded"), friction_law=SlipWeakening(0.5, 0.2))
    scene = weakening if name == "weakening" else find_scene(name)
    document = march_document(march(scene, 0.5, 60))
    assert list(without_unit(document, document["units"])) == []
    assert document["units"]["largest_slip"] == "length"


def test_every_number_of_a_report_has_a_unit():
    solution = solved(STEEL)
    run = sampled_run(solution, resolution=60, end_time=1e-4)
    document = report_document(judge(solution, run), "steel")
    rows = document.pop("rows")
    own = document["semianalytic"]["units"]
    units = {**document["units"], "semianalytic": own}
    assert list(without_unit(document, units)) == []
    symbols = {symbol for row in rows for symbol in row["unit"].replace("²", "").split()}
    assert symbols == {"c_t", "T", "V₀", "τ₀", "1"}
    assert symbols - {"1"} == set(document["units"]["rows"])
    assert document["units"]["rows"]["T"] == "0.0001 s"


def test_no_two_rows_of_a_report_have_one_name():
    solution = solved(find_scene("preloaded"))
    names = [row.name for row in judge(solution, sampled_run(solution, resolution=60)).rows]
    assert len(set(names)) == len(names)


@pytest.mark.slow
def test_values_of_rows_are_what_their_units_say():
    """The integrals of slip and work over the contact, by another rule.

    The rows leave out the first 2 % of c_t T: there slip and work per area are nearly even.
    """
    solution, end_time = solved(STEEL), 1e-4
    run = sampled_run(solution, resolution=100, end_time=end_time)
    rows = {row.name: row for row in judge(solution, run).rows}
    speed, rate = STEEL.material.shear_speed, 2e6 / math.sqrt(80e9 * 7800.0)
    start = 0.02 * speed * end_time
    slip, work = rows["accumulated |slip|, L1"], rows["frictional work, L1"]
    assert (slip.unit, slip.relative) == ("V₀ T c_t T", True)
    assert (work.unit, work.relative) == ("τ₀ V₀ T c_t T", True)
    for row, unit_value, total, density in (
        (slip, rate * end_time, solution.accumulated_slip, solution.path),
        (work, 1e6 * rate * end_time, solution.frictional_work, solution.work_density),
    ):
        whole = float(total(end_time)) - start * float(density(start, end_time))
        assert row.at_nodes * unit_value * speed * end_time == pytest.approx(whole, rel=0.02)
        assert row.exact * unit_value * speed * end_time == pytest.approx(whole, rel=0.02)
    references = reference_values(STEEL, end_time)
    assert references["c_t"] == (STEEL.material.shear_speed, "m/s")
    assert references["V₀"][0] == pytest.approx(rate)


def test_si_names_what_dimensions_are():
    assert unit("length / time") == "length/time"
    assert unit("length / time", "SI") == "m/s"
    assert unit("stress length^2", "SI") == "J/m"
    assert unit("c_t", "SI") == "c_t"


def test_units_are_carried_by_documents_and_make_no_other_scene():
    assert scene_from_document(scene_document(STEEL)).units == "SI"
    assert replace(STEEL, units="") == STEEL
    assert "units" not in scene_document(replace(STEEL, units=""))
    with pytest.raises(SceneError, match="units must be"):
        replace(STEEL, units="cgs")


@pytest.mark.thinned(2)
@pytest.mark.parametrize(
    ("line", "sentence"),
    [
        ('units = "imperial"', "units must be \"SI\" or left out, got 'imperial'"),
        ('unit = "SI"', "unknown key unit; did you mean units?"),
    ],
)
def test_other_units_in_a_file_are_refused(line, sentence, tmp_path, capsys):
    path = tmp_path / "scene.toml"
    path.write_text(STEEL_FILE.replace('units = "SI"', line))
    assert main(["solve", str(path)]) == 2
    assert sentence in capsys.readouterr().err


def test_tables_say_units(tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "120")
    path = tmp_path / "steel.toml"
    path.write_text(STEEL_FILE)
    assert main(["solve", str(path), "--end-time", "1e-4"]) == 0
    shown = capsys.readouterr().out
    for words in ("[m/s]", "Pa sqrt(m)", "m^2", "J/m", "t = 0.0001 s"):
        assert words in shown
    path.write_text(STEEL_FILE.replace('units = "SI"', ""))
    assert main(["solve", str(path)]) == 0
    shown = capsys.readouterr().out
    assert "[length/time]" in shown
    assert "m/s" not in shown


def test_norms_over_space_and_time():
    """Norms of x t over a unit square: 1/4 in L1, 1/3 in L2, off by the trapezoidal rule alone."""
    import numpy as np

    x = t = np.linspace(0, 1, 201)
    values = t[:, None] * x
    assert norm(values, x, 1, t) == pytest.approx(1 / 4, rel=1e-9)
    assert norm(values, x, 2, t) == pytest.approx(1 / 3, rel=1e-4)
    assert relative_error(1.1 * values, values, x, 1, t) == pytest.approx(0.1)


def test_json_of_solve_holds_units(capsys):
    assert main(["solve", "ramp", "--nodes", "60", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["units"]["frictional_work"] == "stress length^2"
    assert document["units"]["onset"] == {"x": "length", "time": "time"}
