"""``slipfront validate``: what another code recorded, against the exact answer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from compare.cli import terminal
from compare.cli.options import SCENE_OPTIONS, Output, option_name, with_options
from compare.comparison.rows import DIFFERS
from compare.output.leftovers import REPORT
from compare.output.places import working_folder
from compare.records.record import Records
from compare.validation.conventions import Conventions, named_scale
from compare.validation.report import write_validation
from compare.validation.validation import Validation, validate
from semianalytic.scene.errors import DataFileError, SceneError
from semianalytic.scene.extras import PLOT, require
from semianalytic.scene.named import find_scene, override_scene, scene_folder, scene_label

FIGURE = "validation.png"
_UNITS = "Units and conventions of the file (detected and said unless given)"


class UnreadableError(DataFileError):
    """A file of another code that cannot be read or compared; by its line, where it has any."""

    exit_code = 2


def _option(type_: Any, text: str, *, metavar: str | None = None) -> Any:
    return Annotated[type_, typer.Option(help=text, metavar=metavar, rich_help_panel=_UNITS)]


UNIT_OPTIONS: Mapping[str, Any] = {
    name: _option(str | None, text)
    for name, text in {
        "length_unit": "Of positions and slip: m, km, cm, mm or um.",
        "time_unit": "s, ms or us.",
        "stress_unit": "Pa, kPa, MPa or GPa.",
    }.items()
}


@with_options(overrides=SCENE_OPTIONS, units=UNIT_OPTIONS)
def validate_command(
    overrides: Mapping[str, Any],
    units: Mapping[str, str],
    results: Annotated[
        list[Path],
        typer.Argument(metavar="RESULT...", help="What another code wrote; coarse to fine."),
    ],
    scene_name: Annotated[
        str, typer.Option("--scene", metavar="SCENE", help="Name of a scene, or a TOML file.")
    ],
    spacing: Annotated[
        list[float] | None,
        typer.Option(
            help="Distance of grid points on the interface, in units of the file; once for each "
            "resolution."
        ),
    ] = None,
    scale: _option(  # type: ignore[valid-type]
        list[str] | None, "What numbers are multiplied by, as length=0.001.", metavar="NAME=NUMBER"
    ) = None,
    sign: _option(str | None, "Of slip and shear: as-given or reversed.") = None,  # type: ignore[valid-type]
    slip: _option(str | None, "relative, half, or face: that of one face.") = None,  # type: ignore[valid-type]
    pressure: _option(str | None, "What is positive: compression or tension.") = None,  # type: ignore[valid-type]
    time_shift: _option(float, "Added to the times, in units of the scene.") = 0.0,  # type: ignore[valid-type]
    rate_from_slip: Annotated[
        bool, typer.Option("--rate-from-slip", help="Make a slip rate of differences of slip.")
    ] = False,
    threshold: Annotated[
        float | None,
        typer.Option(help="Slip rate at which slip has begun; a hundredth of load / (ρ c_t)."),
    ] = None,
    output: Output = None,
) -> None:
    """Hold what another code recorded on the interface against the exact answer.

    Units and conventions that are detected are said first.  The exit code is 0 if nothing differs
    by more than the error bars allow, 1 if something does, 2 if a file cannot be read.
    """
    require("slipfront validate", *PLOT)
    scene = override_scene(find_scene(scene_name), **overrides)
    label = scene_label(scene_name)
    conventions = Conventions(
        scale=_scales(units, scale or ()),
        sign=sign,
        slip=slip,
        pressure=pressure,
        time_shift=time_shift,
        rate_from_slip=rate_from_slip,
        threshold=threshold,
    )
    directory = output or scene_folder(f"{label}-validation", overrides)
    try:
        validation = validate(_read(results), scene, spacing=spacing, conventions=conventions)
    except DataFileError as error:
        raise UnreadableError(str(error)) from error
    with working_folder(directory):
        write_files(validation, label, directory)
    _show(validation, label, directory)
    raise typer.Exit(1 if validation.verdict == DIFFERS else 0)


def write_files(validation: Validation, label: str, directory: Path) -> None:
    """Write a validation into a folder, as JSON and as a figure."""
    from compare.figures.saving import save_figure
    from compare.validation.figure import validation_figure

    save_figure(validation_figure(validation), directory / FIGURE)
    write_validation(validation, label, directory / REPORT)


def _read(results: Sequence[Path]) -> list[Records]:
    from compare.records.read import read_records  # type: ignore[import-not-found]

    return read_records(results)


def _scales(units: Mapping[str, str], scale: Sequence[str]) -> dict[str, float]:
    """What numbers of a file are multiplied by, from names of units and from numbers."""
    sizes = {}
    for option, name in units.items():
        kind = option.removesuffix("_unit")
        sizes[kind] = named_scale(kind, name)
    for text in scale:
        name, _, number = text.partition("=")
        if name in sizes:
            raise SceneError(f"The scale of {name} is given twice; leave one of the two out.")
        try:
            sizes[name] = float(number)
        except ValueError:
            raise SceneError(
                f"{option_name('scale')} must be a name and a number as length=0.001, got {text!r}."
            ) from None
    return sizes


def _show(validation: Validation, label: str, directory: Path) -> None:
    console = Console()
    for note in validation.notes:
        console.print(f"Note: {note}.", highlight=False, markup=False)
    console.print(terminal.validation_table(validation, label))
    console.print(terminal.references_line(validation), highlight=False)
    console.print(terminal.norms_table(validation))
    text = terminal.verdict_text(validation, ("spacing",))
    console.print(text, highlight=False, markup=False)
    console.print(f"Written to {directory}/", highlight=False, markup=False)
