"""``slipfront solve`` of scenes that are marched, next to a slot or along a line."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import typer
from rich.console import Console

from compare.comparison.documents import march_document
from compare.output.places import save_somewhere
from semianalytic import Marched, Scene, solve
from semianalytic.results.files import write_bytes
from semianalytic.scene.errors import ComputationError
from semianalytic.scene.extras import HDF5, XARRAY, require
from slipfront.cli import terminal
from slipfront.cli.endings.faults import INTERRUPTED
from slipfront.cli.endings.refusals import in_options, without_effect
from slipfront.cli.options import MARCH_OPTIONS, in_bytes
from slipfront.cli.scenes.points import AskedPoints, show_answer

if TYPE_CHECKING:
    from compare.figures.named import Draw

_SHARES = 1000
"""Parts of a march that the progress bar counts."""
_ENDS = ("end_time", "go_on")
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
    if end_time is None and points is not None and not {*scene.run, *options} & {*_ENDS}:
        end_time = points.end_time(scene)
    save, earlier = options.pop("save", None), options.pop("go_on", None)
    netcdf = save is not None and save.suffix == ".nc"
    if save is not None or earlier is not None:
        require(*(("a NetCDF file", *XARRAY) if netcdf else ("a saved march", *HDF5)))
    from compare.output.progress import progress_bar

    notes = Console(stderr=True)
    bar = progress_bar(notes, quiet or as_json, "marching")
    with bar as show:
        saved: Any = None
        if earlier is not None:
            saved = Marched.load(earlier)
            kept = {"no_estimate"} if scene.on_line else {"memory"}
            if given := [name for name in options if name not in kept]:
                raise without_effect(given[0], "go_on")
            options["go_on"] = saved
        every = options.get("every", 1) if saved is None else saved.checkpoint.every
        if end_time is not None:
            options["end_time"] = end_time
        if "memory" in options:
            options["memory"] = in_bytes(options["memory"])
        if options.pop("no_estimate", False):
            options["estimate"] = False
        done: Any = solve(scene, method="space-time", progress=shares_of(show), **options)
    if netcdf:
        # In memory first, for HDF5 files are spoiled if the disk becomes full.
        content = done.to_xarray().to_netcdf(engine="h5netcdf")
        save_somewhere(lambda path: write_bytes(path, content), save, save.name)
    elif save is not None:
        save_somewhere(done.save, save, save.name)
    if done.is_interrupted:  # a march notes the signal itself
        if save is not None:
            notes.print(f"{save} holds the march until t = {done.end_time:.6g}.", highlight=False)
        raise typer.Exit(INTERRUPTED)
    if done.checkpoint.every > every and not done.scene.on_line and not quiet:
        notes.print(
            f"Every {done.checkpoint.every}th level is stored: more would not fit into the memory.",
            highlight=False,
        )
    document, table = march_document(done), terminal.march_table(done, label)
    files = {"Saved": save, "Drawn": plot}
    show_answer(done, document, [table], points, files, draw, as_json=as_json)
    check_marched(done, label)


def shares_of(show: Callable[[int, int], object]) -> Callable[[float, float], object]:
    """Return what shows the progress of a march."""
    return lambda time, end: show(int(_SHARES * max(time, 0.0) / end), _SHARES)


def check_marched(marched: Any, label: str) -> None:
    """Raise ComputationError if a march is unresolved or misses --rtol; call after printing."""
    if marched.scene.on_line:
        if marched.status != "done":
            raise ComputationError(f"{label} is {marched.status}")
        return
    why = in_options(marched.caution, MARCH_OPTIONS)
    if marched.checkpoint.rtol is not None and not (
        marched.error_estimate <= marched.checkpoint.rtol
    ):
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
