"""Pictures of whole fields, with wave fronts and moving parts of the interface, and of records."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.lines import Line2D
from matplotlib.text import Annotation

from compare.comparison.scales import scene_fronts
from compare.figures.fronts import Front, Moving, Window, fronts, moving_parts
from compare.figures.quantities import Quantity
from compare.figures.style import (
    BLACK,
    ORANGE,
    SENSE_COLOURS,
    SMALL,
    cycle,
    describe,
    ink,
    line_handle,
    look,
    mark_waves,
    marker_handle,
    new_figure,
    outline,
    scene_words,
    styled,
)
from compare.output.field_files import FieldRecord, Fields
from semianalytic import Scene
from semianalytic.scene.arrays import Array
from semianalytic.scene.units import unit

SHOWN = 0.995
"""Fraction of the points whose values are within the range of colours."""
WIDE = 4.0
"""Height of a picture [inch] below which its colour bar is placed under it."""
NAME_SIZE = (0.12, 0.04)
"""Room of the name of a front, over the width and the height of a panel."""
NAME_SHIFTS = (0.0, 0.06, -0.06, 0.12, -0.12)
"""Places of a name along its front, over its length, from the one it asks for."""
BEYOND = {"size": "max", "sign": "both", "light": "neither"}
"""Ends of the colour bar of each kind of quantity beyond which values lie."""
COLOURS = {"size": "viridis", "sign": "RdBu_r", "light": "gray"}
INK = {"size": ("white", "#333333"), "sign": ("#333333", "white"), "light": (ORANGE, "#333333")}
"""Colour of the fronts over each kind of quantity, and of their outline."""
_AXES = ("xx", "yy", "xy", "xz", "yz")


class FieldPicture:
    """A picture of a field that can be moved to another time, with the same colours.

    Parameters
    ----------
    fields : Fields
    quantity : Quantity
        Quantity to draw, from `find_quantity`.
    window : (x0, x1, y0, y1)
        Part of the plane to draw [length]; `reach` gives everything the waves have reached.
    points : int
        Number of points along the longer side of the window; the spacing is the same along the
        shorter one.
    time : float
        Time shown first, whose values determine the range of colours [time].
    """

    @look()
    def __init__(
        self, fields: Fields, quantity: Quantity, window: Window, points: int, time: float
    ) -> None:
        self.fields, self.quantity, self.window = fields, quantity, window
        self._x, self._y = _middles(window, points)
        tall = 6.2 * (window[3] - window[2]) / (window[1] - window[0])
        self.figure = new_figure(
            8.0, float(np.clip(tall, 1.5, 9.0)) + (1.0 if tall > WIDE else 1.8)
        )
        self.figure.set_layout_engine("compressed")
        self.panel: Axes = self.figure.subplots()
        self._height: float | None = None  # of the title, which the layout is to find
        values = self._values(time)
        rest = float(quantity.at(fields, np.ones(1), np.ones(1), 0.0)[0])  # in the initial state
        self._norm = Normalize(*_range(values, quantity, rest))
        image = self._draw(values, time)
        self.figure.colorbar(
            image,
            ax=self.panel,
            label=quantity.labelled(fields.scene),
            location="right" if tall > WIDE else "bottom",
            shrink=0.9,
            aspect=20 if tall > WIDE else 40,
            extend=BEYOND[quantity.kind],
        )
        layout = self.figure.get_layout_engine()
        assert layout is not None
        for _ in range(2):  # the sizes of labels are known only at the second time
            layout.execute(self.figure)
        self.figure.set_layout_engine("none")  # the layout stays fixed for all times
        self._height = self.figure.texts[0].get_position()[1]

    @look()
    def show(self, time: float) -> None:
        """Draw the field at another time [time]."""
        self.panel.clear()
        self.figure.legends.clear()
        self._draw(self._values(time), time)

    def _values(self, time: float) -> Array:
        x, y = np.meshgrid(self._x, self._y)
        return self.quantity.at(self.fields, x.ravel(), y.ravel(), time).reshape(x.shape)

    def _draw(self, values: Array, time: float) -> AxesImage:
        panel, scene = self.panel, self.fields.scene
        image = panel.imshow(
            np.clip(values, self._norm.vmin, self._norm.vmax),  # clips infinite values too
            extent=self.window,
            origin="lower",
            norm=self._norm,
            cmap=COLOURS[self.quantity.kind],
            interpolation="nearest",
        )
        for front in fronts(self.fields, time):
            draw_front(panel, front, self.window, *INK[self.quantity.kind])
        handles = draw_interface(panel, self.fields, time)
        self.figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))
        length = unit("length", scene.units)
        panel.set(xlabel=f"x [{length}]", ylabel=f"y [{length}]")
        panel.set(xlim=self.window[:2], ylim=self.window[2:])
        moment = f"t = {time:.4g} {unit('time', scene.units) if scene.units else ''}"
        describe(self.figure, f"{scene_words(self.fields.scene)},  {moment}", self._height)
        return image


def _rayleigh_fronts(fields: Fields, parts: list[Moving], time: float) -> list[float]:
    """Return the places of Rayleigh fronts: on the slot, and where slip or opening covers one.

    Between different bodies that slip there is no such wave.
    """
    if fields.scene.on_line:
        return []
    if fields.scene.lower_material is not None:
        return [-body.rayleigh_speed * time for body in fields.scene.bodies]
    speeds = scene_fronts(fields.scene)
    if "Rayleigh" not in speeds:
        return []
    place = speeds["Rayleigh"] * time
    return [-place, *([place] if any(part.covers(place) for part in parts) else [])]


def _middles(window: Window, points: int) -> tuple[Array, Array]:
    """Return the centres of square cells that fill a window: x (n,) and y (m,)."""
    x0, x1, y0, y1 = window
    size = max(x1 - x0, y1 - y0) / points

    def along(low: float, high: float) -> Array:
        count = max(1, round((high - low) / size))
        return np.asarray(low + (np.arange(count) + 0.5) * (high - low) / count)

    return along(x0, x1), along(y0, y1)


def _range(values: Array, quantity: Quantity, rest: float) -> tuple[float, float]:
    """Return the range of the colours; the few values beyond it have the colours of its ends."""
    if quantity.kind == "light":
        return 0.0, 1.0
    finite = values[np.isfinite(values)]
    if quantity.kind == "size":
        return 0.0, float(np.quantile(finite, SHOWN)) or 1.0
    away = float(np.quantile(np.abs(finite - rest), SHOWN)) or 1.0
    return rest - away, rest + away


def _name_at(panel: Axes, front: Front, window: Window) -> tuple[float, float] | None:
    """Return where the name of a front is seen, clear of others: at its place or near it."""
    x0, x1, y0, y1 = window
    taken = [text.xy for text in panel.texts if isinstance(text, Annotation)]
    wanted = None
    for shift in NAME_SHIFTS if front.share else (0.0,):
        at = int(np.clip((front.share + shift) * len(front.x), 0, len(front.x) - 1))
        x, y = float(front.x[at]), float(front.sides[0] * front.y[at])
        if x0 < x < x1 and y0 <= y <= y1:
            wide, high = NAME_SIZE[0] * (x1 - x0), NAME_SIZE[1] * (y1 - y0)
            if all(abs(x - a) > wide or abs(y - b) > high for a, b in taken):
                return x, y
            wanted = (x, y) if shift == 0 else wanted
    return wanted


def draw_front(panel: Axes, front: Front, window: Window, colour: str, around: str) -> None:
    """Draw a front and its mirror image, with its name if the upper one is visible."""
    line: dict[str, Any] = {"color": colour, "linestyle": "--", "linewidth": 0.8}
    for side in front.sides:
        panel.plot(front.x, side * front.y, **line, path_effects=outline(around, 1.6))
    place = _name_at(panel, front, window) if front.name else None
    if place is not None:
        beside = front.share == 0
        panel.annotate(
            front.name,
            place,
            (4, 5) if beside else (0, 0),
            textcoords="offset points",
            color=colour,
            fontsize=SMALL,
            ha="left" if beside else "center",
            va="bottom" if beside else "center",
            path_effects=outline(around),
        )


def draw_interface(panel: Axes, fields: Fields, time: float) -> list[Line2D]:
    """Draw slot, slip, open parts and Rayleigh fronts on y = 0, and return their legend entries."""
    far = 1e3 * fields.scene.fastest_speed * time
    bar: dict[str, Any] = {"linewidth": 2.5, "solid_capstyle": "butt"}
    slot = bar | {"color": BLACK, "path_effects": outline("white", 4.0)}
    ends = np.clip(fields.scene.contact.intervals, -far, far)
    handles = {}
    for begin, end in zip([-far, *ends[:, 1]], [*ends[:, 0], far], strict=True):
        if begin < end:
            panel.plot([begin, end], [0, 0], **slot)
            handles["slot"] = Line2D([], [], label="slot", **slot)
    parts = moving_parts(fields, time)
    for part in parts:
        moving = bar | {"color": SENSE_COLOURS[part.kind], "path_effects": outline(BLACK, 4.0)}
        panel.plot([part.start, min(part.end, far)], [0, 0], **moving)
        handles[part.kind] = Line2D([], [], label=part.kind, **moving)
    places = _rayleigh_fronts(fields, parts, time)
    if places:
        at = np.zeros(len(places))
        panel.plot(places, at, "D", color=ORANGE, markersize=5, markeredgecolor=BLACK, zorder=3)
        handles["Rayleigh"] = marker_handle("Rayleigh front", ORANGE, "D", 5)
        handles["Rayleigh"].set_markeredgecolor(BLACK)
    if not fields.scene.on_line:
        handles["fronts"] = line_handle("wave fronts", ink(0.65), "--")
    return [*handles.values()]


@styled
def record_figure(record: FieldRecord, scene: Scene) -> Figure:
    """Draw velocity, displacement, stress and strain over time, with the arrivals of waves."""
    figure = describe(new_figure(7.5, 8.5), scene)
    panels = figure.subplots(4, 1, sharex=True)
    # of P and S waves from the edge of the slot, if they are in the record
    distance = float(np.hypot(record.x, record.y))
    times = {name: distance / speed for name, speed in scene_fronts(scene).items()}
    arrivals = {name: t for name, t in times.items() if name != "Rayleigh" and 0 < t < record.t[-1]}
    for panel, symbol, rows, dimension, axes, words in (
        (panels[0], "v", record.velocity, "length / time", "xyz", "velocity"),
        (panels[1], "u", record.displacement, "length", "xyz", "displacement"),
        (panels[2], r"\sigma", record.stress, "stress", _AXES, "stress"),
        (panels[3], r"\varepsilon", record.strain, "1", _AXES, "strain"),
    ):
        for row, axis, colour in zip(rows, axes, cycle(), strict=False):
            shown = np.where(np.isfinite(row), row, np.nan)
            panel.plot(record.t, shown, color=colour, label=f"${symbol}_{{{axis}}}$", linewidth=1.2)
        panel.set_ylabel(f"{words} [{unit(dimension, scene.units)}]")
        panel.legend(loc="upper left")
        mark_waves(panel, arrivals, 1.0, labels=panel is panels[0])
    length = unit("length", scene.units)
    panels[0].set_title(f"x = {record.x:.4g}, y = {record.y:.4g} [{length}]", pad=16)
    panels[-1].set(xlabel=f"t [{unit('time', scene.units)}]", xlim=(0, record.t[-1]))
    return figure
