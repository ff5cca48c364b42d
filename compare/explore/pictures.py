"""The pictures of the page, drawn once; only their numbers are sent anew."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from bokeh.models import (
    ColorBar,
    ColumnDataSource,
    LinearColorMapper,
    Range1d,
)
from bokeh.palettes import Viridis256
from bokeh.plotting import figure

from compare.explore.maps import REGIMES, RegimeMap
from compare.explore.views import KINDS, FieldView, InterfaceView, SpaceTimeView
from compare.figures.style import (
    BLACK,
    BLUE,
    GREEN,
    PURPLE,
    SENSE_COLOURS,
    STICK_SHADE,
    VERMILLION,
    shade,
)
from compare.studies.regimes.figures import COLOURS

SHADES = {kind: shade(kind) for kind in KINDS}
REGIME_COLOURS = {**COLOURS, "open": PURPLE}
WAVES = {"Rayleigh": "c_R", "S": "c_t", "P": "c_l"}
HEIGHT = 260
WITH_COLOUR_BAR = 1.12
"""Width over height of a picture with equal axes and a bar beside it."""


def _source(*names: str) -> ColumnDataSource:
    return ColumnDataSource({name: [] for name in names})


def _panel(name: str, title: str, x_label: str, y_label: str, height: int = HEIGHT) -> figure:
    """An empty picture as wide as there is room [pixels]."""
    panel = figure(
        name=name,
        title=title,
        height=height,
        sizing_mode="stretch_width",
        tools="pan,box_zoom,wheel_zoom,reset,save",
        active_drag=None,
        toolbar_location="above",
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


def _limit(axis: Range1d, low: float, high: float) -> None:
    axis.update(start=low, end=high, reset_start=low, reset_end=high)


class InterfacePictures:
    """Slip rate, and tractions, along the contact; zones shaded, waves dashed."""

    def __init__(self) -> None:
        at = "x / (c_t T)"
        self.rate = _panel("rate", "Slip rate", at, "slip rate / V₀")
        self.tractions = _panel("tractions", "Tractions", at, "traction / τ₀")
        self._lines = _source("x", "rate", "shear", "upper", "lower", "pressure")
        self._zones = _source("left", "right", "colour")
        self._waves = _source("x")
        for panel in (self.rate, self.tractions):
            panel.quad("left", "right", 1e6, -1e6, source=self._zones, color="colour")
            panel.segment("x", -1e6, "x", 1e6, source=self._waves, color="#595959", line_dash="4 3")
        self.rate.line("x", "rate", source=self._lines, color=BLUE, line_width=2)
        curves = (
            ("shear", "shear traction", BLUE, "solid"),
            ("upper", "± f p", VERMILLION, "dotted"),
            ("lower", "± f p", VERMILLION, "dotted"),
            ("pressure", "pressure p", GREEN, "dashed"),
        )
        for name, words, colour, dash in curves:
            self.tractions.line(
                "x",
                name,
                source=self._lines,
                color=colour,
                line_dash=dash,
                line_width=2,
                legend_label=words,
            )
        legend = self.tractions.legend[0]
        self.tractions.add_layout(legend, "below")
        legend.update(orientation="horizontal", border_line_alpha=0, location="left")
        legend.update(label_text_font_size="8pt", padding=3, spacing=8)

    def draw(self, view: InterfaceView, space_time: SpaceTimeView) -> None:
        """Show what happens along the contact at T."""
        bound = view.bound
        self._lines.data = {
            "x": view.x,
            "rate": np.clip(view.slip_rate, -1e6, 1e6),
            "shear": np.clip(view.shear, -1e6, 1e6),
            "upper": bound,
            "lower": -bound,
            "pressure": view.pressure,
        }
        self._zones.data = {
            "left": [inner for _, inner, _ in space_time.wedges],
            "right": [outer for *_, outer in space_time.wedges],
            "colour": [SHADES[kind] for kind, *_ in space_time.wedges],
        }
        self._waves.data = {"x": list(space_time.waves.values())}
        for panel, limits in (
            (self.rate, view.rate_limits),
            (self.tractions, view.traction_limits),
        ):
            _limit(panel.x_range, 0.0, space_time.reach)
            _limit(panel.y_range, *limits)


class SpaceTimePicture:
    """What slips, sticks and is open over space and time."""

    def __init__(self) -> None:
        self.panel = _panel("zones", "Zones in space and time", "x / (c_t T)", "t / T")
        self.panel.background_fill_color = STICK_SHADE
        self._image = _source("image", "dw")
        mapper = LinearColorMapper(list(SHADES.values()), low=-0.5, high=len(SHADES) - 0.5)
        self.panel.image("image", 0, 0, "dw", 1, source=self._image, color_mapper=mapper)
        self._wedges = _source("xs", "ys", "colour")
        self.panel.patches(
            "xs",
            "ys",
            source=self._wedges,
            color="colour",
            line_color=BLACK,
            line_width=0.7,
        )
        self._waves = _source("xs", "ys")
        self.panel.multi_line("xs", "ys", source=self._waves, color="#595959", line_dash="4 3")
        self._names = _source("x", "name", "side")
        self.panel.text(
            "x",
            0.99,
            "name",
            source=self._names,
            text_align="side",
            text_font_size="8pt",
            text_baseline="top",
        )

    def draw(self, view: SpaceTimeView) -> None:
        """Show wedges, or an image of what was marched."""
        image = [] if view.image is None else [view.image]
        self._image.data = {"image": image, "dw": [view.reach] * len(image)}
        self._wedges.data = {
            "xs": [[0.0, inner, outer] for _, inner, outer in view.wedges],
            "ys": [[0.0, 1.0, 1.0] for _ in view.wedges],
            "colour": [SHADES[kind] for kind, *_ in view.wedges],
        }
        self._waves.data = {
            "xs": [[0.0, at] for at in view.waves.values()],
            "ys": [[0.0, 1.0] for _ in view.waves],
        }
        self._names.data = {
            "x": [at + (-0.05 if name == "Rayleigh" else 0.02) for name, at in view.waves.items()],
            "name": [WAVES[name] for name in view.waves],
            "side": ["right" if name == "Rayleigh" else "left" for name in view.waves],
        }
        _limit(self.panel.x_range, 0.0, view.reach)


class FieldPicture:
    """Particle speed around the contact edge, with its fronts."""

    def __init__(self) -> None:
        self.panel = _panel(
            "field", "Particle speed / V₀ in both bodies", "x / (c_t T)", "y / (c_t T)"
        )
        self.panel.update(height=None, sizing_mode="scale_width", aspect_ratio=WITH_COLOUR_BAR)
        self._image = _source("image", "x", "width")
        self._colours = LinearColorMapper(Viridis256, low=0.0, high=1.0)
        self.panel.image(
            "image", "x", "x", "width", "width", source=self._image, color_mapper=self._colours
        )
        self._fronts, self._parts = _source("xs", "ys"), _source("xs", "ys", "colour")
        self.panel.multi_line("xs", "ys", source=self._fronts, color="white", line_dash="4 3")
        self.panel.segment(-100, 0, 0, 0, color=BLACK, line_width=4)
        self.panel.multi_line("xs", "ys", source=self._parts, color="colour", line_width=4)
        self.panel.add_layout(ColorBar(color_mapper=self._colours, width=10, padding=4), "right")

    def draw(self, view: FieldView) -> None:
        """Show a field."""
        far = view.reach
        self._image.data = {"image": [view.speed], "x": [-far], "width": [2 * far]}
        self._colours.high = view.largest
        self._fronts.data = {
            "xs": [x for x, _ in view.lines],
            "ys": [y for _, y in view.lines],
        }
        self._parts.data = {
            "xs": [[start, end] for _, start, end in view.parts],
            "ys": [[0.0, 0.0] for _ in view.parts],
            "colour": [SENSE_COLOURS[kind] for kind, *_ in view.parts],
        }
        for axis in (self.panel.x_range, self.panel.y_range):
            _limit(axis, -far, far)


class MapPicture:
    """The regime of a scene among those at other Poisson ratios and frictions."""

    def __init__(self) -> None:
        self.panel = _panel("map", "Place among regimes", "friction f", "Poisson ratio ν", 320)
        self._image = _source("image", "x", "y", "width", "height")
        names = list(REGIMES)
        mapper = LinearColorMapper(
            [REGIME_COLOURS[name] for name in names], low=-0.5, high=len(names) - 0.5
        )
        self.panel.image(
            "image", "x", "y", "width", "height", source=self._image, color_mapper=mapper
        )
        self._place = _source("x", "y")
        self.panel.scatter(
            "x",
            "y",
            source=self._place,
            marker="circle_cross",
            size=16,
            fill_color="white",
            line_color=BLACK,
            line_width=2,
        )

    def place(self, friction: float, poisson_ratio: float) -> None:
        """Mark where the scene is."""
        self._place.data = {"x": [friction], "y": [poisson_ratio]}

    def draw(self, drawn: RegimeMap | None) -> Sequence[Mapping[str, str]]:
        """Show a map, or none; returns the names and colours of what is on it."""
        if drawn is None:
            self._image.data = {name: [] for name in self._image.data}
            return []
        (low, high), (least, most) = drawn.friction, drawn.poisson_ratio
        self._image.data = {
            "image": [drawn.image],
            "x": [low],
            "y": [least],
            "width": [high - low],
            "height": [most - least],
        }
        _limit(self.panel.x_range, low, high)
        _limit(self.panel.y_range, least, most)
        names = list(REGIMES)
        present = [names[int(number)] for number in np.unique(drawn.image)]
        return [{"name": REGIMES[name], "colour": REGIME_COLOURS[name]} for name in present]
