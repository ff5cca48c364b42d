"""Downloads of the page: figure, table, scene file, and a program."""

from __future__ import annotations

import io
from collections.abc import Callable, Mapping
from dataclasses import MISSING, fields
from typing import Any

from compare.output.tables import csv_text
from semianalytic import Scene
from semianalytic.methods import chosen
from semianalytic.results.datasets import QUANTITIES
from semianalytic.scene.given.template import scene_text
from semianalytic.scene.units import unit
from slipfront.explore.views import end_time, interface_view

Content = tuple[str, str, bytes]
"""Name of a file, its MIME type, and its content."""
_LONGEST_LINE = 60
"""Longest line of a program that the page shows without breaking it."""
_COLUMNS = {
    name: QUANTITIES[name][0] for name in ("slip_rate", "slip", "shear_traction", "pressure")
}


def figure_file(answer: Any, form: str) -> Content:
    """Return the matplotlib figure of an answer as svg, pdf or png."""
    from compare.figures.named import answer_figure

    drawn = io.BytesIO()
    answer_figure(answer).savefig(drawn, format=form, dpi=200)
    mime = {"svg": "image/svg+xml", "pdf": "application/pdf", "png": "image/png"}[form]
    return f"slipfront.{form}", mime, drawn.getvalue()


def table_file(answer: Any) -> Content:
    """Return slip rate, slip and tractions along the contact at T as CSV; line 1 has the units."""
    scene, time = answer.scene, end_time(answer.scene)
    x = interface_view(answer).x * scene.material.shear_speed * time
    columns = [x, *(getattr(answer, name)(x, time) for name in _COLUMNS)]
    units = [unit("length", scene.units), *(unit(kind, scene.units) for kind in _COLUMNS.values())]
    said = f"at t = {time!r} {unit('time', scene.units)}; {', '.join(units)}"
    rows = zip(*(column.tolist() for column in columns), strict=True)
    return "slipfront.csv", "text/csv", csv_text(["x", *_COLUMNS], rows, said).encode()


def program(scene: Scene) -> str:
    """Return a short Python program that reproduces the answer."""
    lines = ["import slipfront as sf", "", "scene = sf.Scene("]
    for field in fields(scene):
        made = None if field.default_factory is MISSING else field.default_factory()
        value = getattr(scene, field.name)
        if value != (made if field.default is MISSING else field.default):
            text = repr(value)
            # classes stand behind sf
            lines += _argument(field.name, f"sf.{text}" if text[0].isupper() else text)
    time = end_time(scene)
    if chosen(scene).name == "self-similar":
        lines += [")", "answer = sf.solve(scene)", "print(answer.zones, answer.openings)"]
    else:
        lines += [")", f"answer = sf.solve(scene, end_time={time!r})", "print(answer)"]
    lines += ["# at x, and t = T", f"print(answer.slip_rate([0.1, 0.5], {time!r}))"]
    return "\n".join(lines) + "\n"


def _argument(name: str, made: str) -> list[str]:
    """Return the lines of an argument of the scene; a long class is spread over several lines."""
    line, (head, _, rest) = f"    {name}={made},", made.partition("(")
    if len(line) <= _LONGEST_LINE or "(" in rest:
        return [line]
    parts = [f"        {part}," for part in rest.removesuffix(")").split(", ")]
    return [f"    {name}={head}(", *parts, "    ),"]


FILES: Mapping[str, Callable[[Any], Content]] = {
    "svg": lambda answer: figure_file(answer, "svg"),
    "pdf": lambda answer: figure_file(answer, "pdf"),
    "png": lambda answer: figure_file(answer, "png"),
    "csv": table_file,
    "toml": lambda answer: (
        "scene.toml",
        "application/toml",
        scene_text(answer.scene, "slipfront explore").encode(),
    ),
    "python": lambda answer: ("scene.py", "text/x-python", program(answer.scene).encode()),
}
"""The function behind each download button of the page."""
