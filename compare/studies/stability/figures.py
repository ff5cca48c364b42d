"""Figures of the stability study of the solver."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator, ScalarFormatter

from compare.figures.saving import save_figure
from compare.figures.style import (
    BLACK,
    BLUE,
    GREEN,
    SMALL,
    VERMILLION,
    describe,
    ink,
    new_figure,
    outline,
    styled,
)
from compare.studies.stability.sweeps import StudyRow

PLACEMENT_STYLE = {
    "galerkin": (BLUE, "Galerkin"),
    "nodes": (VERMILLION, "collocation at nodes"),
    "midpoints": (GREEN, "collocation at mid-points"),
}
FLOOR = 1e-17

SCENES = r"$f = \chi\,Q_0/P_b$ (preload), $\chi\,Q_0/P_0$ (remote)"
"""Definition of friction in all figures."""


def save_figures(output: Path, rows: Sequence[StudyRow], form: str = "png") -> None:
    """Write all figures of the study into a folder, in a format."""
    save_figure(limits_figure(rows), output / f"stability-limits.{form}")
    save_figure(thresholds_figure(rows), output / f"stability-thresholds.{form}")
    save_figure(grids_figure(rows), output / f"stability-grids.{form}")
    save_figure(rules_figure(rows), output / f"stability-rules.{form}")


@styled
def limits_figure(rows: Sequence[StudyRow]) -> Figure:
    """Draw errors and estimates as the Poisson ratio approaches 0.5, 0 and -1."""
    studies = sorted({row.study for row in rows if row.study.startswith("nu to")})
    words = f"edges over $c_t$, slip rates relative;  {SCENES}"
    figure = describe(new_figure(3.4 * len(studies), 4.6), words)
    panels = figure.subplots(1, len(studies), sharey=True, squeeze=False)[0]
    for panel, study in zip(panels, studies, strict=True):
        for (case, quantity), part in _curves(rows, study, ("case", "quantity")):
            label = quantity + ("" if quantity != "error estimate" else f", {case}")
            (line,) = panel.loglog(*_xy(part), ".-", label=label, markersize=4, linewidth=1)
            failed = [row for row in part if row.status != "converged"]
            x, y = _xy(failed)
            panel.loglog(x, y, "x", color=line.get_color(), markersize=8)
        panel.set(title=_limit_title(study), xlabel=r"distance of $\nu$ from the limit")
    panels[0].set_ylabel("error, error estimate")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3, frameon=False)
    return figure


def _limit_title(study: str) -> str:
    limit, side = study.removeprefix("nu to ").rstrip("+-"), study[-1]
    return rf"$\nu \to {limit}$" + {"+": ", from above", "-": ", from below"}.get(side, "")


@styled
def thresholds_figure(rows: Sequence[StudyRow]) -> Figure:
    """Draw error estimates and numbers of zones near thresholds; crosses are not converged."""
    estimates = [row for row in rows if row.study == "threshold"]
    cases = sorted({row.case for row in estimates})
    distances = sorted({row.parameter for row in estimates})
    values = np.full((len(cases), len(distances)), np.nan)
    words = f"numbers of zones; errors over $c_t$ and $V_0$;  {SCENES}"
    figure = describe(new_figure(11, 0.42 * len(cases) + 2.1), words)
    panel = figure.subplots()
    for row in estimates:
        i, j = cases.index(row.case), distances.index(row.parameter)
        if row.quantity == "error estimate" and math.isfinite(row.value):
            values[i, j] = row.value
        if row.quantity == "zones" and row.status == "converged":
            panel.text(
                j,
                i,
                f"{row.value:.0f}",
                ha="center",
                va="center",
                color="white",
                path_effects=outline(BLACK),
            )
        elif row.quantity == "zones":
            panel.plot(j, i, "x", color=VERMILLION, markersize=8, path_effects=outline())
    image = panel.imshow(
        np.maximum(values, 1e-15), norm=LogNorm(1e-15, 1e-7), cmap="viridis", aspect="auto"
    )
    panel.set_yticks(range(len(cases)), cases, fontsize=SMALL)
    panel.set_xticks(range(len(distances)), [_distance(d) for d in distances], fontsize="x-small")
    panel.set_xlabel("relative distance of friction from the threshold")
    figure.colorbar(image, ax=panel, label="error estimate at rtol 1e-8")
    return figure


def _distance(value: float) -> str:
    if value == 0:
        return "0"
    exponent = math.log10(abs(value))
    sign = "−" if value < 0 else "+"
    return f"${sign}10^{{{exponent:g}}}$"


@styled
def grids_figure(rows: Sequence[StudyRow]) -> Figure:
    """Draw the first stage over the number of nodes: error, odd-even mode, condition, rounds."""
    figure = describe(new_figure(10, 7.8), f"slip rates relative;  {SCENES}")
    panels = figure.subplots(2, 2).ravel()
    cases = sorted({row.case for row in rows if row.study == "grid"})
    styles = dict(zip(cases, ("-", "--", ":", "-."), strict=False))
    for panel, quantity in zip(
        panels, ("slip rate error", "odd-even mode", "condition", "rounds"), strict=True
    ):
        measured = [row for row in rows if row.quantity == quantity]
        for (case, method), part in _curves(measured, "grid", ("case", "method")):
            placement, way = method.split(", ")
            colour, _ = PLACEMENT_STYLE[placement]
            if quantity == "rounds":
                _draw_rounds(panel, part, colour, styles[case], way)
            elif way == "pivoting" and not (quantity == "condition" and case != cases[0]):
                panel.loglog(*_xy(part), ".", linestyle=styles[case], color=colour)
        panel.set(xlabel="nodes", ylabel=quantity, xscale="log", yscale="log")
        panel.set_xticks([20, 50, 100, 200, 500, 1000, 2000], minor=False)
        panel.xaxis.set_major_formatter(ScalarFormatter())
        panel.xaxis.set_minor_locator(NullLocator())
    panels[2].set_ylabel("condition number, unit diagonal")
    panels[3].set_ylabel("pivots (·), active-set rounds (o, × no end)")
    panels[1].set_ylabel("odd–even mode / largest slip rate")
    for colour, label in PLACEMENT_STYLE.values():
        panels[0].plot([], [], color=colour, label=label)
    for case, style in styles.items():
        panels[0].plot([], [], style, color=ink(0.7), label=case)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3, frameon=False)
    return figure


def _draw_rounds(panel: Axes, part: Sequence[StudyRow], colour: str, style: str, way: str) -> None:
    solved = [row for row in part if row.status == "solved"]
    if way == "pivoting":
        panel.loglog(*_xy(solved), ".", linestyle=style, color=colour)
        return
    panel.loglog(*_xy(solved), "o", color=colour, markersize=5, fillstyle="none")
    panel.loglog(*_xy([row for row in part if row not in solved]), "x", color=colour)


@styled
def rules_figure(rows: Sequence[StudyRow]) -> Figure:
    """Draw quadrature nodes against error, estimate against true error, digits lost near c_R."""
    words = f"relative errors of edges, slip rates, impedance;  {SCENES}"
    figure = describe(new_figure(12, 4.6), words)
    left, middle, right = figure.subplots(1, 3)
    for (case,), part in _curves(
        [row for row in rows if row.quantity == "slip rate error"], "rule", ("case",)
    ):
        left.semilogy(*_xy(part), ".-", label=case)
    left.set(xlabel="nodes of all panels", ylabel="error of the slip rate at the edge")
    for (case,), group in _curves(rows, "estimate", ("case",)):
        by_rtol: dict[float, dict[str, float]] = {}
        for row in group:
            by_rtol.setdefault(row.parameter, {})[row.quantity] = row.value
        pairs = [(max(p["true error"], FLOOR), p["error estimate"]) for p in by_rtol.values()]
        middle.loglog(*np.array(sorted(pairs)).T, ".-", label=case, linewidth=0.8)
    middle.loglog([1e-15, 1e-2], [1e-15, 1e-2], ":", color=ink())
    middle.set(xlabel="true error", ylabel="error estimate")
    for (case, method), part in _curves(rows, "near c_R", ("case", "method")):
        right.loglog(*_xy(part), ".-", label=f"impedance {method}, {case}", linewidth=0.8)
    for (case,), part in _curves(rows, "narrow gap", ("case",)):
        right.loglog(*_xy(part), "s-", label=f"gap of the solver, {case}", markersize=4)
    right.set(xlabel="distance from $c$, width of the gap", ylabel="relative error")
    for panel in (left, middle, right):
        panel.legend()
    return figure


def _curves(
    rows: Iterable[StudyRow], study: str, keys: tuple[str, ...]
) -> Iterator[tuple[tuple[str, ...], list[StudyRow]]]:
    """Yield the rows of a study in groups of equal keys, each by ascending parameter."""

    def key(row: StudyRow) -> tuple[str, ...]:
        return tuple(getattr(row, name) for name in keys)

    chosen = sorted((row for row in rows if row.study == study), key=key)
    for values, group in groupby(chosen, key=key):
        yield values, sorted(group, key=lambda row: row.parameter)


def _xy(rows: Iterable[StudyRow]) -> tuple[list[float], list[float]]:
    kept = [row for row in rows if math.isfinite(row.value)]
    return [row.parameter for row in kept], [max(row.value, FLOOR) for row in kept]
