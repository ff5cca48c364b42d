"""Figures, tables and text of the chart, made from the measured points alone."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import groupby
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import NullFormatter

from compare.figures.saving import save_figure
from compare.figures.style import (
    BLACK,
    BROWN,
    MARCH,
    PREDICTION,
    PUBLISHED,
    SIMULATION,
    VIOLET,
    ink,
    marker_handle,
    new_figure,
    scene_words,
    styled,
)
from compare.output.files import filled_template, write_text
from compare.output.printed import Table
from compare.output.tables import markdown_table
from compare.studies.chart.methods import EDGE_THRESHOLD, METHODS
from compare.studies.chart.points import SCENES, VERSIONS, Point
from compare.studies.chart.reference import FINEST
from semianalytic.scene.given.named import NAMED_SCENES

LEVELS = (0.1, 0.01, 1e-3, 1e-8)
LEVEL_NAMES = ("10 %", "1 %", "0.1 %", "1e-8")

STYLES = {
    "self-similar": (PREDICTION, "o"),
    "self-similar-cold": (VIOLET, "o"),
    "first-stage": (BROWN, "s"),
    "published": (PUBLISHED, "X"),
    "space-time": (MARCH, "D"),
    "fem": (SIMULATION, "^"),
    "fem-p1": (BROWN, "v"),
    "fem-triangles": (BROWN, "<"),
    "fem-q2": (SIMULATION, ">"),
    "fem-graded": (BLACK, "P"),
    "fem-two-blocks": (BLACK, "h"),
    "fem-undamped": (SIMULATION, "p"),
    "fem-whole": (BROWN, "*"),
}
"""Colour and marker of every method."""

_AREA = 0.12  # area of a marker, points^2 per MB


def by_method(points: Sequence[Point], scene_name: str) -> Iterator[tuple[str, list[Point]]]:
    """Yield the methods of a scene with their points, in the order of the table."""
    mine = [point for point in points if point.scene_name == scene_name]
    for method, group in groupby(mine, key=lambda point: point.method):
        yield method, list(group)


def slope(points: Sequence[Point]) -> float:
    """Return the power of time with which the error of a method falls, by least squares.

    Points below the error of the reference are left out; with fewer than two, the slope is nan.
    """
    known = [p for p in points if p.error > _floor(p) and p.seconds > 0 and p.error < math.inf]
    if len(known) < 2:
        return math.nan
    time, error = np.log([p.seconds for p in known]), np.log([p.error for p in known])
    if np.ptp(time) == 0:
        return math.nan
    return float(np.polyfit(time - time.mean(), error, 1)[0])


def _floor(point: Point) -> float:
    """Return the error below which a point of a self-similar scene has no meaning."""
    return _bars(point)[0] if NAMED_SCENES[point.scene_name].scene.is_self_similar else 0.0


def _bars(point: Point) -> tuple[float, float]:
    """Return the uncertainty of slip rate and edges of the reference.

    A self-similar reference agrees with closed forms to rounding, but its tolerance is `FINEST`.
    """
    bars = point.reference_error, point.reference_edge_error
    if not NAMED_SCENES[point.scene_name].scene.is_self_similar:
        return bars
    return max(bars[0], FINEST), max(float(np.nan_to_num(bars[1])), FINEST)


@styled
def chart_figure(points: Sequence[Point], scene_name: str) -> Figure:
    """Errors of slip rate and of zone edges against time, one line per method.

    Marker areas show peak memory.  Points that are better than the reference are drawn at the error
    of the reference, the upper end of the shaded band; missed zones are left out.
    """
    figure = new_figure(12, 5.6)
    panels = figure.subplots(1, 2, sharex=True)
    titles = "slip rate, relative $L_1$ error", "worst zone edge, error over $c_t$"
    handles = []
    for method, group in by_method(points, scene_name):
        colour, marker = STYLES[method]
        time = np.array([point.seconds for point in group])
        area = np.array([max(_AREA * point.memory, 6) for point in group])
        for panel, errors in zip(panels, _errors(group), strict=True):
            known = np.isfinite(errors) & (errors > 0) & np.isfinite(time)
            x, y = time[known], errors[known]
            panel.plot(x, y, color=colour, linewidth=1, zorder=2)
            panel.scatter(x, y, area[known], color=colour, marker=marker, linewidths=0, zorder=3)
        power = slope(group)
        label = METHODS[method].label + ("" if math.isnan(power) else f", slope {power:.2g}")
        handles.append(Line2D([], [], color=colour, marker=marker, linewidth=1, label=label))
    bars = _bars(next(point for point in points if point.scene_name == scene_name))
    for panel, title, bar in zip(panels, titles, bars, strict=True):
        _finish(panel, bar)
        panel.set(xlabel="set-up and solving [s]", title=title)
    for memory in (100, 1000):
        size, label = math.sqrt(_AREA * memory), f"peak memory {memory:,} MB"
        handles.append(marker_handle(label, ink(0.45), "o", size))
    named = NAMED_SCENES[scene_name]
    title = f"{scene_name}: {named.summary}\n{scene_words(named.scene)}"
    figure.suptitle(title, x=0.02, ha="left", color=ink(0.75))
    figure.legend(handles=handles, loc="outside right upper", frameon=False)
    return figure


def _errors(group: Sequence[Point]) -> tuple[np.ndarray, np.ndarray]:
    """Return the errors of both panels, raised to the error of self-similar references."""
    limited = NAMED_SCENES[group[0].scene_name].scene.is_self_similar
    floors = _bars(group[0]) if limited else (0.0, 0.0)
    return (
        np.maximum([point.error for point in group], floors[0]),
        np.maximum([point.edge_error for point in group], floors[1]),
    )


def _finish(panel: Axes, bar: float) -> None:
    """Set logarithmic scales, and shade the errors below the uncertainty of the reference."""
    panel.set(xscale="log", yscale="log")
    panel.xaxis.set_minor_formatter(NullFormatter())
    panel.yaxis.set_minor_formatter(NullFormatter())
    panel.grid(True, which="major", color=ink(0.15), linewidth=0.6)
    panel.set_axisbelow(True)
    if not math.isfinite(bar) or bar <= 0:
        return
    low, high = panel.get_ylim()
    low = min(low, bar / 10)
    panel.axhspan(low, bar, facecolor="none", edgecolor=ink(0.2), hatch="//", linewidth=0, zorder=1)
    panel.annotate(
        "reference uncertain",
        (0.01, low),
        (0, 3),
        xycoords=panel.get_yaxis_transform(),
        textcoords="offset points",
        fontsize="x-small",
        color=ink(0.65),
    )
    panel.set_ylim(low, high)


def charted(points: Sequence[Point]) -> list[str]:
    """Return the names of the scenes that have points, in the order of the chart."""
    present = {point.scene_name for point in points}
    return [name for name in SCENES if name in present]


def slopes(points: Sequence[Point]) -> dict[str, dict[str, float]]:
    """Return the slope of error against time by scene and method; nan where there is none."""
    return {
        name: {method: slope(group) for method, group in by_method(points, name)}
        for name in charted(points)
    }


def slopes_table(points: Sequence[Point]) -> Table:
    """Return a table of the slope of error against time, of every method on every scene."""
    names = charted(points)
    table = Table("method", title="error ∝ time^slope")
    for name in names:
        table.add_column(name, justify="right")
    for label, cells in _slopes(points, names):
        table.add_row(label, *cells)
    return table


def _slopes(points: Sequence[Point], scene_names: Sequence[str]) -> Iterator[tuple[str, list[str]]]:
    groups = [dict(by_method(points, scene_name)) for scene_name in scene_names]
    for name, method in METHODS.items():
        powers = [slope(group.get(name, [])) for group in groups]
        yield method.label, ["—" if math.isnan(power) else f"{power:.2f}" for power in powers]


def cheapest(points: Sequence[Point], level: float) -> Point | None:
    """Return the fastest point within an error level, reference error included, or None."""
    good = [point for point in points if point.error + point.reference_error <= level]
    return min(good, key=lambda point: point.seconds, default=None)


def chart_text(points: Sequence[Point], form: str = "png") -> str:
    """Return the Markdown page of the chart: recommended methods, their costs, and their limits.

    Links are relative to the folder docs/.
    """
    names, one = charted(points), points[0]
    dates = sorted({point.date for point in points})
    groups = {name: [p for p in points if p.scene_name == name] for name in names}
    sections = (_scene_lines(group, name, form) for name, group in groups.items())
    slopes = ([label, *powers] for label, powers in _slopes(points, names))
    return filled_template(
        "compare.studies.chart",
        "chart.md",
        **{name: getattr(one, name) for name in (*VERSIONS, "machine", "cores")},
        count=len(points),
        when=dates[0] if len(dates) == 1 else f"{dates[0]} … {dates[-1]}",
        threshold=f"{EDGE_THRESHOLD:g}",
        recommended=markdown_table(("error of", *names), _recommended(points, names)),
        scenes="\n".join("\n".join(section) for section in sections),
        slopes=markdown_table(("method", *names), slopes),
        failures="\n".join(_failures(points, names)),
    )


def _recommended(points: Sequence[Point], scene_names: Sequence[str]) -> Iterator[list[str]]:
    """Yield the fastest method of every scene for every error level."""
    for name, level in zip(LEVEL_NAMES, LEVELS, strict=True):
        row = [name]
        for scene_name in scene_names:
            mine = [point for point in points if point.scene_name == scene_name]
            best = cheapest(mine, level)
            if best is not None:
                cell = f"{METHODS[best.method].label}, {_priced(best)}, error {best.error:.0e}"
            else:
                cell = _unknown(mine[0], level)
            row.append(cell)
        yield row


def _unknown(point: Point, level: float) -> str:
    """Return why no method is named for an error level."""
    return "—" if point.reference_error < level else "reference not known that well"


def _scene_lines(points: Sequence[Point], scene_name: str, form: str) -> Iterator[str]:
    described, one = NAMED_SCENES[scene_name], points[0]
    yield f"## {scene_name}"
    yield ""
    yield f"Scene: {described.summary}."
    kind = "closed form" if described.scene.is_self_similar else "difference of the two"
    edge = one.reference_edge_error
    yield (
        f"Reference: {one.reference} ({kind}: {one.reference_error:.1e}"
        + ("" if math.isnan(edge) else f", zone edge {edge:.1e}")
        + ")."
    )
    yield ""
    seen = f"Errors of slip rate and zone edges of {scene_name} against time, one line per method"
    yield f"![{seen}](figures/chart_{scene_name}.{form})"
    yield ""
    best = [cheapest(points, level) for level in LEVELS]
    rows = []
    for family in dict.fromkeys(METHODS[point.method].family for point in points):
        own = [point for point in points if METHODS[point.method].family == family]
        cells = []
        for level, first in zip(LEVELS, best, strict=True):
            own_best = cheapest(own, level)
            cell = _unknown(one, level) if own_best is None else _named(own_best, family)
            is_best = own_best is not None and own_best is first
            cells.append(f"**{cell}**" if is_best else cell)
        rows.append((family, *cells))
    yield markdown_table(("cheapest for an error of", *LEVEL_NAMES), rows)


def _named(point: Point, family: str) -> str:
    label = METHODS[point.method].label.removeprefix("FEM ")
    return _priced(point) if label == family else f"{label}, {_priced(point)}"


def _priced(point: Point) -> str:
    return f"{point.name}: {_time(point.seconds)}, {point.memory:.0f} MB"


def _time(seconds: float) -> str:
    return f"{1000 * seconds:.2g} ms" if seconds < 0.0995 else f"{seconds:.2g} s"


FAILS: dict[str, str] = {
    "self-similar": "It takes only step loads and constant friction. Beside thresholds, at very "
    "low friction and for ν near 0.5 it may end without convergence, which its status says "
    "([thresholds](stability.md#thresholds), "
    "[limits of ν](stability.md#limits-of-the-poisson-ratio), "
    "[what is left](stability.md#remaining-failures))",
    "first-stage": "No grid gives the answer: the error depends on the distance of zone edges "
    "from nodes ([first stage](stability.md#the-first-stage))",
    "published": "It solves another equation, whatever the number of collocation points, and "
    "takes only a sudden remote load ([the article](article.md))",
    "space-time": "Steps above c_t Δt/h of 0.57 to 0.7 are unstable and refused. Edges are no "
    "more accurate than the grid ([where it fails](spacetime.md#where-it-fails), "
    "[step size and long times](stability.md#the-other-two-methods))",
    "fem": "It smears fronts over a width set by damping and mesh "
    "([damping](fem.md#damping), [step size, ν, opening](fem.md#when-it-fails))",
    "fem-triangles": "The irregularity of the mesh appears on fine meshes "
    "([elements](fem.md#elements))",
    "fem-graded": "Waves are reflected where the mesh grows ([elements](fem.md#elements))",
    "fem-undamped": "Slip rates at single times oscillate, and zones break up "
    "([damping](fem.md#damping))",
}
"""Limits of the methods, with links to their studies; all finite elements share one entry."""


def _failures(points: Sequence[Point], scene_names: Sequence[str]) -> Iterator[str]:
    for name, reason in FAILS.items():
        own = [point for point in points if point.method == name]
        if not own:
            continue
        ends = []
        for scene_name in scene_names:
            known = [p for p in own if p.scene_name == scene_name and math.isfinite(p.error)]
            obstacle = METHODS[name].obstacle(NAMED_SCENES[scene_name].scene)
            if obstacle:
                ends.append(f"{scene_name} not possible ({obstacle})")
            elif known:
                best = min(known, key=lambda point: point.error)
                missed = sum(math.isinf(point.edge_error) for point in known)
                zones = f", zones missed at {missed} of {len(known)} settings" if missed else ""
                bar = _bars(best)[0]
                least = (
                    f"{best.error:.1e}" if best.error > bar else f"below {bar:.1e}, the reference"
                )
                ends.append(f"{scene_name} {least} at {best.name}{zones}")
        yield f"- **{METHODS[name].label}**. {reason}. Best error: {'; '.join(ends)}."
    doubtful = [point for point in points if point.status != "measured"]
    for point in doubtful:
        label = METHODS[point.method].label
        yield f"- {label} on {point.scene_name}, {point.name}: {point.status.rstrip('.')}."


def write_chart(directory: Path, points: Sequence[Point], form: str = "png") -> str:
    """Draw all figures in a format, write `chart.md` beside them, and return its text.

    Raises
    ------
    DataFileError
        If a file cannot be written.
    """
    for name in charted(points):
        folder = directory / "figures"
        folder.mkdir(parents=True, exist_ok=True)
        save_figure(chart_figure(points, name), folder / f"chart_{name}.{form}")
    text = chart_text(points, form)
    write_text(directory / "chart.md", text)
    return text
