"""Terminal output of all commands: tables for readers, or JSON and nothing else."""

from __future__ import annotations

import math
import sys
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.markup import escape

from compare.comparison.documents import (
    WAVES,
    envelope,
    json_text,
    march_document,
    solution_document,
)
from compare.comparison.rows import AGREES, DIFFERS, UNRESOLVED, Row, shown_number
from compare.comparison.scales import WAVE_SYMBOLS, reference_values
from compare.output.printed import PrintedTable
from semianalytic import Scene
from semianalytic.results.in_words import digits_apart, number_or_infinity
from semianalytic.scene.given.documents import history_document
from semianalytic.scene.incident import IncidentWave
from semianalytic.scene.loads import Step
from semianalytic.scene.tabulated import Tabulated
from semianalytic.scene.units import unit, with_unit
from slipfront.cli.endings.refusals import in_options
from slipfront.cli.endings.unread import NOTES
from slipfront.cli.options import MARCH_OPTIONS, MESH_OPTIONS

if TYPE_CHECKING:  # most commands print an answer, and judge none
    from compare.comparison.judgement import Judgement
    from compare.comparison.mesh_choice import MeshChoice
    from compare.validation.validation import Validation
    from fem import Simulation
    from semianalytic import Marched

_SENSES = {1: "forward", -1: "reverse"}
"""Slip towards +x and towards -x."""
TOTALS = ("accumulated_slip", "frictional_work")
DIGITS = 4


def print_json(
    command: str, document: Mapping[str, Any], status: str = "done", files: Iterable[Path] = ()
) -> None:
    """Print the `envelope` of a document, with columns of tables that were not read."""
    if unread := [*document.get("unread", ()), *NOTES]:
        document = {**document, "unread": unread}
    sys.stdout.write(json_text(envelope(command, document, status, files)))


def zones_table(answer: Any, title: str) -> PrintedTable:
    """Return a table of slip zones and openings with their edge velocities.

    Velocities are given in units of the scene and relative to c_t, between different bodies that of
    the upper one.
    """
    scene, known = answer.scene, solution_document(answer)
    names = f"[{unit('length / time', scene.units)}]", "/ c_t"
    headings = [f"velocity\n{escape(name)}" for name in names]
    table = PrintedTable("zone", "edge", numbers=headings, title=title)
    table.add_column("regime")
    table.add_column("sense")
    parts = [
        (str(number), zone, _SENSES[zone["sense"]])
        for number, zone in enumerate(known["zones"], start=1)
    ]
    parts += [("open", opening, "") for opening in known["openings"]]
    parts.sort(key=lambda part: part[1]["inner"])
    edges = [
        math.inf if speed is None else speed
        for _, part, _ in parts
        for speed in (part["inner"], part["outer"])
    ]
    over_c_t = [speed / scene.material.shear_speed for speed in edges]
    columns = (
        [number_or_infinity(speed, digits_apart(column, 6, "f"), "f") for speed in column]
        for column in (edges, over_c_t)
    )
    shown = zip(*columns, strict=True)
    for name, part, sense in parts:
        table.add_row(name, "inner", *next(shown), part.get("inner_regime", ""), sense)
        table.add_row("", "outer", *next(shown), part.get("outer_regime", ""), "")
    if not parts:
        table.add_row("none", "", "", "", "stuck everywhere", "")
    return table


def facts_table(answer: Any) -> PrintedTable:
    """Return a table of loads, wave speeds, edges, status, error estimate and statistics."""
    scene, known = answer.scene, solution_document(answer)
    units, edge = known["units"], known["edge"]
    table = PrintedTable("quantity", "value", "unit", show_header=False)
    for name, value, dimension in _tractions(scene):
        table.add_row(name, value, unit(dimension, scene.units))
    speeds = known["wave_speeds"]
    for body, own in speeds.items() if "upper" in speeds else (("", speeds),):
        names = ", ".join(WAVE_SYMBOLS[name] for name in WAVES if WAVES[name] in own)
        values = ", ".join(f"{speed:.6g}" for speed in own.values())
        table.add_row(f"{names}{body and f', {body} body'}", values, units["wave_speeds"])
    for name, value in edge.items():
        if name == "state":
            table.add_row("edge", value, "")
        elif isinstance(value, float):
            table.add_row(f"{_label(name)} at the edge", f"{value:.6g}", units["edge"][name])
    if "far_slip_rate" in known:
        table.add_row(
            "slip rate far ahead", f"{known['far_slip_rate']:.6g}", units["far_slip_rate"]
        )
    for name, values in edge.items():
        if isinstance(values, dict):
            shown = ", ".join(f"{value:.6g}" for value in values.values())
            when = with_unit(1.0, "time", scene.units)
            table.add_row(f"{', '.join(values)} at t = {when}", shown, units["edge"][name])
    for wave in getattr(answer, "growing", ()):
        growth = f"{100 * math.expm1(wave.per_wavelength):.3g}"
        table.add_row("growth of waves towards the edge in a march", growth, "% per wavelength")
    table.add_row("status", answer.status, "")
    table.add_row("error estimate", f"{answer.error_estimate:.1e}", "of c_t and of values")
    for name, value in known.get("statistics", {}).items():
        table.add_row(name.replace("_", " "), _plain(value), "s" if name == "seconds" else "")
    return table


def _tractions(scene: Scene) -> Iterator[tuple[str, str, str]]:
    """Yield name, value and dimension of the base tractions and of the load, with its place."""
    where = "from far away" if scene.arrives else "on the slot"
    for name, part in (
        ("pressure, shear before", scene.base),
        (f"load {where}", scene.superposition.taken_off),
    ):
        yield name, f"{part.pressure:.6g}, {part.shear:.6g}", "stress"
    for name, history in scene.acting_histories.items():
        if history != Step():
            words = str(history_document(history)["kind"]).replace("-", " ")
            if isinstance(history, Tabulated):  # all other histories reach 1
                words += f", largest value {max(map(abs, history.value_at_t)):.4g}"
            yield f"history of its {name}", words, ""
    load = scene.load
    if isinstance(load, IncidentWave):
        yield f"{load.kind} wave from {load.from_}, angle", f"{load.angle:.6g}", "degrees"
    if scene.front_slowness:
        yield "velocity of its front along x", f"{1 / scene.front_slowness:.6g}", "length / time"


def end_table(answer: Any, end_time: float) -> PrintedTable:
    """Return a table of everything until an end time: positions of zones, slip, work."""
    known = solution_document(answer, end_time)
    end, units = known["until_end_time"], known["units"]["until_end_time"]
    when = with_unit(end_time, "time", answer.scene.units)
    table = PrintedTable("quantity", "value", "unit", title=f"t = {when}")
    zones = [
        (f"zone {n}, {_SENSES[zone['sense']]}", zone) for n, zone in enumerate(end["zones"], 1)
    ]
    zones += [("open", part) for part in end["openings"]]
    digits = digits_apart([part[name] for _, part in zones for name in ("start", "end")], 6)
    for name, part in zones:
        place = f"{part['start']:.{digits}g} < x < {number_or_infinity(part['end'], digits)}"
        table.add_row(name, place, unit("length", answer.scene.units))
    for name in ("largest_slip", "accumulated_slip", "frictional_work"):
        table.add_row(_label(name), number_or_infinity(end[name]), units[name])
    if intensities := end.get("stress_intensity"):
        modes = ", ".join(number_or_infinity(value) for value in intensities.values())
        table.add_row(", ".join(intensities), modes, units["stress_intensity"])
    return table


def march_table(marched: Marched, title: str) -> PrintedTable:
    """Return a table of the content of `documents.march_document`, in the units of the scene."""
    scene, document = marched.scene, march_document(marched)
    units = document["units"]
    table = PrintedTable("quantity", "value", "unit", title=title)
    for name, value, dimension in () if scene.on_line else _tractions(scene):
        table.add_row(name, value, unit(dimension, scene.units))
    for onset in document.get("onset", ()):
        never = f"not until {marched.end_time:.6g}"
        time = never if onset["time"] is None else f"{onset['time']:.6g}"
        place = with_unit(onset["x"], "length", scene.units)
        table.add_row(f"slip starts at x = {place}", time, units["onset"]["time"])
    for mode, value in document.get("stress_intensity_of_a_stuck_edge", {}).items():
        intensity = units["stress_intensity_of_a_stuck_edge"]
        table.add_row(f"{mode} of a stuck edge", f"{value:.6g}", intensity)
    for name, value in document.items():
        if isinstance(value, str) and value:
            table.add_row(name.replace("_", " "), in_options(value, MARCH_OPTIONS))
        elif isinstance(value, (float, int)) and name != "error_estimate":
            table.add_row(_label(name), f"{value:.6g}", units.get(name, ""))
    for quantity, error in document["error_estimates"].items():
        table.add_row(f"error of {quantity.replace('_', ' ')}", f"{error:.1e}", "relative")
    if cost := document.get("statistics"):
        table.add_row(
            "cost",
            f"{cost['steps']} steps of {cost['nodes']} nodes, {cost['poles']} poles (error "
            f"{cost['memory_error']:.0e}), {sum(cost['seconds'].values()):.2g} s",
        )
    return table


def simulation_line(simulation: Simulation) -> str:
    """Return one line on mesh, model, damping and cost of a simulation."""
    shear_speed = simulation.scene.material.shear_speed
    cell = simulation.element_size / (shear_speed * simulation.end_time)
    return (
        f"mesh size {simulation.element_size:.4g} = {cell:.4g} c_t T, model {simulation.model}, "
        f"damping {simulation.damping:g} h/c_t, {simulation.unknowns:,} unknowns, "
        f"{simulation.steps} steps in {simulation.seconds['steps']:.2g} s, end time "
        f"{simulation.end_time:g}"
    )


def mesh_lines(choice: MeshChoice) -> Iterator[str]:
    """Yield which mesh was chosen, why, and its cost; then each feature that it cannot resolve."""
    from compare.comparison.mesh_choice import toll

    taken = toll(choice.seconds, choice.memory)
    yield f"resolution {choice.resolution} ({choice.reason}): about {taken}"
    for unseen in choice.unresolved:
        advice = in_options(unseen.advice, MESH_OPTIONS)
        yield f"will stay unresolved: {unseen.name}; {advice}"


def error_line(simulation: Simulation) -> str:
    """Return a sentence on the errors of final slip rate and slip, estimated by coarser meshes."""
    if simulation.companion is None:
        return "no error bars, for there is no coarser mesh"
    from compare.comparison.judgement import own_bars
    from compare.comparison.mesh_choice import two_digits

    rate, slip = (
        f"{two_digits(100 * row.bar)} %" if row.relative else f"{two_digits(row.bar)} {row.unit}"
        for row in own_bars(simulation)
        if row.bar is not None
    )
    return f"slip rate at the end within {rate}, slip within {slip}, by coarser meshes"


def judged_table(title: str, rows: Sequence[Row], **numbers: str) -> PrintedTable:
    """Return judged rows with units and places; differences in red, errors of norms in per cent.

    Headings are given by the numbers of the rows that stand below them.
    """
    table = PrintedTable(title=escape(title), box=SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))
    table.add_column("quantity", min_width=14)  # the whole table fits into 80 columns
    for heading in (*numbers.values(), "differ by", "bar ±"):
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("verdict", no_wrap=True, min_width=10)
    for row in rows:
        label = row.name if row.unit in ("1", "exact") else f"{row.name} [{row.unit}]"
        label = f"{label} at {place}" if (place := getattr(row, "place", "")) else label
        cells = [shown_number(getattr(row, name), DIGITS) for name in numbers]
        cells += row.shown_shares(row.difference, row.bar)
        table.add_row(
            escape(label),
            *cells,
            f"[bold red]{row.said}[/bold red]" if row.verdict == DIFFERS else row.said,
        )
    return table


def norms_table(validation: Validation) -> PrintedTable:
    """Return a table of the relative errors of every quantity over all stations."""
    from compare.comparison.mesh_choice import two_digits

    numbers = "L1 error", "L2 error", "samples"
    table = PrintedTable("quantity", numbers=numbers, title="Over all stations", box=SIMPLE_HEAD)
    for norm in validation.norms:
        if norm.x is None:
            parts = (f"{two_digits(100 * part)} %" for part in (norm.L1, norm.L2))
            table.add_row(norm.quantity.replace("_", " "), *parts, str(norm.samples))
    return table


def references_line(judgement: Judgement | Validation) -> str:
    """Return a line that explains the symbols in the units of a judgement."""
    from compare.validation.validation import Validation

    run = judgement.exact if isinstance(judgement, Validation) else judgement.simulation
    if not hasattr(run, "scene"):  # an interface is compared in its own units
        return "Units: those of the scene; % of the prediction"
    references = reference_values(run.scene, run.end_time)
    values = (f"{symbol} = {value:.4g} {unit}" for symbol, (value, unit) in references.items())
    return f"Units: {', '.join(values)}; % of the prediction"


def verdict_lines(judgement: Judgement | Validation) -> Iterator[str]:
    """Yield the verdict, and how far the two answers are apart."""
    found = judgement.counts.items()
    rows = ", ".join(f"{count} {verdict.removesuffix('s')}" for verdict, count in found if count)
    yield f"Verdict: {judgement.said} ({f'rows: {rows}' if rows else 'nothing is compared'})."
    if quoted := judgement.quoted:
        what = "Difference ± error bar of what decides: " if "±" in quoted else ""
        yield f"{what}{quoted}." if what else f"{quoted.capitalize()}."


def unresolved_lines(
    judgement: Judgement | Validation, options: Collection[str] = MESH_OPTIONS
) -> Iterator[str]:
    """Yield each reason for which rows are unresolved, with its remedy; first those that leave the
    verdict open."""
    hindering = judgement.hindering if judgement.verdict == UNRESOLVED else ()
    for heading, open_ in (
        ("Unresolved, which leaves the verdict open:", True),
        ("Unresolved, without effect on the verdict:", False),
    ):
        alike: dict[str, list[str]] = {}
        for row in judgement.having(UNRESOLVED):
            if (row in hindering) == open_:
                reason = "; ".join(filter(None, (row.obstacle, judgement.remedy(row))))
                alike.setdefault(in_options(reason, options), []).append(row.name)
        if alike:
            yield heading
        yield from (f"  · {'; '.join(names)}: {reason}." for reason, names in alike.items())


def print_judgement(
    judgement: Judgement,
    title: str,
    headings: Mapping[str, str],
    options: Collection[str] = MESH_OPTIONS,
    *,
    everything: bool,
) -> None:
    """Print the verdict, what is to be quoted, what was compared and what is unresolved; then the
    rows that do not agree, or all."""
    console = Console()
    for line in (*verdict_lines(judgement), title, *unresolved_lines(judgement, options)):
        console.print(line, highlight=False, markup=False)
    rows = [row for row in judgement.rows if everything or row.verdict != AGREES]
    if rows:
        console.print(judged_table("", rows, **headings))
        console.print(references_line(judgement), highlight=False)
    if len(rows) < len(judgement.rows):
        said = f"{len(judgement.rows) - len(rows)} rows agree; --all prints them."
        console.print(said, highlight=False)


def _label(name: str) -> str:
    """Return the printed name of a number of a document; totals say that they are totals."""
    words = name.replace("_", " ")
    return f"{words} over the contact" if name in TOTALS else words


def _plain(value: object) -> str:
    if isinstance(value, dict):
        return ", ".join(f"{key} {_plain(item)}" for key, item in value.items())
    return f"{value:.4g}" if isinstance(value, float) else str(value)
