"""Figures of the evidence page, and its profiles over time, with all methods in one panel."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from compare.comparison.case import EDGE_CELLS
from compare.comparison.scales import WAVE_SYMBOLS, scene_fronts, slip_rate_scale, stress_scale
from compare.figures.style import (
    BLACK,
    BLUE,
    BROWN,
    GREEN,
    MARCH,
    PLACE_LABEL,
    PREDICTION,
    RATE_LABEL,
    SIMULATION,
    TIME_LABEL,
    TRACTION_LABEL,
    VERMILLION,
    LineStyle,
    describe,
    ink,
    line_handle,
    mark_waves,
    marker_handle,
    new_figure,
    styled,
)
from compare.figures.style import PUBLISHED as PUBLISHED_COLOUR
from compare.studies.evidence.study import FEM, PUBLISHED, SceneEvidence

Array = NDArray[np.float64]

COLOURS = {
    "self-similar": PREDICTION,
    "space-time": MARCH,
    FEM: SIMULATION,
    PUBLISHED: PUBLISHED_COLOUR,
}
"""Colour of each method, in figures and in the profiles that follow the slider."""
LINES: Mapping[str, LineStyle] = {"self-similar": "-", "space-time": "--", PUBLISHED: "-."}
FRAMES = 33
STEPS_OF_UNIT, LARGEST = 2000, 9999
"""Units of a profile per height of its panel, and the largest value in these units."""
NEAR_EDGE = 0.05
"""Fraction of the waves' reach, next to the edge, where singular tractions may leave the panel."""


@styled
def rates_figure(evidence: SceneEvidence) -> Figure:
    """Draw the slip rate at T by all methods, and differences from the first of them."""
    scale = slip_rate_scale(evidence.scene)
    rates = {name: h.slip_rate[-1] / scale for name, h in evidence.histories.items()}
    unjudged = {}
    if evidence.published is not None:
        unjudged[PUBLISHED] = evidence.published_rate()[-1] / scale
    figure, (upper, lower), place = _pair(evidence)
    for name, values in {**rates, **unjudged}.items():
        _draw(upper, name, place, values)
    upper.set_ylim(*_panel_limits([values[EDGE_CELLS:] for values in rates.values()]))
    upper.set_ylabel(RATE_LABEL)
    upper.legend(handles=_handles([*rates, *unjudged]), loc="best")
    _draw_differences(lower, place, rates)
    return figure


@styled
def tractions_figure(evidence: SceneEvidence) -> Figure:
    """Draw shear traction and friction bound ± f p at T by all methods; differences in shear."""
    scale = stress_scale(evidence.scene)
    figure, (upper, lower), place = _pair(evidence)
    shear = {}
    for name, history in evidence.histories.items():
        shear[name] = history.shear_traction[-1] / scale
        bound = evidence.scene.friction * history.pressure[-1] / scale
        _draw(upper, name, place, shear[name])
        for sign in (1, -1):
            upper.plot(place, sign * bound, ":", color=COLOURS[name], linewidth=1)
    upper.set_ylim(*_panel_limits([values[_ahead(place)] for values in shear.values()]))
    upper.set_ylabel(TRACTION_LABEL)
    handles = [*_handles(shear), line_handle(r"bound $\pm f p$", ink(0.7), ":")]
    upper.legend(handles=handles, loc="best")
    _draw_differences(lower, place, shear)
    return figure


@styled
def energy_figure(evidence: SceneEvidence) -> Figure:
    """Draw the energies of the finite-element model over time, and the work of the loads."""
    energy, unit = evidence.simulation.energy, energy_unit(evidence)
    figure = describe(new_figure(7, 3.8), evidence.scene)
    panel = figure.subplots()
    for name, values, colour in (
        ("work of the loads", energy.external, ink()),
        ("kinetic", energy.kinetic, BLUE),
        ("strain", energy.strain, GREEN),
        ("friction", energy.friction, VERMILLION),
        ("damping", energy.damping, BROWN),
    ):
        time = energy.t / evidence.simulation.end_time
        panel.plot(time, values / unit, color=colour, label=name)
    panel.legend()
    panel.set(xlabel=TIME_LABEL, ylabel=r"energy $/\ \tau_0 V_0 c_t T^2$", xlim=(0, 1))
    return figure


@styled
def opening_figure(evidence: SceneEvidence) -> Figure:
    """Draw where the contact is open over space and time in the finite-element model."""
    simulation, speed = evidence.simulation, evidence.scene.material.shear_speed
    history, end = simulation.interface, simulation.end_time
    figure = describe(new_figure(7, 3.8), evidence.scene)
    panel = figure.subplots()
    place = history.x / (speed * end)
    panel.pcolormesh(
        place, history.t / end, simulation.is_open, shading="nearest", cmap="Greys", rasterized=True
    )
    panel.set(xlabel=PLACE_LABEL, ylabel=TIME_LABEL, xlim=(0, place[-1]), ylim=(0, 1))
    panel.set_title("open (dark) or closed", pad=16)
    fronts = scene_fronts(evidence.scene)
    mark_waves(panel, fronts, speed, "rays", colour=BLACK, outlined="white")
    return figure


def energy_unit(evidence: SceneEvidence) -> float:
    """Return the unit of energies per thickness, τ₀ V₀ c_t T² [stress length²]."""
    scene, end = evidence.scene, evidence.simulation.end_time
    area = scene.material.shear_speed * end**2
    return stress_scale(scene) * slip_rate_scale(scene) * area


def profiles(anchor: str, evidence: SceneEvidence) -> dict[str, Any]:
    """Return profiles over x/(c_t T) at 33 times, as integers in a unit of each curve.

    Curves are the slip rate over V₀, and shear traction and friction bound over τ₀.
    """
    scene, histories = evidence.scene, evidence.histories
    first, material = histories[FEM], scene.material
    end = first.t[-1]
    levels = np.unique(np.linspace(0, len(first.t) - 1, FRAMES).round().astype(int))
    place = first.x / (material.shear_speed * end)
    rate, stress = slip_rate_scale(scene), stress_scale(scene)
    rates = {name: h.slip_rate[levels] / rate for name, h in histories.items()}
    shear = {name: h.shear_traction[levels] / stress for name, h in histories.items()}
    bound = {name: scene.friction * h.pressure[levels] / stress for name, h in histories.items()}
    framed = shear if evidence.judgements else {**shear, "bound": bound[FEM]}
    around_rates = _panel_limits([values[:, EDGE_CELLS:] for values in rates.values()])
    around_shear = _panel_limits([values[:, _ahead(place)] for values in framed.values()])
    if evidence.published is not None:
        rates[PUBLISHED] = evidence.published_rate()[levels] / rate
    tractions = [*_curves(shear, around_shear), *_curves(bound, around_shear, bound=True)]
    fronts = scene_fronts(scene).items()
    return {
        "x": [round(float(x), 5) for x in place],
        "t": [round(float(t), 5) for t in first.t[levels] / end],
        "fronts": {
            WAVE_SYMBOLS[name]: round(speed / material.shear_speed, 6) for name, speed in fronts
        },
        "panels": [
            {
                "id": f"{anchor}-rate",
                "label": "slip rate / V₀",
                "limits": around_rates,
                "curves": _curves(rates, around_rates),
            },
            {
                "id": f"{anchor}-traction",
                "label": "shear traction, and bound ± f p (dotted), / τ₀",
                "limits": around_shear,
                "curves": tractions,
            },
        ],
    }


def _curves(
    fields: dict[str, Array], limits: tuple[float, float], *, bound: bool = False
) -> list[dict[str, Any]]:
    """Convert fields (levels, n) by method to integers, finite elements first, beneath the others.

    Friction bounds are drawn with both signs.
    """
    unit = float(f"{(limits[1] - limits[0]) / STEPS_OF_UNIT:.6g}")
    return [
        {
            "method": name,
            "signs": (1, -1) if bound else (1,),
            "bound": bound,
            "unit": unit,
            "values": np.clip(values / unit, -LARGEST, LARGEST).round().astype(int).tolist(),
        }
        for name, values in sorted(fields.items(), key=lambda pair: pair[0] != FEM)
    ]


def _panel_limits(values: list[Array]) -> tuple[float, float]:
    """Return limits with a margin of 8 % of the range of all values, or 0.001 if that is more."""
    low = min(float(each.min()) for each in values)
    high = max(float(each.max()) for each in values)
    margin = max(0.08 * (high - low), 1e-3)
    return low - margin, high + margin


def _ahead(place: Array) -> NDArray[np.bool_]:
    return np.asarray(place > NEAR_EDGE * place[-1])


def _pair(evidence: SceneEvidence) -> tuple[Figure, tuple[Axes, Axes], Array]:
    """Return two panels with the wave fronts at T, and x/(c_t T) of the contact nodes."""
    history, material = evidence.histories[FEM], evidence.scene.material
    place = history.x / (material.shear_speed * history.t[-1])
    figure = describe(new_figure(7, 5.2), evidence.scene)
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(2, 1))
    for panel in (upper, lower):
        panel.axhline(0, color=ink(0.5), linewidth=0.6)
        mark_waves(panel, scene_fronts(evidence.scene), material.shear_speed, labels=panel is upper)
    lower.set(xlabel=PLACE_LABEL, xlim=(0, place[-1]))
    return figure, (upper, lower), place


def _draw(panel: Axes, name: str, place: Array, values: Array) -> None:
    if name == FEM:
        panel.plot(place, values, ".", color=COLOURS[name], markersize=4, zorder=1)
    else:
        panel.plot(place, values, linestyle=LINES[name], color=COLOURS[name], linewidth=1.3)


def _draw_differences(panel: Axes, place: Array, fields: dict[str, Array]) -> None:
    """Draw the differences of all other fields from the first."""
    first, *others = fields
    differences = {name: fields[name] - fields[first] for name in others}
    for name, values in differences.items():
        panel.plot(place, values, color=COLOURS[name], linewidth=1)
    if differences:
        panel.set_ylim(*_panel_limits([values[_ahead(place)] for values in differences.values()]))
    panel.set_ylabel(f"less {first}")


def _handles(names: Iterable[str]) -> list[Line2D]:
    return [
        marker_handle(name, COLOURS[name])
        if name == FEM
        else line_handle(name, COLOURS[name], LINES[name])
        for name in names
    ]
