"""Figure of growing waves: a map over contrast and friction, and pairs that are met."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from compare.figures.style import (
    BLACK,
    BLUE,
    BROWN,
    GREEN,
    PURPLE,
    SMALL,
    STICK_SHADE,
    VERMILLION,
    describe,
    new_figure,
    outline,
    styled,
)
from compare.studies.dissimilar.points import FRICTIONS, GrowthPoint, NamedPoint, ThresholdPoint

_LEAST, _MOST = 0.01, 100.0
"""Growth per wavelength [%] that colours and lines show."""
_COLOURS = (BLUE, VERMILLION, GREEN, PURPLE, BROWN)
_TICKS = (1, 1.2, 1.5, 2, 2.5, 3, 4)
_FRICTION_TICKS = (0.01, 0.03, 0.1, 0.3, 1)


@styled
def growth_figure(
    points: Sequence[GrowthPoint], curves: Sequence[ThresholdPoint], named: Sequence[NamedPoint]
) -> Figure:
    """Growth per wavelength over contrast and friction, and over friction for named pairs."""
    figure = new_figure(11, 5)
    describe(
        figure,
        "waves that grow while bodies slide: how much larger after running one wavelength "
        "(left: equal densities, ν = 1/4)",
    )
    left, right = figure.subplots(1, 2)
    _draw_map(figure, left, points)
    _draw_curves(left, curves)
    _draw_named(right, named)
    for panel in (left, right):
        panel.set_title("")
    return figure


def _draw_map(figure: Figure, panel: Axes, points: Sequence[GrowthPoint]) -> None:
    x = np.unique([point.contrast for point in points])
    y = np.unique([point.friction for point in points])
    growth = np.array([max(point.growth_with, point.growth_against) for point in points])
    grid = np.ma.masked_less_equal(growth.reshape(len(x), len(y)).T, 0.0)
    panel.set_facecolor(STICK_SHADE)
    mesh = panel.pcolormesh(
        x, y, grid, norm=LogNorm(_LEAST, _MOST), cmap="YlOrRd", shading="nearest", rasterized=True
    )
    bar = figure.colorbar(mesh, ax=panel, extend="both")
    bar.set_label("growth per wavelength [%]")
    panel.set(xscale="log", yscale="log", xlim=(x[0], x[-1]), ylim=FRICTIONS)
    panel.set(xlabel="$c_t$ of the faster body over the slower", ylabel="friction $f$")
    ticks = [tick for tick in _TICKS if x[0] <= tick <= x[-1]]
    panel.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    panel.set_xticks([], minor=True)
    panel.set_yticks(_FRICTION_TICKS, [f"{tick:g}" for tick in _FRICTION_TICKS])
    panel.text(0.42, 0.3, "no wave\ngrows", transform=panel.transAxes, ha="center", fontsize=SMALL)


def _draw_curves(panel: Axes, curves: Sequence[ThresholdPoint]) -> None:
    x = [one.contrast for one in curves]
    for values, style, label in (
        (
            [one.threshold_with for one in curves],
            "-",
            "$f_+$: waves with the slower body grow above",
        ),
        ([one.threshold_against for one in curves], "--", "$f_-$: waves against it grow above"),
    ):
        shown = np.where(np.array(values) > 0, values, np.nan)
        panel.plot(x, shown, style, color=BLACK, label=label, path_effects=outline())
    panel.legend(loc="lower left", fontsize=SMALL)


def _draw_named(panel: Axes, named: Sequence[NamedPoint]) -> None:
    parts = groupby(named, lambda point: point.pair)
    for colour, (pair, rows) in zip(_COLOURS, parts, strict=True):
        points = list(rows)
        friction = np.array([point.friction for point in points])
        growth = np.array([point.growth for point in points])
        ahead = np.array([point.velocity > 0 for point in points])
        for here, style in ((ahead, "-"), (~ahead, "--")):
            shown = np.where(here, growth, np.nan)
            label = pair if style == ("-" if ahead[-1] else "--") else None
            panel.plot(friction, shown, style, color=colour, label=label)
    panel.set(xscale="log", yscale="log", xlim=FRICTIONS, ylim=(_LEAST, _MOST))
    panel.set_xticks(_FRICTION_TICKS, [f"{tick:g}" for tick in _FRICTION_TICKS])
    panel.set(xlabel="friction $f$", ylabel="growth per wavelength [%]")
    panel.legend(loc="upper left", fontsize=SMALL, title="dashed: runs against the slower body")
