"""Convergence of the fields in the bodies: the tables and the figure of docs/fem.md.

Run as ``python -m docs.studies.accuracy.fields convergence --csv docs/data`` or
``python -m docs.studies.accuracy.fields figure``.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from compare.comparison.fields.errors import FieldErrors, field_errors, fronts_in, pair_errors
from compare.figures.saving import save_figure
from compare.figures.snapshots import snapshot_figure
from compare.studies.tables import Study, run_studies
from fem import Simulation, simulate
from semianalytic import Scene, solve
from semianalytic.scene.given.named import NAMED_SCENES

SCENES = ("preloaded", "lift-off-shear")
RESOLUTIONS = (50, 100, 200)
DRAWN = "lift-off-shear"
AFAR = 0.1
"""Distance from all fronts [c_t T] that stays fixed when the mesh is refined."""


@dataclass(frozen=True)
class ConvergenceRow:
    """Relative L1 errors of one component at T on three meshes, each twice as fine as the last.

    Attributes
    ----------
    scene, component : str
    coarse, medium, fine : float
        Errors over both bodies.
    order : float
        Observed order of convergence between the last two meshes.
    coarse_outside, medium_outside, fine_outside, order_outside : float
        Errors and order outside a band of two elements around the fronts.
    coarse_afar, medium_afar, fine_afar, order_afar : float
        Errors and order farther than `AFAR` from all fronts.
    """

    scene: str
    component: str
    coarse: float
    medium: float
    fine: float
    order: float
    coarse_outside: float
    medium_outside: float
    fine_outside: float
    order_outside: float
    coarse_afar: float
    medium_afar: float
    fine_afar: float
    order_afar: float


def convergence(scenes: Sequence[str], resolutions: Sequence[int]) -> list[ConvergenceRow]:
    """Measure the errors of the scenes on three meshes."""
    return [row for name in scenes for row in _refined(name, NAMED_SCENES[name].scene, resolutions)]


def _refined(name: str, scene: Scene, resolutions: Sequence[int]) -> Iterator[ConvergenceRow]:
    for meshes in zip(*(_errors(scene, resolution) for resolution in resolutions), strict=True):
        component, parts = meshes[0][0], np.array([errors for _, *errors in meshes]).T
        values = [[*part, math.log2(part[1] / part[2])] for part in parts]
        yield ConvergenceRow(name, component, *np.ravel(values).tolist())


def _errors(scene: Scene, resolution: int) -> Iterator[tuple[str, float, float, float]]:
    """Yield each component with its errors: of the whole field, outside the band, and afar."""
    run, errors = last_frame(scene, resolution)
    fronts, width = fronts_in(solve(scene), scene), AFAR * scene.material.shear_speed * run.end_time
    for near, far in zip(
        errors.frames[-1], pair_errors(errors.last, fronts, run.end_time, width), strict=True
    ):
        yield near.component, near.whole, near.outside, far.outside


def last_frame(scene: Scene, resolution: int) -> tuple[Simulation, FieldErrors]:
    """Simulate a scene with one snapshot at its end; return the simulation and the errors."""
    with TemporaryDirectory() as folder:
        run = simulate(scene, resolution=resolution, snapshots=folder, frames=1)
        errors = field_errors(solve(scene), run, Path(folder))
    assert errors is not None  # a self-similar solution always has fields
    return run, errors


def write_figure(folder: Path) -> None:
    """Write the figure of docs/fem.md as fields_SCENE.png."""
    scene = NAMED_SCENES[DRAWN].scene
    run, errors = last_frame(scene, RESOLUTIONS[1])
    save_figure(snapshot_figure(errors, run), folder / f"fields_{DRAWN}.png")


STUDIES: dict[str, Study] = {"convergence": lambda: convergence(SCENES, RESOLUTIONS)}


def main(arguments: Sequence[str]) -> int:
    """Print or write rows, or draw the figure."""
    if list(arguments) == ["figure"]:
        write_figure(Path("docs", "figures"))
        return 0
    return run_studies("docs.studies.accuracy.fields", "fields", STUDIES, arguments)


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
