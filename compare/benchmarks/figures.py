"""Figures of the benchmarks: the answer to a sheet, and several runs beside each other."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from compare.benchmarks.answers import answer_to
from compare.benchmarks.classes import CLASSES, tolerances
from compare.benchmarks.interfaces.reference import Reference
from compare.benchmarks.interfaces.sheets import SI, InterfaceSheet
from compare.benchmarks.scores import GRADED, Score
from compare.benchmarks.sheet import Sheet
from compare.benchmarks.sheets import ALL_SHEETS
from compare.figures.histories import march_figure
from compare.figures.interface import prediction_figure
from compare.figures.pairs import pair_figure
from compare.figures.style import cycle, describe, ink, marker_handle, new_figure, styled
from compare.figures.whole_line import line_figure
from semianalytic import LineSolution, Marched, Pair, PairSolution

MARKERS = "osD^vPX<>*"
LEAST_SHOWN = 1e-5
"""Smaller errors are drawn at this value."""


def sheet_figure(sheet: Sheet) -> Figure:
    """The answer to a sheet."""
    answer = answer_to(sheet)
    if isinstance(answer, Reference):
        assert isinstance(sheet, InterfaceSheet)
        return reference_figure(sheet, answer)
    if isinstance(answer, LineSolution):
        return line_figure(answer)
    if isinstance(answer, PairSolution):
        return pair_figure(answer)
    return march_figure(answer) if isinstance(answer, Marched) else prediction_figure(answer)


@styled
def reference_figure(sheet: InterfaceSheet, answer: Reference) -> Figure:
    """Slip rate and slip at the stations of an interface over time."""
    si = sheet.units == SI
    figure = describe(new_figure(7, 5), f"{sheet.title}: {sheet.friction_words}")
    upper, lower = figure.subplots(2, 1, sharex=True)
    colours = cycle()
    for i, x in enumerate(answer.x):
        look = {"color": colours[i % len(colours)], "ls": "-" if i < len(colours) else "--"}
        upper.plot(answer.t, answer.values["slip_rate"][:, i], **look)
        label = f"$x$ = {x / 1000:g} km" if si else f"$x$ = {x:g}"
        lower.plot(answer.t, answer.values["slip"][:, i], label=label, **look)
    upper.set(ylabel="slip rate [m/s]" if si else "slip rate $/\\ c_t$")
    lower.set(ylabel="slip [m]" if si else "slip over half the width")
    lower.set_xlabel("$t$ [s]" if si else "$c_t t$ over half the width")
    lower.set_xlim(0, answer.t[-1])
    lower.legend(fontsize="small", ncols=2)
    return figure


@styled
def score_figure(scores: Sequence[Score]) -> Figure:
    """Errors of runs, a dot each on a line per quantity; a panel per sheet, classes shaded."""
    sheets = [name for name in ALL_SHEETS if any(one.sheet == name for one in scores)]
    labels = list(dict.fromkeys(one.label for one in scores))
    colours = cycle()
    looks = {
        label: (colours[at % len(colours)], MARKERS[at % len(MARKERS)])
        for at, label in enumerate(labels)
    }
    lines = [sum(name in _asked(scores, sheet) for name in GRADED) for sheet in sheets]
    height = 1.1 + sum(0.42 * count + 0.55 for count in lines)
    figure = new_figure(7, height)
    panels = figure.subplots(len(sheets), 1, sharex=True, squeeze=False, height_ratios=lines)[:, 0]
    for panel, sheet in zip(panels, sheets, strict=True):
        _draw_sheet(panel, ALL_SHEETS[sheet], [one for one in scores if one.sheet == sheet], looks)
    panels[-1].set_xlabel(r"error: of arrivals $/\ T$, of all else relative $L_1$")
    handles = [marker_handle(label.replace("$", r"\$"), *look) for label, look in looks.items()]
    figure.legend(handles=handles, loc="outside lower center", ncols=3)
    return figure


def _asked(scores: Iterable[Score], sheet: str) -> list[str]:
    """Quantities of a sheet, as they are listed."""
    given = {one.quantity for one in scores if one.sheet == sheet}
    return [name for name in GRADED if name in given]


def _draw_sheet(
    panel: Axes, sheet: Sheet, scores: Sequence[Score], looks: dict[str, tuple[str, str]]
) -> None:
    names = _asked(scores, sheet.name)
    for row, name in enumerate(names):
        bounds = tolerances().get((sheet.name, name))
        for class_name in CLASSES if bounds else ():
            bound = max(getattr(bounds, class_name), LEAST_SHOWN)
            panel.plot([bound, bound], [row - 0.35, row + 0.35], color=ink(0.5), linewidth=1)
            panel.annotate(
                class_name, (bound, row + 0.35), fontsize="x-small", ha="right", color=ink(0.65)
            )
        for one in scores:
            if one.quantity == name and math.isfinite(one.error):
                colour, marker = looks[one.label]
                at = max(one.error, LEAST_SHOWN)
                panel.plot(at, row, marker, color=colour, markersize=5)
    panel.set_title(_panel_title(sheet), loc="left")
    panel.set_xscale("log")
    panel.grid(axis="y", color=ink(0.1))
    panel.set_axisbelow(True)
    panel.set_yticks(range(len(names)), [name.replace("_", " ") for name in names])
    panel.set_ylim(len(names) - 0.4, -0.6)


def _panel_title(sheet: Sheet) -> str:
    if isinstance(sheet, InterfaceSheet):
        return f"{sheet.name}: {sheet.friction_words}"
    problem = sheet.problem
    if isinstance(problem, Pair):
        problem = problem.alike
    ratio, friction = problem.material.poisson_ratio, problem.friction
    return f"{sheet.name}: ν = {ratio:.3g}, f = {friction:.3g}"
