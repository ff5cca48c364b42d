"""``slipfront solve`` of scenes that are not self-similar: marches that can be resumed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import typer
from rich.console import Console

from compare.comparison.documents import march_document
from compare.output.places import check_file, save_somewhere
from semianalytic import Marched, Scene, solve
from semianalytic.engine.scenes.march import march
from semianalytic.results.interruption import deferred_interrupt
from semianalytic.scene.errors import ComputationError, SceneError
from semianalytic.scene.extras import HDF5, require
from slipfront.cli import terminal
from slipfront.cli.endings.interruption import INTERRUPTED
from slipfront.cli.endings.refusals import in_options
from slipfront.cli.options import MARCH_OPTIONS, in_bytes, option_name
from slipfront.cli.scenes.points import AskedPoints, show_answer

if TYPE_CHECKING:
    from compare.figures.named import Draw

_LITTLE = 0.1
"""Share of a load until the end time below which an unresolved march says so."""


def march_command(
    scene: Scene,
    label: str,
    end_time: float | None,
    options: Mapping[str, Any],
    points: AskedPoints | None = None,
    *,
    as_json: bool,
    draw: Draw | None,
    plot: Path | None,
    quiet: bool,
) -> None:
    """March a scene, or continue a saved march, and print the result.

    A march that is unresolved or misses --rtol is a ComputationError; it is printed before.
    """
    options = dict(options)
    if end_time is None and points is not None and "go_on" not in options:
        end_time = points.end_time(scene)
    save, earlier = options.pop("save", None), options.pop("go_on", None)
    if save is not None or earlier is not None:
        require("a saved march", *HDF5)
    if save is not None:
        check_file(save)
    from compare.output.progress import progress_bar

    notes = Console(stderr=True)
    bar = progress_bar(notes, quiet or as_json, "marching")
    with bar as show, deferred_interrupt() as interruption:

        def progress(done: int, steps: int) -> bool:
            show(done, steps)
            return interruption.pressed

        if earlier is None:
            every = options.get("every", 1)
            memory = in_bytes(options.pop("memory", None))
            options |= {"end_time": end_time, "memory": memory, "progress": progress}
            options["companion"] = not options.pop("no_estimate", False)
            marched = solve(scene, method="space-time", **options)
        else:
            saved = Marched.load(earlier)
            every = saved.every
            marched = _gone_on(saved, earlier, scene, end_time, options, progress)
    if save is not None:
        save_somewhere(marched.save, save, save.name)
    if interruption.pressed:
        if save is not None:
            notes.print(
                f"{save} holds the march until t = {marched.end_time:.6g}.", highlight=False
            )
        raise typer.Exit(INTERRUPTED)
    if marched.every > every and not quiet:
        notes.print(
            f"Every {marched.every}th level is stored: more would not fit into the memory.",
            highlight=False,
        )
    done = {"Saved": save, "Drawn": plot}
    table, document = terminal.march_table(marched, label), march_document(marched)
    show_answer(marched, document, [table], points, done, draw, as_json=as_json)
    check_resolved(marched, label)


def check_resolved(marched: Marched, label: str) -> None:
    """Raise ComputationError if a march is unresolved or misses --rtol; call after printing."""
    why = in_options(marched.caution, MARCH_OPTIONS)
    if marched.rtol is not None and not marched.error_estimate <= marched.rtol:
        raise ComputationError(f"{label} is not within --rtol: {why}.")
    if marched.status == "resolved":
        return
    times = np.linspace(0.0, marched.end_time, 1001)[1:]
    for name, history in marched.scene.acting_histories.items():
        share = float(np.abs(history.value(times)).max())
        if share < _LITTLE:  # as where the rise time of another solid is kept
            why += (
                f"; until t = {marched.end_time:.4g} the {name} of the load reaches only "
                f"{share:.2g} of its size: give a later --end-time, or a load that comes earlier"
            )
    raise ComputationError(f"{label} is unresolved: {why}.")


def _gone_on(
    saved: Marched,
    path: Path,
    scene: Scene,
    end_time: float | None,
    options: dict[str, Any],
    progress: Callable[[int, int], bool],
) -> Marched:
    """Continue a saved march, to the latest time it can reach unless an end time is given."""
    if saved.scene != scene:
        raise SceneError(f"{path} holds a march of another scene; give that scene.")
    memory = in_bytes(options.pop("memory", None))
    if options:
        raise SceneError(
            f"{option_name(next(iter(options)))} has no effect with --go-on; leave one of the two "
            "out."
        )
    return march(scene, end_time, go_on=saved, memory=memory, progress=progress)
