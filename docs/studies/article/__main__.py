"""The article reproduced: its figures, its claims, and the readings of its algorithm.

Slip and slip rates are relative, twice those of the article, in units of V_0 = 2 Q_0/(mu b).
``python -m docs.studies.article --output docs`` makes the tables and figures of article.md.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from compare.comparison.scales import wave_speeds
from compare.figures.style import RATE_LABEL, cycle, describe, mark_waves, new_figure, styled
from docs.studies.article.cases import (
    CASES,
    END_TIME,
    SHEAR_SPEED,
    Case,
    Cases,
    run_case,
    run_cases,
    slot_errors,
    slot_rows,
)
from docs.studies.article.claims import CLAIMS, METHODS
from docs.studies.article.stuck import stuck_pressure, stuck_shear
from docs.studies.runner import Row, Study, drawn, main
from semianalytic.reference import DEFAULT_READING, published_slip
from semianalytic.scene.loads import Step

Array = NDArray[np.float64]
Curves = Callable[[Case, str], tuple[Array, Array]]

_VELOCITY = np.linspace(0.004, 2.05, 1200)  # x/(c_t t)
UNITS = (
    r"$\nu$ = 1/3, $c_t$ = 5, $t$ = 0.01, $f P_0$ = 1, $\chi = f P_0/Q_0$;  "
    r"$V_0 = 2 Q_0/(\mu b)$ = $2 Q_0/(\rho c_t)$"
)
"""Parameters that hold in all figures of the article."""


def _resolution(quick: bool) -> int:
    """Elements per c_t T."""
    return 60 if quick else 200


def case_row(kind: str, chi: float, resolution: int) -> Row:
    """Return the mean difference of exact and simulated slip rates of a case, over V_0."""
    case = run_case(kind, chi, resolution)
    return {
        "base": "remote" if kind == "remote" else "preloaded",
        "chi": chi,
        "poisson_ratio": case.solution.scene.material.poisson_ratio,
        "difference": case.difference(),
    }


def claim_rows(resolution: int) -> list[Row]:
    """Judge all claims by the three methods."""
    cases = run_cases(resolution)
    return [judge(cases) | {"resolution": resolution} for judge in CLAIMS]


def claims_table(rows: list[Row]) -> list[Row]:
    """Return the claims without the resolution, which the figures know them by."""
    return [{name: row[name] for name in row if name != "resolution"} for row in rows]


def _panels(columns: int, lines: int = 1) -> tuple[Figure, Any]:
    figure = describe(new_figure(12 if columns == 3 else 9, 3.6 * lines + 0.2), UNITS)
    return figure, figure.subplots(lines, columns, squeeze=False)


@styled
def figure_2(cases: Cases) -> Figure:
    """Draw stuck pressure p* and shear q* at three times: (3.10), (3.14) and finite elements.

    The simulation has the remote load with chi = 2, under which the whole contact sticks.
    """
    case = cases["remote", 2.0]
    material, history = case.solution.scene.material, case.history
    figure, [panels] = _panels(2)
    x = np.linspace(2e-4, 0.11, 1200)
    before = case.solution.scene.superposition.in_place
    fields = (
        (stuck_pressure, history.pressure - before.pressure, "$p^*/P_0$"),
        (stuck_shear, (history.shear_traction - before.shear) * case.chi, "$q^*/Q_0$"),
    )
    for panel, (predict, simulated, label) in zip(panels, fields, strict=True):
        for part, colour in zip((0.4, 0.7, 1.0), cycle(), strict=False):
            row = int(np.searchsorted(history.t, part * END_TIME * 0.999))
            value = predict(Step(), 1.0, material, x, history.t[row]).value
            panel.plot(x, value, color=colour, label=f"t = {history.t[row]:.4f}")
            panel.plot(history.x, simulated[row], ".", color=colour, markersize=2.5)
        panel.set(xlabel="x", ylabel=label, ylim=(-0.12, 0.6), xlim=(0, 0.11))
        panel.legend(title="lines exact, dots FEM")
    return figure


def _rate_curves(case: Case, method: str) -> tuple[Array, Array]:
    """Return x/(c_t T) and the slip rate of a method; the published method has no base."""
    if method == "exact":
        return _VELOCITY, case.exact(_VELOCITY)
    if method != "published":
        return case.simulated()
    slip = published_slip(case.chi)
    return 1 / slip.u[::-1], case.chi * slip.slip_rate[::-1]


def _slip_curves(case: Case, method: str) -> tuple[Array, Array]:
    """Return x/(c_t T) and the relative slip over V_0 T of a method."""
    if method == "exact":
        total = case.solution.slip(_VELOCITY * SHEAR_SPEED * END_TIME, END_TIME)
        return _VELOCITY, total / (case.scale * END_TIME)
    if method != "published":
        return case.simulated()[0], case.history.slip[-1] / (case.scale * case.history.t[-1])
    slip = published_slip(case.chi)
    total = np.cumsum(slip.slip_rate * np.diff(slip.u, prepend=1.0)) / slip.u
    return 1 / slip.u[::-1], case.chi * total[::-1]


def _draw(panels: Sequence[Axes], cases: Sequence[Case], curves: Curves, label: str) -> None:
    """Draw a panel for each method; the published one knows no preload."""
    for panel, method in zip(panels, METHODS, strict=True):
        shown = [one for one in cases if method != "published" or one.kind == "remote"]
        for case, colour in zip(shown, cycle(), strict=False):
            velocity, value = curves(case, method)
            name = rf"$\chi$ = {case.chi:g}" + (", preloaded" * (case.kind == "preloaded"))
            line = "." if method == "finite_elements" else "-"
            style: dict[str, Any] = {"color": colour, "markersize": 2, "linewidth": 1.2}
            panel.plot(velocity * SHEAR_SPEED * END_TIME, value, line, label=name, **style)
        title = f"published, {DEFAULT_READING.signs}" if method == "published" else method
        panel.set(xlabel="x", xlim=(0, 0.105))
        panel.set_title(title.replace("_", " "), pad=14)
        mark_waves(panel, wave_speeds(cases[0].solution.scene.material), 1 / END_TIME)
        panel.legend()
    panels[0].set_ylabel(label)


@styled
def figure_5(cases: Cases) -> Figure:
    """Draw the slip rate for chi > 1 at t = 0.01: published algorithm, exact, finite elements."""
    figure, [panels] = _panels(3)
    chosen = [cases[one] for one in (("remote", 1.2), ("remote", 2.0), ("preloaded", 2.0))]
    _draw(panels, chosen, _rate_curves, RATE_LABEL)
    panels[0].set_ylim(-1.0, 0.6)
    return figure


@styled
def figure_6(cases: Cases) -> Figure:
    """Draw slip rate (above) and slip (below) for chi < 1 at t = 0.01, by the three methods."""
    figure, lines = _panels(3, 2)
    chosen = [cases[one] for one in CASES if one[1] < 1 and one[0] != "auxetic"]
    _draw(lines[0], chosen, _rate_curves, RATE_LABEL)
    _draw(lines[1], chosen, _slip_curves, r"slip $/\ (V_0 t)$")
    lines[0][0].set_ylim(-1.5, 0.4)
    return figure


def slot_figure(rows: list[Row]) -> Figure:
    """Draw the traction under a prescribed pulse of slip: simulation and kernels, both modes."""
    names = {
        "free": "kernel, slot face free",
        "held": "kernel, slot face held, (4.31), (4.37)",
        "simulated": "FEM",
    }
    curves = [
        {"mode": row["mode"], "x": row["x"], "by": label, "traction": row[name]}
        for name, label in names.items()
        for row in rows
    ]
    panel = {"x": "x", "y": "traction", "by": ("by",), "marker": "-", "ylabel": "traction"}
    words = r"smooth pulse of slip, $\nu$ = 1/3, $f$ without effect, units $c_t$ = $\mu$ = $t$ = 1"
    modes = dict.fromkeys(row["mode"] for row in rows)
    panels = [
        panel | {"where": {"mode": one}, "title": f"mode {one}", "xlabel": "x"} for one in modes
    ]
    return drawn(curves, panels, words)


def _of_cases(draw: Callable[[Cases], Figure]) -> Callable[[list[Row]], Figure]:
    return lambda rows: draw(run_cases(rows[0]["resolution"]))


STUDIES = [
    Study("article-cases", lambda quick: [(*one, _resolution(quick)) for one in CASES], case_row),
    Study(
        "article-claims",
        lambda quick: [(_resolution(quick),)],
        claim_rows,
        claims_table,
        {
            "article-figure2": _of_cases(figure_2),
            "article-figure5": _of_cases(figure_5),
            "article-figure6": _of_cases(figure_6),
        },
    ),
    Study(
        "article-slots",
        lambda quick: [(mode, 0.01 if quick else 0.005) for mode in ("II", "I")],
        slot_rows,
        slot_errors,
        {"article-slot": slot_figure},
    ),
]

if __name__ == "__main__":
    raise SystemExit(main("docs.studies.article", STUDIES))
