"""``slipfront field``: fields inside the bodies as pictures, animations, grids and records."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Mapping
from contextlib import suppress
from functools import partial
from typing import Any

import numpy as np
from rich.console import Console

from compare.comparison.documents import SCENE_DIMENSIONS, Dimensions, units_document
from compare.output.places import working_folder
from compare.output.progress import progress_bar
from semianalytic import Scene, solve
from semianalytic.methods import chosen
from semianalytic.parameters.overriding import override_scene
from semianalytic.results.answer import method_of
from semianalytic.results.interruption import whole
from semianalytic.scene.checks import checked_number, checked_size, checked_word, shown
from semianalytic.scene.errors import SceneError
from semianalytic.scene.extras import FEM, PLOT, require
from semianalytic.scene.given.documents import scene_document
from semianalytic.scene.given.finding import check_slot, find, scene_folder, scene_label
from semianalytic.scene.tables.units import si_size
from semianalytic.scene.units import measure, unit
from slipfront.cli import options
from slipfront.cli.endings.refusals import check_converged, check_no_march_options
from slipfront.cli.marching import check_marched, shares_of
from slipfront.cli.scenes.completion import FORMATS, QUANTITIES, one_of
from slipfront.cli.terminal import print_json

GRID = (200, 200)
"""Default number of cells of a grid, along x and y."""
MOST_POINTS, MOST_FRAMES, MOST_SAMPLES = 4000, 10_000, 1_000_000
"""Limits of points and cells along an axis, of frames, and of times; more are a typing error."""
MARCHED_OPTIONS = {
    name: options.MARCH_OPTIONS[name] for name in ("nodes", "rtol", "length", "memory")
}
_DIMENSIONS: Dimensions = {
    "scene": SCENE_DIMENSIONS,
    "error_estimate": "1",
    "time": "time",
    "window": "length",
    "gauges": "length",
}

_PICTURE, _FILM, _GRID, _GAUGE = "Picture", "Animation", "Grid for ParaView", "Gauges"

_OPTIONS: Mapping[str, Any] = {
    "of": options.option(
        "Quantity: speed, pressure, max-shear, fringes, vx, vy, ux, uy, sxx, syy or sxy; "
        "in antiplane shear also vz, uz, sxz or syz.",
        _PICTURE,
        complete=one_of(*QUANTITIES),
    ),
    "time": options.measured_option("time", "Time of the picture [time]; 1 / c_t by default."),
    "window": options.option(
        "Part of the plane to show [length]; everything the waves have reached by default.",
        metavar="X0,X1,Y0,Y1",
    ),
    "points": options.option("Points along the longer side.", _PICTURE),
    "thickness": options.measured_option(
        "length", "Thickness of the body along z, for fringes [length].", _PICTURE
    ),
    "stress_optical": options.measured_option(
        "stress length",
        "Material fringe constant, such as 7.2kN/m, stress times thickness per fringe [stress "
        "length]; by default the larger step makes 4 fringes. Needs --thickness.",
        _PICTURE,
    ),
    "animate": options.option("Animate N times from 0 to --time as well.", _FILM, metavar="N"),
    "form": options.option(
        "Format of the animation: gif, which is the default, or mp4.",
        _FILM,
        flag="--format",
        complete=one_of(*FORMATS),
    ),
    "vtu": options.option(
        "Write velocity, displacement and stress, at the times of --animate if given.",
        _GRID,
        flag="--vtu",
    ),
    "grid": options.option("Cells of the grid; 200,200 by default.", _GRID, metavar="NX,NY"),
    "gauge": options.option(
        "Record all fields at a point from t = 0 to --time; may be repeated.", _GAUGE, metavar="X,Y"
    ),
    "samples": options.option("Number of times of a record; 1000 by default.", _GAUGE),
}


@options.with_options(
    _OPTIONS,
    overrides=options.SCENE_OPTIONS,
    lower=options.LOWER_OPTIONS,
    march_options=MARCHED_OPTIONS,
)
def field_command(
    overrides: Mapping[str, Any],
    lower: Mapping[str, Any],
    march_options: Mapping[str, Any],
    scene_name: options.SceneArgument,
    of: str = "speed",
    time: float | None = None,
    window: str | None = None,
    points: int = 400,
    thickness: float | None = None,
    stress_optical: float | None = None,
    animate: int = 0,
    form: str | None = None,
    vtu: bool = False,
    grid: str | None = None,
    gauge: list[str] | None = None,
    samples: int | None = None,
    method: options.Method = "auto",
    output: options.Output = None,
    figures: options.FiguresForm = "png",
    as_json: options.AsJson = False,
    quiet: options.Quiet = False,
) -> None:
    """Draw fields inside the bodies with all fronts named; animate, export or record them.

    Velocity, stress and displacement are exact if the scene is self-similar, between different
    bodies as well: the lower one is lower_material of the file, or equals the upper one
    except for the numbers that are given.  Other scenes with a slot, and those on a line, are
    marched until --time.  A picture is written to DIR/SCENE_QUANTITY.png, an animation to the same
    folder, grids to DIR/fields.pvd, and the record of the first --gauge to DIR/SCENE_gauge-1.csv;
    at the end every file is listed with what it shows.
    """
    require("slipfront field", *PLOT, *(FEM if vtu else ()))
    from compare.figures.animation import check_format, write_animation
    from compare.figures.fields import FieldPicture, record_figure
    from compare.figures.fronts import reach
    from compare.figures.quantities import find_quantity
    from compare.figures.saving import save_figure
    from compare.output.field_files import record_fields, write_frames, write_record

    given, label = {**overrides, **lower}, scene_label(scene_name)
    scene = override_scene(find(scene_name), **given)
    marched = chosen(scene, method).name == "space-time"
    if not marched:
        check_slot(label, scene)
        check_no_march_options(march_options, scene)
    time = options.asked(scene, "time", time, "time")
    thickness = options.asked(scene, "thickness", thickness, "length")
    stress_optical = options.asked(scene, "stress_optical", stress_optical, "stress length")
    step = _fringe_stress(of, thickness, stress_optical)
    quantity = find_quantity(of, scene, step)
    if grid is not None and not vtu:
        raise SceneError("--grid needs --vtu; give both.")
    if form is not None:
        checked_word("--format", form, FORMATS)
    usual = scene.run.get("end_time", 1 / scene.material.shear_speed)
    time = usual if time is None else checked_size("field: time", time)
    asked_window = None if window is None else _window_of(scene, window)
    points = _count_of("points", points, 2, MOST_POINTS)
    frames = _count_of("animate", animate, 0, MOST_FRAMES)
    times = np.linspace(time / max(frames, 1), time, max(frames, 1)).tolist()
    cells = _cells_of(grid) if grid else GRID
    gauges = [_place_of(scene, place) for place in gauge or ()]
    count = 1000 if samples is None else samples
    t = np.linspace(0.0, time, _count_of("samples", count, 2, MOST_SAMPLES))
    if form is not None and not frames:
        raise SceneError("--format is that of --animate; give both.")
    if samples is not None and not gauges:
        raise SceneError("--samples are those of --gauge; give both.")
    form = form or FORMATS[0]
    if frames:
        check_format(form)
    directory = output or scene_folder(scene_name, given) / "field"
    bar = partial(progress_bar, Console(stderr=True), quiet)
    length, moment = (unit(kind, scene.units) for kind in ("length", "time"))
    until = f"{time:g} {moment}"
    with working_folder(directory) as files:
        if marched:
            with bar("marching") as progress:
                settings = {**march_options, "end_time": time}
                if "memory" in settings:
                    settings["memory"] = options.in_bytes(settings["memory"])
                settings["progress"] = shares_of(progress)
                answer: Any = whole(solve(scene, method="space-time", **settings))
        else:
            answer = solve(scene, method="self-similar")
        shown_window = asked_window or reach(answer, time)
        picture = FieldPicture(answer, quantity, shown_window, points, time)
        names = {f"{label}_{of}.{figures}": f"{of} at t = {until}"}  # what is in each file
        save_figure(picture.figure, directory / f"{label}_{of}.{figures}")
        if frames:
            names[f"{label}_{of}.{form}"] = f"{of} until then, {frames} frames"
            with bar("drawing") as progress:
                write_animation(directory / f"{label}_{of}.{form}", picture, times, progress)
        if vtu:
            what = f"fields on {cells[0]}×{cells[1]} cells for ParaView"
            names["fields.pvd"] = f"{what}, {len(times)} times until {until}"
            with bar("writing") as progress:
                write_frames(directory, answer, times, shown_window, cells, progress)
        for number, (x, y) in enumerate(gauges, start=1):
            record, path = record_fields(answer, x, y, t), directory / f"{label}_gauge-{number}.csv"
            words = [scene_name, *(f"{options.option_name(k)}={v}" for k, v in given.items())]
            words += [f"--gauge={x!r},{y!r}", f"--time={time!r}", f"--samples={len(t)}"]
            write_record(path, record, scene.units, shlex.join(["slipfront", "field", *words]))
            save_figure(record_figure(record, scene), path.with_suffix(f".{figures}"))
            place = f"x = {x:g} {length}, y = {y:g} {length}"
            names[path.name] = f"record at {place}, {len(t)} times until {until}"
            names[f"{path.stem}.{figures}"] = "figure of this record"
    if as_json:
        document: dict[str, Any] = {
            "scene": scene_document(answer.scene),
            "method": method_of(answer),
            "error_estimate": answer.error_estimate,
            "of": of,
            "time": time,
            "window": dict(zip(("x0", "x1", "y0", "y1"), shown_window, strict=True)),
            "frames": frames,
            "gauges": [{"x": x, "y": y} for x, y in gauges],
        }
        document["units"] = units_document(document, _DIMENSIONS, answer.scene)
        print_json("field", document, answer.status, files)
    else:
        width = max(map(len, names))
        lines = (f"  {name:{width}}  {words}" for name, words in names.items())
        text = "\n".join([f"Written to {directory}/:", *lines])
        Console(soft_wrap=True).print(text, highlight=False, markup=False)
    if method_of(answer) == "space-time":
        check_marched(answer, label)
    else:
        check_converged(answer, label)


def _fringe_stress(of: str, thickness: float | None, stress_optical: float | None) -> float | None:
    """Return the difference of principal stresses per fringe [stress], if it is given."""
    if thickness is None and stress_optical is None:
        return None
    if of != "fringes":
        raise SceneError("--thickness and --stress-optical are for --of fringes; add that.")
    if thickness is None or stress_optical is None:
        raise SceneError("fringes follow from --thickness and --stress-optical; give both.")
    constant = checked_size("field: stress_optical", stress_optical)
    return constant / checked_size("field: thickness", thickness)


def _count_of(name: str, value: int, least: int, most: int) -> int:
    if not least <= value <= most:
        raise SceneError(
            f"{options.option_name(name)} must be a whole number from {least} to {most}, got "
            f"{shown(value)}."
        )
    return value


def _window_of(scene: Scene, text: str) -> tuple[float, float, float, float]:
    required = "be four numbers x0,x1,y0,y1 with x0 < x1 and y0 < y1"
    x0, x1, y0, y1 = _numbers("window", text, 4, required, scene)
    if not (x0 < x1 and y0 < y1):
        raise SceneError(f"--window must {required}, got {shown(text)}.")
    return x0, x1, y0, y1


def _place_of(scene: Scene, text: str) -> tuple[float, float]:
    x, y = _numbers("gauge", text, 2, "be two numbers x,y", scene)
    return x, y


def _cells_of(text: str) -> tuple[int, int]:
    required = f"be two whole numbers nx,ny from 2 to {MOST_POINTS}"
    nx, ny = _numbers("grid", text, 2, required)
    if not all(count.is_integer() and 2 <= count <= MOST_POINTS for count in (nx, ny)):
        raise SceneError(f"--grid must {required}, got {shown(text)}.")
    return int(nx), int(ny)


def _numbers(
    name: str, text: str, count: int, required: str, scene: Scene | None = None
) -> Iterator[float]:
    """Parse a given count of finite numbers that are separated by commas.

    They are lengths that may have units if there is a scene.
    """
    numbers: list[Any] = []
    with suppress(ValueError, SceneError):
        parts = text.split(",")
        if scene is None:
            numbers = [float(part) for part in parts]
        else:
            numbers = [measure(part, "length", si_size) for part in parts]
    if scene is not None:
        numbers = [options.asked(scene, name, number, "length") for number in numbers]
    if len(numbers) != count:
        raise SceneError(f"{options.option_name(name)} must {required}, got {shown(text)}.")
    return iter([checked_number(options.option_name(name), number) for number in numbers])
