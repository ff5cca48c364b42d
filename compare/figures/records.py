"""Figures of the records of instruments at one point of a body."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from compare.comparison.scales import scene_fronts
from compare.figures.style import cycle, describe, mark_waves, new_figure, styled
from compare.output.field_files import FieldRecord
from semianalytic import Scene
from semianalytic.scene.units import unit

_AXES = ("xx", "yy", "xy", "xz", "yz")


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
