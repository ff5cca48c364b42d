"""Every figure that the package makes, drawn from cheap data: name -> function without arguments.

Names are those of modules of compare and their functions, and after a slash what is drawn.
"""

from __future__ import annotations

import contextlib
import importlib
import io
import tempfile
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path
from unittest.mock import patch

import numpy as np
from catalogue import solved
from compare_cases import sampled_run
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from compare.chart.figure import chart_figure
from compare.chart.points import read_points
from compare.comparison.fields.errors import field_errors
from compare.comparison.judgement import side_by_side
from compare.figures import histories, interface
from compare.figures.fields import FieldPicture, record_figure
from compare.figures.fronts import reach
from compare.figures.named import answer_figure
from compare.figures.quantities import find_quantity
from compare.figures.snapshots import snapshot_figure
from compare.output.field_files import record_fields
from compare.validation.figure import validation_figure
from compare.validation.validation import validate
from docs.examples.__main__ import EXAMPLES
from docs.studies.pages import DATA
from fem import simulate
from semianalytic import Gauge, find, fit, solve
from slipfront.fits.figures import fit_figure

SMALLER = {"survey_map": {"side": 12}}
"""What keeps an example short in a test and leaves what it prints."""


@cache
def _run(name):
    return sampled_run(solved(name), resolution=40, times=20)


@cache
def _case(name):
    return side_by_side(solved(name), _run(name))


@cache
def _marched(name):
    return solve(find(name), method="space-time", nodes=60)


def _of_case(name, scene):
    return histories.comparison_figures(_case(scene))[name](_case(scene))


def _of_run(draw, name):
    return draw(solved(name), _run(name).interface)


def _snapshots():
    with tempfile.TemporaryDirectory() as folder:
        scene = find("preloaded")
        run = simulate(scene, resolution=8, snapshots=Path(folder), frames=1)
        return snapshot_figure(field_errors(solved("preloaded"), run, Path(folder)), run)


def _field(name, of):
    solution = solved(name)
    quantity = find_quantity(of, solution.scene)
    return FieldPicture(solution, quantity, reach(solution, 1.0), 40, 1.0).figure


def _field_of_pair():
    answer = solve(find("pair-opening"))
    quantity = find_quantity("max-shear", answer.scene)
    return FieldPicture(answer, quantity, reach(answer, 1.0), 40, 1.0).figure


def _record():
    solution = solved("preloaded")
    record = record_fields(solution, 0.4, 0.2, np.linspace(0, 1, 30))
    return record_figure(record, solution.scene)


def _validation():
    solution, t = solved("preloaded"), np.linspace(0, 1, 41)
    x = np.array([0.1, 0.25, 0.5, 0.75, 0.95])
    seen = solution.history(x, t)
    names = ("slip_rate", "slip", "shear_traction", "pressure")
    data = {"t": t, "x": x, **{name: getattr(seen, name) for name in names}}
    return validation_figure(validate(data, solution.scene, spacing=0.02))


def _chart(name):
    return chart_figure(read_points(DATA / "chart.csv"), name)


@cache
def _example(name):
    """The figure that an example saves."""
    saved = []

    def keep(figure, path, **options):
        for line in (line for panel in figure.axes for line in panel.lines):
            line.set_color(to_hex(line.get_color()))  # "C0" is that of the style it is drawn in
        saved.append(figure)

    main = importlib.import_module(f"docs.examples.{name}").main
    with (
        tempfile.TemporaryDirectory() as folder,
        patch.object(Figure, "savefig", keep),
        contextlib.redirect_stdout(io.StringIO()),
    ):
        main(Path(folder), **SMALLER.get(name, {}))
    (figure,) = saved
    return figure


def _fit() -> Figure:
    """Friction and load from one record of slip rate."""
    solution, t = solved("preloaded"), np.linspace(0.3, 1.5, 24)
    gauge = Gauge(0.25, t, solution.slip_rate(0.25, t), 0.01)
    return fit_figure(fit([gauge], solution.scene, ("friction", "load_shear")))


CATALOGUE: dict[str, Callable[[], Figure]] = {
    **{
        f"compare.figures.histories.{name}_figure/{scene}": partial(_of_case, name, scene)
        for scene, names in (("auxetic", "sense history"), ("lift-off-shear", "sense gap"))
        for name in names.split()
    },
    **{
        f"compare.figures.interface.{draw.__name__}/{scene}": partial(_of_run, draw, scene)
        for draw in (
            interface.interface_figure,
            interface.fronts_figure,
        )
        for scene in ("auxetic", "lift-off-shear", "preloaded")
    },
    "compare.figures.named.answer_figure": lambda: answer_figure(_marched("unload")),
    **{
        f"compare.figures.named.answer_figure/{name}": lambda name=name: answer_figure(solved(name))
        for name in ("tap", "auxetic", "lift-off-shear")
    },
    "compare.figures.snapshots.snapshot_figure": _snapshots,
    "compare.figures.fields.record_figure": _record,
    **{
        f"compare.figures.fields.FieldPicture/{of} of {name}": partial(_field, name, of)
        for name, of in (("auxetic", "speed"), ("tap", "pressure"), ("antiplane", "fringes"))
    },
    "compare.figures.fields.FieldPicture/max-shear of a pair": _field_of_pair,
    "compare.validation.figure.validation_figure": _validation,
    "slipfront.fits.figures.fit_figure": _fit,
    **{
        f"compare.chart.figure.chart_figure/{name}": partial(_chart, name)
        for name in ("preloaded", "remote-shock", "auxetic", "ramp")
    },
    **{f"docs.examples.{name}.main": partial(_example, name) for name in EXAMPLES},
}
