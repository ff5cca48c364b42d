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
    HalfLine,
    LineSolution,
    Patch,
    Scene,
    WholeLine,
    solve_growing,
    solve_line,
)
from semianalytic.prediction import METHODS
from semianalytic.scene.checks import checked_size, shown
from semianalytic.scene.errors import ComputationError, SceneError
from semianalytic.scene.extras import PLOT, require
from semianalytic.whole_line.named import find_line, override_line
from slipfront.cli.terminal import print_json

_EXACT = ("auto", "self-similar")


def slot_scene_of(source: str, overrides: Mapping[str, Any]) -> Scene | None:
    """Return the scene that a half-line moves like; None for any other whole line."""
    problem = override_line(find_line(source), **overrides)
    if isinstance(problem, WholeLine) and isinstance(problem.load, HalfLine):
        return problem.slot_scene
    return None


def line_command(
    source: str,
    label: str,
    overrides: Mapping[str, Any],
    end_time: float | None,
    *,
    method: str,
    as_json: bool,
    plot: Path | None,
    figure: str | None,
) -> None:
    """Solve a whole line or a growing load, and print the result.

    Raises
    ------
    ComputationError
        If the answer has not converged; it is printed before.
    """
    if method not in _EXACT:
        reason = "is marched for scenes with a slot alone" if method in METHODS else "is unknown"
        raise SceneError(f"{label} is solved exactly, and method {shown(method)} {reason}.")
    if figure is not None:
        raise SceneError(f"--figure draws scenes with a slot; leave it out for {label}.")
    if end_time is not None:
        checked_size("solve: end_time", end_time)
    if plot is not None:
        require("slipfront solve --plot", *PLOT)
        from compare.figures.saving import figure_format

        figure_format(plot)
        check_file(plot)
    problem = override_line(find_line(source), **overrides)
    answer: LineSolution | GrowingSolution
    if isinstance(problem, GrowingSlot):
        answer = solve_growing(problem)
    else:
        solved = solve_line(problem)
        assert isinstance(solved, LineSolution)  # half-lines are solved as scenes
        answer = solved
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
