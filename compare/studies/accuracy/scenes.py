"""The named scenes by both methods: the numbers and figures of docs/scenes.md.

``python -m compare.studies.accuracy.scenes summary quantities --csv docs/data`` writes the numbers,
``python -m compare.studies.accuracy.scenes figures`` draws docs/figures/scene_NAME.png.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from compare.comparison.prediction import prediction_at_nodes
from compare.comparison.report import Report, build_report
from compare.comparison.rows import EDGE_CELLS, Row
from compare.figures.histories import comparison_figures
from compare.figures.saving import figure_png
from compare.studies.tables import Study, run_studies
from semianalytic.results.files import write_bytes
from semianalytic.scene.named import NAMED_SCENES

RESOLUTION = 100
"""That of `slipfront compare` unless another is given."""

QUANTITIES = {
    "preloaded": (
        ("slow zone, from the edge to [c_t]", "zone 1, outer edge"),
        ("second zone, from [c_t]", "zone 2, inner edge"),
        ("to [c_t]", "zone 2, outer edge"),
        ("frictional work, integral", "frictional work in L1"),
    ),
    "remote-shock": (
        ("slow zone, from the edge to [c_t]", "zone 1, outer edge"),
        ("second zone, from [c_t]", "zone 2, inner edge"),
        ("to [c_t]", "zone 2, outer edge"),
    ),
    "auxetic": (
        ("slow zone, from the edge to [c_t]", "zone 1, outer edge"),
        ("reversed zone, from [c_t]", "zone 2, inner edge"),
        ("to [c_t]", "zone 2, outer edge"),
        ("fast zone, from [c_t]", "zone 3, inner edge"),
        ("to [c_t]", "zone 3, outer edge"),
        ("reverse slip, part of the map", "reverse slip, part of the map"),
        ("reversal at x = 0.75 c_t T [T]", "slip reversal at x = 0.75 c_t T"),
    ),
    "ramp": (
        ("onset at x = 0.25 c_t T [T]", "slip onset (1 % of peak) at x = 0.25 c_t T"),
        ("onset at x = 0.5 c_t T [T]", "slip onset (1 % of peak) at x = 0.50 c_t T"),
        ("slip at T, integral", "slip at the end in L1"),
    ),
    "unload": (
        ("reverse slip, part of the map", "reverse slip, part of the map"),
        ("onset at x = 0.5 c_t T [T]", "slip onset (1 % of peak) at x = 0.50 c_t T"),
        ("accumulated slip, integral", "accumulated |slip| in L1"),
    ),
    "pulse": (
        ("reverse slip, part of the map", "reverse slip, part of the map"),
        ("onset at x = 0.5 c_t T [T]", "slip onset (1 % of peak) at x = 0.50 c_t T"),
        ("accumulated slip, integral", "accumulated |slip| in L1"),
    ),
    "harmonic": (
        ("forward slip, part of the map", "forward slip, part of the map"),
        ("reverse slip, part of the map", "reverse slip, part of the map"),
        ("frictional work in cycle 1", "frictional work in cycle 1"),
        ("frictional work in cycle 2", "frictional work in cycle 2"),
        ("frictional work in cycle 3", "frictional work in cycle 3"),
    ),
    "pressure-drop": (
        ("zone, from [c_t]", "zone 1, inner edge"),
        ("to [c_t]", "zone 1, outer edge"),
        ("onset at x = 0.5 c_t T [T]", "first slip (1e-6 V₀) at x = 0.50 c_t T"),
        ("frictional work, integral", "frictional work in L1"),
    ),
}
"""What docs/scenes.md says of a scene: how it is called there, and in the report."""

COMPARED = tuple(name for name in NAMED_SCENES if name != "lift-off")
"""Of `lift-off` nothing is predicted."""

FIGURES = {
    "remote-shock": "slip_rate.png",
    "stuck": "tractions.png",
    "auxetic": "sense.png",
    "ramp": "sense.png",
    "unload": "sense.png",
    "pulse": "sense.png",
    "harmonic": "sense.png",
    "pressure-drop": "sense.png",
}
"""Which figure of `slipfront compare SCENE` docs/scenes.md shows."""


@dataclass(frozen=True)
class SummaryRow:
    """How far both methods are apart on a scene.

    Relative L1 differences but `sense`, the part of the reached (x, t) area in which the sense of
    slip differs, and `sense_bound`, the most that it may be; nan where nothing slips.  `profile`
    is the slip rate at T where the scene is self-similar, over space and time otherwise.
    """

    scene: str
    summary: str
    friction: float
    solver: str
    profile: float
    sense: float
    sense_bound: float
    slip_rate: float
    slip: float
    accumulated_slip: float
    frictional_work: float
    shear_traction: float
    pressure: float


@dataclass(frozen=True)
class QuantityRow:
    """One quantity of a scene by both methods, nan where one of them has none."""

    scene: str
    quantity: str
    prediction: float
    simulation: float


@cache
def _report(scene: str, resolution: int) -> Report:
    from fem import simulate

    simulation = simulate(NAMED_SCENES[scene].scene, resolution=resolution)
    return build_report(scene, prediction_at_nodes(simulation), simulation)


def _rows(scene: str, resolution: int) -> dict[str, Row]:
    return {row.quantity: row for row in _report(scene, resolution).rows}


def summary(resolution: int = RESOLUTION) -> list[SummaryRow]:
    """Every scene that both methods answer."""
    return [_summary(scene, resolution) for scene in COMPARED]


def _summary(scene: str, resolution: int) -> SummaryRow:
    named, rows = NAMED_SCENES[scene], _rows(scene, resolution)
    over_time = "slip rate over space and time in L1"
    sense = rows.get("sense of slip, part of the map that differs")

    def difference(quantity: str) -> float:
        row = rows.get(quantity)
        return math.nan if row is None or row.difference is None else row.difference

    return SummaryRow(
        scene,
        named.summary,
        named.scene.friction,
        _report(scene, resolution).prediction.method,
        difference("slip rate in L1" if named.scene.is_self_similar else over_time),
        difference("sense of slip, part of the map that differs"),
        math.nan if sense is None else sense.tolerance,
        difference(over_time),
        difference("slip at the end in L1"),
        difference("accumulated |slip| in L1"),
        difference("frictional work in L1"),
        difference("shear traction in L1"),
        difference("pressure in L1"),
    )


def quantities(resolution: int = RESOLUTION) -> list[QuantityRow]:
    """What docs/scenes.md says of the scenes, one by one."""
    return [row for scene in QUANTITIES for row in _quantities(scene, resolution)]


def _quantities(scene: str, resolution: int) -> Iterator[QuantityRow]:
    rows = _rows(scene, resolution)
    yield QuantityRow(scene, "largest forward V", *largest_rates(_report(scene, resolution)))
    for name, quantity in QUANTITIES[scene]:
        row = rows[quantity]
        values = (row.prediction, row.simulation)
        yield QuantityRow(scene, name, *(math.nan if v is None else float(v) for v in values))


def largest_rates(report: Report) -> tuple[float, float]:
    """Largest forward slip rate, four elements off the edge, predicted and simulated.

    At T where x/t is all that counts, over space and time from 0.2 T on otherwise.
    """
    predicted, seen = report.prediction.interface, report.simulation.interface
    shown = seen.x > (EDGE_CELLS + 0.5) * report.simulation.element_size
    since = 0.2 if report.prediction.solution is None else 1.0
    places = np.ix_(seen.t >= since * seen.t[-1], shown)
    return float(predicted.slip_rate[places].max()), float(seen.slip_rate[places].max())


def write_figures(folder: Path) -> None:
    """Write the figures of docs/scenes.md as scene_NAME.png, in few colours to keep them small."""
    for scene, name in FIGURES.items():
        report = _report(scene, RESOLUTION)
        picture = figure_png(comparison_figures(report)[name](report), 100, 64)
        write_bytes(folder / f"scene_{scene}.png", picture)


STUDIES: dict[str, Study] = {"summary": summary, "quantities": quantities}


def main(arguments: Sequence[str]) -> int:
    """Print or write rows, or draw the figures."""
    if list(arguments) == ["figures"]:
        write_figures(Path("docs", "figures"))
        return 0
    return run_studies("compare.studies.accuracy.scenes", "scenes", STUDIES, arguments)


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
