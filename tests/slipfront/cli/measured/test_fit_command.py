"""``slipfront fit``: tables, JSON, pictures, exit codes, one sentence for what is wrong."""

import json
from pathlib import Path

import numpy as np
import pytest
from catalogue import PRELOADED
from faults import ROOT

from docs.studies import samples
from semianalytic import find, solve
from semianalytic.inversion.quoted import PLACES
from slipfront.fits import read_gauges
from tests.slipfront.surveys.test_interface_surveys import FAULT

NOISE = 0.02
LINE = "--scene preloaded --friction 0.32 --parameters friction"


@pytest.fixture(scope="module")
def records(tmp_path_factory):
    """Slip rate at two places, as text."""
    solution, random = solve(PRELOADED), np.random.default_rng(4)
    rows = ["t,x,slip_rate"]
    for x in (0.4, 0.9):
        t = np.linspace(0.4 * x, 4 * x, 40)
        rate = solution.slip_rate(x, t) + random.normal(scale=NOISE, size=len(t))
        rows += [f"{a},{x},{b}" for a, b in zip(t.tolist(), rate.tolist(), strict=True)]
    path = tmp_path_factory.mktemp("records") / "rates.csv"
    path.write_text("\n".join(rows) + "\n")
    return path


def test_a_fit_is_shown_drawn_and_written(records, tmp_path, shown):
    """Of a gain, which takes one solution."""
    line = f"--scene preloaded --parameters gain --noise {NOISE} --plot fit.png --output fit.json"
    said = shown(f"fit {records} {line}").out
    assert "Fit: converged" in said
    assert "misfits are as large as the noise" in said
    # stress before the load is 0 and friction constant: no stress drop, fracture energy or S
    assert sum(row.count("- │") == 3 for row in said.splitlines()) == PLACES
    assert (tmp_path / "fit.png").read_bytes().startswith(b"\x89PNG")
    found = json.loads((tmp_path / "fit.json").read_text())
    gain = found["parameters"]["gain"]
    assert abs(gain["value"] - 1.0) < 4 * gain["standard_error"] < 0.1
    assert found["status"] == "converged"
    assert found["units"]["parameters"] == {"gain": "1"}
    assert found["units"]["gauges"]["x"] == "length"
    assert [gauge["samples"] for gauge in found["gauges"]] == [40, 40]
    for name in ("stress_drop", "fracture_energy", "strength_ratio"):
        assert found["rupture"][name]["value"] == [None] * PLACES


def test_json_is_all_that_is_printed_and_priors_count(records, printed):
    line = f"{LINE} --noise slip_rate={NOISE} --prior friction=normal(0.31,1e-4)"
    found = printed(f"fit {records} {line}")
    friction = found["parameters"]["friction"]["value"]
    assert friction == found["scene"]["friction"] == pytest.approx(0.31, abs=3e-4)
    assert found["known_by_prior"] == ["friction"]


@pytest.mark.slow
def test_misfits_that_noise_does_not_explain_are_in_the_headline(records, shown):
    line = f"--scene preloaded --friction 0.6 --parameters load_shear --noise {NOISE}"
    said = shown(f"fit {records} {line}", 4)
    assert "Fit: misfits are " in said.out
    assert said.err.startswith("The fit is not to be relied upon: misfits are ")
    assert said.err.count("\n") == 1


@pytest.mark.slow
def test_what_the_data_leave_free_is_exit_code_four(records, shown):
    line = f"--scene preloaded --parameters friction,base_pressure --noise {NOISE}"
    said = shown(f"fit {records} {line}", 4)
    assert "not constrained" in said.out
    assert "do not constrain friction and base_pressure apart" in said.err


# --- an interface ---------------------------------------------------------------------------------


@pytest.fixture
def fault(tmp_path):
    """A file of an interface, and the file of a recorder with slip on it and strain in the body,
    which are a tenth too large."""
    (tmp_path / "fault.toml").write_text(FAULT)
    t = np.linspace(0.4, 2.0, 5)
    done = solve(find("fault.toml"), end_time=2.0, nodes=32, times=t, estimate=False)
    columns = t, 1.1 * done.slip(-1.0, t), 1.1e6 * done.strain(-1.0, 0.6, t)[2]
    rows = "".join(f"{at},{slip},{strain}\n" for at, slip, strain in zip(*columns, strict=True))
    (tmp_path / "recorder.csv").write_text("t,LVDT,SG1 [ustrain]\n" + rows)


def test_a_gain_is_fitted_to_a_wide_file(fault, printed):
    line = "recorder.csv --gauge LVDT=slip@-1 --gauge SG1=exy@-1,0.6 --noise slip=0.2 --noise 0.05"
    document = printed(f"fit {line} --scene fault.toml --parameters gain", 4)
    assert document["parameters"]["gain"]["value"] == pytest.approx(1.1, abs=0.02)
    assert document["scene"]["friction_law"]["kind"] == "slip-weakening"
    assert document["scene"]["run"]["nodes"] == 32
    assert [gauge["quantity"] for gauge in document["gauges"]] == ["slip", "exy"]
    assert document["units"]["rupture"]["fracture_energy"] == "stress length"
    assert document["rupture"]["x"] == [-1.0]
    energy = document["rupture"]["fracture_energy"]
    assert 0 < energy["from"][0] < energy["value"][0] < energy["to"][0]


# --- records of a march in PMMA, as they are committed --------------------------------------------

DATA = ROOT / "docs" / "data"
TRUTH = {"friction": 0.35, "load_shear": 4e6, "t0": 3e-6}
SCENE = f"--scene {DATA / 'pmma.toml'} --parameters {','.join(TRUTH)}"
NOISES = f"--noise {samples.STRAIN_NOISE} --noise ux={samples.MOTION_NOISE}"


@pytest.mark.slow
@pytest.mark.parametrize(
    "line",
    [f"{DATA}/pmma_slip.csv", f"{DATA}/pmma_gauges.csv {DATA}/pmma_line.csv {NOISES}"],
    ids=["slip across the interface", "strain gauges and a line off it"],
)
def test_what_was_recorded_in_pmma_is_fitted(line, shown):
    """The truth lies within the ellipse that all but a thousandth of such fits have it in."""
    shown(f"fit {line} {SCENE} --output fit.json --plot fit.png")
    assert Path("fit.png").stat().st_size > 10_000
    found = json.loads(Path("fit.json").read_text())
    assert list(found["parameters"]) == list(TRUTH)
    away = [found["parameters"][name]["value"] - value for name, value in TRUTH.items()]
    assert away @ np.linalg.solve(found["covariance"], away) < 16.3
    assert found["misfit"] == "misfits are as large as the noise"
    assert found["units"]["parameters"] == {"friction": "1", "load_shear": "Pa", "t0": "s"}
    if "gauges" in line:
        assert found["parameters"]["friction"]["standard_error"] < 0.005
        assert 0 < found["derivative_error"] < 0.2


@pytest.mark.slow
def test_the_committed_records_are_those_of_their_command(tmp_path):
    samples.main(tmp_path)
    for name in ("pmma_gauges.csv", "pmma_line.csv", "pmma_slip.csv"):
        noise = {"": 1.0}
        pairs = zip(
            read_gauges([tmp_path / name], noise), read_gauges([DATA / name], noise), strict=True
        )
        for new, old in pairs:
            np.testing.assert_allclose(new.values, old.values, atol=1.1e-6)
