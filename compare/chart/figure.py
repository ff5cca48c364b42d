"""Results of a chart as figure, table, sentences and JSON."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, astuple, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from compare.chart.methods import METHODS, find_problem
from compare.chart.points import FILE, Point, made_by
from compare.figures import style
from compare.figures.saving import save_figure
from compare.output.printed import PrintedTable
from compare.output.tables import write_rows

COLOURS = {"exact": style.PREDICTION, "march": style.MARCH, "fem": style.SIMULATION}
MARKERS = {"exact": "o", "march": "D", "fem": "^"}
FOUND_FILE = "data/chart-found.csv"


@dataclass(frozen=True)
class Found:
    """Results of one method on one scene; nan where its points do not determine them.

    Times are in seconds.  The slope is the power of time with which errors fall, by least squares
    over points that are worse than the reference is uncertain; their times differ by a factor of 3.
    """

    scene: str
    method: str
    cheapest: float
    cheapest_error: float
    least_error: float
    seconds_to_percent: float
    slope: float


def by_scene(points: Sequence[Point]) -> dict[str, dict[str, list[Point]]]:
    """Return points by the label of their scene and by their method."""
    scenes: dict[str, dict[str, list[Point]]] = {}
    for point in points:
        scenes.setdefault(point.key[0], {}).setdefault(point.method, []).append(point)
    return scenes


def slope(points: Sequence[Point]) -> float:
    """Return the `Found.slope` of points."""
    known = [point for point in points if point.error > point.reference_error]
    time, error = np.log([(point.seconds, point.error) for point in known] or [(1.0, 1.0)]).T
    if np.ptp(time) < math.log(3):
        return math.nan
    return float(np.polyfit(time - time.mean(), error, 1)[0])


def findings(points: Sequence[Point]) -> list[Found]:
    """Return what points say about each method on each scene."""
    found = []
    for label, methods in by_scene(points).items():
        for name, group in methods.items():
            known = [point for point in group if point.runs]
            good = [point.seconds for point in known if point.error <= 0.01]
            first = min(known, key=lambda point: point.seconds, default=group[0])
            least = min((point.error for point in known), default=math.nan)
            ends = first.seconds, first.error, least, min(good, default=math.nan)
            found.append(Found(label, METHODS[name].label, *ends, slope(known)))
    return found


def judged_by(points: Sequence[Point], label: str) -> str:
    """Say what the reference of a scene is, how uncertain, and which other method confirms it."""
    (point, *_), *_ = by_scene(points)[label].values()
    own = point.reference.partition(",")[0]
    others = [
        f"{found.method} to {found.least_error:.0e}"
        for found in findings(points)
        if found.scene == label and found.method != own and found.least_error < math.inf
    ]
    confirmed = f"agrees with {' and '.join(others)}" if others else "is compared with no other"
    return (
        f"Reference: {point.reference}, uncertain by {point.reference_error:.0e}; "
        f"it is one of the methods shown, and {confirmed}."
    )


@style.styled
def chart_figure(points: Sequence[Point], label: str) -> Figure:
    """Draw the error of each method on a scene against its computing time.

    Errors in the hatched band are smaller than the reference is certain, and are drawn no lower
    than a third of that.  Hollow points are of answers that call themselves inaccurate.
    """
    methods = by_scene(points)[label]
    (point, *_), *_ = methods.values()
    quantity, bar = point.quantity.replace("_", " "), point.reference_error
    figure = style.new_figure(7.2, 5.4)
    panel = figure.subplots()
    for name, group in methods.items():
        known, colour, marker = [p for p in group if p.runs], COLOURS[name], MARKERS[name]
        if not known:
            continue
        time, error = np.array([(p.seconds, max(p.error, bar / 3)) for p in known]).T
        good = np.array([p.status in ("converged", "resolved") for p in known])
        settings = METHODS[name].words.format(f"{known[0].setting:g} to {known[-1].setting:g}")
        words = f"{METHODS[name].label}, {settings}; slope {slope(known):.2g}"
        panel.plot(time, error, color=colour, marker=marker, mfc="none")
        words = words.removesuffix("; slope nan")
        panel.plot(time[good], error[good], marker, color=colour, label=words)
    panel.set(xscale="log", yscale="log", xlabel="processor time of one run [s]")
    panel.set_ylabel(f"relative $L_1$ error of the {quantity}")
    low = min(panel.get_ylim()[0], bar / 5)
    words, pale = "less than the reference is certain", style.ink(0.2)
    panel.axhspan(low, bar, fc="none", ec=pale, hatch="//", lw=0, zorder=0, label=words)
    panel.set_ylim(low)
    panel.grid(True, which="major", color=pale, linewidth=0.6)
    facts = f"{style.scene_words(find_problem(point.scene).scene)}\n{judged_by(points, label)}"
    panel.set_title(facts.replace("; ", ";\n"), size=style.SMALL, color=style.ink(0.75), wrap=True)
    figure.suptitle(f"{label}: error of the {quantity} against computing time")
    figure.legend(loc="outside lower left", frameon=False)
    return figure


def write_chart(
    directory: Path, points: Sequence[Point], labels: Sequence[str], form: str = "png"
) -> None:
    """Write what all points say as CSV, and the figures of the scenes with these labels."""
    write_rows(directory / FOUND_FILE, findings(points), command=made_by(directory / FILE))
    for label in labels:
        save_figure(chart_figure(points, label), directory / f"figures/chart_{label}.{form}")


def described(points: Sequence[Point]) -> Iterator[PrintedTable | str]:
    """Yield a table of what points say, and sentences on references and on refusals."""
    numbers = "cheapest [s]", "its error", "least error", "1 % in [s]", "slope"
    title = "Relative error against processor time"
    table = PrintedTable("scene", "method", numbers=numbers, title=title)
    for row in findings(points):
        words = [f"{number:.2g}" for number in astuple(row)[2:]]
        table.add_row(row.scene, row.method, *("—" if word == "nan" else word for word in words))
    yield table
    for label in by_scene(points):
        yield f"{label}. {judged_by(points, label)}"
        yield from dict.fromkeys(p.status for p in points if p.key[0] == label and not p.runs)


def chart_document(points: Sequence[Point]) -> dict[str, Any]:
    """Return all points and findings as plain dictionaries with units, for JSON."""
    return {
        "points": [asdict(point) for point in points],
        "found": [asdict(finding) for finding in findings(points)],
        "units": {
            "points": {"end_time": "time", "seconds": "s", "error": "1", "reference_error": "1"},
            "found": {"cheapest": "s", "seconds_to_percent": "s", "slope": "1"},
        },
    }
