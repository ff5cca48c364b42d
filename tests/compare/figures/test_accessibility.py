"""Every figure can be read by the colour-blind, says nu, f and units, and stands out from paper."""

import re
from functools import cache
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from colour_vision import VISIONS, contrast, least_difference, lightness_is_ordered
from figure_catalogue import CATALOGUE
from matplotlib.collections import QuadMesh
from matplotlib.colors import ListedColormap, to_hex, to_rgba
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle
from matplotlib.patheffects import withStroke
from matplotlib.text import Text

import compare
from compare.figures import style

SLOW = {
    "slipfront.fits.figures.fit_figure",
    *(name for name in CATALOGUE if name.startswith("docs.examples.")),
}
"""Figures that take seconds to make: more than half of the time of this file."""
EACH = pytest.mark.parametrize(
    "name", [pytest.param(entry, marks=[pytest.mark.slow] * (entry in SLOW)) for entry in CATALOGUE]
)
LEAST_APART = 15.0
"""Least distance of curves and marks of one form in CIELAB; side by side 2.3 is just seen."""
LEAST_FILLS_APART = 8.0
"""Least distance of areas, which are larger."""
LEAST_CONTRAST = 3.0
"""WCAG 2.2, of graphical objects."""
FACTS = {
    "nu": r"ν|\\nu|Poisson ratio",
    "f": r"\bf =|\bf\$? (?:P|without|times|varies)|\$f|friction|f\\,|f P",
    "units": r"\[[^\]]+\]|V₀|V_0|[^a-z]/[ \\$]*c_t|c_t T|relative|over|cₜ|units|[PQ]_[0b]/[PQ|]",
}


@cache
def drawn(name):
    figure = CATALOGUE[name]()
    figure.set_layout_engine("none")  # draws several times; nothing here depends on places
    figure.draw_without_rendering()
    return figure


def maps(panel):
    """Images and meshes of a panel."""
    return [artist for artist in panel.get_children() if isinstance(artist, QuadMesh | AxesImage)]


def over(colour, ground, alpha=None):
    """What a colour is on a ground that it may let through."""
    *rgb, own = to_rgba(colour, alpha)
    return to_hex(own * np.array(rgb) + (1 - own) * np.array(to_rgba(ground)[:3]))


def curves(panel):
    """Lines of a panel that can be seen."""
    return [line for line in panel.lines if line.get_visible() and len(line.get_xdata())]


def forms(line):
    """How a line looks but for its colour."""
    return line.get_linestyle(), line.get_marker(), line.get_linewidth() > 2


def entries(panel, figure):
    """What legends of a panel, and of the figure, tell apart."""
    legends = [*figure.legends, *([panel.get_legend()] if panel.get_legend() else [])]
    return [handle for legend in legends for handle in legend.legend_handles]


def too_near(figure):
    """Pairs of colours that some reader could take for one another."""
    for panel in figure.axes:
        ground = panel.get_facecolor()
        handles = entries(panel, figure)
        lines = [*curves(panel), *(handle for handle in handles if isinstance(handle, Line2D))]
        looks = {(over(line.get_color(), ground, line.get_alpha()), forms(line)) for line in lines}
        fills = {over(item.get_facecolor(), ground) for item in handles if isinstance(item, Patch)}
        pairs = [
            (a, b, LEAST_APART)
            for (a, form), (b, other) in combinations(sorted(looks), 2)
            if form == other and a != b
        ]
        for entry in maps(panel):
            if isinstance(entry.get_cmap(), ListedColormap) and entry.get_cmap().N < 20:
                fills |= {to_hex(colour) for colour in entry.get_cmap().colors}
        pairs += [(a, b, LEAST_FILLS_APART) for a, b in combinations(sorted(fills), 2)]
        for a, b, least in pairs:
            if least_difference(a, b) < least:
                yield a, b, round(least_difference(a, b), 1)


def faint(figure):
    """Words and curves that do not stand out from what is behind them."""
    for panel in figure.axes:
        grounds = {to_hex(panel.get_facecolor())}
        grounds |= {
            over(patch.get_facecolor(), panel.get_facecolor())
            for patch in panel.patches
            if isinstance(patch, Rectangle)
        }
        for line in curves(panel):
            behind = strokes(line) if maps(panel) else grounds
            if line.get_markeredgecolor() == style.BLACK != line.get_color():
                behind = {style.BLACK}
            shown = {over(line.get_color(), ground, line.get_alpha()) for ground in behind}
            if not behind or min(contrast(a, b) for a in shown for b in behind) < LEAST_CONTRAST:
                yield line.get_label(), line.get_color(), behind
    for text in figure.findobj(Text):
        ground = strokes(text) or {to_hex(figure.get_facecolor())}
        if (
            text.get_text()
            and min(contrast(text.get_color(), colour) for colour in ground) < LEAST_CONTRAST
        ):
            yield text.get_text(), text.get_color(), ground


def strokes(artist):
    """Colours around an artist."""
    effects = [effect for effect in artist.get_path_effects() if isinstance(effect, withStroke)]
    return {to_hex(effect._gc["foreground"]) for effect in effects}


@pytest.mark.thinned(20)
@EACH
def test_colours_are_told_apart_by_all_readers(name):
    assert list(too_near(drawn(name))) == []


@pytest.mark.thinned(20)
@EACH
def test_colour_maps_are_in_order_of_lightness_for_all_readers(name):
    for panel in drawn(name).axes:
        for entry in maps(panel):
            if entry.get_cmap().N >= 20:
                colours = entry.get_cmap()(np.linspace(0, 1, 101))
                assert all(lightness_is_ordered(colours, vision) for vision in VISIONS)
                assert least_difference(colours[0], colours[-1]) > LEAST_APART


@pytest.mark.thinned(10)
@EACH
def test_words_and_curves_stand_out(name):
    assert list(faint(drawn(name))) == []


@pytest.mark.thinned(10)
@EACH
def test_figures_say_poisson_ratio_friction_and_units(name):
    words = "\n".join(text.get_text() for text in drawn(name).findobj(Text))
    assert [fact for fact, pattern in FACTS.items() if not re.search(pattern, words)] == []


DRAWING = ("compare", "slipfront", "docs/examples")


def test_the_catalogue_has_every_figure_of_the_package():
    root = Path(compare.__file__).parents[1]
    sources = [path for folder in DRAWING for path in (root / folder).rglob("*.py")]
    made = {
        f"{'.'.join(path.relative_to(root).with_suffix('').parts)}.{name}"
        for path in sources
        for name in re.findall(r"^@(?:style\.)?styled\ndef (\w+)", path.read_text(), re.M)
    }
    assert len(made) > 10
    assert made <= {name.partition("/")[0] for name in CATALOGUE}
    for path in sources:
        makes = re.search(r"new_figure\(|= Figure\(", path.read_text())
        assert not makes or re.search(
            r"@(style\.)?styled|@look\(\)|def new_figure", path.read_text()
        ), path


def two_lines(first, other, **look):
    figure = Figure()
    figure.subplots().plot([0, 1], [0, 1], color=first, **look)
    figure.axes[0].plot([0, 1], [1, 0], color=other)
    return figure


def test_red_and_green_are_found_unless_their_forms_differ():
    assert list(too_near(two_lines("#B03030", "#507000")))
    assert not list(too_near(two_lines("#B03030", "#507000", linestyle="--")))
    assert not list(too_near(two_lines(style.BLUE, style.VERMILLION)))


def test_rainbows_and_faint_curves_are_found():
    from matplotlib import colormaps

    rainbow = colormaps["hsv"](np.linspace(0, 1, 101))
    assert not any(lightness_is_ordered(rainbow, vision) for vision in VISIONS)
    assert len(list(faint(two_lines(style.BLACK, style.YELLOW)))) == 1
