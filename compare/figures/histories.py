"""Figures over space and time: sense of slip by both methods, profiles, wear; a march alone."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from compare.comparison.history_rows import sense_maps, slips
from compare.comparison.report import Report
from compare.comparison.scales import slip_rate_scale, stress_scale
from compare.figures.interface import fronts_figure, slip_rate_figure, tractions_figure
from compare.figures.style import (
    PATH_LABEL,
    PLACE_LABEL,
    PREDICTION,
    RATE_LABEL,
    SENSE_COLOURS,
    SIMULATION,
    SMALL,
    TIME_LABEL,
    WORK_LABEL,
    describe,
    mark_waves,
    method_handles,
    new_figure,
    waves_handle,
)
from semianalytic import Marched

MOMENTS = (0.25, 0.5, 0.75, 1.0)
LEVELS = 400
"""Most points of a march that are drawn along each axis, nearly."""


def comparison_figures(report: Report) -> dict[str, Callable[[Report], Figure]]:
    """The figures that a comparison has, by file name."""
    figures: dict[str, Callable[[Report], Figure]] = {}
    solution = report.prediction.solution
    if solution is not None:
        figures = {
            "slip_rate.png": lambda r: slip_rate_figure(solution, r.simulation.interface),
            "tractions.png": lambda r: tractions_figure(solution, r.simulation.interface),
            "fronts.png": lambda r: fronts_figure(solution, r.simulation.interface),
        }
    if slips(report.prediction, report.simulation):
        figures |= {"sense.png": sense_figure, "history.png": history_figure}
        figures |= {"wear.png": wear_figure}
    return figures


def sense_figure(report: Report) -> Figure:
    """Maps of slip sense over (x, t): predicted, simulated, and where the two differ."""
    predicted, seen, reached = sense_maps(report.prediction, report.simulation)
    history = report.simulation.interface
    material, end = report.simulation.scene.material, history.t[-1]
    length = material.shear_speed * end
    slipping = np.flatnonzero((predicted != 0).any(axis=0))
    right = min(1.15 * history.x[slipping[-1]] / length + 0.05, history.x[-1] / length)
    differs = np.where((predicted != seen) & reached, 1, 0)
    share = differs.sum() / reached.sum()
    kinds = ListedColormap(list(SENSE_COLOURS.values()))
    figure = describe(new_figure(10.5, 4.6), report.simulation.scene)
    panels = figure.subplots(1, 3, sharex=True, sharey=True)
    for panel, title, values, colours, low in (
        (panels[0], f"semi-analytic ({report.prediction.method})", predicted, kinds, -1),
        (panels[1], "finite elements", seen, kinds, -1),
        (panels[2], f"differ in {100 * share:.2g} % of the reached area", differs, "Greys", 0),
    ):
        panel.pcolormesh(
            history.x / length,
            history.t / end,
            values,
            shading="nearest",
            cmap=colours,
            vmin=low,
            vmax=1,
            rasterized=True,
        )
        panel.set(xlabel=PLACE_LABEL, xlim=(0, right), ylim=(0, 1))
        panel.set_title(title, pad=16)
        mark_waves(panel, material, material.shear_speed, "rays")
    panels[0].set_ylabel(TIME_LABEL)
    handles = [Patch(color=colour, label=kind) for kind, colour in SENSE_COLOURS.items()]
    panels[1].legend(handles=[*handles, waves_handle()], loc="lower right", fontsize=SMALL)
    return figure


def history_figure(report: Report) -> Figure:
    """Slip rate along the interface at four moments, by both methods."""
    prediction, seen = report.prediction, report.simulation.interface
    scene, end = report.simulation.scene, seen.t[-1]
    length, scale = scene.material.shear_speed * end, slip_rate_scale(scene)
    figure = describe(new_figure(7, 7.7), scene)
    panels = figure.subplots(len(MOMENTS), 1, sharex=True)
    reach = np.flatnonzero(np.abs(prediction.interface.slip_rate).max(axis=0) > 0)[-1]
    for panel, moment in zip(panels, MOMENTS, strict=True):
        level = int(np.argmin(np.abs(seen.t - moment * end)))
        x, slip_rate = prediction.curve(seen.t[level])
        panel.axhline(0, color="0.6", linewidth=0.6)
        panel.plot(
            seen.x / length, seen.slip_rate[level] / scale, ".", color=SIMULATION, markersize=2.5
        )
        panel.plot(x / length, slip_rate / scale, color=PREDICTION, linewidth=1.2)
        panel.annotate(f"t = {moment:g} T", (0.98, 0.85), xycoords="axes fraction", ha="right")
    panels[0].legend(handles=method_handles(), loc="upper center", fontsize=SMALL)
    panels[-1].set(xlabel=PLACE_LABEL, xlim=(0, 1.05 * seen.x[reach] / length))
    figure.supylabel(RATE_LABEL)
    return figure


def wear_figure(report: Report) -> Figure:
    """Accumulated |slip| and frictional work along the interface at the end, by both methods."""
    prediction, simulation = report.prediction, report.simulation
    scene, x, end = simulation.scene, simulation.interface.x, simulation.interface.t[-1]
    length = scene.material.shear_speed * end
    slip, stress = slip_rate_scale(scene) * end, stress_scale(scene)
    work = prediction.final_work_density, simulation.final_work_density
    figure = describe(new_figure(7, 5.7), scene)
    panels = figure.subplots(2, 1, sharex=True)
    for panel, label, (predicted, seen), unit in (
        (panels[0], PATH_LABEL, (prediction.final_path, simulation.final_path), slip),
        (panels[1], WORK_LABEL, work, slip * stress),
    ):
        panel.plot(x / length, predicted / unit, color=PREDICTION)
        panel.plot(x / length, seen / unit, ".", color=SIMULATION, markersize=2.5)
        panel.set_ylabel(label)
        panel.set_ylim(bottom=0)
    reach = np.flatnonzero(prediction.final_path > 0)[-1]
    panels[0].legend(handles=method_handles(), loc="upper right", fontsize=SMALL)
    panels[1].set(xlabel=PLACE_LABEL, xlim=(0, 1.05 * x[reach] / length))
    return figure


def march_figure(marched: Marched) -> Figure:
    """Slip rate over space and time, and accumulated |slip| along the interface at the end."""
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
    mark_waves(upper, scene.material, scene.material.shear_speed, "rays")
    lower.plot(fields.x / length, marched.final_path / (scale * marched.end_time), color=PREDICTION)
    lower.set(xlabel=PLACE_LABEL, ylabel=PATH_LABEL)
    return figure
