"""``slipfront fit``: fit parameters of a scene to measured records."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import typer
from rich.console import Console
from rich.markup import escape

from compare.comparison.documents import envelope, json_text
from compare.output.places import check_file, write_text
from compare.output.printed import PrintedTable
from compare.output.progress import progress_bar
from compare.records.names import not_read
from semianalytic.inversion.fitted import Fit
from semianalytic.inversion.fitting import fit
from semianalytic.inversion.gauges import QUANTITIES
from semianalytic.inversion.priors import LogNormal, Normal, Prior, Uniform
from semianalytic.inversion.quoted import QUOTED
from semianalytic.inversion.unknowns import (
    SETUP,
    Setup,
    is_fitted_on_line,
    number_name,
    plain_name,
)
from semianalytic.parameters.overriding import override_scene
from semianalytic.scene.checks import shown
from semianalytic.scene.errors import ComputationError, SceneError
from semianalytic.scene.extras import PLOT, require
from semianalytic.scene.given.files import read_document
from semianalytic.scene.given.finding import check_slot, find
from semianalytic.scene.scene import Scene
from semianalytic.scene.tables.units import si_size
from semianalytic.scene.units import measure, unit, units_shown
from slipfront.cli import options
from slipfront.cli.scenes.completion import scene_names
from slipfront.fits.data import gauges_and_notes
from slipfront.fits.documents import dimension, fit_document, known_by_prior, misfit_sentence

PRIORS: Mapping[str, type] = {"normal": Normal, "lognormal": LogNormal, "uniform": Uniform}
_PLACE = re.compile(r"([^=]+)=\s*(\w+)\s*@\s*([^,@]+(?:,[^,@]+)?)\Z")
_PRIOR = re.compile(r"([^=]+)=\s*(\w+)\s*\(\s*([^,()]+?)\s*,\s*([^,()]+?)\s*\)\s*$")


_OPTIONS: Mapping[str, Any] = {
    "files": typer.Argument(metavar="FILE...", help="Records: tables of t, x, y and values."),
    "scene_name": options.option(
        "Scene or interface, by name or TOML file, for all that is not fitted.",
        flag="--scene",
        complete=scene_names,
        metavar="SCENE",
    ),
    "parameters": options.option(
        "Parameters to fit, such as friction,load_shear.", metavar="NAME,..."
    ),
    "noise": options.option(
        "Standard deviation, such as 0.5um, of all samples in that unit, or of a quantity, where "
        "no column gives it.",
        metavar="[NAME=]NUMBER",
    ),
    "gauge": options.option(
        "Quantity and place of a column, in tables with one column for each gauge, as "
        "SG1=exx@20mm,3.5mm, or a TOML file of lines SG1 = 'exx@20mm,3.5mm'.",
        metavar="NAME=QUANTITY@X,Y",
    ),
    "prior": options.option(
        "friction=normal(mean,sd), or lognormal(median,factor) or uniform(low,high); numbers may "
        "have units, as load_shear=normal(5MPa,1MPa).",
        metavar="NAME=KIND(A,B)",
    ),
    "held": options.option(
        "Value of t0, x0 or gain, such as t0=3us, if it is not fitted.",
        flag="--setup",
        metavar="NAME=NUMBER",
    ),
    "nodes": options.option("Nodes of one period, if the scene is on a line."),
    "plot": options.option("Draw records, fit and parameters.", metavar="FILE"),
    "output": options.option("Write the JSON of --json to a file.", metavar="FILE"),
}


@options.with_options(_OPTIONS, overrides=options.SCENE_OPTIONS)
def fit_command(
    overrides: Mapping[str, Any],
    files: list[Path],
    scene_name: str,
    parameters: str,
    noise: list[str] | None = None,
    gauge: list[str] | None = None,
    prior: list[str] | None = None,
    held: list[str] | None = None,
    nodes: int | None = None,
    plot: Path | None = None,
    output: Path | None = None,
    as_json: options.AsJson = False,
    quiet: options.Quiet = False,
) -> None:
    """Fit parameters of a scene to the records of gauges.

    Values of the scene are the first guess; the search covers the plausible ranges of parameters,
    or those of their priors.  The exit code is 4 if the fit is unreliable.
    """
    require("slipfront fit", *(PLOT if plot else ()))
    names = tuple(part.strip() for part in parameters.split(",") if part.strip())
    scene = override_scene(find(scene_name), **overrides)
    if not is_fitted_on_line(scene):
        check_slot(scene_name, scene)
        if nodes is not None:
            raise SceneError("--nodes has no effect on a scene with a slot; leave it out.")
    names = tuple(number_name(scene, name) for name in names)
    known, of_setup = _priors(scene, prior or ()), {name: dimension(name, scene) for name in SETUP}
    numbers: dict[str, Any] = options.read_numbers(scene, "setup", held or (), of_setup)
    gauges, notes, unread = gauges_and_notes(
        files, _noise(scene, noise or ()), scene, names, _places(scene, gauge or ())
    )
    if plot is not None:
        from compare.figures.saving import figure_format

        figure_format(plot)
    for path in filter(None, (plot, output)):
        check_file(path)
    with progress_bar(Console(stderr=True), quiet or as_json, "fitting") as progress:
        found = fit(
            gauges,
            scene,
            names,
            priors=known,
            setup=Setup(**numbers),
            nodes=nodes,
            progress=progress,
        )
    written = [path for path in (plot, output) if path is not None]
    document = {**fit_document(found), "notes": list(notes), "unread": list(unread)}
    text = json_text(envelope("fit", document, files=written))
    if plot is not None:
        from compare.figures.saving import save_figure
        from slipfront.fits.figures import fit_figure

        save_figure(fit_figure(found), plot)
    if output is not None:
        write_text(output, text)
    if as_json:
        print(text, end="")
    else:
        _show(found, written, (*notes, *not_read(unread)))
    if found.status != "converged":
        raise ComputationError(f"The fit is not to be relied upon: {found.status}.")


def _show(found: Fit, written: Sequence[Path], notes: Sequence[str]) -> None:
    console = Console()
    for note in notes:
        console.print(f"Note: {note}.", highlight=False, markup=False)
    console.print(_values_table(found))
    if found.quoted.x.size:
        console.print(_rupture_table(found))
    count = len(found.minima)
    minima = f"{count} minima, the next with a chi2 {found.next_minimum:.3g} above"
    minima = "one minimum" if count == 1 else minima
    console.print(_gauges_table(found))
    lines = [
        f"chi2 {found.chi2:.4g} of {found.freedom}: {misfit_sentence(found)}.",
        f"The search found {minima}; {found.solutions} solutions.",
    ]
    lines += [f"The data add nothing to the prior of {name}." for name in known_by_prior(found)]
    lines += [f"Written to {path}" for path in written]
    for line in lines:
        console.print(line, highlight=False, markup=False)


def _values_table(found: Fit) -> PrintedTable:
    table = PrintedTable("parameter", numbers=("value", "error"), title=f"Fit: {found.status}")
    table.add_column("unit")
    for number, name in enumerate(found.parameters):
        table.add_row(
            name,
            f"{found.values[number]:.6g}",
            found.error_in_words(number),
            escape(unit(dimension(name, found.scene), found.scene.units)),
        )
    return table


def _rupture_table(found: Fit) -> PrintedTable:
    kinds, units = {"x": "length", **QUOTED}.items(), found.scene.units
    headings = (escape(f"{n.replace('_', ' ')} [{unit(kind, units)}]") for n, kind in kinds)
    table = PrintedTable(numbers=headings, title="Rupture")
    for place, x in enumerate(found.quoted.x):
        pairs = [[row[place] for row in getattr(found.quoted, name)] for name in QUOTED]
        cells = [f"{value:.3g} ± {error:.1g}" if value == value else "-" for value, error in pairs]
        table.add_row(f"{x:.4g}", *cells)
    return table


def _gauges_table(found: Fit, most: int = 12) -> PrintedTable:
    length = unit("length", found.scene.units)
    numbers = *(escape(f"{axis} [{length}]") for axis in "xy"), "samples", "chi2"
    table = PrintedTable("gauge", "quantity", numbers=numbers, title="Gauges")
    rows = list(zip(found.gauges, found.residuals, strict=True))
    for gauge, residual in rows[:most]:
        table.add_row(
            escape(gauge.label),
            gauge.quantity,
            f"{gauge.x:.5g}",
            "" if gauge.y is None else f"{gauge.y:.5g}",
            str(len(gauge.t)),
            f"{np.sum((residual / gauge.noise) ** 2):.4g}",
        )
    if len(rows) > most:
        table.add_row(f"and {len(rows) - most} more", *[""] * 5)
    return table


def _noise(scene: Scene, given: Sequence[str]) -> dict[str, float]:
    """Return standard deviations by quantity; the key "" stands for all quantities.

    A number with a unit and without a name stands for all quantities that have this unit.
    """
    result: dict[str, float] = {}
    for text in given:
        name, _, number = text.rpartition("=")
        if name:
            result |= options.read_numbers(scene, "noise", [text], QUANTITIES)
            continue
        kinds = [kind for kind in dict.fromkeys(QUANTITIES.values()) if _is_of(kind, number)]
        if not kinds:
            units = "; ".join(map(units_shown, dict.fromkeys(QUANTITIES.values())))
            raise SceneError(
                "--noise must be a number for all samples, such as 0.01, or one in a unit for "
                f"those that have it ({units}), or NAME=NUMBER for one quantity, such as "
                f"slip_rate=0.01, got {shown(number)}."
            )
        sizes = {kind: _measured(scene, "noise", number, kind) for kind in kinds}
        of_all = {"": sizes["1"]} if len(kinds) == len(set(QUANTITIES.values())) else {}
        found = {quantity: sizes[kind] for quantity, kind in QUANTITIES.items() if kind in sizes}
        result = {**(of_all or found), **result}
    return result


def _is_of(kind: str, number: str) -> bool:
    """Return whether a text is a number without a unit, or in one of a dimension."""
    try:
        measure(number, kind, si_size)
    except SceneError:
        return False
    return True


def _measured(scene: Scene, name: str, text: str, kind: str) -> float:
    """Return a number that may have a unit of a dimension, in the units of the scene."""
    number: float = options.asked(scene, name, measure(text, kind, si_size), kind)
    return number


def _places(scene: Scene, given: Sequence[str]) -> dict[str, tuple[Any, ...]]:
    """Parse NAME=QUANTITY@X,Y arguments, some of which may be files of them, by name."""
    listed: list[tuple[str, str]] = []
    for text in given:
        if "=" in text or not text.endswith(".toml"):
            listed.append(("--gauge", text))
            continue
        named = read_document(text)
        if not named:
            raise SceneError(f"{text} names no gauge; write lines such as SG1 = 'exx@20mm,3.5mm'.")
        listed += [(text, f"{name}={place}") for name, place in named.items()]
    result: dict[str, tuple[Any, ...]] = {}
    for where, text in listed:
        match = _PLACE.match(text)
        if match is None or match[2] not in QUANTITIES:
            raise SceneError(
                f"{where}: a gauge must be NAME=QUANTITY@X,Y, as SG1=exx@20mm,3.5mm, or @X on the "
                f"interface, with one of {', '.join(QUANTITIES)}, got {shown(text)}."
            )
        try:
            place = [_measured(scene, "gauge", at, "length") for at in match[3].split(",")]
        except SceneError as error:
            raise SceneError(f"{where}: the place of {match[1]} {error}") from None
        if result.setdefault(match[1].strip(), (match[2], *place)) != (match[2], *place):
            raise SceneError(f"{where}: {match[1]} has two places; give one.")
    return result


def _priors(scene: Scene, given: Sequence[str]) -> dict[str, Prior]:
    """Parse NAME=KIND(A,B) arguments, whose numbers may have units, into priors by name."""
    result: dict[str, Prior] = {}
    for text in given:
        match = _PRIOR.match(text)
        if match is None or match[2].lower() not in PRIORS:
            raise _no_prior(text)
        name, kind = plain_name(match[1].strip()), match[2].lower()
        own = dimension(name, scene)
        # the second number of a log-normal prior is a factor
        kinds = own, "1" if kind == "lognormal" else own
        try:
            numbers = [
                _measured(scene, "prior", number, quantity)
                for number, quantity in zip(match.group(3, 4), kinds, strict=True)
            ]
        except SceneError as error:
            raise SceneError(f"{_no_prior(text)} Its numbers: each {error}") from None
        result[name] = PRIORS[kind](*numbers)
    return result


def _no_prior(text: str) -> SceneError:
    return SceneError(
        "--prior must be NAME=KIND(A,B) with a kind among "
        f"{', '.join(PRIORS)}, as friction=normal(0.3,0.1), got {text!r}."
    )
