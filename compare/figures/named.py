"""Figures of an answer by name: those of slipfront, or of an installed package."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from compare.figures.histories import march_figure
from compare.figures.interface import prediction_figure
from semianalytic import Marched, Solution
from semianalytic.scene.checks import shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.plugins import FIGURES, Plugin, find_plugin, plugin_names

Draw = Callable[[Any], Figure]

DEFAULT_FIGURE = "interface"


def _interface(answer: Any) -> Figure:
    """Draw slip rate and tractions of an answer."""
    if isinstance(answer, Solution):
        return prediction_figure(answer)
    if isinstance(answer, Marched):
        return march_figure(answer)
    return np.ravel(answer.plot())[0].figure


OWN_FIGURES: Mapping[str, Draw] = {DEFAULT_FIGURE: _interface}


def find_figure(name: str) -> Draw:
    """Return the function of a name that draws an answer.

    Raises
    ------
    SceneError
        If there is no figure of this name.
    PluginError
        If the package that provides it is broken or not the only one; the returned function
        raises it too, if the package draws no figure.
    """
    if name in OWN_FIGURES:
        return OWN_FIGURES[name]
    plugin = find_plugin(FIGURES, name)
    if plugin is None:
        names = [*OWN_FIGURES, *plugin_names(FIGURES, OWN_FIGURES)]
        close = difflib.get_close_matches(name, names, n=1, cutoff=0.5)
        hint = f"did you mean {close[0]}?" if close else f"choose {', '.join(names)}."
        raise SceneError(f"There is no figure called {name!r}; {hint}")
    draw = plugin.load()
    if not callable(draw):
        raise plugin.error(f"must be a function of an answer, not {shown(draw)}")
    return _drawn_by(plugin, draw)


def _drawn_by(plugin: Plugin, draw: Callable[[Any], object]) -> Draw:
    def drawn(answer: Any) -> Figure:
        figure = plugin.guarded("cannot be drawn", lambda: draw(answer))
        if not isinstance(figure, Figure):
            raise plugin.error(f"must return a matplotlib Figure, not {shown(figure)}")
        return figure

    return drawn
