"""Named scenes by both methods: the numbers and figures of docs/scenes.md.

``python -m docs.studies.accuracy.scenes summary quantities unresolved --csv docs/data`` writes
the numbers; ``python -m docs.studies.accuracy.scenes figures`` draws
docs/figures/scene_NAME.png.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from compare.comparison.case import EDGE_CELLS, Case
from compare.comparison.judgement import Judgement, judge
from compare.comparison.prediction import method_of, predict_like
from compare.comparison.rows import AGREES, DIFFERS, UNRESOLVED, Row
from compare.figures.histories import comparison_figures
from compare.figures.saving import figure_png
from compare.studies.tables import Study, run_studies
from semianalytic import Solution
from semianalytic.results.files import write_bytes
from semianalytic.scene.given.named import NAMED_SCENES

RESOLUTION = 100
"""Default resolution of `slipfront compare`."""

QUANTITIES = {
    "preloaded": (
        ("slow zone, from the edge to [c_t]", "zone 1, outer edge"),
        ("second zone, from [c_t]", "zone 2, inner edge"),
        ("to [c_t]", "zone 2, outer edge"),
        ("frictional work, integral", "frictional work, L1"),
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
        ("reverse slip, part of the map", "reverse slip, part of map"),
        ("reversal at x = 0.75 c_t T [T]", "reversal at 0.75 c_t T"),
    ),
    "ramp": (
        ("onset at x = 0.25 c_t T [T]", "onset at 0.25 c_t T"),
        ("onset at x = 0.5 c_t T [T]", "onset at 0.50 c_t T"),
        ("slip at T, integral", "slip, L1"),
    ),
    "unload": (
        ("reverse slip, part of the map", "reverse slip, part of map"),
        ("onset at x = 0.5 c_t T [T]", "onset at 0.50 c_t T"),
        ("accumulated slip, integral", "accumulated |slip|, L1"),
    ),
    "pulse": (
        ("reverse slip, part of the map", "reverse slip, part of map"),
        ("onset at x = 0.5 c_t T [T]", "onset at 0.50 c_t T"),
        ("accumulated slip, integral", "accumulated |slip|, L1"),
    ),
    "harmonic": (
        ("forward slip, part of the map", "forward slip, part of map"),
        ("reverse slip, part of the map", "reverse slip, part of map"),
        ("frictional work in cycle 1", "work in cycle 1"),
        ("frictional work in cycle 2", "work in cycle 2"),
        ("frictional work in cycle 3", "work in cycle 3"),
    ),
    "pressure-drop": (
        ("zone, from [c_t]", "zone 1, inner edge"),
        ("to [c_t]", "zone 1, outer edge"),
        ("onset at x = 0.75 c_t T [T]", "onset at 0.75 c_t T"),
        ("frictional work, integral", "frictional work, L1"),
    ),
    "viscous": (
        ("zone, from the edge to [c_t]", "zone 1, outer edge"),
        ("slip at T, integral", "slip, L1"),
        ("frictional work, integral", "frictional work, L1"),
    ),
    "antiplane": (
        ("zone, from the edge to [c_t]", "zone 1, outer edge"),
        ("slip at T, integral", "slip, L1"),
        ("frictional work, integral", "frictional work, L1"),
    ),
    "incident-p": (
        ("open up to [c_t]", "opening 1, outer edge"),
        ("backward zone, to [c_t]", "zone 1, outer edge"),
        ("slip at T, integral", "slip, L1"),
    ),
    "incident-sv": (
        ("backward zone, from the edge to [c_t]", "zone 1, outer edge"),
        ("slip at T, integral", "slip, L1"),
        ("frictional work, integral", "frictional work, L1"),
    ),
    "incident-pulse": (
        ("slip at T, integral", "slip, L1"),
        ("accumulated slip, integral", "accumulated |slip|, L1"),
        ("frictional work, integral", "frictional work, L1"),
    ),
    "moving-load": (
        ("zone, from the edge to [c_t]", "zone 1, outer edge"),
        ("slip at T, integral", "slip, L1"),
        ("frictional work, integral", "frictional work, L1"),
    ),
    "lift-off": (
        ("open up to [c_t]", "opening 1, outer edge"),
        ("gap at T, integral", "gap, L1"),
    ),
    "lift-off-shear": (
        ("open up to [c_t]", "opening 1, outer edge"),
        ("slow zone, to [c_t]", "zone 1, outer edge"),
        ("second zone, from [c_t]", "zone 2, inner edge"),
        ("to [c_t]", "zone 2, outer edge"),
        ("frictional work, integral", "frictional work, L1"),
    ),
    "tap": (
        ("open from [c_t]", "opening 1, inner edge"),
        ("to [c_t]", "opening 1, outer edge"),
        ("gap at T, integral", "gap, L1"),
        ("largest gap", "largest gap"),
    ),
}
"""Quantities of each scene in docs/scenes.md: their names there, and in the judgement."""

COMPARED = tuple(NAMED_SCENES)
"""Scenes of the tables."""

FIGURES = {
    "remote-shock": "slip_rate",
    "stuck": "tractions",
    "auxetic": "sense",
    "ramp": "sense",
    "unload": "sense",
    "pulse": "sense",
    "harmonic": "sense",
    "pressure-drop": "sense",
    "viscous": "slip_rate",
    "antiplane": "slip_rate",
    "lift-off": "gap",
    "lift-off-shear": "slip_rate",
    "tap": "gap",
}
"""Figure of `slipfront compare SCENE` that docs/scenes.md shows for each scene."""


@dataclass(frozen=True)
class SummaryRow:
    """Judgement of a scene, and differences between the two methods.

    It holds the numbers of rows with each verdict, and relative L1 differences, nan if nothing
    slips.  `sense` is the share of the reached (x, t) area in which the sense of slip differs, and
    `sense_bar` its error bar.  `profile` is the difference of slip rates, at T if the scene is
    self-similar and otherwise over space and time, and `profile_bar` its error bar.
    """

    scene: str
    summary: str
    friction: float
    solver: str
    verdict: str
    agree: int
    unresolved: int
    differ: int
    profile: float
    profile_bar: float
    sense: float
    sense_bar: float
    slip_rate: float
    slip: float
    accumulated_slip: float
    frictional_work: float
    shear_traction: float
    pressure: float


@dataclass(frozen=True)
class QuantityRow:
    """One quantity of a scene, as in `Row`; values are nan where an answer has none.

    `bar` is in the unit of the values.  For quantities that are not judged, `bar` is nan and
    `verdict` empty.
    """

    scene: str
    quantity: str
    exact: float
    at_nodes: float
    simulated: float
    bar: float
    verdict: str


@dataclass(frozen=True)
class UnresolvedRow:
    """A quantity that the mesh does not resolve, the reason, and the resolution that would.

    `resolution` is in node distances per c_t T, nan if unknown.
    """

    scene: str
    quantity: str
    obstacle: str
    resolution: float


@cache
def _judgement(scene: str, resolution: int) -> Judgement:
    from fem import simulate

    simulation = simulate(NAMED_SCENES[scene].scene, resolution=resolution)
    return judge(predict_like(simulation), simulation)


def _rows(scene: str, resolution: int) -> dict[str, Row]:
    return {row.name: row for row in _judgement(scene, resolution).rows}


def summary(resolution: int = RESOLUTION) -> list[SummaryRow]:
    """Judge every scene that both methods answer."""
    return [_summary(scene, resolution) for scene in COMPARED]


def _summary(scene: str, resolution: int) -> SummaryRow:
    named, rows = NAMED_SCENES[scene], _rows(scene, resolution)
    judgement = _judgement(scene, resolution)
    counts = judgement.counts
    over_time = "slip rate over (x, t), L1"
    profile = "slip rate, L1" if named.scene.is_self_similar else over_time
    sense = "other sense, part of map"

    def difference(name: str) -> float:
        return _number(rows[name].difference if name in rows else None)

    def bar(name: str) -> float:
        return _number(rows[name].bar if name in rows else None)

    return SummaryRow(
        scene,
        named.summary,
        named.scene.friction,
        method_of(judgement.prediction),
        judgement.verdict,
        counts[AGREES],
        counts[UNRESOLVED],
        counts[DIFFERS],
        difference(profile),
        bar(profile),
        difference(sense),
        bar(sense),
        difference(over_time),
        difference("slip, L1"),
        difference("accumulated |slip|, L1"),
        difference("frictional work, L1"),
        difference("shear traction, L1"),
        difference("pressure, L1"),
    )


def quantities(resolution: int = RESOLUTION) -> list[QuantityRow]:
    """Return the quantities that docs/scenes.md names, scene by scene."""
    return [row for scene in QUANTITIES for row in _quantities(scene, resolution)]


def _quantities(scene: str, resolution: int) -> Iterator[QuantityRow]:
    judgement, rows = _judgement(scene, resolution), _rows(scene, resolution)
    if judgement.case.slips:
        predicted, simulated = largest_rates(judgement.case)
        if predicted > 0:
            rates = math.nan, predicted, simulated, math.nan
            yield QuantityRow(scene, "largest forward V", *rates, "")
    for name, quantity in QUANTITIES[scene]:
        row = rows[quantity]
        exact, at_nodes, simulated = map(_number, (row.exact, row.at_nodes, row.simulated))
        bar = _number(row.bar) * (at_nodes if row.relative else 1.0)
        yield QuantityRow(scene, name, exact, at_nodes, simulated, bar, row.verdict)


def unresolved(resolution: int = RESOLUTION) -> list[UnresolvedRow]:
    """Return all unresolved rows of all scenes."""
    return [
        UnresolvedRow(scene, row.name, row.obstacle, _number(row.resolution))
        for scene in COMPARED
        for row in _judgement(scene, resolution).having(UNRESOLVED)
    ]


def _number(value: float | None) -> float:
    """Return a value, or nan instead of None."""
    return math.nan if value is None else value


def largest_rates(case: Case) -> tuple[float, float]:
    """Return the largest forward slip rates four elements off the edge, at the nodes and simulated.

    They are taken at T if the scene is self-similar, otherwise over space and time from 0.2 T on.
    """
    seen = case.seen
    shown = seen.x > (EDGE_CELLS + 0.5) * case.simulation.element_size
    since = 1.0 if isinstance(case.prediction, Solution) else 0.2
    places = np.ix_(seen.t >= since * case.end_time, shown)
    return float(case.at_nodes.slip_rate[places].max()), float(seen.slip_rate[places].max())


def write_figures(folder: Path) -> None:
    """Write the figures of docs/scenes.md as scene_NAME.png; few colours keep them small."""
    for scene, name in FIGURES.items():
        case = _judgement(scene, RESOLUTION).case
        picture = figure_png(comparison_figures(case)[name](case), 100, 64)
        write_bytes(folder / f"scene_{scene}.png", picture)


STUDIES: dict[str, Study] = {
    "summary": summary,
    "quantities": quantities,
    "unresolved": unresolved,
}


def main(arguments: Sequence[str]) -> int:
    """Print or write rows, or draw the figures."""
    if list(arguments) == ["figures"]:
        write_figures(Path("docs", "figures"))
        return 0
    return run_studies("docs.studies.accuracy.scenes", "scenes", STUDIES, arguments)


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
