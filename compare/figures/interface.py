"""Figures: slip rate, tractions and the space–time map, prediction against simulation.

Every function returns a Figure.  Pass `axes` to draw into axes of a figure of your own.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from io import BytesIO
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backend_bases import FigureCanvasBase
from matplotlib.colors import Normalize, PowerNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray
from PIL import Image

from compare.comparison.scales import slip_rate_scale, stress_scale, wave_speeds
from semianalytic import Scene, SlipZone, Solution
from semianalytic.results.files import write_bytes
from semianalytic.results.interface_history import InterfaceHistory
from semianalytic.scene.errors import SceneError

Array = NDArray[np.float64]

PREDICTION = "#12355b"
SIMULATION = "#d1495b"
ZONE_COLOURS = {"slip": "#cfe3f4", "stick": "#efefef", "reverse slip": "#f8d3c5"}
SYMBOLS = {"Rayleigh": r"$c_R$", "S": r"$c_t$", "P": r"$c_l$"}
SPEED_LABEL = r"$\xi/c_t = x/(c_t t)$"
RATE_LABEL = r"slip rate $\times\ \rho c_t/2\tau_0$"
POINTS = 1500


def slip_rate_figure(
    solution: Solution, history: InterfaceHistory, *, axes: tuple[Axes, Axes] | None = None
) -> Figure:
    """Slip rate against ξ/c_t at the last time of the history, with the difference below.

    Parameters
    ----------
    solution : Solution
        The prediction.
    history : InterfaceHistory
        The simulation of the same scene.
    axes : (Axes, Axes), optional
        Where to draw the two answers and their difference.
    """
    scene, scale, time = solution.scene, slip_rate_scale(solution.scene), history.t[-1]
    upper, lower = axes or _new_pair()
    velocity, shear_speed = history.x / time, scene.material.shear_speed
    shown = (history.x > 0) & (velocity <= _speed_limit(scene))
    dense = _speeds(scene)

    _shade_zones(upper, solution.zones, scene)
    upper.plot(
        dense / shear_speed,
        solution.slip_rate(dense * time, time) / scale,
        color=PREDICTION,
        label="semi-analytic",
    )
    upper.plot(
        velocity[shown] / shear_speed,
        history.slip_rate[-1, shown] / scale,
        ".",
        color=SIMULATION,
        markersize=3,
        label="finite elements",
    )
    predicted = solution.slip_rate(history.x[shown], time)
    lower.plot(
        velocity[shown] / shear_speed,
        (history.slip_rate[-1, shown] - predicted) / scale,
        color=SIMULATION,
        linewidth=1,
    )
    lower.axhline(0, color=PREDICTION, linewidth=0.8)
    for panel in (upper, lower):
        _mark_fronts(panel, scene, label=panel is upper)
    if not solution.zones:
        _widen(upper, 0.1)
        _widen(lower, 0.01)
    upper.set_ylabel(RATE_LABEL)
    upper.legend(
        handles=[*method_handles(), *_zone_handles(solution.zones)], loc="best", fontsize=8
    )
    lower.set(xlabel=SPEED_LABEL, ylabel="difference", xlim=(0, dense[-1] / shear_speed))
    return _figure(upper)


def tractions_figure(
    solution: Solution, history: InterfaceHistory, *, axes: Axes | None = None
) -> Figure:
    """Shear traction and friction bound ±f p against ξ/c_t at the last time of the history.

    Parameters
    ----------
    solution : Solution
        The prediction.
    history : InterfaceHistory
        The simulation of the same scene.
    axes : Axes, optional
        Where to draw.
    """
    scene, scale, time = solution.scene, stress_scale(solution.scene), history.t[-1]
    panel = axes or _new_axes()
    velocity = history.x / time
    shown = (velocity <= _speed_limit(scene)) & (history.x > 0)
    _shade_zones(panel, solution.zones, scene)
    shear = _draw_predicted_tractions(panel, solution, time)
    position = velocity[shown] / scene.material.shear_speed
    style: dict[str, Any] = {"color": SIMULATION, "markersize": 3, "linestyle": "none"}
    panel.plot(position, history.shear_traction[-1, shown] / scale, marker=".", **style)
    bound = scene.friction * history.pressure[-1, shown] / scale
    for sign in (1, -1):
        panel.plot(position, sign * bound, marker="_", alpha=0.6, **style)
    _mark_fronts(panel, scene)
    handles = [
        Line2D([], [], color=PREDICTION, label="shear traction, semi-analytic"),
        Line2D([], [], marker=".", label="shear traction, finite elements", **style),
        Line2D([], [], color=PREDICTION, linestyle=":", label=r"bound $\pm f p$, semi-analytic"),
        Line2D([], [], marker="_", label=r"bound $\pm f p$, finite elements", **style),
    ]
    panel.legend(handles=[*handles, *_zone_handles(solution.zones)], loc="best", fontsize=8)
    panel.set(xlabel=SPEED_LABEL, ylabel=r"traction $/\ \tau_0$", xlim=(0, _right_end(scene)))
    panel.set_ylim(_traction_limits(shear))
    return _figure(panel)


def fronts_figure(
    solution: Solution, history: InterfaceHistory, *, axes: Axes | None = None
) -> Figure:
    """Space–time map of the simulated slip rate under the predicted fronts and zone edges.

    Slip of one sense is coloured by its square root, so that weak zones show.

    Parameters
    ----------
    solution : Solution
        The prediction, drawn as straight lines x = speed × t.
    history : InterfaceHistory
        The simulation of the same scene, at least two times and two positions.
    axes : Axes, optional
        Where to draw.
    """
    scene, scale, time = solution.scene, slip_rate_scale(solution.scene), history.t[-1]
    length = scene.material.shear_speed * time
    panel = axes or _new_axes()
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
    right = _right_end(scene)
    line_colour = "black" if signed else "white"
    for name, speed in wave_speeds(scene.material).items():
        slope = speed / scene.material.shear_speed
        panel.plot([0, slope], [0, 1], "--", color=line_colour, linewidth=0.9)
        panel.annotate(
            SYMBOLS[name], (slope, 1), (0, 3), textcoords="offset points", ha="center", va="bottom"
        )
    for edge in _finite_edges(solution.zones):
        slope = edge / scene.material.shear_speed
        panel.plot([0, slope], [0, 1], "-", color=SIMULATION, linewidth=1.1)
    handles = [Line2D([], [], color=line_colour, linestyle="--", label="predicted wave fronts")]
    if solution.zones:
        handles.append(Line2D([], [], color=SIMULATION, label="predicted zone edges"))
    panel.legend(handles=handles, loc="lower right", fontsize=8, facecolor="0.6")
    panel.set(xlabel=r"$x/(c_t T)$", ylabel=r"$t/T$", xlim=(0, right), ylim=(0, 1), facecolor="0.9")
    return _figure(panel)


def prediction_figure(solution: Solution, *, axes: tuple[Axes, Axes] | None = None) -> Figure:
    """The semi-analytic answer alone: slip rate above, tractions and friction bound below.

    Parameters
    ----------
    solution : Solution
        The prediction.
    axes : (Axes, Axes), optional
        Where to draw slip rate and tractions.
    """
    scene = solution.scene
    upper, lower = axes or _new_pair(ratios=(1, 1))
    dense = _speeds(scene)
    for panel in (upper, lower):
        _shade_zones(panel, solution.zones, scene)
        _mark_fronts(panel, scene, label=panel is upper)
    upper.plot(
        dense / scene.material.shear_speed,
        solution.slip_rate(dense, 1.0) / slip_rate_scale(scene),
        color=PREDICTION,
    )
    upper.set_ylabel(RATE_LABEL)
    upper.legend(handles=_zone_handles(solution.zones), loc="best", fontsize=8)
    shear = _draw_predicted_tractions(lower, solution, 1.0)
    handles = [
        Line2D([], [], color=PREDICTION, label="shear traction"),
        Line2D([], [], color=PREDICTION, linestyle=":", label=r"bound $\pm f p$"),
    ]
    lower.legend(handles=handles, loc="best", fontsize=8)
    lower.set(xlabel=SPEED_LABEL, ylabel=r"traction $/\ \tau_0$", xlim=(0, _right_end(scene)))
    lower.set_ylim(_traction_limits(shear))
    return _figure(upper)


def figure_format(path: str | Path) -> str:
    """The format that the name of a figure asks for.

    Raises
    ------
    SceneError
        If matplotlib knows no such format.
    """
    path = Path(path)
    form = path.suffix.removeprefix(".").lower()
    if form not in FigureCanvasBase.get_supported_filetypes():
        raise SceneError(
            f"Figures cannot be written as {path.name!r}; end the name in .png, .pdf or .svg."
        )
    return form


def save_figure(figure: Figure, path: str | Path) -> None:
    """Write a figure in the format its name asks for, whole or not at all.

    Raises
    ------
    SceneError
        If matplotlib knows no such format.
    DataFileError
        If the file cannot be written.
    """
    drawn = BytesIO()
    figure.savefig(drawn, format=figure_format(path), dpi=200)
    write_bytes(path, drawn.getbuffer())


def figure_png(figure: Figure, dpi: int = 110, colours: int = 256) -> bytes:
    """A figure as PNG of few colours, which takes a third of the space."""
    drawn, packed = BytesIO(), BytesIO()
    figure.savefig(drawn, format="png", dpi=dpi)
    picture = Image.open(drawn).convert("RGB")
    picture.quantize(colours, dither=Image.Dither.NONE).save(packed, format="png", optimize=True)
    return packed.getvalue()


def _new_axes() -> Axes:
    return Figure(figsize=(7, 4.5), layout="constrained").subplots()


def _new_pair(ratios: tuple[int, int] = (3, 1)) -> tuple[Axes, Axes]:
    figure = Figure(figsize=(7, 5.5), layout="constrained")
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


def _mark_fronts(panel: Axes, scene: Scene, *, label: bool = True) -> None:
    for name, speed in wave_speeds(scene.material).items():
        position = speed / scene.material.shear_speed
        panel.axvline(position, color="0.35", linestyle="--", linewidth=0.8, zorder=1)
        if label:
            panel.annotate(
                SYMBOLS[name],
                (position, 1),
                (0, 2),
                xycoords=panel.get_xaxis_transform(),
                textcoords="offset points",
                ha="center",
                va="bottom",
            )


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


def method_handles() -> list[Line2D]:
    """Legend entries of the two answers."""
    return [
        Line2D([], [], color=PREDICTION, label="semi-analytic"),
        Line2D([], [], color=SIMULATION, marker=".", linestyle="none", label="finite elements"),
    ]


def _zone_handles(zones: tuple[SlipZone, ...]) -> list[Patch]:
    kinds = dict.fromkeys(["stick", *(_zone_kind(zone) for zone in zones)])
    return [Patch(color=ZONE_COLOURS[kind], label=kind) for kind in kinds]
