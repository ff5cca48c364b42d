"""Figure of the records at stations with the exact records, and of their differences."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from compare.figures import style
from compare.records.record import QUANTITIES, Record
from compare.validation.rows import chosen_stations
from compare.validation.validation import Validation

if TYPE_CHECKING:
    from matplotlib.axes import Axes

LABELS = {
    "slip_rate": style.RATE_LABEL,
    "slip": r"slip $/\ (V_0 T)$",
    "shear_traction": r"shear traction $/\ \tau_0$",
    "pressure": r"pressure $/\ \tau_0$",
}
DOTS = 60
"""Samples that are shown of a record, at most; the difference has all of them."""
FINE = 600


@style.styled
def validation_figure(validation: Validation) -> Figure:
    """A column for each quantity: records above, what they differ by below."""
    stations = validation.grids.finest.stations
    names = [name for name in QUANTITIES if any(name in record.values for record in stations)]
    figure = style.describe(style.new_figure(max(3.4 * len(names), 5.5), 5.6), validation.scene)
    panels = figure.subplots(
        2, max(len(names), 1), sharex=True, squeeze=False, height_ratios=(2, 1)
    )
    places = chosen_stations([record.x for record in stations], validation.exact)
    for column, name in enumerate(names):
        for place, colour in zip(places, style.cycle(), strict=False):
            if name in stations[place].values:
                _draw(panels[:, column], validation, stations[place], name, colour)
        panels[0, column].set_title(LABELS[name])
        panels[1, column].axhline(0, color=style.ink(), linewidth=0.6)
        panels[1, column].set_xlabel(style.TIME_LABEL)
    panels[0, 0].set(xlim=(0, 1))
    panels[1, 0].set_ylabel("recorded less exact")
    length = validation.scene.material.shear_speed * validation.exact.end_time
    handles = [
        style.line_handle("exact", style.ink()),
        style.marker_handle("recorded", style.ink()),
    ]
    handles += [
        style.line_handle(rf"$x = {stations[place].x / length:.3g}\,c_t T$", colour)
        for place, colour in zip(places, style.cycle(), strict=False)
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=4)
    return figure


def _draw(
    panels: np.ndarray, validation: Validation, record: Record, name: str, colour: str
) -> None:
    upper: Axes
    lower: Axes
    upper, lower = panels
    exact, sampling = validation.exact, validation.grids.sampling
    unit, end = exact.unit(name), exact.end_time
    fine = np.linspace(0.0, end, FINE + 1)[1:]
    upper.plot(fine / end, exact.record(name, record.x, fine) / unit, color=colour, linewidth=1.0)
    values, every = record.values[name] / unit, max(len(record.t) // DOTS, 1)
    upper.plot(record.t[::every] / end, values[::every], ".", color=colour, markersize=3.5)
    expected = exact.record(name, record.x, record.t, sampling) / unit
    lower.plot(record.t / end, values - expected, color=colour, linewidth=0.8)
