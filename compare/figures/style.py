"""How all figures look: one palette, the words on axes, what they are scaled by, wave fronts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from compare.comparison.scales import WAVE_SYMBOLS, stress_scale
from semianalytic import CoulombFriction, Scene

LineStyle = Literal["-", "--", "-.", ":"]

BLACK, ORANGE, SKY, GREEN = "#000000", "#E69F00", "#56B4E9", "#009E73"
YELLOW, BLUE, VERMILLION, PURPLE = "#F0E442", "#0072B2", "#D55E00", "#CC79A7"
"""The palette of Okabe and Ito, told apart by the colour-blind as well."""

CYCLE = (BLUE, VERMILLION, GREEN, ORANGE, PURPLE, SKY, BLACK)
"""Colours of curves that are nothing in particular, in this order."""

PREDICTION, SIMULATION, MARCH, PUBLISHED = BLUE, VERMILLION, GREEN, PURPLE
"""Colours of the self-similar answer, finite elements, a march and the published algorithm."""

STICK_SHADE, SLIP_SHADE, REVERSE_SHADE, OPEN_SHADE = "#efefef", "#cfe5f3", "#f7d5b5", "#f6f0b2"
SENSE_COLOURS = {"reverse slip": VERMILLION, "stick": STICK_SHADE, "slip": SKY, "open": YELLOW}
"""In the order of the numbers that stand for them in maps of senses, from -1 on."""

SYMBOLS = {name: f"${symbol}$" for name, symbol in WAVE_SYMBOLS.items()}
PLACE_LABEL, TIME_LABEL = r"$x/(c_t T)$", r"$t/T$"
SPEED_LABEL = r"$\xi/c_t = x/(c_t t)$"
RATE_LABEL = r"slip rate $/\ V_0$"
PATH_LABEL = r"$\int |V|\,dt\ /\ (V_0 T)$"
GAP_LABEL, PRESSURE_LABEL = r"gap $/\ (V_0 T)$", r"pressure $/\ \tau_0$"
TRACTION_LABEL, WORK_LABEL = r"traction $/\ \tau_0$", r"frictional work $/\ (\tau_0 V_0 T)$"
SMALL = 8
"""Size of legends and notes [points]."""


def new_figure(width: float, height: float) -> Figure:
    """An empty figure [inch] whose parts keep clear of each other."""
    return Figure(figsize=(width, height), layout="constrained")


def scene_words(scene: Scene) -> str:
    """What a figure of one scene must say of it: Poisson ratio, friction, the units of its axes."""
    law = scene.friction_law
    kind = "" if isinstance(law, CoulombFriction) else f" ({type(law).__name__})"
    mode = "antiplane shear,  " if scene.antiplane else ""
    return (
        f"{mode}ν = {scene.material.poisson_ratio:.3g},  f = {scene.friction:.3g}{kind},  "
        f"τ₀ = {_unit_name(scene)} = {stress_scale(scene):.3g},  V₀ = 2 τ₀ / ρcₜ"
    )


def _unit_name(scene: Scene) -> str:
    """Which traction `stress_scale` is."""
    for name, part in (("load", scene.load), ("base", scene.base)):
        if max(abs(part.pressure), abs(part.shear)) > 0:
            larger = "shear" if abs(part.shear) >= abs(part.pressure) else "pressure"
            return f"{larger} of the {name}"
    return "unit"


def describe(figure: Figure, scene: Scene) -> Figure:
    """The figure, with `scene_words` above it."""
    figure.suptitle(scene_words(scene), fontsize=9, color="0.25", wrap=True)
    return figure


def mark_waves(
    panel: Axes,
    speeds: Mapping[str, float],
    unit: float,
    kind: Literal["vertical", "horizontal", "rays"] = "vertical",
    *,
    labels: bool = True,
    colour: str = "0.35",
) -> None:
    """Dashed lines for wave fronts, with their symbols at the rim of the panel.

    Parameters
    ----------
    panel : Axes
        With the limits it is to keep if `kind` is "rays".
    speeds : mapping from name of a wave to its speed [length / time]
    unit : float
        What a speed is divided by to give its place on an axis, or the slope dx/dt of a ray.
    kind : str
        Lines of x, lines of y, or rays from the origin over x and t.
    labels : bool
        Whether to write the symbols.
    colour : str
    """
    style: dict[str, Any] = {"color": colour, "linestyle": "--", "linewidth": 0.8}
    sides = {"Rayleigh": "right", "S": "left", "P": "center"}  # c_R and c_t are neighbours
    for name, speed in speeds.items():
        at, side = speed / unit, sides[name]
        if kind == "vertical":
            panel.axvline(at, zorder=1, **style)
            place = (at, 1.0), panel.get_xaxis_transform(), (0, 2), side, "bottom"
        elif kind == "horizontal":
            panel.axhline(at, zorder=1, **style)
            below = "top" if name == "Rayleigh" else "bottom"
            place = (1.0, at), panel.get_yaxis_transform(), (3, 0), "left", below
        else:
            panel.plot([0, at], [0, 1], **style)
            right, top = panel.get_xlim()[1], panel.get_ylim()[1]
            if at * top <= right:
                place = (at * top, top), panel.transData, (0, 2), side, "bottom"
            else:
                place = (right, right / at), panel.transData, (2, 0), "left", "center"
        if labels:
            where, coordinates, offset, across, along = place
            panel.annotate(
                SYMBOLS[name],
                where,
                offset,
                xycoords=coordinates,
                textcoords="offset points",
                ha=across,
                va=along,
                fontsize=SMALL,
            )


def line_handle(label: str, colour: str, style: LineStyle = "-") -> Line2D:
    """Legend entry of a curve."""
    return Line2D([], [], color=colour, linestyle=style, label=label)


def marker_handle(label: str, colour: str, marker: str = ".", size: float = 6.0) -> Line2D:
    """Legend entry of samples; size [points]."""
    return Line2D(
        [], [], color=colour, marker=marker, markersize=size, linestyle="none", label=label
    )


def waves_handle(speeds: Mapping[str, float], colour: str = "0.35") -> Line2D:
    """Legend entry of what `mark_waves` draws."""
    words = "waves" if len(speeds) > 1 else "wave"
    return line_handle(f"{words} {', '.join(SYMBOLS[name] for name in speeds)}", colour, "--")


def method_handles() -> list[Line2D]:
    """Legend entries of a prediction, drawn by a line, and of finite elements, by samples."""
    return [line_handle("semi-analytic", PREDICTION), marker_handle("finite elements", SIMULATION)]
