"""Where the methods fail, and what the program does about it: maps and tables of stability.md.

``python -m docs.studies.stability --output docs`` takes two minutes for the solver, half a minute
for the space-time march and a quarter of an hour for finite elements, which fem.md shows.
"""

from __future__ import annotations

import math

import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from compare.figures import style
from docs.studies.runner import Row, Study, drawn, main
from docs.studies.stability.marches import RAN, fem_points, fem_row, march_points, march_row
from docs.studies.stability.solver import GRID_SCENES, solver_points, solver_rows, table

SCENES = r"$f = \chi\,Q_0/P_b$ (preload), $\chi\,Q_0/P_0$ (remote)"
"""Definition of friction in the figures of the solver."""
_FLOOR = 1e-17


CURVES: Row = {"x": "parameter", "y": "value"}
CURVES["failed"] = lambda row: row["status"] not in ("converged", "solved")
LOGARITHMIC = {"xscale": "log", "yscale": "log"}


def _positive(rows: list[Row]) -> list[Row]:
    """Return rows whose values have a place on a logarithmic axis, or are nan."""
    return [row | {"value": row["value"] or math.nan} for row in rows]


def limits_figure(rows: list[Row]) -> Figure:
    """Draw errors and estimates as the Poisson ratio approaches 0.5, 0 and -1."""
    limits = ("0.5", "0+", "0-", "-1")
    return drawn(
        _positive(rows),
        [{"title": rf"$\nu \to {x}$", "where": {"study": f"nu to {x}"}} for x in limits],
        f"edges over $c_t$, slip rates relative;  {SCENES}",
        **CURVES,
        **LOGARITHMIC,
        by=("case", "quantity"),
        xlabel=r"distance of $\nu$ from the limit",
    )


@style.styled
def thresholds_figure(rows: list[Row]) -> Figure:
    """Draw error estimates and numbers of zones near thresholds; crosses are not converged."""
    near = [row for row in rows if row["study"] == "threshold"]
    cases = sorted({row["case"] for row in near})
    distances = sorted({row["parameter"] for row in near})
    values = np.full((len(cases), len(distances)), np.nan)
    figure = style.describe(
        style.new_figure(11, 0.42 * len(cases) + 2.1),
        f"numbers of zones; errors over $c_t$ and $V_0$;  {SCENES}",
    )
    panel = figure.subplots()
    for row in near:
        i, j = cases.index(row["case"]), distances.index(row["parameter"])
        if row["quantity"] == "error estimate" and math.isfinite(row["value"]):
            values[i, j] = max(row["value"], 1e-15)
        elif row["quantity"] == "zones":
            known = row["status"] == "converged"
            mark, colour = (f"{row['value']:.0f}", "white") if known else ("×", style.VERMILLION)
            effects = style.outline(style.BLACK if known else "white")
            panel.text(j, i, mark, ha="center", va="center", color=colour, path_effects=effects)
    image = panel.imshow(values, norm=LogNorm(1e-15, 1e-7), cmap="viridis", aspect="auto")
    panel.set_yticks(range(len(cases)), cases, fontsize=style.SMALL)
    words = [f"${'-+'[x > 0]}10^{{{math.log10(abs(x)):g}}}$" if x else "0" for x in distances]
    panel.set_xticks(range(len(distances)), words, fontsize="x-small")
    panel.set_xlabel("relative distance of friction from the threshold")
    figure.colorbar(image, ax=panel, label="error estimate at rtol 1e-8")
    return figure


def grids_figure(rows: list[Row]) -> Figure:
    """Draw the first stage over the number of nodes: error, odd-even mode, condition, rounds."""
    cases = [f"{loading}, ν = {nu:.3g}, χ = {chi:g}" for loading, nu, chi in GRID_SCENES]
    shown = [(case, name) for case in cases for name in ("slip rate error", "odd-even mode")]
    shown += [(cases[0], "condition"), (cases[0], "rounds")]
    panels = [
        {"where": {"study": "grid", "case": case, "quantity": name}, "title": case, "ylabel": name}
        for case, name in shown
    ]
    words = f"first stage on a grid, slip rates relative; crosses: not solved;  {SCENES}"
    options: Row = {"by": ("method",), "xlabel": "nodes", "xlim": (15, 2500)}
    return drawn(_positive(rows), panels, words, **CURVES, **LOGARITHMIC, **options)


def rules_figure(rows: list[Row]) -> Figure:
    """Draw quadrature nodes against error, estimate against true error, digits lost near c_R."""
    errors = {
        (row["case"], row["parameter"]): row["value"]
        for row in rows
        if row["quantity"] == "true error"
    }
    pairs = [
        row | {"true": max(errors[row["case"], row["parameter"]], _FLOOR)}
        for row in rows
        if row["study"] == "estimate" and row["quantity"] == "error estimate"
    ]
    panels: list[Row] = [
        {"where": {"study": "rule", "quantity": "slip rate error"}, "xlabel": "nodes of all panels"}
        | {"xscale": "linear", "ylabel": "error of the slip rate at the edge"},
        {"where": {"study": "estimate", "quantity": "error estimate"}, "x": "true"}
        | {"xlabel": "true error", "ylabel": "error estimate"},
        {"where": {"study": "near c_R"}, "by": ("case", "method"), "xlabel": "distance from $c$"},
        {"where": {"study": "narrow gap"}, "xlabel": "width of the gap at $c_R$"},
    ]
    figure = drawn(
        [*_positive([row for row in rows if row["quantity"] != "error estimate"]), *pairs],
        panels,
        f"relative errors of edges, slip rates, impedance;  {SCENES}",
        **LOGARITHMIC,
        **{"x": "parameter", "y": "value", "by": ("case",), "ylabel": "relative error"},
    )
    figure.axes[1].plot([1e-15, 1e-2], [1e-15, 1e-2], ":", color=style.ink())
    return figure


def march_figure(rows: list[Row]) -> Figure:
    """Draw the errors of the four parts of the study; crosses at the bottom were refused."""
    labels = {
        "step ratio": (r"$c_t\,\Delta t / h$", "linear"),
        "Poisson ratio": (r"$\nu$", "linear"),
        "friction": (r"$f$ times pressure over shear of the load", "log"),
        "end time": (r"end time, at constant $h$", "log"),
    }
    common: Row = {"x": "parameter", "y": "percent", "by": ("case",), "yscale": "log"}
    common |= {"ylabel": "L1 error of slip rate [%]", "failed": lambda row: row["status"] != RAN}
    return drawn(
        [row | {"percent": 100 * row["error"]} for row in rows],
        [
            {"where": {"study": study}, "xlabel": label, "xscale": scale}
            for study, (label, scale) in labels.items()
        ],
        "marches of preloaded (f = 0.3) and remote-shock (f = 1.25), ν = 1/3, one thing varied",
        **common,
    )


STUDIES = [
    Study(
        "stability-solver",
        solver_points,
        solver_rows,
        table,
        {
            "stability-limits": limits_figure,
            "stability-thresholds": thresholds_figure,
            "stability-grids": grids_figure,
            "stability-rules": rules_figure,
        },
    ),
    Study(
        "stability-space-time",
        march_points,
        march_row,
        figures={"stability-space-time": march_figure},
    ),
    Study("fem-stability", fem_points, fem_row),
]

if __name__ == "__main__":
    raise SystemExit(main("docs.studies.stability", STUDIES))
