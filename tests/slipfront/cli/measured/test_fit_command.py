"""``slipfront fit``: tables, JSON, pictures, exit codes, one sentence for what is wrong."""

import json

import numpy as np
import pytest
from catalogue import PRELOADED

from semianalytic import solve
from slipfront.cli.commands import main

NOISE = 0.02
LINE = "--scene preloaded --friction 0.4 --parameters friction"


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


def run(line, records):
    return main(["fit", str(records), *line.split()])


def test_a_fit_is_shown_drawn_and_written(records, tmp_path, capsys):
    picture, document = tmp_path / "fit.png", tmp_path / "fit.json"
    assert run(f"{LINE} --noise {NOISE} --plot {picture} --output {document}", records) == 0
    shown = capsys.readouterr().out
    assert "Fit: converged" in shown
    assert "misfits are as large as the noise" in shown
    assert picture.read_bytes().startswith(b"\x89PNG")
    found = json.loads(document.read_text())
    friction = found["parameters"]["friction"]
    assert abs(friction["value"] - 0.3) < 4 * friction["standard_error"] < 0.1
    assert found["status"] == "converged"
    assert found["units"]["parameters"] == {"friction": "1"}
    assert found["units"]["gauges"]["x"] == "length"
    assert [gauge["samples"] for gauge in found["gauges"]] == [40, 40]
    assert found["scene"]["friction"] == friction["value"]


def test_json_is_all_that_is_printed_and_priors_count(records, printed):
    line = f"{LINE} --noise slip_rate={NOISE} --prior friction=normal(0.31,1e-4)"
    found = printed(f"fit {records} {line}")
    assert found["parameters"]["friction"]["value"] == pytest.approx(0.31, abs=3e-4)
    assert found["known_by_prior"] == ["friction"]


def test_misfits_that_noise_does_not_explain_are_in_the_headline(records, capsys):
    line = f"--scene preloaded --friction 0.6 --parameters load_shear --noise {NOISE}"
    assert run(line, records) == 4
    captured = capsys.readouterr()
    assert "Fit: misfits are " in captured.out
    assert captured.err.startswith("The fit is not to be relied upon: misfits are ")
    assert captured.err.count("\n") == 1


@pytest.mark.slow
def test_what_the_data_leave_free_is_exit_code_four(records, capsys):
    names = "friction,base_pressure"
    line = f"--scene preloaded --parameters {names} --noise {NOISE}"
    assert run(line, records) == 4
    captured = capsys.readouterr()
    assert "not constrained" in captured.out
    assert "do not constrain friction and base_pressure apart" in captured.err


@pytest.mark.slow
def test_short_chains_are_unresolved(records, capsys):
    line = f"{LINE} --noise {NOISE} --posterior --steps 6 --quiet --json"
    assert run(line, records) == 4
    captured = capsys.readouterr()
    assert json.loads(captured.out)["posterior"]["status"].startswith("unresolved")
    assert "autocorrelation times" in captured.err


@pytest.mark.thinned(2)
@pytest.mark.parametrize(
    ("line", "code", "message"),
    [
        (LINE, 3, "does not say how exact its slip_rate is"),
        (f"{LINE} --noise much", 2, "or NAME=NUMBER for one quantity"),
        (f"{LINE} --noise 3frob", 2, "m, cm, mm, um or km; "),
        (f"{LINE} --noise slip_rate=much", 2, "slip_rate: the number must be a number alone"),
        (f"{LINE} --noise 1e-160", 2, "noise of all must lie within 1e-60"),
        (f"{LINE} --noise 1e-20", 2, "noise must lie within"),
        (f"{LINE} --noise -1", 2, "noise of all must be positive"),
        (f"{LINE} --noise speed=1", 2, "--noise knows slip_rate"),
        (f"{LINE} --noise 0.1 --prior friction=0.3", 2, "--prior must be NAME=KIND(A,B)"),
        (f"{LINE} --noise 0.1 --prior friction=flat(0,1)", 2, "normal, lognormal, uniform"),
        (f"{LINE} --noise 0.1 --prior t0=normal(0,1)", 2, "prior of 't0', which is not fitted"),
        (f"{LINE} --noise 0.1 --setup x1=3", 2, "--setup knows t0, x0, gain"),
        (f"{LINE},speed --noise 0.1", 2, "parameters must be among friction"),
        (f"{LINE} --noise 0.1 --plot fit.xyz", 2, "Figures cannot be written as 'fit.xyz'"),
        ("--scene ramp --parameters friction --noise 0.1", 2, "step loads only"),
    ],
)
def test_what_is_wrong_is_one_sentence(line, code, message, records, refused):
    assert message in refused(f"fit {records} {line}", code)
