"""``slipfront solve`` of whole lines without a slot, and of loads that grow as a power of time."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rich.console import Console

from compare.comparison.line_documents import line_answer_document, problem_of
from compare.output.places import check_file
from compare.output.printed import Table
from semianalytic import (
    GrowingSlot,
    GrowingSolution,
    LineSolution,
    Patch,
    WholeLine,
    solve,
)
from semianalytic.scene.checks import checked_size
from semianalytic.scene.errors import ComputationError
from semianalytic.scene.extras import PLOT, require
from slipfront.cli.terminal import print_json


def line_command(
    problem: WholeLine | GrowingSlot,
    label: str,
    end_time: float | None,
    *,
    as_json: bool,
    plot: Path | None,
) -> None:
    """Solve a whole line or a growing load, and print the result.

    Raises
    ------
    ComputationError
        If the answer has not converged; it is printed before.
    """
    if end_time is not None:
        checked_size("solve: end_time", end_time)
    if plot is not None:
        require("slipfront solve --plot", *PLOT)
        from compare.figures.saving import figure_format

        figure_format(plot)
        check_file(plot)
    answer: LineSolution | GrowingSolution = solve(problem)
    if plot is not None:
        from compare.figures.saving import save_figure
        from compare.figures.whole_line import line_figure

        save_figure(line_figure(answer), plot)
    if as_json:
        document = line_answer_document(answer, end_time)
        print_json("solve", document, files=[] if plot is None else [plot])
    else:
        console = Console()
        console.print(answer_table(answer, label, end_time))
        if plot is not None:
            console.print(f"Drawn in {plot}", highlight=False)
    if answer.status != "converged":
        raise ComputationError(
            f"{label} has not converged: {answer.status}; do not rely on this answer, change "
            "friction a little."
        )


def answer_table(
    answer: LineSolution | GrowingSolution, label: str, end_time: float | None
) -> Table:
    """Return a table of the content of `line_documents.line_answer_document`."""
    problem, document = problem_of(answer), line_answer_document(answer, end_time)
    table = Table("quantity", "value", "unit", title=label)
    described, units = document["line"], document["units"]
    for name, part in (("pressure, shear before", "base"), (_load_name(problem), "load")):
        if part in described:
            values = f"{described[part]['pressure']:.6g}, {described[part]['shear']:.6g}"
            table.add_row(name, values, units["line"][part]["pressure"])
    if isinstance(problem, WholeLine):
        table.add_row("what drives motion", f"{problem.excess:.6g}", _load_unit(units))
        table.add_row("missing to motion", f"{problem.missing:.6g}", units["line"]["base"]["shear"])
    else:
        table.add_row("strength over load", f"{problem.strength_ratio:.6g}", "")
    speeds = ", ".join(f"{one:.6g}" for one in document["wave_speeds"].values())
    table.add_row("c_R, c_t, c_l", speeds, units["edge_speed"])
    state = "open" if answer.openings else f"slip {answer.zones[0].sense:+d}"
    sides = "either side" if isinstance(answer, LineSolution) else "from the contact edge"
    table.add_row(f"edge of {state}, {sides}", f"{answer.edge_speed:.12g}", units["edge_speed"])
    over = answer.edge_speed / problem.material.shear_speed
    table.add_row("over c_t", f"{over:.12g}", "")
    amplitude = f"{answer.edge_amplitude:.6g}"
    table.add_row("rate over sqrt(1 - x/(v t)) there", amplitude, units["edge_amplitude"])
    table.add_row("status", answer.status, "")
    table.add_row("error estimate", f"{answer.error_estimate:.1e}", "relative")
    for name, value in document.get("until_end_time", {}).items():
        if isinstance(value, float):
            known = units["until_end_time"][name]
            table.add_row(f"at the end time: {name.replace('_', ' ')}", f"{value:.6g}", known)
    return table


def _load_name(problem: WholeLine | GrowingSlot) -> str:
    """Return what the load is, with the speed of a patch or the power of time."""
    if isinstance(problem, GrowingSlot):
        return f"load over t^{problem.power}"
    if isinstance(problem.load, Patch):
        return f"load on a patch, |x| < {problem.load.speed:.6g} t"
    return "rate of the point force"


def _load_unit(units: Mapping[str, Any]) -> str:
    return str(units["line"]["load"]["pressure"])
