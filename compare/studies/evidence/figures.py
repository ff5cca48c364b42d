"""Figures and profiles over time of the evidence page, all methods in one panel."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from compare.comparison.rows import EDGE_CELLS
from compare.comparison.scales import slip_rate_scale, stress_scale, wave_speeds
from compare.figures.interface import PREDICTION, RATE_LABEL, SIMULATION
from compare.studies.evidence.study import FEM, PUBLISHED, SceneEvidence

Array = NDArray[np.float64]

COLOURS = {
    "self-similar": PREDICTION,
    "space-time": "#2a9d8f",
    FEM: SIMULATION,
    PUBLISHED: "#b07d12",
}
"""One colour per method, in figures and in the profiles that follow the slider."""
LINES: Mapping[str, Literal["-", "--", "-."]] = {
    "self-similar": "-",
    "space-time": "--",
    PUBLISHED: "-.",
}
FRAMES = 33
STEPS_OF_UNIT, LARGEST = 2000, 9999
"""Units of a profile over the height of its panel, and the most of them that are kept."""
NEAR_EDGE = 0.05
"""Part of the waves' reach, next to the edge, that may leave the panel: singular tractions."""


def rates_figure(found: SceneEvidence) -> Figure:
    """Slip rate at T by all methods, and differences from the first of them."""
    scale = slip_rate_scale(found.scene)
    rates = {name: h.slip_rate[-1] / scale for name, h in found.histories.items()}
    unjudged = {}
    if found.published is not None:
        unjudged[PUBLISHED] = found.published_rate()[-1] / scale
    figure, (upper, lower), place = _pair(found)
    for name, values in {**rates, **unjudged}.items():
        _draw(upper, name, place, values)
    _frame(upper, [values[EDGE_CELLS:] for values in rates.values()])
    first = _draw_differences(lower, place, rates)
    upper.set_ylabel(RATE_LABEL)
    lower.set_ylabel(f"less {first}")
    upper.legend(handles=_handles((*rates, *unjudged)), loc="best", fontsize=8)
    return figure


def tractions_figure(found: SceneEvidence) -> Figure:
    """Shear traction and friction bound ± f p at T by all methods; differences in shear."""
    scale = stress_scale(found.scene)
    figure, (upper, lower), place = _pair(found)
    shear = {}
    for name, history in found.histories.items():
        shear[name] = history.shear_traction[-1] / scale
        bound = found.scene.friction * history.pressure[-1] / scale
        _draw(upper, name, place, shear[name])
        for sign in (1, -1):
            upper.plot(place, sign * bound, ":", color=COLOURS[name], linewidth=1)
    _frame(upper, [values[_ahead(place)] for values in shear.values()])
    first = _draw_differences(lower, place, shear)
    upper.set_ylabel(r"traction $/\ \tau_0$")
    lower.set_ylabel(f"less {first}")
    bound_handle = Line2D([], [], color="0.3", linestyle=":", label=r"bound $\pm f p$")
    upper.legend(handles=[*_handles(tuple(shear)), bound_handle], loc="best", fontsize=8)
    return figure


def energy_figure(found: SceneEvidence) -> Figure:
    """Where the work of the loads goes in the finite-element model, over time."""
    energy, end = found.simulation.energy, found.simulation.end_time
    unit = energy_unit(found)
    figure = Figure(figsize=(7, 3.6), layout="constrained")
    panel = figure.subplots()
    parts = {
        "work of the loads": (energy.external, "black"),
        "kinetic": (energy.kinetic, "#12355b"),
        "strain": (energy.strain, "#2a9d8f"),
        "friction": (energy.friction, "#d1495b"),
        "damping": (energy.damping, "#b07d12"),
    }
    for name, (values, colour) in parts.items():
        panel.plot(energy.t / end, values / unit, color=colour, label=name)
    panel.legend(fontsize=8)
    panel.set(xlabel=r"$t/T$", ylabel=r"energy $/\ \tau_0 V_0 c_t T^2$", xlim=(0, 1))
    return figure


def opening_figure(found: SceneEvidence) -> Figure:
    """Where the contact is open over space and time in the finite-element model."""
    simulation, material = found.simulation, found.scene.material
    history = simulation.interface
    length = material.shear_speed * simulation.end_time
    figure = Figure(figsize=(7, 3.6), layout="constrained")
    panel = figure.subplots()
    panel.pcolormesh(
        history.x / length,
        history.t / simulation.end_time,
        simulation.is_open,
        shading="nearest",
        cmap="Greys",
        rasterized=True,
    )
    for speed in wave_speeds(material).values():
        panel.plot([0, speed / material.shear_speed], [0, 1], "--", color="0.4", linewidth=0.8)
    panel.set(xlabel=r"$x/(c_t T)$", ylabel=r"$t/T$", ylim=(0, 1), title="open (dark) or closed")
    return figure


def energy_unit(found: SceneEvidence) -> float:
    """τ₀ V₀ c_t T² [stress length²], what energies per thickness are measured by."""
    scene, end = found.scene, found.simulation.end_time
    area = scene.material.shear_speed * end**2
    return stress_scale(scene) * slip_rate_scale(scene) * area


def profiles(anchor: str, scene: SceneEvidence) -> dict[str, Any]:
    """Profiles over x/(c_t T) at 33 times, as whole multiples of a unit per curve.

    Curves are the slip rate over V₀, and shear traction and friction bound over τ₀.
    """
    histories, material = scene.histories, scene.scene.material
    first = histories[FEM]
    end = first.t[-1]
    levels = np.unique(np.linspace(0, len(first.t) - 1, FRAMES).round().astype(int))
    place = first.x / (material.shear_speed * end)
    rate, stress = slip_rate_scale(scene.scene), stress_scale(scene.scene)
    rates = {name: history.slip_rate[levels] / rate for name, history in histories.items()}
    shear = {name: history.shear_traction[levels] / stress for name, history in histories.items()}
    bound = {
        name: scene.scene.friction * history.pressure[levels] / stress
        for name, history in histories.items()
    }
    ahead = _ahead(place)
    framed = shear if scene.reports else {**shear, "bound": bound[FEM]}
    limits = (
        _panel_limits([values[:, EDGE_CELLS:] for values in rates.values()]),
        _panel_limits([values[:, ahead] for values in framed.values()]),
    )
    if scene.published is not None:
        rates[PUBLISHED] = scene.published_rate()[levels] / rate
    panels = [
        {
            "id": f"{anchor}-rate",
            "label": "slip rate / V₀",
            "limits": limits[0],
            "curves": _curves(rates, limits[0]),
        },
        {
            "id": f"{anchor}-traction",
            "label": "shear traction, and bound ± f p (dotted), / τ₀",
            "limits": limits[1],
            "curves": [*_curves(shear, limits[1]), *_curves(bound, limits[1], bound=True)],
        },
    ]
    symbols = zip(("c_R", "c_t", "c_l"), wave_speeds(material).values(), strict=True)
    return {
        "x": [round(float(x), 5) for x in place],
        "t": [round(float(t), 5) for t in first.t[levels] / end],
        "fronts": {name: round(speed / material.shear_speed, 6) for name, speed in symbols},
        "panels": panels,
    }


def _curves(
    fields: dict[str, Array], limits: tuple[float, float], *, bound: bool = False
) -> list[dict[str, Any]]:
    """Fields (levels, n) by method as whole numbers, finite elements first and so beneath.

    Bounds are drawn with both signs.
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
    """Limits that hold all values with a margin of 8 % or 0.001, whichever is more."""
    low = min(float(each.min()) for each in values)
    high = max(float(each.max()) for each in values)
    margin = max(0.08 * (high - low), 1e-3)
    return low - margin, high + margin


def _ahead(place: Array) -> NDArray[np.bool_]:
    return np.asarray(place > NEAR_EDGE * place[-1])


def _pair(found: SceneEvidence) -> tuple[Figure, tuple[Axes, Axes], Array]:
    """Two panels with the wave fronts at T, and x/(c_t T) of the contact nodes."""
    history, material = found.histories[FEM], found.scene.material
    place = history.x / (material.shear_speed * history.t[-1])
    figure = Figure(figsize=(7, 5), layout="constrained")
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(2, 1))
    for panel in (upper, lower):
        panel.axhline(0, color="0.6", linewidth=0.6)
        for speed in wave_speeds(material).values():
            panel.axvline(
                speed / material.shear_speed, color="0.5", linestyle="--", linewidth=0.7, zorder=0
            )
    lower.set(xlabel=r"$x/(c_t T)$", xlim=(0, place[-1]))
    return figure, (upper, lower), place


def _draw(panel: Axes, name: str, place: Array, values: Array) -> None:
    if name == FEM:
        panel.plot(place, values, ".", color=COLOURS[name], markersize=4, zorder=1)
    else:
        panel.plot(place, values, linestyle=LINES[name], color=COLOURS[name], linewidth=1.3)


def _draw_differences(panel: Axes, place: Array, fields: dict[str, Array]) -> str:
    """Draw all but the first field less the first; return the name of that one."""
    first, *others = fields
    gaps = [fields[name] - fields[first] for name in others]
    for name, gap in zip(others, gaps, strict=True):
        panel.plot(place, gap, color=COLOURS[name], linewidth=1)
    if gaps:
        _frame(panel, [gap[_ahead(place)] for gap in gaps])
    return first


def _frame(panel: Axes, values: list[Array]) -> None:
    panel.set_ylim(*_panel_limits(values))


def _handles(names: tuple[str, ...]) -> list[Line2D]:
    return [
        Line2D([], [], color=COLOURS[name], marker=".", linestyle="none", label=name)
        if name == FEM
        else Line2D([], [], color=COLOURS[name], linestyle=LINES[name], label=name)
        for name in names
    ]
