"""``slipfront solve`` of two different bodies with a slot."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console

from compare.comparison.pair_documents import pair_answer_document
from compare.output.printed import Table
from semianalytic import PairSolution, solve
from semianalytic.dissimilar.pair import Pair
from semianalytic.results.in_words import digits_apart
from semianalytic.scene.checks import checked_size
from semianalytic.scene.errors import SceneError
from semianalytic.scene.units import unit
from slipfront.cli.endings.refusals import check_converged
from slipfront.cli.options import option_name
from slipfront.cli.scenes.points import Points, points_table
from slipfront.cli.terminal import print_json

_RUN = "march them with slipfront run (docs/engine.md)"


def check_pair_options(
    march_options: Mapping[str, Any], plot: Path | None, figure: str | None
) -> None:
    """Raise SceneError for options of ``slipfront solve`` that two different bodies do not take."""
    if march_options:
        raise SceneError(
            f"{option_name(next(iter(march_options)))} is for marches of identical bodies; leave "
            f"it out for different ones, or {_RUN}."
        )
    if plot is not None or figure is not None:
        raise SceneError(
            f"--{'figure' if plot is None else 'plot'} draws identical bodies; leave it out for "
            "different ones, and ask for points with --x and --t, or draw what solve returns "
            "in Python (docs/dissimilar.md)."
        )


def pair_command(
    pair: Pair, label: str, end_time: float | None, points: Points | None, *, as_json: bool
) -> None:
    """Solve two different bodies with a slot, and print the result.

    Raises
    ------
    ComputationError
        If the answer has not converged; it is printed before.
    """
    if end_time is not None:
        checked_size("solve: end_time", end_time)
    answer = solve(pair)
    if as_json:
        document = pair_answer_document(answer, end_time)
        document = document if points is None else points.with_units(document, answer)
        print_json("solve", document)
    else:
        console = Console()
        if points is not None:
            console.print(points_table(answer, points))
        console.print(_zones_table(answer, label))
        console.print(_facts_table(answer, end_time))
    check_converged(answer, label)


def _zones_table(answer: PairSolution, title: str) -> Table:
    """Return a table of slip zones and openings with their edge velocities."""
    speed = unit("length / time", answer.pair.units)
    table = Table("zone", "inner edge", "outer edge", "unit", "sense", title=title)
    parts = [(zone.inner, zone.outer, f"{zone.sense:+d}") for zone in answer.zones]
    parts += [(part.inner, part.outer, "open") for part in answer.openings]
    digits = digits_apart([end for inner, outer, _ in parts for end in (inner, outer)], 8)
    for number, (inner, outer, sense) in enumerate(sorted(parts), start=1):
        table.add_row(str(number), f"{inner:.{digits}g}", f"{outer:.{digits}g}", speed, sense)
    if not parts:
        table.add_row("none", "", "", "", "stuck everywhere")
    return table


def _facts_table(answer: PairSolution, end_time: float | None) -> Table:
    """Return a table of the other content of `pair_documents.pair_answer_document`."""
    table = Table("quantity", "value", "unit", show_header=False)
    document = pair_answer_document(answer, end_time)
    units = document["units"]
    for name, part in (("pressure, shear before", "base"), ("load on the slot", "load")):
        values = f"{document['pair'][part]['pressure']:.6g}, {document['pair'][part]['shear']:.6g}"
        table.add_row(name, values, units["pair"][part]["pressure"])
    for body, speeds in document["wave_speeds"].items():
        values = ", ".join(f"{one:.6g}" for one in speeds.values())
        table.add_row(f"c_R, c_t, c_l, {body} body", values, units["wave_speeds"][body]["shear"])
    table.add_row(
        "slip rate at the edge", f"{document['edge_slip_rate']:.6g}", units["edge_slip_rate"]
    )
    for wave in answer.growing:
        towards = "a march of these bodies lets waves towards the edge grow"
        table.add_row(towards, f"by {100 * np.expm1(wave.per_wavelength):.3g} % per wavelength", "")
    table.add_row("status", answer.status, "")
    table.add_row("error estimate", f"{answer.error_estimate:.1e}", "relative")
    for name, value in document.get("until_end_time", {}).items():
        if isinstance(value, float):
            words = "time" if name == "time" else f"until then: {name.replace('_', ' ')}"
            table.add_row(words, f"{value:.6g}", units["until_end_time"][name])
    return table
