"""``slipfront compare``: both answers to a scene, side by side."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console

from compare.cli import terminal
from compare.cli.options import (
    MESH_OPTIONS,
    SCENE_OPTIONS,
    Method,
    NoSnapshots,
    Output,
    Quiet,
    option_name,
    with_options,
)
from compare.cli.simulate_command import simulate_into
from compare.cli.solve_command import check_converged
from compare.comparison.judgement import Judgement, judge
from compare.comparison.prediction import check_predictable, predict_like
from compare.comparison.report import write_report
from compare.comparison.rows import DIFFERS
from compare.comparison.snapshots import last_snapshot
from compare.output.leftovers import REPORT, SNAPSHOTS, forget_figures
from compare.output.places import working_folder
from compare.output.progress import progress_bar
from semianalytic import Solution
from semianalytic.scene.errors import SceneError
from semianalytic.scene.extras import FEM, PLOT, require
from semianalytic.scene.named import (
    DEFAULT_SCENE,
    find_scene,
    override_scene,
    scene_folder,
    scene_label,
)
from semianalytic.scene.scene import scene_document

if TYPE_CHECKING:
    from fem import Simulation


@with_options(overrides=SCENE_OPTIONS, settings=MESH_OPTIONS)
def compare_command(
    overrides: Mapping[str, float],
    settings: Mapping[str, Any],
    scene_name: Annotated[
        str | None,
        typer.Argument(
            metavar="[SCENE]",
            help=f"Name of a scene, or a TOML file; {DEFAULT_SCENE} unless given.",
        ),
    ] = None,
    from_: Annotated[
        Path | None,
        typer.Option(
            "--from", metavar="DIR", help="Folder of an earlier simulation to use instead."
        ),
    ] = None,
    method: Method = "auto",
    output: Output = None,
    no_snapshots: NoSnapshots = False,
    quiet: Quiet = False,
) -> None:
    """Solve and simulate a scene; write figures and a judgement on whether the two agree.

    The exit code is 0 if nothing differs by more than the error bars allow, what this mesh cannot
    resolve being listed; 1 if something does; 4 if the prediction has not converged.
    """
    require("slipfront compare", *FEM, *PLOT)
    earlier = None
    if from_ is not None:
        earlier = _earlier_simulation(from_, scene_name, overrides, settings)
        label = scene_label(scene_name) if scene_name else from_.resolve().name
        directory = output or from_
    else:
        scene_name = scene_name or DEFAULT_SCENE
        label = scene_label(scene_name)
        directory = output or scene_folder(scene_name, overrides)
        scene = override_scene(find_scene(scene_name), **overrides)
        check_predictable(scene, method)
    with working_folder(directory):
        simulation = earlier or simulate_into(
            directory, scene, label, settings, snapshots=not no_snapshots, quiet=quiet
        )
        snapshots = (from_ or directory) / SNAPSHOTS
        written = snapshots.is_dir() and not no_snapshots
        snapshot = last_snapshot(snapshots, simulation.run) if written else None
        with progress_bar(Console(stderr=True), quiet, "marching") as progress:
            prediction = predict_like(simulation, method, progress)
        judgement = judge(prediction, simulation, snapshot)
        write_comparison(judgement, label, directory)
    _show(judgement, label, directory)
    if isinstance(prediction, Solution):
        check_converged(prediction, label)
    raise typer.Exit(1 if judgement.verdict == DIFFERS else 0)


def write_comparison(judgement: Judgement, label: str, directory: Path) -> None:
    """Draw the figures of a judgement into a folder and write it there as JSON."""
    from compare.figures.histories import comparison_figures
    from compare.figures.saving import save_figure

    drawn = comparison_figures(judgement.case)
    for name, draw in drawn.items():
        save_figure(draw(judgement.case), directory / name)
    forget_figures(directory, drawn)
    write_report(judgement, label, directory / REPORT)


def _show(judgement: Judgement, label: str, directory: Path) -> None:
    console = Console()
    console.print(terminal.judgement_table(judgement, label))
    console.print(terminal.references_line(judgement), highlight=False)
    console.print(terminal.verdict_text(judgement), highlight=False)
    console.print(f"Written to {directory}/", highlight=False)


def _earlier_simulation(
    directory: Path,
    scene_name: str | None,
    overrides: Mapping[str, float],
    settings: Mapping[str, Any],
) -> Simulation:
    """Load a simulation; check that it is of the scene asked for, if one was."""
    from fem import load_simulation

    if settings:
        raise SceneError(
            f"{option_name(next(iter(settings)))} has no effect with --from; leave one of the two "
            "out."
        )
    simulation = load_simulation(directory)
    if simulation.lower_material is not None:
        raise SceneError(
            f"{directory} holds blocks of two materials, to which the theory does not apply "
            "(docs/limits.md)."
        )
    scene = override_scene(find_scene(scene_name) if scene_name else simulation.scene, **overrides)
    if scene != simulation.scene:
        raise SceneError(
            f"{directory} holds a simulation of another scene "
            f"({scene_document(simulation.scene)}); leave the scene out or simulate again."
        )
    return simulation
