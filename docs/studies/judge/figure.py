"""Figure of how far the judge can be trusted."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from compare.comparison.rows import ALARM, DIFFERS
from compare.figures.style import (
    BLUE,
    SMALL,
    VERMILLION,
    cycle,
    describe,
    ink,
    marker_handle,
    new_figure,
    styled,
)
from docs.studies.judge.rows import JudgedRow, SpoiltRow
from docs.studies.judge.scenes import STEPS
from docs.studies.judge.spoils import SPOILS

_FARTHEST = 3.0
"""End of the axis of differences over bars; larger ratios are drawn at this value."""
_LEAST_ROWS = 10
"""Least number of rows for which a kind has a curve."""
_LEAST_EFFECT, _LARGEST_EFFECT = 0.1, 100.0
"""Limits of the axis of effects over bars; effects beyond a limit are drawn at it."""


@styled
def judge_figure(judged: Sequence[JudgedRow], spoilt: Sequence[SpoiltRow]) -> Figure:
    """Differences of right answers over their bars, by kind; mistakes caught and missed."""
    words = "random step loads, ν = −0.9 to 0.49,  f = 0 to 2;  rows in the units of the judgement"
    figure = describe(new_figure(10, 4.8), words)
    right, wrong = figure.subplots(1, 2, width_ratios=(1, 1.25))
    _draw_bars(right, judged)
    _draw_mistakes(wrong, spoilt)
    return figure


def _draw_bars(panel: Axes, judged: Sequence[JudgedRow]) -> None:
    """Draw for each kind the cumulative share of rows over their difference divided by the bar."""
    barred = [row for row in judged if row.group == STEPS and row.tells]
    kinds = dict.fromkeys(row.kind for row in barred)
    styles = [(colour, style) for style in ("-", "--") for colour in cycle()]
    for kind, (colour, style) in zip(kinds, styles, strict=False):
        ratios = np.sort([row.over_bar for row in barred if row.kind == kind])
        if len(ratios) < _LEAST_ROWS:
            continue
        share = np.arange(1, len(ratios) + 1) / len(ratios)
        panel.step(
            np.minimum(ratios, _FARTHEST),
            100 * share,
            style,
            color=colour,
            where="post",
            label=f"{kind} ({len(ratios)})",
        )
    _mark_bars(panel)
    panel.set(
        xlabel="|difference| / error bar",
        ylabel="rows of right answers [%]",
        xlim=(0, _FARTHEST),
        ylim=(0, 100.5),
        title="right answers: alarm beyond the dashed line",
    )
    panel.legend(loc="lower right")


def _draw_mistakes(panel: Axes, spoilt: Sequence[SpoiltRow]) -> None:
    """Every mistake that was tried, by its effect over the bar in the row where that is most."""
    names = [spoil.name for spoil in SPOILS]
    for caught, colour in ((True, BLUE), (False, VERMILLION)):
        part = [row for row in spoilt if row.spoil in names and (row.verdict == DIFFERS) is caught]
        panel.plot(
            np.clip([row.over_bar for row in part], _LEAST_EFFECT, _LARGEST_EFFECT),
            [names.index(row.spoil) + (0.12 if caught else -0.12) for row in part],
            "o" if caught else "x",
            color=colour,
            markersize=4,
        )
    _mark_bars(panel)
    panel.set(
        xlabel="effect at the nodes / error bar, in the row where that is most",
        xscale="log",
        xlim=(0.8 * _LEAST_EFFECT, 1.25 * _LARGEST_EFFECT),
        ylim=(len(names) - 0.4, -0.6),
        title="wrong answers, a quarter to eight times the usual",
    )
    panel.set_yticks(range(len(names)), names, fontsize=SMALL)
    panel.grid(axis="y", color=ink(0.1))
    handles = [
        marker_handle("caught", BLUE, "o", 4),
        marker_handle("not caught", VERMILLION, "x", 4),
    ]
    panel.legend(handles=handles, loc="lower left")


def _mark_bars(panel: Axes) -> None:
    """Draw lines where a difference equals the bar and where it counts as a difference."""
    panel.axvline(1, color=ink(0.65), linewidth=0.8)
    panel.axvline(ALARM, color=ink(0.65), linewidth=0.8, linestyle="--")
