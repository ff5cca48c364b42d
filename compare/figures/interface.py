"""Figures of slip rate, tractions and the space–time map: prediction against simulation.

Every function draws a `solution`, the prediction, and returns a Figure.  Where it takes a
`history`, this is the simulation of the same scene.  Pass `axes` to draw into your own figure.
"""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import Normalize, PowerNorm
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import NDArray

from compare.comparison.scales import contact_fronts, slip_rate_scale, stress_scale
from compare.figures import style
from compare.figures.fronts import reach
from semianalytic import Solution
from semianalytic.dissimilar_slot.solution import PairSolution
from semianalytic.results.in_words import kind_of_slip
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.selfsimilar.zones.motion import OpenZone, SlipZone

Array = NDArray[np.float64]
Exact = Solution | PairSolution

POINTS = 1500


@style.styled
def slip_rate_figure(
    solution: Exact, history: InterfaceHistory, *, axes: tuple[Axes, Axes] | None = None
) -> Figure:
    """Draw slip rate against ξ/c_t at the last time of the history, with the difference below."""
    scene, scale, time = solution.scene, slip_rate_scale(solution.scene), history.t[-1]
    upper, lower = axes or _new_panels(solution, (3, 1))
    unit, dense = scene.material.shear_speed, _speeds(solution)
    shown = history.x <= _speed_limit(solution) * time
    velocity, seen = history.x[shown] / time / unit, history.slip_rate[-1, shown] / scale
    difference = seen - solution.slip_rate(history.x[shown], time) / scale

    _shade_zones(upper, solution)
    upper.plot(dense / unit, solution.slip_rate(dense * time, time) / scale, color=style.PREDICTION)
    upper.plot(velocity, seen, ".", color=style.SIMULATION, markersize=3)
    lower.plot(velocity, difference, color=style.SIMULATION, linewidth=1)
    lower.axhline(0, color=style.PREDICTION, linewidth=0.8)
    for panel in (upper, lower):
        style.mark_waves(panel, _fronts(solution), unit, labels=panel is upper)
    if not solution.zones:
        _widen(upper, 0.1)
        _widen(lower, 0.01)
    upper.set_ylabel(style.RATE_LABEL)
    _legend(upper, solution, *style.method_handles())
    lower.set(xlabel=style.SPEED_LABEL, ylabel="difference", xlim=(0, dense[-1] / unit))
    return _figure(upper)


@style.styled
def tractions_figure(
    solution: Exact, history: InterfaceHistory, *, axes: Axes | None = None
) -> Figure:
    """Draw shear traction and friction bound ±f p against ξ/c_t at the last time of the history."""
    scene, scale, time = solution.scene, stress_scale(solution.scene), history.t[-1]
    panel = axes or _new_axes(solution)
    unit = scene.material.shear_speed
    shown = history.x <= _speed_limit(solution) * time
    velocity = history.x[shown] / time / unit
    shear = history.shear_traction[-1, shown] / scale
    bound = scene.strength(history.pressure[-1, shown]) / scale

    _shade_zones(panel, solution)
    predicted = _draw_predicted_tractions(panel, solution, time)
    panel.plot(velocity, shear, ".", color=style.SIMULATION, markersize=3)
    for sign in (1, -1):
        panel.plot(velocity, sign * bound, "_", color=style.SIMULATION, markersize=3)
    style.mark_waves(panel, _fronts(solution), unit)
    handles = (
        style.line_handle("shear traction, semi-analytic", style.PREDICTION),
        style.marker_handle("shear traction, finite elements", style.SIMULATION),
        style.line_handle(r"bound $\pm f p$, semi-analytic", style.PREDICTION, ":"),
        style.marker_handle(r"bound $\pm f p$, finite elements", style.SIMULATION, "_"),
    )
    _legend(panel, solution, *handles)
    panel.set(xlabel=style.SPEED_LABEL, ylabel=style.TRACTION_LABEL, xlim=(0, _right_end(solution)))
    panel.set_ylim(_traction_limits(predicted))
    return _figure(panel)


@style.styled
def fronts_figure(
    solution: Exact, history: InterfaceHistory, *, axes: Axes | None = None
) -> Figure:
    """Draw a space–time map of the simulated slip rate with predicted fronts and zone edges.

    Colours of slip of one sense scale with its square root, which makes weak zones visible.
    """
    scene, scale, time = solution.scene, slip_rate_scale(solution.scene), history.t[-1]
    length = scene.material.shear_speed * time
    panel = axes or _new_axes(solution)
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
    _figure(panel).colorbar(image, ax=panel, label=style.RATE_LABEL + ", finite elements")
    panel.set(xlabel=style.PLACE_LABEL, ylabel=style.TIME_LABEL, facecolor=style.ink(0.1))
    panel.set(xlim=(0, _right_end(solution)), ylim=(0, 1))
    waves, edges, around = (
        (style.BLACK, style.VIOLET, "white") if signed else ("white", style.ORANGE, style.BLACK)
    )
    speed = scene.material.shear_speed
    style.mark_waves(panel, _fronts(solution), speed, "rays", colour=waves, outlined=around)
    handles = [style.waves_handle(_fronts(solution), waves)]
    lines: tuple[tuple[Iterable[SlipZone | OpenZone], str, style.LineStyle], ...] = (
        (solution.zones, "predicted zone edges", "-"),
        (solution.openings, "predicted ends of the opening", ":"),
    )
    for parts, words, line in lines:
        ends = (edge for part in parts for edge in (part.inner, part.outer))
        for edge in (end for end in ends if 0 < end < np.inf):
            panel.plot(
                [0, edge / speed],
                [0, 1],
                line,
                color=edges,
                linewidth=1.1,
                path_effects=style.outline(around),
            )
        if parts:
            handles.append(style.line_handle(words, edges, line))
    for handle in handles:
        handle.set_path_effects(style.outline(around))
    panel.legend(handles=handles, loc="lower right")
    return _figure(panel)


def _new_axes(solution: Exact) -> Axes:
    return style.describe(style.new_figure(7, 4.7), style.scene_words(solution.scene)).subplots()


def _new_panels(solution: Exact, ratios: tuple[int, ...]) -> tuple[Axes, ...]:
    """Return panels above each other, with these ratios of heights."""
    figure = style.describe(
        style.new_figure(7, 1.9 + 1.9 * len(ratios)), style.scene_words(solution.scene)
    )
    return tuple(figure.subplots(len(ratios), 1, sharex=True, height_ratios=ratios))


def _figure(panel: Axes) -> Figure:
    figure = panel.get_figure(root=True)
    assert figure is not None  # axes in use always belong to a figure
    return figure


def _speed_limit(solution: Exact) -> float:
    return reach(solution, 1.0)[1]


def _right_end(solution: Exact) -> float:
    return _speed_limit(solution) / solution.scene.material.shear_speed


def _fronts(solution: Exact) -> dict[str, float]:
    speeds, limit = contact_fronts(solution.scene), _speed_limit(solution)
    return {name: speed for name, speed in speeds.items() if speed <= limit}


def _speeds(solution: Exact) -> Array:
    """Return similarity velocities [length / time] for smooth curves, without the edge itself."""
    limit = _speed_limit(solution)
    return np.linspace(limit / POINTS, limit, POINTS)


def _parts(solution: Exact) -> list[SlipZone | OpenZone]:
    """Return the slip zones and openings."""
    return [*solution.zones, *solution.openings]


def _zone_kind(zone: SlipZone | OpenZone) -> str:
    if isinstance(zone, OpenZone):
        return "open"
    return kind_of_slip(zone.sense)


def _shade_zones(panel: Axes, solution: Exact) -> None:
    """Shade slip, reverse slip and openings, and the sticking parts between them."""
    limit, unit = _speed_limit(solution), solution.scene.material.shear_speed
    zones = sorted(_parts(solution), key=lambda zone: zone.inner)
    ends = [0.0, *(min(e, limit) for zone in zones for e in (zone.inner, zone.outer)), limit]
    for number, (start, stop) in enumerate(pairwise(ends)):
        kind = _zone_kind(zones[number // 2]) if number % 2 else "stick"
        panel.axvspan(start / unit, stop / unit, color=style.shade(kind), linewidth=0, zorder=0)


def _draw_predicted_tractions(panel: Axes, solution: Exact, time: float) -> Array:
    """Draw predicted shear traction and bound; return the first over τ₀, or the bound if 0."""
    scene, scale = solution.scene, stress_scale(solution.scene)
    dense = _speeds(solution)
    shear = solution.shear_traction(dense * time, time) / scale
    bound = scene.strength(solution.pressure(dense * time, time)) / scale
    position = dense / scene.material.shear_speed
    panel.plot(position, shear, color=style.PREDICTION)
    for sign in (1, -1):
        panel.plot(position, sign * bound, ":", color=style.PREDICTION)
    return shear if shear.any() else np.stack([-bound, bound])


def _traction_limits(shear: Array) -> tuple[float, float]:
    """Return limits that leave out the singularity at the edge."""
    beyond_edge = shear[..., shear.shape[-1] // 20 :]
    lowest, highest = float(beyond_edge.min()), float(beyond_edge.max())
    margin = 0.15 * max(highest - lowest, 1e-3)
    return lowest - margin, highest + margin


def _widen(panel: Axes, least: float) -> None:
    """Widen the limits so that rounding errors do not fill the panel of a stuck interface."""
    lowest, highest = panel.get_ylim()
    panel.set_ylim(min(lowest, -least), max(highest, least))


def _legend(panel: Axes, solution: Exact, *handles: Artist) -> None:
    """Add a legend of these entries and of the shades of the zones."""
    kinds = dict.fromkeys(["stick", *(_zone_kind(zone) for zone in _parts(solution))])
    shades = [Patch(color=style.shade(kind), label=kind) for kind in kinds]
    panel.legend(handles=[*handles, *shades], loc="best")
