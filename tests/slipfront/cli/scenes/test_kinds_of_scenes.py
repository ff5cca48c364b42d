"""What kinds of scenes the commands take: whole lines, moving fronts, antiplane shear, marches."""

import json
import os
import signal
from contextlib import contextmanager
from dataclasses import replace

import pytest

import slipfront as sf
from semianalytic import Marched, find, solve

# --- whole lines and growing loads ----------------------------------------------------------------

HALF_LINE = """
contact = "whole line"
friction = 0.5
units = "SI"
[material]
shear_modulus = 30e9
density = 2700.0
poisson_ratio = 0.25
[base]
pressure = 10e6
shear = 1e6
[load]
kind = "half-line"
shear = 8e6
"""


@pytest.mark.parametrize("name", ["whole-line-patch", "point-load", "growing-load"])
def test_a_named_line_is_solved(shown, printed, name):
    problem = find(name)
    answer = solve(problem)
    said = shown(f"solve {name} --end-time 2").out
    assert f"{answer.edge_speed:.6g}" in said
    assert "converged" in said
    document = printed(f"solve {name} --end-time 2")
    assert document["edge"]["speed"] == answer.edge_speed
    end = document["until_end_time"]
    assert end["accumulated_slip"] == pytest.approx(float(answer.accumulated_slip(2.0)))
    if name == "point-load":
        assert end["largest_slip"] is None  # infinite at the force


def test_a_line_in_si_units_has_them(tmp_path, printed):
    path = tmp_path / "patch.toml"
    text = HALF_LINE.replace('"half-line"', '"patch"\nspeed = 500.0')
    path.write_text(text)
    document = printed(["solve", path])
    assert document["units"]["edge"]["speed"] == "m/s"
    assert document["units"]["scene"]["load"]["shear"] == "Pa"
    path.write_text(text.replace('"patch"\nspeed = 500.0', '"point-force"'))
    document = printed(["solve", path])
    assert document["units"]["scene"]["load"]["shear"] == "N/(m s)"
    growing = text.replace('contact = "whole line"', "").replace("pressure = 10e6", "pressure = 0")
    growing = growing.replace("shear = 1e6", "shear = 0")
    load = '"growing"\npower = 2\npressure = 10e6'
    path.write_text(growing.replace('"patch"\nspeed = 500.0', load))
    document = printed(["solve", path])
    assert document["units"]["scene"]["load"]["shear"] == "Pa/s^2"
    assert document["units"]["edge"]["amplitude"] == "m/s^3"


def test_a_half_line_is_solved_as_the_slot_that_moves_alike(tmp_path, printed):
    path = tmp_path / "half.toml"
    path.write_text(HALF_LINE)
    document = printed(["solve", path])
    assert document["scene"]["load"] == {"pressure": 0.0, "shear": 4e6}
    assert document["zones"][0]["inner"] == 0
    marched = printed(["solve", path, "--method", "space-time", "--nodes", 300])
    assert marched["method"] == "space-time"


@pytest.mark.thinned(2)
@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("whole-line-patch", ("shear traction", "strength f p")),
        ("growing-load", ("shear traction", "strength f p")),
        ("pair-slip", ("slip rate", "shear traction", "pressure")),
    ],
)
def test_a_figure_is_drawn(name, words, tmp_path, shown):
    shown(f"solve {name} --plot a.svg")
    text = (tmp_path / "a.svg").read_text()
    assert [word for word in words if word not in text] == []


# --- two half-planes that slide -------------------------------------------------------------------

GOUGE, ROCK = "12e9,2300,0.25", "30e9,2700,0.25"


def sliding(upper=GOUGE, lower=ROCK, friction="0.4"):
    return f"sliding --upper {upper} --lower {lower} --friction {friction}"


def test_a_verdict_and_thresholds_are_printed(shown):
    said = shown(sliding()).out
    assert "0.531417" in said
    assert "well posed" in said


def test_json_has_the_waves(printed):
    document = printed(sliding(friction="0.6"))
    assert document["well_posed"] is False
    assert document["waves"][0]["per_wavelength"] == pytest.approx(1.0533, abs=1e-4)
    assert document["threshold_with"] == pytest.approx(0.5314169, abs=1e-7)


def test_what_is_infinite_is_null_and_bodies_may_have_units(printed):
    document = printed(sliding(lower=GOUGE))
    upper, lower = "12GPa,2.3g/cm3,0.25", "12e6kPa,2300kg/m3,25%"
    assert printed(sliding(upper=upper, lower=lower, friction="40%")) == document
    assert document["threshold_with"] is None
    assert document["delayed_growth"] is None


# --- waves at an angle and moving loads -----------------------------------------------------------


def test_a_march_knows_the_intensity_of_the_moving_front(printed):
    stuck = printed("solve incident-sv --friction 5 --method space-time --nodes 40")
    marched = stuck["stress_intensity_of_a_stuck_edge"]
    exact = solve(replace(find("incident-sv"), friction=5.0)).stress_intensity(1.0)
    assert list(marched.values()) == pytest.approx([float(answer) for answer in exact], rel=1e-12)


def test_sv_beyond_critical_is_marched_if_asked_for(printed):
    wave = "solve incident-sv --angle 45 --wave-stress=-0.3 --nodes 40 --friction 0.1"
    near, far = (printed(f"{wave} --method space-time --entry {entry}") for entry in (0.5, 1.0))
    assert near["stress_intensity_of_a_stuck_edge"] == {}
    assert near["statistics"]["steps"] < far["statistics"]["steps"]


# --- antiplane shear ------------------------------------------------------------------------------


@pytest.mark.usefixtures("undrawn")
def test_compare_agrees_on_the_named_scene(tmp_path, shown):
    said = shown("compare antiplane --resolution 24 --frames 1 --output out --quiet").out
    document = json.loads((tmp_path / "out" / "report.json").read_text())
    assert document["verdict"] == "agrees"
    rows = {"S front, interface (shear traction)", "zone 1, outer edge", "slip rate, L1"}
    assert {row["name"] for row in document["rows"]} >= rows | {"v_z, whole"}
    assert "Rayleigh front" not in said


def test_any_scene_can_be_turned(printed):
    document = printed("solve preloaded --mode antiplane")
    assert document["scene"]["mode"] == "antiplane"
    assert document["wave_speeds"] == {"shear": 1.0}
    assert document["zones"][0]["outer"] == pytest.approx(1 / 1.3**2, rel=1e-8)
    assert document["zones"][0]["outer_regime"] == "sub-shear"
    assert set(document["edge"]["stress_intensity_at_unit_time"]) == {"K_I", "K_III"}


# --- answers that are saved; marches interrupted and continued ------------------------------------


def test_solve_saves_an_exact_answer(shown, printed, refused):
    assert "Saved in answer.h5" in shown("solve preloaded --friction 0.2 --save answer.h5").out
    ends = [zone.outer for zone in sf.load("answer.h5").zones]
    assert ends == [zone["outer"] for zone in printed("solve answer.h5")["zones"]]
    assert printed("solve whole-line-patch --save patch.h5")["files"] == ["patch.h5"]
    assert sf.load("patch.h5").scene == find("whole-line-patch")
    assert "ends in .h5" in refused("solve preloaded --save answer.nc")
    solve(find("ramp"), nodes=50).save("march.h5")
    assert "--go-on continues a saved march" in refused("solve march.h5", 3)


def test_solve_marches_saves_and_goes_on(tmp_path, shown, printed):
    options = "--nodes 120 --end-time 0.5 --latest 1 --save march.h5 --plot march.png"
    assert "reach of reverse slip" in shown(f"solve harmonic {options}").out
    assert (tmp_path / "march.png").stat().st_size > 10_000
    document = printed("solve harmonic --go-on march.h5")
    assert document["end_time"] == 1.0
    length = Marched.load("march.h5").interface.x[-1]
    whole = solve(find("harmonic"), method="space-time", end_time=1.0, nodes=120, length=length)
    assert document["frictional_work"] == pytest.approx(
        whole.final_work_density.sum() * whole.spacing, rel=0.05
    )


def test_interrupted_march_is_saved(monkeypatch, shown, printed):
    """Ctrl-C after the first steps: the file holds them, and can go on."""

    @contextmanager
    def pressing(*_):
        yield lambda done, parts: os.kill(os.getpid(), signal.SIGINT) if done > 0 else None

    with monkeypatch.context() as patch:
        patch.setattr("compare.output.progress.progress_bar", pressing)
        said = shown("solve harmonic --nodes 100 --save march.h5", 130).err
    assert "holds the march until" in " ".join(said.split())
    assert 0 < Marched.load("march.h5").end_time < 0.1
    printed("solve harmonic --go-on march.h5")

    with monkeypatch.context() as patch:
        patch.setattr("compare.output.progress.progress_bar", pressing)
        shown("solve supershear --nodes 128 --save line.h5 --no-estimate", 130)
    assert 0 < Marched.load("line.h5").end_time < 30


def test_going_on_with_another_scene_is_refused(tmp_path, refused):
    saved = tmp_path / "march.h5"
    solve(find("ramp"), method="space-time", end_time=0.5, nodes=50, latest=1.0).save(saved)
    refused("solve harmonic --go-on march.h5")
    assert "leave one of the two out" in refused("solve ramp --go-on march.h5 --nodes 60")
    saved.write_bytes(saved.read_bytes()[:500])
    refused("solve ramp --go-on march.h5", 3)
