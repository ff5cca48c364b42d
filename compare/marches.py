"""What the command ``slipfront solve`` says of a space-time march: table, JSON, figure."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from rich.table import Table

from compare.figures import PREDICTION, RATE_LABEL
from compare.history_rows import PROBES, slip_sense
from compare.measures import onset_time
from compare.scales import slip_rate_scale
from semianalytic import Marched
from semianalytic.histories import intensity_history
from semianalytic.scene import scene_document

LEVELS = 400


def march_document(marched: Marched) -> dict[str, Any]:
    """A march as plain dictionaries, lists, strings and finite numbers, for JSON."""
    scene, fields, spacing = marched.scene, marched.interface, marched.grid.spacing
    largest = float(np.abs(fields.slip_rate).max())
    length = scene.material.shear_speed * marched.end_time
    sense = slip_sense(fields.slip_rate, largest)
    intensity = {
        name: float(intensity_history(history, scene.step, scene.material, marched.end_time)[index])
        for index, (name, history) in enumerate(
            (("K_I", scene.pressure_history), ("K_II", scene.shear_history))
        )
    }
    return {
        "scene": scene_document(scene),
        "method": "space-time",
        "end_time": marched.end_time,
        "largest_slip_rate": largest,
        "largest_slip": float(np.abs(fields.slip).max()),
        "reach_of_slip": float(fields.x[sense.any(axis=0)].max(initial=0.0)),
        "reach_of_reverse_slip": float(fields.x[(sense < 0).any(axis=0)].max(initial=0.0)),
        "onset": [
            {
                "x": float(fields.x[node]),
                "time": onset_time(fields.t, fields.slip_rate[:, node], 0.01 * largest)
                if largest
                else None,
            }
            for node in (int(np.argmin(np.abs(fields.x - probe * length))) for probe in PROBES)
        ],
        "accumulated_slip": float(marched.path.sum() * spacing),
        "friction_work": float(marched.friction_work.sum() * spacing),
        "stress_intensity_of_a_stuck_edge": intensity,
        "statistics": {
            "nodes": marched.statistics.nodes,
            "steps": marched.statistics.steps,
            "poles": marched.statistics.poles,
            "memory_error": marched.statistics.memory_error,
            "seconds": marched.statistics.seconds,
        },
    }


def march_table(marched: Marched, title: str) -> Table:
    """The same as a table, in the units of the scene."""
    document = march_document(marched)
    statistics = document.pop("statistics")
    table = Table("quantity", "value", title=title)
    for onset in document.pop("onset"):
        time = "never" if onset["time"] is None else f"{onset['time']:.6g}"
        table.add_row(f"slip starts at x = {onset['x']:.4g}", time)
    for name, value in document.pop("stress_intensity_of_a_stuck_edge").items():
        table.add_row(f"{name} of a stuck edge", f"{value:.6g}")
    for name, value in document.items():
        if name != "scene":
            text = value if isinstance(value, str) else f"{value:.6g}"
            table.add_row(name.replace("_", " "), text)
    seconds = sum(statistics["seconds"].values())
    table.add_row(
        "cost",
        f"{statistics['steps']} steps of {statistics['nodes']} nodes, {statistics['poles']} "
        f"poles (error {statistics['memory_error']:.0e}), {seconds:.2g} s",
    )
    return table


def march_figure(marched: Marched) -> Figure:
    """Slip rate over space and time, and accumulated |slip| along the interface at the end."""
    scene, fields = marched.scene, marched.interface
    length, scale = scene.material.shear_speed * marched.end_time, slip_rate_scale(scene)
    rows = slice(None, None, max(1, len(fields.t) // LEVELS))
    columns = slice(None, None, max(1, len(fields.x) // LEVELS))
    rate = fields.slip_rate[rows, columns] / scale
    top = max(float(np.quantile(np.abs(rate), 0.99)), 1e-6)
    figure = Figure(figsize=(7, 6), layout="constrained")
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(2, 1))
    image = upper.pcolormesh(
        fields.x[columns] / length,
        fields.t[rows] / marched.end_time,
        rate,
        shading="nearest",
        cmap="RdBu",
        vmin=-top,
        vmax=top,
        rasterized=True,
    )
    figure.colorbar(image, ax=upper, label=RATE_LABEL)
    upper.set_ylabel(r"$t/T$")
    lower.plot(fields.x / length, marched.path / (scale * marched.end_time), color=PREDICTION)
    lower.set(
        xlabel=r"$x/(c_t T)$",
        ylabel=r"$\int |V|\,dt\ /\ V_0 T$",
        xlim=(0, fields.x[-1] / length),
    )
    return figure
