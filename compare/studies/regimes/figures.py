"""Figures of slip regimes: maps with traced boundaries, front speeds, reverse slip."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from compare.comparison.scales import wave_speeds
from compare.figures.saving import save_figure
from compare.figures.style import PREDICTION, SIMULATION, SYMBOLS
from compare.studies.regimes.points import (
    POISSON_RATIOS,
    REGIMES,
    BoundaryPoint,
    MapPoint,
    closed_form_speed,
    frictions,
    poisson_ratios,
    stuck_above,
    zone_speeds,
)
from semianalytic import Material
from semianalytic.regimes.reverse_slip import log_narrow_reverse_threshold
from semianalytic.regimes.thresholds import Loading, nucleation

Array = NDArray[np.float64]

COLOURS = {
    "stuck": "#efefef",
    "slow": "#cfe3f4",
    "front": "#fbe6a2",
    "two": "#8fbbe0",
    "one": "#4f87bd",
    "everywhere": "#9fd3b0",
    "reverse": "#f3b49f",
    "failed": "#000000",
}
CURVES = {
    "edge": ("edge sticks above", "-", "#12355b"),
    "nucleation": ("slip at the shear front below", "--", "#7a1f5c"),
    "gap": ("stick gap at $c_R$ under 1e-14 below", "-.", "#1c1c1c"),
    "everywhere": ("slip everywhere below", ":", "#1d6b3a"),
    "reverse": ("reverse slip below", "-", "#c0392b"),
}
CHI = {"preload": r"$\chi_b = f P_b/Q_0$", "remote": r"$\chi = f P_0/Q_0$"}
PUBLISHED_THRESHOLD = (1 / 3, 0.0575)


@dataclass(frozen=True)
class RegimeResults:
    """Everything the figures and tables of regimes show, sorted."""

    points: dict[Loading, list[MapPoint]]
    curves: list[BoundaryPoint]
    fronts: list[MapPoint]
    reverse: list[MapPoint]


def save_regimes(path: Path, loading: Loading, results: RegimeResults) -> None:
    """Map of one loading; a remote one also over the share of the way to full stick."""
    points = results.points[loading]
    curves = {
        name: np.array([(p.poisson_ratio, 10**p.log10_chi) for p in group])
        for name, group in groupby(
            (p for p in results.curves if p.loading == loading), key=lambda p: p.curve
        )
        if name in CURVES
    }
    if loading == "preload":
        figure = Figure(figsize=(7, 5.6), layout="constrained")
        panels = [figure.subplots()]
    else:
        figure = Figure(figsize=(11, 5.8), layout="constrained")
        panels = list(figure.subplots(1, 2))
    for panel, share in zip(panels, (False, True), strict=False):
        _draw_map(panel, loading, points, share)
        for name, curve in curves.items():
            label, style, colour = CURVES[name]
            height = _share(curve) if share else curve[:, 1]
            panel.plot(curve[:, 0], height, style, color=colour, label=label)
        panel.set(xlabel=r"Poisson ratio $\nu$", ylabel=CHI[loading])
    for panel in panels:
        panel.set_xlim(*POISSON_RATIOS)
    if loading == "preload":
        panels[0].set(yscale="log", ylim=(1e-3, 1))
    else:
        panels[0].set_facecolor(COLOURS["stuck"])
        panels[0].axhspan(0, 1, color=COLOURS["everywhere"], linewidth=0, zorder=0)
        panels[0].set_ylim(0.97, 1.85)
        panels[1].set(ylabel=r"$(\chi - 1)/(\chi_\mathrm{stuck}(\nu) - 1)$", ylim=(-0.09, 1.09))
    present = [name for name in REGIMES if any(p.regime == name for p in points)]
    patches = [Patch(color=COLOURS[name], label=REGIMES[name]) for name in present]
    handles = [*patches, *panels[0].get_lines()]
    figure.legend(handles=handles, loc="outside lower center", ncols=3, fontsize=8, frameon=False)
    save_figure(figure, path)


def _share(curve: Array) -> Array:
    return np.array([(chi - 1) / (stuck_above(nu) - 1) for nu, chi in curve])


def _draw_map(panel: Axes, loading: Loading, points: Sequence[MapPoint], share: bool) -> None:
    names = list(REGIMES)
    count = math.isqrt(len(points))
    index = np.array([names.index(p.regime) for p in points]).reshape(count, count)
    nu = poisson_ratios(count, corners=True)
    chi = np.array([frictions(loading, float(value), count, corners=True) for value in nu])
    if share:
        chi = (chi - 1) / (np.array([stuck_above(float(value)) for value in nu]) - 1)[:, None]
    panel.pcolormesh(
        np.broadcast_to(nu[:, None], chi.shape),
        chi,
        index,
        cmap=ListedColormap([COLOURS[name] for name in names]),
        norm=BoundaryNorm(np.arange(len(names) + 1) - 0.5, len(names)),
        rasterized=True,
    )


def save_fronts(path: Path, results: RegimeResults) -> None:
    """Speeds of all zone edges against friction, a row per loading, a column per Poisson ratio."""
    loadings = sorted({p.loading for p in results.fronts})
    ratios = sorted({p.poisson_ratio for p in results.fronts})
    figure = Figure(figsize=(3.7 * len(ratios), 3.3 * len(loadings) + 0.4), layout="constrained")
    panels = figure.subplots(len(loadings), len(ratios), squeeze=False, sharex=False)
    for row, loading in zip(panels, loadings, strict=True):
        for panel, nu in zip(row, ratios, strict=True):
            points = [p for p in results.fronts if (p.loading, p.poisson_ratio) == (loading, nu)]
            _draw_fronts(panel, loading, nu, points)
        row[0].set_ylabel(r"speed of zone edges $/\ c_t$")
    handles = [
        Patch(color=COLOURS["two"], label="slips"),
        Patch(color=COLOURS["reverse"], label="slips backward"),
        Line2D([], [], color=PREDICTION, label="edges of slip zones"),
        Line2D([], [], color=SIMULATION, linestyle="--", label=r"$1/((1-\nu)(1+\chi_b)^2)$"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=4, fontsize=8, frameon=False)
    save_figure(figure, path)


def _draw_fronts(panel: Axes, loading: str, nu: float, points: Sequence[MapPoint]) -> None:
    waves = wave_speeds(Material(1.0, 1.0, nu))
    top = 1.06 * waves["P"]
    for name, speed in waves.items():
        panel.axhline(speed, color="0.35", linestyle="--", linewidth=0.7)
        panel.annotate(
            SYMBOLS[name],
            (1, speed),
            (3, 0),
            xycoords=("axes fraction", "data"),
            textcoords="offset points",
            va="top" if name == "Rayleigh" else "bottom",
            fontsize=8,
        )
    borders = _borders([p.chi for p in points], loading == "preload")
    for count, group in groupby(_solved(points), key=_senses):
        part = list(group)
        chi = np.array([p.chi for p in part])
        zones = np.minimum(np.array([zone_speeds(p) for p in part]).reshape(len(part), -1, 3), top)
        for index, sense in enumerate(count):
            inner, outer = zones[:, index, 0], zones[:, index, 1]
            colour = COLOURS["two" if sense > 0 else "reverse"]
            _shade(panel, [borders[x] for x in chi], inner, outer, colour)
            for edge in (inner, outer):
                panel.plot(chi, np.where((edge > 0) & (edge < top), edge, np.nan), color=PREDICTION)
    chi = np.array([p.chi for p in points])
    if loading == "preload":
        dense = np.geomspace(nucleation("preload", nu), chi.max(), 200)
        panel.plot(dense, [closed_form_speed(nu, x) for x in dense], "--", color=SIMULATION)
        panel.set_xscale("log")
    panel.set(xlim=(chi.min(), chi.max()), ylim=(0, top), title=rf"$\nu = {nu:.3g}$")
    panel.set_xlabel(CHI[loading])


def _borders(chi: Sequence[float], logarithmic: bool) -> dict[float, tuple[float, float]]:
    """Halfway to the neighbours of each friction, so that shades meet."""
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


def save_reverse(path: Path, results: RegimeResults) -> None:
    """Threshold and width of reverse slip over nu, and how the width closes with friction."""
    figure = Figure(figsize=(11, 4.6), layout="constrained")
    left, right = figure.subplots(1, 2)
    curves = {
        name: np.array([(p.poisson_ratio, p.log10_chi) for p in group])
        for name, group in groupby(
            (p for p in results.curves if p.loading == "preload"), key=lambda p: p.curve
        )
    }
    threshold, width = curves["reverse"], curves["reverse-width"]
    left.plot(threshold[:, 0], threshold[:, 1], color=SIMULATION, label="friction threshold")
    narrow = threshold[:, 0] >= -0.3
    left.plot(
        threshold[narrow, 0],
        [log_narrow_reverse_threshold(nu) / math.log(10) for nu in threshold[narrow, 0]],
        ":",
        color="black",
        label="the same, narrow strip",
    )
    left.plot(
        width[:, 0], width[:, 1], "--", color=PREDICTION, label="half-width $/c_R$, no friction"
    )
    nu, published = PUBLISHED_THRESHOLD
    left.plot(nu, math.log10(published), "x", color="black", label="published threshold")
    left.set(
        xlabel=r"Poisson ratio $\nu$",
        ylabel=r"$\log_{10}$ of $\chi_b$, of half-width",
        xlim=(threshold[0, 0], threshold[-1, 0]),
    )
    left.legend(fontsize=8, loc="lower left")
    for ratio, group in groupby(_solved(results.reverse), key=lambda p: p.poisson_ratio):
        points = list(group)
        speed = Material(1.0, 1.0, ratio).rayleigh_speed
        share = [
            sum(outer - inner for inner, outer, sense in zone_speeds(p) if sense < 0) / (2 * speed)
            for p in points
        ]
        right.semilogx([p.chi for p in points], share, ".-", label=rf"$\nu = {ratio:g}$")
    right.set(xlabel=CHI["preload"], ylabel="half-width of the reversed strip $/c_R$")
    right.set_ylim(bottom=0)
    right.legend(fontsize=8)
    save_figure(figure, path)
