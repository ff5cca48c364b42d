"""Run studies: points, rows, a table with the command that makes it, figures; resumed if stopped.

A script of docs/studies lists its studies and calls `main`::

    STUDIES = [Study("march-accuracy", points, row, figures={"march-accuracy": error_figure})]

    if __name__ == "__main__":
        raise SystemExit(main("docs.studies.march", STUDIES))

``python -m docs.studies.march march-accuracy --output docs`` then writes the table
docs/data/march-accuracy.csv and docs/figures/march-accuracy.png.  Finished rows are kept in
results/studies until ``--fresh``.
"""

from __future__ import annotations

import argparse
import csv
import io
import json
import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from rich.console import Console

from compare.figures.saving import save_figure
from compare.figures.style import cycle, describe, new_figure, styled
from compare.output.places import write_text
from compare.output.printed import PrintedTable
from compare.output.progress import progress_bar
from compare.tasks.workers import run_tasks

Row = dict[str, Any]
"""One line of a table: numbers, words and truth values by the names of the columns."""
Point = tuple[Any, ...]
"""Arguments of the function that computes rows: numbers, words, None, and lists of these."""

JOURNALS = Path("results", "studies")


@dataclass(frozen=True)
class Study:
    """One table and the figures drawn from its rows.

    name : str
        Name of the data file, such as "march-accuracy" for docs/data/march-accuracy.csv.
    points : callable
        Returns the points; its argument is whether a quick overview is asked for.
    row : callable
        Function of a module: ``row(*point)`` is a dictionary, a dataclass instance, or a list.
    table : callable, optional
        Returns the rows of the table, maybe none, from those of all points.
    figures : mapping, optional
        Functions of the rows of all points that draw figures, by the names of the files.
    """

    name: str
    points: Callable[[bool], Sequence[Point]]
    row: Callable[..., Any]
    table: Callable[[list[Row]], Sequence[Any]] = list
    figures: Mapping[str, Callable[[list[Row]], Figure]] = field(default_factory=dict)


def main(module: str, studies: Sequence[Study], arguments: Sequence[str] | None = None) -> int:
    """Run the studies that the command line of a module names, or all, and write their files."""
    known = {study.name: study for study in studies}
    parser = argparse.ArgumentParser(prog=f"python -m {module}")
    parser.add_argument("names", nargs="*", metavar="STUDY", help=", ".join(known))
    parser.add_argument("--quick", action="store_true", help="compute less, for a first look")
    parser.add_argument("--count", type=int, help="compute about so many points of each study")
    parser.add_argument("--output", type=Path, default=Path("results"), metavar="DIR")
    parser.add_argument("--fresh", action="store_true", help="compute finished rows again")
    parser.add_argument("--workers", type=int, default=1, help="number of processes")
    options = parser.parse_args(arguments)
    if unknown := set(options.names) - known.keys():
        parser.error(f"no study {', '.join(sorted(unknown))}; there are {', '.join(known)}")
    quick = " --quick" if options.quick else ""
    for name in options.names or known:
        journal = JOURNALS / f"{name}{quick.replace(' -', '')}.jsonl"
        if options.fresh:
            journal.unlink(missing_ok=True)
        rows = computed(known[name], options.quick, journal, options.workers, options.count)
        written(known[name], rows, options.output, f"{parser.prog} {name}{quick} --output docs")
    return 0


def computed(
    study: Study, quick: bool, journal: Path, workers: int = 1, count: int | None = None
) -> list[Row]:
    """Return the rows of all points, or of about so many from the first to the last, in order;
    those in the journal are not computed again."""
    chosen = study.points(quick)
    chosen = chosen[:: -(-len(chosen) // count)] if count else chosen
    points = {json.dumps(point): point for point in chosen}
    done: dict[str, list[Row]] = {}
    for line in journal.read_text().splitlines() if journal.exists() else ():
        with suppress(ValueError):  # a run that was killed may have left half a line
            done |= [json.loads(line)]
    missing = [key for key in points if key not in done]
    console = Console(stderr=True)
    if done.keys() & points.keys():
        console.print(f"{study.name}: {len(missing)} of {len(points)} points are not in {journal}")
    with progress_bar(console, False, study.name) as progress:
        tasks = [(study.row, points[key]) for key in missing]
        for index, found in run_tasks(tasks, workers, progress):
            rows = [as_row(entry) for entry in (found if isinstance(found, list) else [found])]
            done[missing[index]] = rows
            journal.parent.mkdir(parents=True, exist_ok=True)
            with journal.open("a", encoding="utf-8") as stream:  # killed, it may end in half a line
                stream.write(f"\n{json.dumps([missing[index], rows])}")
    return [row for key in points for row in done[key]]


def as_row(found: Any) -> Row:
    """Return a dictionary or a dataclass instance as a row of Python's own numbers."""
    row = found if isinstance(found, dict) else asdict(found)
    return {k: v.item() if isinstance(v, np.generic) else v for k, v in row.items()}


def number(value: float | None) -> float:
    """Return a value, or nan instead of None."""
    return math.nan if value is None else value


def grouped(rows: Sequence[Row], *names: str) -> list[tuple[Point, list[Row]]]:
    """Return rows by their values in some columns, in the order of the first row of each group."""
    groups: dict[Point, list[Row]] = {}
    for row in rows:
        groups.setdefault(tuple(row[name] for name in names), []).append(row)
    return list(groups.items())


def written(study: Study, rows: list[Row], output: Path, command: str) -> None:
    """Print and write the table of a study, and write its figures."""
    table = [as_row(row) for row in study.table(rows)]
    (output / "data").mkdir(parents=True, exist_ok=True)
    (output / "figures").mkdir(exist_ok=True)
    for name, draw in study.figures.items():
        save_figure(draw(rows), output / "figures" / f"{name}.png")
    if not table:
        return
    write_table(output / "data" / f"{study.name}.csv", table, command)
    shown = PrintedTable(*(name.replace("_", " ") for name in table[0]), title=study.name)
    for row in table[:60]:  # a map of ten thousand points is for the file
        shown.add_row(*(f"{v:.4g}" if isinstance(v, float) else str(v) for v in row.values()))
    Console(width=140).print(shown, f"{len(table)} rows written to {output}", highlight=False)


def write_table(path: Path, rows: Sequence[Row], command: str) -> None:
    """Write rows as CSV behind a line with the command that makes them."""
    stream = io.StringIO()
    writer = csv.DictWriter(stream, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    write_text(path, f"# {command}\n{stream.getvalue()}")


@styled
def drawn(rows: Sequence[Row], panels: Sequence[Row], words: str, **common: Any) -> Figure:
    """Draw panels, given by arguments of `draw`, "where" (values of columns), settings of axes, and
    by what they have in common."""
    panels = [common | panel for panel in panels]
    lines, columns = -(-len(panels) // 2), min(2, len(panels))
    figure = describe(new_figure(4.8 * columns, 3.6 * lines + 0.4), words)
    axes = figure.subplots(lines, columns, squeeze=False).ravel()
    for ax, panel in zip(axes, panels, strict=False):
        chosen = panel.get("where", {}).items()
        shown = [row for row in rows if all(row[name] == value for name, value in chosen)]
        own = {"x", "y", "by", "value", "label", "colours", "style", "failed", "marker"}
        draw(ax, shown, **{name: panel[name] for name in panel.keys() & own})
        ax.set(**{name: panel[name] for name in panel.keys() - own - {"where"}})
    for spare in axes[len(panels) :]:
        spare.remove()
    return figure


def draw(
    panel: Axes,
    rows: Sequence[Row],
    x: str,
    y: str,
    by: Sequence[str] = (),
    value: str = "",
    label: str = "",
    colours: Mapping[str, str] | None = None,
    style: Mapping[str, Any] | None = None,
    failed: Callable[[Row], bool] = lambda row: False,
    marker: str = ".-",
) -> None:
    """Draw column y of rows over column x: curves, one for each set of values of the columns `by`.

    With a `value`, draw a map with equally many rows for each x, coloured by the numbers in that
    column, labelled by `label`, or by its words with `colours`.  Rows that `failed` are crosses, at
    the bottom if nan.  A `style` is handed to matplotlib.
    """
    if value:
        ordered = sorted(rows, key=lambda row: (row[x], row[y]))
        shape, names = (len({row[x] for row in rows}), -1), list(colours or ())
        shades = [names.index(row[value]) if names else row[value] for row in ordered]
        places = (np.array([row[name] for row in ordered]).reshape(shape) for name in (x, y))
        given: dict[str, Any] = {"shading": "nearest", "rasterized": True, **(style or {})}
        if colours:
            given |= {"cmap": ListedColormap(list(colours.values()))}
            given |= {"vmin": -0.5, "vmax": len(names) - 0.5}
        mesh = panel.pcolormesh(*places, np.array(shades).reshape(shape), **given)
        if not colours:
            panel.figure.colorbar(mesh, ax=panel, label=label or value)
        return
    colour = cycle()
    for index, (key, own) in enumerate(grouped(rows, *by)):
        good = [row for row in own if not failed(row)]
        look: dict[str, Any] = {"color": colour[index % len(colour)], **(style or {})}
        line = [row[x] for row in good], [row[y] for row in good]
        panel.plot(*line, marker, label=", ".join(map(str, key)), **look)
        for row in filter(failed, own):
            bare = row[y] != row[y]
            place = {"transform": panel.get_xaxis_transform()} if bare else {}
            panel.plot([row[x]], [0.03 if bare else row[y]], "x", **look | place)
    if by:
        panel.legend()
