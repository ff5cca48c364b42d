"""``slipfront solve`` and ``slipfront compare`` of scenes on a line."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import typer
from rich.console import Console

from compare.comparison.documents import json_text
from compare.comparison.report import judged_document
from compare.comparison.rows import DIFFERS
from compare.output.files import write_text
from compare.output.leftovers import REPORT
from compare.output.places import check_file, save_somewhere
from compare.output.printed import PrintedTable
from compare.output.progress import progress_bar
from semianalytic import Run, Scene, solve
from semianalytic.results.files import write_bytes
from semianalytic.scene.errors import ComputationError
from semianalytic.scene.extras import FEM, HDF5, XARRAY, require
from slipfront.cli.endings.interruption import INTERRUPTED
from slipfront.cli.terminal import print_json, print_judgement

_SHARES = 1000
"""Parts of the end time that the progress bar counts."""


def solve_interface(
    scene: Scene,
    source: str,
    settings: dict[str, Any],
    save: Path | None = None,
    go_on: Path | None = None,
    *,
    as_json: bool,
    quiet: bool,
) -> None:
    """March a scene with settings of `solve`, save the run, and print it.

    Raises
    ------
    ComputationError
        If the run is unresolved; it is printed before.
    """
    if save is not None:
        check_file(save)
        needed = ("a NetCDF file", *XARRAY) if save.suffix == ".nc" else ("a saved run", *HDF5)
        require(*needed)
    if go_on is not None:
        settings["go_on"] = Run.load(go_on, scene)
    with progress_bar(Console(stderr=True), quiet or as_json, "marching") as show:

        def progress(time: float, last: float) -> None:
            show(int(_SHARES * time / last), _SHARES)

        done = solve(scene, **settings, progress=progress)
    if save is not None and save.suffix == ".nc":
        # In memory first, for HDF5 files are spoiled if the disk becomes full.
        content = done.to_xarray().to_netcdf(engine="h5netcdf")
        save_somewhere(lambda path: write_bytes(path, content), save, save.name)
    elif save is not None:
        save_somewhere(done.save, save, save.name)
    if as_json:
        document = _document(done, source)
        files = [] if save is None else [save]
        print_json("solve", document, status=done.status, files=files)
    else:
        Console().print(_table(done, source))
        if save is not None:
            Console().print(f"Saved in {save}", highlight=False)
    _end(done, source)


def compare_interfaces(
    scene: Scene,
    source: str,
    settings: dict[str, Any],
    mesh_nodes: int | None,
    output: Path | None,
    *,
    everything: bool,
    as_json: bool,
    quiet: bool,
) -> None:
    """March and simulate a scene with settings of `compare`, and judge both.

    All rows are written to a folder if one is given.

    Raises
    ------
    ComputationError
        If the run is unresolved; it is printed before.
    """
    require("slipfront compare", *FEM)
    from compare.comparison.comparing import compare

    with progress_bar(Console(stderr=True), quiet or as_json, "simulating") as show:
        judgement = compare(scene, **settings, mesh_nodes=mesh_nodes, progress=show)
    case: Any = judgement.case
    done = case.run
    meshes = [
        {name: getattr(one, name) for name in ("nodes", "steps", "unknowns", "imbalance")}
        for one in case.simulations
    ]
    comparison = {**judged_document(judgement), "meshes": meshes}
    document = {**_document(done, source), "comparison": comparison}
    files = [] if output is None else [output / REPORT]
    for path in files:
        write_text(path, json_text(document))
    if as_json:
        print_json("compare", document, judgement.verdict, files)
    else:
        finest = case.simulations[0]
        title = (
            f"{source}: {done.nodes} nodes against finite elements, {finest.nodes} along the "
            f"interface, {finest.steps} steps"
        )
        headings = {"at_nodes": "run", "simulated": "FEM"}
        named = ("nodes", "mesh_nodes")
        print_judgement(judgement, title, headings, named, everything=everything)
    if judgement.verdict == DIFFERS:
        raise typer.Exit(1)
    _end(done, source)


def _end(done: Run, source: str) -> None:
    if done.is_interrupted:
        raise typer.Exit(INTERRUPTED)
    if done.status != "done":
        raise ComputationError(f"{source} is {done.status}")


def _document(done: Run, name: str) -> dict[str, Any]:
    """Return what --json prints of a run."""
    on = np.abs(done.interface.slip[-1][done.interface.touching])
    steps = np.diff(done.step_times)
    return {
        "interface": name,
        "nodes": done.nodes,
        "end_time": done.end_time,
        "steps": done.steps,
        "shortest_step": float(steps.min()),
        "longest_step": float(steps.max()),
        "frames": len(done.interface.t),
        "largest_slip": float(on.max()),
        "largest_slip_rate": float(done.peak_rates.max()),
        "slipping": float(
            np.mean(np.abs(done.interface.slip_rate[-1][done.interface.touching]) > 0)
        ),
        "largest_gap": float(done.interface.gap[:, done.interface.touching].max()),
        "error_estimates": dict(done.error_estimates),
        "caution": done.caution,
        "units": {
            **dict.fromkeys(("end_time", "shortest_step", "longest_step"), "time"),
            **dict.fromkeys(("largest_slip", "largest_gap"), "length"),
            "largest_slip_rate": "length / time",
            "slipping": "1",
        },
    }


def _table(done: Run, name: str) -> PrintedTable:
    """Return a run as a table."""
    shown = _document(done, name)
    table = PrintedTable("quantity", "value", "unit", title=name)
    table.add_row("until", f"t = {done.end_time:.6g}", "time")
    table.add_row("nodes, frames", f"{done.nodes}, {len(done.interface.t)}")
    table.add_row(
        "steps",
        f"{done.steps}, of {shown['shortest_step']:.3g} to {shown['longest_step']:.3g}",
        "time",
    )
    table.add_row("largest slip", f"{shown['largest_slip']:.6g}", "length")
    table.add_row("largest slip rate", f"{shown['largest_slip_rate']:.6g}", "length/time")
    table.add_row("slipping at the end", f"{100 * shown['slipping']:.3g} %", "of the contact")
    if done.scene.may_open:
        table.add_row("largest gap", f"{shown['largest_gap']:.6g}", "length")
    for quantity, error in done.error_estimates.items():
        table.add_row(f"error of {quantity.replace('_', ' ')}", f"{error:.1e}", "relative")
    table.add_row("status", done.status)
    if done.caution:
        table.add_row("caution", done.caution)
    return table
