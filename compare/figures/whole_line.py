"""Figures of whole lines and growing loads: rates of slip or opening, tractions and strength."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from compare.comparison.scales import wave_speeds
from compare.figures.style import (
    PREDICTION,
    RATE_LABEL,
    SPEED_LABEL,
    TRACTION_LABEL,
    describe,
    line_handle,
    mark_waves,
    new_figure,
    shade,
    styled,
)
from semianalytic import (
    GrowingSlot,
    GrowingSolution,
    LineSolution,
    Patch,
    PointForce,
    WholeLine,
)

Array = NDArray[np.float64]

POINTS = 1500
_NEAR = np.geomspace(1e-7, 1e-2, 60)
"""Distances, over the width of the figure, of points on either side of a singular one."""
_TALLEST = 1.6
"""Height of a panel over the largest rate at `_AWAY` from a point where rates are infinite."""
_AWAY = 0.004


@styled
def line_figure(
    answer: LineSolution | GrowingSolution, *, axes: tuple[Axes, Axes] | None = None
) -> Figure:
    """Draw rate of slip or opening above, and traction with the strength that bounds it below."""
    whole = isinstance(answer, LineSolution)
    problem = answer.line if isinstance(answer, LineSolution) else answer.slot
    unit, opens = problem.material.shear_speed, bool(answer.openings)
    if axes is None:
        figure = describe(new_figure(7, 5.4), _words(answer))
        upper, lower = figure.subplots(2, 1, sharex=True)
    else:
        upper, lower = axes
    xi, singular = _velocities(answer)
    x = unit * xi
    inner = -answer.edge_speed if whole else 0.0
    for panel in (upper, lower):
        panel.axvspan(inner / unit, answer.edge_speed / unit, color=shade("slip"), zorder=0)
        speeds = wave_speeds(problem.material)
        mark_waves(panel, speeds, unit, labels=panel is upper)
        if whole:
            mark_waves(panel, speeds, -unit, labels=False)
    rate = answer.gap_rate(x, 1.0) if isinstance(answer, LineSolution) and opens else None
    rate = answer.slip_rate(x, 1.0) if rate is None else rate
    scale = stress_unit(problem)
    rate = rate / (2 * scale / problem.material.shear_impedance)
    upper.plot(xi, rate, color=PREDICTION)
    away = np.abs(xi[:, None] - singular).min(axis=1) > _AWAY if len(singular) else xi > 0
    tallest = _TALLEST * np.abs(rate[away]).max()
    if len(singular):
        upper.set_ylim(*((0, tallest) if rate[away].max() > 0 else (-tallest, 0)))
    upper.set_ylabel("rate of opening" if opens else RATE_LABEL)
    held = answer.pressure(x, 1.0)
    traction = held if opens else answer.shear_traction(x, 1.0)
    lower.plot(xi, traction / scale, color=PREDICTION)
    handles = [line_handle("pressure" if opens else "shear traction", PREDICTION)]
    if not opens:
        lower.plot(
            xi, answer.zones[0].sense * problem.friction * held / scale, ":", color=PREDICTION
        )
        handles.append(line_handle("strength f p", PREDICTION, ":"))
    lower.legend(handles=handles, loc="best")
    lower.set(xlabel=SPEED_LABEL, ylabel=TRACTION_LABEL, xlim=(xi[0], xi[-1]))
    drawn = upper.get_figure(root=True)
    assert drawn is not None  # axes in use always belong to a figure
    return drawn


def stress_unit(problem: WholeLine | GrowingSlot) -> float:
    """Return the stress τ₀ in which figures are drawn, at t = 1: the excess, or the load."""
    if isinstance(problem, GrowingSlot):
        return abs(problem.load.shear)
    point = isinstance(problem.load, PointForce)
    return problem.excess / (problem.material.shear_speed if point else 1.0)


def _words(answer: LineSolution | GrowingSolution) -> str:
    """Return a title: the solid, friction, what loads the interface, and the units of the axes."""
    if isinstance(answer, GrowingSolution):
        problem: WholeLine | GrowingSlot = answer.slot
        unit, load = f"Q₀ t^{answer.slot.power}", "load and strength grow as t^n,  "
    else:
        problem, load = answer.line, ""
        point = isinstance(answer.line.load, PointForce)
        unit = "F₀ / cₜ" if point else "excess of the patch"
    mode = "antiplane shear,  " if problem.antiplane else ""
    return (
        f"{mode}ν = {problem.material.poisson_ratio:.4g},  f = {problem.friction:.3g},  "
        f"base ({problem.base.pressure:.3g}, {problem.base.shear:.3g}),  {load}"
        f"t = 1,  τ₀ = {unit} = {stress_unit(problem):.3g},  V₀ = 2 τ₀ / ρcₜ"
    )


def _velocities(answer: LineSolution | GrowingSolution) -> tuple[Array, Array]:
    """Return x/(c_t t) for smooth curves, and those at which the rate is infinite."""
    if isinstance(answer, LineSolution):
        material, load = answer.line.material, answer.line.load
        ends = [load.speed, -load.speed] if isinstance(load, Patch) else [0.0]
    else:
        material, ends = answer.slot.material, []
    unit = material.shear_speed
    outer = 1.05 * material.longitudinal_speed / unit
    inner = -outer if isinstance(answer, LineSolution) else outer / POINTS
    singular, edge = np.array(ends) / unit, answer.edge_speed / unit
    marks = np.concatenate([singular, [edge, -edge]])
    close = (marks[:, None] + outer * np.concatenate([-_NEAR, _NEAR])).ravel()
    xi = np.unique(np.concatenate([np.linspace(inner, outer, POINTS), close]))
    known = (xi >= inner) & (xi <= outer) & ~np.isin(xi, singular)
    return xi[known], singular
