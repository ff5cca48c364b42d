"""Problem sheets as pages in Markdown, of problem, report, answer and classes, and as folders."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from pathlib import Path

from compare.benchmarks.answers import (
    arrival_level,
    arrival_quantity,
    checksums,
    digits_of,
    numbers_of,
    stated_errors,
    table_of,
)
from compare.benchmarks.sheets import OPENING, SI, SUMS, Sheet
from compare.output.places import working_folder
from compare.output.tables import markdown_table
from compare.records.record import QUANTITIES
from semianalytic.results.files import remove_empty, write_bytes
from semianalytic.results.in_words import kind_of_slip
from semianalytic.scene.errors import SceneError

IN_SI = (
    "In SI units, with moduli times 10 GPa, densities times 2500 kg/m³ and tractions times 10 MPa, "
    "T is one second, c_t T 2000 m, a slip rate of 1 is 2 m/s and a slip of 1 is 2 m."
)


def page_of(sheet: Sheet) -> str:
    """The page of a sheet; a sheet that is solved is solved for it."""
    return "\n\n".join(part.strip() for part in _parts(sheet)) + "\n"


def _parts(sheet: Sheet) -> Iterator[str]:
    yield f"# {sheet.name}: {sheet.title}"
    if sheet.tests:
        yield f"It tests {sheet.tests}."
    yield "## Problem"
    yield sheet.statement
    if sheet.note:
        yield sheet.note
    yield f"Units: {sheet.units}. {sheet.name}.toml is the problem as slipfront reads it:"
    yield f"```toml\n{sheet.file}```"
    if not sheet.is_interface:
        yield IN_SI
    yield "## What to report"
    yield from _to_report(sheet)
    yield "## The answer"
    yield from _answer(sheet)
    yield "## Classes"
    yield from _classes(sheet)
    yield "```\nslipfront benchmark score FILE ...\n```"


def _to_report(sheet: Sheet) -> Iterator[str]:
    names = ", ".join(name.replace("_", " ") for name in sheet.report)
    places = ", ".join(f"{x:g}" for x in sheet.stations)
    where = f"x = {places}{' m' if sheet.units == SI else ''}"
    where = where if sheet.is_interface else f"x/(c_t T) = {places}"
    yield (
        f"{names[0].upper()}{names[1:]} over 0 < t <= T at {where}, at your own time steps, as CSV "
        f"in units {sheet.units}, one file for each run. Columns that you do not have may be "
        "missing; where slip rate is a mean over a step, a comment line says so. Cells are "
        f"counted over {sheet.extent_words}; 50, 100 and 200 of them show convergence."
    )
    quantities = sheet.report if sheet.is_interface else QUANTITIES
    lines = (
        f"# benchmark: {sheet.name}",
        "# cells: 100",
        "# slip_rate: mean over the step from t to t + 0.005",
        f"t,x,{','.join(quantities)}",
    )
    yield "\n".join(("```", *lines, "```"))
    if sheet.arrival:
        name, side = arrival_quantity(sheet), "below" if sheet.arrival == OPENING else "above"
        yield (
            f"Arrivals are read off these records: the first time that {name.replace('_', ' ')} is "
            f"{side} {arrival_level(sheet):g}, between samples by linear interpolation."
        )


def _answer(sheet: Sheet) -> Iterator[str]:
    yield (
        f"{sheet.name}.csv holds the answer at the stations, to {digits_of(sheet)} digits; "
        "SHA256SUMS, one folder up, its checksum (`sha256sum --check SHA256SUMS`)."
    )
    errors = stated_errors(sheet)
    if errors:
        source = (
            f"It is the limit of grids of {sheet.nodes // 2} and {sheet.nodes} nodes, by an order "
            f"of {sheet.order}. The stated error is its difference from the limit of "
            f"{sheet.nodes // 4} and {sheet.nodes // 2} nodes"
            if sheet.nodes
            else "It is marched on a grid. The stated error is that of its estimate"
        )
        yield (
            f"{source}: relative L1 over all times and stations; of arrivals the largest, in units "
            "of time. An error of a code below it says nothing about the code."
        )
        yield markdown_table(
            ("", "stated error"),
            [(name.replace("_", " "), f"{error:.2g}") for name, error in errors.items()],
        )
    yield markdown_table(("at t = T", ""), list(_rows(sheet)))


def _rows(sheet: Sheet) -> Iterator[tuple[str, str]]:
    """Rows of what an answer is at T."""
    numbers, digits = numbers_of(sheet), digits_of(sheet)
    for at, (inner, outer, sense) in enumerate(numbers.get("zones", ()), start=1):
        span = f"{inner:.{digits}g} to {outer:.{digits}g}"
        yield f"zone {at}, {kind_of_slip(sense)}, x/(c_t t)", span
    for inner, outer in numbers.get("openings", ()):
        yield "open, x/(c_t t)", f"{inner:.{digits}g} to {outer:.{digits}g}"
    for name in ("max_slip", "accumulated_slip", "frictional_work"):
        if name in numbers:
            yield name.replace("_", " "), f"{numbers[name]:.{digits}g}"
    for name, label in (("arrivals", "arrival"), ("slip", "slip")):
        for x, value in zip(sheet.stations, numbers.get(name, ()), strict=False):
            yield f"{label} at x = {x:g}", "never" if value is None else f"{value:.6g}"


def _classes(sheet: Sheet) -> Iterator[str]:
    if not sheet.classes:
        yield "Errors are given without classes: none are measured."
        return
    yield (
        "The largest errors of a first-order scheme (our finite elements) on 200 (A), 100 (B) and "
        f"50 cells (C) over {sheet.extent_words}; beyond them is D. For arrivals the root of the "
        "mean square error over T, of all else the relative L1 error over time and all stations."
    )
    yield markdown_table(
        ("", *"ABC"),
        [
            (name.replace("_", " "), *(f"{number:.2g}" for number in row))
            for name, row in sheet.classes.items()
        ],
    )


_TEXTS = {"md": page_of, "csv": table_of, "toml": lambda sheet: sheet.file}
"""Texts of a sheet by the endings of their files."""


def exported(sheets: Sequence[Sheet]) -> dict[str, bytes]:
    """Return page, answer and problem of sheets, and checksums, by path below the folder."""
    texts = (text(sheet).encode() for sheet in sheets for text in _TEXTS.values())
    contents = dict(zip(_names(sheets), texts, strict=True))
    return {**contents, SUMS: checksums(contents).encode()}


def _names(sheets: Sequence[Sheet]) -> list[str]:
    return [f"{sheet.name}/{sheet.name}.{ending}" for sheet in sheets for ending in _TEXTS]


def export(folder: Path, sheets: Sequence[Sheet], *, overwrite: bool = False) -> list[Path]:
    """Write sheets into a folder, all or none, and return what was written.

    Files that are there are replaced only with `overwrite`, else refused by a SceneError before
    anything is solved.
    """
    there = sorted(name for name in (*_names(sheets), SUMS) if (folder / name).exists())
    if there and not overwrite:
        raise SceneError(
            f"{folder / there[0]} exists already; choose another folder, or give --overwrite."
        )
    with working_folder(folder):
        contents = exported(sheets)
        new = [folder / name for name in contents if name not in there]
        try:
            for name, data in contents.items():
                write_bytes(folder / name, data)
        except BaseException:
            for path in new:
                with suppress(OSError):
                    path.unlink(missing_ok=True)
            remove_empty([path.parent for path in new if path.parent != folder])
            raise
    return [folder / name for name in contents]
