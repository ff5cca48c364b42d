"""Figures of slip regimes: maps with traced boundaries, front speeds, reverse slip."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import get_args

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import NDArray

from compare.comparison.scales import wave_speeds
from compare.figures.style import (
    BLACK,
    PREDICTION,
    PURPLE,
    REGIME_COLOURS,
    SIMULATION,
    VERMILLION,
    LineStyle,
    cycle,
    describe,
    ink,
    line_handle,
    mark_waves,
    new_figure,
    outline,
    shade,
    styled,
)
from compare.studies.regimes.points import (
    POISSON_RATIOS,
    REGIMES,
    BoundaryPoint,
    MapPoint,
    frictions,
    poisson_ratios,
    zone_speeds,
)
from semianalytic import Material
from semianalytic.reference import edge_speed_under_shear_step
from semianalytic.regimes import Loading, log_narrow_reverse_threshold, nucleation, stuck_threshold
from semianalytic.results.in_words import kind_of_slip

Array = NDArray[np.float64]

CURVES: dict[str, tuple[str, LineStyle, str]] = {
    "edge": ("edge sticks above", "-", BLACK),
    "nucleation": ("slip at the shear front below", "--", PURPLE),
    "gap": ("stick gap at $c_R$ under 1e-14 below", "-.", BLACK),
    "everywhere": ("slip everywhere below", ":", BLACK),
    "reverse": ("reverse slip below", "-", VERMILLION),
}
FRICTION = {
    "preload": r"a step of shear $Q_0$ on base pressure $P_b$,  $f = \chi_b\,Q_0/P_b$",
    "remote": r"sudden remote pressure $P_0$ and shear $Q_0$,  $f = \chi\,Q_0/P_0$",
}
"""Description of each loading, and friction in its units."""
CHI = {"preload": r"$\chi_b = f P_b/Q_0$", "remote": r"$\chi = f P_0/Q_0$"}
PUBLISHED_THRESHOLD = (1 / 3, 0.0575)


@dataclass(frozen=True)
class RegimeResults:
    """Sorted points and curves that the figures and tables of regimes show."""

    points: dict[Loading, list[MapPoint]]
    curves: list[BoundaryPoint]
    fronts: list[MapPoint]
    reverse: list[MapPoint]


@styled
def regimes_figure(loading: Loading, results: RegimeResults) -> Figure:
    """Draw the map of one loading; if remote, also over the share of the way to full stick."""
    points, curves = results.points[loading], _by_curve(results, loading)
    if loading == "preload":
        figure = new_figure(7, 5.6)
        panels = [figure.subplots()]
        panels[0].set(yscale="log", ylim=(1e-3, 1))
    else:
        figure = new_figure(11, 5.8)
        panels = list(figure.subplots(1, 2))
        panels[0].set_facecolor(REGIME_COLOURS["stuck"])
        panels[0].axhspan(0, 1, color=REGIME_COLOURS["everywhere"], linewidth=0, zorder=0)
        panels[0].set_ylim(0.97, 1.85)
        panels[1].set_ylim(-0.09, 1.09)
    describe(figure, FRICTION[loading])
    share_label = r"$(\chi - 1)/(\chi_\mathrm{stuck}(\nu) - 1)$"
    for panel, share in zip(panels, (False, True), strict=False):
        _draw_map(panel, loading, points, share)
        for name, (label, style, colour) in CURVES.items():
            if name in curves:
                nu, chi = curves[name][:, 0], 10 ** curves[name][:, 1]
                height = _share(nu, chi) if share else chi
                panel.plot(nu, height, style, color=colour, label=label, path_effects=outline())
        panel.set(xlabel=r"Poisson ratio $\nu$", ylabel=share_label if share else CHI[loading])
        panel.set_xlim(*POISSON_RATIOS)
    present = [name for name in REGIMES if any(p.regime == name for p in points)]
    patches = [Patch(color=REGIME_COLOURS[name], label=REGIMES[name]) for name in present]
    _legend_below(figure, [*patches, *panels[0].get_lines()], 3)
    return figure


def _legend_below(figure: Figure, handles: Sequence[Artist], columns: int) -> None:
    """Put a legend below the panels, in so many columns or as many as the figure is wide."""
    for count in range(columns, 0, -1):
        legend = figure.legend(
            handles=handles, loc="outside lower center", ncols=count, frameon=False
        )
        if count == 1 or legend.get_window_extent().width <= figure.bbox.width:
            return
        legend.remove()


def _by_curve(results: RegimeResults, loading: Loading) -> dict[str, Array]:
    """Return Poisson ratio and log10 of chi (n, 2) of the traced curves of a loading."""
    points = [p for p in results.curves if p.loading == loading]
    return {
        name: np.array([(p.poisson_ratio, p.log10_chi) for p in group])
        for name, group in groupby(points, key=lambda p: p.curve)
    }


def _share(nu: Array, chi: Array) -> Array:
    """Return the share of the way from slip everywhere (0) to full stick (1)."""
    return (chi - 1) / (np.array([stuck_threshold(float(value)) for value in nu]) - 1)


def _draw_map(panel: Axes, loading: Loading, points: Sequence[MapPoint], share: bool) -> None:
    names = list(REGIMES)
    count = math.isqrt(len(points))
    index = np.array([names.index(p.regime) for p in points]).reshape(count, count)
    nu = poisson_ratios(count, corners=True)
    chi = np.array([frictions(loading, float(value), count, corners=True) for value in nu])
    if share:
        chi = _share(nu, chi.T).T
    panel.pcolormesh(
        np.broadcast_to(nu[:, None], chi.shape),
        chi,
        index,
        cmap=ListedColormap([REGIME_COLOURS[name] for name in names]),
        norm=BoundaryNorm(np.arange(len(names) + 1) - 0.5, len(names)),
        rasterized=True,
    )


@styled
def front_speeds_figure(results: RegimeResults) -> Figure:
    """Draw the speeds of all zone edges against friction, by loading (row) and Poisson ratio."""
    loadings: list[Loading] = [
        one for one in get_args(Loading) if any(p.loading == one for p in results.fronts)
    ]
    ratios = sorted({p.poisson_ratio for p in results.fronts})
    figure = new_figure(3.7 * len(ratios), 3.3 * len(loadings) + 0.4)
    describe(figure, ";  ".join(FRICTION[one] for one in loadings))
    panels = figure.subplots(len(loadings), len(ratios), squeeze=False)
    for row, loading in zip(panels, loadings, strict=True):
        for panel, nu in zip(row, ratios, strict=True):
            points = [p for p in results.fronts if (p.loading, p.poisson_ratio) == (loading, nu)]
            _draw_fronts(panel, loading, nu, points)
        row[0].set_ylabel(r"speed of zone edges $/\ c_t$")
    handles = [
        Patch(color=shade("slip"), label="slips"),
        Patch(color=shade("reverse slip"), label="slips backward"),
        line_handle("edges of slip zones", PREDICTION),
        line_handle(r"one slow zone: $1/((1-\nu)(1+\chi_b)^2)$", SIMULATION, "--"),
        line_handle(r"waves $c_R$, $c_t$, $c_l$", ink(0.65), "--"),
    ]
    _legend_below(figure, handles, 5)
    return figure


def _draw_fronts(panel: Axes, loading: str, nu: float, points: Sequence[MapPoint]) -> None:
    material = Material(1.0, 1.0, nu)
    top = 1.06 * material.longitudinal_speed
    mark_waves(panel, wave_speeds(material), material.shear_speed, "horizontal")
    borders = _borders([p.chi for p in points], loading == "preload")
    for count, group in groupby(_solved(points), key=_senses):
        part = list(group)
        chi = np.array([p.chi for p in part])
        zones = np.minimum(np.array([zone_speeds(p) for p in part]).reshape(len(part), -1, 3), top)
        for index, sense in enumerate(count):
            inner, outer = zones[:, index, 0], zones[:, index, 1]
            colour = shade(kind_of_slip(sense))
            _shade(panel, [borders[x] for x in chi], inner, outer, colour)
            for edge in (inner, outer):
                panel.plot(chi, np.where((edge > 0) & (edge < top), edge, np.nan), color=PREDICTION)
    chi = np.array([p.chi for p in points])
    if loading == "preload":
        dense = np.geomspace(nucleation("preload", nu), chi.max(), 200)
        speeds = [edge_speed_under_shear_step(material, x) for x in dense]
        panel.plot(dense, speeds, "--", color=SIMULATION)
        panel.set_xscale("log")
    panel.set(xlim=(chi.min(), chi.max()), ylim=(0, top), title=rf"$\nu = {nu:.3g}$")
    panel.set_xlabel(CHI[loading])


def _borders(chi: Sequence[float], logarithmic: bool) -> dict[float, tuple[float, float]]:
    """Return the midpoints between neighbouring frictions as limits of shades without gaps."""
    scaled = np.log(chi) if logarithmic else np.array(chi)
    middles = (scaled[1:] + scaled[:-1]) / 2
    ends = np.concatenate([scaled[:1], middles, scaled[-1:]])
    ends = np.exp(ends) if logarithmic else ends
    return {x: (float(ends[i]), float(ends[i + 1])) for i, x in enumerate(chi)}


def _shade(
    panel: Axes, borders: Sequence[tuple[float, float]], inner: Array, outer: Array, colour: str
) -> None:
    edges = np.array(borders)
    panel.bar(
        edges[:, 0],
        outer - inner,
        edges[:, 1] - edges[:, 0],
        inner,
        align="edge",
        color=colour,
        linewidth=0,
        antialiased=False,
    )


def _solved(points: Iterable[MapPoint]) -> list[MapPoint]:
    return [p for p in points if p.regime != "failed"]


def _senses(point: MapPoint) -> tuple[int, ...]:
    return tuple(sense for _, _, sense in zone_speeds(point))


@styled
def reverse_figure(results: RegimeResults) -> Figure:
    """Draw threshold and width of reverse slip over nu, and the width against friction."""
    figure = describe(new_figure(11, 4.8), FRICTION["preload"])
    left, right = figure.subplots(1, 2)
    curves = _by_curve(results, "preload")
    threshold, width = curves["reverse"], curves["reverse-width"]
    left.plot(threshold[:, 0], threshold[:, 1], color=SIMULATION, label="friction threshold")
    narrow = threshold[:, 0] >= -0.3
    left.plot(
        threshold[narrow, 0],
        [log_narrow_reverse_threshold(nu) / math.log(10) for nu in threshold[narrow, 0]],
        ":",
        color=ink(),
        label="the same, narrow strip",
    )
    left.plot(
        width[:, 0], width[:, 1], "--", color=PREDICTION, label="half-width $/c_R$, no friction"
    )
    nu, published = PUBLISHED_THRESHOLD
    left.plot(nu, math.log10(published), "x", color=ink(), label="published threshold")
    left.set(
        xlabel=r"Poisson ratio $\nu$",
        ylabel=r"$\log_{10}$ of $\chi_b$, of half-width",
        xlim=(threshold[0, 0], threshold[-1, 0]),
    )
    left.legend(loc="lower left")
    groups = groupby(_solved(results.reverse), key=lambda p: p.poisson_ratio)
    for (ratio, group), colour in zip(groups, cycle(), strict=False):
        points = list(group)
        speed = Material(1.0, 1.0, ratio).rayleigh_speed
        share = [
            sum(outer - inner for inner, outer, sense in zone_speeds(p) if sense < 0) / (2 * speed)
            for p in points
        ]
        right.semilogx(
            [p.chi for p in points], share, ".-", color=colour, label=rf"$\nu = {ratio:g}$"
        )
    right.set(xlabel=CHI["preload"], ylabel="half-width of the reversed strip $/c_R$")
    right.set_ylim(bottom=0)
    right.legend()
    return figure
