"""Figures of slip rate, tractions and the space–time map: prediction and simulation.

Every function draws a `solution`, an exact prediction, as its own `plot` does, and the `history` of
a simulation of the same scene, and returns a Figure.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from compare.figures import style
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.results.plotting import draw_map, draw_profile, scene_title, shown_units

POINTS = 1500


@style.styled
def interface_figure(solution: Any, history: InterfaceHistory) -> Figure:
    """Draw slip rate and tractions at the last time of the history, and the difference of rates."""
    scene, time = solution.scene, float(history.t[-1])
    figure, (upper, middle, lower) = _new_panels(solution, (3, 3, 1))
    (_, reach), _ = draw_profile(solution, (upper, middle, lower), time)
    length, _, stress = shown_units(scene, reach, time)
    shown = history.x <= reach
    x, rate = history.x[shown] * length[0], history.slip_rate[-1, shown]
    drawn = [line.get_label() for line in middle.lines]
    for name, field in (("shear traction", "shear_traction"), ("pressure", "pressure")):
        if name in drawn:
            values = getattr(history, field)[-1, shown] * stress[0]
            middle.plot(x, values, ".", color=style.SIMULATION, markersize=2)
    upper.plot(x, rate, ".", color=style.SIMULATION, markersize=3)
    difference = rate - solution.slip_rate(history.x[shown], time)
    lower.plot(x, difference, color=style.SIMULATION, linewidth=1)
    lower.axhline(0, color=style.PREDICTION, linewidth=0.8)
    lower.set_ylabel("difference")
    if not solution.zones:  # rounding errors must not fill the panel of a stuck interface
        for panel, least in ((upper, 0.1), (lower, 0.01)):
            low, high = panel.get_ylim()
            panel.set_ylim(min(low, -least), max(high, least))
    figure.legend(handles=style.method_handles(), loc="outside lower center", ncols=2)
    return figure


@style.styled
def fronts_figure(solution: Any, history: InterfaceHistory) -> Figure:
    """Draw a space–time map of the simulated slip rate with predicted fronts and zone edges."""
    figure, (panel,) = _new_panels(solution, (1,))
    draw_map(solution, history, panel)
    end = float(history.t[-1])
    length, time, _ = shown_units(solution.scene, float(np.ptp(history.x)), end)
    panel.set_ylim(0, end * time[0])
    kinds: tuple[tuple[Any, str, style.LineStyle], ...] = (
        (solution.zones, "predicted zone edges", "-"),
        (solution.openings, "predicted ends of the opening", ":"),
    )
    for parts, _, line in kinds:
        ends = {edge for part in parts for edge in (part.inner, part.outer) if 0 < edge < np.inf}
        for edge in ends:
            place = [0, edge * end * length[0]]
            panel.plot(place, [0, end * time[0]], line, color=style.VIOLET, linewidth=1.1)
    handles = [style.line_handle(words, style.VIOLET, line) for of, words, line in kinds if of]
    for drawn in panel.lines:
        drawn.set_path_effects(style.outline())
    if handles:
        panel.legend(handles=handles, loc="lower right")
    return figure


def _new_panels(solution: Any, ratios: tuple[int, ...]) -> tuple[Figure, Any]:
    """Return a figure with panels above each other, with these ratios of heights."""
    figure = style.new_figure(7, 3.5 + 1.2 * len(ratios))
    style.describe(figure, scene_title(solution.scene))
    return figure, np.ravel(figure.subplots(len(ratios), 1, sharex=True, height_ratios=ratios))
