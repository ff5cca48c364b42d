"""Figures over space and time, by both methods: slip sense, profiles, gaps."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from compare.comparison.case import Case
from compare.comparison.quantities.history_rows import sense_maps
from compare.comparison.quantities.local_rows import worst_places
from compare.figures import style
from compare.figures.interface import POINTS, fronts_figure, interface_figure
from semianalytic.results.answer import method_of
from semianalytic.scene.arrays import Array

MOMENTS = (0.25, 0.5, 0.75, 1.0)
_BESIDE: Mapping[str, Any] = {"textcoords": "offset points", "color": style.SIMULATION}


def comparison_figures(case: Case) -> dict[str, Callable[[Case], Figure]]:
    """Return the figures of a comparison, by file name without suffix."""
    figures: dict[str, Callable[[Case], Figure]] = {}
    solution: Any = case.prediction
    if method_of(solution) == "self-similar":
        figures = {
            "interface": lambda case: interface_figure(solution, case.seen),
            "fronts": lambda case: fronts_figure(solution, case.seen),
        }
    if case.slips or case.opens:
        figures |= {"sense": sense_figure}
    if case.slips:
        figures |= {"history": history_figure}
    if case.opens:
        figures |= {"gap": gap_figure}
    return figures


@style.styled
def sense_figure(case: Case) -> Figure:
    """Draw maps of slip sense and opening over (x, t): predicted, simulated, and differences, with
    the places at which fields are farthest beyond their error bars."""
    predicted, seen, reached = sense_maps(case)
    history, material, end = case.seen, case.scene.material, case.end_time
    length = material.shear_speed * end
    moving = np.flatnonzero(((predicted != 0) | (seen != 0)).any(axis=0))
    right = min(1.15 * history.x[moving[-1]] / length + 0.05, history.x[-1] / length)
    differs = np.where((predicted != seen) & reached, 1, 0)
    share = differs.sum() / reached.sum()
    shown = list(style.SENSE_COLOURS.items())[: None if case.opens else -1]
    kinds, most = ListedColormap([colour for _, colour in shown]), len(shown) - 2
    figure = style.describe(style.new_figure(10.5, 4.6), style.scene_words(case.scene))
    panels = figure.subplots(1, 3, sharex=True, sharey=True)
    for panel, title, values, colours, low, high in (
        (panels[0], f"semi-analytic ({method_of(case.prediction)})", predicted, kinds, -1, most),
        (panels[1], "finite elements", seen, kinds, -1, most),
        (panels[2], f"differ in {100 * share:.2g} % of the reached area", differs, "Greys", 0, 1),
    ):
        panel.pcolormesh(
            history.x / length,
            history.t / end,
            values,
            shading="nearest",
            cmap=colours,
            vmin=low,
            vmax=high,
            rasterized=True,
        )
        panel.set(xlabel=style.PLACE_LABEL, xlim=(0, right), ylim=(0, 1))
        panel.set_title(title, pad=16)
        style.mark_waves(
            panel, case.fronts, material.shear_speed, "rays", colour=style.BLACK, outlined="white"
        )
    for name, (level, node), (expected, found, bar) in worst_places(case):
        if abs(found - expected) > bar:
            place = history.x[node] / length, history.t[level] / end
            panels[2].plot(*place, "o", color=style.SIMULATION, fillstyle="none")
            panels[2].annotate(name.replace("_", " "), place, xytext=(5, 3), **_BESIDE)
    panels[0].set_ylabel(style.TIME_LABEL)
    handles = [Patch(color=colour, label=kind) for kind, colour in shown]
    panels[1].legend(
        handles=[*handles, style.waves_handle(case.fronts, style.BLACK)],
        loc="lower right",
    )
    return figure


@style.styled
def history_figure(case: Case) -> Figure:
    """Draw the slip rate along the interface at four times, by both methods."""
    seen, end = case.seen, case.end_time
    length, scale = case.length, case.rate
    figure = style.describe(style.new_figure(7, 7.7), style.scene_words(case.scene))
    panels = figure.subplots(len(MOMENTS), 1, sharex=True)
    reach = np.flatnonzero(np.abs(case.at_nodes.slip_rate).max(axis=0) > 0)[-1]
    for panel, moment in zip(panels, MOMENTS, strict=True):
        level = int(np.argmin(np.abs(seen.t - moment * end)))
        x, slip_rate = curve(case.prediction, float(seen.x[-1]), float(seen.t[level]))
        panel.axhline(0, color=style.ink(0.5), linewidth=0.6)
        points = seen.x / length, seen.slip_rate[level] / scale
        _draw_both(panel, (x / length, slip_rate / scale), points)
        panel.annotate(f"t = {moment:g} T", (0.98, 0.85), xycoords="axes fraction", ha="right")
    panels[0].legend(handles=style.method_handles(), loc="upper center")
    panels[-1].set(xlabel=style.PLACE_LABEL, xlim=(0, 1.05 * seen.x[reach] / length))
    figure.supylabel(style.RATE_LABEL)
    return figure


@style.styled
def gap_figure(case: Case) -> Figure:
    """Draw the gap at four times, and the contact pressure at the end, by both methods."""
    seen, length, end = case.seen, case.length, case.end_time
    figure = style.describe(style.new_figure(7, 5.7), style.scene_words(case.scene))
    upper, lower = figure.subplots(2, 1, sharex=True)
    x = np.linspace(seen.x[-1] / POINTS, seen.x[-1], POINTS)
    for moment in MOMENTS:
        level = int(np.argmin(np.abs(seen.t - moment * end)))
        gap = case.prediction.gap(x, float(seen.t[level])) / (case.rate * end)
        points = seen.x / length, seen.gap[level] / (case.rate * end)
        _draw_both(upper, (x / length, gap), points)
    pressure = case.prediction.pressure(x, end) / case.stress
    _draw_both(lower, (x / length, pressure), (seen.x / length, seen.pressure[-1] / case.stress))
    upper.set_ylabel(style.GAP_LABEL)
    upper.set_title("gap at t = T/4, T/2, 3 T/4 and T, pressure at T")
    upper.legend(handles=style.method_handles(), loc="upper right")
    opened = np.flatnonzero((case.at_nodes.gap + seen.gap).max(axis=0))
    right = min(2 * seen.x[opened[-1]], seen.x[-1]) / length
    calm = 2 * case.scene.superposition.in_place.pressure / case.stress
    lower.set(
        xlabel=style.PLACE_LABEL,
        ylabel=style.PRESSURE_LABEL,
        xlim=(0, right),
        ylim=(-0.05 * calm, calm),
    )
    for opening in case.prediction.openings_at(end):
        for panel in (upper, lower):
            place = opening.start / length, opening.end / length
            panel.axvspan(*place, color=style.shade("open"), linewidth=0, zorder=0)
    return figure


def _draw_both(panel: Axes, curve: tuple[Array, Array], points: tuple[Array, Array]) -> None:
    """Draw a prediction as a curve over points of a simulation."""
    panel.plot(*points, ".", color=style.SIMULATION, markersize=2.5)
    panel.plot(*curve, color=style.PREDICTION, linewidth=1.2)


def curve(prediction: Any, reach: float, time: float) -> tuple[Array, Array]:
    """Return positions and slip rates (n,) up to a reach, at the resolution of the answer."""
    x = np.linspace(reach / POINTS, reach, POINTS)
    if method_of(prediction) == "space-time":
        x = prediction.interface.x
    return x, prediction.slip_rate(x, time)
