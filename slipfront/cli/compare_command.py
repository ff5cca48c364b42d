"""``slipfront compare``: both answers to a scene, side by side."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer
from rich.console import Console

from compare.comparison.comparing import compare
from compare.comparison.documents import json_text, march_document
from compare.comparison.judgement import Judgement, judge
from compare.comparison.prediction import planned, predict_like
from compare.comparison.report import (
    judged_document,
    report_document,
    write_page,
    write_report,
)
from compare.comparison.rows import DIFFERS
from compare.output.leftovers import FIELDS, PAGE, REPORT, SNAPSHOTS, forget_figures
from compare.output.places import working_folder, write_text
from compare.output.progress import progress_bar
from compare.output.tables import write_rows
from semianalytic import Marched, Scene, Solution
from semianalytic.dissimilar_slot.solution import PairSolution
from semianalytic.parameters.overriding import override_scene
from semianalytic.results.answer import method_of
from semianalytic.scene.errors import ComputationError, SceneError
from semianalytic.scene.extras import FEM, PLOT, require
from semianalytic.scene.given.documents import scene_document
from semianalytic.scene.given.finding import (
    find,
    find_scene,
    scene_folder,
    scene_label,
)
from semianalytic.scene.given.named import DEFAULT_SCENE
from slipfront.cli import options, terminal
from slipfront.cli.endings.refusals import (
    check_converged,
    refuse_given,
    specimen_settings,
    without_effect,
)
from slipfront.cli.marching import shares_of
from slipfront.cli.scenes.completion import scene_names
from slipfront.cli.simulate_command import simulate_into, with_error_bars

if TYPE_CHECKING:
    from fem import Simulation, Specimen


_OPTIONS: Mapping[str, Any] = {
    "scene_name": typer.Argument(
        metavar="[SCENE]",
        help=f"Name of a scene, or a TOML file; {DEFAULT_SCENE} unless given.",
        autocompletion=scene_names,
    ),
    "from_": options.option(
        "Folder of an earlier simulation to use instead.", flag="--from", metavar="DIR"
    ),
    "everything": options.option("Print the rows that agree, too.", flag="--all"),
    "nodes": options.option("Nodes of the period of a line, a multiple of 4."),
    "mesh_nodes": options.option("Nodes of the finest mesh along a line."),
}


@options.with_options(
    _OPTIONS,
    overrides=options.SCENE_OPTIONS,
    lower=options.LOWER_OPTIONS,
    settings=options.MESH_OPTIONS,
)
def compare_command(
    overrides: Mapping[str, Any],
    lower: Mapping[str, Any],
    settings: Mapping[str, Any],
    scene_name: str | None = None,
    from_: Path | None = None,
    method: options.Method = "auto",
    budget: options.Budget = None,
    output: options.Output = None,
    figures: options.FiguresForm = "png",
    no_snapshots: options.NoSnapshots = False,
    everything: bool = False,
    nodes: int | None = None,
    mesh_nodes: int | None = None,
    as_json: options.AsJson = False,
    quiet: options.Quiet = False,
) -> None:
    """Solve and simulate a scene; write figures and a judgement on whether the two agree.

    The lower body is that of the file's [lower_material], or equals the upper one except for the
    numbers that are given.  A scene on a line is marched and simulated on three meshes.

    The exit code is 0 if no quantity differs by more than the error bars allow, 1 if one does, and
    4 if the prediction has not converged.  Quantities that this mesh cannot resolve are listed.
    """
    along = {name: n for name, n in (("nodes", nodes), ("mesh_nodes", mesh_nodes)) if n is not None}
    shown = {"everything": everything, "as_json": as_json, "quiet": quiet}
    require("slipfront compare", *FEM, *PLOT)
    from fem.lines.plates import find_specimen

    specimen = None if scene_name is None else find_specimen(scene_name)
    if specimen is not None and scene_name is not None:
        others = {**overrides, **lower, **along, "from": from_, "budget": budget}
        given = specimen_settings(settings, others)
        _compare_line(specimen, scene_name, given, output, **shown)
        return
    refuse_given({"size": settings.get("size")}, "is for specimens; this one takes --resolution")
    if scene_name is not None and (found := find(scene_name)).on_line:
        scenes = {"from": from_, "budget": budget}
        reason = f"is for scenes with a slot; {scene_name} takes --nodes and --mesh-nodes"
        refuse_given({**scenes, **settings, "end_time": None}, reason)
        given = {name: n for name, n in settings.items() if name == "end_time"}
        given |= along
        found = override_scene(found, **overrides, **lower)
        _compare_line(found, scene_name, given, output, **shown)
        return
    refuse_given(along, "is for scenes on a line; this one takes --resolution")
    seconds, snapshots = options.in_seconds(budget), not no_snapshots
    prediction: Solution | PairSolution | Marched | None = None
    if from_ is not None:
        kept = settings if budget is None else {"budget": budget}
        simulation = _earlier_simulation(from_, scene_name, {**overrides, **lower}, kept)
        label = scene_label(scene_name) if scene_name else from_.resolve().name
        directory = output or from_
    else:
        if budget is not None and "resolution" in settings:
            raise without_effect("budget", "resolution")
        scene_name = scene_name or DEFAULT_SCENE
        label = scene_label(scene_name)
        directory = output or scene_folder(scene_name, {**overrides, **lower})
        scene = override_scene(find_scene(scene_name), **overrides, **lower)
        options.asked(scene, "end_time", settings.get("end_time"), "time")
        limited = {**settings, "memory": options.in_bytes(settings.get("memory"))}
        prediction, choice = planned(scene, method, seconds, snapshots=snapshots, **limited)
    notes = Console(stderr=True)
    with working_folder(directory) as files:
        frames = (from_ or directory) / SNAPSHOTS
        if from_ is None:
            simulation = simulate_into(
                directory,
                scene,
                label,
                {**settings, "resolution": choice.resolution, "damping": choice.damping},
                snapshots=snapshots,
                foretold=tuple(terminal.mesh_lines(choice)),
                allowed=None if seconds is None else (choice.seconds, seconds),
                quiet=quiet,
            )
        written = snapshots and frames.is_dir()
        if from_ is not None and simulation.companion is None:
            simulation = with_error_bars(
                simulation, from_, label, snapshots=written, keep=output is None, quiet=quiet
            )
        if prediction is None:
            with progress_bar(notes, quiet, "marching") as progress:
                prediction = predict_like(simulation, method, shares_of(progress))
        with progress_bar(notes, quiet, "fields") as progress:
            judgement = judge(prediction, simulation, frames if written else None, progress)
        write_comparison(judgement, label, directory, figures)
    if as_json:
        document = report_document(judgement, label)
        terminal.print_json("compare", document, judgement.verdict, files)
    else:
        title = (
            f"Compared: {label}, the {method_of(prediction)} answer with finite elements of "
            f"resolution {simulation.resolution}, until t = {simulation.end_time:g}."
        )
        headings = {"exact": "exact", "at_nodes": "at nodes", "simulated": "FEM"}
        terminal.print_judgement(judgement, title, headings, everything=everything)
        Console().print(f"All rows are in {directory / PAGE}", highlight=False)
        if written and judgement.fields is None:
            notes.print(NO_FIELDS, highlight=False)
    if method_of(prediction) != "space-time":
        check_converged(prediction, label)
    raise typer.Exit(1 if judgement.verdict == DIFFERS else 0)


NO_FIELDS = (
    "The snapshots are not compared: a march follows an incident wave or a moving load over a part "
    "of the slot only (docs/spacetime.md)."
)


def write_comparison(judgement: Judgement, label: str, directory: Path, form: str = "png") -> None:
    """Draw the figures of a judgement into a folder, in a format; write JSON, HTML, and fields as
    CSV."""
    from compare.figures.histories import comparison_figures
    from compare.figures.saving import save_figure
    from compare.figures.snapshots import snapshot_figure

    drawn, fields = comparison_figures(judgement.case), judgement.fields
    if fields is not None:
        drawn["fields"] = lambda case: snapshot_figure(fields, case.simulation)
        write_rows(directory / FIELDS, fields.rows)
    for name, draw in drawn.items():
        save_figure(draw(judgement.case), directory / f"{name}.{form}")
    kept = {f"{name}.{form}" for name in drawn}
    forget_figures(directory, kept if fields is None else {*kept, FIELDS})
    pictures = [directory / f"{name}.{form}" for name in drawn]
    write_page(judgement, label, directory / PAGE, pictures)
    write_report(judgement, label, directory / REPORT)


def _earlier_simulation(
    directory: Path,
    scene_name: str | None,
    overrides: Mapping[str, Any],
    settings: Mapping[str, Any],
) -> Simulation:
    """Load a simulation; check that it is of the scene asked for, if any was."""
    from fem.results import load_simulation

    if settings:
        raise without_effect(next(iter(settings)), "from")
    simulation = load_simulation(directory)
    scene = find_scene(scene_name) if scene_name else simulation.scene
    if override_scene(scene, **overrides) != simulation.scene:
        held = scene_document(simulation.scene)
        raise SceneError(
            f"{directory} holds a simulation of another scene ({held}); leave the scene out or "
            "simulate again."
        )
    return simulation


def _compare_line(
    problem: Scene | Specimen,
    source: str,
    settings: dict[str, Any],
    output: Path | None,
    *,
    everything: bool,
    as_json: bool,
    quiet: bool,
) -> None:
    """March and simulate a scene on a line, or a specimen, with settings of `compare`; judge both.

    All rows are written to a folder if one is given.  An unresolved run is printed, and raises a
    ComputationError.
    """
    with progress_bar(Console(stderr=True), quiet or as_json, "simulating") as show:
        judgement = compare(problem, **settings, progress=show)
    case: Any = judgement.case
    done = case.run
    meshes = [
        {name: getattr(simulation, name) for name in ("nodes", "steps", "unknowns", "imbalance")}
        for simulation in case.simulations
    ]
    comparison = {**judged_document(judgement), "until": case.until, "meshes": meshes}
    document = {**march_document(done), "status": judgement.verdict, "comparison": comparison}
    files = [] if output is None else [output / REPORT, output / PAGE]
    if output is not None:
        write_text(output / REPORT, json_text(document))
        write_page(judgement, source, output / PAGE)
    if as_json:
        terminal.print_json("compare", document, judgement.verdict, files)
    else:
        finest = case.simulations[0]
        title = (
            f"Compared: {source}, a march of {done.nodes} nodes with finite elements of "
            f"{finest.nodes} nodes along the interface, until t = {case.until:.4g}{case.later}."
        )
        headings = {"at_nodes": "run", "simulated": "FEM"}
        named = ("nodes", "mesh_nodes", "size")
        terminal.print_judgement(judgement, title, headings, named, everything=everything)
    if judgement.verdict == DIFFERS:
        raise typer.Exit(1)
    if done.status != "done":
        raise ComputationError(f"{source} is {done.status}")
