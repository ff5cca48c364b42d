"""The article's figures 2, 5 and 6 redrawn, and the demonstration of the slot condition.

Every function returns a Figure.  Slip rates are one-sided, in units of Q_0/(mu b).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from compare.article_cases import END_TIME, SHEAR_SPEED, Case, Cases, SlotCheck
from semianalytic.histories import stuck_pressure, stuck_shear
from semianalytic.loads import Step
from semianalytic.published import DEFAULT_READING, published_slip

Array = NDArray[np.float64]

COLOURS = ("#12355b", "#d1495b", "#2a9d8f", "#e9a23b", "#7b5ea7")
_ABOVE = (1.2, 2.0)
_BELOW = (0.01, 0.5, 0.9)
_VELOCITY = np.linspace(0.004, 2.05, 1200)  # x/(c_t t)


def _panels(columns: int, width: float, rows: int = 1) -> tuple[Figure, list[list[Axes]]]:
    figure = Figure(figsize=(width, 3.6 * rows), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False)
    return figure, [list(row) for row in axes]


def _mark_fronts(panel: Axes, case: Case) -> None:
    material = case.solution.scene.material
    for speed in (material.rayleigh_speed, material.shear_speed, material.longitudinal_speed):
        panel.axvline(speed * END_TIME, color="0.6", linestyle="--", linewidth=0.8, zorder=0)


def figure_2(cases: Cases) -> Figure:
    """Stuck pressure p* and shear q* at three times: (3.10), (3.14) and finite elements.

    The simulation is the remote load with chi = 2, which sticks everywhere.
    """
    case = cases.remote[2.0]
    material, history = case.solution.scene.material, case.history
    figure, [panels] = _panels(2, 9)
    rows = [np.searchsorted(history.t, part * END_TIME * 0.999) for part in (0.4, 0.7, 1.0)]
    x = np.linspace(2e-4, 0.11, 1200)
    base = case.solution.scene.base
    fields = (
        (stuck_pressure, history.pressure - base.pressure, 1.0, "$p^*/P_0$"),
        (stuck_shear, (history.shear_traction - base.shear) * case.chi, 1.0, "$q^*/Q_0$"),
    )
    for panel, (predict, seen, amplitude, label) in zip(panels, fields, strict=True):
        for row, colour in zip(rows, COLOURS, strict=False):
            time = history.t[row]
            value = predict(Step(), amplitude, material, x, time).value
            panel.plot(x, value, color=colour, label=f"t = {time:.4f}")
            panel.plot(history.x[1:], seen[row, 1:], ".", color=colour, markersize=2.5)
        panel.set(xlabel="x", ylabel=label, ylim=(-0.12, 0.6), xlim=(0, 0.11))
        panel.legend(fontsize=8, title="lines exact, dots FEM", title_fontsize=8)
    return figure


def _rate_curves(case: Case, method: str) -> tuple[Array, Array]:
    """x/(c_t T) and slip rate of a method; the published one has no base."""
    if method == "exact":
        return _VELOCITY, case.exact(_VELOCITY)
    if method == "finite elements":
        return case.simulated()
    slip = published_slip(case.chi)
    return 1 / slip.u[::-1], case.chi * slip.slip_rate[::-1]


def _slip_curves(case: Case, method: str) -> tuple[Array, Array]:
    """x/(c_t T) and one-sided slip over Q_0 T/(mu b)."""
    if method == "exact":
        total = case.solution.slip(_VELOCITY * SHEAR_SPEED * END_TIME, END_TIME)
        return _VELOCITY, total / (case.scale * END_TIME)
    if method == "finite elements":
        velocity, _ = case.simulated()
        return velocity, case.history.slip[-1, 1:] / (case.scale * case.history.t[-1])
    slip = published_slip(case.chi)
    steps = np.diff(slip.u, prepend=1.0)
    total = np.cumsum(slip.slip_rate * steps) / slip.u
    return 1 / slip.u[::-1], case.chi * total[::-1]


_METHODS = ("published", "exact", "finite elements")


def _draw(panel: Axes, cases: Sequence[Case], method: str, curves: object, style: str) -> None:
    for case, colour in zip(cases, COLOURS, strict=False):
        velocity, value = curves(case, method)  # type: ignore[operator]
        label = rf"$\chi$ = {case.chi:g}" + (", preloaded" if case.base == "preloaded" else "")
        panel.plot(
            velocity * SHEAR_SPEED * END_TIME,
            value,
            style if method == "finite elements" else "-",
            color=colour,
            markersize=2,
            linewidth=1.2,
            label=label,
        )
    _mark_fronts(panel, cases[0])
    panel.set(xlim=(0, 0.105))


def figure_5(cases: Cases) -> Figure:
    """Slip rate for chi > 1 at t = 0.01: published algorithm, exact solution, finite elements."""
    chosen = [*(cases.remote[chi] for chi in _ABOVE), cases.preloaded[2.0]]
    figure, [panels] = _panels(3, 12)
    for panel, method in zip(panels, _METHODS, strict=True):
        shown = chosen[:2] if method == "published" else chosen
        _draw(panel, shown, method, _rate_curves, ".")
        panel.set(xlabel="x", title=_title(method))
        panel.legend(fontsize=8)
    panels[0].set(ylabel=r"$V\ /\ (Q_0/\mu b)$", ylim=(-1.0, 0.6))
    return figure


def figure_6(cases: Cases) -> Figure:
    """Slip rate (above) and slip (below) for chi < 1 at t = 0.01, by the three methods."""
    remote = [cases.remote[chi] for chi in _BELOW]
    preloaded = [cases.preloaded[chi] for chi in _BELOW if chi in cases.preloaded]
    figure, rows = _panels(3, 12, rows=2)
    for panels, curves, label in zip(
        rows,
        (_rate_curves, _slip_curves),
        (r"$V\ /\ (Q_0/\mu b)$", r"$u_x\ /\ (Q_0 t/\mu b)$"),
        strict=True,
    ):
        for panel, method in zip(panels, _METHODS, strict=True):
            shown = remote if method == "published" else [*remote, *preloaded]
            _draw(panel, shown, method, curves, ".")
            panel.set(xlabel="x", title=_title(method))
            panel.legend(fontsize=8)
        panels[0].set(ylabel=label)
    rows[0][0].set_ylim(-1.5, 0.4)
    return figure


def _title(method: str) -> str:
    return f"published, {DEFAULT_READING.signs}" if method == "published" else method


def slot_figure(checks: Sequence[SlotCheck]) -> Figure:
    """Traction under a prescribed pulse of slip: simulation against both kernels, both modes."""
    figure, [panels] = _panels(len(checks), 4.8 * len(checks))
    for panel, check in zip(panels, checks, strict=True):
        edge = int(np.searchsorted(check.x, 0.0))
        x, free, held = (np.insert(v, edge, np.nan) for v in (check.x, check.free, check.held))
        panel.plot(x, free, color=COLOURS[0], label="kernel, slot face free")
        panel.plot(x, held, color=COLOURS[3], label="kernel, slot face held, (4.31), (4.37)")
        panel.plot(check.x, check.simulated, ".", color=COLOURS[1], markersize=3, label="FEM")
        panel.axvline(0, color="0.6", linewidth=0.8)
        panel.set(xlabel="x", ylabel="traction", title=f"mode {check.mode}")
        panel.legend(fontsize=8)
    return figure
