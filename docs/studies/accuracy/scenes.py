"""Named scenes by both methods: docs/how_we_know.md, and the figures of docs/scenes.md.

``python -m docs.studies.accuracy.scenes --output docs`` writes the tables;
``python -m docs.studies.accuracy.scenes figures`` draws docs/figures/scene_NAME.png.
"""

from __future__ import annotations

import sys
from functools import cache
from io import BytesIO
from pathlib import Path

from matplotlib.figure import Figure
from PIL import Image

from compare.comparison.judgement import Judgement, judge
from compare.comparison.prediction import predict_like
from compare.comparison.rows import AGREES, DIFFERS, UNRESOLVED
from compare.figures.histories import comparison_figures
from compare.figures.style import look
from docs.studies.runner import Point, Row, Study, main, number
from semianalytic import find
from semianalytic.results.answer import method_of
from semianalytic.results.files import write_bytes
from semianalytic.scene.given.named import NAMED_SCENES

RESOLUTION = 100
"""Default resolution of `slipfront compare`."""

_ZONE = "zone 1, outer edge"
_TOTALS = "slip, L1; frictional work, L1"
_TWO_ZONES = f"{_ZONE}; zone 2, inner edge; zone 2, outer edge"
_REVERSING = "reverse slip, share of nodes and times; onset at 0.50 c_t T; accumulated |slip|, L1"
QUANTITIES = {
    "preloaded": f"{_TWO_ZONES}; frictional work, L1",
    "remote-shock": _TWO_ZONES,
    "auxetic": f"{_TWO_ZONES}; zone 3, inner edge; zone 3, outer edge; "
    "reverse slip, share of nodes and times; reversal at 0.75 c_t T",
    "ramp": "onset at 0.25 c_t T; onset at 0.50 c_t T; slip, L1",
    "unload": _REVERSING,
    "pulse": _REVERSING,
    "harmonic": "forward slip, share of nodes and times; reverse slip, part of map; "
    "work in cycle 1; work in cycle 2; work in cycle 3",
    "pressure-drop": f"zone 1, inner edge; {_ZONE}; onset at 0.75 c_t T; frictional work, L1",
    "viscous": f"{_ZONE}; {_TOTALS}",
    "antiplane": f"{_ZONE}; {_TOTALS}",
    "incident-p": f"opening 1, outer edge; {_ZONE}; slip, L1",
    "incident-sv": f"{_ZONE}; {_TOTALS}",
    "incident-pulse": "slip, L1; accumulated |slip|, L1; frictional work, L1",
    "moving-load": f"{_ZONE}; {_TOTALS}",
    "lift-off": "opening 1, outer edge; gap, L1",
    "lift-off-shear": f"opening 1, outer edge; {_TWO_ZONES}; frictional work, L1",
    "tap": "opening 1, inner edge; opening 1, outer edge; gap, L1",
}
"""Rows of the judgement of each scene that docs/how_we_know.md shows."""

TOTALS = ("slip", "accumulated |slip|", "frictional work", "shear traction", "pressure")
"""Rows of the summary in addition to the slip rate."""

FIGURES = {
    **dict.fromkeys(
        ("remote-shock", "stuck", "viscous", "antiplane", "lift-off-shear"), "interface"
    ),
    **dict.fromkeys(("auxetic", "ramp", "unload", "pulse", "harmonic", "pressure-drop"), "sense"),
    **dict.fromkeys(("lift-off", "tap"), "gap"),
}
"""Figure of `slipfront compare SCENE` that docs/scenes.md shows for each scene."""


@cache
def _judgement(scene: str, resolution: int) -> Judgement:
    from fem import simulate

    simulation = simulate(find(scene), resolution=resolution)
    return judge(predict_like(simulation), simulation)


def summary(scene: str, resolution: int) -> Row:
    """Return the judgement of a scene, and relative L1 differences between the two methods.

    `sense` is the share of the reached (x, t) area in which the sense of slip differs, `profile`
    the difference of slip rates, at T if the scene is self-similar and otherwise over space and
    time.  Both have an error bar; all are nan if nothing slips.
    """
    named, judgement = NAMED_SCENES[scene], _judgement(scene, resolution)
    rows, over_time = {row.name: row for row in judgement.rows}, "slip rate over (x, t), L1"

    def difference(name: str, what: str = "difference") -> float:
        return number(getattr(rows[name], what) if name in rows else None)

    profile = "slip rate, L1" if named.scene.is_self_similar else over_time
    sense = "other sense, share of nodes and times"
    return {
        "scene": scene,
        "summary": named.summary,
        "friction": named.scene.coefficient,
        "solver": method_of(judgement.prediction),
        "verdict": judgement.verdict,
        "agree": judgement.counts[AGREES],
        "unresolved": judgement.counts[UNRESOLVED],
        "differ": judgement.counts[DIFFERS],
        "profile": difference(profile),
        "profile_bar": difference(profile, "bar"),
        "sense": difference(sense),
        "sense_bar": difference(sense, "bar"),
        "slip_rate": difference(over_time),
        **{name.replace("|", "").replace(" ", "_"): difference(f"{name}, L1") for name in TOTALS},
    }


def quantities(scene: str, resolution: int) -> list[Row]:
    """Return the rows that docs/how_we_know.md shows; bars are in the unit of the values."""
    found: list[Row] = []
    if scene not in QUANTITIES:
        return found
    rows = {row.name: row for row in _judgement(scene, resolution).rows}
    for name in QUANTITIES[scene].split("; "):
        row = rows[name]
        exact, at_nodes, simulated = map(number, (row.exact, row.at_nodes, row.simulated))
        bar = number(row.bar) * (at_nodes if row.relative else 1.0)
        values: Row = {"exact": exact, "at_nodes": at_nodes, "simulated": simulated, "bar": bar}
        found.append({"scene": scene, "quantity": row.label, **values, "verdict": row.verdict})
    return found


def unresolved(scene: str, resolution: int) -> list[Row]:
    """Return the rows that the mesh does not resolve, why, and the resolution that would."""
    found: list[Row] = []
    for row in _judgement(scene, resolution).having(UNRESOLVED):
        needed = {"obstacle": row.obstacle, "resolution": number(row.resolution)}
        found.append({"scene": scene, "quantity": row.name, **needed})
    return found


def figure_png(figure: Figure, dpi: int = 100, colours: int = 64) -> bytes:
    """Return a figure as PNG with few colours, a third as large; rare colours are kept."""
    drawn, packed = BytesIO(), BytesIO()
    with look():
        figure.savefig(drawn, format="png", dpi=dpi)
    picture = Image.open(drawn).convert("RGB")
    few = picture.quantize(colours, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
    few.save(packed, format="png", optimize=True)
    return packed.getvalue()


def write_figures(folder: Path) -> None:
    """Write the figures of docs/scenes.md as scene_NAME.png; few colours keep them small."""
    for scene, name in FIGURES.items():
        case = _judgement(scene, RESOLUTION).case
        picture = figure_png(comparison_figures(case)[name](case))
        write_bytes(folder / f"scene_{scene}.png", picture)


def points(quick: bool) -> list[Point]:
    """Return all named scenes of a slot in one solid."""
    alike = (name for name, named in NAMED_SCENES.items() if named.scene.kind == "Scene")
    return [(name, 60 if quick else RESOLUTION) for name in alike]


STUDIES = [
    Study("scenes-summary", points, summary),
    Study("scenes-quantities", points, quantities),
    Study("scenes-unresolved", points, unresolved),
]

if __name__ == "__main__":
    if sys.argv[1:] == ["figures"]:
        write_figures(Path("docs", "figures"))
    else:
        raise SystemExit(main("docs.studies.accuracy.scenes", STUDIES))
