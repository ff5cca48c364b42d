"""When slip comes to points of the contact, and what happens there until a time: --x and --t."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.markup import escape

from compare.comparison.documents import POINT_DIMENSIONS, points_document, units_document
from compare.output.printed import PrintedTable
from semianalytic import SceneError
from semianalytic.results.answer import FIELDS
from semianalytic.scene.checks import shown
from semianalytic.scene.units import InSI, unit, with_unit
from slipfront.cli.options import option_name, read_number
from slipfront.cli.terminal import print_json

MOST = 1000
"""Largest number of pairs of a position and a time; more are a typing error."""
_ARRIVALS: Mapping[str, str] = {
    "slip": "slip begins",
    "forward": "forward slip begins",
    "reverse": "reverse slip begins",
    "opening": "it opens",
}
_DIGITS = 12
"""Most significant digits of a value: float64 has 16, and some go into rounding."""


@dataclass(frozen=True)
class AskedPoints:
    """Positions [length] and times [time] that were asked for, in the units of the scene.

    All pairs of them are answered, and arrivals alone if there is no time.
    """

    x: tuple[float, ...]
    t: tuple[float, ...]

    def end_time(self, scene: Any) -> float:
        """Return the time a march needs: the last one, or twice that of a shear wave to x."""
        return max(self.t, default=2 * max(self.x) / scene.material.shear_speed)

    def document(self, answer: Any) -> list[dict[str, Any]]:
        """Return what happens at the points as dictionaries, one for each pair."""
        x, t = np.meshgrid(self.x, self.t or (0.0,), indexing="ij")
        return points_document(answer.reading(x, t), at=bool(self.t))

    def shown_time(self, scene: Any) -> tuple[str, float]:
        """Return the unit in which times are shown, and its size: that of the first time given."""
        first = next(iter(self.t), None)
        if isinstance(first, InSI):
            return first.name, first.size
        return unit("time", scene.units), 1.0

    def with_units(self, document: dict[str, Any], answer: Any) -> dict[str, Any]:
        """Return the document of an answer with the points, and their units, added."""
        points = self.document(answer)
        units = units_document(points, POINT_DIMENSIONS, answer.scene)
        return {**document, "points": points, "units": {**document["units"], "points": units}}


def points_of(scene: Any, x: Sequence[str] | None, t: Sequence[str] | None) -> AskedPoints | None:
    """Return the points that --x and --t ask for, each text one or several numbers with units.

    A SceneError refuses a time without a position, numbers that are not positive, units of
    positions or of times alone, and too many points.
    """
    if not x:
        if t:
            raise SceneError("--t needs --x, the positions to print; give both.")
        return None
    points = AskedPoints(tuple(_numbers(scene, "x", x)), tuple(_numbers(scene, "t", t or ())))
    for asked, other in (("x", "t"), ("t", "x")):
        bare = [n for n in getattr(points, asked) if not isinstance(n, InSI)]
        if bare and any(isinstance(n, InSI) for n in getattr(points, other)):
            example = "5cm" if asked == "x" else "30us"
            raise SceneError(
                f"{option_name(asked)} {bare[0]:g} has no unit while {option_name(other)} has one; "
                f"write it as in {option_name(asked)} {example}."
            )
    if len(points.x) * max(len(points.t), 1) > MOST:
        raise SceneError(f"--x and --t make more than {MOST} points; give fewer.")
    return points


def _numbers(scene: Any, name: str, texts: Sequence[str]) -> Iterator[float]:
    dimension = "length" if name == "x" else "time"
    for text in (part for written_in in texts for part in written_in.split(",")):
        number = read_number(scene, name, text, dimension)
        if number <= 0 and not (name == "x" and scene.on_line):
            raise SceneError(
                f"{option_name(name)} must be positive: the contact is x > 0 and the load comes at "
                f"t = 0, got {shown(text)}."
            )
        yield number


def points_table(answer: Any, points: AskedPoints) -> PrintedTable:
    """Return a table of arrivals and fields at points, each with the bar of its error."""
    scene, title, numbers = answer.scene, "At points of the contact", ("value", "± error")
    table = PrintedTable("at", "quantity", numbers=numbers, title=title)
    table.add_column("unit")
    rows = points.document(answer)
    units = units_document(rows, POINT_DIMENSIONS, scene)
    times, size = points.shown_time(scene)
    # an answer that was sampled ends at some time, and does not know what comes later
    end = getattr(answer, "end_time", None)
    never = "never" if end is None else f"not until {end / size:.6g}"
    pairs = [(x, t) for x in points.x for t in points.t or (None,)]
    for point, (x, t) in zip(rows, pairs, strict=True):
        place = f"x = {_given(x, 'length', scene)}"
        if t in (None, points.t[:1] and points.t[0]):
            for name, words in _worth(point["arrivals"]):
                arrival = {key: number / size for key, number in point["arrivals"][name].items()}
                value, bar = written(**arrival, never=never)
                table.add_row(place, words, value, bar, times)
                place = ""
        place = "" if t is None else f"{place and f'{place}, '}t = {_given(t, 'time', scene)}"
        for name in FIELDS if t is not None else ():
            if name == "gap" and not point[name]["value"]:
                continue
            value, bar = written(**point[name])
            table.add_row(place, name.replace("_", " "), value, bar, escape(units[name]))
            place = ""
    return table


def show_answer(
    answer: Any,
    document: dict[str, Any],
    tables: Iterable[PrintedTable],
    points: AskedPoints | None,
    done: Mapping[str, Path | None],
    draw: Callable[[Any], Any] | None,
    *,
    as_json: bool,
) -> None:
    """Draw an answer if that is asked for, and print it: points first, then what was done where."""
    plot = done["Drawn"]
    if draw is not None and plot is not None:
        from compare.figures.saving import save_figure

        save_figure(draw(answer), plot)
    files = {word: path for word, path in done.items() if path is not None}
    if as_json:
        document = document if points is None else points.with_units(document, answer)
        print_json("solve", document, files=files.values())
        return
    for table in (*([] if points is None else [points_table(answer, points)]), *tables):
        Console().print(table)
    for word, path in files.items():
        Console().print(f"{word} in {path}", highlight=False)


def _worth(arrivals: Mapping[str, Mapping[str, float]]) -> list[tuple[str, str]]:
    """Return the arrivals to show: of either sense, then of one where both come, and openings."""
    comes = {name for name, arrival in arrivals.items() if math.isfinite(arrival["value"])}
    both = {"forward", "reverse"} <= comes
    first = {"forward", "reverse"} & comes if not both else set()
    words = dict(_ARRIVALS)
    if len(first) == 1:
        words["slip"] = words[first.pop()]
    shown_ = ["slip", *(("forward", "reverse") if both else ()), *({"opening"} & comes)]
    return [(name, words[name]) for name in shown_]


def written(value: float, error: float, never: str = "∞") -> tuple[str, str]:
    """Write a value to the digits that its error bar leaves, and the bar.

    An infinite value is `never`, and an infinite bar "unknown".
    """
    bar = "unknown" if math.isinf(error) else f"{error:.1e}" if error else "0"
    if math.isinf(value):
        return never, "" if not error else bar
    digits = 6
    if value and 0 < error < abs(value):
        digits = math.floor(math.log10(abs(value))) - math.floor(math.log10(error)) + 2
    elif error >= abs(value):
        digits = 2
    return f"{value:.{min(max(digits, 2), _DIGITS)}g}", bar


def _given(value: float, dimension: str, scene: Any) -> str:
    """Write a number in the unit that it was given in."""
    if isinstance(value, InSI):
        return f"{value / value.size:.6g} {value.name}"
    return with_unit(value, dimension, scene.units, 6)
