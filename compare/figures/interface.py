"""Figures: slip rate, tractions and the space–time map, prediction against simulation.

Every function returns a Figure of a `solution`, the prediction, and where it takes a `history`, of
the simulation of the same scene.  Pass `axes` to draw into axes of a figure of your own.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import pairwise

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import Normalize, PowerNorm
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import NDArray

from compare.comparison.scales import slip_rate_scale, stress_scale
from compare.figures.style import (
    BLACK,
    ORANGE,
    PLACE_LABEL,
    PREDICTION,
    RATE_LABEL,
    REVERSE_SHADE,
    SIMULATION,
    SLIP_SHADE,
    SMALL,
    SPEED_LABEL,
    STICK_SHADE,
    TIME_LABEL,
    TRACTION_LABEL,
    describe,
    line_handle,
    mark_waves,
    marker_handle,
    method_handles,
    new_figure,
    waves_handle,
)
from semianalytic import Scene, SlipZone, Solution
from semianalytic.results.interface_history import InterfaceHistory

Array = NDArray[np.float64]

ZONE_COLOURS = {"slip": SLIP_SHADE, "stick": STICK_SHADE, "reverse slip": REVERSE_SHADE}
POINTS = 1500


def slip_rate_figure(
    solution: Solution, history: InterfaceHistory, *, axes: tuple[Axes, Axes] | None = None
) -> Figure:
    """Slip rate against ξ/c_t at the last time of the history, with the difference below."""
    scene, scale, time = solution.scene, slip_rate_scale(solution.scene), history.t[-1]
    upper, lower = axes or _new_pair(scene)
    unit, dense = scene.material.shear_speed, _speeds(scene)
    shown = history.x <= _speed_limit(scene) * time
    velocity, seen = history.x[shown] / time / unit, history.slip_rate[-1, shown] / scale
    difference = seen - solution.slip_rate(history.x[shown], time) / scale

    _shade_zones(upper, solution.zones, scene)
    upper.plot(dense / unit, solution.slip_rate(dense * time, time) / scale, color=PREDICTION)
    upper.plot(velocity, seen, ".", color=SIMULATION, markersize=3)
    lower.plot(velocity, difference, color=SIMULATION, linewidth=1)
    lower.axhline(0, color=PREDICTION, linewidth=0.8)
    for panel in (upper, lower):
        mark_waves(panel, scene.material, unit, labels=panel is upper)
    if not solution.zones:
        _widen(upper, 0.1)
        _widen(lower, 0.01)
    upper.set_ylabel(RATE_LABEL)
    _legend(upper, solution, *method_handles())
    lower.set(xlabel=SPEED_LABEL, ylabel="difference", xlim=(0, dense[-1] / unit))
    return _figure(upper)


def tractions_figure(
    solution: Solution, history: InterfaceHistory, *, axes: Axes | None = None
) -> Figure:
    """Shear traction and friction bound ±f p against ξ/c_t at the last time of the history."""
    scene, scale, time = solution.scene, stress_scale(solution.scene), history.t[-1]
    panel = axes or _new_axes(scene)
    unit = scene.material.shear_speed
    shown = history.x <= _speed_limit(scene) * time
    velocity = history.x[shown] / time / unit
    shear = history.shear_traction[-1, shown] / scale
    bound = scene.friction * history.pressure[-1, shown] / scale

    _shade_zones(panel, solution.zones, scene)
    predicted = _draw_predicted_tractions(panel, solution, time)
    panel.plot(velocity, shear, ".", color=SIMULATION, markersize=3)
    for sign in (1, -1):
        panel.plot(velocity, sign * bound, "_", color=SIMULATION, markersize=3, alpha=0.6)
    mark_waves(panel, scene.material, unit)
    handles = (
        line_handle("shear traction, semi-analytic", PREDICTION),
        marker_handle("shear traction, finite elements", SIMULATION),
        line_handle(r"bound $\pm f p$, semi-analytic", PREDICTION, ":"),
        marker_handle(r"bound $\pm f p$, finite elements", SIMULATION, "_"),
    )
    _legend(panel, solution, *handles)
    panel.set(xlabel=SPEED_LABEL, ylabel=TRACTION_LABEL, xlim=(0, _right_end(scene)))
    panel.set_ylim(_traction_limits(predicted))
    return _figure(panel)


def fronts_figure(
    solution: Solution, history: InterfaceHistory, *, axes: Axes | None = None
) -> Figure:
    """Space–time map of the simulated slip rate under the predicted fronts and zone edges.

    Slip of one sense is coloured by its square root, so that weak zones show.
    """
    scene, scale, time = solution.scene, slip_rate_scale(solution.scene), history.t[-1]
    length = scene.material.shear_speed * time
    panel = axes or _new_axes(scene)
    rate = history.slip_rate / scale
    signed = bool(np.any(rate < -1e-3))
    top = max(float(np.quantile(np.abs(rate), 0.999)), 1e-3)
    image = panel.pcolormesh(
        history.x / length,
        history.t / time,
        rate if signed else np.maximum(rate, 0),
        shading="nearest",
        cmap="RdBu_r" if signed else "viridis",
        norm=Normalize(-top, top) if signed else PowerNorm(0.5, 0, top),
        rasterized=True,
    )
    _figure(panel).colorbar(image, ax=panel, label=RATE_LABEL + ", finite elements")
    panel.set(xlabel=PLACE_LABEL, ylabel=TIME_LABEL, facecolor="0.9")
    panel.set(xlim=(0, _right_end(scene)), ylim=(0, 1))
    waves, edges = ("0.35", BLACK) if signed else ("white", ORANGE)
    mark_waves(panel, scene.material, scene.material.shear_speed, "rays", colour=waves)
    for edge in _finite_edges(solution.zones):
        slope = edge / scene.material.shear_speed
        panel.plot([0, slope], [0, 1], "-", color=edges, linewidth=1.1)
    handles = [waves_handle(waves)]
    if solution.zones:
        handles.append(line_handle("predicted zone edges", edges))
    panel.legend(
        handles=handles, loc="lower right", fontsize=SMALL, facecolor="0.85" if signed else "0.45"
    )
    return _figure(panel)


def prediction_figure(solution: Solution, *, axes: tuple[Axes, Axes] | None = None) -> Figure:
    """The semi-analytic answer alone: slip rate above, tractions and friction bound below."""
    scene = solution.scene
    upper, lower = axes or _new_pair(scene, ratios=(1, 1))
    unit, dense = scene.material.shear_speed, _speeds(scene)
    for panel in (upper, lower):
        _shade_zones(panel, solution.zones, scene)
        mark_waves(panel, scene.material, unit, labels=panel is upper)
    rate = solution.slip_rate(dense, 1.0) / slip_rate_scale(scene)
    upper.plot(dense / unit, rate, color=PREDICTION)
    upper.set_ylabel(RATE_LABEL)
    _legend(upper, solution)
    shear = _draw_predicted_tractions(lower, solution, 1.0)
    bound = line_handle(r"bound $\pm f p$", PREDICTION, ":")
    handles = [line_handle("shear traction", PREDICTION), bound]
    lower.legend(handles=handles, loc="best", fontsize=SMALL)
    lower.set(xlabel=SPEED_LABEL, ylabel=TRACTION_LABEL, xlim=(0, _right_end(scene)))
    lower.set_ylim(_traction_limits(shear))
    return _figure(upper)


def _new_axes(scene: Scene) -> Axes:
    return describe(new_figure(7, 4.7), scene).subplots()


def _new_pair(scene: Scene, ratios: tuple[int, int] = (3, 1)) -> tuple[Axes, Axes]:
    figure = describe(new_figure(7, 5.7), scene)
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=ratios)
    return upper, lower


def _figure(panel: Axes) -> Figure:
    figure = panel.get_figure(root=True)
    assert figure is not None  # axes in use always belong to a figure
    return figure


def _speed_limit(scene: Scene) -> float:
    return 1.05 * scene.material.longitudinal_speed


def _right_end(scene: Scene) -> float:
    return _speed_limit(scene) / scene.material.shear_speed


def _speeds(scene: Scene) -> Array:
    """Similarity velocities [length / time] for a smooth curve, the edge itself left out."""
    limit = _speed_limit(scene)
    return np.linspace(limit / POINTS, limit, POINTS)


def _finite_edges(zones: Iterable[SlipZone]) -> Iterator[float]:
    for zone in zones:
        yield from (edge for edge in (zone.inner, zone.outer) if 0 < edge < np.inf)


def _zone_kind(zone: SlipZone) -> str:
    return "slip" if zone.sense > 0 else "reverse slip"


def _shade_zones(panel: Axes, zones: tuple[SlipZone, ...], scene: Scene) -> None:
    """Shade slip, reverse slip and what sticks between them."""
    limit, unit = _speed_limit(scene), scene.material.shear_speed
    ends = [0.0, *(min(e, limit) for zone in zones for e in (zone.inner, zone.outer)), limit]
    for number, (start, stop) in enumerate(pairwise(ends)):
        kind = _zone_kind(zones[number // 2]) if number % 2 else "stick"
        panel.axvspan(start / unit, stop / unit, color=ZONE_COLOURS[kind], linewidth=0, zorder=0)


def _draw_predicted_tractions(panel: Axes, solution: Solution, time: float) -> Array:
    """Draw predicted shear traction and bound; return the shear traction / τ₀ beside ξ."""
    scene, scale = solution.scene, stress_scale(solution.scene)
    dense = _speeds(scene)
    shear = solution.shear_traction(dense * time, time) / scale
    bound = scene.friction * solution.pressure(dense * time, time) / scale
    position = dense / scene.material.shear_speed
    panel.plot(position, shear, color=PREDICTION)
    for sign in (1, -1):
        panel.plot(position, sign * bound, ":", color=PREDICTION)
    return shear


def _traction_limits(shear: Array) -> tuple[float, float]:
    """Limits that leave out what grows without bound towards the edge."""
    beyond_edge = shear[len(shear) // 20 :]
    lowest, highest = float(beyond_edge.min()), float(beyond_edge.max())
    margin = 0.15 * max(highest - lowest, 1e-3)
    return lowest - margin, highest + margin


def _widen(panel: Axes, least: float) -> None:
    """Keep rounding from filling the panel of an interface that sticks."""
    lowest, highest = panel.get_ylim()
    panel.set_ylim(min(lowest, -least), max(highest, least))


def _legend(panel: Axes, solution: Solution, *handles: Artist) -> None:
    """A legend of these entries and of the shades of the zones."""
    kinds = dict.fromkeys(["stick", *(_zone_kind(zone) for zone in solution.zones)])
    shades = [Patch(color=ZONE_COLOURS[kind], label=kind) for kind in kinds]
    panel.legend(handles=[*handles, *shades], loc="best", fontsize=SMALL)
