"""Appearance of all figures: style, palette, descriptions, scales of axes, wave fronts.

`slipfront.mplstyle` holds settings of taste; a user's own settings take precedence (see `look`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import cache, wraps
from importlib.resources import as_file, files
from itertools import chain
from typing import Any, Literal, ParamSpec

from matplotlib import RcParams, rc_context, rc_params_from_file, rcParams, rcParamsDefault
from matplotlib.axes import Axes
from matplotlib.colors import to_hex, to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patheffects import AbstractPathEffect, withStroke

from compare.comparison.scales import LOWER, WAVE_SYMBOLS, slip_rate_scale, stress_scale
from semianalytic import Scene
from semianalytic.results import plotting

LineStyle = Literal["-", "--", "-.", ":"]
P = ParamSpec("P")

BLACK, ORANGE, SKY, GREEN = "#000000", "#E69F00", "#56B4E9", "#009E73"
YELLOW, BLUE, VERMILLION, PURPLE = "#F0E442", "#0072B2", "#D55E00", "#CC79A7"
"""Colours of the palette of Okabe and Ito, which colour-blind readers can distinguish."""
BROWN, VIOLET = "#7A3B0A", "#7A2FE0"
"""Colours of lines instead of orange and sky blue, which are too light on white."""
PREDICTION, SIMULATION, MARCH = "C0", "C1", "C2"
"""Colours of curves: self-similar answer, finite elements, march."""
STICK_SHADE, SLIP_SHADE = "#efefef", "#cfe5f3"
"""Colours of maps."""
SENSE_COLOURS = {"reverse slip": VERMILLION, "stick": STICK_SHADE, "slip": SKY, "open": YELLOW}
"""Colours of slip senses, in the order of their numbers in maps, from -1 on."""
REGIME_COLOURS = {
    "stuck": STICK_SHADE,
    "slow": SLIP_SHADE,
    "front": "#f6ec9f",
    "two": SKY,
    "one": BLUE,
    "everywhere": "#8fd3bf",
    "reverse": ORANGE,
    "open": PURPLE,
    "failed": BLACK,
}
"""Colours of regimes of slip (`semianalytic.regimes.regime`) in maps."""
SHADES = {**plotting.SHADES, "stick": ("", 0.06)}
"""Shades of zones behind curves: a colour ("" for that of text) and its share in the mixture."""

SYMBOLS = {name: f"${symbol}$" for name, symbol in WAVE_SYMBOLS.items()} | {
    LOWER + name: f"${symbol[:2]}{{{symbol[2:]}2}}$" for name, symbol in WAVE_SYMBOLS.items()
}
PLACE_LABEL, TIME_LABEL = r"$x/(c_t T)$", r"$t/T$"
RATE_LABEL = r"slip rate $/\ V_0$"
GAP_LABEL, PRESSURE_LABEL = r"gap $/\ (V_0 T)$", r"pressure $/\ \tau_0$"
SMALL = "small"
"""Font size of notes, relative to that of text."""


@cache
def style_sheet() -> RcParams:
    """Return slipfront's settings of matplotlib."""
    with as_file(files("compare.figures") / "slipfront.mplstyle") as path:
        return rc_params_from_file(path, use_default_template=False)


@contextmanager
def look() -> Iterator[None]:
    """Apply slipfront's style, except for settings that the user has changed from the defaults."""
    free = {k: v for k, v in style_sheet().items() if rcParams[k] == rcParamsDefault[k]}
    with rc_context(free):
        yield


def styled(draw: Callable[P, Figure]) -> Callable[P, Figure]:
    """Decorate a function that draws a figure, so that it draws in our `look`."""

    @wraps(draw)
    def drawn(*args: P.args, **options: P.kwargs) -> Figure:
        with look():
            figure = draw(*args, **options)
            for line in _lines(figure):  # fix the colour "C0" now; saving may use another cycle
                line.set_color(to_hex(line.get_color()))
        return figure

    return drawn


def _lines(figure: Figure) -> Iterator[Line2D]:
    """Yield the curves of a figure and those of its legends."""
    legends = [*figure.legends, *(key for p in figure.axes if (key := p.get_legend()) is not None)]
    yield from chain(*(panel.lines for panel in figure.axes), *(key.get_lines() for key in legends))


def cycle() -> list[str]:
    """Return the colours of curves without a meaning of their own, in order."""
    return list(rcParams["axes.prop_cycle"].by_key().get("color", [ink()]))


def ink(strength: float = 1.0) -> str:
    """Return the colour of text, faded towards the background; for words and auxiliary lines."""
    return _mixed(rcParams["text.color"], strength)


def shade(kind: str) -> str:
    """Return the colour behind the curves of a kind of zone in `SHADES`."""
    colour, part = SHADES[kind]
    return _mixed(colour or rcParams["text.color"], part)


def _mixed(colour: str, part: float) -> str:
    """Mix a colour into that of the background; `part` is the share of the colour."""
    pairs = zip(to_rgb(colour), to_rgb(rcParams["axes.facecolor"]), strict=True)
    red, green, blue = (part * value + (1 - part) * ground for value, ground in pairs)
    return to_hex((red, green, blue))


def outline(colour: str = "white", width: float = 2.5) -> list[AbstractPathEffect]:
    """Return path effects of a width [points] that make lines and words visible on any map."""
    return [withStroke(linewidth=width, foreground=colour)]


def new_figure(width: float, height: float) -> Figure:
    """Return an empty figure [inch] whose parts do not overlap."""
    return Figure(figsize=(width, height), layout="constrained")


def scene_words(scene: Scene) -> str:
    """Return the description that a figure of one scene carries: its title, and the units of axes
    with their sizes in SI scenes; on a line, where tractions may vary, the title alone.
    """
    title = plotting.scene_title(scene)
    if scene.on_line:
        return title
    factor, pascal = plotting.shown_units(scene, 1.0, 1.0)[-1] if scene.units else (1.0, "")
    sizes = ""
    if scene.units:  # else they are of the scene's own units, in which numbers mean nothing more
        speed = scene.material.shear_speed
        sizes = f" = {slip_rate_scale(scene):.3g} m/s, cₜ = {speed:.4g} m/s"
    stress = f"{stress_scale(scene) * factor:.3g} {pascal}".rstrip()
    return f"{title}; τ₀ = {_unit_name(scene)} = {stress}, V₀ = 2 τ₀ / ρcₜ{sizes}"


def _unit_name(scene: Scene) -> str:
    """Return the name of the traction that `stress_scale` is."""
    for name, part in (("load", scene.superposition.taken_off), ("base", scene.base)):
        if max(abs(part.pressure), abs(part.shear)) > 0:
            larger = "shear" if abs(part.shear) >= abs(part.pressure) else "pressure"
            return f"{larger} of the {name}"
    return "unit"


def describe(figure: Figure, what: Scene | str, height: float | None = None) -> Figure:
    """Add a title to a figure, `scene_words` or other words, and return it.

    Its lower end is at a `height`, from 0 to 1, or where the layout of the figure puts it.
    """
    words = scene_words(what) if isinstance(what, Scene) else what
    side = "top" if height is None else "bottom"
    figure.suptitle(words, y=height, verticalalignment=side, color=ink(0.75), wrap=True)
    return figure


def mark_waves(
    panel: Axes,
    speeds: Mapping[str, float],
    unit: float,
    kind: Literal["vertical", "horizontal", "rays"] = "vertical",
    *,
    labels: bool = True,
    colour: str | None = None,
    outlined: str | None = None,
) -> None:
    """Draw dashed lines for wave fronts, with their symbols, unless `labels` is false, at the rim.

    Lines are vertical at x, horizontal at y, or rays from the origin over x and t, for which the
    limits of the panel must be set before.  The unit turns speeds, by the name of a wave, into
    positions on the axis, or slopes dx/dt of rays; lines that are outlined are visible over a map.
    """
    style: dict[str, Any] = {"color": colour or ink(0.65), "linestyle": "--", "linewidth": 0.8}
    if outlined is not None:
        style |= {"path_effects": outline(outlined, 2.0)}
    sides = {"Rayleigh": "right", "S": "left", "P": "center"}  # c_R and c_t are neighbours
    for name, speed in speeds.items():
        at, side = speed / unit, sides.get(name, "center")
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
    """Return the legend entry of a curve."""
    return Line2D([], [], color=colour, linestyle=style, label=label)


def marker_handle(label: str, colour: str, marker: str = ".", size: float = 6.0) -> Line2D:
    """Return the legend entry of samples; size [points]."""
    return Line2D(
        [], [], color=colour, marker=marker, markersize=size, linestyle="none", label=label
    )


def waves_handle(speeds: Mapping[str, float], colour: str | None = None) -> Line2D:
    """Return the legend entry of the lines that `mark_waves` draws."""
    words = "waves" if len(speeds) > 1 else "wave"
    names = ", ".join(SYMBOLS[name] for name in speeds)
    return line_handle(f"{words} {names}", colour or ink(0.65), "--")


def method_handles() -> list[Line2D]:
    """Return legend entries of a prediction, a line, and of finite elements, samples."""
    return [line_handle("semi-analytic", PREDICTION), marker_handle("finite elements", SIMULATION)]
