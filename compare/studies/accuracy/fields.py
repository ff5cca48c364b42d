"""How fast the fields in the bodies converge: the tables and the figure of docs/fem.md.

``python -m compare.studies.accuracy.fields convergence --csv docs/data``
``python -m compare.studies.accuracy.fields figure``
"""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from compare.comparison.fields.errors import FieldErrors, field_errors
from compare.figures.saving import figure_png
from compare.figures.snapshots import snapshot_figure
from compare.studies.tables import Study, run_studies
from fem import Simulation, simulate
from semianalytic import Scene, solve
from semianalytic.results.files import write_bytes
from semianalytic.scene.named import NAMED_SCENES

SCENES = ("preloaded", "lift-off-shear")
RESOLUTIONS = (50, 100, 200)
DRAWN = "preloaded"


@dataclass(frozen=True)
class ConvergenceRow:
    """Relative L1 errors of one component at T on three meshes, each half as fine as the next.

    Attributes
    ----------
    scene, component : str
    coarse, medium, fine : float
        Over both bodies.
    order : float
        Of convergence between the last two.
    coarse_outside, medium_outside, fine_outside, order_outside : float
        The same outside the band around the fronts.
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


def convergence(scenes: Sequence[str], resolutions: Sequence[int]) -> list[ConvergenceRow]:
    """The scenes on three meshes."""
    return [row for name in scenes for row in _refined(name, NAMED_SCENES[name].scene, resolutions)]


def _refined(name: str, scene: Scene, resolutions: Sequence[int]) -> Iterator[ConvergenceRow]:
    runs = [last_frame(scene, resolution)[1].frames[-1] for resolution in resolutions]
    for of_meshes in zip(*runs, strict=True):
        coarse, medium, fine = of_meshes
        yield ConvergenceRow(
            name,
            fine.component,
            coarse.whole,
            medium.whole,
            fine.whole,
            math.log2(medium.whole / fine.whole),
            coarse.outside,
            medium.outside,
            fine.outside,
            math.log2(medium.outside / fine.outside),
        )


def last_frame(scene: Scene, resolution: int) -> tuple[Simulation, FieldErrors]:
    """A simulation with one snapshot, at its end, and how far that is off."""
    with TemporaryDirectory() as folder:
        run = simulate(scene, resolution=resolution, snapshots=folder, frames=1)
        errors = field_errors(solve(scene), run, Path(folder))
    assert errors is not None  # a solution knows its fields
    return run, errors


def write_figure(folder: Path) -> None:
    """Write the figure of docs/fem.md as fields_SCENE.png, in few colours to keep it small."""
    scene = NAMED_SCENES[DRAWN].scene
    run, errors = last_frame(scene, RESOLUTIONS[1])
    figure = snapshot_figure(errors, run)
    write_bytes(folder / f"fields_{DRAWN}.png", figure_png(figure, 100, 128))


STUDIES: dict[str, Study] = {"convergence": lambda: convergence(SCENES, RESOLUTIONS)}


def main(arguments: Sequence[str]) -> int:
    """Print or write rows, or draw the figure."""
    if list(arguments) == ["figure"]:
        write_figure(Path("docs", "figures"))
        return 0
    return run_studies("compare.studies.accuracy.fields", "fields", STUDIES, arguments)


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
