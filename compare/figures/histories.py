"""Figures over space and time: slip sense by both methods, profiles, wear; and marches."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from compare.comparison.case import Case
from compare.comparison.quantities.history_rows import sense_maps
from compare.comparison.scales import scene_fronts, slip_rate_scale
from compare.figures.interface import (
    POINTS,
    Array,
    fronts_figure,
    slip_rate_figure,
    tractions_figure,
)
from compare.figures.style import (
    BLACK,
    GAP_LABEL,
    PATH_LABEL,
    PLACE_LABEL,
    PREDICTION,
    PRESSURE_LABEL,
    RATE_LABEL,
    SENSE_COLOURS,
    SIMULATION,
    TIME_LABEL,
    WORK_LABEL,
    describe,
    ink,
    mark_waves,
    method_handles,
    new_figure,
    scene_words,
    shade,
    styled,
    waves_handle,
)
from semianalytic import Marched
from semianalytic.results.answer import method_of

MOMENTS = (0.25, 0.5, 0.75, 1.0)
LEVELS = 400
"""Approximate largest number of points of a march that are drawn along each axis."""


def comparison_figures(case: Case) -> dict[str, Callable[[Case], Figure]]:
    """Return the figures of a comparison, by file name without suffix."""
    figures: dict[str, Callable[[Case], Figure]] = {}
    solution: Any = case.prediction
    if method_of(solution) == "self-similar":
        figures = {
            "slip_rate": lambda one: slip_rate_figure(solution, one.seen),
            "tractions": lambda one: tractions_figure(solution, one.seen),
            "fronts": lambda one: fronts_figure(solution, one.seen),
        }
    if case.slips or case.opens:
        figures |= {"sense": sense_figure}
    if case.slips:
        figures |= {"history": history_figure, "wear": wear_figure}
    if case.opens:
        figures |= {"gap": gap_figure}
    return figures


@styled
def sense_figure(case: Case) -> Figure:
    """Draw maps of slip sense and opening over (x, t): predicted, simulated, and differences."""
    predicted, seen, reached = sense_maps(case)
    history, material, end = case.seen, case.scene.material, case.end_time
    length = material.shear_speed * end
    moving = np.flatnonzero(((predicted != 0) | (seen != 0)).any(axis=0))
    right = min(1.15 * history.x[moving[-1]] / length + 0.05, history.x[-1] / length)
    differs = np.where((predicted != seen) & reached, 1, 0)
    share = differs.sum() / reached.sum()
    shown = list(SENSE_COLOURS.items())[: None if case.opens else -1]
    kinds, most = ListedColormap([colour for _, colour in shown]), len(shown) - 2
    figure = describe(new_figure(10.5, 4.6), scene_words(case.scene))
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
        panel.set(xlabel=PLACE_LABEL, xlim=(0, right), ylim=(0, 1))
        panel.set_title(title, pad=16)
        mark_waves(panel, case.fronts, material.shear_speed, "rays", colour=BLACK, outlined="white")
    panels[0].set_ylabel(TIME_LABEL)
    handles = [Patch(color=colour, label=kind) for kind, colour in shown]
    panels[1].legend(
        handles=[*handles, waves_handle(case.fronts, BLACK)],
        loc="lower right",
    )
    return figure


@styled
def history_figure(case: Case) -> Figure:
    """Draw the slip rate along the interface at four times, by both methods."""
    seen, end = case.seen, case.end_time
    length, scale = case.length, case.rate
    figure = describe(new_figure(7, 7.7), scene_words(case.scene))
    panels = figure.subplots(len(MOMENTS), 1, sharex=True)
    reach = np.flatnonzero(np.abs(case.at_nodes.slip_rate).max(axis=0) > 0)[-1]
    for panel, moment in zip(panels, MOMENTS, strict=True):
        level = int(np.argmin(np.abs(seen.t - moment * end)))
        x, slip_rate = curve(case.prediction, float(seen.x[-1]), float(seen.t[level]))
        panel.axhline(0, color=ink(0.5), linewidth=0.6)
        points = seen.x / length, seen.slip_rate[level] / scale
        _draw_both(panel, (x / length, slip_rate / scale), points)
        panel.annotate(f"t = {moment:g} T", (0.98, 0.85), xycoords="axes fraction", ha="right")
    panels[0].legend(handles=method_handles(), loc="upper center")
    panels[-1].set(xlabel=PLACE_LABEL, xlim=(0, 1.05 * seen.x[reach] / length))
    figure.supylabel(RATE_LABEL)
    return figure


@styled
def wear_figure(case: Case) -> Figure:
    """Draw accumulated |slip| and frictional work along the interface by both methods."""
    simulation, x, length = case.simulation, case.seen.x, case.length
    path, work = case.worn_at_nodes
    slip, stress = case.rate * case.end_time, case.stress
    figure = describe(new_figure(7, 5.7), scene_words(case.scene))
    panels = figure.subplots(2, 1, sharex=True)
    for panel, label, (predicted, seen), unit in (
        (panels[0], PATH_LABEL, (path, simulation.final_path), slip),
        (panels[1], WORK_LABEL, (work, simulation.final_work_density), slip * stress),
    ):
        _draw_both(panel, (x / length, predicted / unit), (x / length, seen / unit))
        panel.set_ylabel(label)
        panel.set_ylim(bottom=0)
    reach = np.flatnonzero(path > 0)[-1]
    panels[0].legend(handles=method_handles(), loc="upper right")
    panels[1].set(xlabel=PLACE_LABEL, xlim=(0, 1.05 * x[reach] / length))
    return figure


@styled
def gap_figure(case: Case) -> Figure:
    """Draw the gap at four times, and the contact pressure at the end, by both methods."""
    seen, length, end = case.seen, case.length, case.end_time
    figure = describe(new_figure(7, 5.7), scene_words(case.scene))
    upper, lower = figure.subplots(2, 1, sharex=True)
    x = np.linspace(seen.x[-1] / POINTS, seen.x[-1], POINTS)
    for moment in MOMENTS:
        level = int(np.argmin(np.abs(seen.t - moment * end)))
        gap = case.prediction.gap(x, float(seen.t[level])) / (case.rate * end)
        points = seen.x / length, seen.gap[level] / (case.rate * end)
        _draw_both(upper, (x / length, gap), points)
    pressure = case.prediction.pressure(x, end) / case.stress
    _draw_both(lower, (x / length, pressure), (seen.x / length, seen.pressure[-1] / case.stress))
    upper.set_ylabel(GAP_LABEL)
    upper.set_title("gap at t = T/4, T/2, 3 T/4 and T, pressure at T")
    upper.legend(handles=method_handles(), loc="upper right")
    opened = np.flatnonzero((case.at_nodes.gap + seen.gap).max(axis=0))
    right = min(2 * seen.x[opened[-1]], seen.x[-1]) / length
    calm = 2 * case.scene.superposition.in_place.pressure / case.stress
    lower.set(xlabel=PLACE_LABEL, ylabel=PRESSURE_LABEL, xlim=(0, right), ylim=(-0.05 * calm, calm))
    for opening in case.prediction.openings_at(end):
        for panel in (upper, lower):
            place = opening.start / length, opening.end / length
            panel.axvspan(*place, color=shade("open"), linewidth=0, zorder=0)
    return figure


def _draw_both(panel: Axes, curve: tuple[Array, Array], points: tuple[Array, Array]) -> None:
    """Draw a prediction as a curve over points of a simulation."""
    panel.plot(*points, ".", color=SIMULATION, markersize=2.5)
    panel.plot(*curve, color=PREDICTION, linewidth=1.2)


def curve(prediction: Any, reach: float, time: float) -> tuple[Array, Array]:
    """Return positions and slip rates (n,) up to a reach, at the resolution of the answer."""
    x = np.linspace(reach / POINTS, reach, POINTS)
    if method_of(prediction) == "space-time":
        x = prediction.interface.x
    return x, prediction.slip_rate(x, time)


@styled
def march_figure(marched: Marched) -> Figure:
    """Draw the slip rate over space and time, and the accumulated |slip| along the interface."""
    scene, fields = marched.scene, marched.interface
    length, scale = scene.material.shear_speed * marched.end_time, slip_rate_scale(scene)
    rows = slice(None, None, max(1, len(fields.t) // LEVELS))
    columns = slice(None, None, max(1, len(fields.x) // LEVELS))
    rate = fields.slip_rate[rows, columns] / scale
    top = max(float(np.quantile(np.abs(rate), 0.99)), 1e-6)
    figure = describe(new_figure(7, 6.2), scene)
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(2, 1))
    image = upper.pcolormesh(
        fields.x[columns] / length,
        fields.t[rows] / marched.end_time,
        rate,
        shading="nearest",
        cmap="RdBu",
        vmin=-top,
        vmax=top,
        rasterized=True,
    )
    figure.colorbar(image, ax=upper, label=RATE_LABEL)
    upper.set(ylabel=TIME_LABEL, xlim=(0, fields.x[-1] / length), ylim=(0, 1))
    speed = scene.material.shear_speed
    mark_waves(upper, scene_fronts(scene), speed, "rays", colour=BLACK, outlined="white")
    lower.plot(fields.x / length, marched.final_path / (scale * marched.end_time), color=PREDICTION)
    lower.set(xlabel=PLACE_LABEL, ylabel=PATH_LABEL)
    return figure
