"""Accuracy of the finite elements for a contact that opens: the table of docs/fem.md.

Run as ``python -m docs.studies.accuracy.openings meshes --csv docs/data``.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from compare.comparison.judgement import side_by_side
from compare.comparison.quantities.edge_rows import opening_rows
from compare.comparison.quantities.profile_rows import gap_rows
from compare.comparison.rows import Row
from compare.studies.tables import Study, run_studies
from fem import simulate
from semianalytic import Scene, solve
from semianalytic.scene.given.named import NAMED_SCENES

SCENES = ("lift-off", "lift-off-shear", "tap")
RESOLUTIONS = (50, 100, 200)


@dataclass(frozen=True)
class MeshRow:
    """Ends of the opening over c_t, by the rules of the judge, and errors of gap and pressure.

    Attributes
    ----------
    scene, h : str
    inner, outer : float
        Ends in the simulation; nan if there is no such end.
    exact_inner, exact_outer : float
        Ends in the exact answer.
    gap : float
        Relative L1 error of the gap at T.
    order : float
        Observed order of that error since the mesh before; nan for the first mesh.
    largest : float
        Relative error of the largest gap.
    """

    scene: str
    h: str
    inner: float
    exact_inner: float
    outer: float
    exact_outer: float
    gap: float
    order: float
    largest: float


def mesh_rows(scenes: Sequence[str], resolutions: Sequence[int]) -> list[MeshRow]:
    """Measure the scenes on meshes of increasing resolution."""
    return [row for name in scenes for row in _refined(name, NAMED_SCENES[name].scene, resolutions)]


def _refined(name: str, scene: Scene, resolutions: Sequence[int]) -> Iterator[MeshRow]:
    exact, last, coarser = solve(scene), math.nan, 0
    for resolution in resolutions:
        case = side_by_side(exact, simulate(scene, resolution=resolution))
        rows = {row.name: row for row in (*opening_rows(case), *gap_rows(case))}
        inner, outer = (rows.get(f"opening 1, {end} edge") for end in ("inner", "outer"))
        gap, largest = rows["gap, L1"].difference or 0.0, rows["largest gap"]
        assert largest.difference is not None
        assert largest.at_nodes is not None
        yield MeshRow(
            name,
            f"1/{resolution}",
            _value(inner, "simulated"),
            _value(inner, "exact"),
            _value(outer, "simulated"),
            _value(outer, "exact"),
            gap,
            math.log(last / gap) / math.log(resolution / coarser) if coarser else math.nan,
            largest.difference / largest.at_nodes,
        )
        last, coarser = gap, resolution


def _value(row: Row | None, name: str) -> float:
    value = None if row is None else getattr(row, name)
    return math.nan if value is None else float(value)


STUDIES: dict[str, Study] = {"meshes": lambda: mesh_rows(SCENES, RESOLUTIONS)}

if __name__ == "__main__":
    raise SystemExit(run_studies("docs.studies.accuracy.openings", "opening", STUDIES))
