"""Figures of regimes: maps with traced curves, speeds of zones, openings, viscous films."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from compare.comparison.scales import wave_speeds
from compare.figures import style
from docs.studies.runner import Row, draw
from semianalytic import Material, regimes
from semianalytic.reference import edge_speed_under_shear_step
from semianalytic.regimes import Loading
from semianalytic.results.in_words import kind_of_slip

POISSON_RATIOS = (-0.9, 0.49)
AHEAD, EDGE = 1, -1
"""Signs of a step of pressure P_0: the contact opens ahead of the edge, or from the edge."""
OPENING_DECADES = (-3.0, 0.5)
"""Logarithms to base 10 of the smallest and the largest P_b / |P_0|."""
VISCOUS_RATIO, VISCOUS_DECADES, VISCOUS_FRICTION = 1 / 3, (-6.0, 2.0), 0.4
"""Poisson ratio, viscosities and largest friction of the map over viscosity."""

REGIMES = {
    "stuck": "fully stuck",
    "slow": "slip slower than the Rayleigh wave",
    "front": "slip at the shear wave, edge stuck",
    "two": "second zone ahead, stick gap at $c_R$",
    "one": "one zone past $c_R$ (gap < 1e-14)",
    "everywhere": "slip everywhere",
    "reverse": "reverse slip present",
    "failed": "not solved",
}
CURVES = {
    "edge": ("edge sticks above", "-", style.BLACK),
    "nucleation": ("slip at the shear front below", "--", style.PURPLE),
    "gap": ("stick gap at $c_R$ under 1e-14 below", "-.", style.BLACK),
    "everywhere": ("slip everywhere below", ":", style.BLACK),
    "reverse": ("reverse slip below", "-", style.VERMILLION),
}
FRICTION = {
    "preload": r"a step of shear $Q_0$ on base pressure $P_b$,  $f = \chi_b\,Q_0/P_b$",
    "remote": r"sudden remote pressure $P_0$ and shear $Q_0$,  $f = \chi\,Q_0/P_0$",
}
"""Description of each loading, and friction in its units."""
CHI = {"preload": r"$\chi_b = f P_b/Q_0$", "remote": r"$\chi = f P_0/Q_0$"}
NU = r"Poisson ratio $\nu$"


def chosen(rows: Sequence[Row], **values: Any) -> list[Row]:
    """Return the rows with some values in some columns."""
    return [row for row in rows if all(row.get(name) == value for name, value in values.items())]


def columns(rows: Sequence[Row], *names: str) -> list[Any]:
    """Return columns as arrays; None becomes nan."""
    return [np.array([row[name] for row in rows], dtype=float) for name in names]


def _share(chi: float, poisson_ratio: float) -> float:
    """Return the share of the way from slip everywhere (0) to full stick (1)."""
    return (chi - 1) / (regimes.stuck_threshold(poisson_ratio) - 1)


def _legend_below(figure: Figure, handles: Sequence[Artist], count: int = 3) -> None:
    figure.legend(handles=handles, loc="outside lower center", ncols=count, frameon=False)


@style.styled
def regimes_figure(rows: list[Row], loading: Loading) -> Figure:
    """Draw the map of one loading; if remote, also over the share of the way to full stick."""
    points = chosen(rows, part="map", loading=loading)
    traced = chosen(rows, part="curves", loading=loading)
    remote = loading == "remote"
    figure = style.describe(style.new_figure(11 if remote else 7, 5.8), FRICTION[loading])
    panels: Any = figure.subplots(1, 2 if remote else 1, squeeze=False)[0]
    for panel, share in zip(panels, (False, True), strict=False):
        place: Callable[[float, float], float] = _share if share else lambda chi, _: chi
        seen = [row | {"y": place(row["chi"], row["poisson_ratio"])} for row in points]
        draw(panel, seen, "poisson_ratio", "y", value="regime", colours=style.REGIME_COLOURS)
        for name, (label, dashes, colour) in CURVES.items():
            line = [row for row in traced if row.get(name) is not None]
            height = [place(10 ** row[name], row["poisson_ratio"]) for row in line]
            if line:
                look: dict[str, Any] = {"color": colour, "path_effects": style.outline()}
                panel.plot(*columns(line, "poisson_ratio"), height, dashes, label=label, **look)
        panel.set(xlabel=NU, ylabel=CHI[loading], xlim=POISSON_RATIOS)
    if remote:
        panels[0].set_facecolor(style.REGIME_COLOURS["stuck"])
        panels[0].axhspan(0, 1, color=style.REGIME_COLOURS["everywhere"], linewidth=0, zorder=0)
        panels[0].set_ylim(0.97, 1.85)
        label = r"$(\chi - 1)/(\chi_\mathrm{stuck}(\nu) - 1)$"
        panels[1].set(ylim=(-0.09, 1.09), ylabel=label)
    else:
        panels[0].set(yscale="log", ylim=(1e-3, 1))
    present = [name for name in REGIMES if chosen(points, regime=name)]
    patches = [Patch(color=style.REGIME_COLOURS[name], label=REGIMES[name]) for name in present]
    _legend_below(figure, [*patches, *panels[0].get_lines()], 3 if remote else 2)
    return figure


@style.styled
def front_speeds_figure(rows: list[Row]) -> Figure:
    """Draw the speeds of all zone edges against friction, by loading (row) and Poisson ratio."""
    shown = chosen(rows, part="fronts")
    ratios = sorted({row["poisson_ratio"] for row in shown})
    figure = style.describe(style.new_figure(3.7 * len(ratios), 7.0), ";  ".join(FRICTION.values()))
    grid = figure.subplots(2, len(ratios), squeeze=False)
    for loading, panels in zip(FRICTION, grid, strict=True):
        for nu, panel in zip(ratios, panels, strict=True):
            material = Material(1.0, 1.0, nu)
            top = 1.06 * material.longitudinal_speed
            style.mark_waves(panel, wave_speeds(material), material.shear_speed, "horizontal")
            points = chosen(shown, loading=loading, poisson_ratio=nu)
            for row in points:
                for inner, outer, sense in row["zones"]:
                    colour, ends = style.shade(kind_of_slip(sense)), np.minimum((inner, outer), top)
                    panel.vlines(row["chi"], *ends, color=colour, linewidth=2.2, zorder=0)
                    edges = [end for end in (inner, outer) if 0 < end < top]
                    panel.plot([row["chi"]] * len(edges), edges, ".", color=style.PREDICTION, ms=2)
            (chi,) = columns(points, "chi")
            if loading == "preload":
                dense = np.geomspace(regimes.nucleation("preload", nu), chi.max(), 200)
                speeds = [edge_speed_under_shear_step(material, x) for x in dense]
                panel.plot(dense, speeds, "--", color=style.SIMULATION)
                panel.set_xscale("log")
            panel.set(xlim=(chi.min(), chi.max()), ylim=(0, top), xlabel=CHI[loading])
            panel.set_title(rf"$\nu = {nu:.3g}$")
        panels[0].set_ylabel(r"speed of zone edges $/\ c_t$")
    handles = [
        Patch(color=style.shade("slip"), label="slips"),
        Patch(color=style.shade("reverse slip"), label="slips backward"),
        style.line_handle("edges of slip zones", style.PREDICTION),
        style.line_handle(r"one slow zone: $1/((1-\nu)(1+\chi_b)^2)$", style.SIMULATION, "--"),
        style.line_handle(r"waves $c_R$, $c_t$, $c_l$", style.ink(0.65), "--"),
    ]
    _legend_below(figure, handles, 5)
    return figure


@style.styled
def openings_figure(rows: list[Row]) -> Figure:
    """Draw a map of the opening by a sudden pressure, and the speeds of its ends for both signs."""
    speeds = chosen(rows, part="speeds")
    ratios = sorted({row["poisson_ratio"] for row in speeds})
    words = "a step of pressure $P_0$ on base pressure $P_b$;  the same for any friction $f$"
    figure = style.describe(style.new_figure(4.4 + 2.7 * len(ratios), 4.6), words)
    first, *rest = figure.subplots(1, 1 + len(ratios), width_ratios=[1.6, *[1] * len(ratios)])
    shares = []
    for row in chosen(rows, part="map"):
        way = Material(1.0, 1.0, row["poisson_ratio"]).longitudinal_speed
        shares.append(row | {"share": (row["outer"] - row["inner"]) / way or math.nan})
    first.set_facecolor(style.STICK_SHADE)
    shading = {"cmap": "YlOrBr", "vmin": 0, "vmax": 1}
    label = "open part of the way to the P front"
    draw(first, shares, "poisson_ratio", "ratio", value="share", label=label, style=shading)
    nu = np.linspace(*POISSON_RATIOS, 300)
    threshold = [regimes.opening_threshold(float(value)) for value in nu]
    first.plot(nu, threshold, color=style.PREDICTION, path_effects=style.outline())
    ends = tuple(10.0**end for end in OPENING_DECADES)
    first.set(xlabel=NU, ylabel=r"$P_b/P_0$", yscale="log", xlim=POISSON_RATIOS, ylim=ends)
    for panel, nu_here in zip(rest, ratios, strict=True):
        material = Material(1.0, 1.0, nu_here)
        own = chosen(speeds, poisson_ratio=nu_here)
        ratio, inner, outer = columns(chosen(own, sign=AHEAD), "ratio", "inner", "outer")
        panel.fill_between(ratio, inner, outer, color=style.shade("open"), linewidth=0)
        panel.plot(ratio, inner, ratio, outer, color=style.PREDICTION)
        edge = columns(chosen(own, sign=-AHEAD), "ratio", "outer")
        panel.plot(*edge, "-.", color=style.SIMULATION)
        panel.set(xscale="log", xlim=ends, ylim=(0, 1.06 * material.longitudinal_speed))
        panel.set(xlabel=r"$P_b/|P_0|$", title=rf"$\nu = {nu_here:.3g}$")
        style.mark_waves(panel, wave_speeds(material), 1.0, "horizontal")
    rest[0].set_ylabel(r"speed of the ends of the opening $/\ c_t$")
    handles = [
        Patch(color=style.STICK_SHADE, label="stays closed"),
        style.line_handle(r"opens ahead below $P_b/P_0 = -p^*(c)$", style.PREDICTION),
        Patch(color=style.shade("open"), label=r"open under a sudden pressure, $P_0 > 0$"),
        style.line_handle(
            r"open up to, pressure put on the slot, $P_0 < 0$", style.SIMULATION, "-."
        ),
        style.line_handle(r"waves $c_R$, $c_t$, $c_l$", style.ink(0.65), "--"),
    ]
    _legend_below(figure, handles)
    return figure


@style.styled
def viscosity_figure(rows: list[Row]) -> Figure:
    """Draw the map with its thresholds, and where the gap closes at several Poisson ratios."""
    figure = style.describe(style.new_figure(11, 5.0), FRICTION["preload"])
    left, right = figure.subplots(1, 2)
    points, curves = chosen(rows, part="map"), chosen(rows, part="curves")
    draw(left, points, "viscosity", "chi", value="regime", colours=style.REGIME_COLOURS)
    names = "viscosity", "nucleation", "closing"
    x, nucleating, closing = columns(chosen(curves, poisson_ratio=VISCOUS_RATIO), *names)
    left.plot(x, nucleating, "--", color=style.PURPLE, path_effects=style.outline())
    left.plot(x, closing, "-", color=style.BLACK, path_effects=style.outline())
    labels = {name: REGIMES[name] for name in ("slow", "two", "one", "failed")}
    labels["one"] = "one zone across $c_R$"
    present = [name for name in labels if chosen(points, regime=name)]
    patches = [Patch(color=style.REGIME_COLOURS[name], label=labels[name]) for name in present]
    left.legend(handles=patches, loc="upper right")
    left.set_title(rf"$\nu = {VISCOUS_RATIO:.3g}$")
    for nu, colour in zip(
        dict.fromkeys(row["poisson_ratio"] for row in curves), style.cycle(), strict=False
    ):
        x, closing = columns(chosen(curves, poisson_ratio=nu), "viscosity", "closing")
        right.plot(x, closing, color=colour, label=rf"$\nu = {nu:.3g}$")
        right.axhline(regimes.closing_limit(nu), linestyle=":", color=colour, linewidth=1)
    right.set_title("slip covers $c_R$ below; dotted: $q^*(c)$")
    right.legend()
    for panel in (left, right):
        panel.set(
            xscale="log", xlim=[10**end for end in VISCOUS_DECADES], ylim=(0, VISCOUS_FRICTION)
        )
        panel.set(xlabel=r"viscosity $/\ (\rho c_t / 2)$", ylabel=CHI["preload"])
    return figure


MAPS: dict[str, Callable[[list[Row]], Figure]] = {
    "regimes_preload": partial(regimes_figure, loading="preload"),
    "regimes_remote": partial(regimes_figure, loading="remote"),
    "front_speeds": front_speeds_figure,
}
