"""``slipfront validate``: what another code recorded, against the exact answer."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from compare.comparison.documents import json_text
from compare.comparison.rows import DIFFERS
from compare.output.leftovers import REPORT
from compare.output.places import working_folder, write_text
from compare.records.names import not_read
from compare.records.read import read_records
from compare.records.record import QUANTITIES, ReadingOptions
from compare.validation.conventions import BASIC, Conventions
from compare.validation.report import validation_document
from compare.validation.validation import CONVERTED, Validation, validate
from semianalytic.parameters.overriding import override_scene
from semianalytic.scene.errors import SceneError
from semianalytic.scene.extras import PLOT, require
from semianalytic.scene.given.finding import find, scene_folder, scene_label
from semianalytic.scene.tables.units import DIMENSIONS, EXAMPLES, si_size
from semianalytic.scene.units import InSI
from slipfront.cli import options, terminal
from slipfront.cli.scenes.completion import scene_names

FIGURE = "validation"
NOISES = {name: DIMENSIONS[name] for name in QUANTITIES}
_UNITS = "Units and conventions of the file (by default those of the scene, and as given)"


UNIT_OPTIONS: Mapping[str, Any] = {
    "length_unit": options.optional(
        str, _UNITS, "Unit of positions and slip, as mm.", metavar="UNIT"
    ),
    "time_unit": options.optional(str, _UNITS, "Unit of times, as µs.", metavar="UNIT"),
    "stress_unit": options.optional(str, _UNITS, "Unit of tractions, as MPa.", metavar="UNIT"),
}
CONVENTIONS: Mapping[str, Any] = {
    "sign": options.optional(str, _UNITS, "Sense of slip and shear: as-given or reversed."),
    "slip": options.optional(str, _UNITS, "Slip: relative, half, or face (that of one face)."),
    "pressure": options.optional(str, _UNITS, "Positive pressure: compression or tension."),
    "tractions": options.optional(str, _UNITS, "Tractions: total, or changes since t = 0."),
    "rate": options.optional(
        str, _UNITS, "Slip rate: at its time (point), or mean over the step before or after it."
    ),
    "time_shift": options.optional(
        float, _UNITS, "Added to the times, in units of the scene [time].", dimension="time"
    ),
}
PLACES: Mapping[str, Any] = {
    "scale": options.optional(
        list[str],
        _UNITS,
        "Unit of a column, as slip=um, or what it is multiplied by, as length=0.001.",
        metavar="NAME=UNIT",
    ),
    "at": Annotated[
        list[float] | None,
        options.measured_option(
            "length", "Where the station of each file is, in its units.", _UNITS
        ),
    ],
    "origin": options.optional(
        float,
        _UNITS,
        "Where the contact begins in the coordinates of the file.",
        dimension="length",
    ),
    "column": options.optional(
        list[str], _UNITS, "Name of a column, as slip_rate=V1.", metavar="NAME=COLUMN"
    ),
}

_OPTIONS: Mapping[str, Any] = {
    "results": typer.Argument(metavar="RESULT...", help="Files of another code; coarse to fine."),
    "scene_name": options.option(
        "Name of a scene, or a TOML file.", flag="--scene", complete=scene_names, metavar="SCENE"
    ),
    "spacing": options.measured_option(
        "length",
        "Distance of grid points on the interface, in the unit of x unless it has its own; "
        "once for each resolution. 0 for a gauge without extent, with --noise.",
    ),
    "noise": options.option(
        "Standard deviation of the samples of a quantity, such as slip=0.5um, in the "
        "unit of the file unless it has its own.",
        metavar="NAME=NUMBER",
    ),
    "strict": options.option("Return 1 if conventions were inferred.", flag="--strict"),
    "rate_from_slip": options.option(
        "Compute slip rate from differences of slip.", flag="--rate-from-slip"
    ),
    "threshold": options.measured_option(
        "length / time",
        "Slip rate at which slip has begun [length / time]; a hundredth of load / (ρ c_t).",
    ),
    "output": options.option(
        "Folder to write to; by default results/SCENE-validation.", metavar="DIR"
    ),
}


@options.with_options(
    _OPTIONS,
    overrides=options.SCENE_OPTIONS,
    units=UNIT_OPTIONS,
    conventions=CONVENTIONS,
    places=PLACES,
)
def validate_command(
    overrides: Mapping[str, Any],
    units: Mapping[str, str],
    conventions: Mapping[str, Any],
    places: Mapping[str, Any],
    results: list[Path],
    scene_name: str,
    spacing: list[float] | None = None,
    noise: list[str] | None = None,
    strict: bool = False,
    rate_from_slip: bool = False,
    threshold: float | None = None,
    output: Path | None = None,
    figures: options.FiguresForm = "png",
    as_json: options.AsJson = False,
) -> None:
    """Compare what another code recorded on the interface with the answer of `solve`.

    Inferred conventions are printed first, with the options that state them; units are never
    inferred.  The exit code is 0 if nothing differs by more than the error bars allow, 1 if
    something does, 3 if a file cannot be read.
    """
    require("slipfront validate", *PLOT)
    from compare.figures.saving import save_figure
    from compare.validation.figure import validation_figure

    scene = override_scene(find(scene_name), **overrides)
    label = scene_label(scene_name)
    for size in spacing or ():
        options.asked(scene, "spacing", size, "length")
    options.asked(scene, "threshold", threshold, "length / time")
    options.asked(scene, "time_shift", conventions.get("time_shift"), "time")
    said = Conventions(
        scale=_scales(units, places.get("scale", ())),
        noise=options.read_numbers(scene, "noise", noise or (), NOISES),
        rate_from_slip=rate_from_slip,
        threshold=threshold,
        **conventions,
    )
    columns = places.get("column", ())
    reading = ReadingOptions(
        tuple(_in_file("at", place, units) for place in places.get("at", ())),
        _in_file("origin", places.get("origin", 0.0), units),
        dict(options.read_pair("column", text, "a column", "slip_rate=V1") for text in columns),
    )
    directory = output or scene_folder(f"{label}-validation", overrides)
    records = read_records(results, reading)
    validation = validate(records, scene, spacing=spacing, conventions=said)
    with working_folder(directory) as files:
        save_figure(validation_figure(validation), directory / f"{FIGURE}.{figures}")
        document = validation_document(validation, label)
        write_text(directory / REPORT, json_text(document))
    if as_json:
        terminal.print_json("validate", document, validation.verdict, files)
    else:
        _show(validation, label, directory)
    failed = validation.verdict == DIFFERS or (strict and validation.verdict == CONVERTED)
    raise typer.Exit(1 if failed else 0)


def _scales(units: Mapping[str, str], scale: Sequence[str]) -> dict[str, float]:
    """Return the factors on the numbers of a file, from names of units and from given numbers."""
    sizes = {}
    for unit, name in units.items():
        kind = unit.removesuffix("_unit")
        size = si_size(name, kind)
        if size is None:
            raise SceneError(
                f"{options.option_name(unit)} must be a unit of {kind} such as {EXAMPLES[kind]}, "
                f"got {name!r}."
            )
        sizes[kind] = size
    for text in scale:
        name, _, number = text.partition("=")
        if name in sizes:
            raise SceneError(f"The scale of {name} is given twice; leave one of the two out.")
        sizes[name] = _scale(name, number, text)
    return sizes


def _scale(name: str, number: str, text: str) -> float:
    """A scale of a column, or of length, time or stress: a number, or a unit."""
    try:
        return float(number)
    except ValueError:
        dimension = name if name in BASIC else DIMENSIONS.get(name, "")
        size = si_size(number, dimension) if dimension else None
        if size is None:
            raise SceneError(
                "--scale must be a name and a unit or number, as slip=um or length=0.001, got "
                f"{text!r}."
            ) from None
        return size


def _in_file(name: str, place: float, units: Mapping[str, str]) -> float:
    """Return a position in the unit of a file, which --length-unit gives."""
    if not isinstance(place, InSI):
        return place
    size = si_size(units.get("length_unit", ""), "length")
    if size is None:
        raise SceneError(
            f"{options.option_name(name)} has a unit, and the numbers of the file may be in "
            "another; name theirs by --length-unit, or give a number alone in the unit of the file."
        )
    return place / size


def _show(validation: Validation, label: str, directory: Path) -> None:
    console = Console()
    for line in _reading_lines(validation):
        console.print(line, highlight=False, markup=False)
    for note in validation.notes:
        console.print(f"Note: {note}.", highlight=False, markup=False)
    title = f"{label}: {validation.source or 'records'} against the exact answer"
    headings = {"exact": "exact", "simulated": "recorded"}
    console.print(terminal.judged_table(title, validation.rows, **headings))
    console.print(terminal.references_line(validation), highlight=False)
    console.print(terminal.norms_table(validation))
    reasons = terminal.unresolved_lines(validation, ("spacing",))
    for line in (*terminal.verdict_lines(validation), *reasons):
        console.print(line, highlight=False, markup=False)
    missed = ", ".join(validation.not_compared).replace("_", " ")
    for line in (*([f"not compared: {missed}"] if missed else []), *not_read(validation.unread)):
        console.print(f"The verdict does not cover: {line}.", highlight=False, markup=False)
    console.print(f"Written to {directory}/", highlight=False, markup=False)


def _reading_lines(validation: Validation) -> Iterator[str]:
    """Lines on what was inferred: what it leaves, and the options that state it."""
    found = validation.detection
    if not found.inferred:
        return
    yield f"Inferred: {'; '.join(found.inferred)}."
    if found.left < found.as_given:
        left, as_given = (f"{100 * part:.2g} %" for part in (found.left, found.as_given))
        yield f"This leaves {left} of a quantity at most, as given {as_given}."
    stated = (f"{options.option_name(name)} {word}" for name, word in found.stating.items())
    yield f"To state it: {' '.join(stated)}"
