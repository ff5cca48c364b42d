"""The command ``slipfront``: solve a scene, simulate it, compare the two."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping, Sequence
from io import TextIOWrapper
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console

from compare.cli import study_commands as studies
from compare.cli import terminal
from compare.cli.interruption import INTERRUPTED, INTERRUPTION
from compare.cli.options import (
    CHECKPOINT_OPTIONS,
    MARCH_OPTIONS,
    MESH_OPTIONS,
    SCENE_OPTIONS,
    with_options,
)
from compare.comparison.predictions import check_predictable, predict
from compare.comparison.report import (
    Report,
    build_report,
    json_text,
    march_document,
    solution_document,
    write_report,
)
from compare.comparison.snapshots import last_snapshot
from compare.output.leftovers import forget_figures, forget_other_runs
from compare.output.places import check_file, save_somewhere, working_folder
from compare.output.progress import progress_bar
from semianalytic import Marched, Scene, Solution, march, march_on, solve
from semianalytic.prediction import chosen_method
from semianalytic.results.interruption import deferred_interrupt
from semianalytic.results.memory import GIGABYTE
from semianalytic.scene.errors import ComputationError, DataFileError, SceneError, SlipfrontError
from semianalytic.scene.extras import FEM, HDF5, PLOT, needing, require
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

SNAPSHOTS = "snapshots"
CHECKPOINT = "checkpoint.h5"
WORTH_SAYING = 60.0
"""Predicted time of a simulation from which on it is said before it starts [s]."""

app = typer.Typer(
    help="Where, when, how fast and which way a frictional interface slips after a sudden load.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)

SceneArgument = Annotated[
    str, typer.Argument(metavar="SCENE", help="Name of a scene, or a TOML file.")
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Show results only, no progress.")]
NoSnapshots = Annotated[bool, typer.Option("--no-snapshots", help="Write no field snapshots.")]
Output = Annotated[
    Path | None,
    typer.Option(
        metavar="DIR",
        help="Folder to write to; results/SCENE unless given, as in results/SCENE-friction-0.2.",
    ),
]
Method = Annotated[
    str, typer.Option(help="self-similar, space-time, or auto: the one the scene calls for.")
]


@app.command()
@with_options(overrides=SCENE_OPTIONS, settings=MESH_OPTIONS)
def compare(
    overrides: Mapping[str, float],
    settings: Mapping[str, Any],
    scene: Annotated[
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
    """Solve and simulate a scene; write figures and a report on how well the two agree.

    The exit code is 0 if every quantity is within its tolerance, 1 if one is not, and 4 if the
    prediction has not converged.
    """
    require("slipfront compare", *FEM, *PLOT)
    if from_ is None:
        source = scene or DEFAULT_SCENE
        label = scene_label(source)
        directory = output or scene_folder(source, overrides)
        wanted = override_scene(find_scene(source), **overrides)
        check_predictable(wanted, method)
    else:
        simulation = _earlier_simulation(from_, scene, overrides, settings)
        directory = output or from_
        label = scene_label(scene) if scene else from_.resolve().name
    with working_folder(directory):
        if from_ is None:
            simulation = _simulate(
                wanted, label, directory, settings, no_snapshots=no_snapshots, quiet=quiet
            )
        snapshots = (from_ or directory) / SNAPSHOTS
        written = snapshots.is_dir() and not no_snapshots
        snapshot = last_snapshot(snapshots, simulation.run) if written else None
        with progress_bar(Console(stderr=True), quiet, "marching") as progress:
            prediction = predict(simulation, method, progress)
        report = build_report(label, prediction, simulation, snapshot)
        _write_comparison(report, directory)
    console = Console()
    console.print(terminal.report_table(report))
    console.print("Tolerances:\n" + terminal.reasons_text(report), highlight=False)
    console.print(f"Written to {directory}/", highlight=False)
    if prediction.solution is not None:
        _check_converged(prediction.solution, label)
    raise typer.Exit(0 if report.passed else 1)


@app.command("solve")
@with_options(overrides=SCENE_OPTIONS, march=MARCH_OPTIONS)
def solve_command(
    overrides: Mapping[str, float],
    march: Mapping[str, Any],
    scene: SceneArgument,
    method: Method = "auto",
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON and nothing else.")] = False,
    plot: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Draw slip rate and tractions (.png, .pdf).")
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Solve a scene: zones and edge velocities, or what happens until an end time.

    Step loads are self-similar and solved exactly; other load histories are marched in time.  The
    exit code is 4 if the solution has not converged; the best answer is printed all the same.
    """
    wanted = override_scene(find_scene(scene), **overrides)
    if plot is not None:
        require("slipfront solve --plot", *PLOT)
        from compare.figures.saving import figure_format

        figure_format(plot)
        check_file(plot)
    if chosen_method(wanted, method) == "space-time":
        _march(wanted, scene_label(scene), march, as_json=as_json, plot=plot, quiet=quiet)
        return
    if march:
        raise SceneError(
            f"{_first_of(march)} is for the space-time solver; add --method space-time."
        )
    solution = solve(wanted)
    if plot is not None:
        from compare.figures.interface import prediction_figure
        from compare.figures.saving import save_figure

        save_figure(prediction_figure(solution), plot)
    if as_json:
        sys.stdout.write(json_text(solution_document(solution)))
    else:
        console = Console()
        console.print(terminal.zones_table(solution, title=scene_label(scene)))
        console.print(terminal.facts_table(solution))
        if plot is not None:
            console.print(f"Drawn in {plot}", highlight=False)
    _check_converged(solution, scene_label(scene))


@app.command()
@with_options(overrides=SCENE_OPTIONS, settings=MESH_OPTIONS, checkpoints=CHECKPOINT_OPTIONS)
def simulate(
    overrides: Mapping[str, float],
    settings: Mapping[str, Any],
    checkpoints: Mapping[str, Any],
    scene: SceneArgument,
    output: Output = None,
    no_snapshots: NoSnapshots = False,
    quiet: Quiet = False,
) -> None:
    """Simulate a scene with finite elements; write the interface history and field snapshots.

    With --checkpoint-every or --checkpoint-seconds a run that is interrupted or killed can be taken
    up again with the same options and --resume; the result is the same to the last bit.  A finished
    run removes its checkpoint.
    """
    require("slipfront simulate", *FEM)
    label = scene_label(scene)
    directory = output or scene_folder(scene, overrides)
    wanted = override_scene(find_scene(scene), **overrides)
    with working_folder(directory):
        _simulate(
            wanted,
            label,
            directory,
            settings,
            no_snapshots=no_snapshots,
            quiet=quiet,
            **checkpoints,
        )
    Console().print(f"Written to {directory}/", highlight=False)


@app.command()
def scenes() -> None:
    """List the scenes that come with the package."""
    Console().print(terminal.scenes_table())


for study in (
    studies.regimes,
    studies.stability,
    studies.article,
    studies.chart,
    studies.wear,
    studies.evidence,
):
    app.command()(study)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code.

    Parameters
    ----------
    arguments : sequence of str, optional
        What follows ``slipfront``; taken from the process if not given.

    Returns
    -------
    int
        0 if all went well, 1 if a comparison is outside its tolerance, 2 for a usage or scene
        error, 3 for a damaged file, 4 for a failed computation, 5 for a missing library, 130
        when interrupted (the program itself returns 143 if that was by SIGTERM).
    """
    _make_streams_lenient()
    os.environ["MPLBACKEND"] = "agg"  # figures go to files; no other backend need exist
    try:
        with needing("This command"):
            app(args=arguments, prog_name="slipfront")
    except SlipfrontError as error:
        print(_printed(error), file=sys.stderr)
        return error.exit_code
    except OSError as error:
        reason = f"Cannot use {error.filename or 'a file'}: {error.strerror or error}."
        print(_printed(reason), file=sys.stderr)
        return DataFileError.exit_code
    except SystemExit as end:
        if end.code == INTERRUPTED:
            print(INTERRUPTION, file=sys.stderr)
        return int(end.code or 0)
    return 0


def _check_converged(solution: Solution, label: str) -> None:
    """Raise ComputationError, when all is shown, unless a solution has converged."""
    if solution.status != "converged":
        raise ComputationError(
            f"{label} has not converged: {solution.status}; do not rely on this answer, "
            "change friction a little or simulate the scene."
        )


def _printed(message: object) -> str:
    """A message on one line that a terminal shows as it is, whatever names it quotes."""
    return "".join(c if c.isprintable() else ascii(c)[1:-1] for c in str(message))


def _make_streams_lenient() -> None:
    """Characters that a terminal cannot show are replaced instead of refused."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper) and stream.errors == "strict":
            stream.reconfigure(errors="replace")


def _first_of(options: Mapping[str, Any]) -> str:
    """An option as it was typed."""
    return "--" + next(iter(options)).replace("_", "-")


def _simulate(
    scene: Scene,
    label: str,
    directory: Path,
    settings: Mapping[str, Any],
    *,
    no_snapshots: bool,
    quiet: bool,
    checkpoint_every: int = 0,
    checkpoint_seconds: float | None = None,
    resume: bool = False,
) -> Simulation:
    """Run the finite-element model and keep its history, and snapshots if wanted, on disk."""
    from fem import cost
    from fem import simulate as run_simulation
    from fem.checkpoint import forget_checkpoint
    from fem.room import check_room

    settings = dict(settings)
    memory = settings.pop("memory", None)
    limit = None if memory is None else memory * GIGABYTE
    predicted = cost(
        scene,
        **settings,
        snapshots=not no_snapshots,
        checkpoint=bool(checkpoint_every or checkpoint_seconds is not None or resume),
        memory=limit,
    )
    check_room(directory / "simulation.h5", predicted.history, "simulate: the histories")
    path = directory / CHECKPOINT
    if checkpoint_every or checkpoint_seconds is not None or resume:
        settings = {
            **settings,
            "checkpoint": path,
            "checkpoint_every": checkpoint_every or None,
            "checkpoint_seconds": checkpoint_seconds,
            "resume": resume,
        }

    console = Console(stderr=True)
    if not quiet and predicted.seconds > WORTH_SAYING:
        console.print(f"{label}: {predicted}.", highlight=False, soft_wrap=True)
    with progress_bar(console, quiet) as progress:
        simulation = run_simulation(
            scene,
            **settings,
            snapshots=None if no_snapshots else directory / SNAPSHOTS,
            progress=progress,
            memory=limit,
            tell=lambda sentence: console.print(sentence, highlight=False, soft_wrap=True),
        )
    save_somewhere(simulation.save, directory)
    forget_other_runs(directory, simulation.run)
    forget_checkpoint(path, simulation.run)
    if not quiet:
        console.print(f"{label}: {terminal.simulation_line(simulation)}", highlight=False)
    if simulation.unwritten:
        raise DataFileError(f"{simulation.unwritten} The histories are in {directory}.")
    return simulation


def _march(
    scene: Scene,
    label: str,
    options: Mapping[str, Any],
    *,
    as_json: bool,
    plot: Path | None,
    quiet: bool,
) -> None:
    """March a scene, or go on with a saved march, and say what happened."""
    options = dict(options)
    save, earlier = options.pop("save", None), options.pop("go_on", None)
    if save is not None or earlier is not None:
        require("a saved march", *HDF5)
    if save is not None:
        check_file(save)
    memory = options.pop("memory", None)
    memory = None if memory is None else memory * GIGABYTE
    console = Console(stderr=True)
    bar = progress_bar(console, quiet or as_json, "marching")
    with bar as show, deferred_interrupt() as interruption:

        def progress(done: int, steps: int) -> bool:
            show(done, steps)
            return interruption.pressed

        if earlier is None:
            marched = march(scene, **options, memory=memory, progress=progress)
        else:
            saved = Marched.load(earlier)
            if saved.scene != scene:
                raise SceneError(f"{earlier} holds a march of another scene; give that scene.")
            end_time = options.pop("end_time", saved.latest)
            if options:
                raise SceneError(
                    f"{_first_of(options)} has no effect with --go-on; leave one of the two out."
                )
            marched = march_on(saved, end_time, progress, memory=memory)
    if save is not None:
        save_somewhere(marched.save, save, save.name)
    if interruption.pressed:
        if save is not None:
            console.print(
                f"{save} holds the march until t = {marched.end_time:.6g}.", highlight=False
            )
        raise typer.Exit(INTERRUPTED)
    wanted = options.get("every", 1) if earlier is None else saved.every
    if marched.every > wanted and not quiet:
        console.print(
            f"Every {marched.every}th level is stored: more would not have fitted into the memory.",
            highlight=False,
        )
    if plot is not None:
        from compare.figures.histories import march_figure
        from compare.figures.saving import save_figure

        save_figure(march_figure(marched), plot)
    if as_json:
        sys.stdout.write(json_text(march_document(marched)))
        return
    Console().print(terminal.march_table(marched, label))
    for done, path in (("Saved", save), ("Drawn", plot)):
        if path is not None:
            Console().print(f"{done} in {path}", highlight=False)


def _earlier_simulation(
    directory: Path, source: str | None, overrides: Mapping[str, float], settings: Mapping[str, Any]
) -> Simulation:
    """Load a simulation; check that it is of the scene asked for, if one was."""
    from fem import load_simulation

    if settings:
        raise SceneError(
            f"{_first_of(settings)} has no effect with --from; leave one of the two out."
        )
    simulation = load_simulation(directory)
    if simulation.lower_material is not None:
        raise SceneError(
            f"{directory} holds blocks of two materials, to which the theory does not apply."
        )
    wanted = override_scene(find_scene(source) if source else simulation.scene, **overrides)
    if wanted != simulation.scene:
        raise SceneError(
            f"{directory} holds a simulation of another scene "
            f"({scene_document(simulation.scene)}); leave the scene out or simulate again."
        )
    return simulation


def _write_comparison(report: Report, directory: Path) -> None:
    from compare.figures.histories import comparison_figures
    from compare.figures.saving import save_figure

    drawn = comparison_figures(report)
    for name, draw in drawn.items():
        save_figure(draw(report), directory / name)
    forget_figures(directory, drawn)
    write_report(report, directory / "report.json")
