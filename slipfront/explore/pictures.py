"""The pictures of the page; they are created once, after which only their numbers are sent.

Changes are collected on a `Board` and sent in one message.  Glyphs are added as such, since methods
of Bokeh's figures such as `line` and `image` make three of each, for those not selected and muted
too.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from bokeh.models import (
    ColorBar,
    ColumnDataSource,
    HoverTool,
    Image,
    LabelSet,
    Line,
    LinearColorMapper,
    MultiLine,
    Patches,
    Quad,
    Range1d,
    Scatter,
    Segment,
    Text,
)
from bokeh.palettes import Viridis256
from bokeh.plotting import figure

from compare.comparison.scales import LOWER, WAVE_SYMBOLS
from compare.figures import style
from semianalytic.scene.arrays import Array
from slipfront.explore.board import Board
from slipfront.explore.maps import REGIMES, RegimeMap
from slipfront.explore.views import KINDS, FieldView, InterfaceView, SpaceTimeView

SHADES = {kind: style.shade(kind) for kind in KINDS}
WAVES = WAVE_SYMBOLS | {f"{LOWER}{name}": f"{symbol}2" for name, symbol in WAVE_SYMBOLS.items()}
"""Symbols of wave fronts; c_t2 and c_l2 are those of a different lower body."""
CURVES = {
    "shear traction": (style.BLUE, "solid"),
    "± f p": (style.VERMILLION, "dotted"),
    "pressure p": (style.GREEN, "dashed"),
}
"""Colours and dashes of tractions."""
GREY = "#595959"
"""Colour of wave fronts on white."""
HEIGHT = 260
SMALL = {"text_font_size": "8pt"}
WITH_COLOUR_BAR = 1.12
"""Width over height of a picture with equal axes and a colour bar."""


def _tell_values(panel: figure, renderer: Any, mode: str = "mouse", **shown: str) -> None:
    """Show values next to the pointer: what each is called, and the column that holds it."""
    tips = [(name.replace("_", " "), column) for name, column in shown.items()]
    panel.add_tools(HoverTool(renderers=[renderer], tooltips=tips, mode=mode))


def _source(*names: str) -> ColumnDataSource:
    return ColumnDataSource({name: [] for name in names})


def _panel(name: str, x_label: str, y_label: str, *, square: bool = False) -> figure:
    """Return an empty picture as wide as its place on the page, or with nearly equal sides."""
    panel = figure(
        name=name,
        height=None if square else HEIGHT,
        sizing_mode="scale_width" if square else "stretch_width",
        aspect_ratio=WITH_COLOUR_BAR if square else None,
        tools="pan,box_zoom,wheel_zoom,reset,save",
        active_drag=None,
        toolbar_location="above",
        toolbar_inner=True,
        x_range=Range1d(0, 1),
        y_range=Range1d(0, 1),
        x_axis_label=x_label,
        y_axis_label=y_label,
        output_backend="canvas",
    )
    panel.toolbar.logo = None
    panel.toolbar.autohide = True
    panel.grid.visible = False
    panel.min_width = 240
    return panel


def _column(values: Array, span: float = 1.0) -> list[float | None]:
    """Round numbers to 1e-5 of an axis's span and clip them far outside it; nan becomes None."""
    digits = 5 - math.floor(math.log10(span)) if span > 0 else 5
    clipped = np.clip(values, -1e3 * span, 1e3 * span).round(digits)
    found: list[float | None] = clipped.tolist()
    return found if np.isfinite(clipped).all() else [v if v == v else None for v in found]


class InterfacePictures:
    """Slip rate and tractions along the contact, with shaded zones and dashed wave fronts."""

    def __init__(self, board: Board) -> None:
        self._board = board
        at = "x / (c_t T)"
        self.rate = _panel("rate", at, "slip rate / V₀")
        self.tractions = _panel("tractions", at, "traction / τ₀")
        self.slip = _panel("slip", at, "slip / (V₀ T)")
        self._lines = _source("x", "rate", "slip", "shear", "upper", "lower", "pressure")
        self._zones = _source("left", "right", "colour")
        self._waves = _source("x", "name", "side", "offset")
        for panel in (self.rate, self.tractions, self.slip):
            zone = Quad(left="left", right="right", top=1e6, bottom=-1e6)
            zone.update(fill_color="colour", line_color="colour")
            panel.add_glyph(self._zones, zone)
            front = Segment(x0="x", y0=-1e6, x1="x", y1=1e6, line_color=GREY, line_dash="4 3")
            panel.add_glyph(self._waves, front)
            names = LabelSet(x="x", y=1, y_units="screen", text="name", source=self._waves)
            names.update(text_align="side", x_offset="offset", **SMALL, text_color="#404040")
            panel.add_layout(names)
        rate, slip = (
            panel.add_glyph(self._lines, Line(x="x", y=name, line_color=style.BLUE, line_width=2))
            for panel, name in ((self.rate, "rate"), (self.slip, "slip"))
        )
        place = "@x{0.0000}"
        _tell_values(self.rate, rate, "vline", x=place, slip_rate="@rate{0.0000}")
        _tell_values(self.slip, slip, "vline", x=place, slip="@slip{0.0000}")
        for name, colour, dash in (
            ("shear", *CURVES["shear traction"]),
            ("upper", *CURVES["± f p"]),
            ("lower", *CURVES["± f p"]),
            ("pressure", *CURVES["pressure p"]),
        ):
            curve = Line(x="x", y=name, line_color=colour, line_dash=dash, line_width=2)
            line = self.tractions.add_glyph(self._lines, curve)
            if name == "shear":
                bound, pressed = "@upper{0.0000}", "@pressure{0.0000}"
                told = {"shear_traction": "@shear{0.0000}", "f_p": bound, "pressure": pressed}
                _tell_values(self.tractions, line, "vline", x=place, **told)

    def draw(self, view: InterfaceView, space_time: SpaceTimeView, share: float = 1.0) -> None:
        """Show the state of the contact at one time."""
        board, rates, tractions = self._board, view.rate_limits, view.traction_limits
        span = tractions[1] - tractions[0]
        bound = _column(view.bound, span)
        board.fill(
            self._lines,
            x=_column(view.x),
            rate=_column(view.slip_rate, rates[1] - rates[0]),
            slip=_column(view.slip, view.slip_limits[1] - view.slip_limits[0]),
            shear=_column(view.shear, span),
            upper=bound,
            lower=[None if value is None else -value for value in bound],
            pressure=_column(view.pressure, span),
        )
        board.fill(
            self._zones,
            left=[share * inner for _, inner, _ in space_time.wedges],
            right=[min(share * outer, space_time.reach) for *_, outer in space_time.wedges],
            colour=[SHADES[kind] for kind, *_ in space_time.wedges],
        )
        before = _labelled_before(space_time.waves)
        board.fill(
            self._waves,
            x=[share * at for at in space_time.waves.values()],
            name=[WAVES[name] for name in space_time.waves],
            side=["right" if name in before else "left" for name in space_time.waves],
            offset=[-3 if name in before else 3 for name in space_time.waves],
        )
        drawn = ((self.rate, rates), (self.tractions, tractions), (self.slip, view.slip_limits))
        for panel, limits in drawn:
            board.limit(panel.x_range, 0.0, space_time.reach)
            board.follow(panel.y_range, *limits)


class SpaceTimePicture:
    """Slip, stick and open parts of the contact over space and time."""

    def __init__(self, board: Board) -> None:
        self._board = board
        self.panel = _panel("zones", "x / (c_t T)", "t / T", square=True)
        self.panel.background_fill_color = style.STICK_SHADE
        self._image = _source("image", "dw")
        mapper = LinearColorMapper(list(SHADES.values()), low=-0.5, high=len(SHADES) - 0.5)
        marched = Image(image="image", x=0, y=0, dw="dw", dh=1, color_mapper=mapper)
        self.panel.add_glyph(self._image, marched)
        self._wedges = _source("xs", "ys", "colour", "kind")
        shapes = Patches(
            xs="xs", ys="ys", fill_color="colour", line_color=style.BLACK, line_width=0.7
        )
        wedges = self.panel.add_glyph(self._wedges, shapes)
        _tell_values(self.panel, wedges, state="@kind", x="$x{0.0000}", t="$y{0.0000}")
        self._waves, self._time = _source("xs", "ys"), _source("y")
        fronts = MultiLine(xs="xs", ys="ys", line_color=GREY, line_dash="4 3")
        self.panel.add_glyph(self._waves, fronts)
        moment = Segment(x0=0, y0="y", x1=1e3, y1="y", line_color=style.BLACK, line_width=1.5)
        self.panel.add_glyph(self._time, moment)
        self._names = _source("x", "name", "side")
        names = Text(x="x", y=0.99, text="name", text_align="side", text_baseline="top")
        names.update(text_color=style.BLACK, **SMALL)
        self.panel.add_glyph(self._names, names)

    def mark(self, share: float) -> None:
        """Draw a line at the time that the other pictures show."""
        self._board.fill(self._time, y=[share] if share < 1 else [])

    def draw(self, view: SpaceTimeView) -> None:
        """Show wedges for a self-similar answer, an image for a march."""
        board, image = self._board, [] if view.image is None else [view.image]
        if image or len(self._image.data["image"]):
            self._image.data = {"image": image, "dw": [view.reach] * len(image)}
        shapes = [_wedge(inner, outer, view.reach) for _, inner, outer in view.wedges]
        board.fill(
            self._wedges,
            xs=[x for x, _ in shapes],
            ys=[y for _, y in shapes],
            colour=[SHADES[kind] for kind, *_ in view.wedges],
            kind=[kind for kind, *_ in view.wedges],
        )
        rays = [[0.0, at] for at in view.waves.values()]
        board.fill(self._waves, xs=rays, ys=[[0.0, 1.0] for _ in rays])
        before = _labelled_before(view.waves)
        board.fill(
            self._names,
            x=[at + (-0.05 if name in before else 0.02) for name, at in view.waves.items()],
            name=[WAVES[name] for name in view.waves],
            side=["right" if name in before else "left" for name in view.waves],
        )
        board.limit(self.panel.x_range, 0.0, view.reach)


def _labelled_before(waves: Mapping[str, float]) -> set[str]:
    """Return the waves whose labels stand before their lines, or a narrow axis cuts them off."""
    return {"Rayleigh", max(waves, key=lambda name: waves[name])}


def _wedge(inner: float, outer: float, reach: float) -> tuple[list[float], list[float]]:
    """Return corners of the area between two edges until T; beyond the inner one if infinite."""
    if math.isinf(outer):
        return [0.0, inner, reach, reach], [0.0, 1.0, 1.0, 0.0]
    return [0.0, inner, outer], [0.0, 1.0, 1.0]


class EdgePicture:
    """Particle speed around the contact edge, with wave fronts."""

    def __init__(self, board: Board) -> None:
        self._board = board
        self.panel = _panel("field", "x / (c_t T)", "y / (c_t T)", square=True)
        self._image = _source("image", "x", "width")
        self._colours = LinearColorMapper(Viridis256, low=0.0, high=1.0)
        place = {"x": "x", "y": "x", "dw": "width", "dh": "width"}
        speed = Image(image="image", **place, color_mapper=self._colours)
        drawn = self.panel.add_glyph(self._image, speed)
        _tell_values(self.panel, drawn, value="@image{0.0000}", x="$x{0.000}", y="$y{0.000}")
        self._names = _source("x", "y", "name")
        self._fronts, self._parts = _source("xs", "ys"), _source("xs", "ys", "colour")
        fronts = MultiLine(xs="xs", ys="ys", line_color="white", line_dash="4 3")
        self.panel.add_glyph(self._fronts, fronts)
        slot = Segment(x0=-100, y0=0, x1=0, y1=0, line_color=style.BLACK, line_width=4)
        self.panel.add_glyph(slot)
        parts = MultiLine(xs="xs", ys="ys", line_color="colour", line_width=4)
        self.panel.add_glyph(self._parts, parts)
        self.panel.add_layout(ColorBar(color_mapper=self._colours, width=10, padding=4), "right")
        names = Text(x="x", y="y", text="name", text_color="white", **SMALL)
        self.panel.add_glyph(self._names, names)

    def draw(self, view: FieldView) -> None:
        """Show a field."""
        board, far = self._board, view.reach
        self._image.data = {"image": [view.size], "x": [-far], "width": [2 * far]}
        board.set(self._colours, high=view.largest)
        names, xs, ys = zip(*view.names, strict=True) if view.names else ((), (), ())
        named = [WAVES.get(name, name) for name in names]
        board.fill(self._names, x=list(xs), y=list(ys), name=named)
        along, across = ([_column(line[at]) for line in view.lines] for at in (0, 1))
        board.fill(self._fronts, xs=along, ys=across)
        board.fill(
            self._parts,
            xs=[[start, end] for _, start, end in view.parts],
            ys=[[0.0, 0.0] for _ in view.parts],
            colour=[style.SENSE_COLOURS[kind] for kind, *_ in view.parts],
        )
        for axis in (self.panel.x_range, self.panel.y_range):
            board.limit(axis, -far, far)


class MapPicture:
    """Map of regimes over Poisson ratio and friction, with the position of the scene."""

    def __init__(self, board: Board) -> None:
        self._board = board
        self.panel = _panel("map", "friction f", "Poisson ratio ν", square=True)
        self._image = _source("image", "x", "y", "width", "height")
        names = list(REGIMES)
        mapper = LinearColorMapper(
            [style.REGIME_COLOURS[name] for name in names], low=-0.5, high=len(names) - 0.5
        )
        regimes = Image(image="image", x="x", y="y", dw="width", dh="height", color_mapper=mapper)
        drawn = self.panel.add_glyph(self._image, regimes)
        _tell_values(self.panel, drawn, friction="$x{0.000}", Poisson_ratio="$y{0.000}")
        self._place = _source("x", "y")
        here = Scatter(x="x", y="y", marker="circle_cross", size=16, fill_color="white")
        here.update(line_color=style.BLACK, line_width=2)
        self.panel.add_glyph(self._place, here)

    def place(self, friction: float, poisson_ratio: float) -> None:
        """Mark the position of the scene."""
        self._board.fill(self._place, x=[friction], y=[poisson_ratio])

    def draw(self, drawn: RegimeMap | None) -> Sequence[Mapping[str, str]]:
        """Show a map, or none, and return names and colours of the regimes on it."""
        if drawn is None:
            self._image.data = {name: [] for name in self._image.data}
            return []
        (low, high), (least, most) = drawn.friction, drawn.poisson_ratio
        sizes = {"width": [high - low], "height": [most - least]}
        self._image.data = {"image": [drawn.image], "x": [low], "y": [least], **sizes}
        self._board.limit(self.panel.x_range, low, high)
        self._board.limit(self.panel.y_range, least, most)
        names = list(REGIMES)
        present = [names[int(number)] for number in np.unique(drawn.image)]
        return [{"name": REGIMES[name], "colour": style.REGIME_COLOURS[name]} for name in present]
