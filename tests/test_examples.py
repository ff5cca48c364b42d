"""Every program in compare/examples runs, writes its file, and finds what it says it finds."""

import contextlib
import importlib
import io
from pathlib import Path

import pytest

import compare.examples
from compare.examples.fit_friction import TRUE
from semianalytic import Marched, Ramp, SlipWeakening
from semianalytic.scene.named import read_scene

FOLDER = Path(compare.examples.__file__).parent
EXAMPLES = sorted(path.stem for path in FOLDER.glob("*.py") if path.stem != "__init__")


@pytest.fixture(scope="module")
def runs(tmp_path_factory, mesh_cache):
    """What each example returns and prints, and the folder it writes to."""
    found = {}
    for name in EXAMPLES:
        folder, shown = tmp_path_factory.mktemp(name), io.StringIO()
        with contextlib.redirect_stdout(shown), contextlib.chdir(folder):
            found[name] = importlib.import_module(f"compare.examples.{name}").main()
        found[name] = (found[name], shown.getvalue(), folder)
    return found


@pytest.mark.parametrize("name", EXAMPLES)
def test_every_example_runs_and_prints_one_line(name, runs):
    _, shown, folder = runs[name]
    assert shown.count("\n") == 1
    assert list(folder.iterdir())


@pytest.mark.parametrize("name", EXAMPLES)
def test_examples_are_short_and_documented(name):
    lines = (FOLDER / f"{name}.py").read_text().splitlines()
    assert 20 <= sum(bool(line.strip()) for line in lines) <= 50
    assert f"python -m compare.examples.{name}" in "\n".join(lines)


def test_friction_is_recovered_within_three_standard_errors(runs):
    friction, _, folder = runs["fit_friction"]
    assert friction == pytest.approx(TRUE, abs=0.011)
    head = (folder / "fit_friction.csv").read_text().splitlines()[0]
    assert head.startswith("time [s],recorded")


def test_sweep_meets_the_closed_form(runs):
    assert runs["sweep_friction"][0] < 1e-8


def test_snapshots_are_indexed(runs):
    pictures, _, folder = runs["paraview_snapshots"]
    assert pictures == 10
    assert (folder / "snapshots" / "fields.pvd").read_text().count(".vtu") == 10


def test_custom_history_goes_on_from_its_file(runs):
    slip, _, folder = runs["custom_history"]
    saved = Marched.load(folder / "custom_history.h5")
    assert saved.end_time == 30e-6
    assert 0 < abs(slip) < 1e-3


def test_weakening_lets_more_slip(runs):
    constant, rate, weakened = runs["friction_law"][0]
    assert constant < rate
    assert constant < weakened


def test_scene_file_of_the_page_on_extending(tmp_path):
    page = (FOLDER.parents[1] / "docs" / "extending.md").read_text()
    path = tmp_path / "slider.toml"
    path.write_text(page.split("```toml\n")[1].split("```")[0])
    scene = read_scene(path)
    assert scene.shear_history == Ramp(2e-5)
    assert scene.friction_law == SlipWeakening(0.2, 1e-5)
