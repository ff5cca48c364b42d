"""Two different bodies on every road a user takes: what works, and what refuses in one sentence."""

import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import slipfront as sf
from docs.studies.lines import scene_along
from fem.results import load_simulation
from semianalytic.scene.given.finding import find_scene
from slipfront.cli import solve_command
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
UPPER, LOWER = sf.Material(1.0, 1.0, 0.25), sf.Material(4.0, 2.0, 0.4)
PAIR = sf.Scene(UPPER, 0.3, sf.Tractions(1.0, 0.0), sf.Tractions(0.0, 1.0), lower_material=LOWER)
RUNNING = scene_along(
    UPPER,
    sf.Coulomb(0.3),
    8.0,
    lower_material=LOWER,
    contact=sf.Contact.half_line(),
    loads=[sf.InterfaceLoad(1.0, on="slot")],
)
GAUGE = sf.Gauge(0.4, np.array([0.1, 0.2]), np.array([0.1, 0.2]), 0.1)


@cache
def solved(friction=0.3, **options):
    """The answer for the bodies of the file, with another friction if one is given."""
    return sf.solve(replace(PAIR, friction=friction), **options)


@pytest.fixture(autouse=True)
def folder(tmp_path):
    (tmp_path / "two.toml").write_text(FILE)
    (tmp_path / "record.csv").write_text("x,t,slip\n0.5,1.0,0.1\n")
    return tmp_path


FUNCTIONS = {
    "sweep": lambda scene: sf.sweep(scene, [0.3]),
    "fit": lambda scene: sf.fit([GAUGE], scene, ["friction"]),
}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_functions_of_a_scene_say_what_can(name):
    with pytest.raises(sf.SceneError, match=r"slipfront solve or survey, or\s+simulate"):
        FUNCTIONS[name]("two.toml")
    with pytest.raises(sf.SceneError, match=r"slipfront solve or survey, or\s+simulate"):
        FUNCTIONS[name](PAIR)
    if name != "fit":  # interfaces of two bodies may be fitted, as those of one
        with pytest.raises(sf.SceneError, match="loads along x, which is marched"):
            FUNCTIONS[name](RUNNING)


def test_a_file_of_two_bodies_is_solved(shown, printed, monkeypatch):
    known, line = solved(), "solve two.toml --x 0.5 --t 1 --end-time 2"
    document = printed(line)
    assert document["scene"]["lower_material"]["density"] == 2.0
    assert document["zones"][0]["outer"] == known.zones[0].outer
    assert document["points"][0]["slip_rate"]["value"] == float(known.slip_rate(0.5, 1.0))
    assert document["until_end_time"]["largest_slip"] == pytest.approx(float(known.max_slip(2.0)))
    assert document["units"]["wave_speeds"] == "length/time"
    monkeypatch.setattr(solve_command, "solve", lambda pair, **_: known)
    said = shown(line).out
    for words in ("open", "c_R, c_t, c_l, lower body", "forward slip begins", "converged"):
        assert words in said
    assert sf.find("two.toml") == PAIR


def test_options_describe_the_lower_body_in_units(tmp_path, printed, monkeypatch):
    monkeypatch.setattr(solve_command, "solve", lambda pair, **_: sf.solve(pair, rtol=1e-4))
    text = 'units = "SI"\n' + FILE.replace("shear_modulus = 1.0", "shear_modulus = 1e9")
    upper, _, rest = text.partition("[lower_material]")
    (tmp_path / "si.toml").write_text(upper + "[base]" + rest.partition("[base]")[2])
    line = "solve si.toml --lower-shear-modulus 4GPa --lower-density 2g/cm3 --density 1000"
    document = printed(line)
    lower = {"shear_modulus": 4e9, "density": 2000.0, "poisson_ratio": 0.25}
    assert document["scene"]["lower_material"] == lower
    assert document["units"]["wave_speeds"] == "m/s"


def test_numbers_that_make_both_bodies_alike_are_an_ordinary_scene(printed):
    alike = "--lower-density 1 --lower-shear-modulus 1 --lower-poisson-ratio 0.25"
    document = printed(f"solve two.toml {alike}")
    assert "lower_material" not in document["scene"]
    scene = sf.Scene(UPPER, 0.3, PAIR.base, PAIR.load)
    assert document["zones"][0]["outer"] == sf.solve(scene).zones[0].outer


def test_a_survey_varies_the_lower_body(printed):
    pytest.importorskip("h5netcdf")
    xarray = pytest.importorskip("xarray")
    line = "survey two.toml --lower-density 2,1e6 --lower-poisson-ratio 0.4,0.5"
    printed(line + " --x 0.5 --t 1 --workers 1 --rtol 1e-8 --output a.nc")
    found = xarray.load_dataset("a.nc", engine="h5netcdf")
    assert found.slip_rate.dims == ("lower_density", "lower_poisson_ratio", "t", "x")
    known = solved()
    here = found.sel(lower_density=2.0, lower_poisson_ratio=0.4)
    assert here.status.item() == "converged"
    assert float(here.edges.sel(edge="outer")[0]) == known.zones[0].outer
    assert float(here.slip_rate[0, 0]) == float(known.slip_rate(0.5, 1.0))
    assert here.lower_shear_speed.item() == pytest.approx(LOWER.shear_speed, rel=1e-14)
    assert here.shear_speed.item() == 1.0
    refused = found.sel(lower_poisson_ratio=0.5)
    assert "poisson_ratio must lie" in refused.status.values[0]
    assert np.isnan(refused.slip_rate).all()
    assert np.isnan(refused.lower_shear_speed).all()
    assert json.loads(found.attrs["scene"])["lower_material"]["shear_modulus"] == 4.0


def test_a_file_of_two_bodies_is_written_from_another(printed):
    for units, scale in (("", 1.0), (" --units SI", 1e9)):
        document = printed(f"init new.toml --force --from two.toml{units}")
        lower = document["scene"]["lower_material"]
        assert lower["shear_modulus"] == scale * LOWER.shear_modulus
        pair = sf.find("new.toml")
        lower = pair.lower_material
        assert lower.shear_modulus == pytest.approx(scale * LOWER.shear_modulus, rel=1e-14)
        assert lower.poisson_ratio == LOWER.poisson_ratio
        ratio = lower.density / pair.material.density
        assert ratio == pytest.approx(LOWER.density / UPPER.density, rel=1e-14)
        assert set(document["units"]["scene"]["lower_material"]) == {*document["scene"]["material"]}


def test_a_simulation_of_a_file_takes_its_lower_body():
    pytest.importorskip("skfem")
    scene = sf.Scene(UPPER, 0.3, PAIR.base, PAIR.load)
    told = sf.cost("two.toml", resolution=8)
    assert told == sf.cost(PAIR, resolution=8)
    assert told != sf.cost(scene, resolution=8)


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_compare_judges_two_bodies(printed, refused, shown, folder, monkeypatch):
    """Once simulated, the bodies are compared again, with a wrong answer, and with other bodies."""
    judged = printed("compare two.toml --resolution 40 --no-snapshots -q --output out")
    assert judged["verdict"] == judged["status"]
    assert judged["parameters"]["lower_material"]["density"] == LOWER.density
    assert judged["semianalytic"]["zones"][0]["outer"] == solved().zones[0].outer
    assert judged["counts"]["differs"] == 0
    rows = {row["name"]: row for row in judged["rows"]}
    assert rows["slip, L1"]["verdict"] == "agrees"
    assert "gap, L1" in rows
    written = {path.name for path in (folder / "out").iterdir()}
    names = ("interface", "fronts", "sense", "history", "gap")
    kept = {"report.html", "report.json", "simulation.h5"}
    assert written == kept | {f"{name}.png" for name in names}
    for line in (
        "compare preloaded --from out",
        "compare two.toml --from out --lower-density 3",
        "compare --from out --lower-density 3",
        "compare two.toml --from out --friction 0.2",
    ):
        assert "another scene" in refused(line)
    from compare.comparison import prediction

    wrong = solved(0.36, rtol=1e-5)
    monkeypatch.setattr(prediction, "solve", lambda scene, method: wrong)
    assert "Verdict: differs" in shown("compare two.toml --from out -q", 1).out


# --- simulations ----------------------------------------------------------------------------------


def simulated(line):
    line = f"simulate {line} --resolution 12 --no-snapshots --output out"
    assert main(line.split()) == 0
    return load_simulation("out")


def test_options_replace_single_parameters():
    sim = simulated("two.toml --lower-shear-modulus 9 --poisson-ratio 0.3 --quiet")
    assert sim.scene.material == sf.Material(1.0, 1.0, 0.3)
    assert sim.scene.lower_material == sf.Material(9.0, 2.0, 0.4)
    assert sim.model == "two blocks of different materials"


def test_folder_says_what_the_lower_block_was(shown):
    shown("simulate preloaded --lower-density 0.5 --resolution 8 --no-snapshots --quiet")
    sim = load_simulation("results/preloaded-lower-density-0.5")
    assert sim.scene.lower_material == sf.Material(1.0, 0.5, 1 / 3)


@pytest.mark.parametrize(
    ("before", "after", "match"),
    [
        ("shear_modulus = 4.0\n", "", "lower_material.shear_modulus is missing"),
        ("density = 2.0", "dense = 2.0", r"unknown key lower_material.dense; did you mean density"),
        ("poisson_ratio = 0.4", "poisson_ratio = 0.5", "poisson_ratio must lie"),
        ("poisson_ratio = 0.4", 'poisson_ratio = "soft"', "poisson_ratio must lie"),
    ],
)
def test_mistakes_in_the_table_are_named(before, after, match, folder):
    (folder / "two.toml").write_text(FILE.replace(before, after))
    with pytest.raises(sf.SceneError, match=match):
        find_scene("two.toml")


def test_opening_and_what_is_under_resolved_are_told(capsys):
    first = simulated("lift-off").interface.x[0]  # one element beyond the edge node
    assert 1 / 12 < first < 1.5 / 12
    told = " ".join(capsys.readouterr().err.split())
    assert f"lift-off: the contact opened, first at x = {first:.4g}" in told
    simulated("preloaded --lower-shear-modulus 0.0625")
    told = " ".join(capsys.readouterr().err.split())
    assert "the lower block is under-resolved" in told
    assert "opened" not in told
