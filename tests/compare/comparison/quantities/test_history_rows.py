"""Load histories on the command line and in comparisons: both methods, side by side."""

import json
import os
import signal
from contextlib import contextmanager
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from compare_cases import sampled_run

from compare import judge
from compare.comparison.case import worn_by
from compare.comparison.judgement import side_by_side
from compare.comparison.prediction import method_of, predict_like
from compare.comparison.quantities.history_rows import (
    beside_edges,
    event_rows,
    sense_rows,
    slip_sense,
)
from compare.comparison.rows import ALARM
from fem import simulate
from semianalytic import (
    Harmonic,
    Marched,
    Ramp,
    RateWeakening,
    SceneError,
    SlipWeakening,
    march,
    solve,
)
from semianalytic.scene.named import NAMED_SCENES, find_scene
from semianalytic.scene.scene import scene_document, scene_from_document
from slipfront.cli.commands import main

HISTORIES = ["ramp", "unload", "pulse", "harmonic"]


@pytest.mark.thinned(6)
@pytest.mark.parametrize("name", HISTORIES)
def test_both_methods_agree_within_the_bars(name, tmp_path, capsys):
    """At half the default resolution; at the default one the numbers in docs/spacetime.md."""
    folder = tmp_path / name
    resolution = "80" if name == "harmonic" else "60"  # its coarser mesh must follow the load
    command = ["compare", name, "--resolution", resolution, "--no-snapshots", "--quiet"]
    assert main([*command, "--output", str(folder)]) == 0
    report = json.loads((folder / "report.json").read_text())
    assert report["verdict"] == "agrees"
    assert report["method"] == "space-time"
    assert report["semianalytic"] is None
    rows = {row["name"]: row for row in report["rows"]}
    assert rows["other sense, part of map"]["difference"] < 0.06
    assert rows["accumulated |slip|, L1"]["difference"] < 0.05
    assert ("reverse slip, part of map" in rows) == (name != "ramp")
    if name == "harmonic":
        assert rows["work in cycle 3"]["at_nodes"] > 0
        assert any(row.startswith("reversal at") for row in rows)
    assert {path.name for path in folder.iterdir()} >= {"sense.png", "history.png", "wear.png"}
    assert "Verdict: agrees (" in capsys.readouterr().out


@pytest.mark.slow
@pytest.mark.usefixtures("undrawn")
def test_space_time_can_be_forced_where_the_exact_solver_applies(tmp_path):
    folder = tmp_path / "forced"
    command = ["compare", "preloaded", "--method", "space-time", "--resolution", "40", "-q"]
    assert main([*command, "--no-snapshots", "--output", str(folder)]) == 0
    assert json.loads((folder / "report.json").read_text())["method"] == "space-time"


@pytest.mark.thinned(2)
@pytest.mark.parametrize(
    ("law", "slip_rate_error", "verdict"),
    [
        (SlipWeakening(0.5, 0.2), 0.02, "agrees"),
        (RateWeakening(0.5, 0.5), 0.5, "unresolved"),
    ],
    ids=["slip", "rate"],
)
def test_both_methods_agree_on_friction_laws(law, slip_rate_error, verdict):
    """Slip at h = 0.01 c_t T: 0.05 % (slip weakening), 0.3 % (rate weakening).

    Under rate weakening the slip rate of the finite elements flickers from step to step (27 %), and
    converges on no mesh: nothing differs, and nothing is said to agree.
    """
    scene = replace(find_scene("preloaded"), friction_law=law)
    run = simulate(scene, resolution=60)
    judgement = judge(predict_like(run), run)
    rows = {row.name: row for row in judgement.rows}
    assert rows["slip, L1"].difference < 0.01
    assert rows["slip rate over (x, t), L1"].difference < slip_rate_error
    assert judgement.verdict == verdict
    assert judgement.having("differs") == ()


def test_two_predictions_of_one_scene_agree():
    x, t = np.linspace(0, 1.5, 61)[1:], np.linspace(0, 1, 51)
    run = SimpleNamespace(
        scene=find_scene("auxetic"),
        element_size=0.025,
        resolution=40,
        interface=SimpleNamespace(x=x, t=t),
    )
    exact, marched = predict_like(run), predict_like(run, "space-time")
    assert (method_of(exact), method_of(marched)) == ("self-similar", "space-time")
    expected, other = exact.slip(x, 1.0), marched.slip(x, 1.0)
    assert np.abs(other - expected).sum() < 0.01 * np.abs(expected).sum()
    path, marched_path = (worn_by(one, one.history(x, t))[0] for one in (exact, marched))
    assert np.abs(marched_path - path).sum() < 0.03 * path.sum()


@pytest.mark.slow
def test_onset_comes_earlier_when_speeds_are_larger():
    exact = solve(find_scene("preloaded"))
    # The slip that begins there lasts as long as a shear wave takes for 6.5 elements of 100.
    run = sampled_run(exact, resolution=160, times=100, stretch=1.05)
    (row,) = (row for row in event_rows(side_by_side(exact, run)))
    assert row.name == "onset at 0.75 c_t T"
    # Interpolated between a hundred times: less than the step between two.
    assert row.simulated == pytest.approx(row.at_nodes / 1.05, abs=0.01)
    # Far beyond its bar; but slip begins so slowly here that the mesh cannot tell when.
    assert abs(row.difference) > ALARM * row.bar
    assert row.verdict == "unresolved"
    assert row.obstacle.endswith("of the threshold")
    honest = sampled_run(exact, resolution=160, times=100, stretch=1.05, growth=2.0)
    (row,) = (row for row in event_rows(side_by_side(exact, honest)))
    assert row.verdict == "agrees"


@pytest.mark.slow
def test_slip_the_other_way_is_a_difference_of_the_maps():
    exact = solve(find_scene("preloaded"))
    run = sampled_run(exact)
    backward = backward_run(run)
    forward, reverse, other = sense_rows(side_by_side(exact, backward))
    assert (forward.simulated, reverse.at_nodes, other.at_nodes) == (0.0, 0.0, 0.0)
    assert forward.at_nodes == reverse.simulated == other.difference
    assert {row.verdict for row in (forward, reverse, other)} == {"differs"}


def backward_run(run):
    seen = run.interface
    return replace(
        run,
        interface=replace(seen, slip_rate=-seen.slip_rate),
        companion=run.companion and backward_run(run.companion),
    )


def test_sense_and_what_lies_beside_its_edges():
    rate = np.array([[0.0, 0.002, 0.5, -0.3, 1.0, 1.0]])
    np.testing.assert_array_equal(slip_sense(rate, 1.0), [[0, 0, 1, -1, 1, 1]])
    beside = beside_edges(np.array([[0, 0, 0, 0, 1, 1, 1, 1]], dtype=np.int8))
    np.testing.assert_array_equal(beside, [[0, 0, 1, 1, 1, 0, 0, 0]])


# --- scenes in files ------------------------------------------------------------------------

SCENE_FILE = """
friction = 0.3
[material]
shear_modulus = 1.0
density = 1.0
poisson_ratio = 0.3
[base]
pressure = 1.0
shear = 0.0
[load]
pressure = 0.0
shear = 1.0
"""


def test_histories_and_laws_from_a_file(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(
        SCENE_FILE
        + '[shear_history]\nkind = "tabulated"\nt = [0, 1, 2]\nvalue_at_t = [0, 1, 0]\n'
        + '[friction_law]\nkind = "slip-weakening"\nreduction = 0.5\ndistance = 0.2\n'
    )
    scene = find_scene(str(path))
    assert scene.shear_history.value(0.5) == 0.5
    assert scene.friction_law == SlipWeakening(0.5, 0.2)
    assert scene_from_document(scene_document(scene)) == scene


@pytest.mark.parametrize("named", NAMED_SCENES.values(), ids=list(NAMED_SCENES))
def test_documents_of_scenes_come_back(named):
    text = json.dumps(scene_document(named.scene))
    assert scene_from_document(json.loads(text)) == named.scene


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ('[shear_history]\nkind = "sawtooth"\n', "kind must be one of step, ramp"),
        ('[shear_history]\nkind = "ramp"\n', "kind ramp needs rise_time"),
        ('[shear_history]\nkind = "ramp"\nrise_time = -1.0\n', "0 or more, got -1.0"),
        ('[shear_history]\nkind = "ramp"\nrise = 1.0\n', "kind ramp has no 'rise'"),
        ('[shear_history]\nkind = "pulse"\nduration = nan\n', "must be a positive number"),
        (
            '[shear_history]\nkind = "tabulated"\nt = [1, 0]\nvalue_at_t = [0, 1]\n',
            "must start at 0 or later and not decrease",
        ),
        ('[shear_histories]\nkind = "step"\n', "did you mean shear_history"),
        ('[friction_law]\nkind = "rate-weakening"\nreduction = 2\nrate = 1\n', "between 0 and 1"),
        (
            '[friction_law]\nkind = "rate-weakening"\nreduction = 1\nrate = 0.1\n',
            "faster than radiation can balance",
        ),
    ],
)
def test_bad_files_are_refused(tmp_path, capsys, table, message):
    path = tmp_path / "scene.toml"
    path.write_text(SCENE_FILE + table)
    assert main(["solve", str(path)]) == SceneError.exit_code
    assert message in capsys.readouterr().err


# --- slipfront solve ------------------------------------------------------------------------


def test_solve_marches_saves_and_goes_on(tmp_path, capsys):
    saved, plot = tmp_path / "march.h5", tmp_path / "march.png"
    command = ["solve", "harmonic", "--nodes", "120", "--end-time", "0.5", "--latest", "1"]
    assert main([*command, "--save", str(saved), "--plot", str(plot)]) == 0
    assert "reach of reverse slip" in capsys.readouterr().out
    assert plot.stat().st_size > 10_000
    assert main(["solve", "harmonic", "--go-on", str(saved), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["end_time"] == 1.0
    whole = march(find_scene("harmonic"), 1.0, 120, length=Marched.load(saved).interface.x[-1] * 1)
    assert document["frictional_work"] == pytest.approx(
        whole.final_work_density.sum() * whole.grid.spacing, rel=0.05
    )


@pytest.mark.parametrize(
    ("command", "message"),
    [
        (["solve", "preloaded", "--nodes", "50"], "add --method space-time"),
        (["solve", "harmonic", "--method", "self-similar"], "use the space-time solver"),
        (["solve", "harmonic", "--step-ratio", "0.9"], "lower it by"),
        (["solve", "lift-off", "--method", "space-time"], "turn tensile"),
        (["compare", "lift-off", "--base-pressure", "0"], "nothing holds the contact together"),
        (["compare", "ramp", "--method", "self-similar"], "use the space-time solver"),
    ],
)
def test_what_cannot_be_solved_is_refused(command, message, capsys):
    assert main(command) == SceneError.exit_code
    assert message in capsys.readouterr().err


def test_interrupted_march_is_saved(tmp_path, monkeypatch, capsys):
    """Ctrl-C after 30 steps: the file holds them, and can go on."""

    @contextmanager
    def pressing(*_):
        yield lambda done, steps: os.kill(os.getpid(), signal.SIGINT) if done == 30 else None

    monkeypatch.setattr("compare.output.progress.progress_bar", pressing)
    saved = tmp_path / "march.h5"
    assert main(["solve", "harmonic", "--nodes", "100", "--save", str(saved)]) == 130
    assert "holds the march until" in " ".join(capsys.readouterr().err.split())
    marched = Marched.load(saved)
    assert marched.statistics.steps == 30
    monkeypatch.undo()
    assert main(["solve", "harmonic", "--go-on", str(saved), "--json"]) == 0


def test_going_on_with_another_scene_is_refused(tmp_path, capsys):
    saved = tmp_path / "march.h5"
    march(find_scene("ramp"), 0.5, 50, latest=1.0).save(saved)
    assert main(["solve", "harmonic", "--go-on", str(saved)]) == SceneError.exit_code
    assert main(["solve", "ramp", "--go-on", str(saved), "--nodes", "60"]) == SceneError.exit_code
    assert "leave one of the two out" in capsys.readouterr().err
    saved.write_bytes(saved.read_bytes()[:500])
    assert main(["solve", "ramp", "--go-on", str(saved)]) == 3


def test_descriptions_are_compared_by_value():
    assert find_scene("ramp").shear_history == Ramp(0.5)
    assert find_scene("harmonic").shear_history == Harmonic(3.0)
