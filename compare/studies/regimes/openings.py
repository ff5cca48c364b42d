"""Openings of the contact under a step of pressure, over base pressure and Poisson ratio.

Pressure on the slot faces, P_0 < 0, opens the contact from its edge whatever the base.  A sudden
pressure P_0 > 0 opens it ahead, around the Rayleigh front, if the base P_b is below the
`opening_threshold` of the step.  Openings depend on neither shear nor friction.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import NDArray

from compare.comparison.scales import wave_speeds
from compare.figures.style import (
    PREDICTION,
    SIMULATION,
    STICK_SHADE,
    describe,
    ink,
    line_handle,
    mark_waves,
    new_figure,
    outline,
    shade,
    styled,
)
from compare.studies.regimes.points import POISSON_RATIOS, poisson_ratios
from semianalytic import Material, Scene, Tractions, solve
from semianalytic.regimes import opening_threshold

RATIOS = (-3.0, 0.5)
"""Logarithms to base 10 of the smallest and the largest P_b / |P_0|."""
RTOL = 1e-8
AHEAD, EDGE = 1, -1
"""Signs of P_0: the contact opens ahead of the edge, or from the edge."""


@dataclass(frozen=True)
class OpeningPoint:
    """Opening under a step of pressure alone.

    Attributes
    ----------
    poisson_ratio : float
        Poisson ratio of the material.
    sign : int
        Sign of P_0.
    ratio : float
        Base pressure over step, P_b / |P_0|.
    inner, outer : float
        Ends of the opening over c_t; 0 if the contact stays closed.
    """

    poisson_ratio: float
    sign: int
    ratio: float
    inner: float
    outer: float


def opening_point(poisson_ratio: float, sign: int, ratio: float) -> OpeningPoint:
    """Solve for the opening under a unit step of pressure of a sign, with a base P_b / |P_0|."""
    scene = Scene(
        Material(1.0, 1.0, poisson_ratio), 0.0, Tractions(ratio, 0.0), Tractions(float(sign), 0.0)
    )
    openings = solve(scene, rtol=RTOL).openings
    inner, outer = (openings[0].inner, openings[0].outer) if openings else (0.0, 0.0)
    return OpeningPoint(poisson_ratio, sign, ratio, inner, outer)


def opening_column(poisson_ratio: float, count: int) -> list[OpeningPoint]:
    """Return the map's points of one Poisson ratio, under a sudden pressure."""
    return [opening_point(poisson_ratio, AHEAD, ratio) for ratio in _ratios(count).tolist()]


def opening_speeds(poisson_ratio: float, count: int) -> list[OpeningPoint]:
    """Return the points of a panel of speeds, for both signs; they are dense at the threshold."""
    threshold, low = opening_threshold(poisson_ratio), 10.0 ** RATIOS[0]
    below = np.geomspace(low, threshold, count // 3, endpoint=False)
    beside = threshold * (1 - np.geomspace(1e-4, 0.3, count // 3))
    ratios = ((AHEAD, np.union1d(below, beside)), (EDGE, np.logspace(*RATIOS, count // 3)))
    return [
        opening_point(poisson_ratio, sign, ratio)
        for sign, several in ratios
        for ratio in several.tolist()
    ]


def sorted_openings(points: Sequence[OpeningPoint]) -> list[OpeningPoint]:
    """Sort points by Poisson ratio, sign of the step and ratio."""
    return sorted(points, key=lambda point: (point.poisson_ratio, point.sign, point.ratio))


@styled
def openings_figure(columns: Sequence[OpeningPoint], speeds: Sequence[OpeningPoint]) -> Figure:
    """Draw a map of the opening by a sudden pressure, and the speeds of its ends for both signs."""
    panels_of = {nu: list(part) for nu, part in groupby(speeds, lambda p: p.poisson_ratio)}
    words = "a step of pressure $P_0$ on base pressure $P_b$;  the same for any friction $f$"
    figure = describe(new_figure(4.4 + 2.7 * len(panels_of), 4.6), words)
    ratios = (1.6, *(1 for _ in panels_of))
    first, *rest = figure.subplots(1, len(ratios), width_ratios=ratios)
    figure.colorbar(
        _draw_map(first, columns), ax=first, label="open part of the way to the P front"
    )
    for panel, (nu, points) in zip(rest, panels_of.items(), strict=True):
        _draw_speeds(panel, nu, points)
    rest[0].set_ylabel(r"speed of the ends of the opening $/\ c_t$")
    figure.legend(
        handles=[
            Patch(color=STICK_SHADE, label="stays closed"),
            line_handle(r"opens ahead below $P_b/P_0 = -p^*(c)$", PREDICTION),
            Patch(color=shade("open"), label=r"open under a sudden pressure, $P_0 > 0$"),
            line_handle(r"open up to, pressure put on the slot, $P_0 < 0$", SIMULATION, "-."),
            line_handle(r"waves $c_R$, $c_t$, $c_l$", ink(0.65), "--"),
        ],
        loc="outside lower center",
        ncols=3,
        frameon=False,
    )
    return figure


def _ratios(count: int, corners: bool = False) -> NDArray[np.float64]:
    """Return P_b / P_0 of the map: centres of equal cells of its logarithm, or their corners."""
    low, high = RATIOS
    steps = np.arange(count + 1) if corners else np.arange(count) + 0.5
    return np.asarray(10 ** (low + (high - low) * steps / count))


def _draw_map(panel: Axes, points: Sequence[OpeningPoint]) -> QuadMesh:
    count = round(len(points) ** 0.5)
    speeds = [Material(1.0, 1.0, p.poisson_ratio).longitudinal_speed for p in points]
    share = np.array([(p.outer - p.inner) for p in points]) / speeds
    panel.set_facecolor(STICK_SHADE)
    image = panel.pcolormesh(
        poisson_ratios(count, corners=True),
        _ratios(count, corners=True),
        np.ma.masked_equal(share.reshape(count, count).T, 0.0),
        cmap="YlOrBr",
        norm=Normalize(0, 1),
        rasterized=True,
    )
    nu = np.linspace(*POISSON_RATIOS, 300)
    panel.plot(
        nu,
        [opening_threshold(float(value)) for value in nu],
        color=PREDICTION,
        path_effects=outline(),
    )
    panel.set(xlabel=r"Poisson ratio $\nu$", ylabel=r"$P_b/P_0$", yscale="log")
    panel.set(xlim=POISSON_RATIOS, ylim=tuple(10.0**end for end in RATIOS))
    return image


def _draw_speeds(panel: Axes, nu: float, points: Sequence[OpeningPoint]) -> None:
    material = Material(1.0, 1.0, nu)
    ahead, edge = ([p for p in points if p.sign == sign] for sign in (AHEAD, EDGE))
    ratio, inner, outer = (
        np.array([getattr(p, name) for p in ahead]) for name in ("ratio", "inner", "outer")
    )
    panel.fill_between(ratio, inner, outer, color=shade("open"), linewidth=0)
    for end in (inner, outer):
        panel.plot(ratio, end, color=PREDICTION)
    panel.plot([p.ratio for p in edge], [p.outer for p in edge], "-.", color=SIMULATION)
    low, high = (10.0**end for end in RATIOS)
    panel.set(xscale="log", xlim=(low, high), ylim=(0, 1.06 * material.longitudinal_speed))
    panel.set(xlabel=r"$P_b/|P_0|$", title=rf"$\nu = {nu:.3g}$")
    mark_waves(panel, wave_speeds(material), 1.0, "horizontal")
