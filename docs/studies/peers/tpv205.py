"""SCEC TPV205 in two dimensions against what PyLith computed at seven stations.

``python -m docs.studies.peers.tpv205 FOLDER`` writes docs/data/peers-tpv205.csv and rows of
docs/data/peers.csv.  FOLDER is a checkout of github.com/chunhuizhao478/farms, which holds the
stations in postprocess/tpv2052d/benchmark_data; its files are not part of this package.
"""

from __future__ import annotations

import re
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import semianalytic as sf
from compare.output.tables import write_rows
from docs.studies.peers.rows import DATA, Array, Row, off, replace_rows, rounded

COMMAND = "python -m docs.studies.peers.tpv205 FOLDER"
NODES = (480, 960, 1920, 3840)
ONSET = 0.1
"""Slip rate [m/s] whose first time is the arrival of a rupture."""
FIELDS = {"slip": "slip", "slip_rate": "slip rate", "shear_traction": "shear traction"}
MEGA = 1e6


@dataclass(frozen=True)
class Station:
    """The differences of both codes at one station, relative, in L1 over 12 s."""

    kilometres: float
    slip: float
    slip_rate: float
    shear_traction: float
    their_arrival: float
    our_arrival: float
    their_last_slip: float
    our_last_slip: float
    their_peak_rate: float
    our_peak_rate: float


def stations(folder: Path) -> dict[float, Array]:
    """Return t [s], slip [m], slip rate [m/s] and shear [MPa], (n, 4), by position [km]."""
    places = sorted((folder / "postprocess/tpv2052d/benchmark_data").glob("pylith_strike*.txt"))
    found = {}
    for path in places:
        place = re.search(r"strike(.*?)_", path.name)
        if place:
            found[float(place[1])] = np.loadtxt(path)[:, :4]
    if not found:
        raise SystemExit(f"{folder} holds no stations of TPV205-2D; give a checkout of farms.")
    return dict(sorted(found.items()))


def arrival(t: Array, rate: Array) -> float:
    """Return the first time at which the slip rate is above `ONSET`."""
    t, rate = np.append(0.0, t), np.append(0.0, rate)
    at = int(np.argmax(rate > ONSET))
    return float(np.interp(ONSET, rate[at - 1 : at + 1], t[at - 1 : at + 1]))


def changes(run: sf.Run, name: str, x: Array) -> Array:
    """Return a field at positions x from the first stored time after 0 on, tractions as changes."""
    field = getattr(run, name)
    where = np.abs(run.x[:, None] - x).argmin(axis=0)
    values = field[1:, where]
    return values - field[0, where] if name == "shear_traction" else values


def main(folder: Path) -> None:
    """Write both tables."""
    theirs = stations(folder)
    x = 1e3 * np.array(list(theirs))
    t = next(iter(theirs.values()))[:, 0]
    found = sf.find("tpv205")
    runs, seconds = {}, {}
    for nodes in NODES:
        began = time.process_time()
        runs[nodes] = sf.solve(
            found.interface, end_time=float(t[-1]), nodes=nodes, times=list(t), estimate=False
        )
        seconds[nodes] = time.process_time() - began
        print(nodes, f"{seconds[nodes]:.1f} s of the processor", flush=True)
    # PyLith writes a shear traction of 0 at t = 0; the next one is the initial one except in the
    # patch that slips at once, where ours is taken
    first = {
        name: np.array([one[1:, i] for one in theirs.values()]).T
        for i, name in enumerate(FIELDS, 1)
    }
    start = runs[NODES[-1]].shear_traction[0, np.abs(runs[NODES[-1]].x[:, None] - x).argmin(axis=0)]
    first["shear_traction"] = MEGA * first["shear_traction"] - start
    rows, before = [], None
    for nodes, run in runs.items():
        for name, quantity in FIELDS.items():
            ours = changes(run, name, x)
            rows.append(
                Row(
                    "PyLith",
                    "tpv205",
                    quantity,
                    "200 m",
                    f"{found.interface.length / nodes:g} m",
                    None,
                    rounded(off(ours, first[name])),
                    None,
                    None if before is None else rounded(off(ours, changes(before, name, x))),
                    None,
                    rounded(seconds[nodes], 2),
                    COMMAND,
                )
            )
            print(rows[-1], flush=True)
        before = run
    replace_rows(rows)
    write_rows(
        DATA / "peers-tpv205.csv", list(_stations(runs[NODES[-1]], theirs, first)), command=COMMAND
    )


def _stations(
    run: sf.Run, theirs: dict[float, Array], first: dict[str, Array]
) -> Iterator[Station]:
    """Yield what both codes say at each station."""
    t = next(iter(theirs.values()))[:, 0]
    for i, (place, record) in enumerate(theirs.items()):
        x = np.array([1e3 * place])
        parts = {name: changes(run, name, x)[:, 0] for name in FIELDS}
        slip, rate, traction = (rounded(off(parts[name], first[name][:, i])) for name in FIELDS)
        yield Station(
            place,
            slip,
            rate,
            traction,
            round(arrival(t[1:], record[1:, 2]), 3),
            round(arrival(t[1:], parts["slip_rate"]), 3),
            rounded(record[-1, 1], 4),
            rounded(parts["slip"][-1], 4),
            rounded(record[:, 2].max()),
            rounded(parts["slip_rate"].max()),
        )


if __name__ == "__main__":
    main(Path(sys.argv[1]))
