"""Our style gives way to what users set by matplotlib's own means; files keep text and bytes."""

import re
from xml.etree import ElementTree

import matplotlib
import numpy as np
import pytest
from matplotlib import rc_context, rcParams, rcParamsDefault
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from compare.figures.named import answer_figure
from compare.figures.saving import save_figure
from compare.figures.style import BLUE, describe, new_figure, scene_words, style_sheet, styled
from semianalytic import find, solve
from semianalytic.scene.given.finding import names
from slipfront.cli.commands import main

SOLUTION = solve(find("preloaded"), rtol=1e-6)
LARGE = {"font.size": 17.0}
CYCLE = {"axes.prop_cycle": matplotlib.cycler(color=["#123456", "#654321"])}


@pytest.fixture(autouse=True)
def plain():
    """Matplotlib as it is without a matplotlibrc."""
    with rc_context():
        matplotlib.rcdefaults()
        yield


def facts():
    """Size of the title, colours of curve, background and words."""
    figure = answer_figure(SOLUTION)
    upper, _ = figure.axes
    (curve,) = (line for line in upper.lines if len(line.get_xdata()) > 100)
    legend = upper.get_legend().get_texts()[0]
    return {
        "title": figure._suptitle.get_fontsize(),
        "label": upper.yaxis.label.get_fontsize(),
        "legend": legend.get_fontsize(),
        "curve": curve.get_color(),
        "ground": to_hex(upper.get_facecolor()),
        "words": to_hex(legend.get_color()),
        "shade": to_hex(upper.patches[0].get_facecolor()),
        "ticks": upper.xaxis.get_major_ticks()[0].label1.get_fontsize(),
    }


def test_without_settings_the_style_is_ours():
    found = facts()
    assert found["curve"] == BLUE.lower()
    assert (found["label"], found["words"], found["ground"]) == (10.0, "#000000", "#ffffff")
    assert found["title"] == found["legend"] == pytest.approx(8.33)
    changed = [name for name in rcParams if rcParams[name] != rcParamsDefault[name]]
    assert [name for name in changed if not name.startswith("backend")] == []


def test_settings_of_the_user_win():
    ours = facts()
    with rc_context(LARGE):
        large = facts()
    for name in ("title", "label", "legend", "ticks"):
        assert large[name] == pytest.approx(1.7 * ours[name])
    assert large["curve"] == ours["curve"]
    with rc_context(CYCLE):
        assert facts()["curve"] == "#123456"
    with rc_context({"legend.fontsize": 13.0}):
        assert facts() == ours | {"legend": 13.0}


def test_a_style_sheet_of_the_user_wins_and_the_dark_one_can_be_read():
    with matplotlib.style.context("dark_background"):
        dark = facts()
        assert dark["curve"] == to_hex(rcParams["axes.prop_cycle"].by_key()["color"][0])
    assert (dark["ground"], dark["words"]) == ("#000000", "#ffffff")
    assert dark["shade"] < "#808080"


def test_our_style_is_one_of_matplotlib():
    with matplotlib.style.context("compare.figures.slipfront"):
        assert rcParams["axes.prop_cycle"] == style_sheet()["axes.prop_cycle"]
        assert rcParams["svg.fonttype"] == "none"


def test_colours_are_those_of_when_a_figure_was_drawn(tmp_path):
    figure = answer_figure(SOLUTION)
    figure.savefig(tmp_path / "outside.svg")
    assert BLUE.lower() in (tmp_path / "outside.svg").read_text().lower()


@styled
def figure_of_words() -> Figure:
    figure = describe(new_figure(4, 3), SOLUTION.scene)
    figure.subplots().set(xlabel="place [m]", ylabel="speed")
    return figure


@pytest.mark.thinned(3)
@pytest.mark.parametrize(
    ("form", "begins"), [("png", b"\x89PNG"), ("pdf", b"%PDF-"), ("svg", b"<?xml")]
)
def test_the_same_figure_is_the_same_bytes(form, begins, tmp_path, monkeypatch):
    found = []
    for date in ("1", "99999999"):
        monkeypatch.setenv("SOURCE_DATE_EPOCH", date)
        path = tmp_path / date / f"one.{form}"
        save_figure(figure_of_words(), path)
        assert [file.name for file in path.parent.iterdir()] == [path.name]
        found.append(path.read_bytes())
    assert found[0] == found[1]
    assert found[0].startswith(begins)
    assert b"Date" not in found[0]
    if form == "png":
        assert np.ptp(matplotlib.image.imread(path)) > 0


def test_words_stay_words_in_vector_files(tmp_path):
    save_figure(figure_of_words(), tmp_path / "one.svg")
    save_figure(figure_of_words(), tmp_path / "one.pdf")
    root = ElementTree.parse(tmp_path / "one.svg").getroot()
    words = {"".join(text.itertext()).strip() for text in root.findall(".//{*}text")}
    assert "place [m]" in words
    assert any("ν = 0.333" in word for word in words)
    pdf = (tmp_path / "one.pdf").read_bytes()
    assert b"/TrueType" in pdf or b"/CIDFontType2" in pdf
    assert b"/Type3" not in pdf


@pytest.mark.slow
@pytest.mark.parametrize("form", ["pdf", "svg"])
def test_figures_of_a_folder_take_a_format(form, tmp_path, capsys):
    command = f"field antiplane --of vz --points 8 --quiet --figures {form} --gauge 0.4,0.2"
    assert main([*command.split(), "--samples", "5", "--output", str(tmp_path)]) == 0
    figures = {path.name for path in tmp_path.iterdir() if path.suffix != ".csv"}
    assert figures == {f"antiplane_vz.{form}", f"antiplane_gauge-1.{form}"}


@pytest.mark.thinned(2)
@pytest.mark.parametrize(
    "command",
    ["compare", "chart", "field preloaded",
     "validate a.csv --scene preloaded"],
)  # fmt: skip
def test_other_formats_are_refused_before_anything_is_done(command, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main([*command.split(), "--figures", "docx"]) == 2
    assert re.search("--figures must be one of png, pdf, svg, got 'docx'", capsys.readouterr().err)
    assert list(tmp_path.iterdir()) == []


def test_every_named_scene_has_words_for_its_figure():
    for name in names():
        assert "ν = " in scene_words(find(name))
