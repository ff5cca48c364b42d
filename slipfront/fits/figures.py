"""Figures of fits: records against the fit, and how well parameters are distinguished."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure

from compare.figures import style
from semianalytic.inversion.fitted import Fit
from semianalytic.inversion.gauges import QUANTITIES, Gauge
from semianalytic.results.plotting import SHOWN, shown_number
from semianalytic.scene.arrays import Array
from semianalytic.scene.units import SI, unit
from slipfront.fits.documents import dimension

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import SubFigure

PANELS = 4
"""Largest number of gauges or lines of gauges that are shown."""
TIMES = 4
"""Largest number of times at which a line of gauges is shown."""
FINE = 500
SHARES = (0.5, 0.9)
"""Probabilities that the ellipses enclose."""
WIDTH = 3.5
"""Half-width of the panels of parameters, in standard errors."""
TINY = "x-small"
"""Font size of numbers at the axes of small panels."""
STRONG = 0.9
"""Correlation from which on its number is written large."""
_UNITS = {**SHOWN, "length / time": ((1.0, "m/s"), (1e3, "mm/s")), "strain": ((1e6, "µstrain"),)}
"""Units of figures of SI scenes: the largest of which there are two or more is drawn."""
_FIELDS = {"v": "velocity v", "u": "displacement u", "s": r"stress \sigma", "e": r"strain \epsilon"}
_Ends = tuple[float, float]
_Unit = tuple[float, str]
"""Factor and name of a unit."""


@dataclass(frozen=True, eq=False)
class _Curve:
    """Recorded and fitted values over time or position, and residuals over the noise.

    `forecast` has the fitted values where they were recorded, and their standard errors, (2, n).
    """

    at: Array
    recorded: Array
    residual: Array
    forecast: Array
    fine: Array
    fitted: Array
    label: str


@dataclass(frozen=True, eq=False)
class _Panel:
    title: str
    along: str
    unit: _Unit
    curves: Sequence[_Curve]


@style.styled
def fit_figure(fit: Fit) -> Figure:
    """Draw records and residuals of a fit on the left, its parameters on the right.

    Bands are two standard errors of the fitted curve to either side.

    On the right, the diagonal shows the density of each parameter.  Ellipses below it enclose 50
    and 90 % of the probability by the covariance.  Correlations stand above it.
    """
    panels = list(_panels(fit))
    height = max(1.5 * len(panels) + 1.0, 1.6 * len(fit.parameters) + 1.4, 3.6)
    what = "fit of a scene on a line" if fit.scene.on_line else fit.scene
    figure = style.describe(style.new_figure(9.0, height), what)
    left, right = np.ravel(figure.subfigures(1, 2, width_ratios=(5, 4), squeeze=False))
    _draw_records(left, fit, panels)
    _draw_parameters(right, fit)
    return figure


def _panels(fit: Fit) -> Iterator[_Panel]:
    """Yield a panel per line of gauges (more positions than times) and per gauge of a selection."""
    groups: dict[tuple[str, float | None], list[int]] = {}
    for number, gauge in enumerate(fit.gauges):
        groups.setdefault((gauge.quantity, gauge.y), []).append(number)
    residuals = fit.residuals
    bands = [np.array(band) for band in fit.forecast()]
    lines = {
        key: numbers
        for key, numbers in groups.items()
        if len(numbers) > max(len(fit.gauges[i].t) for i in numbers)
    }
    alone = [i for key, numbers in groups.items() if key not in lines for i in numbers]
    for numbers in list(lines.values())[:PANELS]:
        curves = list(_over_place(fit, numbers, residuals, bands))
        yield _panel(fit, fit.gauges[numbers[0]], "x", curves)
    room = max(PANELS - len(lines), 1)
    for i in alone if len(alone) <= room else [alone[k] for k in _even(len(alone), room)]:
        gauge = fit.gauges[i]
        fine = np.linspace(gauge.t[0], gauge.t[-1], FINE)
        residual = residuals[i] / gauge.noise
        curve = _Curve(gauge.t, gauge.values, residual, bands[i], fine, fit.seen(gauge, fine), "")
        yield _panel(fit, gauge, "t", [curve])


def _panel(fit: Fit, gauge: Gauge, along: str, curves: Sequence[_Curve]) -> _Panel:
    """Return a panel whose title names the quantity of a gauge, its place and its unit."""
    at = [("x", gauge.x)] * (along == "t") + ([] if gauge.y is None else [("y", gauge.y)])
    place = ", ".join(f"{axis} = {_written(fit, 'length', value)}" for axis, value in at)
    known, name = QUANTITIES[gauge.quantity], gauge.quantity.replace("_", " ")
    if gauge.y is not None:
        name = "{} ${}_{{{}}}$".format(*_FIELDS[name[0]].split(), name[1:])
    most = max(float(np.abs(curve.recorded).max()) for curve in curves)
    of = _shown(fit, "strain" if known == "1" and fit.scene.units == SI else known, most)
    return _Panel(f"{name}{place and f' at {place}'} [{of[1]}]", along, of, curves)


def _shown(fit: Fit, dimension: str, size: float) -> _Unit:
    """Return the unit in which a quantity of a size is drawn."""
    if fit.scene.units != SI:
        return 1.0, unit(dimension, fit.scene.units)
    of = _UNITS.get(dimension, ((1.0, unit(dimension, SI)),))
    return next((choice for choice in of if choice[0] * abs(size) >= 2), of[-1])


def _written(fit: Fit, dimension: str, value: float) -> str:
    return shown_number(value, _shown(fit, dimension, value))


def _in_units(axis: Axis, factor: float) -> None:
    """Write the numbers of an axis in a unit."""
    axis.set_major_formatter(lambda value, _: f"{value * factor:.4g}")


def _even(count: int, shown: int) -> list[int]:
    return [round(number) for number in np.linspace(0, count - 1, shown)]


def _over_place(
    fit: Fit, numbers: list[int], residuals: Sequence[Array], bands: Sequence[Array]
) -> Iterator[_Curve]:
    """Yield the curves of a line of gauges at some of its times."""
    times = sorted({float(t) for i in numbers for t in fit.gauges[i].t})
    for t in [times[k] for k in _even(len(times), min(TIMES, len(times)))]:
        rows = []
        for i in numbers:
            gauge, here = fit.gauges[i], np.flatnonzero(fit.gauges[i].t == t)
            if here.size:
                noise = np.broadcast_to(gauge.noise, gauge.t.shape)[here[0]]
                residual = residuals[i][here[0]] / noise
                rows.append((gauge.x, gauge.values[here[0]], residual, *bands[i][:, here[0]]))
        x, recorded, residual, *band = np.array(sorted(rows)).T
        words = f"t = {_written(fit, 'time', t)}"
        yield _Curve(x, recorded, residual, np.array(band), x, band[0], words)


def _draw_records(figure: SubFigure, fit: Fit, panels: Sequence[_Panel]) -> None:
    axes = figure.subplots(len(panels), 2, squeeze=False, width_ratios=(2, 1))
    below = [*(panel.along for panel in panels[1:]), ""]
    for (left, right), panel, following in zip(axes, panels, below, strict=True):
        for curve, colour in zip(panel.curves, style.cycle(), strict=False):
            left.plot(curve.at, curve.recorded, ".", color=colour, markersize=3.5, alpha=0.7)
            left.plot(curve.fine, curve.fitted, color=colour, linewidth=1.2, label=curve.label)
            middle, error = np.where(np.isfinite(curve.forecast), curve.forecast, np.nan)
            band = middle - 2 * error, middle + 2 * error
            left.fill_between(curve.at, *band, color=colour, alpha=0.25, linewidth=0)
            right.plot(curve.at, curve.residual, ".", color=colour, markersize=3.5)
        for level in (-2, 0, 2):
            right.axhline(
                level, color=style.ink(), linewidth=0.6, linestyle="-" if not level else "--"
            )
        left.set_title(panel.title, fontsize=style.SMALL)
        if panel is panels[0]:
            right.set_title("residual / noise", fontsize=style.SMALL)
        most = max(float(np.abs(curve.at).max()) for curve in panel.curves)
        factor, name = _shown(fit, "time" if panel.along == "t" else "length", most)
        _in_units(left.yaxis, panel.unit[0])
        for side in (left, right):
            if following != panel.along:
                side.set_xlabel(f"{panel.along} [{name}]", fontsize=style.SMALL)
            side.tick_params(labelsize=style.SMALL)
            side.locator_params(axis="x", nbins=5)
            _in_units(side.xaxis, factor)
        if panel.curves[0].label:
            left.legend(fontsize=style.SMALL)
    handles = [
        style.marker_handle("dots: records", style.ink()),
        style.line_handle("lines: fit, with two standard errors", style.ink()),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=2, fontsize=style.SMALL)


def _draw_parameters(figure: SubFigure, fit: Fit) -> None:
    p, errors = len(fit.parameters), fit.standard_errors
    axes = figure.subplots(p, p, squeeze=False)
    spread = np.where(np.isfinite(errors), errors, np.maximum(np.abs(fit.values), 1e-300))
    ranges = [_range(fit, k, float(spread[k])) for k in range(p)]
    names = [dimension(name, fit.scene) for name in fit.parameters]
    units = [_shown(fit, *of) for of in zip(names, fit.values.tolist(), strict=True)]
    labels = [
        name.replace("_", " ") + f" [{of}]" * (of != "1")
        for name, (_, of) in zip(fit.parameters, units, strict=True)
    ]
    for row in range(p):
        for column in range(p):
            panel = axes[row, column]
            panel.tick_params(labelsize=TINY)
            panel.locator_params(nbins=3)
            _in_units(panel.xaxis, units[column][0])
            _in_units(panel.yaxis, units[row][0])
            if row == column:
                _draw_density(panel, fit, row, ranges[row], units[row])
            elif row > column:
                _draw_pair(panel, fit, (column, row), (ranges[column], ranges[row]))
            else:
                _draw_correlation(panel, float(fit.correlation[row, column]))
            if row == p - 1:
                panel.set_xlabel(labels[column], fontsize=style.SMALL)
            if column == 0 and row:
                panel.set_ylabel(labels[row], fontsize=style.SMALL)
    handles = [style.line_handle("50 and 90 %", style.PREDICTION)]
    if len(fit.minima) > 1:
        handles.append(style.marker_handle("other minima", style.VERMILLION, "x"))
    figure.legend(handles=handles, loc="outside lower center", ncols=3, fontsize=style.SMALL)


def _range(fit: Fit, number: int, error: float) -> _Ends:
    """Return the range of a parameter that a panel shows."""
    value = float(fit.values[number])
    below, above = np.maximum(np.abs(_ends(fit, number, error) - value), error)
    return value - WIDTH * float(below), value + WIDTH * float(above)


def _ends(fit: Fit, number: int, error: float) -> Array:
    """Return the ends (2,) of the interval of a value, an error away where it has none."""
    around = fit.values[number] + error * np.array([-1.0, 1.0])
    return np.where(np.isfinite(fit.interval[number]), fit.interval[number], around)


def _draw_density(panel: Axes, fit: Fit, number: int, limits: _Ends, of: _Unit) -> None:
    error = float(fit.standard_errors[number])
    at = np.linspace(*limits, 300)
    if np.isfinite(error):
        # Normal to either side, each as wide as its part of the interval.
        below, above = np.abs(_ends(fit, number, error) - fit.values[number])
        width = np.where(at < fit.values[number], below, above)
        density = np.exp(-(((at - fit.values[number]) / width) ** 2) / 2) * 2 / (below + above)
        panel.plot(at, density / np.sqrt(2 * np.pi), color=style.PREDICTION, linewidth=1.2)
    else:
        panel.text(0.5, 0.5, "free", transform=panel.transAxes, ha="center", fontsize=style.SMALL)
    panel.set(xlim=limits, yticks=[])
    words = fit.error_in_words(number, of[0])
    name = f" {of[1]}" if of[1] != "1" and fit.scene.units else ""
    value = f"{fit.values[number] * of[0]:.4g}"
    # Two sides need a line of their own, or the title is wider than its panel.
    words = f"{value} {words}{name}" if words.startswith("±") else f"{value}{name}\n{words}"
    panel.set_title(words, fontsize=style.SMALL)


def _draw_pair(panel: Axes, fit: Fit, pair: Sequence[int], limits: Sequence[_Ends]) -> None:
    chosen = list(pair)
    part = fit.covariance[np.ix_(chosen, chosen)]
    if np.all(np.isfinite(part)):
        angle = np.linspace(0, 2 * np.pi, 200)
        circle = np.linalg.cholesky(part) @ np.stack([np.cos(angle), np.sin(angle)])
        for share in SHARES:  # a normal density in the plane has 1 - exp(-r^2 / 2) within r
            radius = np.sqrt(-2 * np.log(1 - share))
            ellipse = fit.values[chosen][:, None] + radius * circle
            panel.plot(*ellipse, color=style.PREDICTION, linewidth=1.2)
    panel.plot(*fit.values[chosen], "+", color=style.ink())
    panel.plot(*fit.minima[1:, chosen].T, "x", color=style.VERMILLION, markersize=4)
    panel.set(xlim=limits[0], ylim=limits[1])


def _draw_correlation(panel: Axes, correlation: float) -> None:
    panel.set(xticks=[], yticks=[])
    words = "free" if np.isnan(correlation) else f"{correlation:+.2f}"
    size = "medium" if abs(correlation) < STRONG else "x-large"
    place: Any = {"transform": panel.transAxes, "ha": "center", "va": "center"}
    panel.text(0.5, 0.5, words, fontsize=size, **place)
    for side in panel.spines.values():
        side.set_visible(False)
