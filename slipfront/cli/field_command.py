"""``slipfront field``: fields inside the bodies as pictures, animations, grids and records."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import typer
from rich.console import Console

from compare.comparison.documents import SCENE_DIMENSIONS, Dimensions, units_document
from compare.output.bodies import Fields
from compare.output.places import working_folder
from compare.output.progress import progress_bar
from semianalytic import Marched, Scene, Solution, solve
from semianalytic.dissimilar_slot.solution import PairSolution
from semianalytic.methods import chosen
from semianalytic.parameters.overriding import override_scene
from semianalytic.results.answer import method_of
from semianalytic.scene.checks import checked_size, shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.extras import FEM, PLOT, require
from semianalytic.scene.given.documents import scene_document
from semianalytic.scene.given.finding import find_scene, scene_folder, scene_label
from semianalytic.scene.units import unit
from slipfront.cli.endings.refusals import check_converged, check_no_march_options
from slipfront.cli.marching import check_resolved
from slipfront.cli.options import (
    LOWER_OPTIONS,
    MARCH_OPTIONS,
    SCENE_OPTIONS,
    AsJson,
    FiguresForm,
    Method,
    Output,
    Quiet,
    SceneArgument,
    asked,
    in_bytes,
    measured_option,
    option_name,
    with_options,
)
from slipfront.cli.scenes.completion import FORMATS, QUANTITIES, one_of
from slipfront.cli.scenes.requests import (
    GRID,
    MOST_FRAMES,
    MOST_POINTS,
    MOST_SAMPLES,
    Request,
    cells_of,
    count_of,
    fringe_stress,
    place_of,
    window_of,
)
from slipfront.cli.terminal import print_json

if TYPE_CHECKING:
    from compare.figures.quantities import Quantity

MARCHED_OPTIONS = {name: MARCH_OPTIONS[name] for name in ("nodes", "rtol", "length", "memory")}
_DIMENSIONS: Dimensions = {
    "scene": SCENE_DIMENSIONS,
    "error_estimate": "1",
    "time": "time",
    "window": "length",
    "gauges": "length",
}

_PICTURE, _FILM, _GRID, _GAUGE = "Picture", "Animation", "Grid for ParaView", "Gauges"

_Window = Annotated[
    str | None,
    typer.Option(
        metavar="X0,X1,Y0,Y1",
        help="Part of the plane to show \\[length]; everything the waves have reached by default.",
    ),
]
_Gauges = Annotated[
    list[str] | None,
    typer.Option(
        metavar="X,Y",
        help="Record all fields at a point from t = 0 to --time; may be repeated.",
        rich_help_panel=_GAUGE,
    ),
]


@with_options(overrides=SCENE_OPTIONS, lower=LOWER_OPTIONS, march_options=MARCHED_OPTIONS)
def field_command(
    overrides: Mapping[str, Any],
    lower: Mapping[str, Any],
    march_options: Mapping[str, Any],
    scene_name: SceneArgument,
    of: Annotated[
        str,
        typer.Option(
            help="Quantity: speed, pressure, max-shear, fringes, vx, vy, ux, uy, sxx, syy or sxy; "
            "in antiplane shear also vz, uz, sxz or syz.",
            autocompletion=one_of(*QUANTITIES),
            rich_help_panel=_PICTURE,
        ),
    ] = "speed",
    time: Annotated[
        float | None, measured_option("time", "Time of the picture [time]; 1 / c_t by default.")
    ] = None,
    window: _Window = None,
    points: Annotated[
        int, typer.Option(help="Points along the longer side.", rich_help_panel=_PICTURE)
    ] = 400,
    thickness: Annotated[
        float | None,
        measured_option("length", "Thickness of the body along z, for fringes [length].", _PICTURE),
    ] = None,
    stress_optical: Annotated[
        float | None,
        measured_option(
            "stress length",
            "Material fringe constant, such as 7.2kN/m, stress times thickness per fringe [stress "
            "length]; by default the larger step makes 4 fringes. Needs --thickness.",
            _PICTURE,
        ),
    ] = None,
    animate: Annotated[
        int,
        typer.Option(
            metavar="N", help="Animate N times from 0 to --time as well.", rich_help_panel=_FILM
        ),
    ] = 0,
    form: Annotated[
        str | None,
        typer.Option(
            "--format",
            help="Format of the animation: gif, which is the default, or mp4.",
            rich_help_panel=_FILM,
            autocompletion=one_of(*FORMATS),
        ),
    ] = None,
    vtu: Annotated[
        bool,
        typer.Option(
            "--vtu",
            help="Write velocity, displacement and stress, at the times of --animate if given.",
            rich_help_panel=_GRID,
        ),
    ] = False,
    grid: Annotated[
        str | None,
        typer.Option(
            metavar="NX,NY", help="Cells of the grid; 200,200 by default.", rich_help_panel=_GRID
        ),
    ] = None,
    gauge: _Gauges = None,
    samples: Annotated[
        int | None,
        typer.Option(help="Number of times of a record; 1000 by default.", rich_help_panel=_GAUGE),
    ] = None,
    method: Method = "auto",
    output: Output = None,
    figures: FiguresForm = "png",
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Draw fields inside the bodies with all fronts named; animate, export or record them.

    Velocity, stress and displacement are exact if the scene is self-similar, between different
    bodies as well: the lower one is lower_material of the file, or is like the upper one
    but for the numbers that are given.  A picture is written
    to DIR/SCENE_QUANTITY.png, an animation beside it, grids to DIR/fields.pvd, and the record of
    the first --gauge to DIR/SCENE_gauge-1.csv; at the end every file is listed with what it shows.
    """
    require("slipfront field", *PLOT, *(FEM if vtu else ()))
    from compare.figures.animation import check_format
    from compare.figures.quantities import find_quantity

    given, label = {**overrides, **lower}, scene_label(scene_name)
    scene = override_scene(find_scene(scene_name), **given)
    marched = chosen(scene, method).name == "space-time"
    if not marched:
        check_no_march_options(march_options, scene)
    time = asked(scene, "time", time, "time")
    thickness = asked(scene, "thickness", thickness, "length")
    stress_optical = asked(scene, "stress_optical", stress_optical, "stress length")
    step = fringe_stress(of, thickness, stress_optical)
    quantity = find_quantity(of, scene, step)
    if grid is not None and not vtu:
        raise SceneError("--grid needs --vtu; give both.")
    if form is not None and form not in FORMATS:
        raise SceneError(f"--format must be one of {', '.join(FORMATS)}, got {shown(form)}.")
    request = Request(
        1 / scene.material.shear_speed if time is None else checked_size("field: time", time),
        None if window is None else window_of(scene, window),
        count_of("points", points, 2, MOST_POINTS),
        count_of("animate", animate, 0, MOST_FRAMES),
        form or FORMATS[0],
        (cells_of(grid) if grid else GRID) if vtu else None,
        tuple(place_of(scene, one) for one in gauge or ()),
        count_of("samples", 1000 if samples is None else samples, 2, MOST_SAMPLES),
        figures,
    )
    if form is not None and not request.frames:
        raise SceneError("--format is that of --animate; give both.")
    if samples is not None and not request.gauges:
        raise SceneError("--samples are those of --gauge; give both.")
    if request.frames:
        check_format(request.form)
    directory = output or scene_folder(scene_name, given) / "field"
    words = [scene_name, *(f"{option_name(k)}={v}" for k, v in given.items())]
    answer: Solution | Marched | PairSolution
    with working_folder(directory) as files:
        answer = (
            _marched(scene, request.time, march_options, quiet)
            if marched
            else solve(scene, method="self-similar")
        )
        _draw(directory, f"{label}_{of}", answer, quantity, request, quiet)
        if request.grid is not None:
            _write_grid(directory, answer, request, quiet)
        _record(directory, label, answer, request, words)
    if as_json:
        print_json("field", _document(answer, of, request), answer.status, files)
    else:
        lines = [f"Written to {directory}/:", *_contents(label, of, request, scene)]
        Console(soft_wrap=True).print("\n".join(lines), highlight=False, markup=False)
    if method_of(answer) == "space-time":
        check_resolved(answer, label)
    else:
        check_converged(answer, label)


def _contents(label: str, of: str, request: Request, scene: Scene) -> Iterator[str]:
    """Yield a line for each file that was written: its name, and what is in it."""
    length, moment = (unit(kind, scene.units) for kind in ("length", "time"))
    until, form = f"{request.time:g} {moment}", request.figures
    names = {f"{label}_{of}.{form}": f"{of} at t = {until}"}
    if request.frames:
        names[f"{label}_{of}.{request.form}"] = f"{of} until then, {request.frames} frames"
    if request.grid is not None:
        cells, count = "×".join(map(str, request.grid)), len(request.times)
        names["fields.pvd"] = f"fields on {cells} cells for ParaView, {count} times until {until}"
    for number, (x, y) in enumerate(request.gauges, start=1):
        place = f"x = {x:g} {length}, y = {y:g} {length}"
        records = f"record at {place}, {request.samples} times until {until}"
        names[f"{label}_gauge-{number}.csv"] = records
        names[f"{label}_gauge-{number}.{form}"] = "figure of this record"
    width = max(map(len, names))
    yield from (f"  {name:{width}}  {words}" for name, words in names.items())


def _document(
    answer: Solution | Marched | PairSolution, of: str, request: Request
) -> dict[str, Any]:
    """Return what was drawn and recorded as plain dictionaries, with units."""
    window = request.window or _reach(answer, request)
    document: dict[str, Any] = {
        "scene": scene_document(answer.scene),
        "method": method_of(answer),
        "error_estimate": answer.error_estimate,
        "of": of,
        "time": request.time,
        "window": dict(zip(("x0", "x1", "y0", "y1"), window, strict=True)),
        "frames": request.frames,
        "gauges": [{"x": x, "y": y} for x, y in request.gauges],
    }
    document["units"] = units_document(document, _DIMENSIONS, answer.scene)
    return document


def _reach(fields: Fields, request: Request) -> tuple[float, float, float, float]:
    """Return the window that holds everything the waves have reached."""
    from compare.figures.fronts import reach

    return reach(fields, request.time)


def _marched(scene: Scene, time: float, options: Mapping[str, Any], quiet: bool) -> Marched:
    memory = in_bytes(options.get("memory"))
    with progress_bar(Console(stderr=True), quiet, "marching") as progress:
        options = {**options, "end_time": time, "memory": memory, "progress": progress}
        return solve(scene, method="space-time", **options)


def _draw(
    directory: Path,
    name: str,
    fields: Fields,
    quantity: Quantity,
    request: Request,
    quiet: bool,
) -> None:
    """Draw the picture, and the animation if one is requested."""
    from compare.figures.animation import write_animation
    from compare.figures.fields import FieldPicture
    from compare.figures.saving import save_figure

    window = request.window or _reach(fields, request)
    picture = FieldPicture(fields, quantity, window, request.points, request.time)
    save_figure(picture.figure, directory / f"{name}.{request.figures}")
    if request.frames:
        path = directory / f"{name}.{request.form}"
        with progress_bar(Console(stderr=True), quiet, "drawing") as progress:
            write_animation(path, picture, request.times, progress)


def _write_grid(directory: Path, fields: Fields, request: Request, quiet: bool) -> None:
    from compare.output.field_files import write_frames

    assert request.grid is not None
    window = request.window or _reach(fields, request)
    with progress_bar(Console(stderr=True), quiet, "writing") as progress:
        write_frames(directory, fields, request.times, window, request.grid, progress)


def _record(
    directory: Path, label: str, fields: Fields, request: Request, words: list[str]
) -> None:
    """Write a table and a figure for every gauge."""
    from compare.figures.records import record_figure
    from compare.figures.saving import save_figure
    from compare.output.field_files import record_fields, write_record

    t = np.linspace(0.0, request.time, request.samples)
    for number, (x, y) in enumerate(request.gauges, start=1):
        record, path = record_fields(fields, x, y, t), directory / f"{label}_gauge-{number}.csv"
        asked = [f"--gauge={x!r},{y!r}", f"--time={request.time!r}", f"--samples={len(t)}"]
        command = shlex.join(["slipfront", "field", *words, *asked])
        write_record(path, record, fields.scene.units, command)
        save_figure(record_figure(record, fields.scene), path.with_suffix(f".{request.figures}"))
