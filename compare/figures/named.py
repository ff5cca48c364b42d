"""Figures of an answer by name: those of slipfront, or of an installed package."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from matplotlib.figure import Figure

from compare.figures import style
from semianalytic.results.plotting import scene_title
from semianalytic.scene.checks import meant, shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.plugins import FIGURES, find_plugin, plugin_names

Draw = Callable[[Any], Figure]

DEFAULT_FIGURE = "interface"


@style.styled
def answer_figure(answer: Any, t: float | None = None) -> Figure:
    """Draw what `plot` draws of an answer, at a time if that is given, in our style."""
    figure = style.new_figure(7, 4.7)
    mapped = t is None and getattr(answer, "interface", None) is not None
    panels = figure.subplots(1 if mapped else 2, sharex=True)
    answer.plot(ax=panels, t=t)
    for line in panels.lines if mapped else ():
        line.set_path_effects(style.outline())
    return style.describe(figure, scene_title(answer.scene))


def find_figure(name: str) -> Draw:
    """Return the function of a name that draws an answer; SceneError if there is none.

    Where a package that provides it is broken, or draws no figure, a PluginError is raised, also by
    the function.
    """
    if name == DEFAULT_FIGURE:
        return answer_figure
    plugin = find_plugin(FIGURES, name)
    if plugin is None:
        names = [DEFAULT_FIGURE, *plugin_names(FIGURES, (DEFAULT_FIGURE,))]
        hint = meant(name, names, f"choose {', '.join(names)}.", 0.5)
        raise SceneError(f"There is no figure called {name!r}; {hint}")
    draw = plugin.load()
    if not callable(draw):
        raise plugin.error(f"must be a function of an answer, not {shown(draw)}")

    def drawn(answer: Any) -> Figure:
        figure = plugin.guarded("cannot be drawn", lambda: draw(answer))
        if not isinstance(figure, Figure):
            raise plugin.error(f"must return a matplotlib Figure, not {shown(figure)}")
        return figure

    return drawn
