"""``slipfront survey``: a scene at many values of its parameters, into a file."""

from __future__ import annotations

import re
import shlex
import sys
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.console import Console
from rich.markup import escape

from compare.output.printed import PrintedTable
from compare.output.progress import progress_bar
from semianalytic.parameters.overriding import override_scene
from semianalytic.scene.checks import checked_count, shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.extras import CLUSTER, require
from semianalytic.scene.given.finding import scene_label
from semianalytic.scene.units import ARGUMENTS, InSI, unit
from slipfront.cli import options
from slipfront.cli.terminal import print_json

if TYPE_CHECKING:
    from slipfront.surveys.parameters import Scene


_VALUES = (
    "Values: a number, a list 0.1,0.2,0.5, or start:stop:count, with :log for equal ratios; "
    "with units as 1MPa:5MPa:9"
)

_DIGIT = re.compile(r"\d")


def _values(text: str) -> Any:
    return options.optional(str, _VALUES, text, metavar="VALUES")


VALUE_OPTIONS: Mapping[str, Any] = {
    name: _values(hint.__metadata__[0].help.replace("\\[", "["))
    for name, hint in {**options.SCENE_OPTIONS, **options.LOWER_OPTIONS}.items()
    if name not in ("mode", "load_on", "wave", "wave_from", "units")
}
SAMPLES: Mapping[str, Any] = {
    "x": _values("Positions at which fields are stored [length]."),
    "t": _values("Times at which fields are stored [time]."),
}
QUESTIONS: Mapping[str, Any] = {
    name: options.optional(type_, None, text, dimension=dimension)
    for name, type_, text, dimension in (
        ("rtol", float, "Requested accuracy; 1e-6 by default for solutions, none for marches.", ""),
        ("end_time", float, "Time until which totals are taken and marches run [time].", "time"),
        ("nodes", int, "Number of contact nodes of marches.", ""),
        ("length", float, "Length of the contact that marches observe [length].", "length"),
    )
}
_OPTIONS: Mapping[str, Any] = {
    "vary": options.option(
        "Any other number of the scene, such as friction_law.reduction=0:1:11, or of an "
        "interface, such as friction_law.distance=1e-5:1e-4:10:log.",
        metavar="NAME=VALUES",
    ),
    "together": options.option(
        "Take the values as one list of points instead of a grid.", flag="--together"
    ),
    "output": options.option(
        "NetCDF file to write; results/SCENE-survey.nc by default.", metavar="FILE"
    ),
    "chunk": options.option("Largest number of points that are solved and saved together."),
    "workers": options.option("Number of processes; one per core by default."),
    "scheduler": options.option(
        "Work on the Dask cluster of this scheduler, as tcp://127.0.0.1:8786.", metavar="ADDRESS"
    ),
}


@options.with_options(
    _OPTIONS,
    values=VALUE_OPTIONS,
    samples=SAMPLES,
    question=QUESTIONS,
    overrides={"units": options.SCENE_OPTIONS["units"]},
)
def survey_command(
    values: Mapping[str, str],
    samples: Mapping[str, str],
    question: Mapping[str, Any],
    overrides: Mapping[str, Any],
    scene_name: options.SceneArgument,
    vary: list[str] | None = None,
    together: bool = False,
    output: Path | None = None,
    chunk: int | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    as_json: options.AsJson = False,
    quiet: options.Quiet = False,
) -> None:
    """Solve a scene for many values of its parameters, and write NetCDF.

    Scenes on a line and other scenes that are not self-similar are marched.  The lower body is
    lower_material of the file, or equals the upper one except for the numbers that are given.

    An interrupted survey resumes when it is started again with the same values.  Scenes that are
    refused have nan as their values and the reason as their status; the exit code is still 0.
    """
    from compare.tasks.cluster import connected
    from slipfront.surveys.parameters import checked_subject
    from slipfront.surveys.plan import Question, planned
    from slipfront.surveys.run import FIELDS, run_survey

    scene = override_scene(checked_subject(scene_name), **overrides)
    path = output or Path("results", f"{scene_label(scene_name)}-survey.nc")
    if workers is not None:
        checked_count("--workers", workers, 1, "a whole number from")
    places = {
        name: tuple(np.atleast_1d(typed_values(scene, name, text, ARGUMENTS[name])).tolist())
        for name, text in samples.items()
    }
    for name in ("end_time", "length"):
        options.asked(scene, name, question.get(name), ARGUMENTS[name])
    wanted: dict[str, Any] = {**question, **places, "fields": FIELDS if "t" in places else ()}
    given: dict[str, Any] = {
        name: typed_values(scene, name, text, options.option_dimension(name))
        for name, text in values.items()
    }
    others = _others(scene, vary or ())
    if twice := [name for name in others if name in given]:
        raise SceneError(
            f"--vary {twice[0]} and {options.option_name(twice[0])} are one parameter; give one of "
            "them."
        )
    given |= others
    plan = planned(scene, given, Question(**wanted), together=together, chunk=chunk)
    command = shlex.join(["slipfront", *sys.argv[1:]])
    bar = progress_bar(Console(stderr=True), quiet or as_json, "surveying")
    if scheduler is not None:
        require("--scheduler", *CLUSTER)
    with connected(scheduler) as client, bar as progress:
        found = run_survey(plan, path, workers, client, progress, command)
    document = survey_document(found, path)
    if as_json:
        print_json("survey", document, files=[path])
    else:
        Console().print(_table(document, scene_label(scene_name)))
        Console().print(f"Written to {path}", highlight=False, markup=False)


def typed_values(scene: Scene, name: str, text: str, dimension: str) -> Any:
    """Parse values as they are typed: a number, a row ``0.1,0.2``, or ``start:stop:count``.

    Numbers of a dimension may have units, all of one text or none; they are returned in the units
    of the scene.  Other texts, and too many values, are refused by a SceneError.
    """
    from slipfront.surveys.plan import MOST_VALUES

    first, *others = text.split(":")
    try:
        if not others:
            row = _read(scene, name, text.split(","), dimension)
            return np.array(row) if "," in text else row[0]
        stop, count, *scale = others
        (start, end), number = _read(scene, name, (first, stop), dimension), int(count)
        if number < 1 or scale not in ([], ["log"]):
            raise ValueError(count)
        if scale and not start * end > 0:
            raise _no_values(name, text)  # equal ratios do not reach or cross 0
        if number <= MOST_VALUES:
            return np.geomspace(start, end, number) if scale else np.linspace(start, end, number)
    except ValueError as error:
        # a unit of another dimension is no matter of form
        if isinstance(error, SceneError) and all(map(_DIGIT.search, re.split("[:,]", text)[:2])):
            raise
        raise _no_values(name, text) from error
    raise SceneError(
        f"{options.option_name(name)} must be at most {MOST_VALUES:.0e} values, got {text!r}."
    )


def _read(scene: Scene, name: str, texts: Sequence[str], dimension: str) -> list[float]:
    numbers = [options.read_number(scene, name, text, dimension) for text in texts]
    bare = [number for number in numbers if number and not isinstance(number, InSI)]
    if 0 < len(bare) < len(numbers) and any(isinstance(number, InSI) for number in numbers):
        raise SceneError(
            f"{options.option_name(name)} must have a unit at each number or at none, got "
            f"{shown(','.join(texts))}."
        )
    return numbers


def _no_values(name: str, text: str) -> SceneError:
    return SceneError(
        f"{options.option_name(name)} must be a number, a row as 0.1,0.2,0.5, or start:stop:count "
        f"as 0.1:0.9:100, got {text!r}."
    )


def _others(scene: Scene, vary: Sequence[str]) -> dict[str, Any]:
    """Return the values of parameters that have no option of their own."""
    from semianalytic.parameters.numbers import numbers_of
    from slipfront.surveys.parameters import parameter_name

    result: dict[str, Any] = {}
    for text in vary:
        name, values = options.read_pair("vary", text, "values", "friction_law.reduction=0:1:11")
        if name in result:
            raise SceneError(f"--vary {name} is given twice; give all its values in one row.")
        dimension = numbers_of(scene)[parameter_name(scene, name)].dimension
        result[name] = typed_values(scene, "vary", values, dimension)
    return result


def survey_document(found: Any, path: Path) -> dict[str, Any]:
    """Summarise a survey in numbers with their units, for JSON."""
    counts = Counter(np.asarray(found["status"].values).ravel().tolist())
    methods = Counter(np.asarray(found["method"].values).ravel().tolist())
    estimates = found["error_estimate"].values if "error_estimate" in found else np.array([np.nan])
    document: dict[str, Any] = {
        "file": str(path),
        "points": int(found["status"].size),
        "dimensions": {name: int(length) for name, length in found.sizes.items()},
        "parameters": {
            name: {"least": float(row.min()), "largest": float(row.max()), "count": row.size}
            for name, row in found.coords.items()
            if row.dtype.kind == "f"
        },
        "statuses": dict(counts.most_common()),
        "methods": dict(methods.most_common()),
        "largest_error_estimate": float(np.fmax.reduce(estimates, axis=None)),
        "seconds": float(found["seconds"].sum()),
        "variables": sorted(map(str, found.data_vars)),
    }
    units = {name: found[name].attrs.get("units", "1") for name in document["variables"]}
    document["units"] = {
        "parameters": {name: found[name].attrs["units"] for name in document["parameters"]},
        "largest_error_estimate": unit("1"),
        "seconds": "s",
        "variables": units,
    }
    return document


def _table(document: Mapping[str, Any], label: str) -> PrintedTable:
    table = PrintedTable(title=f"{label}: {document['points']:,} points", show_header=False)
    for name, row in document["parameters"].items():
        units = document["units"]["parameters"][name]
        text = f"{row['least']:.6g} to {row['largest']:.6g} ({row['count']})"
        table.add_row(name.replace("_", " "), text if units == "1" else f"{text} {units}")
    statuses = list(document["statuses"].items())
    for status, count in statuses[:_SHOWN]:
        table.add_row(f"{count:,}", escape(status))
    if len(statuses) > _SHOWN:
        table.add_row(f"{sum(count for _, count in statuses[_SHOWN:]):,}", "otherwise")
    table.add_row("largest error estimate", f"{document['largest_error_estimate']:.2g}")
    table.add_row("processor time", f"{document['seconds']:.3g} s")
    return table


_SHOWN = 4
"""Number of statuses in the table; the rest are counted together."""
