"""What the terminal shows: tables."""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING

from rich.table import Table

from compare.comparison.report import Report, edge_state, march_document
from compare.comparison.rows import Row, shown_number
from compare.comparison.scales import speed_regime
from semianalytic import Marched, Solution
from semianalytic.scene.named import NAMED_SCENES

if TYPE_CHECKING:
    from fem import Simulation


def scenes_table() -> Table:
    """Names and one-line summaries of the scenes that come with the package."""
    table = Table("scene", "what it shows", title="Scenes")
    for name, named in NAMED_SCENES.items():
        table.add_row(name, named.summary)
    return table


def zones_table(solution: Solution, title: str) -> Table:
    """Slip zones with their edge velocities, in the units given and over c_t."""
    material = solution.scene.material
    table = Table("zone", "edge", title=title)
    for heading in ("velocity", "velocity / c_t"):
        table.add_column(heading, justify="right")
    table.add_column("regime")
    table.add_column("sense")
    for number, zone in enumerate(solution.zones, start=1):
        for end in ("inner", "outer"):
            speed = getattr(zone, end)
            table.add_row(
                str(number) if end == "inner" else "",
                end,
                _velocity(speed),
                _velocity(speed / material.shear_speed),
                speed_regime(speed, material),
                ("slip" if zone.sense > 0 else "reverse slip") if end == "inner" else "",
            )
    if not solution.zones:
        table.add_row("none", "", "", "", "stuck everywhere", "")
    return table


def facts_table(solution: Solution) -> Table:
    """Wave speeds, state of the edge, status, error estimate and statistics of a solution."""
    material = solution.scene.material
    mode_one, mode_two = solution.stress_intensity(1.0)
    table = Table("quantity", "value", show_header=False)
    facts = {
        "c_R, c_t, c_l": ", ".join(
            f"{speed:.6g}"
            for speed in (
                material.rayleigh_speed,
                material.shear_speed,
                material.longitudinal_speed,
            )
        ),
        "edge": edge_state(solution),
        "slip rate at the edge": f"{solution.edge_slip_rate:.6g}",
        "slip rate far ahead": f"{solution.scene.far_slip_rate:.6g}",
        "K_I, K_II at t = 1": f"{mode_one:.6g}, {mode_two:.6g}",
        "status": solution.status,
        "error estimate": f"{solution.error_estimate:.1e}",
        **{
            name.replace("_", " "): _plain(value)
            for name, value in dataclasses.asdict(solution.statistics).items()
        },
    }
    for name, value in facts.items():
        table.add_row(name, value)
    return table


def march_table(marched: Marched, title: str) -> Table:
    """What `report.march_document` says of a march, in the units of the scene."""
    document = march_document(marched)
    statistics = document.pop("statistics")
    table = Table("quantity", "value", title=title)
    for onset in document.pop("onset"):
        time = "never" if onset["time"] is None else f"{onset['time']:.6g}"
        table.add_row(f"slip starts at x = {onset['x']:.4g}", time)
    for name, value in document.pop("stress_intensity_of_a_stuck_edge").items():
        table.add_row(f"{name} of a stuck edge", f"{value:.6g}")
    for name, value in document.items():
        if name != "scene" and value != "":
            text = value if isinstance(value, str) else f"{value:.6g}"
            table.add_row(name.replace("_", " "), text)
    seconds = sum(statistics["seconds"].values())
    table.add_row(
        "cost",
        f"{statistics['steps']} steps of {statistics['nodes']} nodes, {statistics['poles']} "
        f"poles (error {statistics['memory_error']:.0e}), {seconds:.2g} s",
    )
    return table


def simulation_line(simulation: Simulation) -> str:
    """One line saying which mesh, model and damping a simulation used, and what it cost."""
    shear_speed = simulation.scene.material.shear_speed
    cell = simulation.element_size / (shear_speed * simulation.end_time)
    return (
        f"mesh size {simulation.element_size:.4g} = {cell:.4g} c_t T, model {simulation.model}, "
        f"damping {simulation.damping:g} h/c_t, {simulation.unknowns:,} unknowns, "
        f"{simulation.steps} steps in {simulation.seconds['steps']:.2g} s, end time "
        f"{simulation.end_time:g}, peak memory {simulation.peak_memory / 1e6:,.0f} MB"
    )


def report_table(report: Report) -> Table:
    """The rows of a report, failures in red."""
    table = Table("quantity", title=f"Semi-analytic against finite elements: {report.label}")
    for heading in ("prediction", "FEM", "difference", "tolerance"):
        table.add_column(heading, justify="right")
    table.add_column("verdict")
    for row in report.rows:
        table.add_row(
            row.quantity,
            shown_number(row.prediction),
            shown_number(row.simulation),
            shown_number(row.difference),
            shown_number(row.tolerance),
            _verdict(row),
        )
    return table


def reasons_text(report: Report) -> str:
    """The distinct reasons behind the tolerances of a report, one a line; what a march misses."""
    reasons = dict.fromkeys(row.reason for row in report.rows if row.present)
    cautions = [f"The march is unresolved: {text}." for text in [report.prediction.caution] if text]
    return "\n".join([*(f"  · {reason}" for reason in reasons), *cautions])


def _velocity(speed: float) -> str:
    return "∞" if math.isinf(speed) else f"{speed:.6f}"


def _plain(value: object) -> str:
    if isinstance(value, dict):
        return ", ".join(f"{key} {_plain(item)}" for key, item in value.items())
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _verdict(row: Row) -> str:
    if not row.present:
        return "not present"
    return "[green]pass[/green]" if row.passed else "[bold red]FAIL[/bold red]"
