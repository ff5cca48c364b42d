"""``slipfront run``: run an interface of a TOML file until a time."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import typer
from rich.console import Console

from compare.comparison.rows import DIFFERS
from compare.output.places import check_file, save_somewhere
from compare.output.printed import Table
from compare.output.progress import progress_bar
from semianalytic import InterfaceFile, Run, find, solve
from semianalytic.interface.named import NAMED_INTERFACES, find_interface
from semianalytic.results.files import write_bytes
from semianalytic.scene.errors import ComputationError, SceneError
from semianalytic.scene.extras import FEM, XARRAY, require
from semianalytic.scene.units import InSI
from slipfront.cli.endings.interruption import INTERRUPTED
from slipfront.cli.options import AsJson, Quiet, measured_option
from slipfront.cli.scenes.completion import interface_names
from slipfront.cli.terminal import interface_table, print_json, verdict_text

if TYPE_CHECKING:
    from compare.interfaces.judging import InterfaceJudgement

_SHARES = 1000
"""Parts of the end time that the progress bar counts."""


def run_command(
    source: Annotated[
        str,
        typer.Argument(
            metavar="INTERFACE",
            help=f"A TOML file, or {', '.join(NAMED_INTERFACES)}.",
            autocompletion=interface_names,
        ),
    ],
    end_time: Annotated[
        float | None,
        measured_option("time", "Last time [time], a number in the units of the interface."),
    ] = None,
    nodes: Annotated[int | None, typer.Option(help="Nodes of one period, a multiple of 4.")] = None,
    rtol: Annotated[
        float | None, typer.Option(help="Error of slip and gap: nodes are doubled until it is met.")
    ] = None,
    save: Annotated[
        Path | None, typer.Option(metavar="FILE", help="File to save the run to (.npz).")
    ] = None,
    go_on: Annotated[
        Path | None, typer.Option(metavar="FILE", help="File of a saved run to continue.")
    ] = None,
    latest: Annotated[
        float | None,
        typer.Option(
            help="Time up to which --go-on may continue the run; its end time by default."
        ),
    ] = None,
    netcdf: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write all fields as NetCDF (.nc).")
    ] = None,
    no_estimate: Annotated[
        bool, typer.Option("--no-estimate", help="Skip the second run on half the nodes.")
    ] = False,
    compare: Annotated[
        bool, typer.Option("--compare", help="Simulate with finite elements too, and judge both.")
    ] = False,
    mesh_nodes: Annotated[
        int | None,
        typer.Option(help="Nodes of the finest mesh of --compare along the interface."),
    ] = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Run an interface: contacts, fields along x and friction with state, in steps of any length.

    The exit code is 4 if the run is unresolved or misses --rtol; the result is printed all the
    same.  Ctrl-C ends a run early; what was computed is printed, and saved
    with --save.  With --compare finite elements on three meshes simulate the interface as well;
    the exit code is 1 if a quantity differs by more than its error bar allows.
    """
    given = {"end_time": end_time, "nodes": nodes, "rtol": rtol, "latest": latest}
    settings: dict[str, Any] = {key: value for key, value in given.items() if value is not None}
    if no_estimate:
        settings["estimate"] = False
    run_interface(
        source,
        settings,
        save=save,
        go_on=go_on,
        netcdf=netcdf,
        compare=compare,
        mesh_nodes=mesh_nodes,
        as_json=as_json,
        quiet=quiet,
    )


def run_interface(
    source: str,
    settings: dict[str, Any],
    *,
    save: Path | None = None,
    go_on: Path | None = None,
    netcdf: Path | None = None,
    compare: bool = False,
    mesh_nodes: int | None = None,
    as_json: bool,
    quiet: bool,
) -> None:
    """Run an interface with settings of `solve`, save it, judge it if asked to, and print it.

    Raises
    ------
    ComputationError
        If the run is unresolved; it is printed before.
    """
    found = find_interface(source) if source in NAMED_INTERFACES else find(source)
    if not isinstance(found, InterfaceFile):
        raise SceneError(f"{source} is no interface: slipfront solve {source} (docs/scenes.md).")
    if isinstance(settings.get("end_time"), InSI):
        raise SceneError(
            "--end-time has a unit, but interfaces do not say which units their numbers have; "
            "give a number alone."
        )
    if netcdf is not None:
        require("slipfront run --netcdf", *XARRAY)
    if mesh_nodes is not None and not compare:
        raise SceneError("--mesh-nodes has no effect without --compare; leave it out.")
    if compare:
        require("slipfront run --compare", *FEM)
        if go_on is not None or settings.keys() & {"estimate", "rtol"}:
            raise SceneError(
                "--compare has no effect with --go-on, --no-estimate and --rtol; leave them out."
            )
    for path in (save, netcdf):
        if path is not None:
            check_file(path)
    if go_on is not None:
        settings["go_on"] = Run.load(go_on, found.interface)
    judgement: InterfaceJudgement | None = None
    notes = Console(stderr=True)
    if compare:
        from compare.interfaces.judging import compare_interface

        settings = {"end_time": found.end_time, **found.options, **settings}
        with progress_bar(notes, quiet or as_json, "simulating") as show:
            judgement = compare_interface(
                found.interface, **settings, mesh_nodes=mesh_nodes, progress=show
            )
        done = judgement.run
    else:
        with progress_bar(notes, quiet or as_json, "running") as show:

            def progress(time: float, last: float) -> None:
                show(int(_SHARES * time / last), _SHARES)

            done = solve(found, **settings, progress=progress)
    if save is not None:
        save_somewhere(done.save, save, save.name)
    if netcdf is not None:
        # In memory first, for HDF5 files are spoiled if the disk becomes full.
        content = done.to_xarray().to_netcdf(engine="h5netcdf")
        save_somewhere(lambda path: write_bytes(path, content), netcdf, netcdf.name)
    files = [path for path in (save, netcdf) if path is not None]
    if as_json:
        document = _document(done, source)
        if judgement is not None:
            document["comparison"] = _comparison(judgement)
        status = done.status if judgement is None else judgement.verdict
        print_json("run", document, status=status, files=files)
    else:
        _show(done, source)
        if judgement is not None:
            Console().print(interface_table(judgement, source))
            Console().print(verdict_text(judgement, ("nodes", "mesh_nodes")), highlight=False)
        for path in files:
            Console().print(f"Saved in {path}", highlight=False)
    if judgement is not None and judgement.verdict == DIFFERS:
        raise typer.Exit(1)
    if done.is_interrupted:
        raise typer.Exit(INTERRUPTED)
    if done.status != "done":
        raise ComputationError(f"{source} is {done.status}")


def _document(done: Run, name: str) -> dict[str, Any]:
    """Return what --json prints of a run."""
    on = np.abs(done.slip[-1][done.touching])
    steps = np.diff(done.step_times)
    return {
        "interface": name,
        "nodes": done.nodes,
        "end_time": done.end_time,
        "steps": done.steps,
        "shortest_step": float(steps.min()),
        "longest_step": float(steps.max()),
        "frames": len(done.t),
        "largest_slip": float(on.max()),
        "largest_slip_rate": float(done.peak_rates.max()),
        "slipping": float(np.mean(np.abs(done.slip_rate[-1][done.touching]) > 0)),
        "largest_gap": float(done.gap[:, done.touching].max()),
        "error_estimates": dict(done.error_estimates),
        "caution": done.caution,
        "units": {
            **dict.fromkeys(("end_time", "shortest_step", "longest_step"), "time"),
            **dict.fromkeys(("largest_slip", "largest_gap"), "length"),
            "largest_slip_rate": "length / time",
            "slipping": "1",
        },
    }


def _comparison(judgement: InterfaceJudgement) -> dict[str, Any]:
    """Return what --json prints of a comparison."""
    return {
        "verdict": judgement.verdict,
        "counts": judgement.counts,
        "meshes": [
            {name: getattr(one, name) for name in ("nodes", "steps", "unknowns", "imbalance")}
            for one in judgement.simulations
        ],
        "rows": [{**asdict(row), "verdict": row.verdict} for row in judgement.rows],
    }


def _show(done: Run, name: str) -> None:
    """Print a run as a table."""
    shown = _document(done, name)
    table = Table("quantity", "value", "unit", title=name)
    table.add_row("until", f"t = {done.end_time:.6g}", "time")
    table.add_row("nodes, frames", f"{done.nodes}, {len(done.t)}")
    table.add_row(
        "steps",
        f"{done.steps}, of {shown['shortest_step']:.3g} to {shown['longest_step']:.3g}",
        "time",
    )
    table.add_row("largest slip", f"{shown['largest_slip']:.6g}", "length")
    table.add_row("largest slip rate", f"{shown['largest_slip_rate']:.6g}", "length/time")
    table.add_row("slipping at the end", f"{100 * shown['slipping']:.3g} %", "of the contact")
    if done.interface.may_open:
        table.add_row("largest gap", f"{shown['largest_gap']:.6g}", "length")
    for quantity, error in done.error_estimates.items():
        table.add_row(f"error of {quantity.replace('_', ' ')}", f"{error:.1e}", "relative")
    table.add_row("status", done.status)
    if done.caution:
        table.add_row("caution", done.caution)
    Console().print(table)
