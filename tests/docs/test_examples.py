"""Every program in docs/examples runs, writes its file, and finds what it says it finds."""

import contextlib
import importlib
import io
import re
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from figure_catalogue import SMALLER

import docs.examples
from docs.examples import __main__ as gallery
from docs.examples.fit_friction import TRUE
from semianalytic import Marched, Ramp, SlipWeakening
from semianalytic.scene.given.files import read_scene
from slipfront.cli.commands import main

FOLDER = Path(docs.examples.__file__).parent
EXAMPLES = sorted(path.stem for path in FOLDER.glob("[a-z]*.py"))
DOCS = FOLDER.parent
SECTIONS = dict(
    re.findall(r"^## (\w+)$(.+?)(?=^## |\Z)", (DOCS / "gallery.md").read_text(), re.M | re.S)
)
NUMBER = re.compile(r"\d+(?:\.\d+)?(?:e-?\d+)?")


@pytest.fixture(scope="module")
def runs(tmp_path_factory, mesh_cache):
    """A function that runs an example once: what it returns and prints, and where it writes."""

    @cache
    def run(name):
        folder, shown = tmp_path_factory.mktemp(name), io.StringIO()
        with contextlib.redirect_stdout(shown), contextlib.chdir(folder):
            program = importlib.import_module(f"docs.examples.{name}")
            found = program.main(**SMALLER.get(name, {}))
        return found, shown.getvalue(), folder

    return run


@pytest.mark.thinned(13)
@pytest.mark.parametrize("name", EXAMPLES)
def test_every_example_runs_and_prints_one_line(name, runs):
    _, shown, folder = runs(name)
    assert shown.count("\n") == 1
    assert (folder / f"{name}.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("name", EXAMPLES)
def test_examples_are_short_and_documented(name):
    lines = (FOLDER / f"{name}.py").read_text().splitlines()
    assert 20 <= sum(bool(line.strip()) for line in lines) <= 50
    assert f"python -m docs.examples.{name}" in "\n".join(lines)


@pytest.mark.thinned(13)
@pytest.mark.parametrize("name", EXAMPLES)
def test_gallery_shows_every_example_and_what_it_prints(name, runs):
    section = SECTIONS[name]
    assert f"`docs/examples/{name}.py`" in section
    assert f"](figures/examples/{name}.png)" in section
    assert (DOCS / "figures" / "examples" / f"{name}.png").stat().st_size < 100_000
    quoted, shown = section.split("```text\n")[1].split("\n```")[0], runs(name)[1].strip()
    assert NUMBER.sub("#", quoted) == NUMBER.sub("#", shown)
    values = [[float(number) for number in NUMBER.findall(text)] for text in (quoted, shown)]
    assert values[1] == pytest.approx(values[0], rel=2e-3, abs=1e-9)


def test_gallery_is_drawn_in_its_own_order(tmp_path, monkeypatch):
    assert list(SECTIONS) == list(gallery.EXAMPLES)
    assert sorted(SECTIONS) == EXAMPLES
    monkeypatch.setattr(gallery, "EXAMPLES", ("first_answer",))
    gallery.main(tmp_path / "figures")
    assert [path.name for path in (tmp_path / "figures").iterdir()] == ["first_answer.png"]


def test_page_for_newcomers_asks_the_command_line_the_same(capsys):
    page = (DOCS / "start.md").read_text()
    line = page.split("    slipfront solve")[1].split("\n\n")[0].replace("\\\n", " ")
    assert main(["solve", *line.split()]) == 0
    velocities = [float(number) for number in NUMBER.findall(capsys.readouterr().out)]
    edges = re.findall(r"([\d.]+)(?: to| m/s,)", page.split("```text\n")[1].split("```")[0])
    assert len(edges) == 4
    for edge in edges:
        assert any(float(edge) == pytest.approx(velocity, abs=0.06) for velocity in velocities)


def test_friction_is_recovered_within_three_standard_errors(runs):
    friction, _, folder = runs("fit_friction")
    assert friction == pytest.approx(TRUE, abs=0.011)
    head = (folder / "fit_friction.csv").read_text().splitlines()[0]
    assert head.startswith("time [s],recorded")


def test_sweep_meets_the_closed_form(runs):
    assert runs("sweep_friction")[0] < 1e-8


@pytest.mark.slow
def test_a_product_bends_the_posterior_and_the_chains_follow(runs):
    """Two gains act by their product c and are alike beforehand: ln gain is normal about
    half of ln c, with the width of their priors over the root of two."""
    samples = runs("posterior")[0]
    logarithms = np.log(samples)
    product = logarithms.sum(axis=1)
    width, effective = np.log(1.4) / 2**0.5, (len(samples) / 2) ** 0.5
    assert product.std() < 0.3 * logarithms[:, 0].std()
    assert logarithms[:, 0].std() == pytest.approx(width, rel=4 / effective)
    assert logarithms[:, 0].mean() == pytest.approx(product.mean() / 2, abs=4 * width / effective)
    third = np.mean((samples[:, 0] - samples[:, 0].mean()) ** 3)
    assert third / samples[:, 0].std() ** 3 > 0.4  # no ellipse is skew


@pytest.mark.slow
def test_survey_is_kept_to_its_accuracy(runs):
    estimate, _, folder = runs("survey_map")
    assert estimate <= 1e-6
    assert (folder / "survey_map.nc").read_bytes().startswith(b"\x89HDF")


@pytest.mark.slow
def test_custom_history_goes_on_from_its_file(runs):
    slip, _, folder = runs("custom_history")
    saved = Marched.load(folder / "custom_history.h5")
    assert saved.end_time == 30e-6
    assert 0 < abs(slip) < 1e-3


def test_scene_file_of_the_page_on_extending(tmp_path):
    page = (DOCS / "extending.md").read_text()
    path = tmp_path / "slider.toml"
    path.write_text(page.split("```toml\n# slider.toml\n")[1].split("```")[0])
    scene = read_scene(path)
    assert scene.shear_history == Ramp(2e-5)
    assert scene.friction == SlipWeakening(0.4, 0.32, 1e-5)
