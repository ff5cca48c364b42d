"""Figures of fits: records against the fit, and how well parameters are distinguished."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure

from compare.figures import style
from compare.records.record import Array
from semianalytic.inversion.fitted import Fit
from semianalytic.inversion.gauges import QUANTITIES, Gauge
from semianalytic.scene.units import unit, with_unit
from slipfront.fits.documents import dimension

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import SubFigure

PANELS = 5
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
    curves: Sequence[_Curve]


@style.styled
def fit_figure(fit: Fit) -> Figure:
    """Draw records and residuals of a fit on the left, its parameters on the right.

    Bands are two standard errors of the fitted curve to either side.

    On the right, the diagonal shows the density of each parameter.  Ellipses below it enclose 50
    and 90 % of the probability by the covariance.  Correlations stand above it.
    """
    panels = list(_panels(fit))
    height = max(1.9 * len(panels) + 0.8, 2.0 * len(fit.parameters) + 1.2, 3.6)
    what = "fit of a scene on a line" if fit.scene.on_line else fit.scene
    figure = style.describe(style.new_figure(12.5, height), what)
    left, right = np.ravel(figure.subfigures(1, 2, width_ratios=(6.5, 6), squeeze=False))
    _draw_records(left, fit, panels)
    _draw_parameters(right, fit)
    return figure


def _panels(fit: Fit) -> Iterator[_Panel]:
    """Yield a panel per line of gauges (more positions than times) and per gauge of a selection."""
    groups: dict[tuple[str, float | None], list[int]] = {}
    for number, gauge in enumerate(fit.gauges):
        groups.setdefault((gauge.quantity, gauge.y), []).append(number)
    residuals, units = fit.residuals, fit.scene.units
    bands = [np.array(band) for band in fit.forecast()]
    lines = {
        key: numbers
        for key, numbers in groups.items()
        if len(numbers) > max(len(fit.gauges[i].t) for i in numbers)
    }
    alone = [i for key, numbers in groups.items() if key not in lines for i in numbers]
    for key, numbers in list(lines.items())[:PANELS]:
        quantity, y = key
        title = quantity if y is None else f"{quantity} at y = {with_unit(y, 'length', units)}"
        curves = list(_over_place(fit, numbers, residuals, bands))
        yield _Panel(_with_unit(fit, fit.gauges[numbers[0]], title), "x", curves)
    room = max(PANELS - len(lines), 1)
    for i in alone if len(alone) <= room else [alone[k] for k in _even(len(alone), room)]:
        gauge = fit.gauges[i]
        fine = np.linspace(gauge.t[0], gauge.t[-1], FINE)
        residual = residuals[i] / gauge.noise
        curve = _Curve(gauge.t, gauge.values, residual, bands[i], fine, fit.seen(gauge, fine), "")
        place = f"x = {with_unit(gauge.x, 'length', units)}"
        place += "" if gauge.y is None else f", y = {with_unit(gauge.y, 'length', units)}"
        title = f"{gauge.quantity} at {place}"
        yield _Panel(_with_unit(fit, gauge, title), "t", [curve])


def _even(count: int, shown: int) -> list[int]:
    return [round(number) for number in np.linspace(0, count - 1, shown)]


def _with_unit(fit: Fit, gauge: Gauge, title: str) -> str:
    return f"{title} [{unit(QUANTITIES[gauge.quantity], fit.scene.units)}]"


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
        words = f"t = {with_unit(t, 'time', fit.scene.units)}"
        yield _Curve(x, recorded, residual, np.array(band), x, band[0], words)


def _draw_records(figure: SubFigure, fit: Fit, panels: Sequence[_Panel]) -> None:
    axes = figure.subplots(len(panels), 2, squeeze=False, width_ratios=(2, 1))
    for (left, right), panel in zip(axes, panels, strict=True):
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
        right.set_title("residual / noise", fontsize=style.SMALL)
        dimensioned = unit("time" if panel.along == "t" else "length", fit.scene.units)
        for side in (left, right):
            side.set_xlabel(f"{panel.along} [{dimensioned}]", fontsize=style.SMALL)
            side.tick_params(labelsize=style.SMALL)
            side.ticklabel_format(scilimits=(-3, 4))
            side.locator_params(axis="x", nbins=5)
            for axis in (side.xaxis, side.yaxis):
                axis.offsetText.set_fontsize(style.SMALL)
        if panel.curves[0].label:
            left.legend(fontsize=style.SMALL)


def _draw_parameters(figure: SubFigure, fit: Fit) -> None:
    p, errors = len(fit.parameters), fit.standard_errors
    axes = figure.subplots(p, p, squeeze=False)
    spread = np.where(np.isfinite(errors), errors, np.maximum(np.abs(fit.values), 1e-300))
    ranges = [_range(fit, k, float(spread[k])) for k in range(p)]
    for row in range(p):
        for column in range(p):
            panel = axes[row, column]
            panel.tick_params(labelsize=TINY)
            panel.locator_params(nbins=3)
            panel.ticklabel_format(useOffset=False, scilimits=(-3, 4))
            panel.xaxis.offsetText.set_fontsize(TINY)
            panel.yaxis.offsetText.set_fontsize(TINY)
            if row == column:
                _draw_density(panel, fit, row, ranges[row])
            elif row > column:
                _draw_pair(panel, fit, (column, row), (ranges[column], ranges[row]))
            else:
                _draw_correlation(panel, float(fit.correlation[row, column]))
            if row == p - 1:
                panel.set_xlabel(_axis(fit, column), fontsize=style.SMALL)
            if column == 0 and row:
                panel.set_ylabel(_axis(fit, row), fontsize=style.SMALL)
    handles = [style.line_handle("50 and 90 % by the covariance", style.PREDICTION)]
    if len(fit.minima) > 1:
        handles.append(style.marker_handle("other minima", style.VERMILLION, "x"))
    figure.legend(handles=handles, loc="outside lower center", ncols=3, fontsize=style.SMALL)


def _axis(fit: Fit, number: int) -> str:
    name = fit.parameters[number]
    return f"{name.replace('_', ' ')} [{unit(dimension(name, fit.scene), fit.scene.units)}]"


def _range(fit: Fit, number: int, error: float) -> tuple[float, float]:
    """Return the range of a parameter that a panel shows."""
    value = float(fit.values[number])
    below, above = np.maximum(np.abs(_ends(fit, number, error) - value), error)
    return value - WIDTH * float(below), value + WIDTH * float(above)


def _ends(fit: Fit, number: int, error: float) -> Array:
    """Return the ends (2,) of the interval of a value, an error away where it has none."""
    around = fit.values[number] + error * np.array([-1.0, 1.0])
    return np.where(np.isfinite(fit.interval[number]), fit.interval[number], around)


def _draw_density(panel: Axes, fit: Fit, number: int, limits: tuple[float, float]) -> None:
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
    name = dimension(fit.parameters[number], fit.scene)
    has_unit = name != "1" and fit.scene.units
    error_words = fit.error_in_words(number)
    # Two sides need a line of their own, or the title is wider than its panel.
    words = (
        f"{fit.values[number]:.4g}{' ' if error_words.startswith('±') else chr(10)}{error_words}"
    )
    words += f" {unit(name, fit.scene.units)}" if has_unit else ""
    panel.set_title(words, fontsize=style.SMALL)


def _draw_pair(
    panel: Axes,
    fit: Fit,
    pair: tuple[int, int],
    limits: tuple[tuple[float, float], tuple[float, float]],
) -> None:
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
